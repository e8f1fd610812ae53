"""Positions of a scenario file, as points of one plane: north and east [m]."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Final, TypeAlias

from ..quantities import LENGTH, NUMBER, Quantity, Range
from ..strict_yaml import Reader
from ..units import KILOMETRE
from ..yaml_nodes import Mapping, Node

if TYPE_CHECKING:
    from pyproj import Transformer

Point: TypeAlias = tuple[float, float]  # north, east [m]
_COORDINATE: Final = Range(at_least=-1e7, at_most=1e7)
_SAME_POINT: Final = 1e-3  # [m]
_LEAST_EXTENT: Final = 5.0  # of a waterway or a region that can be meant in metres [m]
IN_DEGREES: Final = "a position in degrees is {lonlat: [longitude, latitude]}, throughout the file"
_FARTHEST: Final = 500.0 * KILOMETRE  # from the first lonlat position: there the plane is still flat enough


class Plane:
    """Reads positions: [east, north] in metres or lonlat in degrees, but not both in one file.

    Lonlat positions are laid on the plane that touches the earth at the first of them that is
    read: the first point of the first waterway (azimuthal equidistant projection).
    """

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self._firsts: dict[str, Node] = {}
        self._projection: Transformer | None = None

    @property
    def in_degrees(self) -> bool:
        """Whether positions of this file are lonlat."""
        return "lonlat" in self._firsts

    def points(self, node: Node, at_least: int) -> list[Point]:
        """Points of a line, of which no neighbours are the same."""
        places = self._reader.items(node, at_least)
        points = [self.point(each) for each in places]
        for place, (before, point) in zip(places[1:], pairwise(points), strict=True):
            if math.dist(before, point) < _SAME_POINT:
                self._reader.refuse(place, "the same point as the one before", hint="remove one")
        return points

    def may_be_degrees(self, points: Sequence[Point]) -> bool:
        """Whether points that were read as metres are no larger than degrees are."""
        in_range = all(abs(north) <= 90.0 and abs(east) <= 180.0 for north, east in points)
        return in_range and not self.in_degrees

    def are_degrees(self, points: Sequence[Point]) -> bool:
        """Whether they may be, and are besides smaller than any ship, and away from the origin."""
        spans = [(min(each), max(each)) for each in zip(*points, strict=True)]
        around_origin = all(low <= 0.0 <= high for low, high in spans)
        extent = max((high - low for low, high in spans), default=0.0)
        return extent < _LEAST_EXTENT and not around_origin and self.may_be_degrees(points)

    def point(self, node: Node) -> Point:
        """A position as north and east [m]."""
        if not isinstance(node, Mapping):
            east, north = self._pair(node, "[east, north]", LENGTH, (_COORDINATE, _COORDINATE))
            return north, east
        block = self._reader.block(node)
        bounds = Range(at_least=-180.0, at_most=180.0), Range(at_least=-90.0, at_most=90.0)
        lon, lat = self._pair(block.require("lonlat"), "lonlat", NUMBER, bounds)
        return self._projected(node, lon, lat) if block.done() else (math.nan, math.nan)

    def _pair(self, node: Node, kind: str, quantity: Quantity, bounds: tuple[Range, Range]) -> Point:
        hint = "a position is [east, north] in metres, or {lonlat: [longitude, latitude]}"
        items = self._reader.items(node, 2, 2, hint=hint)
        if len(items) != 2:
            return math.nan, math.nan
        if kind not in self._firsts and self._firsts:
            (other, first), *_ = self._firsts.items()
            hint = f"this file began with {other}, at line {first.line}; write all positions in that way"
            self._reader.refuse(node, f"{kind} and {other} positions in one file", hint=hint)
        self._firsts.setdefault(kind, node)
        one, two = (
            self._reader.number(each, quantity, within, bare=True)
            for each, within in zip(items, bounds, strict=True)
        )
        return one, two

    def _projected(self, node: Node, lon: float, lat: float) -> Point:
        if self._projection is None:
            self._projection = _projection(lon, lat)
        east, north = self._projection.transform(lon, lat)
        if not math.hypot(east, north) < _FARTHEST:
            hint = "lonlat is [longitude, latitude], in this order"
            distance = f"more than {_FARTHEST / KILOMETRE:.0f} km"
            self._reader.refuse(node, f"{distance} from the first position", hint=hint)
        return LENGTH.keep(north), LENGTH.keep(east)


def _projection(lon: float, lat: float) -> Transformer:
    from pyproj import Transformer

    plane = f"+proj=aeqd +lon_0={lon} +lat_0={lat} +datum=WGS84 +units=m"
    return Transformer.from_crs("EPSG:4326", plane, always_xy=True)
