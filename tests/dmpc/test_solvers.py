"""The solvers of CasADi, and what they all owe: equal answers, kept bounds, values for every failure."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from ccas_core.dmpc.local_problem import LocalProblem, Solution
from ccas_core.dmpc.model import objective
from ccas_core.dmpc.outcome import Outcome
from ccas_core.dmpc.parameters import Start
from ccas_core.dmpc.solvers import (
    SOLVERS,
    AbstractLocalSolver,
    Fatrop,
    Ipopt,
    _Programme,
    default_solver,
    make_solver,
    slots,
)
from ccas_core.dmpc.trajectories import rollout
from ccas_core.errors import InputError
from ccas_core.frames import FloatArray

from .problems import guess, guesses, random_problem

CASADI = ("ipopt", "fatrop")
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def solvers() -> dict[str, AbstractLocalSolver]:
    return {name: make_solver(name) for name in CASADI}


def problems(count: int, seed: int) -> list[LocalProblem]:
    generator = np.random.default_rng(seed)
    return [random_problem(generator) for _ in range(count)]


def alike(one: Solution, other: Solution) -> bool:
    return math.isclose(one.objective, other.objective, rel_tol=1e-6, abs_tol=1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_ipopt_and_fatrop_agree_or_each_has_found_a_minimum(
    seed: int, solvers: dict[str, AbstractLocalSolver]
) -> None:
    (problem,) = problems(1, 100 + seed)
    one, other = (solvers[name].solve(problem, guess(problem, Start.NOMINAL)) for name in CASADI)

    assert one.outcome is other.outcome is Outcome.CONVERGED
    if alike(one, other):
        near = solvers["fatrop"].solve(problem, one.plan.controls)
        assert alike(near, one)
        assert np.max(np.abs(near.plan.trajectory.poses - one.plan.trajectory.poses)) < 0.1  # [m]
        return
    for answer in (one, other):  # each is a minimum: a descent that starts there gains nothing
        descended = make_solver("riccati").solve(problem, answer.plan.controls)
        assert math.isclose(descended.objective, answer.objective, rel_tol=1e-5, abs_tol=1e-6)


@pytest.mark.parametrize("name", CASADI)
def test_answer_keeps_the_bounds_and_the_model(name: str, solvers: dict[str, AbstractLocalSolver]) -> None:
    for problem in problems(4, 7):
        narrow = replace(problem, offset_limits=np.tile([-8.0, 5.0], (problem.settings.horizon, 1)))
        for start in guesses(narrow):
            plan = solvers[name].solve(narrow, start).plan

            assert np.all((plan.controls[:, 0] >= -8.0) & (plan.controls[:, 0] <= 5.0))
            assert np.all((plan.controls[:, 1] >= 0.0) & (plan.controls[:, 1] <= 1.0))
            assert np.array_equal(rollout(narrow, plan.controls).trajectory.poses, plan.trajectory.poses)


@pytest.mark.parametrize("name", CASADI)
def test_answer_is_not_worse_than_its_start_and_its_objective_is_that_of_its_plan(
    name: str, solvers: dict[str, AbstractLocalSolver]
) -> None:
    for problem in problems(4, 8):
        start = guess(problem, Start.NOMINAL)
        answer = solvers[name].solve(problem, start)

        assert answer.objective == objective(problem, answer.plan)
        assert answer.objective <= objective(problem, rollout(problem, start)) + 1e-9
        assert answer.iterations > 0
        assert answer.seconds > 0.0


# --- what goes wrong is a value


@pytest.mark.parametrize("where", ["threats", "multiplier", "initial", "guess", "speed"])
@pytest.mark.parametrize("name", CASADI)
def test_input_that_is_not_a_number_gives_an_outcome_within_seconds(name: str, where: str) -> None:
    script = f"""
import math, sys
from dataclasses import replace
import numpy as np
from ccas_core.dmpc.solvers import make_solver
from ccas_core.frames import PathPose
from tests.dmpc.problems import guesses, random_problem
problem = random_problem(np.random.default_rng(3))
start = guesses(problem)[0]
nan = {{
    "threats": lambda: replace(problem, threats=np.full_like(problem.threats, math.nan)),
    "multiplier": lambda: replace(problem, multiplier=np.full_like(problem.multiplier, math.nan)),
    "initial": lambda: replace(problem, initial=PathPose(math.nan, 0.0, 0.0)),
    "speed": lambda: replace(problem, speed=math.nan),
}}
if {where!r} == "guess":
    start = np.full_like(start, math.nan)
