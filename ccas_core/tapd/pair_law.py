"""The law of a pair: one rule by which two ships come to the same law, wherever each of them is.

The law by which two ships judge one another is the law in force *where they will meet*: half-way between the
positions that they have at their closest approach, each sailing on as it does now; at the earliest now, and
at the latest `FORESIGHT` from now; now, where the distance between them does not change.  On one waterway
they sail on along it, bends included.

The rule reads the two reports and the chart alone, and does not know which of the two ships is asking: what
is computed for (a, b) is bit for bit what is computed for (b, a).  Once an encounter has begun, its law stays
until the ships are past and clear (`encounters`).
"""

from __future__ import annotations

import math
from typing import Final

from ..frames import NedPose, PathPose
from ..regions import Law
from ..waterway import Towards, Waters
from ..world import ShipReport
from .facts import closest_approach, motion_of
from .language.code import MOTION

FORESIGHT: Final = 900.0  # how far ahead two ships look for the place where they meet [s]
_PLACES: Final = tuple(MOTION.index(name) for name in ("ox", "oy", "tx", "ty"))


def law_of_pair(waters: Waters, one: ShipReport, other: ShipReport) -> Law:
    """Law by which two ships judge an encounter that begins now.

    Parameters
    ----------
    waters
        The chart, which both have.
    one, other
        What the ships report, in any order.
    """
    return waters.laws.everywhere or waters.laws.at(place_of_meeting(waters, one, other))


def place_of_meeting(waters: Waters, one: ShipReport, other: ShipReport) -> NedPose:
    """Point half-way between two ships at their closest approach; its course is zero."""
    moved = motion_of(waters, one, other)
    rx, ry, wx, wy, ovx, ovy, tvx, tvy = moved[:8]
    tcpa, _ = closest_approach(rx, ry, wx, wy)
    time = min(max(tcpa, 0.0), FORESIGHT) if math.isfinite(tcpa) else 0.0
    ox, oy, tx, ty = (moved[place] for place in _PLACES)
    x = ((ox + ovx * time) + (tx + tvx * time)) / 2.0
    y = ((oy + ovy * time) + (ty + tvy * time)) / 2.0
    frame = waters.waterway(one.waterway).frame(Towards.END)
    if one.waterway == other.waterway and not frame.is_straight:
        met = frame.to_ned(PathPose(x, y, 0.0))
        return NedPose(met.x, met.y, 0.0)
    return NedPose(x, y, 0.0)
