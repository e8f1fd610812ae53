"""Hulls along tracks: clearance, collision, entry, grounding, contact with obstacles.

Between periods positions are followed at steps of at most 1 s (contract).  Hulls are rectangles,
length by beam, along the course, in the inertial frame {n}.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from ..frames import FloatArray, PathFrame, PathPose, frozen_array
from ..ships import Ship, ShipId
from ..waterway import Obstacle
from .frame import Frame, ShipFrame

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

Polygons: TypeAlias = NDArray[Any]  # of shapely polygons: NumPy knows them as objects only

STEP: Final = 1.0  # greatest time between two looks at a pair of hulls [s]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Track:
    """Where a ship was while it was under way: `poses` is (K, 3), columns as in `NedPose`.

    From row k to row k + 1 it sails straight, on the course of row k + 1 (`sim.frame`).
    """

    ship: Ship
    times: FloatArray  # (K,), rising [s]
    poses: FloatArray

    def __post_init__(self) -> None:
        times, poses = frozen_array(self.times), frozen_array(self.poses)
        if times.ndim != 1 or not len(times) or poses.shape != (len(times), 3):
            raise ValueError(f"a track is (K,) and (K, 3) with K >= 1, got {times.shape} and {poses.shape}")
        if not np.all(np.diff(times) > 0.0):
            raise ValueError(f"times of the track of {self.ship.id!r} do not rise")
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "poses", poses)

    def at(self, times: FloatArray) -> FloatArray:
        """Poses (m, 3) at instants (m,) of the track; at a row itself, its own course."""
        north = np.interp(times, self.times, self.poses[:, 0])
        east = np.interp(times, self.times, self.poses[:, 1])
        row = np.clip(np.searchsorted(self.times, times, side="left"), 0, len(self.times) - 1)
        return np.column_stack([north, east, self.poses[row, 2]])


def under_way(frame: Frame) -> dict[ShipId, ShipFrame]:
    """Ships of a frame that have not arrived."""
    return {id_: ship for id_, ship in frame.ships.items() if id_ not in frame.arrived}


def states(frames: Iterable[Frame], id_: ShipId) -> Iterator[ShipFrame]:
    """States of one ship, in all frames in which it is under way."""
    return (ships[id_] for frame in frames if id_ in (ships := under_way(frame)))


def track(ship: Ship, line: PathFrame, frames: Iterable[Frame]) -> Track:
    """Track of a ship through frames in which it is under way, up to its arrival.

    Where no frame shows it past the end of its route, it is taken to sail there beside its guiding line.
    """
    rows: list[tuple[float, float, float, float]] = []
    offset = 0.0
    for frame in frames:
        now = frame.ships.get(ship.id)
        if ship.id not in frame.arrived and now is not None:
            rows.append((frame.time, now.pose.x, now.pose.y, now.pose.course))
            offset = now.path_y
        elif ship.id in frame.arrived and rows:
            arrival, last = frame.arrived[ship.id], rows[-1]
            end, share = line.to_ned(PathPose(line.length, offset, 0.0)), 1.0
            if now is not None:
                end, share = now.pose, (arrival - last[0]) / (frame.time - last[0])
            if arrival > last[0]:
                north, east = last[1] + share * (end.x - last[1]), last[2] + share * (end.y - last[2])
                rows.append((arrival, north, east, end.course))
            break
    if not rows:
        raise ValueError(f"ship {ship.id!r} is under way in none of the frames")
    table = np.array(rows)
    return Track(ship=ship, times=table[:, 0], poses=table[:, 1:])


@dataclass(frozen=True, slots=True, kw_only=True)
class Meeting:
    """What became of two ships over the time in which both were under way."""

    pair: tuple[ShipId, ShipId]  # sorted
    clearance: float  # least distance between the hulls [m]
    time: float  # of the least clearance [s]
    entry: bool  # a hull met the other's safety rectangle

    @property
    def collision(self) -> bool:
        """Whether the hulls overlapped, or touched."""
        return self.clearance == 0.0


def rectangles(poses: FloatArray, length: float, beam: float) -> Polygons:
    """Rectangles (m,) around poses (m, 3), along the course."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    along = np.column_stack([cos, sin])[:, None, :] * (length / 2.0)
    across = np.column_stack([-sin, cos])[:, None, :] * (beam / 2.0)
    signs = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]])
    corners = poses[:, None, :2] + signs[None, :, :1] * along + signs[None, :, 1:] * across
    return np.asarray(shapely.polygons(corners))


