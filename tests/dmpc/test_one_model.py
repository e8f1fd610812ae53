"""One model: three solvers minimise one function, and a formula that changes does so for all."""

from __future__ import annotations

import inspect
import math
from dataclasses import replace
from types import FunctionType, ModuleType

import casadi as ca
import numpy as np
import pytest

from ccas_core.dmpc import cost, riccati_kernel
from ccas_core.dmpc.casadi_to_numba import python_source
from ccas_core.dmpc.local_problem import LocalPlan, LocalProblem
from ccas_core.dmpc.model import CONTROLS, STATES, constants, stage_model, stage_parameters
from ccas_core.dmpc.riccati import Riccati, stage_functions
from ccas_core.dmpc.solvers import Fatrop, Ipopt, slots
from ccas_core.dmpc.trajectories import rollout
from ccas_core.frames import FloatArray

from .problems import random_problem

EXACT = 1e-12  # relative


def _random(seed: int, horizon: int = 12) -> tuple[LocalProblem, LocalPlan]:
    """Make a problem, and a plan that is nobody's answer."""
    generator = np.random.default_rng(seed)
    problem = random_problem(generator)
    problem = replace(
        problem,
        settings=replace(problem.settings, horizon=horizon),
        offset_limits=problem.offset_limits[:horizon],
        speed_limits=problem.speed_limits[:horizon],
        threats=problem.threats[:, :horizon],
        multiplier=generator.normal(0.0, 1e-2, (horizon + 1, 3)),
        broadcast=replace(problem.broadcast, poses=problem.broadcast.poses[: horizon + 1]),
    )
    controls = np.column_stack(
        [generator.uniform(-40.0, 40.0, horizon), generator.uniform(0.0, 1.0, horizon)]
    )
    return problem, rollout(problem, controls)


def _programme(
    kind: type[Ipopt | Fatrop], problem: LocalProblem, plan: LocalPlan
) -> tuple[float, FloatArray]:
    """Objective and gradient by the controls (N, 2) of a programme, at a plan; its constraints hold there."""
    horizon, threats = len(plan.controls), slots(len(problem.threats))
    built = kind().build(horizon, threats)
    start = problem.initial
    parameters = np.concatenate(
        [
            [start.x, start.y, start.course, problem.last_offset],
            constants(problem),
            stage_parameters(problem, threats).ravel(),
        ]
    )
    oracle = built.solve.oracle()
    point = built.pack(plan, problem.last_offset)
    there = oracle(x=point, p=parameters)
    assert float(ca.mmax(ca.fabs(there["g"]))) < 1e-10  # [m]; positions are up to 3 km
    slopes = oracle.factory("slopes", ["x", "p"], ["grad:f:x", "jac:g:x"])
    slope, jacobian = (np.asarray(ca.densify(each)) for each in slopes(point, parameters))
    places = built.controls(np.arange(len(point), dtype=float)).astype(int)  # of the controls
    others = np.setdiff1d(np.arange(len(point)), places)
    adjoint = np.linalg.solve(jacobian[:, others].T, slope[others, 0])
    reduced = slope[places.ravel(), 0] - jacobian[:, places.ravel()].T @ adjoint
    return float(there["f"]), reduced.reshape(horizon, CONTROLS)


def _loops(loops: ModuleType, problem: LocalProblem, plan: LocalPlan) -> tuple[float, FloatArray]:
    """The same of the loops of `riccati`."""
    horizon = len(plan.controls)
    start = problem.initial
    task = riccati_kernel.Task(
        start=np.array([start.x, start.y, start.course, problem.last_offset]),
        low=np.column_stack([problem.offset_limits[:, 0], np.zeros(horizon)]),
        high=np.column_stack([problem.offset_limits[:, 1], np.ones(horizon)]),
        constants=constants(problem),
        anchors=np.hstack([problem.multiplier[1:], problem.broadcast.poses[1:]]),
        threats=np.array(problem.threats),
    )
    states, same = np.zeros((horizon + 1, STATES)), np.empty((horizon, CONTROLS))
    states[0] = task.start
    sailed, step, gain = np.empty_like(states), np.zeros((horizon, 2)), np.zeros((horizon, 2, 4))
    value = loops.sail(task, plan.controls, states, step, gain, 0.0, same, sailed, np.empty(1))
    costate, gradient = np.zeros(4), np.empty((horizon, CONTROLS))
    unused, table = np.zeros(4), np.zeros((4, 4))
    for k in range(horizon - 1, -1, -1):
        togo = np.zeros(4), np.zeros((4, 4)), costate
        loops.add_closeness(sailed[k + 1], task.anchors[k], task.constants, *togo, *togo)
        for threat in task.threats:
            loops.add_risk(sailed[k + 1], threat[k], *togo, *togo)
        before = np.empty(4)
        loops.expand(
            sailed[k], plan.controls[k], task.constants, *togo,
            unused, np.zeros(2), table, np.zeros((2, 4)), np.zeros((2, 2)), before, gradient[k],
        )  # fmt: skip
        costate = before
    return value, gradient


def _interpreted() -> ModuleType:
    """The loops of `riccati` as Python runs them, made anew from the model."""
    module = ModuleType("interpreted")
    names = vars(module)
    names |= {"math": math, "np": np}
    for function in stage_functions():
        exec(python_source(function), names)  # noqa: S102
    for name, routine in vars(riccati_kernel).items():
        if inspect.isfunction(routine):
            names[name] = FunctionType(routine.__code__, names)
    return module


@pytest.fixture(scope="module")
def loops() -> ModuleType:
    pytest.importorskip("numba")
    return Riccati().loops


@pytest.mark.parametrize("seed", range(4))
def test_three_solvers_have_one_objective_and_one_gradient(seed: int, loops: ModuleType) -> None:
    problem, plan = _random(100 + seed)
    (ipopt, slope), (fatrop, same_slope), (riccati, other_slope) = (
        _programme(Ipopt, problem, plan),
        _programme(Fatrop, problem, plan),
        _loops(loops, problem, plan),
    )
    steepest = np.max(np.abs(slope))

    assert fatrop == pytest.approx(ipopt, rel=EXACT)
    assert riccati == pytest.approx(ipopt, rel=EXACT)
    assert np.max(np.abs(same_slope - slope)) < EXACT * steepest
    assert np.max(np.abs(other_slope - slope)) < EXACT * steepest


def _all_three(problem: LocalProblem, plan: LocalPlan) -> FloatArray:
    """Objectives of programmes and loops made anew from the model."""
    stage_model.cache_clear()
    ways = (_programme(Ipopt, problem, plan), _programme(Fatrop, problem, plan))
    return np.array([value for value, _ in (*ways, _loops(_interpreted(), problem, plan))])


def test_a_formula_that_changes_changes_for_all_three(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, plan = _random(200)
    effort = cost.control_effort

    def dearer(offset: ca.SX, last: ca.SX, speed_factor: ca.SX, K_y: ca.SX, K_s: ca.SX) -> ca.SX:
        return effort(offset, last, speed_factor, K_y, K_s) + (1.0 - speed_factor)

    before = _all_three(problem, plan)
    monkeypatch.setattr(cost, "control_effort", dearer)
    after = _all_three(problem, plan)
    stage_model.cache_clear()

    assert after - before == pytest.approx(np.full(3, np.sum(1.0 - plan.controls[:, 1])), rel=1e-9)
