"""From text to formula: names are looked up, types and units are checked.

A definition of the ruleset is a condition with a name, for some ships or for the pair; it is compiled anew
for the ships it is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import Final, NoReturn, TypeAlias

from ...errors import did_you_mean
from ...quantities import ANGLE, LENGTH, MASS, NUMBER, SPEED, TIME, Quantity
from ..vocabulary import MOTIONS, Fact, Kind, Scope, Vocabulary
from . import motion, syntax
from .formula import (
    FALSE,
    NEGATIVE,
    POSITIVE,
    ZERO,
    Before,
    Constant,
    Formula,
    Known,
    Measure,
    Named,
    Same,
    Test,
    all_of,
    any_of,
    negated,
    sign,
)
from .polynomial import Polynomial, number, variable
from .syntax import Fault, Span

Dimensions: TypeAlias = tuple[int, int, int, int]  # powers of m, s, kg, deg

DIMENSIONS: Final[Mapping[str, Dimensions]] = {
    NUMBER.name: (0, 0, 0, 0),
    LENGTH.name: (1, 0, 0, 0),
    TIME.name: (0, 1, 0, 0),
    SPEED.name: (1, -1, 0, 0),
    MASS.name: (0, 0, 1, 0),
    ANGLE.name: (0, 0, 0, 1),
}
_QUANTITY_OF: Final = {
    dims: quantity
    for quantity in (NUMBER, LENGTH, TIME, SPEED, MASS, ANGLE)
    for dims in [DIMENSIONS[quantity.name]]
}
UNITS: Final[Mapping[str, tuple[Fraction, Dimensions]]] = {
    "": (Fraction(1), (0, 0, 0, 0)),
    "m": (Fraction(1), (1, 0, 0, 0)),
    "km": (Fraction(1000), (1, 0, 0, 0)),
    "NM": (Fraction(1852), (1, 0, 0, 0)),
    "s": (Fraction(1), (0, 1, 0, 0)),
    "min": (Fraction(60), (0, 1, 0, 0)),
    "h": (Fraction(3600), (0, 1, 0, 0)),
    "m/s": (Fraction(1), (1, -1, 0, 0)),
    "km/h": (Fraction(1000, 3600), (1, -1, 0, 0)),
    "kn": (Fraction(1852, 3600), (1, -1, 0, 0)),
    "kg": (Fraction(1), (0, 0, 1, 0)),
    "t": (Fraction(1000), (0, 0, 1, 0)),
    "deg": (Fraction(1), (0, 0, 0, 1)),
}
FUNCTIONS: Final = ("abs", "bearing", "from_starboard", "known")
_PAIR_MOTIONS: Final = ("tcpa", "dcpa", "distance", "course_difference")
_SHIP_MOTIONS: Final = ("speed", "time_to_intersection")
_SHIPS: Final = ("own", "other")


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number of the ruleset: its value, and the range for which the ruleset is meant to hold."""

    value: Fraction
    low: Fraction
    high: Fraction
    dimensions: Dimensions
    meaning: str = ""


@dataclass(frozen=True, slots=True)
class Definition:
    """A condition with a name; `ships` are the names of the ships that it is asked for."""

    ships: tuple[str, ...]
    expression: syntax.Expression
    text: str


@dataclass(frozen=True, slots=True)
class _Amount:
    """A number: a polynomial, and what it measures."""

    value: Polynomial
    dimensions: Dimensions


@dataclass(frozen=True, slots=True)
class _Moving:
    """A quantity of motion, which can only be compared."""

    name: str
    ships: tuple[str, ...]
    dimensions: Dimensions


@dataclass(frozen=True, slots=True)
class _Chosen:
    """A fact with some words as values."""

    name: str
    fact: Fact


@dataclass(frozen=True, slots=True)
class _Ship:
    """One of the two ships."""

    name: str


@dataclass(frozen=True, slots=True)
class _Literal:
    """A word that is no name: perhaps a value of a fact."""

    word: str


_Value: TypeAlias = Formula | _Amount | _Moving | _Chosen | _Ship | _Literal


