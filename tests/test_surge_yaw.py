"""The ship with surge speed and yaw rate: drift, turns, and what it cannot do."""

from __future__ import annotations

import math

import casadi as ca
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ccas_core.frames import NedPose
from ccas_core.surge_yaw import Current, Manoeuvrability, Motion, advance, step, usual, within

numbers = st.floats(-20.0, 20.0)
LIMITS = Manoeuvrability(max_speed=5.0, max_yaw_rate=0.2, acceleration=0.5, yaw_acceleration=0.1)


def test_ship_without_way_drifts_with_the_current() -> None:
    there = advance(NedPose(0.0, 0.0, 1.0), Motion(0.0, 0.0), Current(north=0.3, east=-0.4), 10.0)

    assert (there.x, there.y, there.course) == pytest.approx((3.0, -4.0, 1.0))


def test_ship_that_heads_up_into_the_current_keeps_its_track() -> None:
    yaw = -math.asin(0.5 / 2.0)
    there = advance(NedPose(0.0, 0.0, yaw), Motion(2.0, 0.0), Current(east=0.5), 20.0)

    assert there.y == pytest.approx(0.0)


def test_yaw_angle_comes_back_within_half_a_turn() -> None:
    assert advance(NedPose(0.0, 0.0, 3.0), Motion(1.0, 0.5), Current(), 1.0).course == pytest.approx(
        3.5 - math.tau
    )


@given(numbers, numbers, numbers)
def test_symbols_sail_as_numbers_do(yaw: float, surge: float, rate: float) -> None:
    symbols = ca.SX.sym("s", 3)
    after = step((0.0, 0.0, symbols[0]), symbols[1], symbols[2], (0.1, 0.2), 0.5, ca.cos, ca.sin)
    symbolic = ca.Function("step", [symbols], [ca.vertcat(*after)])

    expected = step((0.0, 0.0, yaw), surge, rate, (0.1, 0.2), 0.5)
    assert [float(x) for x in symbolic([yaw, surge, rate]).full().ravel()] == pytest.approx(
        expected, abs=1e-12
    )


@given(st.floats(0.0, 5.0), st.floats(-0.2, 0.2), numbers, numbers)
def test_motion_is_kept_within_all_limits(surge: float, rate: float, wish: float, turn: float) -> None:
    found = within(LIMITS, Motion(surge, rate), Motion(wish, turn), 2.0)

    assert 0.0 <= found.surge <= 5.0
    assert abs(found.yaw_rate) <= 0.2
    assert abs(found.surge - surge) <= 1.0 + 1e-12
    assert abs(found.yaw_rate - rate) <= 0.2 + 1e-12


@pytest.mark.parametrize("name", ["max_speed", "max_yaw_rate", "acceleration", "yaw_acceleration"])
def test_limit_that_is_not_positive_is_refused(name: str) -> None:
    limits = dict.fromkeys(LIMITS.__dataclass_fields__, 1.0) | {name: 0.0}

    with pytest.raises(ValueError, match=f"{name} of a ship must be positive"):
        Manoeuvrability(**limits)


def test_long_ship_turns_and_stops_on_a_longer_way() -> None:
    short, long = usual(10.0, 3.0), usual(100.0, 3.0)

    assert long.max_yaw_rate < short.max_yaw_rate
    assert long.acceleration < short.acceleration
