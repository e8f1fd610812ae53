"""Polynomials with exact coefficients in named variables: what the sign of every numeric condition is.

Variables of a pair: `rx`, `ry` (other's position less own, north and east [m]), `wx`, `wy` (other's velocity
less own [m/s]), `ovx`, `ovy`, `tvx`, `tvy` (own velocity, and that of the other), numeric facts such as
`own.length`, and parameters of the ruleset such as `parameter.T_risk`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Final, TypeAlias, TypeVar

Monomial: TypeAlias = tuple[str, ...]  # variables, sorted, each as often as its power

MIRRORED: Final = {"ovx": "tvx", "ovy": "tvy", "tvx": "ovx", "tvy": "ovy"}
RELATIVE: Final = frozenset({"rx", "ry", "wx", "wy"})  # these change their sign when ships are swapped

_N = TypeVar("_N")


@dataclass(frozen=True, slots=True)
class Polynomial:
    """A sum of monomials, in a canonical order, without zeros."""

    terms: tuple[tuple[Monomial, Fraction], ...]

    def __add__(self, other: Polynomial) -> Polynomial:
        return _sum([*self.terms, *other.terms])

    def __neg__(self) -> Polynomial:
        return Polynomial(tuple((monomial, -factor) for monomial, factor in self.terms))

    def __sub__(self, other: Polynomial) -> Polynomial:
        return self + -other

    def __mul__(self, other: Polynomial) -> Polynomial:
        return _sum(
            (tuple(sorted(one + two)), factor * by) for one, factor in self.terms for two, by in other.terms
        )

    @property
    def constant(self) -> Fraction | None:
        """Value of a polynomial without variables; None where there are some."""
        if not self.terms:
            return Fraction(0)
        (monomial, factor), *more = self.terms
        return factor if not monomial and not more else None

    @property
    def variables(self) -> frozenset[str]:
        """Names of all variables."""
        return frozenset(name for monomial, _ in self.terms for name in monomial)

    @property
    def degree(self) -> int:
        """Greatest number of variables that are multiplied with one another."""
        return max((len(monomial) for monomial, _ in self.terms), default=0)

    def evaluated(self, values: Mapping[str, _N], number: Callable[[Fraction], _N]) -> _N:
        """Value where the variables have these values, with numbers of any kind that add and multiply."""
        total = number(Fraction(0))
        for monomial, factor in self.terms:
            product = number(factor)
            for name in monomial:
                product = product * values[name]  # type: ignore[operator]
            total = total + product  # type: ignore[operator]
        return total

    def with_values(self, values: Mapping[str, Polynomial]) -> Polynomial:
        """Put polynomials in the place of some variables."""
        if not self.variables & values.keys():
            return self
        replaced = Polynomial(())
        for monomial, factor in self.terms:
            product = number(factor)
            for name in monomial:
                product = product * values.get(name, variable(name))
            replaced = replaced + product
        return replaced

    def mirrored(self) -> Polynomial:
        """The same, seen from the other ship."""
        return _sum(
            (
                tuple(sorted(map(mirrored_name, monomial))),
                -factor if sum(name in RELATIVE for name in monomial) % 2 else factor,
            )
            for monomial, factor in self.terms
        )


def mirrored_name(name: str) -> str:
    """Name of a variable or a fact, seen from the other ship.

    >>> mirrored_name("own.length"), mirrored_name("ovx"), mirrored_name("geometry")
    ('other.length', 'tvx', 'geometry')
    """
    if name.startswith("own."):
        return f"other.{name[4:]}"
    if name.startswith("other."):
        return f"own.{name[6:]}"
    return MIRRORED.get(name, name)


def number(value: Fraction | int) -> Polynomial:
    """Make a constant."""
    return Polynomial((((), Fraction(value)),)) if value else Polynomial(())


@cache
def variable(name: str) -> Polynomial:
    """Make a variable."""
    return Polynomial((((name,), Fraction(1)),))


def canonical(polynomial: Polynomial) -> tuple[Polynomial, int]:
    """Scale so that the first coefficient is 1, and say whether that turned the sign.

    Conditions that compare the same two things then share one polynomial, whichever way they are written.
    """
    if not polynomial.terms:
        return polynomial, 1
    lead = polynomial.terms[0][1]
    scaled = Polynomial(tuple((monomial, factor / lead) for monomial, factor in polynomial.terms))
    return scaled, 1 if lead > 0 else -1


def _sum(terms: Iterable[tuple[Monomial, Fraction]]) -> Polynomial:
    total: dict[Monomial, Fraction] = {}
    for monomial, factor in terms:
        total[monomial] = total.get(monomial, Fraction(0)) + factor
    return Polynomial(tuple(sorted((m, f) for m, f in total.items() if f)))
