"""Places beside a polyline, and back: the loops of `frames`, whose words and conventions hold here."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Final, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .compiling import fast

WORTH: Final = 3  # poses for which it is worth while to load compiled loops

_Array: TypeAlias = NDArray[np.float64]
# Vertices and tangents (n, 2), courses, distances; least and greatest foot on each segment.
Line: TypeAlias = tuple[_Array, _Array, _Array, _Array, _Array, _Array]


class Loops(NamedTuple):
    """The two ways between a line and the plane."""

    into: Callable[[Line, int, int, _Array, _Array], None]
    out_of: Callable[[Line, _Array, _Array], None]


def loops(poses: int) -> Loops:
    """Choose the loops for so many poses: compiled ones, unless they are few and none are loaded yet."""
    if poses < WORTH and not _compiled.cache_info().currsize:
        return Loops(find_places, find_poses)
    return _compiled()


@cache
def _compiled() -> Loops:
    return Loops(*fast(find_places, find_poses))


def find_places(line: Line, first: int, last: int, poses: _Array, found: _Array) -> None:
    """Read poses of the plane beside a line whose nearest segments lie from `first` until before `last`."""
    vertices, tangents, courses, distances, lower, upper = line
    for m in range(len(poses)):
        least, nearest, along, foot, gap_x, gap_y = math.inf, first, 0.0, 0.0, 0.0, 0.0
        for n in range(first, last):
            away_x, away_y = poses[m, 0] - vertices[n, 0], poses[m, 1] - vertices[n, 1]
            here = away_x * tangents[n, 0] + away_y * tangents[n, 1]
            on_line = lower[n] if here < lower[n] else min(here, upper[n])
            x, y = away_x - on_line * tangents[n, 0], away_y - on_line * tangents[n, 1]
            square = x * x + y * y
            if square < least or n == first:
                least, nearest, along, foot, gap_x, gap_y = square, n, here, on_line, x, y
        found[m, 0] = distances[nearest] + foot
        found[m, 1] = tangents[nearest, 0] * gap_y - tangents[nearest, 1] * gap_x
        if along != foot:  # outside of a bend: distance to its corner
            corner = min(max(nearest + 1 if along > foot else nearest, 1), len(tangents) - 1)
            outside = tangents[corner, 0] * tangents[corner - 1, 1]
            outside -= tangents[corner, 1] * tangents[corner - 1, 0]  # of a bend to starboard: to port
            found[m, 1] = math.copysign(math.hypot(gap_x, gap_y), outside)
        turn = poses[m, 2] - courses[nearest]
        found[m, 2] = math.atan2(math.sin(turn), math.cos(turn))


def find_poses(line: Line, poses: _Array, found: _Array) -> None:
    """Read poses beside a line in the plane."""
    vertices, tangents, courses, distances, _, _ = line
    for m in range(len(poses)):
        n = min(max(np.searchsorted(distances, poses[m, 0], side="right") - 1, 0), len(tangents) - 1)
        along, aside = poses[m, 0] - distances[n], poses[m, 1]
        found[m, 0] = vertices[n, 0] + along * tangents[n, 0] - aside * tangents[n, 1]
        found[m, 1] = vertices[n, 1] + along * tangents[n, 1] + aside * tangents[n, 0]
        found[m, 2] = poses[m, 2] + courses[n]
