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
from ccas_core.frames import FloatArray
from ccas_core.roles import Geometry, PassingSide, Role
from ccas_core.units import DEGREE

from .options import stated

AHEAD: Final = 22.5 * DEGREE  # theta_1: a ship nearly ahead [rad]
OPPOSITE: Final = 157.5 * DEGREE  # theta_2: courses that are nearly opposite [rad]
ALIKE: Final = 67.5 * DEGREE  # theta_3: courses so near that who comes up from astern overtakes [rad]
BEFORE: Final = 112.5 * DEGREE  # theta_4: a ship abaft of this bearing is not faced [rad]
LEAD: Final = 12.0  # ship lengths' time that both sail until a ship is avoided
MARGIN: Final = 0.3  # of the own length, beside what domains need

_OBLIGED: Final = (Role.GIVE_WAY, Role.BOTH)
_SIDES: Final = {  # on which side of the other the own ship passes, seen along its path: +1 starboard
    PassingSide.PORT_TO_PORT: 1.0,
    PassingSide.STARBOARD_TO_STARBOARD: -1.0,
    PassingSide.OVERTAKE_ON_PORT: -1.0,
    PassingSide.OVERTAKE_ON_STARBOARD: 1.0,
}
_USUAL: Final = {Geometry.HEAD_ON: 1.0, Geometry.OVERTAKING: -1.0}  # where no side is prescribed


@dataclass(frozen=True, slots=True)
class Rule:
    """What the rule term asks towards one target: so far from it in a direction.  Weight 0: nothing."""

    direction: tuple[float, float] = (1.0, 0.0)  # unit vector, north and east
    distance: float = 0.0  # [m]
    weight: float = 0.0  # 0 or 1: the binary weight of the encounter that it is


NOTHING: Final = Rule()


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


def rule_towards(outlook: Outlook, target: Target, velocity: FloatArray) -> Rule:
    """Say what the rule term asks towards a target; `velocity` is the own one over ground, (2,) [m/s]."""
    own = np.array([outlook.pose.x, outlook.pose.y])
    other = np.array([target.pose.x, target.pose.y])
    course = target.pose.course
    along = np.array([math.cos(course), math.sin(course)])
    geometry = target.bearing.geometry
    if geometry is Geometry.NONE:
        geometry = division(own, velocity, other, target.speed * along)
    if target.bearing.role not in _OBLIGED or geometry is Geometry.NONE:
        return NOTHING
    if float(np.hypot(*(other - own))) > near(outlook, target):
        return NOTHING
    needed = abeam(outlook.domain, outlook.motion.surge) + abeam(target.domain, target.speed)
    needed += MARGIN * outlook.hull.length
    distance = stated(outlook.options, f"{geometry}_distance", needed)
    if geometry is Geometry.CROSSING:
        return Rule((-float(along[0]), -float(along[1])), distance, 1.0)
    side = _SIDES.get(target.bearing.passing_side, _USUAL[geometry])  # type: ignore[arg-type]
    path = outlook.line.frame.course_at(outlook.line.frame.to_path(outlook.pose).x)
    return Rule((-side * math.sin(path), side * math.cos(path)), distance, 1.0)


def near(outlook: Outlook, target: Target) -> float:
    """Distance within which a target is avoided: d_min of Sec. 3.4 (4) [m]."""
    time = LEAD * outlook.hull.length / outlook.speed
    return stated(outlook.options, "act_within", time * (outlook.speed + target.speed))


def abeam(domain: AbstractDomain, speed: float) -> float:
    """Reach of a domain to the side [m]."""
    return float(domain.extent(0.0, 1.0, speed))


def _angle(one: FloatArray, other: FloatArray) -> float:
    across, along = one[0] * other[1] - one[1] * other[0], float(np.dot(one, other))
    return abs(math.atan2(across, along))
