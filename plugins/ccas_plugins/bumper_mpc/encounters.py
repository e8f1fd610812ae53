"""Which encounter a target is, and what the rule term asks for it (Sec. 3.4, equations B7 to B9 and B18).

Duty and side come with the target's `Bearing`, from whatever ruleset is in force.  The division by positions
and velocities says only which of the three safe distances counts where the bearing does not say it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from ccas_core.controllers import Outlook, Target
from ccas_core.domains import AbstractDomain
from ccas_core.frames import FloatArray, NedPose, PathPose
from ccas_core.roles import Geometry, PassingSide, Role
from ccas_core.units import DEGREE
from ccas_core.waterway import Obstacle

from .options import stated

AHEAD: Final = 22.5 * DEGREE  # theta_1: a ship nearly ahead [rad]
OPPOSITE: Final = 157.5 * DEGREE  # theta_2: courses that are nearly opposite [rad]
ALIKE: Final = 67.5 * DEGREE  # theta_3: courses so near that who comes up from astern overtakes [rad]
BEFORE: Final = 112.5 * DEGREE  # theta_4: a ship abaft of this bearing is not faced [rad]
LEAD: Final = 12.0  # lengths, of the longer ship, that the own ship sails until a ship is avoided
MARGIN: Final = 0.3  # of the own length, beside what domains need abeam of one another
ASTERN: Final = 1.2  # of the own length, beside the same, astern of a ship that crosses: the bow points there

_OBLIGED: Final = (Role.GIVE_WAY, Role.BOTH)
_SIDES: Final = {  # on which side of the other the own ship passes, seen along its path: +1 starboard
    PassingSide.PORT_TO_PORT: 1.0,
    PassingSide.STARBOARD_TO_STARBOARD: -1.0,
    PassingSide.OVERTAKE_ON_PORT: -1.0,
    PassingSide.OVERTAKE_ON_STARBOARD: 1.0,
}
_USUAL: Final = {Geometry.HEAD_ON: 1.0, Geometry.OVERTAKING: -1.0}  # where no side is prescribed


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """A safe distance that is asked for: so far from somebody in a direction."""

    geometry: Geometry
    place: tuple[float, float]  # of whoever it is, north and east [m]
    velocity: tuple[float, float]  # of the same [m/s]
    direction: tuple[float, float]  # unit vector, north and east
    distance: float  # [m]
    side: float = 0.0  # of the own path on which the ship passes, +1 starboard; 0: astern of who crosses

    def lacking(self, pose: NedPose) -> float:
        """What the distance lacks at a pose, now [m]; negative where there is more than asked for."""
        north, east = pose.x - self.place[0], pose.y - self.place[1]
        return self.distance - self.direction[0] * north - self.direction[1] * east


def division(
    own: FloatArray, velocity: FloatArray, other: FloatArray, other_velocity: FloatArray
) -> Geometry:
    """Divide encounters by unit vector of sight and velocities (B7 to B9); positions and velocities are (2,).

    >>> north = np.array([3.0, 0.0])
    >>> division(np.zeros(2), north, np.array([90.0, 1.0]), -north)
    <Geometry.HEAD_ON: 'head_on'>
    """
    sight = (other - own) / max(float(np.hypot(*(other - own))), 1e-9)
    ahead, between = _angle(velocity, sight), _angle(velocity, other_velocity)
    if float(np.dot(velocity - other_velocity, sight)) <= 0.0:
        return Geometry.NONE  # they do not approach
    if ahead <= AHEAD and between >= OPPOSITE:
        return Geometry.HEAD_ON
    if ahead < math.pi / 2.0 and between <= ALIKE:
        return Geometry.OVERTAKING
    return Geometry.CROSSING if ahead <= BEFORE else Geometry.NONE


def rule_towards(
    outlook: Outlook, target: Target, velocity: FloatArray, before: Rule | None, *, fails: bool = False
) -> Rule | None:
    """Say what the rule term asks towards a target; None: nothing.

    Parameters
    ----------
    velocity
        Of the own ship over ground, (2,) [m/s].
    before
        What was asked in the period before.  It stays until the other's domain is behind, although the
        encounter may be over for the rules.
    fails
        The other owes way, and does not give it.
    """
    if before is not None and before.geometry is not Geometry.CROSSING and _is_beside(outlook, target):
        return _beside(outlook, target, before.geometry, before.side)
    acts = fails or (
        target.bearing.role in _OBLIGED and distance_of(outlook, target) <= near(outlook, target)
    )
    if not acts:
        return None
    course = target.pose.course
    along = np.array([math.cos(course), math.sin(course)])
    own, other = (np.array([pose.x, pose.y]) for pose in (outlook.pose, target.pose))
    geometry = target.bearing.geometry
    if geometry is Geometry.NONE:
        geometry = division(own, velocity, other, target.speed * along)
    if geometry is Geometry.NONE or (
        geometry is Geometry.CROSSING and _angle(velocity, other - own) > BEFORE
    ):
        return None  # not faced: one that is abaft keeps clear of this ship, or has gone by
    if geometry is Geometry.CROSSING:
        return _astern(outlook, target)
    prescribed = target.bearing.passing_side
    side = _USUAL[geometry] if prescribed is None else _SIDES.get(prescribed, _USUAL[geometry])
    if geometry is Geometry.OVERTAKING and float(np.dot(velocity, other - own)) < 0.0:
        side = -side  # this ship is overtaken
    return _beside(outlook, target, geometry, side)


def _beside(outlook: Outlook, target: Target, geometry: Geometry, side: float) -> Rule:
    """Pass beside a target, on a side of the own path: offsets from the path count, also where it bends."""
    frame = outlook.line.frame
    own, there = frame.to_path(outlook.pose), frame.to_path(target.pose)
    beside = frame.to_ned(PathPose(own.x, there.y, 0.0))
    path = frame.course_at(own.x)
    starboard = -math.sin(path), math.cos(path)
    drift = target.speed * math.sin(there.course)
    return Rule(
        geometry=geometry,
        place=(beside.x, beside.y),
        velocity=(drift * starboard[0], drift * starboard[1]),
        direction=(side * starboard[0], side * starboard[1]),
        distance=_distance(outlook, target, geometry, MARGIN),
        side=side,
    )


def _astern(outlook: Outlook, target: Target) -> Rule:
    """Pass astern of a target, along its course."""
    ahead = math.cos(target.pose.course), math.sin(target.pose.course)
    return Rule(
        geometry=Geometry.CROSSING,
        place=(target.pose.x, target.pose.y),
        velocity=(target.speed * ahead[0], target.speed * ahead[1]),
        direction=(-ahead[0], -ahead[1]),
        distance=_distance(outlook, target, Geometry.CROSSING, ASTERN),
    )


def _distance(outlook: Outlook, target: Target, geometry: Geometry, margin: float) -> float:
    """Safe distance: what a scenario states, or what domains need abeam and a margin in lengths [m]."""
    needed = breadth(outlook, target) + margin * outlook.hull.length
    return stated(outlook.options, f"{geometry}_distance", needed)


def _is_beside(outlook: Outlook, target: Target) -> bool:
    """Whether a ship that returned to its path now would come into the other's domain."""
    path = _path_course(outlook)
    north, east = target.pose.x - outlook.pose.x, target.pose.y - outlook.pose.y
    along = north * math.cos(path) + east * math.sin(path)
    turn = target.pose.course - path
    ahead = math.copysign(1.0, along)
    own = float(outlook.domain.extent(ahead, 0.0, outlook.motion.surge))
    other = float(target.domain.extent(-ahead * math.cos(turn), ahead * math.sin(turn), target.speed))
    return abs(along) < own + other + MARGIN * outlook.hull.length


