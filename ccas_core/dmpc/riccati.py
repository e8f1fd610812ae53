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
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import Final

import casadi as ca
import numpy as np

from ..compiling import compiled_module, is_compiled
from ..errors import Diagnostic, InputError
from ..frames import FloatArray, PathPose, PathTrajectory
from . import riccati_kernel as kernel
from .casadi_to_numba import python_source
from .local_problem import LocalPlan, LocalProblem, Solution, free_speeds
from .model import CONSTANTS, CONTROLS, STATES, constants, stage_model
from .outcome import Outcome
from .parameters import Settings
from .risk import COLUMNS
from .solvers import AbstractLocalSolver, Task

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
    functions = [python_source(function) for function in stage_functions()]
    functions += [inspect.getsource(each) for each in vars(kernel).values() if inspect.isfunction(each)]
    numbers = {name: each for name, each in vars(kernel).items() if type(each) in (int, float)}
    try:
        return compiled_module(functions, numbers, [kernel.Task, kernel.Batch])
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

    def prepare(self, tell: Callable[[str], None] | None = None) -> None:
        """Have the loops compiled, or load what an earlier start has compiled."""
        if is_compiled(self.loops, "descend_batch"):
            tell = None
        if tell is not None:
            tell("compiling solver riccati for this machine; that is done once, and takes some seconds")
        began = time.perf_counter()
        none = PathTrajectory(np.zeros((2, 3)))
        self.solve(
            LocalProblem(
                initial=PathPose(0.0, 0.0, 0.0),
                last_offset=0.0,
                speed=1.0,
                settings=Settings(horizon=1),
                offset_limits=np.zeros((1, 2)),
                speed_limits=free_speeds(1),
                threats=np.empty((0, 1, COLUMNS)),
                multiplier=none.poses,
                broadcast=none,
            ),
            np.zeros((1, CONTROLS)),
        )
        if tell is not None:
            tell(f"compiled in {time.perf_counter() - began:.0f} s")

    def solve(self, problem: LocalProblem, guess: FloatArray) -> Solution:
        """Minimise from one guess of the controls, (N, 2)."""
        return self.solve_all(problem, [guess])[0]

    def best(self, problem: LocalProblem, guesses: Iterable[FloatArray]) -> Solution:
        """Minimise from several guesses in one call; the first of equally good answers wins.

        The problem has many minima, because B_1 of Eq. (9) holds small changes back.  So the first guess
        is followed a second time, by way of a problem whose B_1 is `WIDENING` times wider; the answer
        found so comes after all others, and wins if it is better.  A single guess is followed as it is:
        it asks for the minimum next to it, as an iteration of NADMM does that goes on from its own plan.
        """
        return self.choose(self._begin([(problem, tuple(guesses))], widen=True)()[0])

    def begin(self, tasks: Sequence[Task]) -> Callable[[], list[Solution]]:
        """Begin to answer several problems, each as `best` does, on all cores."""
        answers = self._begin(tasks, widen=True)
        return lambda: [self.choose(each) for each in answers()]

    def solve_all(
        self, problem: LocalProblem, guesses: Iterable[FloatArray], *, widen: bool = False
    ) -> list[Solution]:
        """Minimise from each guess, and once more from the first of several if `widen`."""
        return self._begin([(problem, tuple(guesses))], widen=widen)()[0]

    def _begin(self, tasks: Sequence[Task], *, widen: bool) -> Callable[[], list[list[Solution]]]:
        """Begin to find answers from all guesses of each problem; those of one horizon make a batch."""
        horizons: dict[int, list[int]] = {}
        for n, (problem, guesses) in enumerate(tasks):
            horizon = problem.settings.horizon
            for guess in guesses:
                if np.shape(guess) != (horizon, CONTROLS):
                    raise ValueError(f"guesses are {(horizon, CONTROLS)} each, got {np.shape(guess)}")
            horizons.setdefault(horizon, []).append(n)
        batches = [
            (members, _Descent(self, self._batch([tasks[n] for n in members], widen=widen)))
            for members in horizons.values()
        ]

        def answers() -> list[list[Solution]]:
            found: dict[int, list[Solution]] = {}
            for members, descent in batches:
                found |= zip(members, descent.solutions(), strict=True)
            return [found[n] for n in range(len(tasks))]

        return answers

    def _batch(self, tasks: Sequence[Task], *, widen: bool) -> kernel.Batch:
        problems = [problem for problem, _ in tasks]
        guesses = [len(each) for _, each in tasks]
        limits = np.array([(problem.offset_limits, problem.speed_limits) for problem in problems])
        low, high = (np.ascontiguousarray(limits[..., side].transpose(0, 2, 1)) for side in (0, 1))
        anchors = np.empty((*low.shape[:2], 6))
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
            first_answer=_firsts([count + (widen and count > 1) for count in guesses]),
        )


