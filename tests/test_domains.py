"""Safety domains: their edges, their growth, and the distance between two of them."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from ccas_core.domains import AbstractDomain, DynamicBumper, Ellipse, Rectangle, gap

BUMPER = DynamicBumper(length=10.0, full_speed=5.0)
DOMAINS = (BUMPER, Ellipse(ahead=20.0, aside=8.0), Rectangle(length=30.0, breadth=8.0))

angles = st.floats(-math.pi, math.pi)
speeds = st.floats(0.0, 9.0)


@given(angles)
def test_bumper_at_rest_is_a_circle_of_eight_tenths_of_the_length(angle: float) -> None:
    assert BUMPER.extent(math.cos(angle), math.sin(angle), 0.0) == pytest.approx(8.0)


@given(speeds)
def test_bumper_is_a_half_circle_astern_at_any_speed(speed: float) -> None:
    for angle in (math.pi / 2.0, 2.0, math.pi):
        assert BUMPER.extent(math.cos(angle), math.sin(angle), speed) == pytest.approx(8.0)


@given(angles, speeds, speeds)
def test_bumper_grows_with_speed_up_to_full_speed(angle: float, one: float, other: float) -> None:
    slow, fast = sorted((one, other))
    ahead, aside = math.cos(angle), math.sin(angle)

    assert BUMPER.extent(ahead, aside, slow) <= BUMPER.extent(ahead, aside, fast) + 1e-9
    assert BUMPER.extent(ahead, aside, 5.0) == pytest.approx(BUMPER.extent(ahead, aside, 7.0))


def test_bumper_ahead_is_half_an_ellipse() -> None:
    for angle in np.linspace(0.0, math.pi / 2.0, 10):
        edge = BUMPER.extent(math.cos(angle), math.sin(angle), 5.0)
        on_ellipse = (edge * math.cos(angle) / 32.0) ** 2 + (edge * math.sin(angle) / 8.0) ** 2

        assert on_ellipse == pytest.approx(1.0)


def test_rectangle_has_its_corners_on_the_edge() -> None:
    rectangle = Rectangle(length=30.0, breadth=8.0)

    assert [rectangle.gauge(a, b, 1.0) for a, b in rectangle.outline(1.0)] == pytest.approx([1.0] * 4)


@pytest.mark.parametrize("domain", DOMAINS)
def test_outline_is_convex_and_lies_on_the_edge(domain: AbstractDomain) -> None:
    outline = domain.outline(4.0)
    shape = shapely.Polygon(outline)

    assert domain.gauge(outline[:, 0], outline[:, 1], 4.0) == pytest.approx(1.0)
    assert shape.area == pytest.approx(shape.convex_hull.area, rel=1e-9)


@pytest.mark.parametrize("domain", DOMAINS)
@given(angle=angles, speed=speeds)
def test_symbols_go_through_the_same_formula(domain: AbstractDomain, angle: float, speed: float) -> None:
    ahead, aside, surge = ca.SX.sym("ahead"), ca.SX.sym("aside"), ca.SX.sym("surge")
    symbolic = ca.Function("extent", [ahead, aside, surge], [domain.extent(ahead, aside, surge)])
    place = 40.0 * math.cos(angle), 40.0 * math.sin(angle)

    assert float(symbolic(*place, speed)) == pytest.approx(float(domain.extent(*place, speed)), rel=1e-9)


@given(angles, angles, st.floats(1.0, 200.0))
def test_domains_that_are_apart_have_a_gap(bearing: float, turn: float, sight: float) -> None:
    other = DynamicBumper(length=20.0, full_speed=5.0)
    here = shapely.Polygon(BUMPER.outline(4.0))
    cos, sin = math.cos(turn), math.sin(turn)
    rows = other.outline(3.0) @ np.array([[cos, sin], [-sin, cos]])
    there = shapely.Polygon(rows + sight * np.array([math.cos(bearing), math.sin(bearing)]))
    back = bearing + math.pi - turn
    bearings = (math.cos(bearing), math.sin(bearing), math.cos(back), math.sin(back))

    assume(here.disjoint(there))
    found = gap(BUMPER, other, sight=sight, bearings=bearings, speeds=(4.0, 3.0))

    assert found > -0.1  # outlines are polygons, a little smaller than the domains
