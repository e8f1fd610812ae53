"""Hulls along tracks: clearance, collision, entry, grounding, contact with obstacles."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ccas_core.frames import NedPose, PathFrame
from ccas_core.ships import Hull, ShipId
from ccas_core.sim.hulls import Track, clearance, is_grounded, meeting, meetings, obstacles_struck, track
from ccas_core.sim.metrics import safety_indices
from ccas_core.waterway import Obstacle

from . import NORTH, PAPER_HULL, A, B, C, plan, scenario, ship, voyage, waters

NORTHWARD, EASTWARD = 0.0, math.pi / 2.0
BARGE = Hull(length=40.0, beam=8.0)


def course_made(id_: ShipId, rows: list[tuple[float, float, float, float]], hull: Hull = PAPER_HULL) -> Track:
    table = np.array(rows)
    return Track(ship=ship(id_, hull), times=table[:, 0], poses=table[:, 1:])


def still(id_: ShipId, north: float, east: float, course: float) -> Track:
    return course_made(id_, [(0.0, north, east, course)])


def straight(id_: ShipId, north: float, east: float, course: float, speed: float = 3.0) -> Track:
    ahead = 40.0 * speed
    end = (40.0, north + ahead * math.cos(course), east + ahead * math.sin(course), course)
    return course_made(id_, [(0.0, north, east, course), end])


def least(one: Track, other: Track) -> float:
    met = meeting(one, other)
    assert met is not None
    return met.clearance


def test_ships_crossing_at_right_angles_overlap_though_both_indices_are_31_m() -> None:
    one, other = still(A, 0.0, 0.0, NORTHWARD), still(B, 39.6, 39.6, EASTWARD)
    poses = {A: NedPose(0.0, 0.0, NORTHWARD), B: NedPose(39.6, 39.6, EASTWARD)}
    lines = {
        A: PathFrame(np.array([[0.0, 0.0], [1.0, 0.0]])),
        B: PathFrame(np.array([[0.0, 0.0], [0.0, 1.0]])),
    }

    met = meeting(one, other)

    assert safety_indices(poses, {A: ship(A), B: ship(B)}, lines) == pytest.approx({A: 31.0, B: 31.0})
    assert met is not None
    assert met.collision
    assert met.entry


@pytest.mark.parametrize(
    ("north", "east", "course", "apart"),
    [
        (0.0, 40.0, NORTHWARD, 28.6),  # abeam: 40 - 11.4
        (200.0, 0.0, NORTHWARD, 97.0),  # in line: 200 - 103
        (0.0, 100.0, EASTWARD, 42.8),  # bow towards the side: 100 - 51.5 - 5.7
        (106.0, 15.4, NORTHWARD, 5.0),  # corner to corner: 3 and 4
    ],
)
def test_clearance_is_the_distance_between_the_hulls(
    north: float, east: float, course: float, apart: float
) -> None:
    assert least(still(A, 0.0, 0.0, NORTHWARD), still(B, north, east, course)) == pytest.approx(apart)


def test_hulls_that_just_touch_have_collided() -> None:
    side = Hull(length=100.0, beam=12.0)

    met = meeting(course_made(A, [(0.0, 0.0, 0.0, 0.0)], side), course_made(B, [(0.0, 0.0, 12.0, 0.0)], side))

    assert met is not None
    assert met.collision


def test_collision_between_two_periods_is_seen() -> None:
    one = straight(A, -60.0, 0.0, NORTHWARD)
    across = course_made(B, [(0.0, 0.0, -200.0, EASTWARD), (40.0, 0.0, 200.0, EASTWARD)])

    met = meeting(one, across)
    _, apart = clearance(one, across)

    assert min(apart[0], apart[-1]) > 100.0
    assert met is not None
    assert met.collision
    assert 0.0 < met.time < 40.0


def test_a_segment_is_sailed_on_the_course_of_its_later_row() -> None:
    turning = course_made(A, [(0.0, 0.0, 0.0, EASTWARD), (20.0, 60.0, 0.0, NORTHWARD)])

    poses = turning.at(np.array([0.0, 1.0, 20.0]))

    assert poses == pytest.approx(
        np.array([[0.0, 0.0, EASTWARD], [3.0, 0.0, NORTHWARD], [60.0, 0.0, NORTHWARD]])
    )


def test_entry_without_collision_either_way_round() -> None:
    one, other = still(A, 0.0, 0.0, NORTHWARD), still(B, 0.0, 13.0, NORTHWARD)  # hulls 1.6 m apart

    both = meeting(one, other), meeting(other, one)

    assert [(met.entry, met.collision) for met in both if met] == [(True, False), (True, False)]


def test_either_safety_rectangle_can_be_entered() -> None:
    wide, narrow = (Hull(length=100.0, beam=10.0, safety_length=100.0, safety_beam=b) for b in (40.0, 10.0))
    one, other = course_made(A, [(0.0, 0.0, 0.0, 0.0)], wide), course_made(B, [(0.0, 0.0, 20.0, 0.0)], narrow)

    both = meeting(one, other), meeting(other, one)

    assert [met.entry for met in both if met] == [True, True]


def test_no_entry_beyond_the_safety_rectangle() -> None:
    met = meeting(still(A, 0.0, 0.0, NORTHWARD), still(B, 0.0, 14.4, NORTHWARD))  # 8.6 + 5.7 = 14.3

    assert met is not None
    assert not met.entry


def test_ships_that_were_never_under_way_together_did_not_meet() -> None:
    early = course_made(A, [(0.0, 0.0, 0.0, 0.0), (20.0, 60.0, 0.0, 0.0)])
    late = course_made(B, [(40.0, 0.0, 0.0, 0.0), (60.0, 60.0, 0.0, 0.0)])

    assert meeting(early, late) is None
    assert meetings([early, late]) == ()


def test_only_the_time_under_way_together_counts() -> None:
    one = course_made(A, [(0.0, 0.0, 0.0, 0.0), (20.0, 60.0, 0.0, 0.0)])
    other = course_made(B, [(20.0, 300.0, 0.0, 0.0), (40.0, 0.0, 0.0, math.pi)])

    assert least(one, other) == pytest.approx(240.0 - 103.0)


def test_collision_between_two_periods_is_seen_beside_nearer_ships() -> None:
    one = straight(A, -60.0, 0.0, NORTHWARD)
    across = course_made(B, [(0.0, 0.0, -200.0, EASTWARD), (40.0, 0.0, 200.0, EASTWARD)])
    beside_one, beside_other = straight(C, -60.0, 30.0, NORTHWARD), moved(across, 30.0, 0.0, 0.0)

    found = meetings([one, across, beside_one, replace(beside_other, ship=ship(ShipId("d")))])

    assert (A, B) in {met.pair for met in found if met.collision}


def test_hull_outside_the_banks_is_grounded() -> None:
    banks = waters(width=40.0).banks()

    assert not is_grounded(straight(A, 0.0, -1000.0, EASTWARD), banks)
    assert is_grounded(straight(A, 14.4, -1000.0, EASTWARD), banks)  # 14.4 + 5.7 > 20
    assert not is_grounded(straight(A, 14.2, -1000.0, EASTWARD), banks)
    assert is_grounded(straight(A, 0.0, -1000.0, NORTHWARD, speed=0.0), banks)


def test_hull_that_touches_a_pier_strikes_it() -> None:
    near, far = (
        Obstacle(id="pier", x=60.0, y=15.0, radius=10.0),
        Obstacle(id="buoy", x=60.0, y=-7.0, radius=1.0),
    )

    assert obstacles_struck(straight(A, 0.0, 0.0, NORTHWARD), (near, far)) == (near,)


def test_track_ends_with_the_arrival() -> None:
    of = scenario(plan(A, NORTH, before=-2900.0))  # 100 m to go
    frames = voyage(of, {A: [(0.0, 1.0)]})

    line = PathFrame(waters().waterway("river").centreline)
    sailed = track(of.ships[0].ship, line, frames)

    assert sailed.times == pytest.approx([0.0, 20.0, 100.0 / 3.0])
    assert sailed.poses[-1] == pytest.approx([3000.0, 0.0, 0.0])


def test_track_is_cut_at_the_arrival_where_a_frame_shows_the_ship_past_it() -> None:
    of = scenario(plan(A, NORTH, before=-2900.0))
    frames = voyage(of, {A: [(0.0, 1.0)]})
    beyond = replace(frames[1].ships[A], pose=NedPose(3020.0, 6.0, 0.1))
    frames[2] = replace(frames[2], ships={A: beyond})

    sailed = track(of.ships[0].ship, PathFrame(waters().waterway("river").centreline), frames)

    assert sailed.times == pytest.approx([0.0, 20.0, 100.0 / 3.0])
    assert sailed.poses[-1] == pytest.approx([2960.0 + 40.0, 4.0, 0.1])


def test_track_of_rows_that_do_not_rise_is_refused() -> None:
    with pytest.raises(ValueError, match="do not rise"):
        course_made(A, [(20.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)])


metres = st.floats(-600.0, 600.0)
courses = st.floats(-math.pi, math.pi)
hulls = st.sampled_from([PAPER_HULL, BARGE])


@st.composite
def tracks(draw: st.DrawFn, id_: ShipId) -> Track:
    begin, count = draw(st.integers(0, 2)), draw(st.integers(1, 5))
    times = 20.0 * (begin + np.arange(count, dtype=np.float64))
    if draw(st.booleans()):
        times = np.append(times, times[-1] + draw(st.floats(0.5, 19.5)))
    pose = np.array([draw(metres), draw(metres), draw(courses)])
    rows = [pose]
    for span in np.diff(times):
        course = pose[2] + draw(st.floats(-0.5, 0.5))
        ahead = span * draw(st.floats(0.0, 5.0))
        pose = np.array([pose[0] + ahead * math.cos(course), pose[1] + ahead * math.sin(course), course])
        rows.append(pose)
    return Track(ship=ship(id_, draw(hulls)), times=times, poses=np.array(rows))


def moved(of: Track, north: float, east: float, turn: float) -> Track:
    cos, sin = math.cos(turn), math.sin(turn)
    x, y, course = of.poses.T
    poses = np.column_stack([north + cos * x - sin * y, east + sin * x + cos * y, course + turn])
    return Track(ship=of.ship, times=of.times, poses=poses)


@settings(derandomize=True, deadline=None)
@given(one=tracks(A), other=tracks(B))
def test_clearance_does_not_ask_who_looks(one: Track, other: Track) -> None:
    here, there = meeting(one, other), meeting(other, one)

    assert (here is None) == (there is None)
    if here and there:
        assert here.clearance == pytest.approx(there.clearance, abs=1e-9)
        assert (here.entry, here.pair) == (there.entry, there.pair)


@settings(derandomize=True, deadline=None)
@given(one=tracks(A), other=tracks(B), north=metres, east=metres, turn=courses)
def test_clearance_does_not_change_when_the_world_is_moved_and_turned(
    one: Track, other: Track, north: float, east: float, turn: float
) -> None:
    _, before = clearance(one, other)
    _, after = clearance(moved(one, north, east, turn), moved(other, north, east, turn))

    assert after == pytest.approx(before, abs=1e-6)


@settings(derandomize=True, deadline=None)
@given(fleet=st.tuples(tracks(A), tracks(B), tracks(C), tracks(ShipId("d"))))
def test_what_is_left_out_by_centre_distance_does_not_matter(fleet: tuple[Track, ...]) -> None:
    found = {met.pair: met for met in meetings(fleet)}

    for each in fleet:
        pairs = [(one, other) for one, other in combinations(fleet, 2) if each in (one, other)]
        series = [apart for pair in pairs for apart in clearance(*pair)[1]]
        mine = [met.clearance for met in found.values() if each.ship.id in met.pair]
        assert min(mine, default=math.inf) == pytest.approx(min(series, default=math.inf))
    for one, other in combinations(fleet, 2):
        met = meeting(one, other)
        if met and met.entry:
            assert found[met.pair] == met


@settings(derandomize=True, deadline=None)
@given(one=tracks(A), other=tracks(B))
def test_positions_are_followed_at_steps_of_at_most_one_second(one: Track, other: Track) -> None:
    times, apart = clearance(one, other)

    assert np.all(np.diff(times) <= 1.0 + 1e-9)
    met = meeting(one, other)
    assert (met is None) == (len(times) == 0)
    if met:
        assert met.clearance == apart.min()
