"""One ship as a state machine, and fleets of them: who decides when, and what is done when others fail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ccas_core.agent.bus import Bus
from ccas_core.agent.events import Decision, Solved, Step
from ccas_core.agent.messages import Gossip, Intention, Message, Report, Verdicts
from ccas_core.agent.ship_agent import ShipAgent
from ccas_core.dmpc.parameters import Wait
from ccas_core.dmpc.prediction import ConstantVelocity
from ccas_core.frames import NedPose, NedTrajectory
from ccas_core.priority import Edge, EdgeKind
from ccas_core.ships import Ship, ShipId
from ccas_core.tapd.facts import PairFacts
from ccas_core.verdict import Verdict
from ccas_core.waterway import Towards
from ccas_core.world import ShipReport

from . import (
    CHAIN,
    FLEET,
    HORIZON,
    HULL,
    RING,
    A,
    B,
    C,
    D,
    Decreed,
    Nominal,
    agent,
    mass,
    period,
    sensed,
    speed,
)

TWO = Decreed([(A, B)])


class Broken(Decreed):
    """Rules that raise."""

    def judge(self, facts: PairFacts) -> Verdict:
        """Raise."""
        raise ZeroDivisionError(f"no rule for {facts.other}")


class Deaf(Bus):
    """A bus that drops what one ship says of a kind."""

    def __init__(self, kind: type[Message], sender: ShipId) -> None:
        super().__init__()
        self._dropped = kind, sender

    def post(self, now: float, message: Message) -> None:
        """Send, or drop."""
        kind, sender = self._dropped
        if not (isinstance(message, kind) and message.sender == sender):
            super().post(now, message)


def words_of_a(at: int = 0) -> tuple[Report, Verdicts, Intention]:
    """What ship A would say, made by hand: no agent A is needed."""
    reading = sensed(A, at)
    report = ShipReport(
        ship=Ship(id=A, hull=HULL, mass=mass(A)),
        pose=reading.pose,
        speed=reading.speed,
        waterway=A,
        towards=Towards.END,
        ruleset="decreed",
    )
    judged = Verdicts(A, at, (_verdict_of_a(),))
    plan = ConstantVelocity().predict(reading.pose, speed(A), HORIZON, 20.0)
    return Report(A, at, report), judged, Intention(A, at, 1, plan, decided=True)


def _verdict_of_a() -> Verdict:
    ship = agent(A, TWO)
    other = agent(B, TWO)
    for each, peer, id_ in ((ship, other, A), (other, ship, B)):
        for message in each.step(0.0, [sensed(id_)]).outbox:
            peer.step(0.0, [message])
    said = [each for each in ship.step(1.0, []).outbox if isinstance(each, Verdicts)]
    return said[0].verdicts[0]


def kinds(step: Step) -> list[type[Message]]:
    return [type(message) for message in step.outbox]


def answered(ship: ShipAgent, now: float, step: Step) -> Step:
    """Solve what a ship has asked for, and hand it back."""
    assert step.request is not None
    return ship.step(
        now, [Solved(step.request.problem, Nominal().best(step.request.problem, step.request.guesses))]
    )


# --- one ship, and messages made by hand


def test_ship_listens_settles_waits_its_turn_and_decides() -> None:
    report, judged, promise = words_of_a()
    ship = agent(B, TWO)

    begun = ship.step(0.0, [sensed(B)])
    listening = ship.step(0.0, [report])
    settling = ship.step(1.0, [])
    waiting = ship.step(1.1, [judged])
    asking = ship.step(1.2, [promise])
    done = answered(ship, 1.2, asking)

    assert (kinds(begun), begun.wake_at) == ([Report], 1.0)
    assert (kinds(listening), listening.wake_at) == ([], 1.0)
    assert (kinds(settling), settling.wake_at) == ([Verdicts], 3.0)
    assert (kinds(waiting), waiting.request) == ([Gossip], None)
    assert waiting.wake_at == pytest.approx(1.1 + 2.0)
    assert asking.request is not None
    assert kinds(done) == [Intention]
    assert isinstance(done.decision, Decision)
    assert done.outbox[0].period == 0


def test_ship_plans_around_the_promise_that_it_was_told() -> None:
    report, judged, promise = words_of_a()
    poses = promise.trajectory.poses + np.array([30.0, 0.0, 0.0])
    ship = agent(B, TWO)
    ship.step(0.0, [sensed(B), report])
    ship.step(1.0, [])
    asking = ship.step(1.1, [judged, replace(promise, trajectory=NedTrajectory(poses))])

    assert asking.request is not None
    north = -asking.request.problem.threats[0, :, 1] + 2000.0  # to starboard of B, bound east, is south
    assert north == pytest.approx(np.full(HORIZON, 30.0), abs=1e-9)


def test_predecessor_that_never_decides_does_not_keep_a_ship_beyond_its_deadline() -> None:
    report, judged, _ = words_of_a()
    ship = agent(B, TWO, detection=False)
    ship.step(0.0, [sensed(B), report])
    ship.step(1.0, [])
    waiting = ship.step(1.1, [judged])

    late = ship.step(15.0, [])

    assert waiting.wake_at == 15.0
    assert late.decision is not None
    assert late.decision.fallback == "the deadline came before the ship's turn: the ship slows down"
    assert late.decision.speed_factor == 0.0


def test_ship_goes_on_without_a_predecessor_that_stays_silent() -> None:
    report, judged, _ = words_of_a()
    ship = agent(B, TWO)
    ship.step(0.0, [sensed(B), report])
    ship.step(1.0, [])
    ship.step(1.1, [judged])

    assert ship.step(9.9, []).request is None
    assert ship.step(10.0, []).request is not None


def test_message_of_another_period_changes_nothing() -> None:
    report, judged, promise = words_of_a()
    ship = agent(B, TWO)
    ship.step(0.0, [sensed(B), report])
    ship.step(1.0, [])
    ship.step(1.1, [judged])

    assert ship.step(1.2, [replace(promise, period=7)]).request is None


def test_verdict_that_does_not_come_is_awaited_until_the_window_closes() -> None:
    report, _, _ = words_of_a()
    ship = agent(A, TWO)
    ship.step(
        0.0,
        [
            sensed(A),
            replace(report, sender=B, report=replace(report.report, ship=Ship(id=B, hull=HULL, mass=9e6))),
        ],
    )
    ship.step(1.0, [])

    assert Gossip not in kinds(ship.step(2.9, []))
    late = ship.step(3.0, [])
    assert Gossip in kinds(late)
    assert answered(ship, 3.0, late).decision is not None


def test_ship_that_has_not_sensed_anything_says_nothing() -> None:
    step = agent(B, TWO).step(0.0, list(words_of_a()))

    assert (step.outbox, step.wake_at, step.request, step.decision) == ((), None, None, None)


# --- fleets


def test_ship_that_gives_way_decides_before_the_one_that_stands_on() -> None:
    log = period({ship: agent(ship, TWO) for ship in (A, B)})

    assert log.generations == ((A,), (B,))
    assert {each.fallback for each in log.decisions.values()} == {""}


def test_chain_is_decided_link_by_link() -> None:
    rules = Decreed([(C, B), (B, A)])
    log = period({ship: agent(ship, rules) for ship in (A, B, C)})

    assert log.generations == ((C,), (B,), (A,))


def test_ships_that_both_give_way_decide_in_the_same_generation() -> None:
    rules = Decreed(mutual=[(A, B)])
    log = period({ship: agent(ship, rules) for ship in (A, B)})

    assert log.generations == ((A, B),)
    assert all(settlement.mutual for settlement in log.decisions[A].settlements)


def test_ships_without_duties_decide_at_once_together() -> None:
    log = period({ship: agent(ship, Decreed()) for ship in FLEET})

    assert log.generations == (FLEET,)
    assert all(decision.settlements == () for decision in log.decisions.values())


@pytest.mark.parametrize("lightest", [A, B, C])
def test_ring_of_three_is_opened_at_the_lightest_and_logged(lightest: ShipId) -> None:
    masses = dict.fromkeys((A, B, C), 5000000.0) | {lightest: 1e6}
    log = period({ship: agent(ship, Decreed(RING), masses=masses) for ship in (A, B, C)})

    after = {A: B, B: C, C: A}
    order = (lightest, after[lightest], after[after[lightest]])
    assert log.generations == tuple((ship,) for ship in order)
    (opening,) = log.decisions[lightest].openings
    assert opening.edge == Edge(after[after[lightest]], lightest, EdgeKind.DUTY)
    assert opening.criterion == "lightest first"
    assert [log.decisions[ship].openings for ship in order[1:]] == [(), ()]
    assert {each.fallback for each in log.decisions.values()} == {""}


def test_ring_of_four_is_opened_at_the_lightest_and_at_the_smallest_id_among_equals() -> None:
    ring = Decreed([(A, B), (B, C), (C, D), (D, A)])
    masses = {A: 5e6, B: 2e6, C: 5e6, D: 2e6}
    log = period({ship: agent(ship, ring, masses=masses) for ship in FLEET})

    assert log.generations == ((B,), (C,), (D,), (A,))
    assert [each.edge.first for each in log.decisions[B].openings] == [A]


def test_ship_that_merely_waits_for_a_ring_does_not_jump_the_queue() -> None:
    rules = Decreed([*RING, (A, D)])
    masses = {A: 5e6, B: 5e6, C: 5e6, D: 1e3}
    log = period({ship: agent(ship, rules, masses=masses) for ship in FLEET})

    assert log.decisions[D].openings == ()
    order = [ship for generation in log.generations for ship in generation]
    assert order.index(D) > order.index(A)


def test_deadlock_is_opened_after_T_DL_and_not_before() -> None:
    times: list[float] = []

    class Clock(Bus):
        def post(self, now: float, message: Message) -> None:
            if isinstance(message, Intention):
                times.append(now)
            super().post(now, message)

    period({ship: agent(ship, Decreed(RING)) for ship in (A, B, C)}, bus=Clock())

    assert min(times) >= 1.0 + 2.0  # the settling, then T_DL


def test_without_detection_a_ring_falls_back_at_the_deadline() -> None:
    log = period({ship: agent(ship, Decreed(RING), detection=False) for ship in (A, B, C)})

    assert log.generations == ((A, B, C),)
    assert all("the deadline came" in each.fallback for each in log.decisions.values())
    assert all(each.openings == () for each in log.decisions.values())


def test_missing_verdict_makes_both_give_way_in_the_view_that_misses_it() -> None:
    log = period({ship: agent(ship, TWO) for ship in (A, B)}, bus=Deaf(Verdicts, B))

    (settlement,) = log.decisions[A].settlements
    assert "a sees give_way, b sees unknown_fact" in settlement.fallback
    assert settlement.other.reason == "its verdict did not arrive"
    assert settlement.mutual


def test_ruleset_that_raises_leads_to_the_safe_mutual_rule_and_is_logged() -> None:
    log = period({ship: agent(ship, Broken()) for ship in (A, B)})

    (settlement,) = log.decisions[A].settlements
    assert settlement.fallback == "conflict: the ruleset failed: ZeroDivisionError: no rule for b"
    assert log.generations == ((A,), (B,))  # the lighter one first
    assert {each.fallback for each in log.decisions.values()} == {""}


def test_one_ship_with_broken_rules_does_not_stop_the_other() -> None:
    log = period({A: agent(A, TWO), B: agent(B, Broken())})

    assert {each.settlements[0].fallback for each in log.decisions.values()} == {
        "a sees give_way, b sees conflict"
    }


def test_ships_with_different_versions_of_their_rules_fall_back_and_say_so() -> None:
    log = period({A: agent(A, TWO), B: agent(B, Decreed([(A, B)], version="2"))})

    assert {each.settlements[0].fallback for each in log.decisions.values()} == {
        "a judges by decreed 1, b by decreed 2"
    }
    assert log.generations == ((A,), (B,))


@pytest.mark.parametrize("wait", list(Wait))
def test_every_ship_makes_all_its_iterations(wait: Wait) -> None:
    solver = Nominal()
    log = period({ship: agent(ship, Decreed(CHAIN), iterations=3, wait=wait) for ship in (A, B, C)}, solver)

    assert sorted(solver.order()) == sorted(3 * [A, B, C])
    assert all(len(each.update_ms) == len(each.residuals) == 3 for each in log.decisions.values())


def test_agents_share_nothing_that_can_be_changed() -> None:
    together = {ship: agent(ship, Decreed(CHAIN)) for ship in (A, B, C)}
    period(together)
    period(together, index=1)

    owned = [
        {
            id(value)
            for name, value in vars(each).items()
            if isinstance(value, dict | list | set) and name != "_rulesets"
        }
        for each in together.values()
    ]
    assert sum(map(len, owned)) == len(set().union(*owned))


def test_ship_knows_of_others_by_the_bus_only() -> None:
    agents = {ship: agent(ship, Decreed(CHAIN)) for ship in (A, B, C)}
    log = period(agents, bus=Bus(loss=1.0 - 1e-12))

    assert log.generations == ((A, B, C),)
    assert all(decision.settlements == () for decision in log.decisions.values())


def test_last_promise_of_a_period_is_known_in_the_next() -> None:
    agents = {ship: agent(ship, TWO) for ship in (A, B)}
    bus = Bus()
    first = period(agents, bus=bus)
    period(agents, bus=bus, index=1)

    promised = first.decisions[B].plan.poses[1:]
    assert B in agents[A]._promises
    assert agents[A]._promises[B].poses[:-1] == pytest.approx(promised, abs=1e-9)


def test_ship_that_has_arrived_is_not_heard_of_again() -> None:
    agents = {ship: agent(ship, TWO) for ship in (A, B)}
    bus = Bus()
    period(agents, bus=bus)
    log = period({B: agents[B]}, bus=bus, index=1)

    assert log.generations == ((B,),)
    assert log.decisions[B].settlements == ()


def test_pose_of_a_plan_begins_where_the_ship_is() -> None:
    log = period({ship: agent(ship, TWO) for ship in (A, B)})
    here = log.decisions[A].plan.poses[0]

    assert NedPose(*map(float, here)) == sensed(A).pose
