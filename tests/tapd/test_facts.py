"""Facts about two ships: the same from both sides, and wherever in the world they meet."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ccas_core.roles import Geometry
from ccas_core.ships import UNKNOWN
from ccas_core.tapd.encounters import NO_ENCOUNTER, Encounter
from ccas_core.tapd.facts import (
    GRID,
    KEEPS_STARBOARD,
    LEAVES_STARBOARD,
    STOPPED,
    PairFacts,
    assess,
    closest_approach,
    follows_starboard_side,
    time_to_intersection,
)
from ccas_core.tapd.vocabulary import VOCABULARY
from ccas_core.units import DEGREE, wrap
from ccas_core.waterway import Towards, Waters, Waterway

from . import (
    CHART,
    A,
    B,
    Condition,
    Meeting,
    condition,
    crossing,
    head_on,
    overtaking,
    plain,
    random_encounter,
    report,
)

LIMIT = 900.0  # [s]
MEETINGS = [random_encounter(np.random.default_rng(seed), flags=False) for seed in range(400)]
PLACES = st.floats(-1e4, 1e4)
TURNS = st.floats(-math.pi, math.pi)


BEARINGS = (("bearing", "own", "other"), ("bearing", "other", "own"))
QUANTITIES = (
    ("course_difference",),
    *BEARINGS,
    ("tcpa",),
    ("dcpa",),
    ("distance",),
    ("time_to_intersection", "own"),
    ("time_to_intersection", "other"),
)


def is_head_on(facts: PairFacts, limit: float) -> bool:
    return condition("courses_opposite", T_ho=limit)(facts)


def is_crossing(facts: PairFacts, limit: float) -> bool:
    return condition("both_reach", T_IC=limit)(facts)


def overtakes(facts: PairFacts, limit: float) -> bool:
    return condition("comes_up(own, other)", T_ho=limit)(facts)


crosses: Condition = condition("from_starboard(own, other)")
under_way: Condition = condition("under_way")


def _approach(meeting: Meeting) -> tuple[float, float]:
    """TCPA [s] and DCPA [m]."""
    return closest_approach(*meeting.facts().motion[:4])


# --- closest approach -----------------------------------------------------------------------------


def test_closest_approach_of_opposite_ships_is_half_way() -> None:
    tcpa, dcpa = _approach(Meeting(CHART, report(A, -600.0, 0.0, 0.0), report(B, 600.0, 30.0, 180.0)))

    assert [tcpa, dcpa] == pytest.approx([200.0, 30.0])


def test_closest_approach_is_where_nothing_nearer_is_found() -> None:
    for meeting in MEETINGS[:100]:
        tcpa, dcpa = _approach(meeting)
        if math.isinf(tcpa):
            continue
        for seconds in (tcpa - 1.0, tcpa, tcpa + 1.0):
            then = meeting.later(seconds)
            apart = math.hypot(then.own.pose.x - then.other.pose.x, then.own.pose.y - then.other.pose.y)
            grid = GRID * (2.0 + abs(seconds))  # positions and velocities are on a grid
            assert apart >= dcpa - grid
            assert seconds != tcpa or apart == pytest.approx(dcpa, abs=grid)


def test_tcpa_is_negative_when_past() -> None:
    assert head_on().later(400.0).facts()["tcpa"] == pytest.approx(400.0 / 1.2 - 400.0)


@pytest.mark.parametrize("speed", [0.0, 3.0])
def test_tcpa_is_infinite_when_the_range_never_changes(speed: float) -> None:
    tcpa, dcpa = _approach(
        Meeting(CHART, report(A, 0.0, 0.0, 0.0, speed=speed), report(B, 30.0, 40.0, 0.0, speed=speed))
    )

    assert (tcpa, dcpa) == (math.inf, 50.0)


# --- what counts ----------------------------------------------------------------------------------

KINDS = [(head_on(), is_head_on), (crossing(), is_crossing), (overtaking(), overtakes)]


def test_ships_made_by_hand_meet_as_they_are_called() -> None:
    for n, (meeting, _) in enumerate(KINDS):
        answers = [kind(meeting.facts(), LIMIT) for _, kind in KINDS]
        assert answers == [n == m for m in range(3)]


def test_ships_that_are_past_each_other_no_longer_meet() -> None:
    for meeting, kind in KINDS:
        past = meeting.later(450.0).facts()
        assert past["tcpa"] < 0.0
        assert not kind(past, LIMIT)


def test_ships_that_meet_later_than_the_limit_do_not_meet_yet() -> None:
    for meeting, kind in KINDS:
        assert not kind(meeting.facts(), 100.0)


@pytest.mark.parametrize("speed", [0.0, STOPPED - GRID])
def test_stopped_ship_meets_nobody(speed: float) -> None:
    """Velocities are on a grid, so that just at the limit it is the grid that decides."""
    for meeting, kind in KINDS:
        for stopped in (
            replace(meeting, own=replace(meeting.own, speed=speed)),
            replace(meeting, other=replace(meeting.other, speed=speed)),
        ):
            assert not under_way(stopped.facts())
            assert not kind(stopped.facts(), LIMIT)


def test_stopped_ship_never_reaches_an_intersection() -> None:
    assert time_to_intersection(CHART, report(A, -600.0, 0.0, 0.0, speed=0.0), "canal") == math.inf


def test_time_to_intersection_is_distance_along_the_waterway_by_speed() -> None:
    facts = crossing().facts()

    times = [facts[f"{ship}.time_to_intersection"] for ship in ("own", "other")]
    assert times == pytest.approx([1000.0 / 3.0] * 2)
    assert time_to_intersection(CHART, report(A, 600.0, 0.0, 0.0), "canal") == pytest.approx(-200.0)


@pytest.mark.parametrize("across", ["river", "pond"])
def test_without_an_intersection_there_is_no_time_to_it(across: str) -> None:
    pond = Waterway(id="pond", centreline=np.array([[9000.0, 0.0], [9000.0, 500.0]]), width=50.0)
    waters = replace(CHART, waterways=(*CHART.waterways, pond))

    assert time_to_intersection(waters, report(A, -600.0, 0.0, 0.0), across) == math.inf


def test_ship_ahead_on_the_same_arm_does_not_cross() -> None:
    follower = Meeting(CHART, report(A, -900.0, 0.0, 0.0), report(B, -500.0, 0.0, 0.0)).facts()

    assert follower["same_direction"]
    assert not is_crossing(follower, LIMIT)


@pytest.mark.parametrize(
    ("bearing", "comes_up"), [(111.0, False), (114.0, True), (-111.0, False), (-114.0, True)]
)
def test_ship_that_comes_up_from_more_than_two_points_abaft_the_beam_overtakes(
    bearing: float, comes_up: bool
) -> None:
    away = 70.0 * np.array([math.cos(bearing * DEGREE), math.sin(bearing * DEGREE)])
    meeting = Meeting(
        CHART, report(A, float(away[0]), float(away[1]), 0.0, speed=5.0), report(B, 0.0, 0.0, 0.0)
    )

    assert overtakes(meeting.facts(), LIMIT) is comes_up


def test_only_the_faster_ship_overtakes() -> None:
    facts = overtaking().facts()

    assert overtakes(facts, LIMIT)
    assert not overtakes(facts.mirrored(), LIMIT)


# --- the same from both ships ---------------------------------------------------------------------


def test_the_other_view_is_the_assessment_with_the_ships_swapped() -> None:
    for meeting in MEETINGS:
        assert plain(meeting.facts().mirrored()) == plain(meeting.swapped().facts())


def test_mirroring_twice_changes_nothing() -> None:
    for meeting in MEETINGS:
        assert plain(meeting.facts().mirrored().mirrored()) == plain(meeting.facts())


def test_facts_that_are_called_symmetric_or_antisymmetric_are_so_to_the_last_bit() -> None:
    for meeting in MEETINGS:
        one, other = meeting.facts(), meeting.swapped().facts()
        for name in ("course_difference", "tcpa", "dcpa", "distance", "same_waterway", "same_direction"):
            assert one[name] == other[name]
        assert under_way(one) is under_way(other)
        assert not (crosses(one) and crosses(other))
        assert [one.quantity(each) for each in BEARINGS] == [other.quantity(each) for each in BEARINGS[::-1]]


def test_head_on_and_crossing_are_the_same_from_both_sides() -> None:
    for meeting in MEETINGS:
        one, other = meeting.facts(), meeting.swapped().facts()
        assert is_head_on(one, LIMIT) is is_head_on(other, LIMIT)
        assert is_crossing(one, LIMIT) is is_crossing(other, LIMIT)


def test_two_ships_never_overtake_each_other() -> None:
    for meeting in MEETINGS:
        facts = meeting.facts()
        assert not (overtakes(facts, LIMIT) and overtakes(facts.mirrored(), LIMIT))


def test_ships_are_on_the_same_waterway_only_if_each_lies_between_the_other_ones_banks() -> None:
    wide = Waterway(id="wide", centreline=np.array([[-3000.0, 0.0], [3000.0, 0.0]]), width=400.0)
    narrow = Waterway(id="narrow", centreline=np.array([[-3000.0, 100.0], [3000.0, 100.0]]), width=100.0)
    waters = Waters(ruleset="tran2026", waterways=(wide, narrow))
    own = report(A, -900.0, 0.0, 0.0, waterway="wide")
    other = report(B, 900.0, 100.0, 180.0, waterway="narrow", towards=Towards.START)

    assert not assess(VOCABULARY, waters, own, other)["same_waterway"]
    assert not assess(VOCABULARY, waters, other, own)["same_waterway"]


def test_bearing_is_positive_to_starboard() -> None:
    own = report(A, 0.0, 0.0, 90.0)

    for north, bearing in ((-10.0, 90.0), (10.0, -90.0)):
        facts = Meeting(CHART, own, report(B, north, 0.0, 0.0)).facts()
        assert facts.quantity(("bearing", "own", "other")) == pytest.approx(bearing * DEGREE)


def test_courses_cross_from_starboard_where_the_other_one_lies_to_starboard() -> None:
    """On straight waterways, before the intersection, course and bearing tell the same side."""
    for from_starboard in (True, False):
        facts = crossing(other_from_starboard=from_starboard).facts()
        assert crosses(facts) is from_starboard
        assert crosses(facts.mirrored()) is not from_starboard
        assert (facts.quantity(("bearing", "own", "other")) > 0.0) is from_starboard


def test_ship_exactly_astern_bears_180_degrees_to_starboard_from_both_sides_of_north() -> None:
    for course in (0.0, 90.0, 180.0, 270.0):
        turn = course * DEGREE
        ahead = report(A, 100.0 * math.cos(turn), 100.0 * math.sin(turn), course)
        facts = Meeting(CHART, ahead, report(B, 0.0, 0.0, course)).facts()
        assert facts.quantity(("bearing", "own", "other")) == math.pi
        assert facts.mirrored().quantity(("bearing", "other", "own")) == math.pi


def test_ship_at_rest_has_no_course_and_bears_everything_ahead() -> None:
    for place in ((100.0, 0.0), (-100.0, -30.0), (0.0, 50.0)):
        still = Meeting(CHART, report(A, 0.0, 0.0, 200.0, speed=0.0), report(B, *place, 30.0)).facts()
        for facts in (still, still.mirrored().mirrored()):
            assert facts.quantity(("bearing", "own", "other")) == 0.0
            assert facts["course_difference"] == 0.0


# --- wherever they are ----------------------------------------------------------------------------


@given(st.sampled_from(MEETINGS), PLACES, PLACES, TURNS)
@settings(derandomize=True, max_examples=150, deadline=None)
def test_facts_do_not_change_when_the_world_is_moved_and_turned(
    meeting: Meeting, north: float, east: float, turn: float
) -> None:
    here, there = meeting.facts(), meeting.moved(north, east, turn).facts()
    rx, ry, wx, wy = here.motion[:4]
    closing = math.hypot(wx, wy)

    for measured in QUANTITIES:
        value, moved = here.quantity(measured), there.quantity(measured)
        if math.isinf(value):
            assert moved == value
        elif measured[0] in ("bearing", "course_difference"):
            assert wrap(moved - value) == pytest.approx(0.0, abs=5e-6)
        elif measured[0] in ("tcpa", "dcpa"):  # the grid moves velocities by so much
            blurred = 8.0 * GRID * (1.0 + math.hypot(rx, ry) / closing) / min(1.0, closing)
            assert moved == pytest.approx(value, abs=blurred)
        else:
            assert moved == pytest.approx(value, rel=1e-6, abs=4.0 * GRID)
    assert (there["same_direction"], under_way(there)) == (here["same_direction"], under_way(here))


@given(st.sampled_from(MEETINGS))
@settings(derandomize=True, max_examples=150, deadline=None)
def test_in_a_mirrored_world_only_sides_change(meeting: Meeting) -> None:
    here, there = meeting.facts(), meeting.mirrored_world().facts()

    for name in (
        "course_difference",
        "tcpa",
        "dcpa",
        "own.time_to_intersection",
        "other.time_to_intersection",
    ):
        assert there[name] == pytest.approx(here[name], rel=1e-9, abs=1e-6)
    assert crosses(there) is crosses(here.mirrored())
    for measured in BEARINGS:
        assert wrap(there.quantity(measured) + here.quantity(measured)) == pytest.approx(0.0, abs=1e-9)


# --- the starboard side ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("aside", "before", "follows"),
    [
        (KEEPS_STARBOARD, False, True),
        (KEEPS_STARBOARD - 0.1, False, False),
        (KEEPS_STARBOARD - 0.1, True, True),
        (LEAVES_STARBOARD + 0.1, True, True),
        (LEAVES_STARBOARD, True, False),
        (-20.0, True, False),
    ],
)
@pytest.mark.parametrize("towards", [Towards.START, Towards.END])
def test_ship_near_the_centreline_keeps_the_side_that_it_had(
    aside: float, before: bool, follows: bool, towards: Towards
) -> None:
    east = aside if towards is Towards.END else -aside
    ship = report(A, 0.0, east, 0.0 if towards is Towards.END else 180.0, towards=towards)

    assert follows_starboard_side(CHART, ship, before=before) is follows


def test_hysteresis_has_a_width() -> None:
    assert KEEPS_STARBOARD > LEAVES_STARBOARD >= 0.0


@pytest.mark.parametrize("stated", [True, False, UNKNOWN])
def test_what_a_ship_states_of_its_side_comes_first(stated: bool) -> None:
    for aside in (-20.0, 20.0):
        assert follows_starboard_side(CHART, report(A, 0.0, aside, 0.0, starboard=stated)) is stated


def test_unknown_is_not_known_and_false_is() -> None:
    known = condition("known(own.follows_starboard_side)")

    assert not known(head_on(UNKNOWN, False).facts())
    assert known(head_on(False, UNKNOWN).facts())


def test_within_an_encounter_the_sides_are_those_of_its_beginning() -> None:
    held = {ship: {"follows_starboard_side": True} for ship in (A, B)}
    memory = Encounter(geometry=Geometry.HEAD_ON, held=held)

    meeting = Meeting(
        CHART, report(A, -900.0, -20.0, 0.0), report(B, 900.0, 0.0, 180.0, towards=Towards.START)
    )
    facts = meeting.facts(memory)

    assert [facts[f"{ship}.follows_starboard_side"] for ship in ("own", "other")] == [True, True]
    assert meeting.facts(NO_ENCOUNTER)["own.follows_starboard_side"] is False
