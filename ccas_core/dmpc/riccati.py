"""A fast way to minimise the local problem (13b): `riccati`, compiled, tens of times faster than `fatrop`.

Differential dynamic programming with control limits (Tassa, Mansard and Todorov 2014,
doi 10.1109/ICRA.2014.6907001).  A sweep back over the stages makes a quadratic model of the cost to
go, with exact second derivatives of cost and dynamics, and gives each control a step and a feedback;
a sweep forward sails them, so that every iterate is a plan that can be sailed and keeps its bounds.
The formulas are those of `model`, translated by `casadi_to_numba`; the loops stand in `riccati_kernel`.
"""

from __future__ import annotations

import inspect
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from types import ModuleType
from typing import Final

import casadi as ca
import numpy as np

from ..errors import Diagnostic, InputError
from ..frames import FloatArray, PathTrajectory
from . import riccati_kernel as kernel
from .casadi_to_numba import compiled_module
from .local_problem import LocalPlan, LocalProblem, Solution
from .model import CONSTANTS, CONTROLS, STATES, constants, stage_model
from .outcome import Outcome
from .risk import COLUMNS
from .solvers import AbstractLocalSolver

WIDENING: Final = 10.0  # of B_1, on the way to further answers
_ENDS: Final = {
    kernel.CONVERGED: Outcome.CONVERGED,
    kernel.LIMIT: Outcome.ITERATION_LIMIT,
    kernel.NOT_FINITE: Outcome.NOT_FINITE,
    kernel.STALLED: Outcome.FAILED,
}


def stage_functions() -> tuple[ca.Function, ...]:
    """Make the functions of a stage that the loops call, from `model.stage_model`.

    `advance` sails a stage and costs it; `closeness` and `risk` are those of the model.  Backwards,
    `add_closeness` and `add_risk` add derivatives of the state's cost to those of the cost to go,
    and `expand` takes these through the dynamics.  The costate is the exact gradient of the
    objective by the state; with it the gradient by the control is exact as well.
    """
    model = stage_model(1)
    state, control = ca.SX.sym("state", STATES), ca.SX.sym("control", CONTROLS)
    fixed = ca.SX.sym("constants", model.constants)
    slope, table = ca.SX.sym("V_x", STATES), ca.SX.sym("V_xx", STATES, STATES)
    costate = ca.SX.sym("costate", STATES)
    togo = [slope, table, costate]
    bend = _symmetric(table)
    after, effort = model.dynamics(state, control, fixed), model.control_cost(state, control, fixed)

    def added(name: str, cost: ca.SX, inputs: list[ca.SX]) -> ca.Function:
        hessian, gradient = ca.hessian(cost, state)
        sums = [slope + gradient, _symmetric(bend + hessian), costate + gradient]
        return _function(name, [*inputs, *togo], sums)

    anchor, threat = ca.SX.sym("anchor", 6), ca.SX.sym("threat", COLUMNS)
    near, danger = model.closeness(state, anchor, fixed), model.risk(state, threat)

    both = ca.vertcat(state, control)
    by_both = ca.jacobian(after, both)
    curved, effort_by_both = ca.hessian(effort + ca.dot(slope, after), both)
    Q = _symmetric(curved + by_both.T @ bend @ by_both)
    Q_1 = effort_by_both
    exact = ca.gradient(effort + ca.dot(costate, after), both)
    x, u = slice(0, STATES), slice(STATES, STATES + CONTROLS)
    return (
        _function("advance", [state, control, fixed], [after, effort]),
        _function("closeness", [state, anchor, fixed], [near]),
        _function("risk", [state, threat], [danger]),
        added("add_closeness", near, [state, anchor, fixed]),
        added("add_risk", danger, [state, threat]),
        _function(
            "expand",
            [state, control, fixed, *togo],
            [Q_1[x], Q_1[u], Q[x, x], Q[u, x], Q[u, u], exact[x], exact[u]],
        ),
    )


def _symmetric(matrix: ca.SX) -> ca.SX:
    """Take the upper half for both; nothing is then computed twice."""
    return ca.triu2symm(ca.triu(matrix))