@dataclass(slots=True)
class Compiler:
    """Compiles conditions of one ruleset.

    `tangents` collects limits of angle that depend on parameters: name of the variable, and degrees.
    """

    vocabulary: Vocabulary
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    definitions: Mapping[str, Definition] = field(default_factory=dict)
    regimes: Mapping[str, str] = field(default_factory=dict)
    tangents: dict[str, Polynomial] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)  # definitions, parameters and regimes that were asked for
    broken: set[str] = field(default_factory=set)  # definitions that have been refused
    _made: dict[tuple[str, tuple[str, ...]], Formula] = field(default_factory=dict)
    _open: list[str] = field(default_factory=list)

    def condition(self, text: str) -> Formula:
        """Compile a condition on (own, other).

        Raises
        ------
        Fault
            With what is wrong, and its place in the text.
        """
        return self.compiled(syntax.parse(text), text, {"own": "own", "other": "other"})

    def definition(self, name: str) -> Formula:
        """Compile a definition by itself, for own ship and, where it is asked for two, the other."""
        definition = self.definitions[name]
        return self.compiled(definition.expression, definition.text, _bound(definition.ships, _SHIPS))

    def compiled(self, expression: syntax.Expression, text: str, ships: Mapping[str, str]) -> Formula:
        """Compile an expression in which these names mean these ships."""
        scope = _Scope(self, text, ships)
        return scope.formula(expression)

    def asked(self, name: str, ships: tuple[str, ...], span: Span) -> Formula:
        """Compile a definition for some ships."""
        self.used.add(name)
        if name in self.broken:
            return FALSE  # told where it stands
        if name in self._open:
            ring = " -> ".join([*self._open[self._open.index(name) :], name])
            raise Fault(span, f"'{name}' is defined by itself: {ring}")
        key = name, ships
        if key not in self._made:
            definition = self.definitions[name]
            self._open.append(name)
            try:
                names = _bound(definition.ships, ships or _SHIPS)
                self._made[key] = self.compiled(definition.expression, definition.text, names)
            except Fault as fault:
                if "is defined by itself" in fault.message:
                    raise Fault(span, fault.message) from None
                self.broken.add(name)
                return FALSE
            finally:
                self._open.pop()
        label = f"{name}({', '.join(ships)})" if ships else name
        return Named(label, self._made[key])

    def value_of(self, polynomial: Polynomial) -> Fraction | None:
        """Value where all parameters have theirs; None if it depends on facts."""
        values = {f"parameter.{name}": number(p.value) for name, p in self.parameters.items()}
        return polynomial.with_values(values).constant

    def names(self) -> Iterator[str]:
        """All names that a condition may use."""
        yield from self.definitions
        yield from self.parameters
        yield from FUNCTIONS
        yield from _PAIR_MOTIONS
        yield "closing"
        for fact in self.vocabulary.facts:
            if fact.scope is Scope.SHIP:
                yield from (f"{ship}.{fact.name}" for ship in _SHIPS)
            else:
                yield fact.name if fact.scope is Scope.PAIR else f"waterway.{fact.name}"
        for ship in _SHIPS:
            yield from (f"{ship}.{name}" for name in _SHIP_MOTIONS)
        yield from (f"regime.{name}" for name in self.regimes)


def _bound(names: tuple[str, ...], ships: tuple[str, ...]) -> dict[str, str]:
    return dict(zip(names, ships, strict=False)) if names else {"own": "own", "other": "other"}


