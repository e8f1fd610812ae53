"""Ways to minimise the local problem (13b): `ipopt`, as the paper, and `fatrop`, by stages.

A third, `riccati`, has a module of its own.  It is the default where numba, which it needs, is installed.

A solver is a resource: it builds a nonlinear programme once for a horizon and a number of threats,
and is then called like a function.  It returns a `Solution` whatever happens.
"""

from __future__ import annotations

import math
import time
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.util import find_spec
from typing import Any, Final, TypeAlias

import casadi as ca
import numpy as np

from ..errors import Diagnostic, InputError, did_you_mean
from ..frames import FloatArray
from .local_problem import LocalPlan, LocalProblem, Solution
from .model import CONTROLS, STATES, constants, objective, stage_model, stage_parameters
from .outcome import Outcome
from .trajectories import rollout

TOLERANCE: Final = 1e-8
_WALL_TIME: Final = 10.0  # of one solve [s]; half a control period
_SAME: Final = 1e-6  # relative difference below which two objectives tie


@dataclass(frozen=True, slots=True)
class _Programme:
    """A built programme, and how its variables are laid out."""

    solve: ca.Function
    pack: Callable[[LocalPlan, float], FloatArray]  # plan, last offset -> guess
    controls: Callable[[FloatArray], FloatArray]  # variables -> (N, 2)
    lower: Callable[[LocalProblem], FloatArray]
    upper: Callable[[LocalProblem], FloatArray]


Task: TypeAlias = tuple[LocalProblem, Sequence[FloatArray]]  # a problem, and guesses of its controls, (N, 2)


class AbstractLocalSolver(ABC):
    """Minimises local problems, from one guess or several; no state that a caller can see."""

    name: str

    def prepare(self, tell: Callable[[str], None] | None = None) -> None:
        """Do what is done once and takes a while, such as compiling; `tell` hears of it if it is done now."""
        del tell

    @abstractmethod
    def solve(self, problem: LocalProblem, guess: FloatArray) -> Solution:
        """Minimise from one guess of the controls, (N, 2)."""

    def best(self, problem: LocalProblem, guesses: Iterable[FloatArray]) -> Solution:
        """Minimise from several guesses; the first of equally good answers wins.

        A usable answer beats one that is not.  Iterations and seconds are those of all starts.
        """
        return self.choose([self.solve(problem, guess) for guess in guesses])

    def begin(self, tasks: Sequence[Task]) -> Callable[[], list[Solution]]:
        """Begin to answer several problems, each as `best` does; what comes back waits for the answers.

        A solver may take them all at once, and go on while its caller does something else.
        """
        return lambda: [self.best(problem, guesses) for problem, guesses in tasks]

    @staticmethod
    def choose(answers: Sequence[Solution]) -> Solution:
        """Choose among the answers from several guesses, as `best` says."""
        best = answers[0]
        for answer in answers[1:]:
            usable, rival = answer.outcome.usable, best.outcome.usable
            if (usable and not rival) or (
                usable is rival and answer.objective < best.objective - _SAME * max(1.0, abs(best.objective))
            ):
                best = answer
        return Solution(
            plan=best.plan,
            objective=best.objective,
            outcome=best.outcome,
            iterations=sum(answer.iterations for answer in answers),
            seconds=sum(answer.seconds for answer in answers),
            message=best.message,
        )


@dataclass(frozen=True, slots=True, eq=False)
class _NlpSolver(AbstractLocalSolver):
    """A programme of CasADi behind the interface; the children only say how to build it."""

    programmes: dict[tuple[int, int], _Programme] = field(default_factory=dict, init=False, repr=False)

    @abstractmethod
    def build(self, horizon: int, threats: int) -> _Programme:
        """Build the programme for a horizon and a number of threats."""

    def solve(self, problem: LocalProblem, guess: FloatArray) -> Solution:
        """Minimise from one guess of the controls, (N, 2)."""
        threats = slots(len(problem.threats))
        key = problem.settings.horizon, threats
        if key not in self.programmes:
            self.programmes[key] = self.build(*key)
        programme = self.programmes[key]
        start = rollout(problem, guess)
        parameters = np.concatenate(
            [
                [problem.initial.x, problem.initial.y, problem.initial.course, problem.last_offset],
                constants(problem),
                stage_parameters(problem, threats).ravel(),
            ]
        )
        guessed = programme.pack(start, problem.last_offset)
        lower, upper = programme.lower(problem), programme.upper(problem)
        if not (np.all(np.isfinite(parameters)) and np.all(np.isfinite(guessed))):
            return _refused(
                problem, start, Outcome.NOT_FINITE, "the problem holds a value that is not finite"
            )
        if np.any(lower > upper):
            return _refused(problem, start, Outcome.INFEASIBLE, "the bounds of the offset leave no room")
        began = time.perf_counter()
        try:
            answer = programme.solve(
                x0=guessed,
                p=parameters,
                lbx=lower,
                ubx=upper,
                lbg=0.0,
                ubg=0.0,
            )
            stats = programme.solve.stats()
            found = np.asarray(answer["x"], dtype=np.float64).ravel()
        except (RuntimeError, ArithmeticError) as error:
            return _refused(problem, start, Outcome.FAILED, str(error), time.perf_counter() - began)
        seconds = time.perf_counter() - began
        return _judged(problem, start, programme.controls(found), stats, seconds)


