"""Waters as a chart shows them: waterways, junctions, obstacles, routes; `regions` has the laws.

Everything here is in the inertial frame {n}: arrays of points are (n, 2), north and east [m].
Only this module and `frames` know that a guiding line may bend.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from .frames import FloatArray, NedPose, PathFrame, PathTrajectory, frozen_array
from .regions import Hysteresis, Law, LawMap, Region
from .ships import Facts
from .surge_yaw import Current

if TYPE_CHECKING:
    from shapely import Point
    from shapely.geometry.base import BaseGeometry

BANK_MARGIN = 5.0  # water that the hull leaves free towards the bank [m]
OFFSET_LIMIT = 60.0  # y_max: bound of the cross-track offset (Table 1) [m]
_BEND_STEP = math.radians(5.0)  # a rounded corner turns by no more than this at a vertex [rad]
_HAIRPIN = 1e-9  # 1 + cos of a turn that has no mitre: the line goes back where it came from
_LEAST_CUT = 1.0  # a corner that is cut by less stays sharp [m]
_NARROWER = 0.8  # by which an arc that leaves the water is narrowed, again and again
_BEYOND_ENDS = 500.0  # banks go on past the ends of a centreline, so that arriving is not grounding [m]


class Towards(StrEnum):
    """The end of a centreline: where a leg leads, or where upstream is."""

    START = "start"
    END = "end"
    NONE = "none"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Waterway:
    """A reach with a centreline (n, 2), a width [m], and the end that lies upstream."""

    id: str
    centreline: FloatArray
    width: float
    upstream: Towards = Towards.NONE
    facts: Facts = field(default_factory=dict)
    _frames: tuple[PathFrame, PathFrame] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "centreline", frozen_array(self.centreline))
        there, back = PathFrame(self.centreline), PathFrame(self.centreline[::-1])
        object.__setattr__(self, "_frames", (there, back))

    def frame(self, towards: Towards) -> PathFrame:
        """Frame along the centreline in the sense of travel."""
        return self._frames[0] if towards is Towards.END else self._frames[1]

    def strip(self, first: float, last: float) -> BaseGeometry:
        """Water from bank to bank, from one distance [m] along the centreline to a greater one."""
        from shapely import LineString

        line = LineString(self.frame(Towards.END).stretch(first, last))
        return line.buffer(self.width / 2.0, cap_style="flat", join_style="mitre")

    def holds(self, pose: NedPose) -> bool:
        """Whether a position lies between the banks and the ends of the centreline."""
        frame = self.frame(Towards.END)
        here = frame.to_path(pose)
        return abs(here.y) <= self.width / 2.0 and 0.0 <= here.x <= frame.length


@dataclass(frozen=True, slots=True, kw_only=True)
class Obstacle:
    """Something that stays where it is: a circle."""

    id: str
    x: float  # north [m]
    y: float  # east [m]
    radius: float  # [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Waters:
    """A chart: the same for every ship.

    `ruleset`, `ID` or `ID@VERSION`, is in force outside of all regions; it is empty where they cover all.
    """

    ruleset: str
    waterways: tuple[Waterway, ...]
    regions: tuple[Region, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    hysteresis: Hysteresis = field(default_factory=Hysteresis)
    current: Current = field(default_factory=Current)  # drifts ships that are steered by surge and yaw rate
    _laws: LawMap = field(init=False, repr=False)
    _by_id: dict[str, Waterway] = field(init=False, repr=False)
    _junctions: dict[tuple[str, str], NedPose | None] = field(init=False, repr=False)  # found so far
    _banks: list[BaseGeometry] = field(init=False, repr=False)  # one, once it is drawn

    def __post_init__(self) -> None:
        by_id = {waterway.id: waterway for waterway in reversed(self.waterways)}  # the first of an id counts
        default = Law.parsed(self.ruleset) if self.ruleset or not self.regions else None
        object.__setattr__(self, "_laws", LawMap(default, self.regions))
        object.__setattr__(self, "_by_id", by_id)
        object.__setattr__(self, "_junctions", {})
        object.__setattr__(self, "_banks", [])

    def waterway(self, id_: str) -> Waterway:
        """Waterway by its id; `KeyError` where there is none."""
        return self._by_id[id_]

    @property
    def laws(self) -> LawMap:
        """Which law is in force where."""
        return self._laws

    def ruleset_at(self, pose: NedPose) -> str:
        """Id of the ruleset in force at a position."""
        return self._laws.at(pose).ruleset

    def junction(self, one: str, other: str) -> NedPose | None:
        """Centre of the intersection of two waterways, known to all ships; None if they do not meet."""
        pair = min(one, other), max(one, other)
        if pair not in self._junctions:
            point = _meeting_point(*(self.waterway(id_).centreline for id_ in pair))
            self._junctions[pair] = NedPose(float(point.x), float(point.y), 0.0) if point else None
        return self._junctions[pair]

    def banks(self) -> BaseGeometry:
        """Navigable water as one shape: the union of all waterways, prolonged past their ends."""
        if not self._banks:
            from shapely import prepare

            banks = self.water(_BEYOND_ENDS)
            prepare(banks)  # it is asked again and again
            self._banks.append(banks)
        return self._banks[0]

    def water(self, beyond: float = 0.0) -> BaseGeometry:
        """Union of all waterways, each prolonged by so much [m] past its ends."""
        from shapely import union_all

        return union_all(
            [each.strip(-beyond, each.frame(Towards.END).length + beyond) for each in self.waterways]
        )


def _meeting_point(one: FloatArray, other: FloatArray) -> Point | None:
    from shapely import LineString, Point

    meeting = LineString(one).intersection(LineString(other))
    if meeting.is_empty:
        return None
    return meeting if isinstance(meeting, Point) else meeting.representative_point()


@dataclass(frozen=True, slots=True)
class Leg:
    """Part of a route: along one waterway, beside its centreline."""

    waterway: str
    towards: Towards
    offset: float = 0.0  # of the guiding line from the centreline, starboard positive [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GuidingLine:
    """A route drawn on the chart: the line that guidance follows, and the leg at each distance."""

    frame: PathFrame
    legs: tuple[Leg, ...]
    leg_starts: tuple[float, ...]  # distance along the line at which each leg begins [m]
    widths: tuple[float, ...]  # of each leg's waterway [m]
    centrelines: tuple[PathFrame, ...]  # of each leg's waterway, in the sense of travel

    def leg_at(self, x: float) -> Leg:
        """Leg at a distance [m] along the line."""
        return self.legs[self._index(x)]

    def offset_limits(self, x: float, beam: float) -> tuple[float, float]:
        """Least and greatest cross-track offset [m] that keep a hull between the banks, and within y_max."""
        low, high = self.offset_limits_at(np.array([x]), beam)[0].tolist()
        return low, high

    def offset_limits_at(self, x: FloatArray, beam: float) -> FloatArray:
        """As `offset_limits`, at each of several distances along the line, (n, 2) [m]."""
        return np.minimum(np.maximum(self.room_at(x, beam), -OFFSET_LIMIT), OFFSET_LIMIT)

    def room_at(self, x: FloatArray, beam: float) -> FloatArray:
        """Least and greatest offset at which a hull keeps its margin to the banks, (n, 2) [m].

        Where a line runs so near to a bank that not even zero offset has the margin, zero
        remains allowed: the line itself was chosen by the user.
        """
        limits = np.empty((len(x), 2))
        leg = np.maximum(np.searchsorted(self.leg_starts, x, side="right") - 1, 0)
        for index in sorted(set(leg.tolist())):
            at = leg == index
            room = self.widths[index] / 2.0 - beam / 2.0 - BANK_MARGIN
            offset = (
                np.full(np.sum(at), self.legs[index].offset)
                if self.frame.is_straight
                else self._beside_centreline(index, x[at])
            )
            limits[at, 0] = np.minimum(0.0, -room - offset)
            limits[at, 1] = np.maximum(0.0, room - offset)
        return limits

    def _beside_centreline(self, index: int, x: FloatArray) -> FloatArray:
        """Offset of the line from the centreline [m]; on a rounded corner it is not that of the leg."""
        on_line = np.zeros((len(x), 3))
        on_line[:, 0] = x
        there = self.frame.trajectory_to_ned(PathTrajectory(on_line))
        return self.centrelines[index].trajectory_to_path(there).poses[:, 1]

    def _index(self, x: float) -> int:
        return max(0, bisect_right(self.leg_starts, x) - 1)


def guiding_line(waters: Waters, legs: Sequence[Leg], turn_radius: float = 300.0) -> GuidingLine:
    """Draw a route on the chart; corners are rounded with `turn_radius` [m] where there is room.

    Raises
    ------
    ValueError
        If two legs that follow one another do not meet or double back, or a centreline turns back on itself.
    """
    sailed: list[FloatArray] = []  # what lies behind the leg at hand
    current = _beside(waters, legs[0])
    joins: list[FloatArray] = []
    for before, after in pairwise(legs):
        if before.waterway == after.waterway and before.towards is not after.towards:
            raise ValueError(f"the legs along {before.waterway!r} double back")
        names = f"{before.waterway!r} and {after.waterway!r}"
        head, join, tail = _joined(current, _beside(waters, after), names)
        sailed.append(head)
        joins.append(join)
        current = np.vstack([join, tail])
    corners = _distinct(np.vstack([*sailed, current]))
    if len(corners) > 2:
        corners = _rounded(corners, turn_radius, waters.banks())
    frame = PathFrame(corners)
    starts = [0.0] + [frame.to_path(NedPose(float(join[0]), float(join[1]), 0.0)).x for join in joins]
    waterways = [waters.waterway(leg.waterway) for leg in legs]
    return GuidingLine(
        frame=frame,
        legs=tuple(legs),
        leg_starts=tuple(starts),
        widths=tuple(waterway.width for waterway in waterways),
        centrelines=tuple(waterway.frame(leg.towards) for waterway, leg in zip(waterways, legs, strict=True)),
    )


def _beside(waters: Waters, leg: Leg) -> FloatArray:
    """Line beside the centreline of a leg, in the sense of travel, mitred at its bends."""
    line = waters.waterway(leg.waterway).frame(leg.towards).vertices
    steps = np.diff(line, axis=0)
    steps = steps / np.hypot(steps[:, 0], steps[:, 1])[:, None]
    starboard = np.column_stack([-steps[:, 1], steps[:, 0]])
    before, after = np.vstack([starboard[:1], starboard]), np.vstack([starboard, starboard[-1:]])
    mitre: FloatArray = before + after
    reach: FloatArray = np.einsum("nk,nk->n", mitre, before)  # 1 + cos of the turn
    if np.any(reach < _HAIRPIN):
        raise ValueError(f"the centreline of {leg.waterway!r} turns back on itself")
    return line + leg.offset * mitre / reach[:, None]


def _joined(first: FloatArray, second: FloatArray, names: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Follow the first line to the point where it meets the second, then the second: head, join, tail.

    A waterway may end at another's centreline; then the lines beside them are prolonged to one another.
    """
    from shapely import LineString, Point

    point = _meeting_point(first, second)
    if point is None:
        first, second = _prolonged(first, last=True), _prolonged(second, last=False)
        point = _meeting_point(first, second)
    if point is None:
        raise ValueError(f"the legs along {names} do not meet")
    one, two = LineString(first), LineString(second)
    until, since = one.project(point), two.project(point)
    head = [xy for xy in first if one.project(Point(xy)) < until - 1e-6]
    tail = [xy for xy in second if two.project(Point(xy)) > since + 1e-6]
    if not head and not tail:
        raise ValueError(f"the legs along {names} double back")
    join = np.array([point.x, point.y])
    return np.reshape(head, (len(head), 2)), join, np.reshape(tail, (len(tail), 2))


