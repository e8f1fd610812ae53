"""The optimisation of one step by multiple shooting, equations B9 to B18 of `docs/bumper-mpc.md`.

Everything is in a frame that begins at the own ship and lies along its path: x along, y to starboard.  A
programme is built once for each shape of problem, and then called like a function of parameters and guess.
Variables go by stages: state, control, state, ..., state.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import casadi as ca
import numpy as np

from ccas_core.domains import AbstractDomain, DynamicBumper, Ellipse, Rectangle, gap
from ccas_core.frames import FloatArray
from ccas_core.surge_yaw import step

STATES: Final = 5  # x, y [m], yaw angle [rad], surge speed [m/s], yaw rate [rad/s]
CONTROLS: Final = 3  # increments of surge speed and yaw rate, and how much the constraints are relaxed [m]
FIXED: Final = 6  # current along and across, time step, length, speed, reference of the surge speed
STAGE: Final = 6  # reference x, y, course, least and greatest offset, yaw angle from the path
TARGET: Final = 9  # x, y, velocities, cosine and sine of the course, speed, domain (2)
RULED: Final = 8  # x, y, velocities of whoever a rule is about; direction (2), distance, weight
OBSTACLE: Final = 3  # x, y, radius
DOMAIN: Final = 2
_TINY: Final = 1e-9  # keeps the root of a squared distance from an infinite slope at zero [m^2]

# Weights of (B10), of squares without units: lengths over the ship's, speeds over the nominal one.
PATH: Final = 1.0
COURSE: Final = 2.0
SURGE: Final = 8.0
YAW: Final = 0.5  # of the yaw rate times the time in which the ship sails its length
SURGE_INCREMENT: Final = 400.0
YAW_INCREMENT: Final = 2.0
RULE: Final = 20.0  # of a safe distance that is short by much, over the ship's length
RELAXED: Final = (200.0, 2000.0)  # of the relaxation and of its square

KINDS: Final[dict[type[AbstractDomain], tuple[str, str]]] = {  # and what their two parameters are
    Rectangle: ("length", "breadth"),
    Ellipse: ("ahead", "aside"),
    DynamicBumper: ("length", "full_speed"),
}


@dataclass(frozen=True, slots=True)
class Shape:
    """What a programme is built for."""

    horizon: int
    looks: int  # at the others, within each step
    own: type[AbstractDomain]
    targets: tuple[type[AbstractDomain], ...]
    obstacles: int
    ruled: int  # safe distances that rules ask for


@dataclass(frozen=True, slots=True, eq=False)
class Programme:
    """A problem, ready to be solved again and again."""

    solve: ca.Function
    equalities: FloatArray  # which constraints are equalities, (m,) as 0 or 1


@lru_cache(maxsize=32)
def programme(shape: Shape) -> Programme:
    """Build the programme of a shape."""
    fixed, initial = ca.SX.sym("fixed", FIXED), ca.SX.sym("initial", STATES)
    own = ca.SX.sym("own", DOMAIN)
    stages = ca.SX.sym("stages", STAGE, shape.horizon)
    targets = ca.SX.sym("targets", TARGET, max(len(shape.targets), 1))
    obstacles = ca.SX.sym("obstacles", OBSTACLE, max(shape.obstacles, 1))
    ruled = ca.SX.sym("ruled", RULED, max(shape.ruled, 1))
    states = [ca.SX.sym(f"state_{k}", STATES) for k in range(shape.horizon + 1)]
    controls = [ca.SX.sym(f"control_{k}", CONTROLS) for k in range(shape.horizon)]
    domain = _domain(shape.own, own)
    value, rows, equal, variables = ca.SX(0), [], [], []
    for k in range(shape.horizon):
        after = _sailed(states[k], controls[k], fixed)
        rows.append(states[k + 1] - after)  # (B11)
        equal += [1.0] * STATES
        if k == 0:
            rows.append(states[0] - initial)
            equal += [1.0] * STATES
        offset = _offset(after, stages[:, k])
        kept = [offset - stages[3, k], stages[4, k] - offset]  # (B13)
        for look in range(1, shape.looks + 1):
            pose, time = _within(states[k], after, look / shape.looks), (k + look / shape.looks) * fixed[2]
            kept += [
                _gap(domain, pose, after[3], _domain(kind, targets[7:9, n]), targets[:, n], time)
                for n, kind in enumerate(shape.targets)
            ]
            kept += [_clear(domain, pose, after[3], obstacles[:, n]) for n in range(shape.obstacles)]
        rows += [each + controls[k][2] for each in kept]
        equal += [0.0] * len(kept)
        value += _stage_cost(after, controls[k], stages[:, k], fixed)
        value += sum(_rule_cost(after, ruled[:, n], (k + 1) * fixed[2], fixed) for n in range(shape.ruled))
        variables += [states[k], controls[k]]
    variables.append(states[shape.horizon])
    parameters = ca.vertcat(
        fixed, initial, own, ca.vec(stages),
        *([ca.vec(targets)] if shape.targets else []),
        *([ca.vec(obstacles)] if shape.obstacles else []),
        *([ca.vec(ruled)] if shape.ruled else []),
    )  # fmt: skip
    problem = {"x": ca.vertcat(*variables), "f": value, "g": ca.vertcat(*rows), "p": parameters}
    solve = ca.nlpsol("bumper", "ipopt", problem, _SETTINGS)
    return Programme(solve=solve, equalities=np.array(equal))


_SETTINGS: Final[dict[str, Any]] = {
    "print_time": False,
    "error_on_fail": False,
    "ipopt": {
        "print_level": 0,
        "sb": "yes",
        "tol": 1e-5,
        "acceptable_tol": 1e-3,
        "acceptable_iter": 5,
        "max_iter": 80,
        "max_wall_time": 1.0,  # [s]
        "warm_start_init_point": "yes",
        "mu_strategy": "adaptive",
    },
}


def _domain(kind: type[AbstractDomain], sizes: ca.SX) -> AbstractDomain:
    return kind(**{name: sizes[n] for n, name in enumerate(KINDS[kind])})


def _sailed(state: ca.SX, control: ca.SX, fixed: ca.SX) -> ca.SX:
    """Dynamics of a step (B1), with the increments as controls, as (B4) and (B5) have them."""
    surge, yaw_rate = state[3] + control[0], state[4] + control[1]
    current = (fixed[0], fixed[1])
    pose = step((state[0], state[1], state[2]), surge, yaw_rate, current, fixed[2], ca.cos, ca.sin)
    return ca.vertcat(*pose, surge, yaw_rate)


def _within(state: ca.SX, after: ca.SX, share: float) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Pose within a step: on the straight way, at the yaw angle of its end."""
    x, y = (state[n] + share * (after[n] - state[n]) for n in (0, 1))
    return x, y, after[2]


