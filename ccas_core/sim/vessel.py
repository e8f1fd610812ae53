"""The plant: how a ship moves for one period under a command."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from ..dmpc import kinematics
from ..dmpc.parameters import Kinematics
from ..frames import PathPose
from .guidance import Command


class AbstractVessel(ABC):
    """Moves a ship along its guiding line."""

    @abstractmethod
    def advance(self, pose: PathPose, command: Command, speed: float) -> PathPose:
        """Sail one period from a pose under a command, at the nominal speed U^d [m/s]."""


@dataclass(frozen=True, slots=True)
class KinematicVessel(AbstractVessel):
    """The paper's own model, Eq. (4): the plant is what the controller believes.

    >>> vessel = KinematicVessel(Kinematics())
    >>> vessel.advance(PathPose(0.0, 0.0, 0.0), Command(0.0, 0.5), 3.0)
    PathPose(x=30.0, y=0.0, course=0.0)
    """

    model: Kinematics

    def advance(self, pose: PathPose, command: Command, speed: float) -> PathPose:
        """Sail one period."""
        x, y, course = kinematics.step(
            (pose.x, pose.y, pose.course),
            command.offset,
            command.speed_factor,
            speed=speed,
            time_step=self.model.time_step,
            time_constant=self.model.time_constant,
            course_limit=self.model.course_limit,
            steering_gain=self.model.steering_gain,
        )
        return PathPose(x, y, course)
