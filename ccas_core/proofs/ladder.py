"""The ladder of a ruleset as terms: which place of it decides, from the view of one of two ships.

A view goes down the rules; each may apply as written (`own` has the part of the rule's own ship) or
swapped.  A place is one of these two uses of one rule.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import z3

from ..tapd.rules import Mirror, Outcome, Policy, Rule
from ..verdict import OPPOSITE, Kind
from .symbols import Term, View

Duty: TypeAlias = tuple[Any, ...]  # what a verdict makes the ships do; equal where nothing differs for them


@dataclass(frozen=True, slots=True)
class Place:
    """A rule as it is written, or swapped."""

    index: int
    rule: Rule
    swapped: bool

    @property
    def kind(self) -> Kind:
        """Kind of own ship's verdict."""
        kind = self.rule.outcome.kind
        return OPPOSITE.get(kind, kind) if self.swapped else kind


def duty(outcome: Outcome, *, swapped: bool) -> Duty:
    """What a verdict of own ship's view amounts to: kind, who begins, side and who chooses it.

    >>> duty(Outcome(kind=Kind.GIVE_WAY), swapped=True)[0]
    <Kind.STAND_ON: 'stand_on'>
    """
    kind = OPPOSITE.get(outcome.kind, outcome.kind) if swapped else outcome.kind
    begins = swapped if outcome.kind in (Kind.COOPERATE, Kind.PROHIBITED) else None
    chooses = outcome.side_chosen_by
    chosen = None if chooses is None else (chooses == "own") is not swapped
    return kind, begins, outcome.passing_side, chosen


def turned(one: Duty) -> Duty:
    """The duty that the other ship's view must have to fit."""
    kind, begins, side, chosen = one
    return (
        OPPOSITE.get(kind, kind),
        None if begins is None else not begins,
        side,
        None if chosen is None else not chosen,
    )


NOTHING: Duty = (Kind.NONE, None, None, None)


@dataclass(eq=False)
class Ladder:
    """The ladder as one ship sees it.  Rules in Python cannot be put into terms: `opaque` names them."""

    view: View

    @cached_property
    def places(self) -> tuple[Place, ...]:
        """All places, in the order in which they are tried."""
        both = (False, True) if self.view.text.mirror is Mirror.AUTO else (False,)
        return tuple(
            Place(index, rule, swapped) for index, rule in enumerate(self.view.text.rules) for swapped in both
        )

    @cached_property
    def opaque(self) -> tuple[str, ...]:
        """Rules that a function decides."""
        return tuple(rule.id for rule in self.view.text.rules if rule.python)

    def applies(self, place: Place) -> Term:
        """That the condition of a place holds, whatever stands before it."""
        view = self.view.swapped if place.swapped else self.view
        return view.term(place.rule.condition)

    @cached_property
    def _before(self) -> tuple[Term, ...]:
        """That no place before each of them applies; one more for the end of the ladder."""
        free = [z3.BoolVal(True)]  # noqa: FBT003
        for place in self.places:
            free.append(z3.And(free[-1], z3.Not(self.applies(place))))
        return tuple(free)

    def number(self, place: Place) -> int:
        """Where a place stands."""
        return self.places.index(place)

    def decides(self, place: Place) -> Term:
        """That a place is the first that applies."""
        return z3.And(self._before[self.number(place)], self.applies(place))

    @property
    def silent(self) -> Term:
        """That no rule applies."""
        return self._before[-1]

    def says(self, kind: Kind) -> Term:
        """That the verdict is of a kind."""
        parts = [self.decides(place) for place in self.places if place.kind is kind]
        if kind is Kind.NONE:
            parts.append(self.silent)
        return z3.Or(parts)

    def after(self, place: Place) -> Iterator[tuple[Place | None, Term]]:
        """What would decide if a rule were not there: each place behind it, or none."""
        clear: list[Term] = []
        for later in self.places[self.number(place) + 1 :]:
            if later.rule is place.rule:
                continue
            yield later, z3.And([*clear, self.applies(later)])
            clear.append(z3.Not(self.applies(later)))
        yield None, z3.And(clear)

    @property
    def unique(self) -> bool:
        """Whether at most one rule may apply."""
        return self.view.text.policy is Policy.UNIQUE


def ladders(view: View) -> tuple[Ladder, Ladder]:
    """The ladder from both sides."""
    return Ladder(view), Ladder(view.swapped)