def hulls(ship: Ship, poses: FloatArray) -> Polygons:
    """Hull of a ship at each of its poses."""
    return rectangles(poses, ship.hull.length, ship.hull.beam)


def safety_rectangles(ship: Ship, poses: FloatArray) -> Polygons:
    """Safety area of a ship at each of its poses."""
    return rectangles(poses, ship.hull.safety_length, ship.hull.safety_beam)


def clearance(one: Track, other: Track) -> tuple[FloatArray, FloatArray]:
    """Instants at which both ships are under way, and the clearance [m] at each; empty if there are none."""
    times = instants(one, other)
    return times, clearances(one, other, times)


def instants(one: Track, other: Track) -> FloatArray:
    """Instants at which both ships are under way, at steps of at most `STEP` [s]."""
    return _fine(*_segments(_knots(one, other)))


def clearances(one: Track, other: Track, times: FloatArray) -> FloatArray:
    """Distance between the hulls (m,) at instants (m,) [m]."""
    here, there = hulls(one.ship, one.at(times)), hulls(other.ship, other.at(times))
    return np.asarray(shapely.distance(here, there), dtype=np.float64)


def meeting(one: Track, other: Track) -> Meeting | None:
    """Say what became of two ships; None if they were never under way at the same time."""
    near = _Nearness.of(one, other)
    return None if near is None else near.look(one, other)


def meetings(tracks: Sequence[Track]) -> tuple[Meeting, ...]:
    """All meetings that can matter: the nearest of every ship, and all near enough for an entry.

    Other pairs are left out by their centre distances alone, so that many ships are cheap.  The least
    clearance of every ship is exact.
    """
    near = ((tracks[one], tracks[other]) for one, other in _worth_a_look(tracks))
    return tuple(met for one, other in near if (met := meeting(one, other)))


def _worth_a_look(tracks: Sequence[Track]) -> list[tuple[int, int]]:
    """Pairs that can matter, by the distances of the centres at all rows of all tracks."""
    if len(tracks) < 2:
        return []
    times = np.unique(np.concatenate([each.times for each in tracks]))
    centres = np.stack([each.at(times)[:, :2] for each in tracks])
    for each, centre in zip(tracks, centres, strict=True):
        centre[(times < each.times[0]) | (times > each.times[-1])] = np.nan
    apart = [np.hypot(*np.moveaxis(centres - own, 2, 0)) for own in centres]
    nearest = np.array([np.where(np.isnan(each), np.inf, each).min(axis=1) for each in apart])
    np.fill_diagonal(nearest, np.inf)
    steps = np.hypot(*np.moveaxis(np.diff(centres, axis=1), 2, 0))
    step = np.where(np.isnan(steps), 0.0, steps).max(axis=1, initial=0.0)
    hull = [each.ship.hull for each in tracks]
    radius = np.array([_radius(each.length, each.beam) for each in hull])
    area = np.array([_radius(each.safety_length, each.safety_beam) for each in hull])
    inner = np.array([min(each.length, each.beam) / 2.0 for each in hull])
    between = nearest - _sums(step) / 2.0  # no less than this, also between two rows
    best = np.maximum(nearest - _sums(inner), 0.0).min(axis=1)
    for_entry = between <= _sums(np.maximum(area, radius))
    for_clearance = between - _sums(radius) <= np.maximum(best[:, None], best)
    worth = np.isfinite(nearest) & (for_entry | for_clearance)
    return [(int(one), int(other)) for one, other in np.argwhere(np.triu(worth))]


def _sums(each: FloatArray) -> FloatArray:
    return each[:, None] + each


def is_grounded(sailed: Track, banks: BaseGeometry) -> bool:
    """Whether the hull was ever outside the banks."""
    poses = sailed.at(instants(sailed, sailed))
    clear = shapely.buffer(banks, -_radius(sailed.ship.hull.length, sailed.ship.hull.beam))
    doubtful = poses[~shapely.contains_xy(clear, poses[:, 0], poses[:, 1])]
    if not len(doubtful):
        return False
    shapely.prepare(banks)
    return not bool(np.all(shapely.covers(banks, hulls(sailed.ship, doubtful))))