def rule_round(outlook: Outlook, obstacle: Obstacle) -> Rule | None:
    """Say how to go round a static obstacle near the path: on the side that is the shorter way; None: not."""
    frame = outlook.line.frame
    own, there = (frame.to_path(each) for each in (outlook.pose, NedPose(obstacle.x, obstacle.y, 0.0)))
    distance = abeam(outlook.domain, outlook.motion.surge) + obstacle.radius + MARGIN * outlook.hull.length
    reach = float(outlook.domain.extent(1.0, 0.0, outlook.limits.max_speed)) + obstacle.radius
    behind = abeam(outlook.domain, outlook.motion.surge) + obstacle.radius
    if abs(there.y) >= distance or not -behind < there.x - own.x < reach + LEAD * outlook.hull.length:
        return None
    low, high = outlook.line.room_at(np.array([there.x]), outlook.hull.beam)[0]
    ways = {1.0: there.y + distance, -1.0: there.y - distance}
    free = {side: offset for side, offset in ways.items() if low <= offset <= high} or ways
    side = min(free, key=lambda each: abs(free[each]) - each * 1e-6)
    path = frame.course_at(there.x)
    return Rule(
        geometry=Geometry.NONE,
        place=(obstacle.x, obstacle.y),
        velocity=(0.0, 0.0),
        direction=(-side * math.sin(path), side * math.cos(path)),
        distance=distance,
    )


def passing_surge(outlook: Outlook, rule: Rule, surge: float) -> float:
    """Surge speed with which a ship that crosses is behind the other when it comes to its track [m/s].

    `surge` is the usual one, which is the answer where the other is past in time.
    """
    speed = math.hypot(*rule.velocity)
    if rule.geometry is not Geometry.CROSSING or speed <= 0.0:
        return surge
    ahead = rule.velocity[0] / speed, rule.velocity[1] / speed
    path = _path_course(outlook)
    north, east = outlook.pose.x - rule.place[0], outlook.pose.y - rule.place[1]
    across = ahead[0] * east - ahead[1] * north
    approach = ahead[0] * math.sin(path) - ahead[1] * math.cos(path)
    way = -across / approach if abs(approach) > 1e-3 else 0.0  # along the path to the other's track
    if way <= 0.0:
        return surge
    meeting = ahead[0] * (north + way * math.cos(path)) + ahead[1] * (east + way * math.sin(path))
    time = (meeting + rule.distance) / speed  # until the other is so far past that place
    return min(surge, way / time) if time > 0.0 else surge


def near(outlook: Outlook, target: Target) -> float:
    """Distance within which a target is avoided: d_min of Sec. 3.4 (4) [m]."""
    time = LEAD * max(outlook.hull.length, target.hull.length) / outlook.speed
    return stated(outlook.options, "act_within", time * (outlook.speed + target.speed))


def abeam(domain: AbstractDomain, speed: float) -> float:
    """Reach of a domain to the side [m]."""
    return float(domain.extent(0.0, 1.0, speed))


def breadth(outlook: Outlook, target: Target) -> float:
    """Lateral distance at which two domains pass each other [m]."""
    return abeam(outlook.domain, outlook.motion.surge) + abeam(target.domain, target.speed)


def distance_of(outlook: Outlook, target: Target) -> float:
    """Distance of the centres [m]."""
    return math.hypot(target.pose.x - outlook.pose.x, target.pose.y - outlook.pose.y)


def _path_course(outlook: Outlook) -> float:
    return outlook.line.frame.course_at(outlook.line.frame.to_path(outlook.pose).x)


def _angle(one: FloatArray, other: FloatArray) -> float:
    across, along = one[0] * other[1] - one[1] * other[0], float(np.dot(one, other))
    return abs(math.atan2(across, along))
