"""Facts about two ships, Eq. (3) and Sec. 3.1: what Algorithm 1 asks, and what it should have asked.

All come from the two ships' reports and the chart, so that both ships compute the same; every
function is symmetric in the two ships, or says how it changes when they are swapped.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from ..frames import NedPose
from ..ships import UNKNOWN, FactValue, ShipId
from ..units import DEGREE, wrap
from ..waterway import Waters
from ..world import ShipReport
from .encounters import NO_ENCOUNTER, Encounter

STOPPED = 0.1  # a ship slower than this is not under way: it meets nobody [m/s]
OPPOSITE = 180.0 * DEGREE - 22.5 * DEGREE  # least course difference of a head-on encounter, Eq. (3) [rad]
ABAFT = 112.5 * DEGREE  # relative bearing from which a ship that comes up is overtaking [rad]
KEEPS_STARBOARD = 5.0  # a ship this far to starboard of the centreline follows the starboard side [m]
LEAVES_STARBOARD = 0.0  # and does so until it is no farther than this [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class PairFacts:
    """What is true between `own` and `other`; `mirrored` gives the other ship's view."""

    own: ShipReport
    other: ShipReport
    course_difference: float  # between the courses, 0 to pi [rad]; symmetric
    bearing_of_other: float  # relative, starboard positive, (-pi, pi] [rad]
    bearing_of_own: float  # own ship, seen from the other
    tcpa: float  # time to the closest point of approach [s]; negative when past, inf if never; symmetric
    dcpa: float  # distance there [m]; symmetric
    same_waterway: bool  # each lies between the banks of the other's waterway; symmetric
    same_arm: bool  # both follow one waterway in the same direction; symmetric
    own_time_to_intersection: float  # [s]; negative when past, inf if there is none or the ship is stopped
    other_time_to_intersection: float
    courses_cross_from: float  # > 0: the other's course crosses from starboard; antisymmetric
    own_on_starboard_side: FactValue
    other_on_starboard_side: FactValue
    encounter: Encounter  # memory of the pair

    def mirrored(self) -> PairFacts:
        """Give the same facts as the other ship sees them."""
        return replace(
            self,
            own=self.other,
            other=self.own,
            bearing_of_other=self.bearing_of_own,
            bearing_of_own=self.bearing_of_other,
            own_time_to_intersection=self.other_time_to_intersection,
            other_time_to_intersection=self.own_time_to_intersection,
            courses_cross_from=-self.courses_cross_from,
            own_on_starboard_side=self.other_on_starboard_side,
            other_on_starboard_side=self.own_on_starboard_side,
        )

    @property
    def under_way(self) -> bool:
        """Whether both ships make way."""
        return self.own.speed > STOPPED and self.other.speed > STOPPED


def assess(
    waters: Waters, own: ShipReport, other: ShipReport, encounter: Encounter = NO_ENCOUNTER
) -> PairFacts:
    """Assess a pair of ships on a chart.

    Notes
    -----
    In an encounter the starboard side is that of its beginning: a ship that gives way to
    starboard does not earn the right to stand on by doing so.
    """
    tcpa, dcpa = closest_approach(own, other)
    sides = encounter.starboard_sides
    return PairFacts(
        own=own,
        other=other,
        course_difference=abs(wrap(own.pose.course - other.pose.course)),
        bearing_of_other=relative_bearing(own.pose, other.pose),
        bearing_of_own=relative_bearing(other.pose, own.pose),
        tcpa=tcpa,
        dcpa=dcpa,
        same_waterway=_between_banks(waters, own, other) and _between_banks(waters, other, own),
        same_arm=own.waterway == other.waterway and own.towards is other.towards,
        own_time_to_intersection=time_to_intersection(waters, own, other.waterway),
        other_time_to_intersection=time_to_intersection(waters, other, own.waterway),
        courses_cross_from=encounter.crosses_from.get(own.id, math.sin(own.pose.course - other.pose.course)),
        own_on_starboard_side=sides[own.id]
        if known(sides.get(own.id, UNKNOWN))
        else follows_starboard_side(waters, own),
        other_on_starboard_side=sides[other.id]
        if known(sides.get(other.id, UNKNOWN))
        else follows_starboard_side(waters, other),
        encounter=encounter,
    )


