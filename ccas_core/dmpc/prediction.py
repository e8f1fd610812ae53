"""Where a ship will be that has not told its intention (Algorithm 2, step 9)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import lru_cache
from typing import Final

import numpy as np

from ..frames import NedPose, NedTrajectory

REMEMBERED: Final = 16384  # trajectories: all who heard a ship ask for the same, in each iteration


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
        return _straight_on(pose, speed, horizon, time_step)


@lru_cache(maxsize=REMEMBERED)
def _straight_on(pose: NedPose, speed: float, horizon: int, time_step: float) -> NedTrajectory:
    poses = np.empty((horizon + 1, 3))
    sailed = speed * time_step * np.arange(horizon + 1)
    poses[:, 0] = pose.x + sailed * np.cos(pose.course)
    poses[:, 1] = pose.y + sailed * np.sin(pose.course)
    poses[:, 2] = pose.course
    return NedTrajectory(poses)


@lru_cache(maxsize=REMEMBERED)
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
