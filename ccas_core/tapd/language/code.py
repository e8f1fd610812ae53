"""Formulas as compiled functions on floats, exact where floats do not decide.

A numeric condition is the sign of a polynomial.  It is evaluated in floats together with a bound of its
rounding error; only inside the bound it is evaluated again, in whole numbers, so that the sign is always that
of the exact value and the same on every machine.  A fact that is not known raises `UnknownFact` when a
condition looks at it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from typing import Any, Final, NoReturn, TypeAlias

from ..vocabulary import Scope, Vocabulary
from .formula import (
    And,
    Before,
    Constant,
    Formula,
    Known,
    Named,
    Not,
    Or,
    Same,
    Sign,
    Test,
)
from .polynomial import Polynomial

# Places in the tuple of motion: relative position and velocity, both velocities, times to the intersection,
# and, for exact evaluation, the positions themselves.
MOTION: Final = ("rx", "ry", "wx", "wy", "ovx", "ovy", "tvx", "tvy", "own.time_to_intersection",
                 "other.time_to_intersection", "ox", "oy", "tx", "ty")  # fmt: skip
_EXACT_DIFFERENCES: Final = {
    "rx": ("tx", "ox"),
    "ry": ("ty", "oy"),
    "wx": ("tvx", "ovx"),
    "wy": ("tvy", "ovy"),
}
_ON_GRID: Final = frozenset(MOTION[:8])  # a product of these is zero only if one of them is
_ROUNDING: Final = 2.0**-53
_SMALLEST: Final = 1e-290  # more than all that is lost where products are too small for a float

Values: TypeAlias = Sequence[Any]
Decision: TypeAlias = Callable[[Values, Values, Values, Values, Values, list[Any]], bool]


class UnknownFact(Exception):  # noqa: N818 - it is caught, and becomes a verdict
    """A condition looked at a fact that is not known."""

    def __init__(self, missing: Missing) -> None:
        self.missing = missing
        super().__init__(missing.name)


class Missing:
    """Stands where a value is not known; whatever is done with it raises `UnknownFact`."""

    __slots__ = ("name", "owner")

    def __init__(self, owner: str, name: str) -> None:
        self.owner, self.name = owner, name

    def __repr__(self) -> str:
        return "unknown"

    def _raise(self, *_: object) -> NoReturn:
        raise UnknownFact(self)

    __eq__ = __ne__ = __lt__ = __le__ = __gt__ = __ge__ = _raise
    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __neg__ = __abs__ = _raise
    __bool__ = __float__ = __contains__ = __hash__ = _raise


@dataclass(frozen=True, slots=True)
class Program:
    """Conditions, compiled together, so that what they share is evaluated once."""

    decisions: tuple[Decision, ...]
    memory: int  # length of the list that a call needs, filled with None


def program(
    formulas: Iterable[Formula], vocabulary: Vocabulary, constants: Mapping[str, Polynomial]
) -> Program:
    """Compile conditions; `constants` are the values of parameters."""
    writer = _Writer(vocabulary, constants)
    texts = [writer.expression(formula) for formula in formulas]
    lines = [*writer.lines]
    lines += [f"def d{n}(o, t, w, p, k, m): return {text}" for n, text in enumerate(texts)]
    names: dict[str, Any] = {"exact": exact_sign, "Missing": Missing, "P": tuple(writer.polynomials)}
    exec(compile("\n".join(lines), "<conditions>", "exec"), names)  # noqa: S102 - our own text, from formulas
    return Program(tuple(names[f"d{n}"] for n in range(len(texts))), writer.memory)


def exact_sign(polynomial: Polynomial, values: Mapping[str, float]) -> int:
    """Sign of a polynomial at floats, exactly, in whole numbers.

    >>> from .polynomial import number, variable
    >>> exact_sign(variable("a") * number(3) - number(Fraction(3, 10)), {"a": 0.1})
    1
    """
    names = sorted(polynomial.variables)
    ratios = {name: _ratio(name, values) for name in names}
    shift = max((denominator.bit_length() - 1 for _, denominator in ratios.values()), default=0)
    whole = {name: top << (shift - bottom.bit_length() + 1) for name, (top, bottom) in ratios.items()}
    degree = polynomial.degree
    common = lcm(*(factor.denominator for _, factor in polynomial.terms))
    total = 0
    for monomial, factor in polynomial.terms:
        product = factor.numerator * (common // factor.denominator) << (shift * (degree - len(monomial)))
        for name in monomial:
            product *= whole[name]
        total += product
    return (total > 0) - (total < 0)


def _ratio(name: str, values: Mapping[str, float]) -> tuple[int, int]:
    """A value as a fraction whose denominator is a power of two; differences are taken exactly."""
    if name in _EXACT_DIFFERENCES:
        minuend, subtrahend = (Fraction(values[each]) for each in _EXACT_DIFFERENCES[name])
        return (minuend - subtrahend).as_integer_ratio()
    return float(values[name]).as_integer_ratio()


def rounding_bound(polynomial: Polynomial) -> float:
    """Bound of the rounding error of the sum of monomials, relative to the sum of their sizes.

    Each monomial of degree d is a product of d values, each rounded once, and a factor, rounded once: at most
    2 d + 1 roundings; adding n monomials rounds each at most n - 1 times more.
    """
    return 1.01 * (2 * polynomial.degree + 1 + len(polynomial.terms)) * _ROUNDING


class _Writer:
    """Writes formulas as Python expressions, and helper functions for what they share."""

    def __init__(self, vocabulary: Vocabulary, constants: Mapping[str, Polynomial]) -> None:
        self._vocabulary, self._constants = vocabulary, constants
        self.lines: list[str] = []
        self.polynomials: list[Polynomial] = []
        self.memory = 0
        self._signs: dict[Polynomial, str] = {}
        self._shared: dict[Formula, str] = {}

    def expression(self, formula: Formula) -> str:  # noqa: PLR0911 - one for each kind of formula
        """Write a formula."""
        match formula:
            case Constant():
                return str(formula.value)
            case Test():
                return self._test(formula)
            case Same():
                return f"({self._place(formula.one)} == {self._place(formula.other)})"
            case Known():
                return f"(type({self._place(formula.fact)}) is not Missing)"
            case Sign():
                return self._sign(formula)
            case Before():
                return self._before(formula)
            case Not():
                return f"(not {self.expression(formula.part)})"
            case And():
                return f"({' and '.join(map(self.expression, formula.parts))})"
            case Or():
                return f"({' or '.join(map(self.expression, formula.parts))})"
            case Named():
                return self._named(formula)

    def _named(self, formula: Named) -> str:
        if formula.measure is not None or isinstance(formula.part, Test | Named | Constant):
            return self.expression(formula.part)
        if formula.part not in self._shared:
            text = self.expression(formula.part)
            name, slot = f"n{len(self._shared)}", self.memory
            self.memory += 1
            self.lines += [
                f"def {name}(o, t, w, p, k, m):",
                f"    v = m[{slot}]",
                f"    if v is None: v = m[{slot}] = {text}",
                "    return v",
            ]
            self._shared[formula.part] = name
        return f"{self._shared[formula.part]}(o, t, w, p, k, m)"

    def _place(self, fact: str) -> str:
        head, _, tail = fact.partition(".")
        places = self._vocabulary.places
        if fact in MOTION:
            return f"k[{MOTION.index(fact)}]"
        if head in ("own", "other"):
            return f"{'o' if head == 'own' else 't'}[{places[Scope.SHIP][tail]}]"
        if head == "waterway":
            return f"w[{places[Scope.WATERWAY][tail]}]"
        return f"p[{places[Scope.PAIR][fact]}]"

    def _test(self, test: Test) -> str:
        place = self._place(test.fact)
        if test.value is True:
            return f"({place} == True)"
        if test.fact == "waterway.regime":
            return f"({test.value!r} in {place})"
        return f"({place} == {test.value!r})"

    def _before(self, before: Before) -> str:
        relation = "<" if before.strict else "<="
        if isinstance(before.other, str):
            return f"({self._place(before.one)} {relation} {self._place(before.other)})"
        limit = before.other.with_values(self._constants).constant
        if limit is None:
            raise ValueError(f"{before.one} is compared with a limit that depends on facts")
        return f"({self._place(before.one)} {relation} {float(limit)!r})"

    def _sign(self, formula: Sign) -> str:
        polynomial = formula.polynomial.with_values(self._constants)
        value = polynomial.constant
        if value is not None:
            return str((value > 0) - (value < 0) in formula.signs)
        if (simple := self._threshold(polynomial, formula.signs)) is not None:
            return simple
        if polynomial not in self._signs:
            self._signs[polynomial] = self._sign_function(polynomial)
        call = f"{self._signs[polynomial]}(o, t, w, p, k, m)"
        return _SIGN_TESTS[formula.signs].format(call)

    def _threshold(self, polynomial: Polynomial, signs: frozenset[int]) -> str | None:
        """A single value against a limit that is a float: one comparison, exact by itself."""
        terms = dict(polynomial.terms)
        offset = terms.pop((), Fraction(0))
        if len(terms) != 1:
            return None
        ((monomial, factor),) = terms.items()
        limit = -offset / factor
        if len(monomial) != 1 or monomial[0] in _EXACT_DIFFERENCES or Fraction(float(limit)) != limit:
            return None
        turned = frozenset(each if factor > 0 else -each for each in signs)
        return f"({self._place(monomial[0])} {_RELATIONS[turned]} {float(limit)!r})"

    def _sign_function(self, polynomial: Polynomial) -> str:
        number = len(self.polynomials)
        self.polynomials.append(polynomial)
        slot, self.memory = self.memory, self.memory + 1
        names = sorted(polynomial.variables)
        local = {name: f"x{n}" for n, name in enumerate(names)}
        terms = []
        for monomial, factor in polynomial.terms:
            factors = [] if abs(factor) == 1 and monomial else [repr(float(abs(factor)))]
            product = " * ".join([*factors, *(local[name] for name in monomial)])
            terms.append(f"-({product})" if factor < 0 else product)
        values = ", ".join(
            f"{raw!r}: {self._place(raw)}" for name in names for raw in _EXACT_DIFFERENCES.get(name, (name,))
        )
        on_grid = polynomial.variables <= _ON_GRID
        sizes = " + ".join(f"abs(a{n})" for n in range(len(terms)))
        self.lines += [
            f"def s{number}(o, t, w, p, k, m):",
            f"    v = m[{slot}]",
            "    if v is not None: return v",
            *(f"    {local[name]} = {self._place(name)}" for name in names),
            *(f"    a{n} = {term}" for n, term in enumerate(terms)),
            f"    total = {' + '.join(f'a{n}' for n in range(len(terms)))}",
            f"    bound = {rounding_bound(polynomial)!r} * ({sizes}){'' if on_grid else f' + {_SMALLEST!r}'}",
            "    if total > bound: v = 1",
            "    elif total < -bound: v = -1",
            *(["    elif bound == 0.0: v = 0"] if on_grid else []),  # no term is too small for a float
            f"    else: v = exact(P[{number}], {{{values}}})",
            f"    m[{slot}] = v",
            "    return v",
        ]
        return f"s{number}"


_SIGN_TESTS: Final = {
    frozenset({-1}): "({} < 0)",
    frozenset({0}): "({} == 0)",
    frozenset({1}): "({} > 0)",
    frozenset({-1, 0}): "({} <= 0)",
    frozenset({0, 1}): "({} >= 0)",
    frozenset({-1, 1}): "({} != 0)",
}
_RELATIONS: Final = {
    frozenset({-1}): "<",
    frozenset({0}): "==",
    frozenset({1}): ">",
    frozenset({-1, 0}): "<=",
    frozenset({0, 1}): ">=",
    frozenset({-1, 1}): "!=",
}