def is_head_on(facts: PairFacts, time_limit: float) -> bool:
    """HEADON of Eq. (3): opposite courses, TCPA within T_ho [s], same waterway.

    Notes
    -----
    The print has neither a lower bound on TCPA, so that ships that have passed are still head-on,
    nor a case for a stopped ship, by whose speed it divides; and it asks for the waterway in one
    frame only.  Here TCPA never counts when past, both ships are under way, and the waterway is the
    same from both.
    """
    return (
        facts.under_way
        and facts.course_difference > OPPOSITE
        and 0.0 <= facts.tcpa <= time_limit
        and facts.same_waterway
    )


def is_crossing(facts: PairFacts, time_limit: float) -> bool:
    """CROSSING of Algorithm 1, line 9: both ships reach the intersection within T_IC [s], and neither has.

    Ships of one waterway do not cross, whatever their times.
    """
    times = (facts.own_time_to_intersection, facts.other_time_to_intersection)
    return (
        facts.under_way
        and facts.own.waterway != facts.other.waterway
        and all(0.0 <= t < time_limit for t in times)
    )


def overtakes(facts: PairFacts, time_limit: float) -> bool:
    """Whether `own` comes up from more than 22.5 degrees abaft the other's beam."""
    return (
        facts.under_way
        and abs(facts.bearing_of_own) > ABAFT
        and facts.course_difference < math.pi - ABAFT
        and facts.own.speed > facts.other.speed
        and 0.0 <= facts.tcpa <= time_limit
        and facts.same_waterway
    )


def closest_approach(own: ShipReport, other: ShipReport) -> tuple[float, float]:
    """TCPA [s] and DCPA [m] at constant velocities; (inf, range) where the range does not change."""
    rx, ry = other.pose.x - own.pose.x, other.pose.y - own.pose.y
    wx, wy = (
        other.speed * math.cos(other.pose.course) - own.speed * math.cos(own.pose.course),
        other.speed * math.sin(other.pose.course) - own.speed * math.sin(own.pose.course),
    )
    square = wx * wx + wy * wy
    if square < 1e-12:
        return math.inf, math.hypot(rx, ry)
    tcpa = -(rx * wx + ry * wy) / square
    return tcpa, math.hypot(rx + tcpa * wx, ry + tcpa * wy)


def relative_bearing(own: NedPose, other: NedPose) -> float:
    """Bearing of a position from own course, clockwise, (-pi, pi]: starboard positive.

    >>> round(relative_bearing(NedPose(0.0, 0.0, 0.0), NedPose(0.0, 10.0, 0.0)) / DEGREE)
    90
    """
    return wrap(math.atan2(other.y - own.y, other.x - own.x) - own.course)


def time_to_intersection(waters: Waters, ship: ShipReport, across: str) -> float:
    """T^IC of a ship: time until it reaches the centre of the intersection with waterway `across` [s]."""
    if across == ship.waterway or ship.speed <= STOPPED:
        return math.inf
    centre = waters.junction(ship.waterway, across)
    if centre is None:
        return math.inf
    frame = waters.waterway(ship.waterway).frame(ship.towards)
    return (frame.to_path(centre).x - frame.to_path(ship.pose).x) / ship.speed


def follows_starboard_side(waters: Waters, ship: ShipReport, *, before: bool = False) -> FactValue:
    """Whether a ship follows the starboard side of its waterway; what it states itself comes first.

    `before` is what was true a period ago: a ship near the centreline keeps the side it had.
    """
    stated = ship.ship.facts.get("follows_starboard_side")
    if stated is not None:
        return stated
    frame = waters.waterway(ship.waterway).frame(ship.towards)
    offset = frame.to_path(ship.pose).y
    return offset > LEAVES_STARBOARD if before else offset >= KEEPS_STARBOARD


def _between_banks(waters: Waters, own: ShipReport, other: ShipReport) -> bool:
    """Whether the other ship lies between the banks of the own waterway."""
    waterway = waters.waterway(own.waterway)
    return abs(waterway.frame(own.towards).to_path(other.pose).y) <= waterway.width / 2.0


def comes_up(facts: PairFacts) -> ShipId:
    """Of two ships, the one that the other has farther abaft; alike, the smaller id."""
    seen = ((-abs(facts.bearing_of_own), facts.own.id), (-abs(facts.bearing_of_other), facts.other.id))
    return min(seen)[1]


def known(value: FactValue) -> bool:
    """Whether a fact has a value."""
    return value is not UNKNOWN
