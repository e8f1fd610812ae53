"""The compiled solver: its translation from CasADi, its cache, its answers."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from ccas_core import compiling
from ccas_core.dmpc.casadi_to_numba import python_source
from ccas_core.dmpc.local_problem import LocalPlan, LocalProblem, free_speeds
from ccas_core.dmpc.model import (
    CONTROLS,
    STATES,
    constants,
    objective,
    stage_model,
    stage_parameters,
)
from ccas_core.dmpc.outcome import Outcome
from ccas_core.dmpc.parameters import Start
from ccas_core.dmpc.riccati import Riccati, stage_functions
from ccas_core.dmpc.solvers import AbstractLocalSolver, make_solver
from ccas_core.dmpc.trajectories import rollout
from ccas_core.errors import InputError
from ccas_core.frames import FloatArray, PathTrajectory

from .problems import guess, guesses, random_problem

pytest.importorskip("numba")


@pytest.fixture(scope="module")
def riccati() -> Riccati:
    return Riccati()


def _problems(count: int, seed: int) -> list[LocalProblem]:
    generator = np.random.default_rng(seed)
    return [random_problem(generator) for _ in range(count)]


def _gradient(problem: LocalProblem, plan: LocalPlan) -> FloatArray:
    """Gradient of the objective by the controls, from CasADi by another way: single shooting, forwards."""
    threats, horizon = max(1, len(problem.threats)), problem.settings.horizon
    model, fixed = stage_model(threats), constants(problem)
    controls = ca.MX.sym("controls", CONTROLS, horizon)
    stages = stage_parameters(problem, threats)
    pose = problem.initial
    state, total = ca.MX([pose.x, pose.y, pose.course, problem.last_offset]), ca.MX(0)
    for k in range(horizon):
        total += model.control_cost(state, controls[:, k], fixed)
        state = model.dynamics(state, controls[:, k], fixed)
        total += model.state_cost(state, stages[k], fixed)
    slope = ca.Function("slope", [controls], [ca.gradient(total, controls)])
    return np.asarray(slope(plan.controls.T)).T


def _projected(problem: LocalProblem, plan: LocalPlan) -> float:
    """Greatest part of the gradient that is not held by a bound."""
    low = np.column_stack([problem.offset_limits[:, 0], np.zeros(len(plan.controls))])
    high = np.column_stack([problem.offset_limits[:, 1], np.ones(len(plan.controls))])
    inward = np.clip(plan.controls - _gradient(problem, plan), low, high) - plan.controls
    return float(np.max(np.abs(inward)))


def _evaluated(function: ca.Function, arguments: list[FloatArray]) -> list[FloatArray]:
    results = function.call([ca.DM(argument) for argument in arguments])
    return [np.asarray(result) for result in results]


# --- the translation ---------------------------------------------------------------------------


def test_every_translated_operation_gives_what_casadi_gives() -> None:
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    one: list[Any] = [
        ca.exp,
        ca.log,
        ca.sqrt,
        ca.sin,
        ca.cos,
        ca.tan,
        ca.asin,
        ca.acos,
        ca.atan,
        ca.sinh,
        ca.cosh,
    ]
    one += [ca.tanh, ca.asinh, ca.atanh, ca.expm1, ca.log1p, ca.erf]
    signed: list[Any] = [ca.floor, ca.ceil, ca.fabs, ca.sign, ca.logic_not]
    two: list[Any] = [
        ca.plus,
        ca.minus,
        ca.times,
        ca.rdivide,
        ca.power,
        ca.fmod,
        ca.copysign,
        ca.atan2,
        ca.hypot,
    ]
    two += [ca.fmin, ca.fmax, ca.lt, ca.le, ca.eq, ca.ne, ca.logic_and, ca.logic_or]
    terms = [f(x) for f in one] + [f(2.0 * y) for f in signed] + [f(x, y) for f in two]
    terms += [-x, x**2, 2 * x, 1 / x, ca.acosh(1 + x), x**2.5, ca.if_else(x < y, ca.sin(x), y), ca.inf * x]
    function = ca.Function("terms", [x, y], [ca.vertcat(*terms)])
    names: dict[str, Any] = {"math": math, "np": np}
    exec(python_source(function), names)  # noqa: S102
    for values in ((0.3, -0.7), (0.9, 0.2), (0.5, 0.5), (0.25, 1e-9)):
        found = np.empty(len(terms))
        names["terms"](*([value] for value in values), found)

        assert found == pytest.approx(np.asarray(function(*values)).ravel(), rel=1e-14, nan_ok=True)


def test_structural_zeros_are_written() -> None:
    x = ca.SX.sym("x", 2)
    names: dict[str, Any] = {}
    exec(python_source(ca.Function("table", [x], [ca.diag(x)])), names)  # noqa: S102
    found = np.full((2, 2), np.nan)
    names["table"](np.array([3.0, 4.0]), found)

    assert found.tolist() == [[3.0, 0.0], [0.0, 4.0]]


def test_functions_of_matrices_have_no_translation() -> None:
    x = ca.MX.sym("x", 2)

    with pytest.raises(NotImplementedError, match="norm is not made of SX"):
        python_source(ca.Function("norm", [x], [ca.norm_2(x)]))


@pytest.mark.parametrize("function", stage_functions(), ids=lambda function: function.name())
def test_compiled_stage_functions_equal_casadi(function: ca.Function, riccati: Riccati) -> None:
    generator = np.random.default_rng(3)
    shapes_in = [function.size_in(i) for i in range(function.n_in())]
    shapes_out = [function.size_out(i) for i in range(function.n_out())]
    for _ in range(50):
        arguments = [generator.uniform(0.1, 1.5, shape) for shape in shapes_in]
        expected = _evaluated(function, arguments)
        found = [
            np.empty(shape).squeeze(axis=1) if shape[1] == 1 else np.empty(shape) for shape in shapes_out
        ]
        flat = [each.squeeze(axis=1) if each.shape[1] == 1 else each for each in arguments]
        getattr(riccati.loops, function.name())(*flat, *found)

        for one, other in zip(found, expected, strict=True):
            assert one.ravel() == pytest.approx(other.ravel(), rel=1e-12, abs=1e-12)


def test_derivatives_of_a_threat_may_be_added_in_place(riccati: Riccati) -> None:
    generator = np.random.default_rng(4)
    state, threat = generator.uniform(0.1, 1.0, STATES), generator.uniform(0.1, 1.0, 6)
    togo = [generator.uniform(size=4), np.eye(4), generator.uniform(size=4)]
    apart = [np.empty(4), np.empty((4, 4)), np.empty(4)]
    riccati.loops.add_risk(state, threat, *togo, *apart)
    riccati.loops.add_risk(state, threat, *togo, *togo)

    assert all(np.array_equal(one, other) for one, other in zip(apart, togo, strict=True))


def test_state_cost_is_closeness_and_the_risk_of_all_threats() -> None:
    generator = np.random.default_rng(5)
    model = stage_model(3)
    state, stage = generator.uniform(size=STATES), generator.uniform(size=model.stage_parameters)
    fixed = generator.uniform(size=model.constants)
    parts = float(model.closeness(state, stage[:6], fixed))
    parts += sum(float(model.risk(state, stage[6 + 6 * n : 12 + 6 * n])) for n in range(3))

    assert float(model.state_cost(state, stage, fixed)) == pytest.approx(parts, rel=1e-14)


# --- the cache ---------------------------------------------------------------------------------


def test_generated_code_goes_to_the_cache_folder_of_the_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    compiling.cache_folder.cache_clear()
    folder = compiling.cache_folder()
    compiling.cache_folder.cache_clear()

    assert folder == tmp_path / "ccas"
    assert folder.is_dir()


def test_an_unusable_cache_folder_is_replaced_by_one_of_this_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "ccas").write_text("a file where the folder should be")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    compiling.cache_folder.cache_clear()
    folder = compiling.cache_folder()
    compiling.cache_folder.cache_clear()

    assert folder.parent != tmp_path
    assert folder.is_dir()
    folder.rmdir()


def test_without_numba_the_solver_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numba", None)

    with pytest.raises(InputError, match="pip install numba"):
        make_solver("riccati")


def test_numba_is_not_imported_with_the_other_solvers() -> None:
    code = "import ccas_core.dmpc.solvers, sys; raise SystemExit('numba' in sys.modules)"

    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# --- the answers -------------------------------------------------------------------------------


def test_the_solver_has_its_name() -> None:
    solver = make_solver("riccati")

    assert isinstance(solver, Riccati)
    assert solver.name == "riccati"


def test_every_start_ends_in_a_minimum_within_its_bounds(riccati: Riccati) -> None:
    for problem in _problems(100, seed=11):
        for solution in riccati.solve_all(problem, guesses(problem), widen=True):
            offset, factor = solution.plan.controls.T

            assert solution.outcome is Outcome.CONVERGED
            assert np.all((offset >= problem.offset_limits[:, 0]) & (offset <= problem.offset_limits[:, 1]))
            assert np.all((factor >= 0.0) & (factor <= 1.0))


def test_gradient_vanishes_where_no_bound_holds(riccati: Riccati) -> None:
    for problem in _problems(30, seed=12):
        for solution in riccati.solve_all(problem, guesses(problem)):
            assert _projected(problem, solution.plan) < 1e-4


def test_no_small_change_of_the_controls_is_better(riccati: Riccati) -> None:
    generator = np.random.default_rng(13)
    for problem in _problems(20, seed=13):
        solution = riccati.solve(problem, guess(problem, Start.NOMINAL))
        for size in (1e-2, 1e-4):
            change = size * generator.standard_normal(solution.plan.controls.shape) * [1.0, 0.1]
            other = objective(problem, rollout(problem, solution.plan.controls + change))

            assert other >= solution.objective - 1e-9 * abs(solution.objective)


def test_plan_and_objective_are_those_of_the_model(riccati: Riccati) -> None:
    for problem in _problems(30, seed=14):
        solution = riccati.best(problem, guesses(problem))
        sailed = rollout(problem, solution.plan.controls)

        assert solution.objective == pytest.approx(objective(problem, solution.plan), rel=1e-12)
        assert solution.plan.trajectory.poses == pytest.approx(sailed.trajectory.poses, rel=1e-12, abs=1e-12)


def test_best_of_all_starts_is_mostly_as_good_as_that_of_fatrop(riccati: Riccati) -> None:
    fatrop = make_solver("fatrop")
    gaps = []
    for problem in _problems(25, seed=15):
        other = fatrop.best(problem, guesses(problem)).objective
        gaps.append((riccati.best(problem, guesses(problem)).objective - other) / max(1.0, abs(other)))

    worse, better = np.mean(np.array(gaps) > 1e-6), np.mean(np.array(gaps) < -1e-6)
    assert worse <= 0.2  # many minima: neither solver finds the least always
    assert better >= worse


def test_the_first_of_equally_good_answers_wins(riccati: Riccati) -> None:
    problem = random_problem(np.random.default_rng(16), threats=0)
    starts = guesses(problem)
    answers = riccati.solve_all(problem, starts, widen=True)
    best = riccati.best(problem, starts)

    assert max(answer.objective for answer in answers) - min(answer.objective for answer in answers) < 1e-6
    assert np.array_equal(best.plan.controls, answers[0].plan.controls)
    assert best.iterations == sum(answer.iterations for answer in answers)


def test_best_of_one_problem_does_not_depend_on_the_one_before(riccati: Riccati) -> None:
    one, other = _problems(2, seed=17)
    first = riccati.best(one, guesses(one))
    riccati.best(other, guesses(other))

    assert np.array_equal(riccati.best(one, guesses(one)).plan.controls, first.plan.controls)


def _between_two_ways(riccati: AbstractLocalSolver, gain: float) -> LocalProblem:
    """Make an encounter end on, with all on one line: by symmetry the gradient across it is zero."""
    problem = random_problem(np.random.default_rng(18), threats=1)
    settings = replace(problem.settings, weights=replace(problem.settings.weights, mu_3=0.0, K_y=0.01))
    horizon = settings.horizon
    row = np.tile([800.0, 0.0, 1e-5, 0.0, 1e-3, gain], (1, horizon, 1))
    line = np.column_stack([60.0 * np.arange(horizon + 1), np.zeros(horizon + 1), np.zeros(horizon + 1)])
    return replace(
        problem,
        initial=replace(problem.initial, x=0.0, y=0.0, course=0.0),
        last_offset=0.0,
        settings=settings,
        threats=row,
        multiplier=np.zeros((horizon + 1, 3)),
        broadcast=PathTrajectory(line),
    )


def test_a_saddle_is_left_to_starboard(riccati: Riccati) -> None:
    problem = _between_two_ways(riccati, gain=5000.0)
    solution = riccati.solve(problem, guess(problem, Start.NOMINAL))

    assert solution.outcome is Outcome.CONVERGED
    assert np.max(solution.plan.trajectory.poses[:, 1]) > 10.0
    assert np.min(solution.plan.trajectory.poses[:, 1]) > -1.0


def test_narrow_and_changing_limits_are_kept(riccati: Riccati) -> None:
    problem = _problems(1, seed=19)[0]
    horizon = problem.settings.horizon
    low = np.linspace(-3.0, 5.0, horizon)
    problem = replace(problem, offset_limits=np.column_stack([low, low + np.linspace(0.0, 2.0, horizon)]))
    solution = riccati.best(problem, guesses(problem))
    offset = solution.plan.controls[:, 0]

    assert solution.outcome is Outcome.CONVERGED
    assert np.all((offset >= problem.offset_limits[:, 0]) & (offset <= problem.offset_limits[:, 1]))


@pytest.mark.parametrize("horizon", [1, 2, 60])
def test_any_horizon_is_solved(horizon: int, riccati: Riccati) -> None:
    problem = random_problem(np.random.default_rng(20), threats=0)
    settings = replace(problem.settings, horizon=horizon)
    line = np.column_stack([60.0 * np.arange(horizon + 1), np.zeros(horizon + 1), np.zeros(horizon + 1)])
    problem = replace(
        problem,
        settings=settings,
        offset_limits=np.tile([-60.0, 60.0], (horizon, 1)),
        speed_limits=free_speeds(horizon),
        threats=np.zeros((0, horizon, 6)),
        multiplier=np.zeros((horizon + 1, 3)),
        broadcast=PathTrajectory(line),
    )

    assert riccati.solve(problem, guess(problem, Start.SLOW)).outcome is Outcome.CONVERGED


# --- what cannot be solved ---------------------------------------------------------------------


def test_nan_in_a_threat_is_not_finite(riccati: Riccati) -> None:
    problem = random_problem(np.random.default_rng(21), threats=2)
    threats = np.array(problem.threats)
    threats[1, 7, 0] = np.nan
    solution = riccati.best(replace(problem, threats=threats), guesses(problem))

    assert solution.outcome is Outcome.NOT_FINITE
    assert solution.iterations == 0


def test_nan_in_the_broadcast_is_not_finite(riccati: Riccati) -> None:
    problem = random_problem(np.random.default_rng(22))
    poses = np.array(problem.broadcast.poses)
    poses[3, 1] = np.nan
    broken = replace(problem, broadcast=PathTrajectory(poses))

    assert riccati.solve(broken, guess(broken, Start.NOMINAL)).outcome is Outcome.NOT_FINITE


def test_a_guess_that_is_not_finite_loses_to_one_that_is(riccati: Riccati) -> None:
    problem = random_problem(np.random.default_rng(23))
    nominal = guess(problem, Start.NOMINAL)

    assert riccati.solve(problem, nominal * np.nan).outcome is Outcome.NOT_FINITE
    assert riccati.best(problem, [nominal * np.nan, nominal]).outcome is Outcome.CONVERGED


def test_crossed_limits_are_infeasible(riccati: Riccati) -> None:
    problem = random_problem(np.random.default_rng(24))
    crossed = replace(problem, offset_limits=problem.offset_limits[:, ::-1])

    assert riccati.solve(crossed, guess(problem, Start.NOMINAL)).outcome is Outcome.INFEASIBLE


def test_a_guess_of_another_horizon_is_refused(riccati: Riccati) -> None:
    problem = random_problem(np.random.default_rng(25))

    with pytest.raises(ValueError, match="guesses are"):
        riccati.solve(problem, np.zeros((3, 2)))


# --- compiling ---------------------------------------------------------------------------------


def test_compiling_is_told_the_first_time_and_then_never_again(tmp_path: Path) -> None:
    code = (
        "from ccas_core.dmpc.solvers import make_solver\n"
        "told = []\n"
        "make_solver('riccati').prepare(told.append)\n"
        "print(len(told), *told, sep='|')\n"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}
    first, second = (
        subprocess.run(
            [sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True
        ).stdout
        for _ in range(2)
    )

    assert first.startswith("2|compiling solver riccati for this machine; that is done once")
    assert second == "0\n"
