"""Two values compared: which formula says it, and which comparisons have no meaning."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Final, NoReturn, Protocol

from ..vocabulary import Kind
from . import motion
from .dimensions import UNITS, Dimensions, measured
from .formula import NEGATIVE, POSITIVE, ZERO, Before, Formula, Same, Test, all_of, any_of, negated, sign
from .polynomial import Polynomial, number, variable
from .syntax import Fault, Span
from .terms import Amount, Chosen, Literal, Moving, Ship, Value, choices_of, kind_of, shown

_LENGTHS: Final = {"tcpa": motion.tcpa, "dcpa": motion.dcpa, "distance": motion.distance}
_SIGNS: Final[Mapping[str, frozenset[int]]] = {
    "<": frozenset({NEGATIVE}),
    "<=": frozenset({NEGATIVE, ZERO}),
    ">": frozenset({POSITIVE}),
    ">=": frozenset({ZERO, POSITIVE}),
    "==": frozenset({ZERO}),
    "!=": frozenset({NEGATIVE, POSITIVE}),
}
TURNED: Final = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}


class Limits(Protocol):
    """What is known of limits that depend on parameters."""

    tangents: dict[str, Polynomial]

    def value_of(self, polynomial: Polynomial) -> Fraction | None:
        """Value where all parameters have theirs; None if it depends on facts."""


def compared(span: Span, one: Value, relation: str, other: Value, limits: Limits) -> Formula:
    """Say that one value stands in a relation to another.

    Raises
    ------
    Fault
        If that has no meaning.
    """
    if isinstance(one, Chosen):
        return _chosen(span, one, relation, other)
    if isinstance(other, Chosen):
        return _chosen(span, other, relation, one)
    if isinstance(one, Moving):
        return _moving(span, one, relation, other, limits)
    if isinstance(other, Moving):
        return _moving(span, other, TURNED.get(relation, relation), one, limits)
    if isinstance(one, Amount) and isinstance(other, Amount):
        if one.dimensions != other.dimensions:
            mismatch(span, one.dimensions, other.dimensions, "compared with")
        return sign(one.value - other.value, *_SIGNS[relation])
    if isinstance(one, Amount | Ship | Literal) or isinstance(other, Amount | Ship | Literal):
        raise Fault(span, f"{kind_of(one)} is compared with {kind_of(other)}")
    if relation not in ("==", "!="):
        raise Fault(span, "conditions are not ordered", expected="== or !=")
    equal = any_of([all_of([one, other]), all_of([negated(one), negated(other)])])
    return equal if relation == "==" else negated(equal)


def mismatch(span: Span, one: Dimensions, other: Dimensions, verb: str) -> NoReturn:
    """Refuse two numbers that do not measure the same."""
    hint = ""
    if (0, 0, 0, 0) in (one, other):
        unit = next((u for u, (_, dims) in UNITS.items() if dims in (one, other) and u), "")
        hint = f"a number needs its unit, such as '{unit}'" if unit else ""
    raise Fault(span, f"{measured(one)} is {verb} {measured(other)}", hint=hint)


# --- words ----------------------------------------------------------------------------------------


def is_word(span: Span, chosen: Chosen, word: str) -> Formula:
    """Say that a fact has a word for its value."""
    if chosen.fact.kind is Kind.FLAGS:
        raise Fault(span, f"'{chosen.name}' has flags", expected=f"{chosen.fact.name}.{word}")
    if chosen.fact.kind is Kind.CHOICE and word not in chosen.fact.choices:
        expected = choices_of(chosen.fact)
        raise Fault(span, f"'{chosen.name}' is never '{word}'", expected=expected, hint=_near(word, chosen))
    return Test(chosen.name, word)


def _near(word: str, chosen: Chosen) -> str:
    from ...errors import did_you_mean

    hint = did_you_mean(word, chosen.fact.choices)
    return hint if hint.startswith("did") else ""  # else they are listed already


def _chosen(span: Span, one: Chosen, relation: str, other: Value) -> Formula:
    if relation not in ("==", "!="):
        raise Fault(span, "words are not ordered", expected="== or !=")
    if isinstance(other, Ship) and other.name in one.fact.choices:
        other = Literal(other.name)
    if isinstance(other, Chosen):
        if one.fact.choices != other.fact.choices or one.fact.kind is not other.fact.kind:
            raise Fault(span, f"'{one.name}' and '{other.name}' have different values")
        if one.fact.kind is Kind.FLAGS:
            raise Fault(span, f"'{one.name}' has flags", expected=f"{one.fact.name}.WORD")
        formula: Formula = Same(one.name, other.name)
    elif isinstance(other, Literal):
        formula = is_word(span, one, other.word)
    else:
        raise Fault(span, f"'{one.name}' is compared with {kind_of(other)}", expected=choices_of(one.fact))
    return formula if relation == "==" else negated(formula)


# --- quantities of motion -------------------------------------------------------------------------


def _moving(span: Span, one: Moving, relation: str, other: Value, limits: Limits) -> Formula:
    if not isinstance(other, Moving | Amount):
        raise Fault(span, f"'{shown(one)}' is compared with {kind_of(other)}")
    if other.dimensions != one.dimensions:
        mismatch(span, one.dimensions, other.dimensions, "compared with")
    if relation in ("==", "!="):
        raise Fault(span, f"'{shown(one)}' is hardly ever equal", expected="<, <=, > or >=")
    if isinstance(other, Moving):
        return _two_motions(span, one, relation, other)
    if one.name == "time_to_intersection":
        if limits.value_of(other.value) is None:
            raise Fault(span, "a time to the intersection is compared with a fact", expected="a limit")
        return _before(f"{one.ships[0]}.{one.name}", relation, other.value)
    if one.name in _LENGTHS:
        return motion.compared(_LENGTHS[one.name](), relation, other.value)
    if one.name == "speed":
        return motion.compared(motion.speed(one.ships[0]), relation, other.value)
    return motion.compared(_angle(span, one, limits), relation, other.value)


def _two_motions(span: Span, one: Moving, relation: str, other: Moving) -> Formula:
    if one.name == other.name == "speed":
        velocities = [motion.VELOCITY[each.ships[0]] for each in (one, other)]
        squares = [motion.dot(each, each) for each in velocities]
        return sign(squares[0] - squares[1], *_SIGNS[relation])
    if one.name == other.name == "time_to_intersection":
        return _before(f"{one.ships[0]}.{one.name}", relation, f"{other.ships[0]}.{other.name}")
    raise Fault(span, f"'{shown(one)}' is compared with '{shown(other)}'", expected="a limit")


def _before(one: str, relation: str, other: str | Polynomial) -> Formula:
    if relation in ("<", "<="):
        return Before(one, other, strict=relation == "<")
    return negated(Before(one, other, strict=relation == ">="))


def _angle(span: Span, one: Moving, limits: Limits) -> motion.Quantity:
    if one.name == "course_difference":
        a, b = motion.VELOCITY["own"], motion.VELOCITY["other"]
    else:
        a, b = motion.VELOCITY[one.ships[0]], motion.line_of_sight(one.ships[0])
    beyond = motion.turned_beyond if one.name == "bearing" else motion.angle_beyond

    def exceeds(*, strict: bool) -> Callable[[Polynomial], Formula]:
        return lambda limit: beyond(a, b, _angle_limit(span, limit, limits), strict=strict)

    return motion.Quantity(above=exceeds(strict=True), at_least=exceeds(strict=False))


def _angle_limit(span: Span, limit: Polynomial, limits: Limits) -> motion.AngleLimit:
    degrees = limits.value_of(limit)
    if degrees is None:
        raise Fault(span, "an angle is compared with a fact", expected="a limit in degrees")
    acute = abs(degrees) if abs(degrees) < 90 else 180 - abs(degrees)
    if limit.constant is not None or acute in (0, 90):
        return motion.AngleLimit(degrees, number(motion.tangent(acute) if 0 < acute < 90 else 0))
    part = limit if degrees > 0 else -limit
    part = part if abs(degrees) < 90 else number(180) - part
    name = f"tangent({_written(part)})"
    limits.tangents[name] = part
    return motion.AngleLimit(degrees, variable(name))


def _written(polynomial: Polynomial) -> str:
    return " + ".join("*".join([str(factor), *monomial]) for monomial, factor in polynomial.terms)
