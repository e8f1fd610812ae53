"""Conditions as values: tests of facts and signs of polynomials, joined by and, or, not.

A formula is written for (own, other); `mirrored` gives what it says when the ships change places.  All
three meanings are built from formulas alone.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, TypeAlias

from .polynomial import Polynomial, canonical, mirrored_name

SHIP_VALUES: Final = {"own": "other", "other": "own"}  # values of facts that name a ship of the pair
NEGATIVE, ZERO, POSITIVE = -1, 0, 1
_SHIP_WORD: Final = re.compile(r"\b(?:own|other)\b")


@dataclass(frozen=True, slots=True)
class Constant:
    """Always true, or never."""

    value: bool


@dataclass(frozen=True, slots=True)
class Test:
    """A fact has a value; a set of flags has a flag."""

    fact: str
    value: bool | str


@dataclass(frozen=True, slots=True)
class Same:
    """Two facts have one value."""

    one: str
    other: str


@dataclass(frozen=True, slots=True)
class Known:
    """A fact is known."""

    fact: str


@dataclass(frozen=True, slots=True)
class Sign:
    """A polynomial, canonical, has one of some signs."""

    polynomial: Polynomial
    signs: frozenset[int]


@dataclass(frozen=True, slots=True)
class Before:
    """Two times, one of which may be never: `own.time_to_intersection` less than `limit`, and the like."""

    one: str
    other: str | Polynomial
    strict: bool


@dataclass(frozen=True, slots=True)
class Not:
    """The opposite."""

    part: Formula


@dataclass(frozen=True, slots=True)
class And:
    """All of some formulas."""

    parts: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Or:
    """At least one of some formulas."""

    parts: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Measure:
    """What a comparison measures: a polynomial, or a quantity of motion with its ships, and its limit."""

    quantity: Measured
    relation: str
    limit: Measured
    dimensions: tuple[int, int, int, int]

    def mirrored(self) -> Measure:
        """The same with the two ships swapped."""
        return Measure(
            _mirrored_measured(self.quantity), self.relation, _mirrored_measured(self.limit), self.dimensions
        )


@dataclass(frozen=True, slots=True)
class Named:
    """A part that has a name of its own: a definition of the ruleset, or a comparison as written."""

    name: str
    part: Formula
    measure: Measure | None = None


def _mirrored_measured(measured: Measured) -> Measured:
    if isinstance(measured, Polynomial):
        return measured.mirrored()
    return (measured[0], *(SHIP_VALUES.get(ship, ship) for ship in measured[1:]))


Measured: TypeAlias = Polynomial | tuple[str, ...]
Formula: TypeAlias = Constant | Test | Same | Known | Sign | Before | Not | And | Or | Named

TRUE: Final = Constant(value=True)
FALSE: Final = Constant(value=False)


def all_of(parts: Iterable[Formula]) -> Formula:
    """Join by `and`."""
    kept = [part for part in parts if part != TRUE]
    if FALSE in kept:
        return FALSE
    return kept[0] if len(kept) == 1 else And(tuple(kept)) if kept else TRUE


def any_of(parts: Iterable[Formula]) -> Formula:
    """Join by `or`."""
    kept = [part for part in parts if part != FALSE]
    if TRUE in kept:
        return TRUE
    return kept[0] if len(kept) == 1 else Or(tuple(kept)) if kept else FALSE


def negated(part: Formula) -> Formula:
    """Join by `not`."""
    if isinstance(part, Constant):
        return Constant(not part.value)
    return part.part if isinstance(part, Not) else Not(part)


def sign(polynomial: Polynomial, *signs: int) -> Formula:
    """Say that a polynomial has one of some signs; decided at once where it has no variables."""
    value = polynomial.constant
    if value is not None:
        return Constant((value > 0) - (value < 0) in signs)
    scaled, turned = canonical(polynomial)
    return Sign(scaled, frozenset(turned * each for each in signs))


@lru_cache(maxsize=4096)
def mirrored(formula: Formula) -> Formula:
    """The same formula with the two ships swapped."""
    if isinstance(formula, Test):
        value = formula.value
        if "." not in formula.fact and isinstance(value, str):  # a fact of the pair may name a ship
            value = SHIP_VALUES.get(value, value)
        return Test(mirrored_name(formula.fact), value)
    if isinstance(formula, Same):
        return Same(mirrored_name(formula.one), mirrored_name(formula.other))
    if isinstance(formula, Known):
        return Known(mirrored_name(formula.fact))
    if isinstance(formula, Sign):
        return sign(formula.polynomial.mirrored(), *formula.signs)
    if isinstance(formula, Before):
        other = formula.other
        other = mirrored_name(other) if isinstance(other, str) else other.mirrored()
        return Before(mirrored_name(formula.one), other, formula.strict)
    if isinstance(formula, Named):
        measure = formula.measure.mirrored() if formula.measure else None
        return Named(_SHIP_WORD.sub(_swapped, formula.name), mirrored(formula.part), measure)
    return rebuilt(formula, mirrored)


def _swapped(word: re.Match[str]) -> str:
    return SHIP_VALUES[word[0]]


def alike(one: Formula, other: Formula) -> bool:
    """Whether two formulas are the same but for the order of what they join and for names."""
    return _unordered(one) == _unordered(other)


@lru_cache(maxsize=4096)
def _unordered(formula: Formula) -> object:
    if isinstance(formula, And | Or):
        return type(formula), frozenset(_unordered(part) for part in formula.parts)
    if isinstance(formula, Not):
        return Not, _unordered(formula.part)
    if isinstance(formula, Same):
        return Same, frozenset((formula.one, formula.other))
    return _unordered(formula.part) if isinstance(formula, Named) else formula


def rebuilt(formula: Formula, change: Callable[[Formula], Formula]) -> Formula:
    """Apply a change to the parts of a formula; what has no parts stays."""
    if isinstance(formula, Not):
        return negated(change(formula.part))
    if isinstance(formula, And):
        return all_of(change(part) for part in formula.parts)
    if isinstance(formula, Or):
        return any_of(change(part) for part in formula.parts)
    if isinstance(formula, Named):
        return Named(formula.name, change(formula.part), formula.measure)
    return formula


def walk(formula: Formula) -> Iterator[Formula]:
    """Yield a formula and all that it is made of."""
    yield formula
    if isinstance(formula, Not | Named):
        yield from walk(formula.part)
    elif isinstance(formula, And | Or):
        for part in formula.parts:
            yield from walk(part)


def is_too_large(formula: Formula, parts: int, nesting: int) -> bool:
    """Whether a formula has more parts than this, or deeper ones; what is shared counts each time."""
    left = [(formula, 1)]
    count = 0
    while left:
        part, depth = left.pop()
        count += 1
        if count > parts or depth > nesting:
            return True
        if isinstance(part, Not | Named):
            left.append((part.part, depth + 1))
        elif isinstance(part, And | Or):
            left += [(each, depth + 1) for each in part.parts]
    return False


def facts_of(formula: Formula) -> frozenset[str]:
    """Names of all facts and variables that a formula looks at."""
    found: set[str] = set()
    for part in walk(formula):
        if isinstance(part, Test | Known):
            found.add(part.fact)
        elif isinstance(part, Same):
            found |= {part.one, part.other}
        elif isinstance(part, Sign):
            found |= part.polynomial.variables
        elif isinstance(part, Before):
            found.add(part.one)
            found |= {part.other} if isinstance(part.other, str) else part.other.variables
    return frozenset(found)
