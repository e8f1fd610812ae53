"""The centralised baseline: one joint problem for all ships, by the same model, solved at once.

The sum of all ships' costs, with every ship's controls free: what could be reached if one mind steered all.
Ellipses of the risk lie along the guiding lines, which must be straight.  IPOPT finds a minimum near each
guess; the best counts.  It is a measure for the distributed answer, not a way to sail.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import casadi as ca
import numpy as np

from ..frames import FloatArray, PathFrame, PathPose, PathTrajectory
from ..ships import Hull
from .local_problem import LocalProblem, free_speeds
from .model import CONTROLS, STATES, constants, stage_model
from .parameters import Settings
from .risk import collision_risk, threat

_ITERATIONS: Final = 500  # of one solve; a limit in seconds would let the answer depend on the machine


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class JointShip:
    """One ship of the joint problem."""

    hull: Hull
    frame: PathFrame  # straight
    initial: PathPose
    speed: float  # nominal, U^d [m/s]
    offset_limits: FloatArray  # (N, 2) [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class JointAnswer:
    """Controls of all ships, where they lead, and what they cost together."""

    controls: FloatArray  # (ships, N, 2)
    paths: FloatArray  # (ships, N + 1, 3), each in its own frame
    objective: float
    converged: bool


def solve_jointly(
    ships: Sequence[JointShip], settings: Settings, guesses: Sequence[FloatArray]
) -> JointAnswer:
    """Minimise the joint cost from several guesses (ships, N, 2), and return the best answer."""
    if not all(ship.frame.is_straight for ship in ships):
        raise ValueError("the joint problem is stated for straight guiding lines")
    horizon = settings.horizon
    symbols = [ca.SX.sym(f"u_{n}", CONTROLS, horizon) for n in range(len(ships))]
    states = [ca.SX.sym(f"x_{n}", STATES, horizon) for n in range(len(ships))]
    value, gaps = _programme(ships, settings, symbols, states)
    variables = ca.vertcat(*(ca.vertcat(ca.vec(x), ca.vec(u)) for x, u in zip(states, symbols, strict=True)))
    options: dict[str, Any] = {
        "print_time": False,
        "error_on_fail": False,
        "ipopt": {"print_level": 0, "sb": "yes", "max_iter": _ITERATIONS},
    }
    solve = ca.nlpsol("joint", "ipopt", {"x": variables, "f": value, "g": gaps}, options)
    bounds = [_bounds(ship, horizon, side) for side in (0, 1) for ship in ships]
    lower, upper = np.concatenate(bounds[: len(ships)]), np.concatenate(bounds[len(ships) :])
    best: JointAnswer | None = None
    for guess in guesses:
        found = solve(
            x0=np.concatenate([_packed(s, settings, u) for s, u in zip(ships, guess, strict=True)]),
            lbx=lower,
            ubx=upper,
            lbg=0.0,
            ubg=0.0,
        )
        flat = np.asarray(found["x"], dtype=np.float64).ravel().reshape(len(ships), -1)
        controls = flat[:, STATES * horizon :].reshape(len(ships), horizon, CONTROLS)
        answer = joint_cost(ships, settings, controls, converged=bool(solve.stats()["success"]))
        if best is None or answer.objective < best.objective:
            best = answer
    if best is None:
        raise ValueError("the joint problem needs a guess")
    return best


def joint_cost(
    ships: Sequence[JointShip], settings: Settings, controls: FloatArray, *, converged: bool = True
) -> JointAnswer:
    """Sail the controls of all ships, held within their bounds, and sum up what they cost."""
    clipped = np.stack(
        [
            np.column_stack([np.clip(u[:, 0], *ship.offset_limits.T), np.clip(u[:, 1], 0.0, 1.0)])
            for ship, u in zip(ships, controls, strict=True)
        ]
    )
    horizon = settings.horizon
    paths = [_sailed(ship, settings, u) for ship, u in zip(ships, clipped, strict=True)]
    symbols = [ca.DM(u.T) for u in clipped]
    states = [ca.DM(path[1:].T) for path in paths]
    value, _ = _programme(ships, settings, symbols, states)
    return JointAnswer(
        controls=clipped,
        paths=np.stack([path[:, :3] for path in paths]).reshape(len(ships), horizon + 1, 3),
        objective=float(value),
        converged=converged,
    )


def _programme(
    ships: Sequence[JointShip], settings: Settings, controls: Sequence[Any], states: Sequence[Any]
) -> tuple[Any, Any]:
    """Joint cost, and the gaps of the dynamics, of symbols or numbers: (4, N) and (2, N) a ship."""
    model, horizon = stage_model(1), settings.horizon
    value: Any = 0.0
    gaps = []
    for ship, u, x in zip(ships, controls, states, strict=True):
        fixed = constants(_problem(ship, settings))
        state: Any = ca.DM([ship.initial.x, ship.initial.y, ship.initial.course, 0.0])
        for k in range(horizon):
            value += model.control_cost(state, u[:, k], fixed)
            gaps.append(model.dynamics(state, u[:, k], fixed) - x[:, k])
            state = x[:, k]
    for n, own in enumerate(ships):
        for m, other in enumerate(ships):
            if n != m:
                value += _risk(own, other, settings, states[n], states[m])
    return value, ca.vertcat(*gaps)


def _risk(own: JointShip, other: JointShip, settings: Settings, here: Any, there: Any) -> Any:  # noqa: ANN401
    """Risk of one ship towards another over the horizon, with both positions free."""
    horizon = settings.horizon
    step = settings.kinematics.time_step
    along = np.zeros((horizon + 1, 3))
    along[:, 0] = other.initial.x + other.speed * step * np.arange(horizon + 1)
    nominal = own.frame.trajectory_to_path(other.frame.trajectory_to_ned(PathTrajectory(along)))
    rows = threat(own.hull, other.hull, nominal, settings.risk, settings.weights, own.speed * step)
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    seen = own.frame.trajectory_to_path(other.frame.trajectory_to_ned(PathTrajectory(corners))).poses[:, :2]
    origin, turn = seen[0], (seen[1:] - seen[0]).T  # affine, for both lines are straight
    value: Any = 0.0
    for k in range(horizon):
        dx = here[0, k] - (origin[0] + turn[0, 0] * there[0, k] + turn[0, 1] * there[1, k])
        dy = here[1, k] - (origin[1] + turn[1, 0] * there[0, k] + turn[1, 1] * there[1, k])
        value += collision_risk(dx, dy, *(float(each) for each in rows[k, 2:]))
    return value


def _problem(ship: JointShip, settings: Settings) -> LocalProblem:
    horizon = settings.horizon
    return LocalProblem(
        initial=ship.initial,
        last_offset=0.0,
        speed=ship.speed,
        settings=settings,
        offset_limits=ship.offset_limits,
        speed_limits=free_speeds(horizon),
        threats=np.zeros((0, horizon, 6)),
        multiplier=np.zeros((horizon + 1, 3)),
        broadcast=PathTrajectory(np.zeros((horizon + 1, 3))),
    )


def _sailed(ship: JointShip, settings: Settings, controls: FloatArray) -> FloatArray:
    """States (N + 1, 4) under controls (N, 2)."""
    model, fixed = stage_model(1), constants(_problem(ship, settings))
    states = [np.array([ship.initial.x, ship.initial.y, ship.initial.course, 0.0])]
    for control in controls:
        states.append(np.asarray(model.dynamics(states[-1], control, fixed), dtype=np.float64).ravel())
    return np.array(states)


def _packed(ship: JointShip, settings: Settings, controls: FloatArray) -> FloatArray:
    return np.concatenate([_sailed(ship, settings, controls)[1:].ravel(), controls.ravel()])


def _bounds(ship: JointShip, horizon: int, side: int) -> FloatArray:
    free = np.full(STATES * horizon, np.inf if side else -np.inf)
    pairs = np.column_stack([ship.offset_limits[:, side], np.full(horizon, float(side))])
    return np.concatenate([free, pairs.ravel()])