def _function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
    return ca.Function(name, inputs, outputs, {"cse": True})


def compiled() -> ModuleType:
    """Compile the solver, or load what an earlier start has compiled."""
    routines = [each for each in vars(kernel).values() if inspect.isfunction(each)]
    numbers = {name: each for name, each in vars(kernel).items() if type(each) in (int, float)}
    try:
        return compiled_module(stage_functions(), routines, numbers)
    except ImportError as error:
        raise InputError(
            Diagnostic(
                source="solver",
                message=f"solver 'riccati' cannot be used: {error}",
                hint="install numba (`pip install numba`), or choose solver 'fatrop'",
            )
        ) from error


def _widening() -> FloatArray:
    """Factors of the constants that widen B_1."""
    return np.array([WIDENING if name in {"gamma_s", "gamma_y"} else 1.0 for name in CONSTANTS])


@dataclass(frozen=True, slots=True, eq=False)
class Riccati(AbstractLocalSolver):
    """Differential dynamic programming with control limits, for any horizon and number of threats.

    Notes
    -----
    Each answer is a minimum near its guess; no solver here finds the least of all for certain.
    """

    name: str = "riccati"
    loops: ModuleType = field(default_factory=compiled, init=False, repr=False)
    widening: FloatArray = field(default_factory=_widening, init=False, repr=False)

    def solve(self, problem: LocalProblem, guess: FloatArray) -> Solution:
        """Minimise from one guess of the controls, (N, 2)."""
        return self.solve_all(problem, [guess])[0]

    def best(self, problem: LocalProblem, guesses: Iterable[FloatArray]) -> Solution:
        """Minimise from several guesses in one call; the first of equally good answers wins.

        The problem has many minima, because B_1 of Eq. (9) holds small changes back.  So each guess
        is followed a second time by way of a problem whose B_1 is `WIDENING` times wider; answers
        found so come after all others, and win if they are better.  A single guess is followed as it is:
        it asks for the minimum next to it, as an iteration of NADMM does that goes on from its own plan.
        """
        starts = tuple(guesses)
        return self.choose(self.solve_all(problem, starts, widen=len(starts) > 1))

    def solve_all(
        self, problem: LocalProblem, guesses: Iterable[FloatArray], *, widen: bool = False
    ) -> list[Solution]:
        """Minimise from each guess, and once more from each if `widen`; each took its part of the time."""
        began = time.perf_counter()
        starts = np.array(list(guesses), dtype=np.float64)
        horizon = problem.settings.horizon
        if starts.shape[1:] != (horizon, CONTROLS):
            raise ValueError(f"guesses are {(horizon, CONTROLS)} each, got {starts.shape[1:]}")
        answers = len(starts) * (2 if widen else 1)
        low, high = (
            np.column_stack([problem.offset_limits[:, side], problem.speed_limits[:, side]])
            for side in (0, 1)
        )
        initial = problem.initial
        task = kernel.Task(
            start=np.array([initial.x, initial.y, initial.course, problem.last_offset], dtype=np.float64),
            low=low,
            high=high,
            constants=constants(problem),
            anchors=np.hstack([problem.multiplier[1:], problem.broadcast.poses[1:]]),
            threats=np.array(problem.threats, order="C"),
        )
        controls = np.empty((answers, horizon, CONTROLS))
        states = np.empty((answers, horizon + 1, STATES))
        ends = np.empty((answers, 3))
        widened = task._replace(constants=task.constants * self.widening)
        self.loops.descend_all(task, widened, starts, controls, states, ends)
        possible = bool(np.all(low <= high))
        seconds = (time.perf_counter() - began) / answers
        solutions = []
        for plan, path, (value, iterations, end) in zip(controls, states, ends, strict=True):
            outcome = _ENDS[int(end)] if possible else Outcome.INFEASIBLE
            solutions.append(
                Solution(
                    plan=LocalPlan(controls=plan, trajectory=PathTrajectory(path[:, :3])),
                    objective=float(value),
                    outcome=outcome,
                    iterations=int(iterations),
                    seconds=seconds,
                )
            )
        return solutions
