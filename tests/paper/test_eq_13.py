"""Eq. (13), one update of NADMM, and (A.3): what the print and Appendix A say of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ccas_core.dmpc import nadmm, negotiate
from ccas_core.dmpc.local_problem import LocalProblem
from ccas_core.dmpc.nadmm import Iterate
from ccas_core.dmpc.negotiate import Negotiation, Neighbour, Situation
from ccas_core.dmpc.outcome import Outcome
from ccas_core.dmpc.parameters import HEAD_ON, PARAMETERS, Settings, Start, with_parameter
from ccas_core.dmpc.prediction import ConstantVelocity
from ccas_core.dmpc.solvers import AbstractLocalSolver, make_solver
from ccas_core.frames import FloatArray, NedPose, PathFrame, PathPose, PathTrajectory, frozen_array
from ccas_core.ships import Hull

HULL = Hull(length=103.0, beam=11.4)
LINE = PathFrame(frozen_array([[0.0, 0.0], [0.0, 6000.0]]))  # due east


@pytest.fixture(scope="module")
def solver() -> AbstractLocalSolver:
    return make_solver("fatrop")


# --- the update itself, on f(w) = w'Hw/2 - h'w


def transcribed(
    w: FloatArray, v: FloatArray, z: FloatArray, H: FloatArray, h: FloatArray, beta: float, lambda_: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Eq. (2) letter by letter, A = I, B = -I, b = 0, g = 0; each minimum by its normal equations."""
    eye = np.eye(len(w))
    A, B, b = eye, -eye, np.zeros(len(w))
    z_half = z - beta * (1.0 - lambda_) * (A @ w + B @ v - b)
    w_new = np.linalg.solve(H + beta * A.T @ A, h - A.T @ z_half - beta * A.T @ (B @ v - b))
    z_new = z_half + beta * (A @ w_new + B @ v - b)
    v_new = np.linalg.solve(beta * B.T @ B, -B.T @ z_new - beta * B.T @ (A @ w_new - b))
    return np.asarray(w_new, dtype=float), np.asarray(v_new, dtype=float), z_new


@pytest.mark.parametrize("relaxation", [0.4, 1.0, 1.7])
def test_update_is_eq_2_for_the_problem_of_appendix_A(relaxation: float) -> None:
    generator = np.random.default_rng(13)
    rows, beta = 4, 0.8
    root = generator.normal(size=(3 * rows, 3 * rows))
    H, h = root @ root.T + np.eye(3 * rows), generator.normal(size=3 * rows)
    w, v, z = generator.normal(size=(3, 3 * rows))

    def minimise(half: FloatArray, told: FloatArray) -> FloatArray:
        found = np.linalg.solve(H + beta * np.eye(3 * rows), h - half.ravel() + beta * told.ravel())
        return np.asarray(found, dtype=float).reshape(rows, 3)

    iterate = Iterate(local=w.reshape(rows, 3), broadcast=v.reshape(rows, 3), multiplier=z.reshape(rows, 3))
    for _ in range(5):
        iterate = nadmm.update(iterate, minimise, beta=beta, relaxation=relaxation)
        w, v, z = transcribed(w, v, z, H, h, beta, relaxation)

        assert iterate.local.ravel() == pytest.approx(w, abs=1e-10)
        assert iterate.broadcast.ravel() == pytest.approx(v, abs=1e-10)
        assert iterate.multiplier.ravel() == pytest.approx(z, abs=1e-10)


@pytest.mark.parametrize("relaxation", [0.5, 1.0, 1.5])
def test_multiplier_vanishes_and_the_trajectories_agree_at_the_minimum(relaxation: float) -> None:
    target = np.random.default_rng(14).normal(size=(5, 3))
    beta = 6.0  # more than twice the Lipschitz constant, 2

    def minimise(half: FloatArray, told: FloatArray) -> FloatArray:
        return (2.0 * target - half + beta * told) / (2.0 + beta)

    iterate = nadmm.start(np.zeros((5, 3)))
    for _ in range(200):
        iterate = nadmm.update(iterate, minimise, beta=beta, relaxation=relaxation)

    assert np.max(np.abs(iterate.multiplier)) < 1e-9
    assert iterate.local == pytest.approx(target, abs=1e-9)
    assert iterate.residual < 1e-9


def test_broadcast_is_the_new_local_trajectory_plus_z_over_beta() -> None:
    before = nadmm.start(np.zeros((2, 3)))
    after = nadmm.full_step(before, np.full((2, 3), 0.5), np.ones((2, 3)), beta=2.0)

    assert after.multiplier == pytest.approx(np.full((2, 3), 0.5 + 2.0))
    assert after.broadcast == pytest.approx(np.full((2, 3), 1.0 + 2.5 / 2.0))


def test_with_lambda_of_one_the_first_broadcast_is_an_extrapolation() -> None:
    start, new = np.zeros((2, 3)), np.ones((2, 3))
    after = nadmm.update(nadmm.start(start), lambda half, told: new, beta=3e-4, relaxation=1.0)

    assert after.broadcast == pytest.approx(2.0 * new - start)


def test_a_period_begins_without_multiplier_and_without_disagreement() -> None:
    iterate = nadmm.start(np.ones((3, 3)))

    assert not iterate.multiplier.any()
    assert iterate.residual == 0.0


# --- the same on a real local problem


