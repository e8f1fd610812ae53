"""The model of layer 2, stated once in CasADi: dynamics, control cost and state cost of a stage.

All solvers are built from these three functions, and the plant sails by the same `kinematics`.
The state of a stage is (x, y, course, u^y of the stage before): with the last offset in the state,
Eq. (8) and (9) couple no neighbouring controls, and the problem has the structure of optimal control.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from operator import attrgetter

import casadi as ca
import numpy as np

from ..frames import FloatArray
from . import cost, kinematics
from .local_problem import LocalPlan, LocalProblem
from .risk import COLUMNS, collision_risk

STATES = 4  # x, y [m], course [rad], last offset [m]
CONTROLS = 2  # offset u^y [m], speed factor u^s
CONSTANTS = [
    "speed",
    "time_step",
    "time_constant",
    "course_limit",
    "steering_gain",
    "K_y",
    "K_s",
    "mu_1",
    "mu_2",
    "mu_3",
    "r_2",
    "side",
    "gamma_s",
    "gamma_y",
    "beta",
]


@dataclass(frozen=True, slots=True)
class StageModel:
    """CasADi functions of one stage, for a number of threats."""

    constants: int
    stage_parameters: int
    dynamics: ca.Function  # (state, control, constants) -> state
    control_cost: ca.Function  # (state, control, constants) -> J^e + J^b of the stage
    state_cost: ca.Function  # (state, stage parameters, constants) -> J^ca + <z, p - p~> + beta/2 |p - p~|^2
    closeness: ca.Function  # (state, (z, p~), constants) -> <z, p - p~> + beta/2 |p - p~|^2
    risk: ca.Function  # (state, threat) -> one term of J^ca; `state_cost` is `closeness` and all of these


@cache
def stage_model(threats: int) -> StageModel:
    """State the model for a number of threats; made once for each."""
    state, control = ca.SX.sym("state", STATES), ca.SX.sym("control", CONTROLS)
    constants = ca.SX.sym("constants", len(CONSTANTS))
    named = dict(zip(CONSTANTS, ca.vertsplit(constants), strict=True))
    x, y, course, last_offset = ca.vertsplit(state)
    offset, speed_factor = ca.vertsplit(control)

    motion = {key: named[key] for key in CONSTANTS[:5]}
    sailed = kinematics.step((x, y, course), offset, speed_factor, **motion)
    arguments = (offset, last_offset, speed_factor)
    habits = {key: named[key] for key in ("mu_1", "mu_2", "mu_3", "r_2", "side", "gamma_s", "gamma_y")}
    effort = cost.control_effort(*arguments, named["K_y"], named["K_s"]) + cost.behaviour(
        *arguments, **habits
    )

    anchor = ca.SX.sym("anchor", 6)
    multiplier, broadcast = anchor[0:3], anchor[3:6]
    away = state[0:3] - broadcast
    near = ca.dot(multiplier, away) + named["beta"] / 2.0 * ca.dot(away, away)  # (13b)
    closeness = ca.Function("closeness", [state, anchor, constants], [near])

    threat = ca.SX.sym("threat", COLUMNS)
    row = ca.vertsplit(threat)
    risk = ca.Function("risk", [state, threat], [collision_risk(x - row[0], y - row[1], *row[2:])])

    stage = ca.SX.sym("stage", 6 + COLUMNS * threats)
    total = closeness(state, stage[0:6], constants)
    for n in range(threats):
        total += risk(state, stage[6 + COLUMNS * n : 6 + COLUMNS * (n + 1)])

    inputs = [state, control, constants]
    return StageModel(
        constants=len(CONSTANTS),
        stage_parameters=6 + COLUMNS * threats,
        dynamics=ca.Function("dynamics", inputs, [ca.vertcat(*sailed, offset)]),
        control_cost=ca.Function("control_cost", inputs, [effort]),
        state_cost=ca.Function("state_cost", [state, stage, constants], [total]),
        closeness=closeness,
        risk=risk,
    )


def constants(problem: LocalProblem) -> FloatArray:
    """Values of the constants of a problem, in the order of the model."""
    settings = problem.settings
    return np.array(
        [problem.speed, *_motion(settings.kinematics), *_habits(settings.weights), settings.beta],
        dtype=np.float64,
    )


_motion, _habits = attrgetter(*CONSTANTS[1:5]), attrgetter(*CONSTANTS[5:-1])


def stage_parameters(problem: LocalProblem, threats: int) -> FloatArray:
    """Parameters of the stages k = 1 ... N, (N, 6 + 6 n), filled up with threats of no height."""
    horizon = problem.settings.horizon
    padding = np.zeros((threats - len(problem.threats), horizon, COLUMNS))
    rows = np.concatenate([problem.threats, padding])
    return np.hstack(
        [problem.multiplier[1:], problem.broadcast.poses[1:], rows.transpose(1, 0, 2).reshape(horizon, -1)]
    )


def objective(problem: LocalProblem, plan: LocalPlan) -> float:
    """Objective of (13b) at a plan, by the model: the same number whichever solver found it."""
    model = stage_model(max(1, len(problem.threats)))
    fixed = constants(problem)
    stages = stage_parameters(problem, max(1, len(problem.threats)))
    poses, controls = plan.trajectory.poses, plan.controls
    last = np.concatenate([[problem.last_offset], controls[:, 0]])
    states = np.column_stack([poses, last])
    horizon = len(controls)
    efforts = model.control_cost.map(horizon)(states[:-1].T, controls.T, fixed)
    risks = model.state_cost.map(horizon)(states[1:].T, stages.T, fixed)
    return float(ca.sum2(efforts + risks))
