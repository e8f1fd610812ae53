"""A ship with surge speed and yaw rate, without sideslip, adrift with the current.

The kinematic model and the limits of a surface vehicle in congested inland waters (`docs/bumper-mpc.md`,
equations B1 to B5).  The same formula moves the plant and is asked by controllers with symbols: they hand in
their own cosine and sine.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from .frames import NedPose
from .units import wrap

Number: TypeAlias = Any  # a float, or a symbol of CasADi

_TURNING_RADIUS = 3.0  # of a ship of which nothing else is known, in lengths
_STOPPING_WAY = 5.0  # in which it stops from nominal speed, in lengths


@dataclass(frozen=True, slots=True)
class Current:
    """Water that moves over the ground, everywhere alike: velocities to north and east [m/s]."""

    north: float = 0.0
    east: float = 0.0

    @property
    def speed(self) -> float:
        """Over ground [m/s]."""
        return math.hypot(self.north, self.east)

    @property
    def course(self) -> float:
        """To where the water flows, clockwise from north [rad]."""
        return math.atan2(self.east, self.north)


@dataclass(frozen=True, slots=True, kw_only=True)
class Manoeuvrability:
    """Limits of surge speed and yaw rate and of what they change by in a second (B2 to B5)."""

    max_speed: float  # greatest surge speed [m/s]
    max_yaw_rate: float  # [rad/s]
    acceleration: float  # [m/s^2]
    yaw_acceleration: float  # [rad/s^2]

    def __post_init__(self) -> None:
        for name in ("max_speed", "max_yaw_rate", "acceleration", "yaw_acceleration"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of a ship must be positive, got {getattr(self, name)}")


def usual(length: float, speed: float) -> Manoeuvrability:
    """Manoeuvrability of a ship of which only length [m] and nominal speed [m/s] are known.

    It turns on a radius of three lengths, stops within five, and takes up its yaw rate in one.
    """
    yaw_rate = speed / (_TURNING_RADIUS * length)
    return Manoeuvrability(
        max_speed=speed,
        max_yaw_rate=yaw_rate,
        acceleration=speed**2 / (2.0 * _STOPPING_WAY * length),
        yaw_acceleration=yaw_rate * speed / length,
    )


@dataclass(frozen=True, slots=True)
class Motion:
    """What a ship is steered to for a period."""

    surge: float  # surge speed through the water [m/s]
    yaw_rate: float  # clockwise [rad/s]


def step(
    pose: tuple[Number, Number, Number],
    surge: Number,
    yaw_rate: Number,
    current: tuple[Number, Number],
    time_step: Number,
    cos: Callable[[Number], Number] = math.cos,
    sin: Callable[[Number], Number] = math.sin,
) -> tuple[Number, Number, Number]:
    """Sail one step (B1): north, east [m] and yaw angle [rad] after it.

    The ship turns first and moves then, on the new yaw angle, as the plant of the first paper does.

    >>> step((0.0, 0.0, 0.0), 2.0, 0.0, (0.0, 0.5), 10.0)
    (20.0, 5.0, 0.0)
    """
    north, east, yaw = pose
    turned = yaw + time_step * yaw_rate
    return (
        north + time_step * (surge * cos(turned) + current[0]),
        east + time_step * (surge * sin(turned) + current[1]),
        turned,
    )


def within(limits: Manoeuvrability, before: Motion, wanted: Motion, time_step: float) -> Motion:
    """Keep what is wanted within the limits, and within what can change in a step [s].

    >>> usual(10.0, 5.0).max_speed, within(usual(10.0, 5.0), Motion(0.0, 0.0), Motion(9.0, 0.0), 1.0)
    (5.0, Motion(surge=0.25, yaw_rate=0.0))
    """
    faster, turned = limits.acceleration * time_step, limits.yaw_acceleration * time_step
    surge = min(max(wanted.surge, before.surge - faster), before.surge + faster)
    yaw_rate = min(max(wanted.yaw_rate, before.yaw_rate - turned), before.yaw_rate + turned)
    most = limits.max_yaw_rate
    return Motion(min(max(surge, 0.0), limits.max_speed), min(max(yaw_rate, -most), most))


def advance(pose: NedPose, motion: Motion, current: Current, time_step: float) -> NedPose:
    """Sail one period; the yaw angle comes back in (-pi, pi]."""
    here = (pose.x, pose.y, pose.course)
    north, east, yaw = step(here, motion.surge, motion.yaw_rate, (current.north, current.east), time_step)
    return NedPose(north, east, wrap(yaw))