def meeting(settings: Settings = HEAD_ON, aside: float = 0.0) -> tuple[Negotiation, list[Neighbour]]:
    """A ship bound east, and another that comes towards it."""
    situation = Situation(
        hull=HULL,
        frame=LINE,
        initial=PathPose(500.0, 0.0, 0.0),
        last_offset=0.0,
        speed=3.0,
        settings=settings,
        offset_limits=np.tile([-60.0, 60.0], (settings.horizon, 1)),
        room=np.tile([-60.0, 60.0], (settings.horizon, 1)),
        last_controls=None,
    )
    other = ConstantVelocity().predict(NedPose(aside, 2300.0, -np.pi / 2), 3.0, settings.horizon, 20.0)
    return negotiate.begin(situation), [Neighbour(HULL, other)]


@pytest.mark.parametrize("relaxation", [0.6, 1.0, 1.4])
def test_negotiation_makes_the_updates_of_eq_13(solver: AbstractLocalSolver, relaxation: float) -> None:
    settings = replace(HEAD_ON, relaxation=relaxation)
    negotiation, neighbours = meeting(settings)
    beta = settings.beta
    p = told = negotiation.iterate.local
    z = np.zeros_like(p)
    for _ in range(settings.iterations):
        problem = negotiate.local_problem(negotiation, neighbours)
        solution = solver.best(problem, negotiate.guesses(negotiation))
        negotiation = negotiate.advance(negotiation, problem, solution)

        z_half = z - beta * (1.0 - relaxation) * (p - told)  # (13a)
        stated: LocalProblem = replace(problem, multiplier=z_half, broadcast=PathTrajectory(told))
        assert problem.multiplier == pytest.approx(z_half, abs=1e-3 * beta)
        assert problem.broadcast.poses == pytest.approx(told, abs=4e-3)
        p = solver.best(stated, [solution.plan.controls]).plan.trajectory.poses  # (13b)
        z = z_half + beta * (p - told)  # (13c)
        told = p + z / beta  # (13d), (A.3)

        assert negotiation.iterate.local == pytest.approx(p, abs=1e-3)  # two runs of a solver [m]
        assert negotiation.iterate.multiplier == pytest.approx(z, abs=1e-3 * beta)
        assert negotiation.iterate.broadcast == pytest.approx(told, abs=4e-3)


def test_difference_of_local_and_broadcast_trajectory_vanishes_with_iterations(
    solver: AbstractLocalSolver,
) -> None:
    negotiation, neighbours = meeting(replace(HEAD_ON, iterations=30), aside=5.0)
    while not negotiation.done:
        problem = negotiate.local_problem(negotiation, neighbours)
        solution = solver.best(problem, negotiate.guesses(negotiation))
        negotiation = negotiate.advance(negotiation, problem, solution)

    assert negotiation.worst is Outcome.CONVERGED
    assert negotiation.residuals[0] > 1.0
    assert negotiation.residuals[-1] < 0.05 * negotiation.residuals[0]


def test_after_the_last_iteration_the_promise_is_the_local_plan(solver: AbstractLocalSolver) -> None:
    negotiation, neighbours = meeting()
    told = []
    while not negotiation.done:
        problem = negotiate.local_problem(negotiation, neighbours)
        solution = solver.best(problem, negotiate.guesses(negotiation))
        negotiation = negotiate.advance(negotiation, problem, solution)
        told.append(LINE.trajectory_to_path(negotiation.told()).poses)
        extrapolated = negotiation.iterate.broadcast
        if not negotiation.done:
            assert told[-1] == pytest.approx(extrapolated, abs=1e-6)

    assert told[-1] == pytest.approx(negotiation.plan.trajectory.poses, abs=1e-6)
    assert np.max(np.abs(told[-1] - extrapolated)) > 1e-3


def test_solution_that_is_not_usable_changes_neither_plan_nor_multiplier(
    solver: AbstractLocalSolver,
) -> None:
    negotiation, neighbours = meeting()
    problem = negotiate.local_problem(negotiation, neighbours)
    solution = replace(solver.best(problem, negotiate.guesses(negotiation)), outcome=Outcome.ITERATION_LIMIT)

    after = negotiate.advance(negotiation, problem, solution)

    assert after.iterate is negotiation.iterate
    assert after.plan is negotiation.plan
    assert (after.iteration, after.usable, after.worst) == (1, False, Outcome.ITERATION_LIMIT)


# --- Theorem 1


@pytest.mark.parametrize("relaxation", [0.0, -0.5, 2.0, 2.5, float("nan")])
def test_lambda_outside_of_zero_to_two_is_refused(relaxation: float) -> None:
    with pytest.raises(ValueError, match=r"lambda must lie in \(0, 2\) \(Theorem 1\)"):
        replace(HEAD_ON, relaxation=relaxation)


@pytest.mark.parametrize("beta", [0.0, -3e-4, float("nan")])
def test_beta_that_is_not_positive_is_refused(beta: float) -> None:
    with pytest.raises(ValueError, match=r"beta must be positive \(Theorem 1\)"):
        replace(HEAD_ON, beta=beta)


@pytest.mark.parametrize("name", ["lambda", "beta"])
def test_scenario_cannot_set_what_theorem_1_refuses(name: str) -> None:
    assert PARAMETERS[name].low > 0.0
    with pytest.raises(ValueError, match=name):
        with_parameter(HEAD_ON, name, 0.0)


def test_first_update_starts_from_all_starts_and_the_next_from_the_plan() -> None:
    settings = replace(HEAD_ON, starts=(Start.LAST, Start.NOMINAL, Start.STARBOARD, Start.SLOW))
    negotiation, _ = meeting(settings)

    assert len(negotiate.guesses(negotiation)) == 3  # there is no last plan
    (guess,) = negotiate.guesses(replace(negotiation, iteration=1))
    assert guess is negotiation.plan.controls