class _Scope:
    """Compiles one text."""

    def __init__(self, compiler: Compiler, text: str, ships: Mapping[str, str]) -> None:
        self._compiler, self._text, self._ships = compiler, text, ships

    def formula(self, expression: syntax.Expression) -> Formula:
        """Compile what must be a condition."""
        value = self._value(expression)
        if isinstance(value, _Literal):
            self._unknown(expression.span, value.word)
        if isinstance(value, _Amount | _Moving | _Chosen | _Ship):
            hint = "compare it with something" if not isinstance(value, _Ship) else "name one of its facts"
            raise Fault(
                expression.span, f"{_kind(value)} is no condition", expected="true or false", hint=hint
            )
        return value

    def _value(self, expression: syntax.Expression) -> _Value:
        match expression:
            case syntax.Truth():
                return Constant(expression.value)
            case syntax.Number():
                return self._number(expression)
            case syntax.Word():
                return self._named(expression.span, expression.name)
            case syntax.Call():
                return self._call(expression)
            case syntax.Negation():
                return negated(self.formula(expression.part))
            case syntax.Junction():
                parts = [self.formula(part) for part in expression.parts]
                return all_of(parts) if expression.word == "and" else any_of(parts)
            case syntax.Comparison():
                return self._comparison(expression)
            case syntax.Membership():
                return self._membership(expression)
            case syntax.Arithmetic():
                return self._arithmetic(expression)
            case syntax.Minus():
                amount = self._amount(expression.part)
                return _Amount(-amount.value, amount.dimensions)

    # -- names -----------------------------------------------------------------------------------

    def _named(self, span: Span, name: str) -> _Value:
        compiler = self._compiler
        if name in self._ships:
            return _Ship(self._ships[name])
        if name in compiler.definitions:
            wanted = compiler.definitions[name].ships
            if wanted:
                call = f"{name}({', '.join(wanted)})"
                raise Fault(span, f"'{name}' is asked for ships", expected=call)
            self._needs_pair(span, name)
            return compiler.asked(name, (), span)
        if name in compiler.parameters:
            compiler.used.add(name)
            return _Amount(variable(f"parameter.{name}"), compiler.parameters[name].dimensions)
        head, _, tail = name.partition(".")
        if tail:
            return self._owned(span, name, head, tail)
        if name in _PAIR_MOTIONS:
            return _Moving(name, (), DIMENSIONS[MOTIONS[name][0].name])
        if name == "closing":
            return Named("closing", motion.closing())
        if fact := compiler.vocabulary.find(Scope.PAIR, name):
            return self._fact(name, fact)
        if name in FUNCTIONS:
            raise Fault(span, f"'{name}' is asked for something", expected=f"{name}(…)")
        return _Literal(name)

    def _owned(self, span: Span, name: str, head: str, tail: str) -> _Value:
        """What belongs to a ship or a waterway: `own.length`, `waterway.current`, `regime.tidal`."""
        compiler = self._compiler
        if head == "regime":
            if tail not in compiler.regimes:
                hint = did_you_mean(tail, compiler.regimes) + "; a regime is declared under 'regimes'"
                raise Fault(span, f"unknown regime '{tail}'", hint=hint)
            compiler.used.add(name)
            return Test("waterway.regime", tail)
        if head == "waterway":
            if fact := compiler.vocabulary.find(Scope.WATERWAY, tail):
                return self._fact(name, fact)
            self._unknown(span, name)
        if head not in self._ships:
            if head in _SHIPS:
                known = ", ".join(self._ships)
                raise Fault(span, f"'{head}' is not a ship here", hint=f"this is asked for: {known}")
            self._unknown(span, name)
        ship = self._ships[head]
        if tail in _SHIP_MOTIONS:
            return _Moving(tail, (ship,), DIMENSIONS[MOTIONS[tail][0].name])
        fact = compiler.vocabulary.find(Scope.SHIP, tail)
        if fact is None:
            self._unknown(span, name)
        return self._fact(f"{ship}.{tail}", fact)

    @staticmethod
    def _fact(name: str, fact: Fact) -> _Value:
        if fact.kind is Kind.FLAG:
            return Test(name, value=True)
        if fact.kind is Kind.NUMBER:
            return _Amount(variable(name), DIMENSIONS[fact.quantity.name])
        return _Chosen(name, fact)

    def _needs_pair(self, span: Span, name: str) -> None:
        if set(self._ships.values()) != set(_SHIPS):
            hint = "it speaks of own and other, and this is asked for one ship"
            raise Fault(span, f"'{name}' has no meaning here", hint=hint)

    def _unknown(self, span: Span, name: str) -> NoReturn:
        compiler = self._compiler
        head, _, tail = name.partition(".")
        known = list(compiler.names())
        if tail and head in self._ships and head not in _SHIPS:
            known += [f"{head}.{each[4:]}" for each in known if each.startswith("own.")]
        near = did_you_mean(name, known)
        if not near.startswith("did"):
            near = "all names are listed by `ccas facts`"
        what = "fact" if tail else "name"
        raise Fault(span, f"unknown {what} '{name}'", hint=near)

    # -- calls -----------------------------------------------------------------------------------

    def _call(self, call: syntax.Call) -> _Value:
        if call.name in self._compiler.definitions:
            wanted = self._compiler.definitions[call.name].ships
            return self._compiler.asked(call.name, self._ship_arguments(call, len(wanted)), call.span)
        if call.name == "bearing":
            return _Moving("bearing", self._two_ships(call), DIMENSIONS[ANGLE.name])
        if call.name == "from_starboard":
            one, other = self._two_ships(call)
            return Named(f"from_starboard({one}, {other})", motion.from_starboard(one, other))
        if call.name == "abs":
            return self._abs(call)
        if call.name == "known":
            return self._known(call)
        known = [*self._compiler.definitions, *FUNCTIONS]
        raise Fault(call.span, f"unknown definition '{call.name}'", hint=did_you_mean(call.name, known))

    def _ship_arguments(self, call: syntax.Call, count: int) -> tuple[str, ...]:
        if len(call.arguments) != count:
            got = f"'{call.name}' is asked for {len(call.arguments)} ship(s)"
            raise Fault(
                call.span, got, expected=f"{count}" if count else f"'{call.name}' without parentheses"
            )
        ships = []
        for argument in call.arguments:
            value = self._value(argument)
            if not isinstance(value, _Ship):
                raise Fault(argument.span, "this is no ship", expected=" or ".join(self._ships))
            ships.append(value.name)
        return tuple(ships)

    def _two_ships(self, call: syntax.Call) -> tuple[str, str]:
        one, other = self._ship_arguments(call, 2)
        if one == other:
            raise Fault(call.span, f"'{call.name}' of a ship with itself", expected="two ships")
        return one, other

    def _abs(self, call: syntax.Call) -> _Value:
        value = self._value(call.arguments[0])
        if len(call.arguments) != 1 or not (isinstance(value, _Moving) and value.name == "bearing"):
            raise Fault(call.span, "'abs' takes a bearing", expected="abs(bearing(own, other))")
        return _Moving("abs", value.ships, value.dimensions)

    def _known(self, call: syntax.Call) -> Formula:
        value = self._value(call.arguments[0])
        name = ""
        if isinstance(value, Test):
            name = value.fact
        elif isinstance(value, _Chosen):
            name = value.name
        elif isinstance(value, _Amount) and len(value.value.terms) == 1:
            name = next(iter(value.value.variables), "")
        if len(call.arguments) != 1 or not name or name.startswith("parameter."):
            raise Fault(call.span, "'known' takes one fact", expected="known(own.wind_side)")
        return Known(name)

    # -- numbers ---------------------------------------------------------------------------------

    def _number(self, expression: syntax.Number) -> _Amount:
        if expression.unit not in UNITS:
            hint = did_you_mean(expression.unit, filter(None, UNITS))
            if expression.unit == "rad":
                hint = "angles are written in degrees: 22.5 deg"
            raise Fault(expression.span, f"unknown unit '{expression.unit}'", hint=hint)
        size, dimensions = UNITS[expression.unit]
        return _Amount(number(Fraction(expression.digits) * size), dimensions)

    def _amount(self, expression: syntax.Expression) -> _Amount:
        value = self._value(expression)
        if isinstance(value, _Literal):
            self._unknown(expression.span, value.word)
        if isinstance(value, _Moving):
            hint = "it can be compared, not calculated with"
            raise Fault(expression.span, f"'{_shown(value)}' is a quantity of motion", hint=hint)
        if not isinstance(value, _Amount):
            raise Fault(expression.span, f"{_kind(value)} is no number", expected="a number")
        return value

    def _arithmetic(self, expression: syntax.Arithmetic) -> _Amount:
        left, right = self._amount(expression.left), self._amount(expression.right)
        if expression.sign == "*":
            sums = zip(left.dimensions, right.dimensions, strict=True)
            one, two, three, four = (a + b for a, b in sums)
            return _Amount(left.value * right.value, (one, two, three, four))
        if left.dimensions != right.dimensions:
            self._mismatch(expression.span, left.dimensions, right.dimensions, "added to")
        value = left.value + right.value if expression.sign == "+" else left.value - right.value
        return _Amount(value, left.dimensions)

    def _mismatch(self, span: Span, one: Dimensions, other: Dimensions, verb: str) -> NoReturn:
        hint = ""
        if (0, 0, 0, 0) in (one, other):
            unit = next((u for u, (_, dims) in UNITS.items() if dims in (one, other) and u), "")
            hint = f"a number needs its unit, such as '{unit}'" if unit else ""
        raise Fault(span, f"{_measured(one)} is {verb} {_measured(other)}", hint=hint)

    # -- comparisons -----------------------------------------------------------------------------

    def _comparison(self, expression: syntax.Comparison) -> Formula:
        parts = []
        steps = zip(pairwise(expression.values), expression.relations, strict=True)
        for (left, right), relation in steps:
            span = Span(left.span.begin, right.span.end)
            parts.append(self._related(span, left, relation, right))
        return all_of(parts)

    def _related(
        self, span: Span, left: syntax.Expression, relation: str, right: syntax.Expression
    ) -> Formula:
        one = _Literal(left.name) if self._is_value_of(left, right) else self._value(left)  # type: ignore[union-attr]
        other = _Literal(right.name) if self._is_value_of(right, left) else self._value(right)  # type: ignore[union-attr]
        if isinstance(one, _Literal) and not isinstance(other, _Chosen):
            self._unknown(left.span, one.word)
        if isinstance(other, _Literal) and not isinstance(one, _Chosen):
            self._unknown(right.span, other.word)
        if isinstance(one, _Chosen) or isinstance(other, _Chosen):
            return self._chosen(span, one, relation, other)
        if isinstance(one, _Moving) or isinstance(other, _Moving):
            return self._moving(span, one, relation, other)
        if isinstance(one, _Amount) and isinstance(other, _Amount):
            if one.dimensions != other.dimensions:
                self._mismatch(span, one.dimensions, other.dimensions, "compared with")
            formula = _SIGNS[relation](one.value - other.value)
            return self._told(span, one, relation, other, formula)
        if isinstance(one, _Amount | _Ship) or isinstance(other, _Amount | _Ship):
            raise Fault(span, f"{_kind(one)} is compared with {_kind(other)}")
        return self._equal(span, one, relation, other)

    def _is_value_of(self, word: syntax.Expression, beside: syntax.Expression) -> bool:
        """Whether a word is a value of the fact beside it; it then means that, whatever else has its name."""
        if not isinstance(word, syntax.Word) or not isinstance(beside, syntax.Word):
            return False
        if word.name in self._ships:
            return False
        head, _, tail = beside.name.partition(".")
        find = self._compiler.vocabulary.find
        if not tail:
            fact = find(Scope.PAIR, head)
        else:
            fact = find(Scope.WATERWAY if head == "waterway" else Scope.SHIP, tail)
        return fact is not None and word.name in fact.choices

    def _equal(self, span: Span, one: _Value, relation: str, other: _Value) -> Formula:
        if relation not in ("==", "!="):
            raise Fault(span, "conditions are not ordered", expected="== or !=")
        assert not isinstance(one, _Amount | _Moving | _Chosen | _Ship | _Literal)  # noqa: S101
        assert not isinstance(other, _Amount | _Moving | _Chosen | _Ship | _Literal)  # noqa: S101
        equal = any_of([all_of([one, other]), all_of([negated(one), negated(other)])])
        return equal if relation == "==" else negated(equal)

    def _chosen(self, span: Span, one: _Value, relation: str, other: _Value) -> Formula:
        if relation not in ("==", "!="):
            raise Fault(span, "words are not ordered", expected="== or !=")
        if not isinstance(one, _Chosen):
            one, other = other, one
        assert isinstance(one, _Chosen)  # noqa: S101
        if isinstance(other, _Ship) and other.name in one.fact.choices:
            other = _Literal(other.name)
        if isinstance(other, _Chosen):
            if one.fact.choices != other.fact.choices or one.fact.kind is Kind.FLAGS:
                raise Fault(span, f"'{one.name}' and '{other.name}' have different values")
            formula: Formula = Same(one.name, other.name)
        elif isinstance(other, _Literal):
            formula = self._word(span, one, other.word)
        else:
            raise Fault(span, f"'{one.name}' is compared with {_kind(other)}", expected=_choices(one.fact))
        return formula if relation == "==" else negated(formula)

    @staticmethod
    def _word(span: Span, chosen: _Chosen, word: str) -> Formula:
        if chosen.fact.kind is Kind.CHOICE and word not in chosen.fact.choices:
            hint = did_you_mean(word, chosen.fact.choices)
            raise Fault(span, f"'{chosen.name}' is never '{word}'", expected=_choices(chosen.fact), hint=hint)
        if chosen.fact.kind is Kind.FLAGS:
            raise Fault(span, f"'{chosen.name}' has flags", expected=f"{chosen.fact.name}.{word}")
        return Test(chosen.name, word)

    def _membership(self, expression: syntax.Membership) -> Formula:
        value = self._value(expression.value)
        if isinstance(value, _Literal):
            self._unknown(expression.value.span, value.word)
        if not isinstance(value, _Chosen):
            raise Fault(
                expression.value.span, f"{_kind(value)} is not among words", expected="a fact with words"
            )
        found = any_of(self._word(word.span, value, word.name) for word in expression.words)
        return negated(found) if expression.negated else found

    def _moving(self, span: Span, one: _Value, relation: str, other: _Value) -> Formula:
        if not isinstance(one, _Moving):
            turned = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}
            return self._moving(span, other, turned.get(relation, relation), one)
        dimensions = other.dimensions if isinstance(other, _Moving | _Amount) else None
        if dimensions is None:
            raise Fault(span, f"'{_shown(one)}' is compared with {_kind(other)}")
        if dimensions != one.dimensions:
            self._mismatch(span, one.dimensions, dimensions, "compared with")
        if relation in ("==", "!="):
            raise Fault(span, f"'{_shown(one)}' is hardly ever equal", expected="<, <=, > or >=")
        if isinstance(other, _Moving):
            formula = self._two_motions(span, one, relation, other)
        elif one.name == "time_to_intersection":
            formula = _before(f"{one.ships[0]}.{one.name}", relation, other.value)  # type: ignore[union-attr]
        else:
            assert isinstance(other, _Amount)  # noqa: S101
            formula = self._limited(span, one, relation, other.value)
        return self._told(span, one, relation, other, formula)

    def _two_motions(self, span: Span, one: _Moving, relation: str, other: _Moving) -> Formula:
        if one.name == other.name == "speed":
            squares = [
                motion.dot(motion.VELOCITY[each.ships[0]], motion.VELOCITY[each.ships[0]])
                for each in (one, other)
            ]
            return _SIGNS[relation](squares[0] - squares[1])
        if one.name == other.name == "time_to_intersection":
            return _before(f"{one.ships[0]}.{one.name}", relation, f"{other.ships[0]}.{other.name}")
        raise Fault(span, f"'{_shown(one)}' is compared with '{_shown(other)}'", expected="a limit")

    def _limited(self, span: Span, one: _Moving, relation: str, limit: Polynomial) -> Formula:
        if one.name in _LENGTHS:
            return motion.compared(_LENGTHS[one.name](), relation, limit)
        if one.name == "speed":
            return motion.compared(motion.speed(one.ships[0]), relation, limit)
        return motion.compared(self._angle(span, one), relation, limit)

    def _angle(self, span: Span, one: _Moving) -> motion.Quantity:
        if one.name == "course_difference":
            a, b = motion.VELOCITY["own"], motion.VELOCITY["other"]
        else:
            a, b = motion.VELOCITY[one.ships[0]], motion.line_of_sight(one.ships[0])
        beyond = motion.turned_beyond if one.name == "bearing" else motion.angle_beyond

        def exceeds(strict: bool) -> Callable[[Polynomial], Formula]:  # noqa: FBT001
            return lambda limit: beyond(a, b, self._angle_limit(span, limit), strict=strict)

        return motion.Quantity(above=exceeds(True), at_least=exceeds(False))  # noqa: FBT003

    def _angle_limit(self, span: Span, limit: Polynomial) -> motion.AngleLimit:
        degrees = self._compiler.value_of(limit)
        if degrees is None:
            raise Fault(span, "an angle is compared with a fact", expected="a limit in degrees")
        acute = abs(degrees) if abs(degrees) < 90 else 180 - abs(degrees)
        if limit.constant is not None or acute in (0, 90):
            return motion.AngleLimit(degrees, number(motion.tangent(acute) if 0 < acute < 90 else 0))
        part = limit if degrees > 0 else -limit
        part = part if abs(degrees) < 90 else number(180) - part
        name = f"tangent({_written(part)})"
        self._compiler.tangents[name] = part
        return motion.AngleLimit(degrees, variable(name))

    def _told(
        self, span: Span, one: _Amount | _Moving, relation: str, other: _Value, formula: Formula
    ) -> Formula:
        """Remember how a comparison was written, and what it measures."""
        text = self._written(span)
        measure = Measure(
            quantity=_measure_of(one), relation=relation, limit=_measure_of(other), dimensions=one.dimensions
        )
        return Named(text, formula, measure)

    def _written(self, span: Span) -> str:
        """Text of a comparison, with the ships that the names of a definition stand for here."""
        text = self._text[span.begin : span.end]
        for name, ship in self._ships.items():
            if name != ship:
                text = _renamed(text, name, f"\0{ship}")
        return text.replace("\0", "")


