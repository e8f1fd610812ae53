"""Which law is in force where: regions, their precedence, and how a ship goes over from one law to another.

A *law* is a ruleset in a version.  Everything here is in the inertial frame {n}.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING, Final

from .frames import FloatArray, NedPose, frozen_array

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

_FARTHEST: Final = 1e8  # corner of the plane, beyond all that a chart may hold [m]
_TOUCHING: Final = 1.0  # area up to which regions only touch: corners are rounded [m2]
_BESIDE: Final = 1.0  # distance up to which waters are neighbours [m]


@dataclass(frozen=True, slots=True)
class Law:
    """A ruleset by its id, in one version, or in whichever is aboard.

    >>> Law.parsed("ccnr@2022.3.26"), str(Law("bpr"))
    (Law(ruleset='ccnr', version='2022.3.26'), 'bpr')
    """

    ruleset: str
    version: str = ""  # whichever is aboard, where it is empty

    def __str__(self) -> str:
        return f"{self.ruleset}@{self.version}" if self.version else self.ruleset

    @classmethod
    def parsed(cls, text: str) -> Law:
        """Read `ID` or `ID@VERSION`."""
        ruleset, _, version = text.partition("@")
        return cls(ruleset, version)

    def is_met_by(self, ruleset: str, version: str) -> bool:
        """Whether a ruleset in a version is the one that this law asks for."""
        return ruleset == self.ruleset and self.version in ("", version)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Region:
    """Part of the waters with a ruleset of its own: a polygon (n, 2), north and east [m].

    `ruleset` is `ID` or `ID@VERSION`.  Where regions overlap, the one with the greatest precedence prevails.
    """

    id: str
    ruleset: str
    polygon: FloatArray
    precedence: int = 0
    _shape: list[BaseGeometry] = field(init=False, repr=False)  # one, once it is asked for
    _box: tuple[float, float, float, float] = field(init=False, repr=False)  # least and greatest coordinates

    def __post_init__(self) -> None:
        object.__setattr__(self, "polygon", frozen_array(self.polygon))
        object.__setattr__(self, "_shape", [])
        (south, west), (north, east) = self.polygon.min(axis=0).tolist(), self.polygon.max(axis=0).tolist()
        object.__setattr__(self, "_box", (south, west, north, east))

    @property
    def law(self) -> Law:
        """Law of the region."""
        return Law.parsed(self.ruleset)

    @property
    def shape(self) -> BaseGeometry:
        """The polygon, ready to be asked again and again."""
        if not self._shape:
            from shapely import Polygon, prepare

            polygon = Polygon(self.polygon)
            prepare(polygon)
            self._shape.append(polygon)
        return self._shape[0]

    def holds(self, pose: NedPose) -> bool:
        """Whether a position lies in the region, its border included."""
        south, west, north, east = self._box
        if not (south <= pose.x <= north and west <= pose.y <= east):
            return False  # most are far away, and that is told at once
        from shapely import intersects_xy

        return bool(intersects_xy(self.shape, pose.x, pose.y))


@dataclass(frozen=True, slots=True, kw_only=True)
class Hysteresis:
    """What keeps a ship that sails along a border from changing its law again and again."""

    width: float = 10.0  # so near to waters under its present law a ship keeps it [m]
    time: float = 60.0  # and for so long after it has changed [s]


@dataclass(frozen=True, slots=True)
class InForce:
    """Law that a ship sails under, and since when."""

    law: Law
    since: float = -math.inf  # [s]; never changed, unless stated


class LawMap:
    """The laws of a chart: of its regions, and elsewhere the default, or that of the nearest region.

    Parameters
    ----------
    default
        Law outside of all regions; None where they cover all waters.
    regions
        At least one, or a default.

    Attributes
    ----------
    everywhere
        The one law of a chart without regions; None where there are some.
    """

    def __init__(self, default: Law | None, regions: Sequence[Region]) -> None:
        if default is None and not regions:
            raise ValueError("waters need a ruleset or a region")
        self.default = default
        self.regions = tuple(sorted(regions, key=lambda each: -each.precedence))  # stable
        self.everywhere = None if self.regions else default
        self._areas: dict[Law, BaseGeometry] = {}

    @property
    def laws(self) -> tuple[Law, ...]:
        """All laws of the chart, each once, the default first."""
        laws = [each.law for each in self.regions]
        return tuple(dict.fromkeys(laws if self.default is None else [self.default, *laws]))

    def at(self, pose: NedPose) -> Law:
        """Law in force at a position."""
        for region in self.regions:
            if region.holds(pose):
                return region.law
        return self.default or self._nearest(pose)

    def _nearest(self, pose: NedPose) -> Law:
        from shapely import Point

        here = Point(pose.x, pose.y)
        return min(self.regions, key=lambda each: each.shape.distance(here)).law

    def area(self, law: Law) -> BaseGeometry:
        """All of the plane that is under a law."""
        if law not in self._areas:
            self._areas[law] = self._drawn_area(law)
        return self._areas[law]

    def _drawn_area(self, law: Law) -> BaseGeometry:
        from shapely import GeometryCollection, box, difference, union_all

        taken: BaseGeometry = GeometryCollection()
        parts = []
        for region in self.regions:
            if region.law == law:
                parts.append(difference(region.shape, taken))
            taken = union_all([taken, region.shape])
        if law == self.default:
            plane = box(-_FARTHEST, -_FARTHEST, _FARTHEST, _FARTHEST)
            parts.append(difference(plane, taken))
        return union_all(parts)

    def is_near(self, law: Law, pose: NedPose, width: float) -> bool:
        """Whether water under a law is no farther than `width` [m] from a position."""
        from shapely import Point

        return bool(self.area(law).distance(Point(pose.x, pose.y)) <= width)

    def in_force(self, pose: NedPose, now: float, before: InForce | None, hysteresis: Hysteresis) -> InForce:
        """Law that a ship sails under, from where it is and what it sailed under before.

        It goes over once it is farther than `hysteresis.width` from all water under its present law, and not
        sooner than `hysteresis.time` after it last went over.
        """
        here = self.at(pose)
        if before is None:
            return InForce(here)
        if here == before.law or now - before.since < hysteresis.time:
            return before
        return before if self.is_near(before.law, pose, hysteresis.width) else InForce(here, now)

    def borders(self, water: BaseGeometry) -> Iterator[tuple[Law, Law]]:
        """Pairs of laws that are neighbours on the water."""
        wet = [(law, self.area(law).intersection(water)) for law in self.laws]
        for (one, here), (other, there) in combinations(wet, 2):
            if not here.is_empty and not there.is_empty and here.distance(there) <= _BESIDE:
                yield one, other

    def uncovered(self, water: BaseGeometry) -> NedPose | None:
        """A position on the water that lies in no region; None where there is none, or there is a default."""
        from shapely import difference, union_all

        if self.default is not None:
            return None
        left = difference(water, union_all([each.shape for each in self.regions]))
        if left.area <= _TOUCHING:
            return None
        point = left.representative_point()
        return NedPose(point.x, point.y, 0.0)


def contested(regions: Sequence[Region]) -> Iterator[tuple[Region, Region]]:
    """Pairs of regions that overlap, with neither prevailing, although their laws differ."""
    for one, other in combinations(regions, 2):
        if one.law == other.law or one.precedence != other.precedence:
            continue
        if one.shape.intersection(other.shape).area > _TOUCHING:
            yield one, other
