"""A fast way to minimise the local problem (13b): `riccati`, compiled, tens of times faster than `fatrop`.

Differential dynamic programming with control limits (Tassa, Mansard and Todorov 2014,
doi 10.1109/ICRA.2014.6907001).  A sweep back over the stages makes a quadratic model of the cost to
go, with exact second derivatives of cost and dynamics, and gives each control a step and a feedback;
a sweep forward sails them, so that every iterate is a plan that can be sailed and keeps its bounds.
The formulas are those of `model`, translated by `casadi_to_numba`; the loops stand in `riccati_kernel`.
"""

from __future__ import annotations

import inspect
import math
import os
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
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
CHUNK: Final = 8  # problems that are worth a thread
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
        return compiled_module(stage_functions(), routines, numbers, [kernel.Task, kernel.Batch])
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


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Riccati(AbstractLocalSolver):
    """Differential dynamic programming with control limits, for any horizon and number of threats.

    Parameters
    ----------
    threads
        How many problems are solved at the same time, where there are many; as many as this process
        has cores, unless given.  Answers do not depend on it.

    Notes
    -----
    Each answer is a minimum near its guess; no solver here finds the least of all for certain.
    """

    name: str = "riccati"
    threads: int = field(default_factory=cores)
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
        return self.best_of_each([(problem, tuple(guesses))])[0]

    def best_of_each(self, tasks: Sequence[tuple[LocalProblem, Sequence[FloatArray]]]) -> list[Solution]:
        """Answer several problems at once, on all cores."""
        return [self.choose(answers) for answers in self._answers(tasks, widen=True)]

    def solve_all(
        self, problem: LocalProblem, guesses: Iterable[FloatArray], *, widen: bool = False
    ) -> list[Solution]:
        """Minimise from each guess, and once more from each of several if `widen`."""
        return self._answers([(problem, tuple(guesses))], widen=widen)[0]

    def _answers(
        self, tasks: Sequence[tuple[LocalProblem, Sequence[FloatArray]]], *, widen: bool
    ) -> list[list[Solution]]:
        """Answers from all guesses of each problem; problems of one horizon make a batch."""
        horizons: dict[int, list[int]] = {}
        for n, (problem, guesses) in enumerate(tasks):
            horizon = problem.settings.horizon
            for guess in guesses:
                if np.shape(guess) != (horizon, CONTROLS):
                    raise ValueError(f"guesses are {(horizon, CONTROLS)} each, got {np.shape(guess)}")
            horizons.setdefault(horizon, []).append(n)
        found: dict[int, list[Solution]] = {}
        for members in horizons.values():
            batch = self._batch([tasks[n] for n in members], widen=widen)
            found |= zip(members, self._descended([tasks[n][0] for n in members], batch), strict=True)
        return [found[n] for n in range(len(tasks))]

    def _batch(
        self, tasks: Sequence[tuple[LocalProblem, Sequence[FloatArray]]], *, widen: bool
    ) -> kernel.Batch:
        problems = [problem for problem, _ in tasks]
        guesses = [len(each) for _, each in tasks]
        limits = np.array([problem.offset_limits for problem in problems])
        low, high = np.zeros_like(limits), np.ones_like(limits)
        low[:, :, 0], high[:, :, 0] = limits[:, :, 0], limits[:, :, 1]
        anchors = np.empty((*limits.shape[:2], 6))
        anchors[:, :, :3] = [problem.multiplier[1:] for problem in problems]
        anchors[:, :, 3:] = [problem.broadcast.poses[1:] for problem in problems]
        starts = [(p.initial.x, p.initial.y, p.initial.course, p.last_offset) for p in problems]
        return self.loops.Batch(  # type: ignore[no-any-return]  # the same class, of the compiled module
            start=np.array(starts, dtype=np.float64),
            low=low,
            high=high,
            constants=np.array([constants(problem) for problem in problems]),
            widening=self.widening,
            anchors=anchors,
            threats=np.concatenate([problem.threats for problem in problems]),
            first_threat=_firsts([len(problem.threats) for problem in problems]),
            guesses=np.array([guess for _, each in tasks for guess in each], dtype=np.float64),
            first_guess=_firsts(guesses),
            first_answer=_firsts([2 * count if widen and count > 1 else count for count in guesses]),
        )

    def _descended(self, problems: Sequence[LocalProblem], batch: kernel.Batch) -> list[list[Solution]]:
        """Run the loops, in chunks on several threads; a problem takes its part of the time of its chunk."""
        horizon, answers = batch.low.shape[1], int(batch.first_answer[-1])
        controls = np.empty((answers, horizon, CONTROLS))
        states = np.empty((answers, horizon + 1, STATES))
        ends = np.empty((answers, 3))

        def descend(chunk: tuple[int, int]) -> float:
            began = time.perf_counter()
            self.loops.descend_batch(batch, *chunk, controls, states, ends)
            return time.perf_counter() - began

        chunks = _chunks(len(problems), self.threads)
        spent = [descend(chunks[0])] if len(chunks) == 1 else _pool(self.threads).map(descend, chunks)
        seconds = np.empty(answers)
        for (begin, end), time_spent in zip(chunks, spent, strict=True):
            rows = slice(batch.first_answer[begin], batch.first_answer[end])
            effort = ends[rows, 1] + 1.0  # iterations
            seconds[rows] = time_spent * effort / np.sum(effort)
        possible = np.all(batch.low <= batch.high, axis=(1, 2))
        found = []
        for b in range(len(problems)):
            rows = range(int(batch.first_answer[b]), int(batch.first_answer[b + 1]))
            found.append(
                [
                    Solution(
                        plan=LocalPlan(controls=controls[n], trajectory=PathTrajectory(states[n, :, :3])),
                        objective=float(ends[n, 0]),
                        outcome=_ENDS[int(ends[n, 2])] if possible[b] else Outcome.INFEASIBLE,
                        iterations=int(ends[n, 1]),
                        seconds=float(seconds[n]),
                    )
                    for n in rows
                ]
            )
        return found


def _firsts(counts: Sequence[int]) -> kernel.IntArray:
    """Row at which each begins, and the end."""
    return np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])


def _chunks(problems: int, threads: int) -> list[tuple[int, int]]:
    """Cut problems into runs, a few a thread, for some take longer; none is smaller than `CHUNK` but the last."""
    size = max(CHUNK, math.ceil(problems / (4 * threads))) if threads > 1 else max(1, problems)
    return [(begin, min(begin + size, problems)) for begin in range(0, problems, size)]


_POOLS: Final[dict[tuple[int, int], ThreadPoolExecutor]] = {}


def _pool(threads: int) -> ThreadPoolExecutor:
    """Threads that are kept; a process that was forked off has none, and gets its own."""
    key = os.getpid(), threads
    if key not in _POOLS:
        _POOLS[key] = ThreadPoolExecutor(threads, thread_name_prefix="riccati")
    return _POOLS[key]
