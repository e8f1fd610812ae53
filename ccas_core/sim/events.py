"""What happens from one frame of a voyage to the next, as events that plugins may observe."""

from __future__ import annotations

from collections.abc import Iterator

from ..events import DeadlockDetected, Event, OrderDecided, RulesetSwitched
from ..tapd.assign import FAILED
from ..verdict import Kind
from .frame import Frame


def events_between(before: Frame | None, frame: Frame) -> tuple[Event, ...]:
    """What has happened since the frame before; None: this is the first.

    The order is told in every period in which ships decide, a ring of ships in the period in which an edge of
    it is first opened, and a ruleset when a ship has come under it from another.
    """
    return (*_switched(before, frame), *_rings(before, frame), *_order(frame))


def _switched(before: Frame | None, frame: Frame) -> Iterator[Event]:
    known = before.ships if before else {}
    for id_, ship in frame.ships.items():
        was = known[id_].ruleset if id_ in known else ""
        if was and ship.ruleset and was != ship.ruleset:
            yield RulesetSwitched(time=frame.time, ship=id_, before=was, after=ship.ruleset)


def _rings(before: Frame | None, frame: Frame) -> Iterator[Event]:
    known = before.openings if before else ()
    openings = tuple(each for each in dict.fromkeys(frame.openings) if each not in known)
    if openings:
        yield DeadlockDetected(time=frame.time, openings=openings)


def _order(frame: Frame) -> Iterator[Event]:
    if frame.generations:
        yield OrderDecided(time=frame.time, generations=frame.generations)


def failed_rulesets(frame: Frame) -> Iterator[tuple[str, str]]:
    """Rulesets that raised while they judged, and what they raised."""
    for settlement in frame.settlements:
        for verdict in (settlement.one, settlement.other):
            if verdict.kind is Kind.CONFLICT and verdict.reason.startswith(FAILED):
                yield verdict.ruleset, verdict.reason.removeprefix(FAILED)
