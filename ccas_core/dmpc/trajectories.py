"""Where plans lead: controls sailed by the model, many at once.

The dynamics are those of `model`.  Where numba is installed the loop over stages is compiled, else CasADi
runs it; the paths are the same.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from ..compiling import compiled_module
from ..frames import FloatArray, PathTrajectory
from .casadi_to_numba import python_source
from .local_problem import LocalPlan, LocalProblem
from .model import CONTROLS, STATES, constants, stage_model

if TYPE_CHECKING:

    def dynamics(state: FloatArray, control: FloatArray, constants: FloatArray, after: FloatArray) -> None:
        """Write the state after a stage; made from `model`."""


def rollout(problem: LocalProblem, controls: FloatArray) -> LocalPlan:
    """Sail controls (N, 2) from the initial pose, held within their bounds."""
    limits, speeds = problem.offset_limits, problem.speed_limits
    held = np.empty((len(controls), CONTROLS))
    held[:, 0] = np.minimum(np.maximum(controls[:, 0], limits[:, 0]), limits[:, 1])
    held[:, 1] = np.minimum(np.maximum(controls[:, 1], speeds[:, 0]), speeds[:, 1])
    return LocalPlan(controls=held, trajectory=PathTrajectory(sailed(problem, held[None])[0]))


def sailed(problem: LocalProblem, controls: FloatArray) -> FloatArray:
    """Sail many plans (M, N, 2) as they are: paths (M, N + 1, 3)."""
    initial = problem.initial
    state = np.array([initial.x, initial.y, initial.course, problem.last_offset])
    paths = np.empty((len(controls), controls.shape[1] + 1, 3))
    _loop()(state, np.ascontiguousarray(controls), constants(problem), paths)
    return paths


def follow(start: FloatArray, controls: FloatArray, constants: FloatArray, paths: FloatArray) -> None:
    """Sail each plan from the same state; the text of the compiled loop."""
    state = np.empty(4)
    for m in range(controls.shape[0]):
        for j in range(4):
            state[j] = start[j]
        for j in range(3):
            paths[m, 0, j] = start[j]
        for k in range(controls.shape[1]):
            dynamics(state, controls[m, k], constants, state)
            for j in range(3):
                paths[m, k + 1, j] = state[j]


@cache
def _loop() -> Callable[[FloatArray, FloatArray, FloatArray, FloatArray], None]:
    """Compile `follow`, or load what an earlier start has compiled; without numba, its stand-in."""
    if find_spec("numba") is None:
        return interpreted
    functions = [python_source(stage_model(1).dynamics), inspect.getsource(follow)]
    return compiled_module(functions, {}).follow  # type: ignore[no-any-return]


def interpreted(start: FloatArray, controls: FloatArray, constants: FloatArray, paths: FloatArray) -> None:
    """As `follow`, run by CasADi."""
    count, horizon = controls.shape[:2]
    run = stage_model(1).dynamics.mapaccum("run", horizon).map(count)
    columns = controls.transpose(2, 0, 1).reshape(CONTROLS, count * horizon)
    found = run(np.tile(start[:, None], count), columns, np.tile(constants[:, None], count * horizon))
    states = np.asarray(found, dtype=np.float64).reshape(STATES, count, horizon)
    paths[:, 0] = start[:3]
    paths[:, 1:] = states.transpose(1, 2, 0)[:, :, :3]
