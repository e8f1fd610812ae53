"""An outlook in the frame of the optimisation: origin at the own ship, x along its path, y to starboard."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ccas_core.controllers import Outlook, Target
from ccas_core.domains import AbstractDomain
from ccas_core.frames import FloatArray, NedPose, NedTrajectory, PathTrajectory
from ccas_core.surge_yaw import Current, Motion, advance, within
from ccas_core.units import wrap
from ccas_core.waterway import Obstacle

from .encounters import Rule
from .options import is_on, number, stated

SLOWEST: Final = 0.2  # least surge speed over the nominal one, where none is stated
SWING: Final = 0.3  # of the length: water that a turned hull needs beside its beam


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Reference:
    """What the ship would do alone, at each step k = 1 ... N, in the local frame."""

    north: float  # origin in {n} [m]
    east: float
    turn: float  # course of the path there: the x axis [rad]
    stages: FloatArray  # (N, 6): x, y, course, least and greatest offset, yaw angle that keeps to the path
    surge: float  # that makes the nominal speed good in this current [m/s]
    current: tuple[float, float]  # along and across, as the controller knows it [m/s]


def reference(outlook: Outlook, horizon: int) -> Reference:
    """Lay the path ahead, and what of the current is to be made up for, into the local frame."""
    line, pose = outlook.line, outlook.line.frame.to_path(outlook.pose)
    ahead = pose.x + outlook.speed * outlook.period * np.arange(1, horizon + 1)
    on_path = np.column_stack([ahead, np.zeros(horizon), np.zeros(horizon)])
    there = line.frame.trajectory_to_ned(PathTrajectory(on_path)).poses
    turn = line.frame.course_at(pose.x)
    swing = SWING * outlook.hull.length
    low, high = line.room_at(np.asarray(ahead, dtype=np.float64), outlook.hull.beam).T
    xy = turned(there[:, :2] - np.array([outlook.pose.x, outlook.pose.y]), turn)
    courses = np.unwrap(np.concatenate([[0.0], there[:, 2] - turn]))[1:]
    water = outlook.waters.current if is_on(outlook.options, "knows_current") else Current()
    along, across = turned(np.array([[water.north, water.east]]), turn)[0]
    surge, crab = _made_up_for(outlook, float(along), float(across))
    return Reference(
        north=outlook.pose.x,
        east=outlook.pose.y,
        turn=turn,
        stages=np.column_stack(
            [xy, courses, np.minimum(low + swing, 0.0), np.maximum(high - swing, 0.0), courses + crab]
        ),
        surge=surge,
        current=(float(along), float(across)),
    )


def _made_up_for(outlook: Outlook, along: float, across: float) -> tuple[float, float]:
    """Surge speed and yaw angle, from the path's, that make the nominal speed good along the path."""
    wanted = outlook.speed - along
    surge = min(max(math.hypot(wanted, across), 0.0), outlook.limits.max_speed)
    crab = -math.asin(min(max(across / surge, -1.0), 1.0)) if surge > 0.0 else 0.0
    return surge, crab


