"""HEADON, Eq. (3): what the print says, and where we depart from it.

The quantities come from `facts`; the condition on them is `courses_opposite` of tran2026.yaml.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ccas_core.frames import FloatArray
from ccas_core.tapd.facts import closest_approach
from ccas_core.units import DEGREE
from ccas_core.waterway import Towards, Waters, Waterway

from ..tapd import CHART, A, B, Meeting, condition, head_on, random_encounter, report

T_ho = 600.0  # [s]


def velocity(meeting: Meeting, *, own: bool) -> FloatArray:
    """v_{i,n} of the paper."""
    ship = meeting.own if own else meeting.other
    return ship.speed * np.array([math.cos(ship.pose.course), math.sin(ship.pose.course)])


def opposite(meeting: Meeting) -> bool:
    """First term of Eq. (3): v_i . v_j / (|v_i| |v_j|) < -cos(22.5 deg)."""
    v_i, v_j = velocity(meeting, own=True), velocity(meeting, own=False)
    return float(v_i @ v_j) / float(np.linalg.norm(v_i) * np.linalg.norm(v_j)) < -math.cos(22.5 * DEGREE)


def tcpa(meeting: Meeting) -> float:
    """Time at which |p_j - p_i + t (v_j - v_i)| is least."""
    apart = np.array([meeting.other.pose.x - meeting.own.pose.x, meeting.other.pose.y - meeting.own.pose.y])
    closing = velocity(meeting, own=False) - velocity(meeting, own=True)
    return float(
        np.polynomial.Polynomial([apart @ apart, 2.0 * apart @ closing, closing @ closing]).deriv().roots()[0]
    )


def same_waterway(meeting: Meeting) -> bool:
    """Last term of Eq. (3), y_min <= y_{j,i} <= y_max, on the straight waterways of these tests."""
    waterway = meeting.waters.waterway(meeting.own.waterway)
    start, end = waterway.centreline
    chi = math.atan2(end[1] - start[1], end[0] - start[0])
    away = np.array([meeting.other.pose.x, meeting.other.pose.y]) - start
    y = float(-math.sin(chi) * away[0] + math.cos(chi) * away[1])
    return abs(y) <= waterway.width / 2.0


def is_head_on(meeting: Meeting, limit: float = T_ho) -> bool:
    """HEADON of the ruleset, with this T_ho [s]."""
    return condition("courses_opposite", T_ho=limit)(meeting.facts())


def test_closest_approach_is_that_of_the_minimum() -> None:
    for seed in range(300):
        meeting = random_encounter(np.random.default_rng(seed))
        if abs(meeting.own.speed - meeting.other.speed) < 1.0:
            continue  # where the ships hardly move past one another, the minimum is flat
        found, _ = closest_approach(*meeting.facts().motion[:4])
        assert found == meeting.facts()["tcpa"] == pytest.approx(tcpa(meeting), rel=1e-4, abs=1e-3)


def turned(course: float) -> Meeting:
    """Two ships on the river; the course of the second in degrees."""
    return Meeting(CHART, report(A, -600.0, 0.0, 0.0), report(B, 600.0, 0.0, course, towards=Towards.START))


def test_head_on_is_the_conjunction_of_the_three_terms_as_long_as_both_ships_are_coming() -> None:
    counted = 0
    for seed in range(2000):
        meeting = random_encounter(np.random.default_rng(seed))
        if min(meeting.own.speed, meeting.other.speed) == 0.0:
            continue
        waterway = same_waterway(meeting) and same_waterway(meeting.swapped())
        expected = opposite(meeting) and 0.0 <= tcpa(meeting) <= T_ho and waterway
        assert is_head_on(meeting) is expected
        counted += expected

    assert counted > 100


@pytest.mark.parametrize(
    ("course", "expected"), [(157.4, False), (157.6, True), (180.0, True), (202.4, True), (202.6, False)]
)
def test_courses_are_opposite_within_two_points(course: float, expected: bool) -> None:
    assert is_head_on(turned(course)) is expected


@pytest.mark.parametrize(("limit", "expected"), [(199.9, False), (200.1, True)])
def test_ships_meet_within_the_time_limit(limit: float, expected: bool) -> None:
    assert is_head_on(turned(180.0), limit) is expected


@pytest.mark.parametrize(("east", "expected"), [(79.0, True), (81.0, False), (-81.0, False)])
def test_other_ship_lies_between_the_banks(east: float, expected: bool) -> None:
    meeting = turned(180.0)
    aside = replace(meeting, other=replace(meeting.other, pose=replace(meeting.other.pose, y=east)))

    assert is_head_on(aside) is expected


def test_speed_of_the_ships_plays_no_part_in_the_first_term() -> None:
    slow = replace(turned(180.0), own=replace(turned(180.0).own, speed=0.2))

    assert is_head_on(slow)


# --- departures, see the comment in tran2026.yaml --------------------------------------------------------


def test_ships_that_have_passed_are_no_longer_head_on_though_the_print_says_so() -> None:
    past = head_on().later(400.0)

    assert opposite(past)
    assert tcpa(past) < 0.0
    assert not is_head_on(past)


def test_stopped_ship_is_not_head_on_where_the_print_divides_by_zero() -> None:
    stopped = replace(turned(180.0), other=replace(turned(180.0).other, speed=0.0))

    assert not is_head_on(stopped)


def test_on_a_bend_the_waterway_is_the_same_from_both_ships_or_from_none() -> None:
    straight = Waterway(id="straight", centreline=np.array([[0.0, 0.0], [4000.0, 0.0]]), width=160.0)
    bent = Waterway(
        id="bent", centreline=np.array([[0.0, 60.0], [2000.0, 60.0], [3000.0, 300.0]]), width=160.0
    )
    waters = Waters(ruleset="tran2026", waterways=(straight, bent))
    own = report(A, 500.0, 70.0, 0.0, waterway="bent")
    other = report(B, 2900.0, 0.0, 180.0, waterway="straight", towards=Towards.START)
    meeting = Meeting(waters, own, other)

    assert not is_head_on(meeting)
    assert not is_head_on(meeting.swapped())
    seen = [
        abs(waters.waterway(w).frame(Towards.END).to_path(pose).y) <= 80.0
        for w, pose in (("bent", other.pose), ("straight", own.pose))
    ]
    assert seen == [False, True]  # the print would depend on who asks