def _prolonged(line: FloatArray, *, last: bool) -> FloatArray:
    """Carry a line on beyond its last vertex, or before its first, by y_max."""
    end, inner = (line[-1], line[-2]) if last else (line[0], line[1])
    beyond = end + OFFSET_LIMIT * (end - inner) / np.hypot(*(end - inner))
    return np.vstack([line, beyond]) if last else np.vstack([beyond, line])


def _rounded(corners: FloatArray, radius: float, banks: BaseGeometry) -> FloatArray:
    """Replace each corner by an arc of short chords, tangent to both sides and between the banks."""
    points = [corners[:1]]
    for before, corner, after in zip(corners, corners[1:], corners[2:], strict=False):
        points.append(_arc(before, corner, after, radius, banks))
    points.append(corners[-1:])
    return _distinct(np.vstack(points))


def _arc(
    before: FloatArray, corner: FloatArray, after: FloatArray, radius: float, banks: BaseGeometry
) -> FloatArray:
    """Chords of the widest arc of at most `radius` that rounds a corner without leaving the water."""
    from shapely import LineString

    come, go = corner - before, after - corner
    come_length, go_length = np.hypot(*come), np.hypot(*go)
    come, go = come / come_length, go / go_length
    turn = math.atan2(come[0] * go[1] - come[1] * go[0], float(come @ go))
    if abs(turn) < _BEND_STEP or abs(turn) > math.pi - 1e-6:
        return corner[None]
    cut = min(radius * math.tan(abs(turn) / 2.0), come_length / 2.0, go_length / 2.0)
    while cut > _LEAST_CUT:
        arc = cut / math.tan(abs(turn) / 2.0)
        entry = corner - cut * come
        centre = entry + math.copysign(arc, turn) * np.array([-come[1], come[0]])
        angles = np.linspace(0.0, turn, math.ceil(abs(turn) / _BEND_STEP) + 1)
        cos, sin = np.cos(angles), np.sin(angles)
        spoke = entry - centre
        chords: FloatArray = centre + np.column_stack(
            [spoke[0] * cos - spoke[1] * sin, spoke[0] * sin + spoke[1] * cos]
        )
        if banks.covers(LineString(chords)):
            return chords
        cut *= _NARROWER
    return corner[None]


def _distinct(points: FloatArray) -> FloatArray:
    """Leave out vertices that repeat the one before."""
    kept = [points[0]]
    for point in points[1:]:
        if np.hypot(*(point - kept[-1])) > 1e-6:
            kept.append(point)
    return np.array(kept)
