"""Algorithm 2: the order of updates in both readings of wait(i), and what a ship plans on."""

from __future__ import annotations

import numpy as np
import pytest

from ccas_core.agent.bus import Bus
from ccas_core.agent.messages import Intention, Message
from ccas_core.dmpc.negotiate import Progress, may_update
from ccas_core.dmpc.parameters import Wait
from ccas_core.ships import ShipId

from ..agent import CHAIN, HORIZON, A, B, C, Decreed, Nominal, agent, line, period, sensed, speed


class Tape(Bus):
    """A bus that keeps all intentions."""

    def __init__(self) -> None:
        super().__init__()
        self.said: list[Intention] = []

    def post(self, now: float, message: Message) -> None:
        """Keep an intention, and send."""
        if isinstance(message, Intention):
            self.said.append(message)
        super().post(now, message)


def updates(wait: Wait, iterations: int = 3) -> list[tuple[ShipId, int]]:
    """Ship and number of each update, in the order in which they were told."""
    tape = Tape()
    ships = (A, B, C)
    agents = {ship: agent(ship, Decreed(CHAIN), iterations=iterations, wait=wait) for ship in ships}
    period(agents, bus=tape)
    return [(each.sender, each.iteration) for each in tape.said]


def test_sequential_ships_finish_all_iterations_before_the_next_begins() -> None:
    assert updates(Wait.SEQUENTIAL) == [(ship, n) for ship in (A, B, C) for n in (1, 2, 3)]


def test_interleaved_ships_make_each_iteration_after_their_predecessor_made_it() -> None:
    told = updates(Wait.INTERLEAVED)

    assert sorted(told) == [(ship, n) for ship in (A, B, C) for n in (1, 2, 3)]
    for n in (1, 2, 3):
        assert told.index((A, n)) < told.index((B, n)) < told.index((C, n))


def test_interleaved_last_ship_begins_before_the_first_has_finished_or_with_it() -> None:
    told = updates(Wait.INTERLEAVED, iterations=5)

    assert told.index((C, 1)) < told.index((A, 5))


@pytest.mark.parametrize("wait", list(Wait))
def test_with_one_iteration_both_readings_are_the_same(wait: Wait) -> None:
    assert updates(wait, iterations=1) == [(A, 1), (B, 1), (C, 1)]


def test_ship_without_predecessors_never_waits() -> None:
    assert all(may_update(wait, n, []) for wait in Wait for n in range(3))


def test_predecessor_that_has_decided_is_not_waited_for() -> None:
    assert all(may_update(wait, 5, [Progress(1, decided=True)]) for wait in Wait)


def test_ship_waits_for_all_of_its_predecessors() -> None:
    far, near = Progress(3, decided=True), Progress(0, decided=False)

    assert not any(may_update(wait, 0, [far, near]) for wait in Wait)


def test_predecessor_that_has_not_told_its_intention_is_predicted_with_constant_velocity() -> None:
    solver = Nominal()
    agents = {ship: agent(ship, Decreed([(A, B)])) for ship in (A, B)}
    period(agents, solver)

    first = solver.asked[0]  # of A, who has heard nothing of B's intention
    assert solver.order()[0] == A
    assert first.threats.shape == (1, HORIZON, 6)
    ahead = sensed(B).pose.y - sensed(A).pose.y + speed(B) * 20.0 * np.arange(1, HORIZON + 1)
    start = line(A).frame.to_path(sensed(A).pose).x
    assert first.threats[0, :, 0] == pytest.approx(start + ahead, abs=1e-9)
    assert first.threats[0, :, 1] == pytest.approx(np.full(HORIZON, -2000.0), abs=1e-9)


@pytest.mark.parametrize("iterations", [1, 2, 5])
def test_iterations_are_counted_and_done_ships_promise_once(iterations: int) -> None:
    tape = Tape()
    agents = {ship: agent(ship, Decreed(CHAIN), iterations=iterations) for ship in (A, B, C)}
    log = period(agents, bus=tape)

    for ship in (A, B, C):
        said = [each for each in tape.said if each.sender == ship]
        assert [each.iteration for each in said] == list(range(1, iterations + 1))
        assert [each.decided for each in said] == [False] * (iterations - 1) + [True]
        assert said[-1].trajectory.poses == pytest.approx(log.decisions[ship].plan.poses)


def test_period_ends_when_all_ships_are_done() -> None:
    agents = {ship: agent(ship, Decreed(CHAIN)) for ship in (A, B, C)}

    assert period(agents).decisions.keys() == {A, B, C}
