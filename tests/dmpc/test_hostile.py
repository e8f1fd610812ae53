"""What nobody should ask for: an outcome comes back all the same, and a ship keeps a safe command."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ccas_core.dmpc import negotiate
from ccas_core.dmpc.negotiate import Neighbour, Situation
from ccas_core.dmpc.outcome import Outcome
from ccas_core.dmpc.parameters import HEAD_ON, Start
from ccas_core.dmpc.prediction import ConstantVelocity
from ccas_core.dmpc.solvers import AbstractLocalSolver, make_solver
from ccas_core.frames import NedPose, NedTrajectory, PathFrame, PathPose, frozen_array
from ccas_core.ships import Hull

HULL = Hull(length=103.0, beam=11.45)
LINE = PathFrame(frozen_array([[0.0, 0.0], [6000.0, 0.0]]))
SOLVERS = ("riccati", "fatrop", "ipopt")


@pytest.fixture(scope="module")
def solvers() -> dict[str, AbstractLocalSolver]:
    pytest.importorskip("numba")
    return {name: make_solver(name) for name in SOLVERS}


def situation(
    *, speed: float = 3.0, horizon: int = 45, starts: tuple[Start, ...] = tuple(Start)
) -> Situation:
    """A ship at the beginning of a straight line, with 60 m of water to either side."""
    return Situation(
        hull=HULL,
        frame=LINE,
        initial=PathPose(0.0, 0.0, 0.0),
        last_offset=0.0,
        speed=speed,
        settings=replace(HEAD_ON, horizon=horizon, starts=starts),
        offset_limits=np.tile([-60.0, 60.0], (horizon, 1)),
        room=np.tile([-60.0, 60.0], (horizon, 1)),
        last_controls=None,
    )


def other(x: float, y: float, course: float, *, speed: float = 3.0, horizon: int = 45) -> Neighbour:
    return Neighbour(HULL, ConstantVelocity().predict(NedPose(x, y, course), speed, horizon, 20.0))


def crowd(count: int) -> list[Neighbour]:
    """So many ships all about, on all courses."""
    generator = np.random.default_rng(count)
    places = zip(generator.uniform(200.0, 3000.0, count), generator.uniform(-60.0, 60.0, count), strict=True)
    return [other(x, y, float(generator.uniform(-math.pi, math.pi))) for x, y in places]


CASES = {
    "two ships at one spot": (situation(), [other(0.0, 0.0, 0.0)]),
    "two ships at one spot, at rest": (situation(speed=0.0), [other(0.0, 0.0, 0.0, speed=0.0)]),
    "head to head at one spot": (situation(), [other(0.0, 0.0, math.pi)]),
    "speed zero": (situation(speed=0.0), [other(900.0, 0.0, math.pi)]),
    "horizon one": (situation(horizon=1), [other(120.0, 0.0, math.pi, horizon=1)]),
    "no neighbours": (situation(), []),
    "fifty neighbours": (situation(), crowd(50)),
    "a neighbour that jumps about": (
        situation(),
        [Neighbour(HULL, NedTrajectory(np.random.default_rng(1).uniform(-1e5, 1e5, (46, 3))))],
    ),
}
POISON = (math.nan, math.inf, -math.inf)


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("case", CASES)
def test_degenerate_encounter_has_an_answer_within_bounds(
    case: str, name: str, solvers: dict[str, AbstractLocalSolver]
) -> None:
    here, neighbours = CASES[case]
    begun = negotiate.begin(here)
    problem = negotiate.local_problem(begun, neighbours)
    solution = solvers[name].best(problem, negotiate.guesses(begun))
    offset, factor = solution.plan.controls.T

    assert isinstance(solution.outcome, Outcome)
    assert np.all(np.isfinite(solution.plan.controls))
    assert np.all((np.abs(offset) <= 60.0) & (factor >= 0.0) & (factor <= 1.0))
    assert solution.outcome is Outcome.CONVERGED or name != "riccati"


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("poison", POISON)
def test_trajectory_that_is_not_a_number_gives_an_outcome_and_the_ship_slows_down(
    poison: float, name: str, solvers: dict[str, AbstractLocalSolver]
) -> None:
    poses = np.array(other(900.0, 0.0, math.pi).trajectory.poses)
    poses[20:, :2] = poison
    begun = negotiate.begin(situation())
    neighbours = [Neighbour(HULL, NedTrajectory(poses))]
    with np.errstate(invalid="ignore"):
        problem = negotiate.local_problem(begun, neighbours)
        solution = solvers[name].best(problem, negotiate.guesses(begun))
        after = negotiate.advance(begun, problem, solution)
        sailing_on = negotiate.guess(Start.NOMINAL, begun.situation.offset_limits)
        plan, what = negotiate.fallback(replace(begun.situation, last_controls=sailing_on), neighbours)

    assert solution.outcome in (Outcome.NOT_FINITE, Outcome.CONVERGED)  # far away is no danger
    assert np.all(np.isfinite(after.plan.controls))
    assert np.all(np.isfinite(plan.controls))
    assert what == "the ship slows down"


def test_answers_do_not_depend_on_the_number_of_threads() -> None:
    pytest.importorskip("numba")
    from ccas_core.dmpc.riccati import Riccati

    tasks = []
    for here, neighbours in (each for case, each in CASES.items() if case != "horizon one"):
        for count in range(9):
            begun = negotiate.begin(replace(here, last_offset=float(count), paths={}, rows={}))
            tasks.append((negotiate.local_problem(begun, neighbours), negotiate.guesses(begun)))
    one, two, five = (Riccati(threads=threads).begin(tasks)() for threads in (1, 2, 5))

    assert len(tasks) > 60
    for answer, same, other_one in zip(one, two, five, strict=True):
        assert np.array_equal(answer.plan.controls, same.plan.controls)
        assert np.array_equal(answer.plan.controls, other_one.plan.controls)
        assert (answer.objective, answer.iterations) == (other_one.objective, other_one.iterations)


def test_problems_of_several_horizons_are_answered_in_their_order() -> None:
    pytest.importorskip("numba")
    solver = make_solver("riccati")
    tasks = []
    for horizon in (5, 30, 5, 12, 30):
        begun = negotiate.begin(situation(horizon=horizon))
        neighbour = other(300.0, 0.0, math.pi, horizon=horizon)
        tasks.append((negotiate.local_problem(begun, [neighbour]), negotiate.guesses(begun)))

    for (problem, guesses), answer in zip(tasks, solver.begin(tasks)(), strict=True):
        assert np.array_equal(answer.plan.controls, solver.best(problem, guesses).plan.controls)


def test_no_problems_have_no_answers() -> None:
    pytest.importorskip("numba")

    assert make_solver("riccati").begin([])() == []
