"""From text to formula: names are looked up, types and units are checked.

A definition of the ruleset is a condition with a name, for some ships or for the pair; it is compiled anew
for the ships it is asked for.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import Final, NoReturn

from ...errors import did_you_mean
from ...quantities import ANGLE
from ..vocabulary import MOTIONS, Fact, Kind, Scope, Vocabulary
from . import motion, syntax
from .comparisons import TURNED, compared, is_word, mismatch
from .dimensions import DIMENSIONS, UNITS, Dimensions
from .formula import (
    FALSE,
    Constant,
    Formula,
    Known,
    Measure,
    Named,
    Test,
    all_of,
    any_of,
    is_too_large,
    negated,
)
from .polynomial import Polynomial, number, variable
from .syntax import Fault, Span
from .terms import SHIP_MOTIONS, Amount, Chosen, Literal, Moving, Ship, Value, kind_of, measure_of, shown

__all__ = [
    "BUILT_IN",
    "DIMENSIONS",
    "FUNCTIONS",
    "UNITS",
    "Compiler",
    "Definition",
    "Dimensions",
    "Parameter",
]

FUNCTIONS: Final = ("abs", "bearing", "from_starboard", "known")
MAX_PARTS: Final = 10_000  # of a condition, with its definitions written out
MAX_NESTING: Final = 100
MAX_DEFINITIONS_OPEN: Final = 30  # that ask for one another before they stand in the file
MAX_FACTORS: Final = 4  # quantities multiplied with one another
_MOST: Final = Fraction(10**30)
_PAIR_MOTIONS: Final = ("tcpa", "dcpa", "distance", "course_difference")
_SHIPS: Final = ("own", "other")
BUILT_IN: Final = (*FUNCTIONS, *_PAIR_MOTIONS, *SHIP_MOTIONS, *_SHIPS, "closing", "waterway", "regime")


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


class _EntangledError(Fault):
    """A fault of definitions that ask for one another: each of them has it."""


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
        formula = _Scope(self, text, ships).formula(expression)
        if is_too_large(formula, MAX_PARTS, MAX_NESTING):
            hint = "a definition that asks for others counts for all that they say"
            expected = f"at most {MAX_PARTS} parts, and {MAX_NESTING} within one another"
            raise Fault(expression.span, "the condition is too large", expected=expected, hint=hint)
        return formula

    def asked(self, name: str, ships: tuple[str, ...], span: Span) -> Formula:
        """Compile a definition for some ships."""
        self.used.add(name)
        if name in self.broken:
            return FALSE  # told where it stands
        if len(self._open) > MAX_DEFINITIONS_OPEN:
            message = f"definitions that ask for one another, more than {MAX_DEFINITIONS_OPEN} deep"
            raise _EntangledError(span, message, hint="put those that are asked for first")
        if name in self._open:
            ring = " -> ".join([*self._open[self._open.index(name) :], name])
            raise _EntangledError(span, f"'{name}' is defined by itself: {ring}")
        key = name, ships
        if key not in self._made:
            definition = self.definitions[name]
            self._open.append(name)
            try:
                names = _bound(definition.ships, ships or _SHIPS)
                self._made[key] = self.compiled(definition.expression, definition.text, names)
            except _EntangledError as fault:
                raise _EntangledError(span, fault.message, hint=fault.hint) from None
            except Fault:
                self.broken.add(name)
                return FALSE  # it is told when the definition itself is compiled
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
            yield from (f"{ship}.{name}" for name in SHIP_MOTIONS)
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
        if isinstance(value, Literal):
            self._unknown(expression.span, value.word)
        if isinstance(value, Amount | Moving | Chosen | Ship):
            hint = "compare it with something" if not isinstance(value, Ship) else "name one of its facts"
            raise Fault(
                expression.span, f"{kind_of(value)} is no condition", expected="true or false", hint=hint
            )
        return value

    def _value(self, expression: syntax.Expression) -> Value:  # noqa: PLR0911 - one for each production
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
                return Amount(-amount.value, amount.dimensions)

    # -- names -----------------------------------------------------------------------------------

    def _named(self, span: Span, name: str) -> Value:
        compiler = self._compiler
        if name in self._ships:
            return Ship(self._ships[name])
        if name in compiler.definitions:
            wanted = compiler.definitions[name].ships
            if wanted:
                call = f"{name}({', '.join(wanted)})"
                raise Fault(span, f"'{name}' is asked for ships", expected=call)
            self._needs_pair(span, name)
            return compiler.asked(name, (), span)
        if name in compiler.parameters:
            compiler.used.add(name)
            return Amount(variable(f"parameter.{name}"), compiler.parameters[name].dimensions)
        head, _, tail = name.partition(".")
        if tail:
            return self._owned(span, name, head, tail)
        if name in _PAIR_MOTIONS:
            return Moving(name, (), DIMENSIONS[MOTIONS[name][0].name])
        if name == "closing":
            return Named("closing", motion.closing())
        if fact := compiler.vocabulary.find(Scope.PAIR, name):
            return self._fact(name, fact)
        if name in FUNCTIONS:
            raise Fault(span, f"'{name}' is asked for something", expected=f"{name}(…)")
        return Literal(name)

    def _owned(self, span: Span, name: str, head: str, tail: str) -> Value:
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
        if tail in SHIP_MOTIONS:
            return Moving(tail, (ship,), DIMENSIONS[MOTIONS[tail][0].name])
        fact = compiler.vocabulary.find(Scope.SHIP, tail)
        if fact is None:
            self._unknown(span, name)
        return self._fact(f"{ship}.{tail}", fact)

    @staticmethod
    def _fact(name: str, fact: Fact) -> Value:
        if fact.kind is Kind.FLAG:
            return Test(name, value=True)
        if fact.kind is Kind.NUMBER:
            return Amount(variable(name), DIMENSIONS[fact.quantity.name])
        return Chosen(name, fact)

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

    def _call(self, call: syntax.Call) -> Value:
        if call.name in self._compiler.definitions:
            wanted = self._compiler.definitions[call.name].ships
            return self._compiler.asked(call.name, self._ship_arguments(call, len(wanted)), call.span)
        if call.name == "bearing":
            return Moving("bearing", self._two_ships(call), DIMENSIONS[ANGLE.name])
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
            if not isinstance(value, Ship):
                raise Fault(argument.span, "this is no ship", expected=" or ".join(self._ships))
            ships.append(value.name)
        return tuple(ships)

    def _two_ships(self, call: syntax.Call) -> tuple[str, str]:
        one, other = self._ship_arguments(call, 2)
        if one == other:
            raise Fault(call.span, f"'{call.name}' of a ship with itself", expected="two ships")
        return one, other

    def _abs(self, call: syntax.Call) -> Value:
        value = self._value(call.arguments[0])
        if len(call.arguments) != 1 or not (isinstance(value, Moving) and value.name == "bearing"):
            raise Fault(call.span, "'abs' takes a bearing", expected="abs(bearing(own, other))")
        return Moving("abs", value.ships, value.dimensions)

    def _known(self, call: syntax.Call) -> Formula:
        asked = call.arguments[0]
        value = self._value(asked)
        if isinstance(asked, syntax.Word) and len(call.arguments) == 1:
            if isinstance(value, Literal):
                self._unknown(asked.span, value.word)
            if isinstance(value, Test):
                return Known(value.fact)
            if isinstance(value, Chosen):
                return Known(value.name)
            if isinstance(value, Amount) and asked.name not in self._compiler.parameters:
                return Known(*value.value.variables)
        raise Fault(call.span, "'known' takes one fact", expected="known(own.wind_side)")

    # -- numbers ---------------------------------------------------------------------------------

    def _number(self, expression: syntax.Number) -> Amount:
        if expression.unit not in UNITS:
            hint = did_you_mean(expression.unit, filter(None, UNITS))
            if expression.unit == "rad":
                hint = "angles are written in degrees: 22.5 deg"
            raise Fault(expression.span, f"unknown unit '{expression.unit}'", hint=hint)
        size, dimensions = UNITS[expression.unit]
        value = number(Fraction(expression.digits) * size)
        self._in_measure(expression.span, value)
        return Amount(value, dimensions)

    @staticmethod
    def _in_measure(span: Span, polynomial: Polynomial) -> None:
        """Refuse factors that floats do not hold when they are multiplied with one another."""
        if any(not 1 / _MOST <= abs(factor) <= _MOST for _, factor in polynomial.terms):
            raise Fault(span, "a number beyond all measure", expected="at most 1e30")

    def _amount(self, expression: syntax.Expression) -> Amount:
        value = self._value(expression)
        if isinstance(value, Literal):
            self._unknown(expression.span, value.word)
        if isinstance(value, Moving):
            hint = "it can be compared, not calculated with"
            raise Fault(expression.span, f"'{shown(value)}' is a quantity of motion", hint=hint)
        if not isinstance(value, Amount):
            raise Fault(expression.span, f"{kind_of(value)} is no number", expected="a number")
        return value

    def _arithmetic(self, expression: syntax.Arithmetic) -> Amount:
        left, right = self._amount(expression.left), self._amount(expression.right)
        if expression.sign == "*":
            sums = zip(left.dimensions, right.dimensions, strict=True)
            one, two, three, four = (a + b for a, b in sums)
            product = left.value * right.value
            if product.degree > MAX_FACTORS:
                raise Fault(expression.span, f"a product of more than {MAX_FACTORS} quantities")
            self._in_measure(expression.span, product)
            return Amount(product, (one, two, three, four))
        if left.dimensions != right.dimensions:
            mismatch(expression.span, left.dimensions, right.dimensions, "added to")
        value = left.value + right.value if expression.sign == "+" else left.value - right.value
        return Amount(value, left.dimensions)

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
        one, other = self._side(left, right), self._side(right, left)
        if isinstance(one, Literal) and not isinstance(other, Chosen):
            self._unknown(left.span, one.word)
        if isinstance(other, Literal) and not isinstance(one, Chosen):
            self._unknown(right.span, other.word)
        formula = compared(span, one, relation, other, self._compiler)
        if isinstance(one, Moving) or isinstance(other, Amount):
            return self._told(span, one, relation, other, formula)
        if isinstance(other, Moving):
            return self._told(span, other, TURNED.get(relation, relation), one, formula)
        return formula

    def _side(self, expression: syntax.Expression, beside: syntax.Expression) -> Value:
        """One side of a comparison: a word may be a value of the fact on the other side."""
        if isinstance(expression, syntax.Word) and self._is_value_of(expression, beside):
            return Literal(expression.name)
        return self._value(expression)

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

    def _membership(self, expression: syntax.Membership) -> Formula:
        value = self._value(expression.value)
        if isinstance(value, Literal):
            self._unknown(expression.value.span, value.word)
        if not isinstance(value, Chosen):
            raise Fault(
                expression.value.span, f"{kind_of(value)} is not among words", expected="a fact with words"
            )
        found = any_of(
            is_word(word.span, value, self._ships.get(word.name, word.name)) for word in expression.words
        )
        return negated(found) if expression.negated else found

    def _told(self, span: Span, one: Value, relation: str, other: Value, formula: Formula) -> Formula:
        """Remember how a comparison was written, and what it measures."""
        assert isinstance(one, Amount | Moving)  # noqa: S101
        assert isinstance(other, Amount | Moving)  # noqa: S101
        measure = Measure(
            quantity=measure_of(one), relation=relation, limit=measure_of(other), dimensions=one.dimensions
        )
        return Named(self._written(span), formula, measure)

    def _written(self, span: Span) -> str:
        """Text of a comparison, with the ships that the names of a definition stand for here."""
        text = self._text[span.begin : span.end]
        for name, ship in self._ships.items():
            if name != ship:
                text = _renamed(text, name, f"\0{ship}")
        return text.replace("\0", "")


def _renamed(text: str, name: str, ship: str) -> str:
    return re.sub(rf"(?<![\w.\0]){name}(?=[.,)])", ship, text)
