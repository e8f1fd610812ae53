"""Events that observers are told: what happened from one frame to the next."""

from __future__ import annotations

from dataclasses import replace

from ccas_core.events import DeadlockDetected, OrderDecided, RulesetSwitched
from ccas_core.priority import Edge, EdgeKind, Opening, settle
from ccas_core.ships import ShipId
from ccas_core.sim.events import events_between, failed_rulesets
from ccas_core.sim.frame import Frame
from ccas_core.verdict import Kind, Verdict

A, B = ShipId("a"), ShipId("b")
OPENING = Opening(Edge(A, B, EdgeKind.DUTY), "lightest first")


def frame(**changes: object) -> Frame:
    usual = Frame(index=1, time=20.0, ships={}, settlements=(), openings=(), generations=(), arrived={})
    return replace(usual, **changes)  # type: ignore[arg-type]


class Under:
    """As much of a ship's frame as events are made of."""

    def __init__(self, ruleset: str) -> None:
        self.ruleset = ruleset


def test_order_is_told_in_every_period_in_which_ships_decide() -> None:
    decided = frame(generations=((A,), (B,)))

    assert events_between(None, decided) == (OrderDecided(time=20.0, generations=((A,), (B,))),)
    assert events_between(decided, decided) == events_between(None, decided)
    assert events_between(decided, frame()) == ()


def test_ring_is_told_when_it_is_first_opened() -> None:
    ring = frame(openings=(OPENING, OPENING))

    assert events_between(None, ring) == (DeadlockDetected(time=20.0, openings=(OPENING,)),)
    assert events_between(ring, ring) == ()


def test_switch_is_told_of_a_ship_that_comes_under_another_ruleset() -> None:
    before, after = frame(ships={A: Under("bpr"), B: Under("bpr")}), frame(ships={A: Under("ccnr")})

    assert events_between(before, after) == (RulesetSwitched(time=20.0, ship=A, before="bpr", after="ccnr"),)
    assert events_between(None, after) == ()
    assert events_between(before, frame(ships={A: Under("")})) == ()  # it has arrived


def test_ruleset_that_raised_is_found_with_what_it_raised() -> None:
    one, other = (
        Verdict(own=own, other=to, kind=Kind.CONFLICT, ruleset="odd", version="1", reason=reason)
        for own, to, reason in ((A, B, "the ruleset failed: KeyError: 'x'"), (B, A, "articles 1 and 2"))
    )

    found = list(failed_rulesets(frame(settlements=(settle(one, other, {A: 1.0, B: 2.0}),))))

    assert found == [("odd", "KeyError: 'x'")]