def turned(vectors: FloatArray, angle: float) -> FloatArray:
    """Read vectors (m, 2) of north and east on axes turned by an angle, or back by its negative."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.column_stack(
        [cos * vectors[:, 0] + sin * vectors[:, 1], cos * vectors[:, 1] - sin * vectors[:, 0]]
    )


def initial(outlook: Outlook, local: Reference) -> FloatArray:
    """State of the ship now, (5,)."""
    yaw = wrap(outlook.pose.course - local.turn)
    return np.array([0.0, 0.0, yaw, outlook.motion.surge, outlook.motion.yaw_rate])


def target_row(
    local: Reference, target: Target, sizes: tuple[float, float], domain_speed: float
) -> FloatArray:
    """Row of a target as the programme wants it, (9,); its domain is that of a speed [m/s]."""
    course = target.pose.course - local.turn
    cos, sin = math.cos(course), math.sin(course)
    velocity = target.speed * cos, target.speed * sin
    place = _place(local, target.pose.x, target.pose.y)
    return np.array([*place, *velocity, cos, sin, domain_speed, *sizes])


def obstacle_row(local: Reference, obstacle: Obstacle) -> FloatArray:
    """Row of an obstacle, (3,)."""
    return np.array([*_place(local, obstacle.x, obstacle.y), obstacle.radius])


def rule_row(local: Reference, rule: Rule) -> FloatArray:
    """Row of a safe distance that a rule asks for, (8,)."""
    velocity, direction = turned(np.array([rule.velocity, rule.direction]), local.turn)
    return np.array([*_place(local, *rule.place), *velocity, *direction, rule.distance, 1.0])


def _place(local: Reference, north: float, east: float) -> FloatArray:
    place: FloatArray = turned(np.array([[north - local.north, east - local.east]]), local.turn)[0]
    return place


def bounds(
    outlook: Outlook, local: Reference, state: FloatArray, *, may_stop: bool, fastest: float
) -> tuple[FloatArray, FloatArray]:
    """Bounds by stage, each (N, 8), of the control of k and the state of k + 1 (B2 to B5, B8).

    A ship that begins outside of them has the time that it needs to come back.
    """
    horizon, limits, period = len(local.stages), outlook.limits, outlook.period
    faster, quicker = limits.acceleration * period, limits.yaw_acceleration * period
    most = number(outlook.options, "max_turn")
    steps = np.arange(1, horizon + 1)
    free = np.full(horizon, np.inf)
    off = np.abs(state[2] - local.stages[:, 2]) - 0.5 * limits.max_yaw_rate * period * steps
    turn = np.maximum(most, off)
    slowest = 0.0 if may_stop else stated(outlook.options, "min_speed", SLOWEST * outlook.speed)
    least = np.minimum(slowest, np.maximum(state[3], 0.0) + 0.5 * faster * steps)
    greatest = np.maximum(fastest, state[3] - 0.5 * faster * steps)
    rate = np.full(horizon, limits.max_yaw_rate)
    course = local.stages[:, 2]
    change = np.tile([faster, quicker], (horizon, 1))
    low = np.column_stack([-change, 0.0 * rate, -free, -free, course - turn, least, -rate])
    high = np.column_stack([change, free, free, free, course + turn, greatest, rate])
    return low, high


def rolled_out(outlook: Outlook, increments: FloatArray) -> tuple[list[Motion], list[NedPose]]:
    """Motions and poses under increments (N, 2), within the limits: what will be sailed."""
    motion, pose = outlook.motion, outlook.pose
    water = outlook.waters.current if is_on(outlook.options, "knows_current") else Current()
    motions, poses = [], [pose]
    for surge, yaw_rate in increments.tolist():
        wanted = Motion(motion.surge + surge, motion.yaw_rate + yaw_rate)
        motion = within(outlook.limits, motion, wanted, outlook.period)
        pose = advance(pose, motion, water, outlook.period)
        motions.append(motion)
        poses.append(pose)
    return motions, poses


def trajectory(poses: Sequence[NedPose]) -> NedTrajectory:
    """Poses as a trajectory."""
    return NedTrajectory(np.array([[each.x, each.y, each.course] for each in poses]))


def states_of(
    local: Reference, state: FloatArray, motions: Sequence[Motion], poses: Sequence[NedPose]
) -> FloatArray:
    """States (N + 1, 5) of poses and motions, in the local frame."""
    table = trajectory(poses).poses
    xy = turned(table[:, :2] - np.array([local.north, local.east]), local.turn)
    yaw = np.unwrap(table[:, 2] - table[0, 2]) + state[2]
    moved = np.array([[state[3], state[4]], *([each.surge, each.yaw_rate] for each in motions)])
    return np.column_stack([xy, yaw, moved])


def sizes_of(domain: AbstractDomain, names: tuple[str, str]) -> tuple[float, float]:
    """The two parameters of a domain."""
    return float(getattr(domain, names[0])), float(getattr(domain, names[1]))
