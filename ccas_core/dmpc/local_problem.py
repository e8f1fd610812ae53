"""The local problem of one ship, Eq. (10) to (12) with the objective of Eq. (13b), as a value.

`solvers` minimise it; `model` states its formulas.  Everything is in the own path frame {w_i}.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from ..frames import FloatArray, PathPose, PathTrajectory, frozen_array
from .outcome import Outcome
from .parameters import Settings


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LocalProblem:
    """What one ship has to minimise in one NADMM update.

    Parameters
    ----------
    initial
        Pose now, p^init of (10c).
    last_offset
        Offset applied last, u^y(t - 1) [m].
    speed
        Nominal speed U^d [m/s].
    settings
        Weights, model constants, horizon N and penalty beta.
    offset_limits
        Least and greatest offset at each control, (N, 2) [m], and
    speed_limits
        speed factor, (N, 2), within [0, 1]: the set U_i of (10d).
    threats
        Neighbours and obstacles, (n, N, 6), as `risk.threat` makes them.
    multiplier
        z^{s+1/2} of (13a), (N + 1, 3).
    broadcast
        The trajectory to stay near, with the wide bar in (13b).
    """

    initial: PathPose
    last_offset: float
    speed: float
    settings: Settings
    offset_limits: FloatArray
    speed_limits: FloatArray
    threats: FloatArray
    multiplier: FloatArray
    broadcast: PathTrajectory

    def __post_init__(self) -> None:
        horizon = self.settings.horizon
        for name, shape in (
            ("offset_limits", (horizon, 2)),
            ("speed_limits", (horizon, 2)),
            ("threats", (len(self.threats), horizon, 6)),
            ("multiplier", (horizon + 1, 3)),
        ):
            array = frozen_array(getattr(self, name))
            if array.shape != shape:
                raise ValueError(f"{name} is {shape}, got {array.shape}")
            object.__setattr__(self, name, array)
        if self.broadcast.poses.shape != (horizon + 1, 3):
            raise ValueError(f"broadcast is {(horizon + 1, 3)}, got {self.broadcast.poses.shape}")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LocalPlan:
    """Controls and the trajectory they give: a point of the feasible set G_i of Eq. (12)."""

    controls: FloatArray  # (N, 2): offset u^y [m], speed factor u^s
    trajectory: PathTrajectory

    def __post_init__(self) -> None:
        object.__setattr__(self, "controls", frozen_array(self.controls))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution:
    """What a solver reports; the plan is to be sailed only if the outcome is usable."""

    plan: LocalPlan
    objective: float
    outcome: Outcome
    iterations: int
    seconds: float
    message: str = ""  # the solver's own words


@cache
def free_speeds(horizon: int) -> FloatArray:
    """Limits 0 <= u^s <= 1 of the speed factor, (N, 2).

    >>> free_speeds(2).tolist()
    [[0.0, 1.0], [0.0, 1.0]]
    """
    return frozen_array(np.tile([0.0, 1.0], (horizon, 1)))


def shifted(controls: FloatArray) -> FloatArray:
    """Move a plan on by one period; its last control is held.

    >>> shifted(np.array([[1.0, 1.0], [2.0, 0.5]])).tolist()
    [[2.0, 0.5], [2.0, 0.5]]
    """
    return np.vstack([controls[1:], controls[-1:]])