def _offset(state: ca.SX, stage: ca.SX) -> ca.SX:
    """Offset from the path, to starboard [m]."""
    away_x, away_y = state[0] - stage[0], state[1] - stage[1]
    return ca.cos(stage[2]) * away_y - ca.sin(stage[2]) * away_x


def _stage_cost(state: ca.SX, control: ca.SX, stage: ca.SX, fixed: ca.SX) -> ca.SX:
    """Path, surge speed and yaw rate (B10), and the relaxation of the constraints."""
    length, speed = fixed[3], fixed[4]
    lengths_time = length / speed
    relaxed = control[2] / length
    return (
        PATH * (_offset(state, stage) / length) ** 2
        + COURSE * (state[2] - stage[5]) ** 2
        + SURGE * ((state[3] - fixed[5]) / speed) ** 2
        + YAW * (state[4] * lengths_time) ** 2
        + SURGE_INCREMENT * (control[0] / speed) ** 2
        + YAW_INCREMENT * (control[1] * lengths_time) ** 2
        + RELAXED[0] * relaxed
        + RELAXED[1] * relaxed**2
    )


def _rule_cost(state: ca.SX, ruled: ca.SX, time: ca.SX, fixed: ca.SX) -> ca.SX:
    """What a safe distance is short of, on the side that the rules want (B18)."""
    away_x = state[0] - ruled[0] - ruled[2] * time
    away_y = state[1] - ruled[1] - ruled[3] * time
    short = (ruled[6] - ruled[4] * away_x - ruled[5] * away_y) / fixed[3]
    lacking = (short + abs(short)) / 2.0
    cost: ca.SX = RULE * ruled[7] * (ca.sqrt(1.0 + lacking**2) - 1.0)
    return cost


def _gap(
    own: AbstractDomain,
    pose: tuple[ca.SX, ca.SX, ca.SX],
    surge: ca.SX,
    other: AbstractDomain,
    target: ca.SX,
    time: ca.SX,
) -> ca.SX:
    """Distance of the domains along the line that joins the ships (B17)."""
    x, y, yaw = pose
    dx, dy = target[0] + target[2] * time - x, target[1] + target[3] * time - y
    cos, sin, course_cos, course_sin = ca.cos(yaw), ca.sin(yaw), target[4], target[5]
    bearings = (
        cos * dx + sin * dy,
        cos * dy - sin * dx,
        -course_cos * dx - course_sin * dy,
        -course_cos * dy + course_sin * dx,
    )
    sight = ca.sqrt(dx * dx + dy * dy + _TINY)
    apart: ca.SX = gap(own, other, sight=sight, bearings=bearings, speeds=(surge, target[6]))
    return apart


def _clear(own: AbstractDomain, pose: tuple[ca.SX, ca.SX, ca.SX], surge: ca.SX, obstacle: ca.SX) -> ca.SX:
    """Distance of the own domain from an obstacle, which is a circle (B16)."""
    x, y, yaw = pose
    dx, dy = obstacle[0] - x, obstacle[1] - y
    cos, sin = ca.cos(yaw), ca.sin(yaw)
    edge = own.extent(cos * dx + sin * dy, cos * dy - sin * dx, surge)
    apart: ca.SX = ca.sqrt(dx * dx + dy * dy + _TINY) - edge - obstacle[2]
    return apart