def _refused(
    problem: LocalProblem, start: LocalPlan, outcome: Outcome, message: str, seconds: float = 0.0
) -> Solution:
    """Give the start back, with the reason why it is not to be sailed."""
    return Solution(
        plan=start,
        objective=objective(problem, start),
        outcome=outcome,
        iterations=0,
        seconds=seconds,
        message=message,
    )


def _judged(
    problem: LocalProblem, start: LocalPlan, controls: FloatArray, stats: dict[str, Any], seconds: float
) -> Solution:
    """Read a solver's report; the plan is sailed anew, so that it keeps Eq. (4) and the bounds exactly."""
    message = str(stats.get("return_status", stats.get("unified_return_status", "")))
    iterations = int(stats.get("iter_count", 0))
    if not np.all(np.isfinite(controls)):
        outcome, plan, value = Outcome.NOT_FINITE, start, objective(problem, start)
    else:
        plan = rollout(problem, controls)
        value = objective(problem, plan)
        outcome = _outcome(message, success=bool(stats.get("success", False)))
        if not math.isfinite(value):
            outcome = Outcome.NOT_FINITE
    return Solution(
        plan=plan, objective=value, outcome=outcome, iterations=iterations, seconds=seconds, message=message
    )


def _outcome(message: str, *, success: bool) -> Outcome:
    if success:
        return Outcome.CONVERGED
    words = message.lower()
    if "infeasible" in words or "restoration" in words:
        return Outcome.INFEASIBLE
    if "nan" in words or "invalid_number" in words:
        return Outcome.NOT_FINITE
    if "exceeded" in words or "limit" in words or "max" in words:
        return Outcome.ITERATION_LIMIT
    return Outcome.FAILED