def _renamed(text: str, name: str, ship: str) -> str:
    import re

    return re.sub(rf"(?<![\w.\0]){name}(?=[.,)])", ship, text)


_LENGTHS: Final = {"tcpa": motion.tcpa, "dcpa": motion.dcpa, "distance": motion.distance}
_SIGNS: Final[Mapping[str, Callable[[Polynomial], Formula]]] = {
    "<": lambda difference: sign(difference, NEGATIVE),
    "<=": lambda difference: sign(difference, NEGATIVE, ZERO),
    ">": lambda difference: sign(difference, POSITIVE),
    ">=": lambda difference: sign(difference, ZERO, POSITIVE),
    "==": lambda difference: sign(difference, ZERO),
    "!=": lambda difference: sign(difference, NEGATIVE, POSITIVE),
}


def _before(one: str, relation: str, other: str | Polynomial) -> Formula:
    if relation in ("<", "<="):
        return Before(one, other, strict=relation == "<")
    return negated(Before(one, other, strict=relation == ">="))


def _kind(value: _Value) -> str:
    if isinstance(value, _Amount | _Moving):
        return _measured(value.dimensions)
    if isinstance(value, _Chosen):
        return f"'{value.name}', which has words for values,"
    if isinstance(value, _Ship):
        return "a ship"
    return f"'{value.word}'" if isinstance(value, _Literal) else "a condition"


def _measured(dimensions: Dimensions) -> str:
    quantity: Quantity | None = _QUANTITY_OF.get(dimensions)
    return quantity.name if quantity else "a product of quantities"


def _shown(value: _Moving) -> str:
    if value.name in _SHIP_MOTIONS:
        return f"{value.ships[0]}.{value.name}"
    return f"{value.name}({', '.join(value.ships)})" if value.ships else value.name


def _choices(fact: Fact) -> str:
    return f"one of {', '.join(fact.choices)}" if fact.choices else "a word"


def _written(polynomial: Polynomial) -> str:
    return " + ".join("*".join([str(factor), *monomial]) for monomial, factor in polynomial.terms)


def _measure_of(value: _Value) -> tuple[str, ...] | Polynomial:
    if isinstance(value, _Amount):
        return value.value
    assert isinstance(value, _Moving)  # noqa: S101
    return (value.name, *value.ships)
