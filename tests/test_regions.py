"""Laws by place: precedence, areas, neighbours, holes, and how a ship goes over from one law to another."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import box

from ccas_core.frames import NedPose
from ccas_core.regions import Hysteresis, InForce, Law, LawMap, Region, contested

BPR, CCNR, CEVNI = Law("bpr"), Law("ccnr"), Law("cevni")
USUAL = Hysteresis()


def square(id_: str, ruleset: str, low: float, high: float, precedence: int = 0) -> Region:
    """Square region from (low, low) to (high, high)."""
    corners = np.array([[low, low], [low, high], [high, high], [high, low]])
    return Region(id=id_, ruleset=ruleset, polygon=corners, precedence=precedence)


def at(north: float, east: float) -> NedPose:
    return NedPose(north, east, 0.0)


OUTER = square("outer", "ccnr", 0.0, 1000.0)
INNER = square("inner", "cevni", 400.0, 600.0, precedence=1)
LAWS = LawMap(BPR, (OUTER, INNER))
EAST = LawMap(
    BPR,
    (Region(id="e", ruleset="ccnr", polygon=np.array([[-9e3, 0.0], [-9e3, 9e3], [9e3, 9e3], [9e3, 0.0]])),),
)


def test_a_law_is_written_as_it_is_read() -> None:
    for text in ("bpr", "ccnr@2022.3.26", "example.shorter@1"):
        assert str(Law.parsed(text)) == text


@pytest.mark.parametrize(
    ("law", "ruleset", "version", "met"),
    [
        (Law("bpr"), "bpr", "1", True),
        (Law("bpr", "1"), "bpr", "1", True),
        (Law("bpr", "1"), "bpr", "2", False),
        (Law("bpr"), "ccnr", "1", False),
    ],
)
def test_a_law_without_a_version_is_met_by_any(law: Law, ruleset: str, version: str, met: bool) -> None:
    assert law.is_met_by(ruleset, version) is met


@pytest.mark.parametrize(
    ("place", "law"), [((500, 500), CEVNI), ((100, 100), CCNR), ((-100, 100), BPR), ((1000, 1000), CCNR)]
)
def test_the_greatest_precedence_prevails_whatever_the_order(place: tuple[float, float], law: Law) -> None:
    assert LAWS.at(at(*place)) == law
    assert LawMap(BPR, (INNER, OUTER)).at(at(*place)) == law


@settings(max_examples=200)
@given(north=st.floats(-2000, 2000), east=st.floats(-2000, 2000))
def test_the_areas_of_all_laws_hold_each_place_once_and_as_asked_for(north: float, east: float) -> None:
    here = LAWS.at(at(north, east))

    assert LAWS.is_near(here, at(north, east), 0.0)
    strictly = [law for law in LAWS.laws if not LAWS.is_near(law, at(north, east), 1e-9)]
    near_a_border = min(abs(side - each) for side in (0, 400, 600, 1000) for each in (north, east)) < 1e-6
    assert near_a_border or len(strictly) == len(LAWS.laws) - 1


def test_without_a_default_the_nearest_region_counts_outside_of_all() -> None:
    laws = LawMap(None, (square("a", "bpr", 0.0, 10.0), square("b", "ccnr", 100.0, 110.0)))

    assert laws.at(at(20.0, 20.0)) == BPR
    assert laws.at(at(90.0, 90.0)) == CCNR


def test_waters_without_any_law_are_refused() -> None:
    with pytest.raises(ValueError, match="a ruleset or a region"):
        LawMap(None, ())


def test_regions_that_overlap_are_contested_unless_one_prevails_or_the_law_is_one() -> None:
    one, two = square("one", "bpr", 0.0, 10.0), square("two", "ccnr", 5.0, 15.0)

    assert list(contested((one, two))) == [(one, two)]
    assert not list(contested((one, square("two", "ccnr", 5.0, 15.0, precedence=1))))
    assert not list(contested((one, square("two", "bpr", 5.0, 15.0))))
    assert not list(contested((one, square("two", "ccnr", 10.0, 15.0))))  # they only touch


def test_a_hole_is_found_where_there_is_no_default() -> None:
    water = box(-5.0, -5.0, 20.0, 5.0)
    hole = LawMap(None, (square("a", "bpr", -9.0, 9.0),)).uncovered(water)

    assert hole is not None
    assert 9.0 < hole.x < 20.0
    assert LawMap(None, (square("a", "bpr", -9.0, 90.0),)).uncovered(water) is None
    assert LawMap(BPR, (square("a", "bpr", -9.0, 9.0),)).uncovered(water) is None


def test_borders_are_those_on_the_water() -> None:
    canal = box(-50.0, -2000.0, 50.0, 2000.0)

    assert list(EAST.borders(canal)) == [(BPR, CCNR)]
    assert not list(EAST.borders(box(-50.0, -2000.0, 50.0, -5.0)))
    assert not list(LAWS.borders(box(100.0, 100.0, 200.0, 200.0)))


# --- going over -----------------------------------------------------------------------------------


def test_a_ship_goes_over_once_it_is_clear_of_the_border() -> None:
    before = EAST.in_force(at(0.0, -1.0), 0.0, None, USUAL)
    near = EAST.in_force(at(0.0, USUAL.width - 0.1), 20.0, before, USUAL)
    clear = EAST.in_force(at(0.0, USUAL.width + 0.1), 40.0, near, USUAL)

    assert (before.law, near, clear) == (BPR, before, InForce(CCNR, 40.0))


def test_a_ship_that_has_gone_over_stays_for_a_while() -> None:
    over = InForce(CCNR, 40.0)

    assert EAST.in_force(at(0.0, -500.0), 40.0 + USUAL.time - 1.0, over, USUAL) == over
    assert EAST.in_force(at(0.0, -500.0), 40.0 + USUAL.time, over, USUAL).law == BPR


def test_hysteresis_may_be_switched_off() -> None:
    off = Hysteresis(width=0.0, time=0.0)
    one = EAST.in_force(at(0.0, 0.1), 0.0, InForce(BPR, 0.0), off)

    assert one.law == CCNR
    assert EAST.in_force(at(0.0, -0.1), 0.0, one, off).law == BPR


@settings(max_examples=100, deadline=None)
@given(
    amplitude=st.floats(1.0, 60.0),
    period=st.floats(40.0, 600.0),
    middle=st.floats(-20.0, 20.0),
    seed=st.integers(0, 99),
)
def test_along_a_border_a_ship_goes_over_once_a_crossing_and_a_minute_at_most(
    amplitude: float, period: float, middle: float, seed: int
) -> None:
    noise = np.random.default_rng(seed).normal(0.0, 3.0, 400)
    now, law, changes, crossings, side = 0.0, None, [], 0, 0
    for shake in noise:
        east = middle + amplitude * math.sin(math.tau * now / period) + float(shake)
        here = 1 if east >= 0.0 else -1
        crossings += side not in (0, here)
        side = here
        after = EAST.in_force(at(3.0 * now, east), now, law, USUAL)
        if law is not None and after.law != law.law:
            changes.append(now)
        law = after
        now += 5.0

    assert len(changes) <= crossings
    assert all(later - sooner >= USUAL.time for sooner, later in itertools.pairwise(changes))