class _Descent:
    """Descents of a batch under way: a small one is made at once, others on threads, in chunks."""

    def __init__(self, solver: Riccati, batch: kernel.Batch) -> None:
        problems, horizon = batch.low.shape[:2]
        answers = int(batch.first_answer[-1])
        self._batch = batch
        self._descend = solver.loops.descend_batch
        self._controls = np.empty((answers, horizon, CONTROLS))
        self._states = np.empty((answers, horizon + 1, STATES))
        self._ends = np.empty((answers, 3))
        self._chunks = _chunks(problems, solver.threads)
        self._spent: Iterable[float] = (
            _pool(solver.threads).map(self._run, self._chunks)
            if len(self._chunks) > 1
            else [self._run(chunk) for chunk in self._chunks]
        )

    def _run(self, chunk: tuple[int, int]) -> float:
        began = time.perf_counter()
        self._descend(self._batch, *chunk, self._controls, self._states, self._ends)
        return time.perf_counter() - began

    def solutions(self) -> list[list[Solution]]:
        """Wait for the answers; each takes its part of the time of its chunk, by iterations."""
        batch, firsts, ends = self._batch, self._batch.first_answer.tolist(), self._ends
        seconds = np.empty(len(ends))
        for (begin, end), spent in zip(self._chunks, self._spent, strict=True):
            rows = slice(firsts[begin], firsts[end])
            effort = ends[rows, 1] + 1.0
            seconds[rows] = spent * effort / np.sum(effort)
        possible = np.all(batch.low <= batch.high, axis=(1, 2))
        answers = [
            Solution(
                plan=LocalPlan(controls=controls, trajectory=PathTrajectory(states[:, :3])),
                objective=value,
                outcome=_ENDS[int(end)],
                iterations=int(iterations),
                seconds=time_spent,
            )
            for controls, states, (value, iterations, end), time_spent in zip(
                self._controls, self._states, ends.tolist(), seconds.tolist(), strict=True
            )
        ]
        return [
            answers[first:last]
            if sound
            else [replace(each, outcome=Outcome.INFEASIBLE) for each in answers[first:last]]
            for first, last, sound in zip(firsts, firsts[1:], possible.tolist(), strict=False)
        ]


def _firsts(counts: Sequence[int]) -> kernel.IntArray:
    """Row at which each begins, and the end."""
    return np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])


def _chunks(problems: int, threads: int) -> list[tuple[int, int]]:
    """Cut problems into runs, a few a thread, for some take longer; small ones are not worth it."""
    size = max(CHUNK, math.ceil(problems / (2 * threads))) if threads > 1 else max(1, problems)
    return [(begin, min(begin + size, problems)) for begin in range(0, problems, size)]


_POOLS: Final[dict[tuple[int, int], ThreadPoolExecutor]] = {}


def _pool(threads: int) -> ThreadPoolExecutor:
    """Threads that are kept; a process that was forked off has none, and gets its own."""
    key = os.getpid(), threads
    if key not in _POOLS:
        _POOLS[key] = ThreadPoolExecutor(threads, thread_name_prefix="riccati")
    return _POOLS[key]
