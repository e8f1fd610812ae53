"""Where a ship will be that has not told its intention (Algorithm 2, step 9)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import lru_cache

import numpy as np

from ..frames import NedPose, NedTrajectory


class AbstractPredictor(ABC):
    """Predicts the motion of a neighbour from what is known of it now."""

    @abstractmethod
    def predict(self, pose: NedPose, speed: float, horizon: int, time_step: float) -> NedTrajectory:
        """Predict N = `horizon` steps of `time_step` [s]; the first row is `pose`."""


class ConstantVelocity(AbstractPredictor):
    """Course and speed stay as they are, as in the paper.

    >>> ConstantVelocity().predict(NedPose(0.0, 0.0, 0.0), 3.0, 2, 20.0).poses[:, 0].tolist()
    [0.0, 60.0, 120.0]
    """

    def predict(self, pose: NedPose, speed: float, horizon: int, time_step: float) -> NedTrajectory:
        """Predict a straight line."""
        sailed = speed * time_step * np.arange(horizon + 1)
        course = np.full(horizon + 1, pose.course)
        north = pose.x + sailed * np.cos(pose.course)
        east = pose.y + sailed * np.sin(pose.course)
        return NedTrajectory(np.column_stack([north, east, course]))


@lru_cache(maxsize=4096)  # all who heard it ask for the same
def carried_on(told: NedTrajectory) -> NedTrajectory:
    """Carry an intention on by one period; its last step is repeated."""
    poses = told.poses
    last = poses[-1].copy()
    last[:2] += poses[-1, :2] - poses[-2, :2]
    return NedTrajectory(np.vstack([poses[1:], last]))


def resized(told: NedTrajectory, horizon: int) -> NedTrajectory:
    """Bring an intention to the own horizon: cut, or its last step repeated."""
    while len(told.poses) < horizon + 1:
        last = told.poses[-1].copy()
        last[:2] += told.poses[-1, :2] - told.poses[-2, :2]
        told = NedTrajectory(np.vstack([told.poses, last]))
    return told if len(told.poses) == horizon + 1 else NedTrajectory(told.poses[: horizon + 1])
