"""What the places of a ladder come to, and what would fit from the other side; no solver is needed for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, TypeAlias

from ..tapd.rules import Outcome, Rule
from ..verdict import OPPOSITE, Kind

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


NOTHING: Final[Duty] = (Kind.NONE, None, None, None)