def obstacles_struck(sailed: Track, obstacles: Iterable[Obstacle]) -> tuple[Obstacle, ...]:
    """Obstacles that the hull touched."""
    poses = sailed.at(instants(sailed, sailed))
    reach = _radius(sailed.ship.hull.length, sailed.ship.hull.beam)
    struck = []
    for obstacle in obstacles:
        away = np.hypot(poses[:, 0] - obstacle.x, poses[:, 1] - obstacle.y)
        near = poses[away <= reach + obstacle.radius]
        centre = shapely.Point(obstacle.x, obstacle.y)
        if np.any(shapely.distance(hulls(sailed.ship, near), centre) <= obstacle.radius):
            struck.append(obstacle)
    return tuple(struck)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Nearness:
    """What the centre distances of two ships say of their clearance, before any hull is drawn."""

    knots: FloatArray  # (K,): rows of either track while both are under way [s]
    least: FloatArray  # (max(K - 1, 1),): least centre distance between two knots [m]
    at_most: float  # bound of the least clearance [m]
    hull_reach: float  # no contact of hulls beyond this centre distance [m]
    safety_reach: float  # no entry beyond it [m]

    @classmethod
    def of(cls, one: Track, other: Track) -> _Nearness | None:
        knots = _knots(one, other)
        if not len(knots):
            return None
        apart = (other.at(knots) - one.at(knots))[:, :2]
        first, step = (apart[:-1], np.diff(apart, axis=0)) if len(knots) > 1 else (apart, 0.0 * apart)
        squared = np.einsum("kc,kc->k", step, step)
        foot = -np.einsum("kc,kc->k", first, step) / np.where(squared > 0.0, squared, 1.0)
        nearest = first + np.clip(foot, 0.0, 1.0)[:, None] * step
        least = np.hypot(nearest[:, 0], nearest[:, 1])
        one_hull, other_hull = one.ship.hull, other.ship.hull
        radii = [_radius(hull.length, hull.beam) for hull in (one_hull, other_hull)]
        areas = [_radius(hull.safety_length, hull.safety_beam) for hull in (one_hull, other_hull)]
        inner = sum(min(hull.length, hull.beam) / 2.0 for hull in (one_hull, other_hull))
        return cls(
            knots=knots,
            least=least,
            at_most=max(0.0, float(np.hypot(apart[:, 0], apart[:, 1]).min()) - inner),
            hull_reach=sum(radii),
            safety_reach=max(radii[0] + areas[1], areas[0] + radii[1]),
        )

    def look(self, one: Track, other: Track) -> Meeting:
        """Draw the hulls where it matters."""
        worth = self.least <= max(self.at_most + self.hull_reach, self.safety_reach)
        begins, ends = _segments(self.knots)
        times = _fine(begins[worth], ends[worth])
        apart = clearances(one, other, times)
        closest = int(np.argmin(apart))
        first, second = sorted((one.ship.id, other.ship.id))
        return Meeting(
            pair=(first, second),
            clearance=float(apart[closest]),
            time=float(times[closest]),
            entry=self._entry(one, other, times),
        )

    def _entry(self, one: Track, other: Track, times: FloatArray) -> bool:
        here, there = one.at(times), other.at(times)
        near = np.hypot(*(there - here)[:, :2].T) <= self.safety_reach
        here, there = here[near], there[near]
        into_one = shapely.intersects(safety_rectangles(one.ship, here), hulls(other.ship, there))
        into_other = shapely.intersects(safety_rectangles(other.ship, there), hulls(one.ship, here))
        return bool(np.any(into_one) or np.any(into_other))


def _knots(one: Track, other: Track) -> FloatArray:
    """Rows of either track in the time that they share."""
    begin, end = max(one.times[0], other.times[0]), min(one.times[-1], other.times[-1])
    times = np.union1d(one.times, other.times)
    return np.asarray(times[(times >= begin) & (times <= end)], dtype=np.float64)


def _segments(knots: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Begin and end of each stretch between knots; a single knot is a stretch of no length."""
    return (knots[:-1], knots[1:]) if len(knots) > 1 else (knots, knots)


def _fine(begins: FloatArray, ends: FloatArray) -> FloatArray:
    """Instants from each begin to its end, both included, at steps of at most `STEP`."""
    counts = np.maximum(np.ceil((ends - begins) / STEP), 1.0).astype(int)
    nth = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    begin, end, count = (np.repeat(each, counts) for each in (begins, ends, counts))
    return np.union1d(begin + nth / count * (end - begin), ends)


def _radius(length: float, breadth: float) -> float:
    """Of the circle around a rectangle [m]."""
    return math.hypot(length, breadth) / 2.0
