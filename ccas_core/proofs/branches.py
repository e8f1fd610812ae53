"""Rules in plain Python, run once for each branch on symbolic ships.

A condition of the function asks an oracle, which answers true the first time and false the next, until all
ways through the function have been gone.  All ways that return one thing become a plain rule.  What
leaves what can be followed (it calls `float`, an angle, a library) is not proved about, and is said so.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Final

from ..tapd.language import motion
from ..tapd.language.formula import (
    NEGATIVE,
    POSITIVE,
    ZERO,
    Formula,
    Test,
    all_of,
    any_of,
    negated,
    sign,
)
from ..tapd.language.polynomial import Polynomial, number, variable
from ..tapd.python_rules import PythonRule, RoleDecision, outcome_of
from ..tapd.rules import Outcome, Part, Rule, RulesetText
from ..tapd.vocabulary import Fact, Kind, Scope
from ..tapd.written import WrittenRuleset
from ..verdict import Verdict

MOST_BRANCHES: Final = 200
_QUANTITIES: Final = {"tcpa": motion.tcpa, "dcpa": motion.dcpa, "distance": motion.distance}
_SIGNS: Final = {
    operator.lt: (NEGATIVE,),
    operator.le: (NEGATIVE, ZERO),
    operator.gt: (POSITIVE,),
    operator.ge: (ZERO, POSITIVE),
    operator.eq: (ZERO,),
    operator.ne: (NEGATIVE, POSITIVE),
}
_WORDS: Final = {operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">="}


class Leaves(Exception):  # noqa: N818 - it is caught, and told
    """A rule does something that cannot be followed."""


@dataclass(slots=True)
class Oracle:
    """Answers conditions along one way through a function; `path` is what has been answered."""

    forced: list[bool]
    path: list[tuple[Formula, bool]] = field(default_factory=list)

    def ask(self, formula: Formula) -> bool:
        """Answer as on this way, and true where the way is new."""
        for known, answer in self.path:
            if known == formula:
                return answer
        if len(self.path) > MOST_BRANCHES:
            raise Leaves(f"more than {MOST_BRANCHES} conditions on one way")
        answer = self.forced[len(self.path)] if len(self.path) < len(self.forced) else True
        self.path.append((formula, answer))
        return answer


class Symbol:
    """What a symbolic ship has instead of a value; whatever cannot be followed raises `Leaves`."""

    __slots__ = ("_oracle",)
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, oracle: Oracle) -> None:
        self._oracle = oracle

    def _leave(self, *_: object) -> Any:
        raise Leaves(f"the value of a {type(self).__name__.lower()} is asked for, which only a real ship has")

    def __bool__(self) -> bool:
        return bool(self._leave())

    __float__ = __int__ = __index__ = __iter__ = __len__ = __str__ = __format__ = _leave
    __round__ = __abs__ = __truediv__ = __rtruediv__ = __pow__ = __mod__ = __floordiv__ = _leave


class Truth(Symbol):  # noqa: PLW1641 - nothing that stands for a value has a hash
    """A condition."""

    __slots__ = ("_formula",)

    def __init__(self, oracle: Oracle, formula: Formula) -> None:
        super().__init__(oracle)
        self._formula = formula

    def __bool__(self) -> bool:
        return self._oracle.ask(self._formula)

    def __eq__(self, other: object) -> bool:
        return bool(self) == other

    def __ne__(self, other: object) -> bool:
        return bool(self) != other

    def __and__(self, other: object) -> bool:
        return bool(self) and bool(other)

    def __or__(self, other: object) -> bool:
        return bool(self) or bool(other)

    def __invert__(self) -> bool:
        return not bool(self)


class Word(Symbol):  # noqa: PLW1641 - nothing that stands for a value has a hash
    """A fact with words for values."""

    __slots__ = ("_choices", "_fact")

    def __init__(self, oracle: Oracle, fact: str, choices: tuple[str, ...]) -> None:
        super().__init__(oracle)
        self._fact, self._choices = fact, choices

    def _is(self, word: str) -> bool:
        return word in self._choices and self._oracle.ask(Test(self._fact, word))

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Word):
            return any(self == word and other == word for word in self._choices)
        return self._is(str(other))

    def __ne__(self, other: object) -> bool:
        return not self == other


class Ordered(Symbol):
    """A symbol that is greater or less than another."""

    __slots__ = ()

    def _compared(self, other: object, relation: Callable[[Any, Any], bool]) -> bool:
        raise NotImplementedError

    def __lt__(self, other: object) -> bool:
        return self._compared(other, operator.lt)

    def __le__(self, other: object) -> bool:
        return self._compared(other, operator.le)

    def __gt__(self, other: object) -> bool:
        return self._compared(other, operator.gt)

    def __ge__(self, other: object) -> bool:
        return self._compared(other, operator.ge)


class Amount(Ordered):  # noqa: PLW1641 - nothing that stands for a value has a hash
    """A number: a polynomial in facts."""

    __slots__ = ("_value",)

    def __init__(self, oracle: Oracle, value: Polynomial) -> None:
        super().__init__(oracle)
        self._value = value

    def _with(
        self, other: object, join: Callable[[Polynomial, Polynomial], Polynomial], *, turned: bool = False
    ) -> Amount:
        there = _polynomial(other)
        return Amount(self._oracle, join(there, self._value) if turned else join(self._value, there))

    def __add__(self, other: object) -> Amount:
        return self._with(other, operator.add)

    def __radd__(self, other: object) -> Amount:
        return self._with(other, operator.add, turned=True)

    def __sub__(self, other: object) -> Amount:
        return self._with(other, operator.sub)

    def __rsub__(self, other: object) -> Amount:
        return self._with(other, operator.sub, turned=True)

    def __mul__(self, other: object) -> Amount:
        return self._with(other, operator.mul)

    def __rmul__(self, other: object) -> Amount:
        return self._with(other, operator.mul, turned=True)

    def __neg__(self) -> Amount:
        return Amount(self._oracle, -self._value)

    def _compared(self, other: object, relation: Callable[[Any, Any], bool]) -> bool:
        if isinstance(other, Moving):
            raise Leaves("a fact is compared with a quantity of motion")
        formula = sign(self._value - _polynomial(other), *_SIGNS[relation])
        return self._oracle.ask(formula)

    def __eq__(self, other: object) -> bool:
        return self._compared(other, operator.eq)

    def __ne__(self, other: object) -> bool:
        return self._compared(other, operator.ne)


class Moving(Ordered):
    """A quantity of motion, which can be compared with a number."""

    __slots__ = ("_quantity",)

    def __init__(self, oracle: Oracle, quantity: motion.Quantity) -> None:
        super().__init__(oracle)
        self._quantity = quantity

    def _compared(self, other: object, relation: Callable[[Any, Any], bool]) -> bool:
        if isinstance(other, Symbol):
            raise Leaves("two quantities of motion are compared")
        return self._oracle.ask(motion.compared(self._quantity, _WORDS[relation], _polynomial(other)))


def _polynomial(value: object) -> Polynomial:
    if isinstance(value, Amount):
        return value._value  # noqa: SLF001 - one of us
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise Leaves(f"a number is joined with a {type(value).__name__}")
    return number(Fraction(value))


class SymbolicShip:
    """Facts of one ship, by name."""

    __slots__ = ("_pair", "_side")

    def __init__(self, pair: SymbolicPair, side: str) -> None:
        self._pair, self._side = pair, side

    def __getattr__(self, name: str) -> Symbol:
        return self._pair.fact(self._side, name)


class SymbolicPair:
    """What a rule in Python looks at, in place of a `PairView`."""

    __slots__ = ("_oracle", "_text", "other", "own", "waterway")

    def __init__(self, text: RulesetText, oracle: Oracle) -> None:
        self._text, self._oracle = text, oracle
        self.own, self.other, self.waterway = (
            SymbolicShip(self, side) for side in ("own", "other", "waterway")
        )

    def fact(self, owner: str, name: str) -> Symbol:
        """A fact of a ship or of the waterway."""
        if name == "speed" and owner != "waterway":
            return Moving(self._oracle, motion.speed(owner))
        scope = Scope.WATERWAY if owner == "waterway" else Scope.SHIP
        found = self._text.vocabulary.find(scope, name)
        if found is None:
            raise AttributeError(f"there is no fact {owner}.{name}")
        return self._symbol(found, f"{owner}.{name}")

    def __getattr__(self, name: str) -> Symbol:
        if name in _QUANTITIES:
            return Moving(self._oracle, _QUANTITIES[name]())
        found = self._text.vocabulary.find(Scope.PAIR, name)
        if found is None:
            raise Leaves(f"'{name}' cannot be followed")
        return self._symbol(found, name)

    def _symbol(self, fact: Fact, name: str) -> Symbol:
        if fact.kind is Kind.FLAG:
            return Truth(self._oracle, Test(name, value=True))
        if fact.kind is Kind.CHOICE:
            return Word(self._oracle, name, fact.choices)
        if fact.kind is Kind.NUMBER:
            return Amount(self._oracle, variable(name))
        raise Leaves(f"'{name}' cannot be followed")

    def bearing(self, from_: str, to: str) -> Symbol:
        """An angle is compared in floats at sea, and cannot be followed exactly."""
        raise Leaves(f"the bearing of {to} from {from_} is an angle")


@dataclass(frozen=True, slots=True)
class Branch:
    """One way through a function: what held on it, and what it returned."""

    condition: Formula
    outcome: Outcome


def branches(rule: PythonRule, text: RulesetText) -> tuple[Branch, ...]:
    """Go all ways through a function that return something.

    Raises
    ------
    Leaves
        If it does something that cannot be followed.
    """
    found: list[Branch] = []
    forced: list[bool] | None = []
    ways = 0
    while forced is not None:
        ways += 1
        if ways > MOST_BRANCHES:
            raise Leaves(f"more than {MOST_BRANCHES} ways through it")
        oracle = Oracle(forced)
        try:
            said = rule.decide(SymbolicPair(text, oracle))  # type: ignore[arg-type]
        except Leaves:
            raise
        except Exception as error:  # noqa: BLE001 - a plugin may raise anything
            raise Leaves(f"it raises {type(error).__name__}: {error}") from None
        if said is not None:
            if not isinstance(said, RoleDecision | str):
                raise Leaves(f"it returns a {type(said).__name__}")
            held = all_of(each if answer else negated(each) for each, answer in oracle.path)
            found.append(Branch(held, outcome_of(rule, said)))
        forced = _next(oracle.path)
    return tuple(found)


def _next(path: list[tuple[Formula, bool]]) -> list[bool] | None:
    """Answers of the next way: the last condition that was true is now false; None after the last way."""
    answers = [answer for _, answer in path]
    while answers and not answers[-1]:
        answers.pop()
    return [*answers[:-1], False] if answers else None


class Unfolded(WrittenRuleset):
    """A ruleset whose rules in Python have become plain rules; it still judges by the functions."""

    def __init__(self, original: WrittenRuleset, text: RulesetText) -> None:
        super().__init__(text)
        self._original = original

    def judge(self, facts: Any) -> Verdict:
        """Judge as the original does."""
        return self._original.judge(facts)

    def with_text(self, text: RulesetText) -> WrittenRuleset:
        """The same with another text."""
        return Unfolded(self._original, text)


def unfolded(ruleset: WrittenRuleset) -> tuple[WrittenRuleset, tuple[str, ...]]:
    """Replace rules in Python by plain rules, one for each outcome, under the same id.

    Gives also of which that was not possible, and why.
    """
    rules: list[Rule] = []
    left: list[str] = []
    for rule in ruleset.text.rules:
        if not rule.python:
            rules.append(rule)
            continue
        try:
            ways = branches(ruleset.python_rule(rule.python), ruleset.text)
        except Leaves as why:
            left.append(f"rule '{rule.id}' is tested, not proved: {why}")
            rules.append(rule)
            continue
        for outcome in dict.fromkeys(way.outcome for way in ways):
            way = any_of(each.condition for each in ways if each.outcome == outcome)
            parts = (*rule.parts, Part("python", way))
            plain = replace(
                rule, condition=all_of([rule.condition, way]), parts=parts, outcome=outcome, python=""
            )
            rules.append(plain)
    if len(rules) == len(ruleset.text.rules) and all(
        a is b for a, b in zip(rules, ruleset.text.rules, strict=True)
    ):
        return ruleset, tuple(left)
    return Unfolded(ruleset, replace(ruleset.text, rules=tuple(rules))), tuple(left)
