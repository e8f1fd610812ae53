"""The inertial frame, the path frames, and the one way between them (Sec. 2.1)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ccas_core.frames import (
    FloatArray,
    NedPose,
    NedTrajectory,
    PathFrame,
    PathPose,
    PathTrajectory,
    frozen_array,
)
from ccas_core.units import wrap

PLACES = st.floats(-5000.0, 5000.0)
COURSES = st.floats(-math.pi, math.pi, exclude_min=True)
POSES = st.builds(NedPose, PLACES, PLACES, COURSES)
EAST = PathFrame(np.array([[0.0, 0.0], [0.0, 1000.0]]))
STARBOARD_BEND = PathFrame(np.array([[0.0, 0.0], [1000.0, 0.0], [1500.0, 500.0]]))  # 45 degrees


@st.composite
def straight_frames(draw: st.DrawFn) -> PathFrame:
    start, course = np.array([draw(PLACES), draw(PLACES)]), draw(COURSES)
    ahead = draw(st.floats(10.0, 5000.0)) * np.array([math.cos(course), math.sin(course)])
    return PathFrame(np.array([start, start + ahead]))


@st.composite
def bent_frames(draw: st.DrawFn, greatest_turn: float = math.radians(5.0)) -> PathFrame:
    """Draw a line of chords that never turns by more than so much, nor comes back to itself."""
    course = draw(COURSES)
    points = [np.array([draw(PLACES), draw(PLACES)])]
    for turn in draw(st.lists(st.floats(-greatest_turn, greatest_turn), min_size=2, max_size=8)):
        ahead = np.array([math.cos(course), math.sin(course)])
        points.append(points[-1] + draw(st.floats(30.0, 300.0)) * ahead)
        course += turn
    return PathFrame(np.array(points))


def _beside(frame: PathFrame, share: float, y: float) -> NedPose:
    """Pose on the normal of a vertex or chord, at a share of the length."""
    return frame.to_ned(PathPose(share * frame.length, y, 0.1))


def _apart(one: NedPose, other: NedPose) -> float:
    return math.hypot(one.x - other.x, one.y - other.y)


# --- a straight line: Sec. 2.1 to the letter ------------------------------------------------------


@given(straight_frames(), POSES)
@settings(derandomize=True, max_examples=80, deadline=None)
def test_straight_frame_is_the_rotation_and_shift_of_the_paper(frame: PathFrame, pose: NedPose) -> None:
    (x_wp, y_wp), (x_next, y_next) = frame.vertices.tolist()
    chi_wp = math.atan2(y_next - y_wp, x_next - x_wp)
    R_i = np.array(
        [
            [math.cos(chi_wp), math.sin(chi_wp), 0.0],
            [-math.sin(chi_wp), math.cos(chi_wp), 0.0],
            [0.0, 0.0, 1.0],
        ]
    )
    expected = R_i @ (np.array([pose.x, pose.y, pose.course]) - np.array([x_wp, y_wp, chi_wp]))

    here = frame.to_path(pose)

    assert [here.x, here.y] == pytest.approx(expected[:2], abs=1e-6)
    assert wrap(here.course - expected[2]) == pytest.approx(0.0, abs=1e-9)


@given(straight_frames(), POSES)
@settings(derandomize=True, max_examples=80, deadline=None)
def test_a_pose_goes_there_and_back_on_a_straight_line(frame: PathFrame, pose: NedPose) -> None:
    back = frame.to_ned(frame.to_path(pose))

    assert _apart(pose, back) < 1e-6
    assert wrap(back.course - pose.course) == pytest.approx(0.0, abs=1e-9)


def test_offset_is_positive_to_starboard() -> None:
    north = PathFrame(np.array([[0.0, 0.0], [1000.0, 0.0]]))

    assert north.to_path(NedPose(500.0, 20.0, 0.0)) == PathPose(500.0, 20.0, 0.0)


def test_course_is_relative_to_the_line_and_clockwise() -> None:
    assert EAST.to_path(NedPose(0.0, 0.0, math.pi / 2 + 0.1)).course == pytest.approx(0.1)
    assert EAST.to_ned(PathPose(0.0, 0.0, 0.1)).course == pytest.approx(math.pi / 2 + 0.1)


def test_ship_that_sails_against_the_line_has_the_relative_course_pi() -> None:
    assert EAST.to_path(NedPose(0.0, 0.0, -math.pi / 2)).course == math.pi


# --- one pose and many ----------------------------------------------------------------------------


@given(st.one_of(straight_frames(), bent_frames()), st.lists(POSES, min_size=1, max_size=6))
@settings(derandomize=True, max_examples=60, deadline=None)
def test_a_pose_is_read_like_a_trajectory(frame: PathFrame, poses: list[NedPose]) -> None:
    array = np.array([[pose.x, pose.y, pose.course] for pose in poses])

    many = frame.trajectory_to_path(NedTrajectory(array)).poses

    for pose, row in zip(poses, many, strict=True):
        here = frame.to_path(pose)
        assert [here.x, here.y] == pytest.approx(row[:2], abs=1e-6)
        assert wrap(here.course - row[2]) == pytest.approx(0.0, abs=1e-9)


@given(st.one_of(straight_frames(), bent_frames()), st.lists(POSES, min_size=1, max_size=6))
@settings(derandomize=True, max_examples=60, deadline=None)
def test_a_path_pose_is_read_like_a_path_trajectory(frame: PathFrame, poses: list[NedPose]) -> None:
    array = np.array([[pose.x, pose.y, pose.course] for pose in poses])

    many = frame.trajectory_to_ned(PathTrajectory(array)).poses

    for pose, row in zip(poses, many, strict=True):
        there = frame.to_ned(PathPose(pose.x, pose.y, pose.course))
        assert [there.x, there.y] == pytest.approx(row[:2], abs=1e-6)
        assert wrap(there.course - row[2]) == pytest.approx(0.0, abs=1e-9)


@given(straight_frames(), st.lists(POSES, min_size=1, max_size=6))
@settings(derandomize=True, max_examples=60, deadline=None)
def test_a_vertex_in_the_middle_of_a_straight_line_changes_nothing(
    frame: PathFrame, poses: list[NedPose]
) -> None:
    split = PathFrame(np.insert(frame.vertices, 1, frame.vertices.mean(axis=0), axis=0))

    for pose in poses:
        one, other = frame.to_path(pose), split.to_path(pose)
        assert [one.x, one.y] == pytest.approx([other.x, other.y], abs=1e-6)
        assert wrap(one.course - other.course) == pytest.approx(0.0, abs=1e-9)


# --- bent lines -----------------------------------------------------------------------------------


@given(bent_frames(), st.floats(0.0, 1.0), st.floats(-60.0, 60.0))
@settings(derandomize=True, max_examples=80, deadline=None)
def test_a_pose_comes_back_to_within_the_gap_of_a_bend(frame: PathFrame, share: float, y: float) -> None:
    """Outside a bend of 5 degrees all points between two normals share one distance along the line."""
    pose = _beside(frame, share, y)

    back = frame.to_ned(frame.to_path(pose))

    assert _apart(pose, back) <= 2.0 * abs(y) * math.sin(math.radians(2.5)) + 1e-6


@given(bent_frames(), st.floats(0.0, 1.0), COURSES)
@settings(derandomize=True, max_examples=80, deadline=None)
def test_a_pose_on_a_bent_line_goes_there_and_back(frame: PathFrame, share: float, course: float) -> None:
    pose = PathPose(share * frame.length, 0.0, course)

    back = frame.to_path(frame.to_ned(pose))

    assert [back.x, back.y] == pytest.approx([pose.x, pose.y], abs=1e-6)


@given(bent_frames(), st.floats(0.0, 1.0), st.floats(-60.0, 60.0), COURSES)
@settings(derandomize=True, max_examples=80, deadline=None)
def test_offset_and_distance_are_continuous_along_a_bent_line(
    frame: PathFrame, share: float, y: float, course: float
) -> None:
    one, step = _beside(frame, share, y), 0.01
    other = NedPose(one.x + step * math.cos(course), one.y + step * math.sin(course), one.course)

    here, there = frame.to_path(one), frame.to_path(other)

    assert abs(there.y - here.y) <= step + 1e-9  # a distance to a line changes no faster than one moves
    jump = 2.0 * abs(y) * math.tan(math.radians(2.5))  # from one chord to the next, inside the bend
    assert abs(there.x - here.x) <= jump + step * 1.1


@pytest.mark.parametrize("y", [-40.0, 40.0])
def test_offset_stays_on_its_side_all_the_way_around_a_bend(y: float) -> None:
    north, east = STARBOARD_BEND.vertices[1].tolist()
    spokes = np.linspace(-math.pi / 2, -math.pi / 4, 20) + (math.pi if y > 0.0 else 0.0)
    around = [NedPose(north + abs(y) * math.cos(a), east + abs(y) * math.sin(a), 0.0) for a in spokes]

    sides = {math.copysign(1.0, STARBOARD_BEND.to_path(pose).y) for pose in around}

    assert sides == {math.copysign(1.0, y)}


def test_offset_stays_on_its_side_all_the_way_around_a_hairpin() -> None:
    hairpin = PathFrame(np.array([[0.0, 0.0], [1000.0, 0.0], [500.0, 300.0]]))
    spokes = np.linspace(-math.pi / 2 + 0.01, math.pi / 3, 40)
    around = [NedPose(1000.0 + 20.0 * math.cos(a), 20.0 * math.sin(a), 0.0) for a in spokes]

    assert all(hairpin.to_path(pose).y < 0.0 for pose in around)


def test_outside_a_corner_the_offset_is_the_distance_to_the_corner() -> None:
    here = STARBOARD_BEND.to_path(NedPose(1000.0 + 40.0 * math.sin(0.3), -40.0 * math.cos(0.3), 0.0))

    assert [here.x, here.y] == pytest.approx([1000.0, -40.0])


@pytest.mark.parametrize(
    ("pose", "expected"),
    [
        (NedPose(-300.0, 10.0, 0.0), PathPose(-300.0, 10.0, 0.0)),
        (
            NedPose(1500.0 + 300.0, 500.0 + 300.0, math.pi / 4),
            PathPose(1000.0 + 800.0 * math.sqrt(2.0), 0.0, 0.0),
        ),
    ],
)
def test_line_goes_on_straight_past_its_ends(pose: NedPose, expected: PathPose) -> None:
    here = STARBOARD_BEND.to_path(pose)

    assert [here.x, here.y, here.course] == pytest.approx([expected.x, expected.y, expected.course])
    assert _apart(pose, STARBOARD_BEND.to_ned(expected)) < 1e-9


def test_course_of_a_bent_line_is_that_of_the_chord() -> None:
    courses = [STARBOARD_BEND.course_at(x) for x in (-100.0, 0.0, 999.9, 1000.1, 5000.0)]

    assert courses == pytest.approx([0.0, 0.0, 0.0, math.pi / 4, math.pi / 4])


def test_length_of_a_bent_line_is_the_sum_of_its_chords() -> None:
    assert STARBOARD_BEND.length == pytest.approx(1000.0 + 500.0 * math.sqrt(2.0))


# --- what a frame refuses, and what nobody can change ---------------------------------------------


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        ([[0.0, 0.0]], "n >= 2"),
        ([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], "n >= 2"),
        ([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]], "repeat"),
    ],
)
def test_line_without_a_direction_is_refused(vertices: list[list[float]], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        PathFrame(np.array(vertices))


@pytest.mark.parametrize("kind", [NedTrajectory, PathTrajectory])
@pytest.mark.parametrize("shape", [(3,), (4, 2)])
def test_trajectory_of_a_wrong_shape_is_refused(
    kind: type[NedTrajectory | PathTrajectory], shape: tuple[int, ...]
) -> None:
    with pytest.raises(ValueError, match=r"\(N \+ 1, 3\)"):
        kind(np.zeros(shape))


@pytest.mark.parametrize(
    "make", [lambda a: NedTrajectory(a).poses, lambda a: PathFrame(a[:, :2]).vertices, frozen_array]
)
def test_arrays_of_values_are_copies_that_nobody_can_write_to(make: object) -> None:
    assert callable(make)
    given = np.arange(6.0).reshape(2, 3)

    kept: FloatArray = make(given)
    given[0, 0] = 99.0

    assert kept[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        kept[0, 0] = 1.0
