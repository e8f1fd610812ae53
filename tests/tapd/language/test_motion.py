"""Quantities of motion as signs of polynomials: the same as plain arithmetic, and exact on the limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest

from ccas_core.tapd.facts import GRID, PairFacts
from ccas_core.tapd.language.motion import tangent
from ccas_core.units import DEGREE

from .. import stated
from . import PLAIN, moving, random_facts

RELATIONS: dict[str, Callable[[float, float], bool]] = {
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}
LIMITS = {  # text of a quantity -> unit, limits, and how the facts give its value
    "tcpa": ("s", (-100.0, 0.0, 60.0, 300.0), ("tcpa",)),
    "dcpa": ("m", (-5.0, 0.0, 40.0, 200.0), ("dcpa",)),
    "distance": ("m", (-5.0, 0.0, 100.0, 500.0), ("distance",)),
    "own.speed": ("m/s", (-1.0, 0.0, 3.0, 4.0), ("speed", "own")),
    "other.speed": ("m/s", (-1.0, 0.0, 3.0, 4.0), ("speed", "other")),
    "course_difference": (
        "deg",
        (-10.0, 0.0, 22.5, 67.5, 90.0, 112.5, 157.5, 180.0, 200.0),
        ("course_difference",),
    ),
    "bearing(own, other)": (
        "deg",
        (-200.0, -180.0, -112.5, -90.0, -22.5, 0.0, 22.5, 90.0, 112.5, 180.0, 200.0),
        ("bearing", "own", "other"),
    ),
    "bearing(other, own)": ("deg", (-112.5, -90.0, 0.0, 45.0, 112.5), ("bearing", "other", "own")),
    "abs(bearing(other, own))": ("deg", (-10.0, 0.0, 22.5, 90.0, 112.5, 180.0), ("abs", "other", "own")),
}
FACTS = [random_facts(np.random.default_rng(seed)) for seed in range(150)]


def plain(facts: PairFacts, quantity: str) -> float:
    """Value of a quantity by plain arithmetic, written anew."""
    rx, ry, wx, wy, ovx, ovy, tvx, tvy = facts.motion[:8]
    velocity = {"own": complex(ovx, ovy), "other": complex(tvx, tvy)}
    apart = complex(rx, ry)
    closing = complex(wx, wy)
    if quantity == "distance":
        return abs(apart)
    if quantity.endswith(".speed"):
        return abs(velocity[quantity.partition(".")[0]])
    if quantity == "tcpa":
        return math.inf if closing == 0 else -(apart * closing.conjugate()).real / abs(closing) ** 2
    if quantity == "dcpa":
        return abs(apart) if closing == 0 else abs((apart * closing.conjugate()).imag) / abs(closing)
    if quantity == "course_difference":
        return abs(angle(velocity["other"], velocity["own"]))
    if "(own, other)" in quantity:
        return angle(apart, velocity["own"])
    bearing = angle(-apart, velocity["other"])
    return abs(bearing) if quantity.startswith("abs") else bearing


def angle(to: complex, since: complex) -> float:
    """Angle [deg] from one vector to another, clockwise; 0 where one of them is zero."""
    if to == 0 or since == 0:
        return 0.0
    found = math.degrees(np.angle(to / since))
    return 180.0 if found == -180.0 else float(found)


@pytest.mark.parametrize("relation", RELATIONS)
@pytest.mark.parametrize("quantity", LIMITS)
def test_comparison_is_that_of_plain_arithmetic_away_from_the_limit(quantity: str, relation: str) -> None:
    unit, limits, _ = LIMITS[quantity]
    asked = 0
    for limit in limits:
        decide = PLAIN.decide(f"{quantity} {relation} {limit:g} {unit}")
        for facts in FACTS:
            value = plain(facts, quantity)
            if abs(value - limit) < 1e-3 or abs(abs(value) - 180.0) < 1e-3 > abs(abs(limit) - 180.0):
                continue
            assert decide(facts) is RELATIONS[relation](value, limit), (facts.motion, limit)
            asked += 1
    assert asked > 200


@pytest.mark.parametrize("quantity", LIMITS)
def test_value_that_is_shown_is_that_of_plain_arithmetic(quantity: str) -> None:
    unit, _, measured = LIMITS[quantity]
    for facts in FACTS:
        shown = facts.quantity(measured) / (DEGREE if unit == "deg" else 1.0)
        assert shown == pytest.approx(plain(facts, quantity), rel=1e-9, abs=1e-6)


# --- exactly on the limit -------------------------------------------------------------------------

ON_THE_LIMIT = [
    ("tcpa", "60 s", moving(300.0, 0.0, (5.0, 0.0), (0.0, 0.0))),
    ("tcpa", "0 s", moving(0.0, 300.0, (5.0, 0.0), (1.0, 0.0))),
    ("tcpa", "0 s", moving(0.0, 0.0, (5.0, 0.0), (1.0, 0.0))),
    ("tcpa", "-60 s", moving(-300.0, 0.0, (5.0, 0.0), (0.0, 0.0))),
    ("dcpa", "40 m", moving(300.0, 40.0, (5.0, 0.0), (-3.0, 0.0))),
    ("dcpa", "40 m", moving(300.0, -40.0, (5.0, 0.0), (-3.0, 0.0))),
    ("dcpa", "50 m", moving(30.0, 40.0, (5.0, 0.0), (5.0, 0.0))),
    ("dcpa", "0 m", moving(300.0, 0.0, (5.0, 0.0), (-3.0, 0.0))),
    ("distance", "50 m", moving(30.0, -40.0, (5.0, 0.0), (-3.0, 0.0))),
    ("distance", "0 m", moving(0.0, 0.0, (5.0, 0.0), (-3.0, 0.0))),
    ("own.speed", "5 m/s", moving(30.0, -40.0, (3.0, -4.0), (-3.0, 0.0))),
    ("own.speed", "0 m/s", moving(30.0, -40.0, (0.0, 0.0), (-3.0, 0.0))),
    ("course_difference", "0 deg", moving(30.0, -40.0, (3.0, 4.0), (6.0, 8.0))),
    ("course_difference", "45 deg", moving(30.0, -40.0, (3.0, 0.0), (2.0, -2.0))),
    ("course_difference", "90 deg", moving(30.0, -40.0, (3.0, 0.0), (0.0, 2.0))),
    ("course_difference", "135 deg", moving(30.0, -40.0, (3.0, 0.0), (-2.0, -2.0))),
    ("course_difference", "180 deg", moving(30.0, -40.0, (3.0, 1.0), (-3.0, -1.0))),
    ("bearing(own, other)", "0 deg", moving(30.0, 0.0, (3.0, 0.0), (0.0, 0.0))),
    ("bearing(own, other)", "45 deg", moving(30.0, 30.0, (3.0, 0.0), (0.0, 0.0))),
    ("bearing(own, other)", "-45 deg", moving(30.0, -30.0, (3.0, 0.0), (0.0, 0.0))),
    ("bearing(own, other)", "90 deg", moving(0.0, 30.0, (3.0, 0.0), (0.0, 0.0))),
    ("bearing(own, other)", "-90 deg", moving(0.0, -30.0, (3.0, 0.0), (0.0, 0.0))),
    ("bearing(own, other)", "135 deg", moving(-30.0, 30.0, (3.0, 0.0), (0.0, 0.0))),
    ("bearing(own, other)", "-135 deg", moving(-30.0, -30.0, (3.0, 0.0), (0.0, 0.0))),
    ("bearing(own, other)", "180 deg", moving(-30.0, 0.0, (3.0, 0.0), (0.0, 0.0))),
    ("abs(bearing(other, own))", "135 deg", moving(-30.0, 30.0, (3.0, 0.0), (-2.0, 0.0))),
]


@pytest.mark.parametrize(("quantity", "limit", "facts"), ON_THE_LIMIT)
def test_on_the_limit_a_value_is_at_least_and_at_most_but_neither_less_nor_greater(
    quantity: str, limit: str, facts: PairFacts
) -> None:
    answers = {relation: PLAIN.decide(f"{quantity} {relation} {limit}")(facts) for relation in RELATIONS}

    assert answers == {"<": False, "<=": True, ">": False, ">=": True}


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(
    ("quantity", "limit", "place"),
    [("dcpa", "40 m", (300.0, 40.0)), ("distance", "50 m", (30.0, 40.0)), ("tcpa", "60 s", (300.0, 0.0))],
)
def test_one_step_of_the_grid_off_the_limit_decides(
    quantity: str, limit: str, place: tuple[float, float], side: float
) -> None:
    rx, ry = place
    rx, ry = (rx + side * GRID, ry) if quantity == "tcpa" else (rx, ry + side * GRID)
    facts = moving(rx, ry, (5.0, 0.0), (0.0, 0.0))

    assert PLAIN.decide(f"{quantity} > {limit}")(facts) is (side > 0)
    assert PLAIN.decide(f"{quantity} < {limit}")(facts) is (side < 0)


# --- at rest, and without relative motion -----------------------------------------------------------


def test_without_relative_motion_the_closest_approach_is_never_and_here() -> None:
    together = moving(30.0, 40.0, (3.0, 1.0), (3.0, 1.0))

    for text in ("tcpa > 1000000 s", "tcpa >= 0 s", "dcpa >= 50 m", "dcpa <= 50 m", "not closing"):
        assert PLAIN.decide(text)(together)
    for text in ("tcpa < 1000000 s", "tcpa <= 0 s", "dcpa > 50 m", "dcpa < 50 m"):
        assert not PLAIN.decide(text)(together)


@pytest.mark.parametrize("quantity", ["course_difference", "bearing(own, other)", "abs(bearing(own, other))"])
def test_angle_at_a_ship_at_rest_is_0(quantity: str) -> None:
    still = moving(30.0, -40.0, (0.0, 0.0), (3.0, 1.0))

    for limit in (-180.0, -90.0, -22.5, 0.0, 22.5, 90.0, 112.5, 180.0):
        for relation, compare in RELATIONS.items():
            text = f"{quantity} {relation} {limit:g} deg"
            assert PLAIN.decide(text)(still) is compare(0.0, limit), text


def test_ship_at_rest_crosses_nobody() -> None:
    still = moving(30.0, -40.0, (0.0, 0.0), (3.0, 1.0))

    assert not PLAIN.decide("from_starboard(own, other)")(still)
    assert not PLAIN.decide("from_starboard(other, own)")(still)


# --- words ----------------------------------------------------------------------------------------


def test_from_starboard_is_a_course_that_crosses_to_port_and_never_both() -> None:
    one, other = PLAIN.decide("from_starboard(own, other)"), PLAIN.decide("from_starboard(other, own)")
    for facts in FACTS:
        _, _, _, _, ovx, ovy, tvx, tvy = facts.motion[:8]
        turn = ovx * tvy - ovy * tvx
        if abs(turn) > 1e-3:
            assert one(facts) is (turn < 0)
            assert other(facts) is (turn > 0)
        assert not (one(facts) and other(facts))


def test_closing_is_a_range_that_shrinks() -> None:
    decide = PLAIN.decide("closing")
    for facts in FACTS:
        rx, ry, wx, wy = facts.motion[:4]
        change = math.hypot(rx + 1e-3 * wx, ry + 1e-3 * wy) - math.hypot(rx, ry)
        if abs(rx * wx + ry * wy) > 1.0:
            assert decide(facts) is (change < 0)


def test_time_to_the_intersection_is_compared_as_it_is_and_may_be_never() -> None:
    facts = stated(at=((0, 0, 0, 3), (10, 10, 20, 3)))  # nearly parallel: one waterway

    assert facts["own.time_to_intersection"] == math.inf
    assert not PLAIN.decide("own.time_to_intersection < 1000000 h")(facts)
    assert PLAIN.decide("own.time_to_intersection <= other.time_to_intersection")(facts)


@pytest.mark.parametrize("degrees", [1, 22.5, 45, 67.5, 89])
def test_tangent_is_a_fraction_near_to_the_tangent(degrees: float) -> None:
    found = tangent(Fraction(degrees))

    assert found.denominator <= 10**6
    assert math.degrees(math.atan(found)) == pytest.approx(degrees, abs=1e-6)
