"""Where a ship would sail if it met nobody: on beside its guiding line, at its nominal speed, to the end."""

from __future__ import annotations

import math

import numpy as np

from ..frames import NedPose, PathFrame, PathTrajectory
from .hulls import STEP, Track
from .scenario import Plan


def undisturbed(plan: Plan, pose: NedPose, time: float, line: PathFrame) -> Track:
    """Sail on from a pose at a time [s], at the present offset and nominal speed, to the end of the line."""
    here = line.to_path(pose)
    steps = max(0, math.ceil((line.length - here.x) / plan.speed / STEP))
    times = STEP * np.arange(steps + 1, dtype=np.float64)
    x = np.minimum(here.x + plan.speed * times, max(line.length, here.x))
    path = np.column_stack([x, np.full_like(x, here.y), np.zeros_like(x)])
    poses = line.trajectory_to_ned(PathTrajectory(path)).poses
    return Track(ship=plan.ship, times=time + times, poses=poses)
