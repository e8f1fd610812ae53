"""Waters as a chart shows them: limits of the offset, junctions, routes, regions, banks."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Point, covers

from ccas_core.frames import FloatArray, NedPose, PathPose
from ccas_core.regions import Region
from ccas_core.waterway import (
    BANK_MARGIN,
    OFFSET_LIMIT,
    GuidingLine,
    Leg,
    Towards,
    Waters,
    Waterway,
    guiding_line,
)

OFFSETS = st.floats(-100.0, 100.0)
WIDTHS = st.floats(20.0, 400.0)
BEAMS = st.floats(4.0, 23.0)


def way(id_: str, *points: tuple[float, float], width: float = 160.0) -> Waterway:
    """Waterway through points [north, east]."""
    return Waterway(id=id_, centreline=np.array(points), width=width)


CANAL = way("canal", (0.0, -3000.0), (0.0, 3000.0))  # from west to east
RIVER = way("river", (-3000.0, 0.0), (3000.0, 0.0), width=100.0)  # from south to north
FAR = way("far", (5000.0, -3000.0), (5000.0, 3000.0))
CHART = Waters(ruleset="bpr", waterways=(CANAL, RIVER, FAR))


def along(offset: float = 0.0, width: float = 160.0) -> GuidingLine:
    waters = Waters(ruleset="bpr", waterways=(way("canal", (0.0, 0.0), (0.0, 1000.0), width=width),))
    return guiding_line(waters, [Leg("canal", Towards.END, offset)])


def turns(line: FloatArray) -> FloatArray:
    """Angle between neighbouring chords [rad]."""
    steps = np.diff(line, axis=0)
    courses = np.arctan2(steps[:, 1], steps[:, 0])
    return np.asarray(np.abs((np.diff(courses) + np.pi) % (2.0 * np.pi) - np.pi))


# --- limits of the offset -------------------------------------------------------------------------


def test_on_wide_water_the_offset_is_bounded_by_the_paper() -> None:
    assert along(width=400.0).offset_limits(500.0, beam=10.0) == (-OFFSET_LIMIT, OFFSET_LIMIT)


def test_on_narrow_water_the_hull_keeps_its_margin_to_both_banks() -> None:
    assert along(width=60.0).offset_limits(500.0, beam=10.0) == (-20.0, 20.0)


def test_a_guiding_line_to_starboard_leaves_less_room_there() -> None:
    assert along(offset=15.0, width=60.0).offset_limits(500.0, beam=10.0) == (-35.0, 5.0)


@pytest.mark.parametrize(("offset", "limits"), [(28.0, (-48.0, 0.0)), (-28.0, (0.0, 48.0))])
def test_a_line_beside_the_bank_stays_allowed_itself(offset: float, limits: tuple[float, float]) -> None:
    assert along(offset=offset, width=60.0).offset_limits(500.0, beam=10.0) == limits


@given(OFFSETS, WIDTHS, BEAMS)
@settings(derandomize=True, max_examples=60, deadline=None)
def test_zero_offset_is_always_allowed_and_sixty_metres_never_exceeded(
    offset: float, width: float, beam: float
) -> None:
    least, greatest = along(offset, width).offset_limits(500.0, beam)

    assert -OFFSET_LIMIT <= least <= 0.0 <= greatest <= OFFSET_LIMIT


@given(OFFSETS, WIDTHS, BEAMS)
@settings(derandomize=True, max_examples=60, deadline=None)
def test_a_limit_other_than_zero_keeps_the_hull_between_the_banks(
    offset: float, width: float, beam: float
) -> None:
    least, greatest = along(offset, width).offset_limits(500.0, beam)
    room = width / 2.0 - beam / 2.0 - BANK_MARGIN

    assert greatest == 0.0 or offset + greatest <= room + 1e-9
    assert least == 0.0 or offset + least >= -room - 1e-9


def test_limits_are_those_of_the_leg() -> None:
    line = guiding_line(CHART, [Leg("canal", Towards.END), Leg("river", Towards.END)])

    assert line.offset_limits(0.0, beam=10.0)[1] == OFFSET_LIMIT
    assert line.offset_limits(line.frame.length, beam=10.0)[1] == 40.0


# --- waterways ------------------------------------------------------------------------------------


def test_frames_of_the_two_directions_are_opposite() -> None:
    pose = NedPose(-20.0, 500.0, 0.0)

    there, back = (CANAL.frame(towards).to_path(pose) for towards in (Towards.END, Towards.START))

    assert (there.y, back.y) == (20.0, -20.0)
    assert there.x + back.x == pytest.approx(6000.0)


@pytest.mark.parametrize(
    ("pose", "held"),
    [
        (NedPose(0.0, 0.0, 0.0), True),
        (NedPose(80.0, 3000.0, 0.0), True),
        (NedPose(80.1, 0.0, 0.0), False),
        (NedPose(0.0, 3000.1, 0.0), False),
        (NedPose(0.0, -3000.1, 0.0), False),
    ],
)
def test_waterway_holds_what_lies_between_its_banks_and_ends(pose: NedPose, held: bool) -> None:
    assert CANAL.holds(pose) is held


def test_unknown_waterway_is_a_key_error() -> None:
    with pytest.raises(KeyError, match="moat"):
        CHART.waterway("moat")


# --- junctions ------------------------------------------------------------------------------------


def test_junction_is_the_same_from_both_waterways() -> None:
    assert CHART.junction("canal", "river") == NedPose(0.0, 0.0, 0.0)
    assert CHART.junction("river", "canal") == NedPose(0.0, 0.0, 0.0)


def test_waterways_that_do_not_meet_have_no_junction() -> None:
    assert CHART.junction("canal", "far") is None


def test_junction_of_a_waterway_that_ends_in_another_is_its_end() -> None:
    branch = way("branch", (0.0, 700.0), (2000.0, 700.0))
    waters = Waters(ruleset="bpr", waterways=(CANAL, branch))

    assert waters.junction("branch", "canal") == NedPose(0.0, 700.0, 0.0)


def test_junction_of_waterways_that_share_a_reach_lies_on_both() -> None:
    shared = way("shared", (-1000.0, 0.0), (0.0, 0.0), (0.0, 2000.0))
    waters = Waters(ruleset="bpr", waterways=(CANAL, shared))

    centre = waters.junction("canal", "shared")

    assert centre is not None
    assert CANAL.holds(centre)
    assert shared.holds(centre)


# --- routes ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("towards", "north"), [(Towards.END, -20.0), (Towards.START, 20.0)])
def test_offset_of_a_leg_is_to_starboard_of_the_way_that_one_goes(towards: Towards, north: float) -> None:
    line = guiding_line(CHART, [Leg("canal", towards, 20.0)])

    assert line.frame.vertices[:, 0] == pytest.approx([north, north])


def test_line_beside_a_bent_centreline_keeps_its_distance() -> None:
    bent = way("bent", (0.0, 0.0), (1000.0, 0.0), (2000.0, 600.0))
    line = guiding_line(Waters(ruleset="bpr", waterways=(bent,)), [Leg("bent", Towards.END, 20.0)], 1e-3)

    offsets = [bent.frame(Towards.END).to_path(NedPose(x, y, 0.0)).y for x, y in line.frame.vertices]

    assert offsets == pytest.approx([20.0] * len(offsets), abs=0.01)


def test_route_over_two_legs_changes_leg_at_the_junction() -> None:
    line = guiding_line(CHART, [Leg("canal", Towards.END), Leg("river", Towards.END)])
    change = line.leg_starts[1]

    assert line.leg_at(-10.0).waterway == line.leg_at(change - 1.0).waterway == "canal"
    assert line.leg_at(change).waterway == line.leg_at(line.frame.length + 10.0).waterway == "river"
    assert line.frame.vertices[0] == pytest.approx([0.0, -3000.0])
    assert line.frame.vertices[-1] == pytest.approx([3000.0, 0.0])


@pytest.mark.parametrize("offset", [-20.0, 0.0, 20.0])
def test_route_over_two_legs_changes_leg_on_the_way_whichever_way_it_turns(offset: float) -> None:
    for canal, river in product((Towards.START, Towards.END), repeat=2):
        line = guiding_line(CHART, [Leg("canal", canal, offset), Leg("river", river, offset)])

        assert 0.0 < line.leg_starts[1] < line.frame.length


@pytest.mark.parametrize("offset", [0.0, 20.0])
def test_route_that_turns_at_a_junction_stays_between_the_banks(offset: float) -> None:
    banks = CHART.banks()

    for canal, river in product((Towards.START, Towards.END), repeat=2):
        line = guiding_line(CHART, [Leg("canal", canal, offset), Leg("river", river, offset)])
        assert covers(banks, LineString(line.frame.vertices))


def test_route_along_a_bent_waterway_stays_between_the_banks() -> None:
    bent = way("bent", (0.0, 0.0), (1000.0, 0.0), (1000.0, 1000.0))
    waters = Waters(ruleset="bpr", waterways=(bent,))

    line = guiding_line(waters, [Leg("bent", Towards.END)])

    assert covers(waters.banks(), LineString(line.frame.vertices))


def test_limits_on_a_rounded_corner_keep_the_hull_between_the_banks() -> None:
    bent = way("bent", (0.0, 0.0), (1000.0, 0.0), (1500.0, 500.0))
    waters = Waters(ruleset="bpr", waterways=(bent,))
    line, banks = guiding_line(waters, [Leg("bent", Towards.END)]), waters.banks()

    for x in np.linspace(0.0, line.frame.length, 100):
        for limit in line.offset_limits(float(x), beam=10.0):
            point = line.frame.to_ned(PathPose(float(x), limit, 0.0))
            assert covers(banks, Point(point.x, point.y).buffer(5.0))


def test_route_over_three_legs_changes_leg_in_their_order() -> None:
    back = way("back", (1500.0, -3000.0), (1500.0, 3000.0))
    waters = Waters(ruleset="bpr", waterways=(CANAL, RIVER, back))
    legs = [
        Leg("canal", Towards.END, 20.0),
        Leg("river", Towards.END, 20.0),
        Leg("back", Towards.START, 20.0),
    ]

    line = guiding_line(waters, legs)

    assert line.leg_starts == tuple(sorted(line.leg_starts))
    middles = [
        (a + b) / 2.0 for a, b in zip(line.leg_starts, (*line.leg_starts[1:], line.frame.length), strict=True)
    ]
    assert [line.leg_at(x) for x in middles] == legs


def test_third_leg_that_crosses_the_first_too_is_joined_to_the_second() -> None:
    slant = way(
        "slant", (-1500.0, -2500.0), (2500.0, 1500.0)
    )  # crosses the canal in the west, the river in the south
    waters = Waters(ruleset="bpr", waterways=(CANAL, RIVER, slant))
    legs = [Leg("canal", Towards.END), Leg("river", Towards.END), Leg("slant", Towards.END)]

    line = guiding_line(waters, legs)

    assert line.leg_starts == tuple(sorted(line.leg_starts))
    assert line.leg_starts[-1] < line.frame.length


def test_legs_that_do_not_meet_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match="'canal' and 'far' do not meet"):
        guiding_line(CHART, [Leg("canal", Towards.END), Leg("far", Towards.END)])


@pytest.mark.parametrize("offset", [0.0, 20.0])
def test_branch_that_ends_at_a_centreline_can_be_entered_from_its_starboard_side(offset: float) -> None:
    branch = way("branch", (0.0, 0.0), (3000.0, 0.0))
    waters = Waters(ruleset="bpr", waterways=(CANAL, branch))

    line = guiding_line(waters, [Leg("canal", Towards.END, 20.0), Leg("branch", Towards.END, offset)])

    assert line.leg_at(line.frame.length).waterway == "branch"


# --- rounding -------------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [50.0, 300.0, 1000.0])
def test_corner_is_rounded_by_chords_that_turn_five_degrees_at_most(radius: float) -> None:
    line = guiding_line(CHART, [Leg("canal", Towards.END), Leg("river", Towards.END)], radius).frame

    assert turns(line.vertices).max() <= math.radians(5.0) + 1e-9
    assert turns(line.vertices).sum() == pytest.approx(math.pi / 2.0)


def test_rounded_corner_is_an_arc_of_the_turn_radius_tangent_to_both_legs() -> None:
    ways = (replace(CANAL, width=600.0), replace(RIVER, width=600.0))  # room for it
    waters = Waters(ruleset="bpr", waterways=ways)
    line = guiding_line(waters, [Leg("canal", Towards.END), Leg("river", Towards.END)], 300.0).frame
    centre = np.array([300.0, -300.0])

    arc = line.vertices[1:-1]

    assert np.hypot(*(arc - centre).T) == pytest.approx(300.0)
    assert arc[0] == pytest.approx([0.0, -300.0])
    assert arc[-1] == pytest.approx([300.0, 0.0])


def test_corner_with_little_room_is_rounded_more_tightly() -> None:
    short = way("short", (-40.0, 0.0), (100.0, 0.0))
    waters = Waters(ruleset="bpr", waterways=(CANAL, short))

    line = guiding_line(waters, [Leg("canal", Towards.END), Leg("short", Towards.END)], 300.0).frame

    assert line.vertices[-1] == pytest.approx([100.0, 0.0])
    assert line.vertices[1] == pytest.approx([0.0, -50.0])
    assert turns(line.vertices).max() <= math.radians(5.0) + 1e-9


def test_straight_route_and_slight_bends_keep_their_vertices() -> None:
    slight = way("slight", (0.0, 0.0), (1000.0, 0.0), (2000.0, 50.0))

    line = guiding_line(Waters(ruleset="bpr", waterways=(slight,)), [Leg("slight", Towards.END)])

    assert line.frame.vertices == pytest.approx(slight.centreline)


# --- regions and banks ----------------------------------------------------------------------------

RHINE = Region(
    id="rhine", ruleset="ccnr", polygon=np.array([[0.0, 0.0], [0.0, 100.0], [100.0, 100.0], [100.0, 0.0]])
)
WIDER = Region(id="wider", ruleset="cevni", polygon=2.0 * RHINE.polygon)
REGIONS = Waters(ruleset="bpr", waterways=(CANAL,), regions=(RHINE, WIDER))


@pytest.mark.parametrize(
    ("north", "east", "ruleset"),
    [(50.0, 50.0, "ccnr"), (100.0, 50.0, "ccnr"), (150.0, 50.0, "cevni"), (-1.0, 50.0, "bpr")],
)
def test_ruleset_is_that_of_the_first_region_that_holds_the_place(
    north: float, east: float, ruleset: str
) -> None:
    assert REGIONS.ruleset_at(NedPose(north, east, 0.0)) == ruleset


@pytest.mark.parametrize(
    ("north", "east", "navigable"),
    [
        (79.0, 1000.0, True),
        (81.0, 1000.0, False),
        (1000.0, 49.0, True),
        (1000.0, 51.0, False),
        (0.0, 3499.0, True),  # 500 m past the end: arriving is not grounding
        (0.0, 3501.0, False),
    ],
)
def test_banks_hold_every_waterway_and_some_water_past_its_ends(
    north: float, east: float, navigable: bool
) -> None:
    assert bool(covers(CHART.banks(), Point(north, east))) is navigable


def test_banks_of_a_bend_have_no_notch_outside() -> None:
    bent = way("bent", (0.0, 0.0), (1000.0, 0.0), (1000.0, 1000.0), width=100.0)

    assert covers(Waters(ruleset="bpr", waterways=(bent,)).banks(), Point(1049.0, -49.0))
