"""Eq. (6), the collision risk: what the text says of it."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import casadi as ca
import numpy as np
import pytest

from ccas_core.dmpc.parameters import Risk, RiskShape, Weights
from ccas_core.dmpc.risk import collision_risk, threat
from ccas_core.frames import FloatArray, PathTrajectory
from ccas_core.ships import Hull

BARGE = Hull(length=103.0, beam=11.4)
BOAT = Hull(length=20.0, beam=5.0)
WEIGHTS = Weights()
ALIGNED = Risk()
PRINTED = Risk(shape=RiskShape.AXIS_BOUND)
HORIZON = 12


def standing(course: float = 0.0) -> PathTrajectory:
    """Another ship that lies at the origin with some course, so that a position is a distance."""
    return PathTrajectory(np.tile([0.0, 0.0, course], (HORIZON + 1, 1)))


def felt(rows: FloatArray, k: int, dx: float, dy: float) -> float:
    """Risk at step k = 1, 2, ... and at a distance from the other ship."""
    x, y, *rest = map(float, rows[k - 1])
    return collision_risk(dx - x, dy - y, rest[0], rest[1], rest[2], rest[3])


@pytest.mark.parametrize("risk", [ALIGNED, PRINTED], ids=["aligned", "printed"])
def test_risk_is_highest_at_no_distance_and_is_there_the_discounted_gain(risk: Risk) -> None:
    rows = threat(BARGE, BARGE, standing(0.7), risk, WEIGHTS)

    for k in range(1, HORIZON + 1):
        top = felt(rows, k, 0.0, 0.0)
        assert top == pytest.approx(WEIGHTS.K_ca / math.sqrt(1.0 + WEIGHTS.K_d * k), rel=1e-14)
        assert top > felt(rows, k, 1.0, 0.0)
        assert top > felt(rows, k, 0.0, -1.0)


@pytest.mark.parametrize("risk", [ALIGNED, PRINTED], ids=["aligned", "printed"])
def test_risk_never_exceeds_K_ca(risk: Risk) -> None:
    rows = threat(BARGE, BOAT, standing(-1.1), risk, WEIGHTS)
    generator = np.random.default_rng(6)

    assert max(felt(rows, 1, *map(float, generator.normal(0, 50, 2))) for _ in range(200)) <= WEIGHTS.K_ca


def test_risk_falls_with_the_step_for_it_is_known_less_well() -> None:
    rows = threat(BARGE, BARGE, standing(), ALIGNED, WEIGHTS)
    values = [felt(rows, k, 20.0, 5.0) for k in range(1, HORIZON + 1)]

    assert all(later < sooner for sooner, later in pairwise(values))


def test_without_discount_all_steps_weigh_the_same() -> None:
    rows = threat(BARGE, BARGE, standing(), ALIGNED, replace(WEIGHTS, K_d=0.0))

    assert {felt(rows, k, 20.0, 5.0) for k in range(1, HORIZON + 1)} == {felt(rows, 1, 20.0, 5.0)}


@pytest.mark.parametrize("risk", [ALIGNED, PRINTED], ids=["aligned", "printed"])
@pytest.mark.parametrize("bearing", [0.0, 0.5, 1.6, 3.0, -2.0])
def test_risk_falls_with_distance_and_vanishes_far_away(risk: Risk, bearing: float) -> None:
    rows = threat(BARGE, BARGE, standing(0.4), risk, WEIGHTS)
    values = [felt(rows, 1, d * math.cos(bearing), d * math.sin(bearing)) for d in (0, 5, 10, 20, 40, 60)]

    assert all(farther < nearer for nearer, farther in pairwise(values))
    assert felt(rows, 1, 1000.0 * math.cos(bearing), 1000.0 * math.sin(bearing)) < 1e-9


def test_axis_bound_form_is_the_printed_formula_whatever_the_course() -> None:
    generator = np.random.default_rng(7)
    for course in (0.0, 1.0, math.pi / 2):
        rows = threat(BARGE, BOAT, standing(course), PRINTED, WEIGHTS)
        dx, dy = map(float, generator.uniform(-60, 60, 2))
        k = int(generator.integers(1, HORIZON + 1))
        height = WEIGHTS.K_ca / math.sqrt(1.0 + WEIGHTS.K_d * k)

        printed = height * math.exp(-(dx**2) / PRINTED.alpha_x - dy**2 / PRINTED.alpha_y)
        assert felt(rows, k, dx, dy) == pytest.approx(printed, rel=1e-14)


def test_distance_is_that_between_the_ships_at_the_same_step() -> None:
    poses = np.column_stack([60.0 * np.arange(HORIZON + 1), np.full(HORIZON + 1, 7.0), np.zeros(HORIZON + 1)])
    rows = threat(BARGE, BARGE, PathTrajectory(poses), ALIGNED, WEIGHTS)

    for k in range(1, HORIZON + 1):
        assert felt(rows, k, 60.0 * k, 7.0) == pytest.approx(WEIGHTS.K_ca / math.sqrt(1 + WEIGHTS.K_d * k))


def test_course_aligned_ellipse_turns_with_the_course_of_the_other() -> None:
    along = threat(BOAT, BARGE, standing(0.0), ALIGNED, WEIGHTS)
    across = threat(BOAT, BARGE, standing(math.pi / 2), ALIGNED, WEIGHTS)

    assert felt(along, 1, 60.0, 0.0) > felt(along, 1, 0.0, 60.0)
    assert felt(across, 1, 0.0, 60.0) > felt(across, 1, 60.0, 0.0)


def test_axes_of_the_ellipse_are_kappa_times_both_half_extents_there() -> None:
    rows = threat(BARGE, BOAT, standing(0.0), ALIGNED, WEIGHTS)
    top = felt(rows, 1, 0.0, 0.0)

    ahead = ALIGNED.kappa_along * (BOAT.safety_length + BARGE.length) / 2.0
    abeam = ALIGNED.kappa_across * (BOAT.safety_beam + BARGE.beam) / 2.0
    assert felt(rows, 1, ahead, 0.0) == pytest.approx(top / math.e)
    assert felt(rows, 1, 0.0, abeam) == pytest.approx(top / math.e)


@pytest.mark.parametrize("course", [0.3, 1.2, -2.5])
def test_risk_is_the_same_on_both_sides_of_the_other_and_before_and_behind_it(course: float) -> None:
    rows = threat(BARGE, BARGE, standing(course), ALIGNED, WEIGHTS)
    cos, sin = math.cos(course), math.sin(course)

    def at(ahead: float, abeam: float) -> float:
        return felt(rows, 1, ahead * cos - abeam * sin, ahead * sin + abeam * cos)

    assert at(40.0, 15.0) == pytest.approx(at(-40.0, 15.0)) == pytest.approx(at(40.0, -15.0))


def test_risk_of_one_towards_the_other_is_in_general_not_that_of_the_other_towards_the_one() -> None:
    barge_fears_boat = threat(BARGE, BOAT, standing(math.pi / 2), ALIGNED, WEIGHTS)
    boat_fears_barge = threat(BOAT, BARGE, standing(-math.pi / 2), ALIGNED, WEIGHTS)
    # The boat lies 40 m ahead of the barge and crosses; seen from the boat, the barge is 40 m abeam.

    one, other = felt(barge_fears_boat, 1, -40.0, 0.0), felt(boat_fears_barge, 1, 0.0, 40.0)
    assert abs(one - other) > 0.01 * max(one, other)


def test_symbols_give_the_same_numbers() -> None:
    arguments = ca.SX.sym("arguments", 6)
    symbolic = ca.Function("risk", [arguments], [collision_risk(*ca.vertsplit(arguments))])
    generator = np.random.default_rng(8)

    for _ in range(100):
        dx, dy = map(float, generator.uniform(-100, 100, 2))
        a, b, c, gain = map(float, generator.uniform([1e-5, -1e-5, 1e-4, 1], [1e-3, 1e-5, 1e-2, 2e3]))
        assert float(symbolic(ca.DM([dx, dy, a, b, c, gain]))) == pytest.approx(
            collision_risk(dx, dy, a, b, c, gain), rel=1e-13
        )
