"""Faults of the solver and of the radio: every ship has a command in every period, and the voyage goes on."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import pytest

from ccas_core import plugins
from ccas_core.dmpc.local_problem import LocalPlan, LocalProblem, Solution
from ccas_core.dmpc.outcome import Outcome
from ccas_core.dmpc.solvers import AbstractLocalSolver, make_solver
from ccas_core.frames import FloatArray
from ccas_core.sim.frame import Frame
from ccas_core.sim.scenario import BusChoice, Scenario
from ccas_core.sim.scenario_file import load_scenario
from ccas_core.sim.voyage import periods_limit, voyage
from ccas_scenarios import path

RULESETS = plugins.load().rulesets
Fails = Callable[[int], bool]  # number of the solve -> whether it fails


class Faulty(AbstractLocalSolver):
    """A solver that fails when it is told to."""

    name = "faulty"

    def __init__(self, fails: Fails, outcome: Outcome = Outcome.FAILED, *, nan: bool = False) -> None:
        self._fails, self._outcome, self._nan = fails, outcome, nan
        self._inner = make_solver("riccati")
        self.count = 0

    def solve(self, problem: LocalProblem, guess: FloatArray) -> Solution:
        """Solve from one guess, or fail."""
        return self.best(problem, [guess])

    def best(self, problem: LocalProblem, guesses: Iterable[FloatArray]) -> Solution:
        """Solve, or fail."""
        self.count += 1
        answer = self._inner.best(problem, guesses)
        if not self._fails(self.count):
            return answer
        if self._nan:
            nowhere = LocalPlan(
                controls=np.full_like(answer.plan.controls, math.nan), trajectory=answer.plan.trajectory
            )
            answer = replace(answer, plan=nowhere, objective=math.nan)
        return replace(answer, outcome=self._outcome)


def crossing(bus: BusChoice | None = None) -> Scenario:
    scenario = load_scenario(path("tran2026/fig_10"), RULESETS)
    control = replace(scenario.control, horizon=30)
    return replace(scenario, control=control, bus=bus or BusChoice())


def alone() -> Scenario:
    scenario = crossing()
    return replace(scenario, ships=scenario.ships[:1])


def sail(scenario: Scenario, solver: AbstractLocalSolver) -> list[Frame]:
    return list(voyage(scenario, RULESETS, solver))


def commanded(frames: list[Frame]) -> bool:
    """Whether every ship under way has a command that can be carried out, in every period."""
    return all(
        id_ in frame.arrived
        or (
            any(id_ in generation for generation in frame.generations)
            and math.isfinite(now.offset)
            and 0.0 <= now.speed_factor <= 1.0
            and bool(np.all(np.isfinite(now.plan.poses)))
        )
        for frame in frames
        for id_, now in frame.ships.items()
    )


@pytest.mark.parametrize(
    ("outcome", "nan"),
    [(Outcome.FAILED, False), (Outcome.ITERATION_LIMIT, False), (Outcome.NOT_FINITE, True)],
)
def test_solver_that_always_fails_leaves_every_ship_a_command(outcome: Outcome, nan: bool) -> None:
    frames = sail(crossing(), Faulty(lambda _: True, outcome, nan=nan))

    assert commanded(frames)
    assert frames[-1].index == periods_limit(crossing())  # the voyage went on to its end
    for frame in frames:
        for now in frame.ships.values():
            assert now.outcome == outcome.value
            assert now.fallback.startswith(f"{outcome.value}: the ")
            assert now.speed_factor == 0.0


def test_solver_that_sometimes_fails_leaves_every_ship_a_command() -> None:
    draws = np.random.default_rng(21).random(10_000) < 0.5
    frames = sail(crossing(), Faulty(lambda n: bool(draws[n])))

    assert commanded(frames)
    troubled = [now for frame in frames for now in frame.ships.values() if now.outcome]
    assert len(troubled) > 10
    assert any(not now.fallback for now in troubled)  # one usable update of three is enough


def test_solver_that_fails_after_a_good_period_lets_the_last_plan_go_on() -> None:
    frames = sail(alone(), Faulty(lambda n: 4 <= n <= 6))

    (now,) = frames[1].ships.values()
    assert now.fallback == f"{Outcome.FAILED.value}: the last plan goes on"
    assert now.speed_factor > 0.99


def test_ship_that_slowed_down_once_sails_on_when_the_solver_works_again() -> None:
    frames = sail(alone(), Faulty(lambda n: n <= 3))

    factors = [now.speed_factor for frame in frames for now in frame.ships.values()]
    assert factors[0] == 0.0
    assert min(factors[3:]) > 0.9


def test_answer_that_is_not_a_number_never_reaches_the_rudder() -> None:
    draws = np.random.default_rng(22).random(10_000) < 0.3
    frames = sail(crossing(), Faulty(lambda n: bool(draws[n]), Outcome.NOT_FINITE, nan=True))

    assert commanded(frames)
    assert len(frames) > 40


def told(frames: list[Frame]) -> list[object]:
    return [
        (frame.time, id_, now.pose, now.offset, now.speed_factor, now.fallback, frame.generations)
        for frame in frames
        for id_, now in frame.ships.items()
    ]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_loss_of_a_third_and_delay_of_2_s_leave_every_ship_a_command(seed: int) -> None:
    frames = sail(crossing(BusChoice(loss=0.3, delay=2.0, seed=seed)), make_solver("riccati"))

    assert commanded(frames)
    assert any(each.fallback for frame in frames for each in frame.settlements)  # it did matter
    assert len(frames[-1].arrived) == 2


def test_loss_and_delay_repeat_themselves() -> None:
    choice = BusChoice(loss=0.3, delay=2.0, seed=4)
    one, same = (told(sail(crossing(choice), make_solver("riccati"))) for _ in range(2))
    other = told(sail(crossing(replace(choice, seed=5)), make_solver("riccati")))

    assert one == same
    assert one != other


def test_faults_of_solver_and_radio_together_leave_every_ship_a_command() -> None:
    draws = np.random.default_rng(23).random(10_000) < 0.3
    four = load_scenario(path("tran2026/fig_14"), RULESETS)
    scenario = replace(
        four, control=replace(four.control, horizon=20), bus=BusChoice(loss=0.3, delay=2.0, seed=9)
    )

    assert commanded(sail(scenario, Faulty(lambda n: bool(draws[n]))))