else:
    problem = nan[{where!r}]()
print(make_solver({name!r}).best(problem, [start]).outcome.name)
"""
    command = (sys.executable, "-c", script)  # in a process of its own: a solver that hangs cannot be stopped
    try:
        ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=10)
    except subprocess.TimeoutExpired:
        pytest.fail(f"{name} does not come back from {where} that are not numbers")

    assert (ran.returncode, ran.stdout.strip()) == (0, "NOT_FINITE")


class Stub:
    """A built programme of CasADi that answers as it is told."""

    def __init__(self, stats: dict[str, Any], *, nan: bool = False, error: Exception | None = None) -> None:
        self._stats, self._nan, self._error = stats, nan, error

    def __call__(self, **arguments: FloatArray) -> dict[str, FloatArray]:
        """Answer with the start, or with none."""
        if self._error is not None:
            raise self._error
        start = np.asarray(arguments["x0"])
        return {"x": np.full_like(start, math.nan) if self._nan else start}

    def stats(self) -> dict[str, Any]:
        """Report as it was told to."""
        return self._stats


def stubbed(name: str, monkeypatch: pytest.MonkeyPatch, stub: Stub) -> AbstractLocalSolver:
    kind = {"ipopt": Ipopt, "fatrop": Fatrop}[name]
    built = kind.build

    def build(self: Ipopt | Fatrop, horizon: int, threats: int) -> _Programme:
        return replace(built(self, horizon, threats), solve=stub)  # type: ignore[arg-type]

    monkeypatch.setattr(kind, "build", build)
    return make_solver(name)


@pytest.mark.parametrize("error", [RuntimeError("no memory left"), ZeroDivisionError("by zero")])
@pytest.mark.parametrize("name", CASADI)
def test_programme_that_raises_gives_an_outcome_and_the_start(
    name: str, error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    (problem,) = problems(1, 9)
    answer = stubbed(name, monkeypatch, Stub({}, error=error)).solve(problem, guess(problem, Start.SLOW))

    assert answer.outcome is Outcome.FAILED
    assert answer.message == str(error)
    assert np.array_equal(answer.plan.controls, guess(problem, Start.SLOW))
    assert math.isfinite(answer.objective)


@pytest.mark.parametrize(
    ("status", "outcome"),
    [
        ("Maximum_Iterations_Exceeded", Outcome.ITERATION_LIMIT),
        ("Maximum_WallTime_Exceeded", Outcome.ITERATION_LIMIT),
        ("Maximum_CpuTime_Exceeded", Outcome.ITERATION_LIMIT),
        ("SOLVER_RET_LIMITED", Outcome.ITERATION_LIMIT),
        ("Infeasible_Problem_Detected", Outcome.INFEASIBLE),
        ("Restoration_Failed", Outcome.INFEASIBLE),
        ("Invalid_Number_Detected", Outcome.NOT_FINITE),
        ("SOLVER_RET_NAN", Outcome.NOT_FINITE),
        ("Internal_Error", Outcome.FAILED),
    ],
)
def test_report_of_a_solver_is_read_as_an_outcome(
    status: str, outcome: Outcome, monkeypatch: pytest.MonkeyPatch
) -> None:
    (problem,) = problems(1, 9)
    stub = Stub({"success": False, "return_status": status, "iter_count": 17})
    answer = stubbed("ipopt", monkeypatch, stub).solve(problem, guess(problem, Start.NOMINAL))

    assert (answer.outcome, answer.message, answer.iterations) == (outcome, status, 17)
    assert not answer.outcome.usable


@pytest.mark.parametrize("name", CASADI)
def test_answer_that_is_not_a_number_is_replaced_by_the_start(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    (problem,) = problems(1, 9)
    stub = Stub({"success": True}, nan=True)
    answer = stubbed(name, monkeypatch, stub).solve(problem, guess(problem, Start.SLOW))

    assert answer.outcome is Outcome.NOT_FINITE
    assert np.array_equal(answer.plan.controls, guess(problem, Start.SLOW))


def test_iteration_limit_is_an_outcome(monkeypatch: pytest.MonkeyPatch) -> None:
    built = ca.nlpsol

    def short(name: str, plugin: str, programme: dict[str, ca.SX], options: dict[str, Any]) -> ca.Function:
        return built(name, plugin, programme, {**options, "ipopt": {**options["ipopt"], "max_iter": 2}})

    monkeypatch.setattr(ca, "nlpsol", short)
    (problem,) = problems(1, 10)
    answer = Ipopt().solve(problem, guess(problem, Start.STARBOARD))

    assert answer.outcome is Outcome.ITERATION_LIMIT
    assert answer.iterations == 2
    assert np.all(np.isfinite(answer.plan.controls))


@pytest.mark.parametrize("name", CASADI)
def test_bounds_that_leave_no_room_are_infeasible(name: str, solvers: dict[str, AbstractLocalSolver]) -> None:
    (problem,) = problems(1, 11)
    crossed = replace(problem, offset_limits=np.tile([10.0, -10.0], (problem.settings.horizon, 1)))
    answer = solvers[name].solve(crossed, guess(problem, Start.NOMINAL))

    assert answer.outcome is Outcome.INFEASIBLE
    assert np.all(np.isfinite(answer.plan.controls))


# --- the choice among answers


def solution(value: float, outcome: Outcome = Outcome.CONVERGED, iterations: int = 1) -> Solution:
    (problem,) = problems(1, 12)
    plan = rollout(problem, guess(problem, Start.NOMINAL))
    return Solution(plan=plan, objective=value, outcome=outcome, iterations=iterations, seconds=0.5)


def test_best_prefers_the_least_objective() -> None:
    assert AbstractLocalSolver.choose([solution(3.0), solution(1.0), solution(2.0)]).objective == 1.0


def test_best_prefers_a_usable_answer_to_a_smaller_one() -> None:
    answers = [solution(1.0, Outcome.ITERATION_LIMIT), solution(9.0), solution(0.5, Outcome.NOT_FINITE)]

    assert AbstractLocalSolver.choose(answers).objective == 9.0


def test_best_takes_the_first_of_equal_answers() -> None:
    answers = [solution(1000.0), solution(1000.0 - 1e-4), solution(1000.0 + 1e-4)]

    assert AbstractLocalSolver.choose(answers).plan is answers[0].plan


def test_best_keeps_a_number_where_the_others_are_none() -> None:
    answers = [solution(2.0), solution(math.nan, Outcome.NOT_FINITE)]

    assert AbstractLocalSolver.choose(answers).objective == 2.0


def test_best_counts_the_iterations_and_seconds_of_all_starts() -> None:
    chosen = AbstractLocalSolver.choose([solution(1.0, iterations=3), solution(2.0, iterations=4)])

    assert (chosen.iterations, chosen.seconds) == (7, 1.0)


def test_programme_is_built_once_for_a_horizon_and_a_number_of_threats() -> None:
    solver = Fatrop()
    for problem in problems(3, 13):
        one = replace(problem, threats=problem.threats[:1])
        solver.solve(one, guess(one, Start.NOMINAL))

    assert list(solver.programmes) == [(45, 1)]


def test_problem_without_threats_is_solved(solvers: dict[str, AbstractLocalSolver]) -> None:
    generator = np.random.default_rng(14)
    for solver in solvers.values():
        problem = random_problem(generator, threats=0)

        assert solver.solve(problem, guess(problem, Start.NOMINAL)).outcome is Outcome.CONVERGED


def test_any_number_of_threats_has_a_programme() -> None:
    assert all(slots(count) >= count for count in (0, 1, 5, 128, 129, 1000))


@pytest.mark.parametrize("name", SOLVERS)
def test_solver_is_made_by_its_name(name: str) -> None:
    assert make_solver(name).name == name


def test_unknown_solver_is_refused_with_a_hint() -> None:
    with pytest.raises(InputError) as caught:
        make_solver("iopt")

    (finding,) = caught.value.diagnostics
    assert finding.message == "unknown solver 'iopt'"
    assert finding.hint == "did you mean 'ipopt'?"


# --- the default


@pytest.fixture
def no_numba(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setitem(sys.modules, "numba", None)
    default_solver.cache_clear()
    yield
    default_solver.cache_clear()


def test_riccati_is_the_default_where_numba_is_installed() -> None:
    default_solver.cache_clear()

    assert make_solver().name == "riccati"


def test_without_numba_fatrop_is_the_default_and_says_so_once(no_numba: None) -> None:
    with pytest.warns(RuntimeWarning, match="numba is not installed: solver 'fatrop' stands in") as remarks:
        names = [make_solver().name, make_solver().name]

    assert names == ["fatrop", "fatrop"]
    assert len(remarks) == 1
