"""Rules in plain Python, for what a condition cannot say: a function of a pair, at a place of a ladder.

The function takes a `PairView` and returns what own ship does, or None where it has nothing to say.  It is
asked from both sides; what it returns with the ships swapped is turned round for own ship.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from ..roles import PassingSide
from ..ships import UNKNOWN
from ..verdict import Kind
from .facts import PairFacts
from .language.code import Missing, UnknownFact
from .rules import Outcome, Strength


@dataclass(frozen=True, slots=True)
class RoleDecision:
    """What a rule in Python says for own ship; texts are those of ruleset files."""

    kind: str  # give_way, stand_on, mutual, none, negotiate, cooperate, prohibited, conflict or gap
    because: str = ""
    strength: str = ""
    passing_side: str = ""


Decide: TypeAlias = Callable[["PairView"], RoleDecision | str | None]


@dataclass(frozen=True, slots=True)
class PythonRule:
    """A rule of a plugin, by the name under which a ruleset file asks for it."""

    name: str
    decide: Decide
    plugin: str = ""


class ShipView:
    """Facts of one ship, by name: `ship.length` [m], `ship.propulsion`; a fact not known ends the rule."""

    __slots__ = ("_facts", "_side")

    def __init__(self, facts: PairFacts, side: str) -> None:
        self._facts, self._side = facts, side

    def __getattr__(self, name: str) -> Any:
        return _known(self._facts, f"{self._side}.{name}")


class WaterwayView:
    """Facts of the waterway, by name."""

    __slots__ = ("_facts",)

    def __init__(self, facts: PairFacts) -> None:
        self._facts = facts

    def __getattr__(self, name: str) -> Any:
        return _known(self._facts, f"waterway.{name}")


class PairView:
    """What a rule in Python may look at: `pair.own`, `pair.other`, `pair.waterway`, and facts of the pair."""

    __slots__ = ("_facts", "other", "own", "waterway")

    def __init__(self, facts: PairFacts) -> None:
        self._facts = facts
        self.own, self.other = ShipView(facts, "own"), ShipView(facts, "other")
        self.waterway = WaterwayView(facts)

    def __getattr__(self, name: str) -> Any:
        return _known(self._facts, name)

    def bearing(self, from_: str, to: str) -> float:
        """Relative bearing of one ship from the other, 'own' or 'other' [rad], starboard positive."""
        return self._facts.quantity(("bearing", from_, to))


def _known(facts: PairFacts, name: str) -> Any:
    try:
        value = facts[name]
    except KeyError:
        raise AttributeError(f"there is no fact {name!r}") from None
    if value is UNKNOWN:
        head, _, tail = name.partition(".")
        owner = {"own": facts.own, "other": facts.other, "waterway": "waterway"}.get(
            head if tail else "", "pair"
        )
        raise UnknownFact(Missing(owner, tail or name))
    return value


def ruled(rule: PythonRule, pair: PairView) -> Outcome | None:
    """Ask a rule in Python.

    Raises
    ------
    TypeError, ValueError
        If it returns something else than a decision.
    """
    decision = rule.decide(pair)
    return None if decision is None else outcome_of(rule, decision)


def outcome_of(rule: PythonRule, decision: RoleDecision | str) -> Outcome:
    """What a rule in Python has returned, as an outcome.

    Raises
    ------
    TypeError, ValueError
        If it is no decision.
    """
    if isinstance(decision, str):
        decision = RoleDecision(decision)
    if not isinstance(decision, RoleDecision):
        raise TypeError(f"rule {rule.name!r} must return a RoleDecision, got {type(decision).__name__}")
    return Outcome(
        kind=Kind(decision.kind),
        strength=Strength(decision.strength) if decision.strength else None,
        passing_side=PassingSide(decision.passing_side) if decision.passing_side else None,
        reason=decision.because,
    )
