"""Units as numbers in SI, and angles brought into (-pi, pi]."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ccas_core import units
from ccas_core.units import wrap

ANGLES = st.floats(-1e4, 1e4)


@pytest.mark.parametrize(
    ("unit", "in_si"),
    [
        (180.0 * units.DEGREE, math.pi),
        (units.NAUTICAL_MILE / units.KNOT, units.HOUR),
        (units.KILOMETRE / units.KILOMETRE_PER_HOUR, units.HOUR),
        (60.0 * units.MINUTE, units.HOUR),
        (units.TONNE, 1000.0),
        (units.NAUTICAL_MILE, 1852.0),
    ],
)
def test_units_fit_together(unit: float, in_si: float) -> None:
    assert unit == pytest.approx(in_si)


@given(ANGLES)
@settings(derandomize=True)
def test_wrapped_angle_lies_in_the_half_open_interval(angle: float) -> None:
    assert -math.pi < wrap(angle) <= math.pi


@given(ANGLES)
@settings(derandomize=True)
def test_wrapped_angle_points_the_same_way(angle: float) -> None:
    assert math.cos(wrap(angle)) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrap(angle)) == pytest.approx(math.sin(angle), abs=1e-9)


@given(ANGLES)
@settings(derandomize=True)
def test_wrapping_twice_changes_nothing(angle: float) -> None:
    assert wrap(wrap(angle)) == wrap(angle)


@pytest.mark.parametrize("angle", [math.pi, -math.pi])
def test_astern_is_plus_pi_from_either_side(angle: float) -> None:
    assert wrap(angle) == math.pi