@dataclass(frozen=True, slots=True, eq=False)
class Ipopt(_NlpSolver):
    """Multiple shooting and IPOPT, as the paper: all poses and controls are variables."""

    name: str = "ipopt"

    def build(self, horizon: int, threats: int) -> _Programme:
        """Variables: poses (3 N), then controls (2 N); the initial pose is a parameter."""
        model, initial, fixed, stages, parameters = _parameters(horizon, threats)
        poses = ca.SX.sym("poses", 3, horizon)
        controls = ca.SX.sym("controls", CONTROLS, horizon)
        value, gaps, state = ca.SX(0), [], initial
        for k in range(horizon):
            value += model.control_cost(state, controls[:, k], fixed)
            sailed = model.dynamics(state, controls[:, k], fixed)
            gaps.append(sailed[:3] - poses[:, k])
            state = ca.vertcat(poses[:, k], controls[0, k])
            value += model.state_cost(state, stages[:, k], fixed)
        variables = ca.vertcat(ca.vec(poses), ca.vec(controls))
        options: dict[str, Any] = {
            "expand": False,
            "print_time": False,
            "error_on_fail": False,
            "ipopt": {
                "print_level": 0,
                "sb": "yes",
                "tol": TOLERANCE,
                "max_iter": 300,
                "max_wall_time": _WALL_TIME,
            },
        }
        programme = {"x": variables, "f": value, "g": ca.vertcat(*gaps), "p": parameters}
        free = np.full(3 * horizon, np.inf)

        def bound(problem: LocalProblem, side: int) -> FloatArray:
            pairs = np.column_stack([problem.offset_limits[:, side], problem.speed_limits[:, side]])
            return np.concatenate([free if side else -free, pairs.ravel()])

        return _Programme(
            solve=ca.nlpsol("local_problem", "ipopt", programme, options),
            pack=lambda plan, _: np.concatenate([plan.trajectory.poses[1:].ravel(), plan.controls.ravel()]),
            controls=lambda found: found[3 * horizon :].reshape(horizon, CONTROLS),
            lower=lambda problem: bound(problem, 0),
            upper=lambda problem: bound(problem, 1),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Fatrop(_NlpSolver):
    """Optimal control by stages and FATROP: the last offset is a fourth state.

    Without that state, (8) and (9) couple neighbouring stages, and the solver's structure, which is
    that of a Riccati recursion, does not hold.
    """

    name: str = "fatrop"

    def build(self, horizon: int, threats: int) -> _Programme:
        """Variables by stage: state, control, state, control, ..., state."""
        model, initial, fixed, stages, parameters = _parameters(horizon, threats)
        states = [ca.SX.sym(f"state_{k}", STATES) for k in range(horizon + 1)]
        controls = [ca.SX.sym(f"control_{k}", CONTROLS) for k in range(horizon)]
        value, constraints = ca.SX(0), []
        variables = []
        for k in range(horizon):
            value += model.control_cost(states[k], controls[k], fixed)
            value += model.state_cost(states[k + 1], stages[:, k], fixed)
            constraints.append(states[k + 1] - model.dynamics(states[k], controls[k], fixed))
            if k == 0:
                constraints.append(states[0] - initial)
            variables += [states[k], controls[k]]
        variables.append(states[horizon])
        count = sum(part.numel() for part in constraints)
        options: dict[str, Any] = {
            "expand": False,
            "print_time": False,
            "error_on_fail": False,
            "structure_detection": "auto",
            "equality": [True] * count,
            "fatrop": {"print_level": 0, "tol": TOLERANCE, "max_iter": 300},
        }
        programme = {
            "x": ca.vertcat(*variables),
            "f": value,
            "g": ca.vertcat(*constraints),
            "p": parameters,
        }

        def pack(plan: LocalPlan, last_offset: float) -> FloatArray:
            last = np.concatenate([[last_offset], plan.controls[:, 0]])
            rows = np.column_stack([plan.trajectory.poses, last])
            body = np.hstack([rows[:-1], plan.controls]).ravel()
            return np.concatenate([body, rows[-1]])

        def bound(problem: LocalProblem, side: int) -> FloatArray:
            free = np.full((horizon, STATES), np.inf if side else -np.inf)
            rows = np.hstack([free, problem.offset_limits[:, [side]], problem.speed_limits[:, [side]]])
            return np.concatenate([rows.ravel(), free[0]])

        def controls_of(found: FloatArray) -> FloatArray:
            return found[: horizon * (STATES + CONTROLS)].reshape(horizon, STATES + CONTROLS)[:, STATES:]

        return _Programme(
            solve=ca.nlpsol("local_problem", "fatrop", programme, options),
            pack=pack,
            controls=controls_of,
            lower=lambda problem: bound(problem, 0),
            upper=lambda problem: bound(problem, 1),
        )


def _parameters(horizon: int, threats: int) -> tuple[Any, ca.SX, ca.SX, ca.SX, ca.SX]:
    """Model, and the parameters of a programme: initial state, constants, stages (one a column)."""
    model = stage_model(threats)
    initial = ca.SX.sym("initial", STATES)
    fixed = ca.SX.sym("constants", model.constants)
    stages = ca.SX.sym("stages", model.stage_parameters, horizon)
    return model, initial, fixed, stages, ca.vertcat(initial, fixed, ca.vec(stages))


class Recorder(AbstractLocalSolver):
    """A solver that keeps what it is asked, and has another one answer."""

    def __init__(self, inner: AbstractLocalSolver) -> None:
        self.name = inner.name
        self.tasks: list[Task] = []
        self._inner = inner

    def solve(self, problem: LocalProblem, guess: FloatArray) -> Solution:
        """Keep a problem with its guess, and have it solved."""
        self.tasks.append((problem, (guess,)))
        return self._inner.solve(problem, guess)

    def best(self, problem: LocalProblem, guesses: Iterable[FloatArray]) -> Solution:
        """Keep a problem with all its guesses, and have it solved."""
        known = tuple(guesses)
        self.tasks.append((problem, known))
        return self._inner.best(problem, known)


def slots(threats: int) -> int:
    """Number of threats that a programme is built for: the next power of two.

    >>> [slots(n) for n in (0, 1, 3, 5)]
    [1, 1, 4, 8]
    """
    return 1 << max(0, threats - 1).bit_length()


def _riccati() -> AbstractLocalSolver:
    from .riccati import Riccati  # imports numba

    return Riccati()


SOLVERS: Final[dict[str, Callable[[], AbstractLocalSolver]]] = {
    "fatrop": Fatrop,
    "ipopt": Ipopt,
    "riccati": _riccati,
}
FASTEST: Final = "riccati"
WITHOUT_NUMBA: Final = "fatrop"


@cache
def default_solver() -> str:
    """Name of the fastest solver that can be used here; that it is not the fastest of all is told once."""
    if find_spec("numba") is not None:
        return FASTEST
    warnings.warn(
        f"numba is not installed: solver {WITHOUT_NUMBA!r} stands in for {FASTEST!r}, which is tens of times "
        "faster; `pip install numba` brings it",
        RuntimeWarning,
        stacklevel=2,
    )
    return WITHOUT_NUMBA


def make_solver(name: str | None = None) -> AbstractLocalSolver:
    """Make a solver by its name, or the default one; `InputError` where there is none of that name."""
    if name is None:
        name = default_solver()
    if name not in SOLVERS:
        raise InputError(
            Diagnostic(source="solver", message=f"unknown solver {name!r}", hint=did_you_mean(name, SOLVERS))
        )
    return SOLVERS[name]()
