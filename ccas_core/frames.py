"""Inertial frame {n} and path frames {w_i}, and the one way between them (Sec. 2.1).

The inertial frame is north-east-down: x north, y east, course clockwise from north.  The path
frame of ship i runs along its guiding line: x is the distance along the line, y the offset to
*starboard*, and the course is taken relative to the line.  A pose says by its type which frame
it is in; `PathFrame` alone converts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Final, TypeAlias, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .polyline import Line, loops
from .units import wrap

FloatArray: TypeAlias = NDArray[np.float64]
FEW: Final = 50  # segments of a line that are quicker looked at than sorted out


def frozen_array(values: ArrayLike) -> FloatArray:
    """Copy into an array of floats that nobody can write to; one that is so already is kept."""
    if _is_frozen(values):
        return values
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def _is_frozen(values: object) -> TypeGuard[FloatArray]:
    if not isinstance(values, np.ndarray) or values.dtype != np.float64:
        return False
    return values.base is None and not values.flags.writeable


@dataclass(frozen=True, slots=True)
class NedPose:
    """Where a ship is in the inertial frame {n}."""

    x: float  # north [m]
    y: float  # east [m]
    course: float  # clockwise from north [rad]


@dataclass(frozen=True, slots=True)
class PathPose:
    """Where a ship is in a path frame {w_i}."""

    x: float  # along the guiding line [m]
    y: float  # offset to starboard of it [m]
    course: float  # relative to it [rad]


@dataclass(frozen=True, slots=True, eq=False)
class NedTrajectory:
    """Poses over the horizon in {n}: `poses` is (N + 1, 3), columns as in `NedPose`."""

    poses: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "poses", _checked(self.poses))


@dataclass(frozen=True, slots=True, eq=False)
class PathTrajectory:
    """Poses over the horizon in {w_i}: `poses` is (N + 1, 3), columns as in `PathPose`."""

    poses: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "poses", _checked(self.poses))


def _checked(poses: FloatArray) -> FloatArray:
    if poses.ndim != 2 or poses.shape[1] != 3:
        raise ValueError(f"a trajectory is (N + 1, 3), got {poses.shape}")
    return frozen_array(poses)


@dataclass(frozen=True, slots=True, eq=False)
class PathFrame:
    """The path frame {w_i} of a guiding line.

    On a straight line this is the rotation R_i and shift of Sec. 2.1.  On a bent line, the
    nearest point of the line gives x, and before its first and after its last vertex the line
    goes on straight.

    Parameters
    ----------
    vertices
        Corners of the guiding line in {n}, (n, 2), columns north and east [m].  At least two,
        no two neighbours equal.

    Examples
    --------
    >>> frame = PathFrame(frozen_array([[0.0, 0.0], [0.0, 1000.0]]))   # a line due east
    >>> pose = frame.to_path(NedPose(-20.0, 100.0, math.pi / 2))
    >>> round(pose.x), round(pose.y), round(pose.course, 6)
    (100, 20, 0.0)
    """

    vertices: FloatArray
    _lengths: FloatArray = field(init=False, repr=False)
    _distances: FloatArray = field(init=False, repr=False)
    _tangents: FloatArray = field(init=False, repr=False)
    _courses: FloatArray = field(init=False, repr=False)
    _lower: FloatArray = field(init=False, repr=False)  # of the foot of a pose on each segment
    _upper: FloatArray = field(init=False, repr=False)
    _line: Line = field(init=False, repr=False)

    def __post_init__(self) -> None:
        vertices = frozen_array(self.vertices)
        if vertices.ndim != 2 or vertices.shape[1] != 2 or len(vertices) < 2:
            raise ValueError(f"a guiding line is (n, 2) with n >= 2, got {vertices.shape}")
        steps = np.diff(vertices, axis=0)
        lengths = np.hypot(steps[:, 0], steps[:, 1])
        if not np.all(lengths > 0.0):
            raise ValueError("a guiding line must not repeat a vertex")
        set_ = object.__setattr__
        set_(self, "vertices", vertices)
        set_(self, "_lengths", frozen_array(lengths))
        set_(self, "_distances", frozen_array(np.concatenate([[0.0], np.cumsum(lengths)])))
        set_(self, "_tangents", frozen_array(steps / lengths[:, None]))
        set_(self, "_courses", frozen_array(np.arctan2(steps[:, 1], steps[:, 0])))
        lower, upper = np.zeros(len(lengths)), lengths.copy()
        lower[0], upper[-1] = -math.inf, math.inf
        set_(self, "_lower", frozen_array(lower))
        set_(self, "_upper", frozen_array(upper))
        line = vertices, self._tangents, self._courses, self._distances, self._lower, self._upper
        set_(self, "_line", line)

    @property
    def length(self) -> float:
        """Length of the guiding line [m]."""
        return float(self._distances[-1])

    @property
    def is_straight(self) -> bool:
        """Whether the guiding line has no corner."""
        return len(self._courses) == 1

    def course_at(self, x: float) -> float:
        """Course of the guiding line [rad] at distance x [m] along it."""
        return float(self._courses[self._segment(np.array([x]))[0]])

    def stretch(self, first: float, last: float) -> FloatArray:
        """Points of the guiding line from one distance [m] along it to a greater one, (n, 2).

        >>> PathFrame(frozen_array([[0.0, 0.0], [0.0, 1000.0]])).stretch(100.0, 300.0).tolist()
        [[0.0, 100.0], [0.0, 300.0]]
        """
        within = (self._distances > first) & (self._distances < last)
        ends = self._out_of(np.array([[first, 0.0, 0.0], [last, 0.0, 0.0]]))[:, :2]
        return np.vstack([ends[:1], self.vertices[within], ends[1:]])

    def to_path(self, pose: NedPose) -> PathPose:
        """Read a pose of {n} in this frame; the course comes back in (-pi, pi]."""
        if len(self._courses) > 1:
            return _on_bent_line(self, pose)
        (x0, y0), (cos, sin) = self.vertices[0].tolist(), self._tangents[0].tolist()
        away_x, away_y = pose.x - x0, pose.y - y0
        course = pose.course - float(self._courses[0])
        return PathPose(away_x * cos + away_y * sin, away_y * cos - away_x * sin, wrap(course))

    def to_ned(self, pose: PathPose) -> NedPose:
        """Read a pose of this frame in {n}; the course comes back in (-pi, pi]."""
        if len(self._courses) > 1:
            x, y, course = self._out_of(np.array([[pose.x, pose.y, pose.course]]))[0].tolist()
            return NedPose(x, y, wrap(course))
        (x0, y0), (cos, sin) = self.vertices[0].tolist(), self._tangents[0].tolist()
        x, y = x0 + pose.x * cos - pose.y * sin, y0 + pose.x * sin + pose.y * cos
        return NedPose(x, y, wrap(pose.course + float(self._courses[0])))

    def trajectory_to_path(self, trajectory: NedTrajectory) -> PathTrajectory:
        """Read a trajectory of {n} in this frame."""
        return PathTrajectory(self._into(trajectory.poses))

    def trajectory_to_ned(self, trajectory: PathTrajectory) -> NedTrajectory:
        """Read a trajectory of this frame in {n}."""
        return NedTrajectory(self._out_of(trajectory.poses))

    def _segment(self, x: FloatArray) -> NDArray[np.intp]:
        found = np.searchsorted(self._distances, x, side="right") - 1
        return np.minimum(np.maximum(found, 0), len(self._lengths) - 1)

    def _into(self, poses: FloatArray) -> FloatArray:
        found = np.empty_like(poses)
        loops(len(poses)).into(self._line, *self._near(poses), poses, found)
        return found

    def _near(self, poses: FloatArray) -> tuple[int, int]:
        """Range of segments outside of which none is nearest to any pose.

        With c in the midst of poses that are at most r from it, and the line D from c: a pose is no farther
        than D + r from the line, and at least s - r from a segment that is s from c.
        """
        count = len(self._lengths)
        if count <= FEW or len(poses) == 1:
            return 0, count
        x, y = poses[:, 0], poses[:, 1]
        low_x, high_x, low_y, high_y = x.min(), x.max(), y.min(), y.max()
        radius = 0.5 * math.hypot(high_x - low_x, high_y - low_y)
        if not math.isfinite(radius):
            return 0, count
        away_x = 0.5 * (low_x + high_x) - self.vertices[:-1, 0]
        away_y = 0.5 * (low_y + high_y) - self.vertices[:-1, 1]
        foot = away_x * self._tangents[:, 0] + away_y * self._tangents[:, 1]
        foot = np.minimum(np.maximum(foot, self._lower), self._upper)
        distance = np.hypot(away_x - foot * self._tangents[:, 0], away_y - foot * self._tangents[:, 1])
        near = np.flatnonzero(distance <= (distance.min() + 2.0 * radius) * (1.0 + 1e-9) + 1e-6)
        return int(near[0]), int(near[-1]) + 1

    def _out_of(self, poses: FloatArray) -> FloatArray:
        found = np.empty_like(poses)
        loops(len(poses)).out_of(self._line, poses, found)
        return found


@lru_cache(maxsize=4096)
def _on_bent_line(frame: PathFrame, pose: NedPose) -> PathPose:
    """Read a pose; whoever looks at a ship next asks for the same ones again."""
    x, y, course = frame._into(np.array([[pose.x, pose.y, pose.course]]))[0].tolist()  # noqa: SLF001 - its own
    return PathPose(x, y, wrap(course))
