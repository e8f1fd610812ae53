"""Gaps between hulls along trajectories, beside rectangles drawn by shapely."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from ccas_core import compiling
from ccas_core.dmpc import clearance
from ccas_core.dmpc.clearance import bank_gaps, find_gaps, gap_in_step, gaps
from ccas_core.frames import FloatArray
from ccas_core.ships import Hull
from ccas_core.sim.hulls import rectangles

ONE, OTHER = Hull(length=90.0, beam=10.0), Hull(length=40.0, beam=6.0)


def poses(generator: np.random.Generator, spread: float) -> FloatArray:
    """Two rows: a step of up to 80 m on any course."""
    begin, course = generator.uniform(-spread, spread, 2), generator.uniform(-np.pi, np.pi)
    end = begin + generator.uniform(0.0, 80.0) * np.array([np.cos(course), np.sin(course)])
    return np.column_stack([np.stack([begin, end]), [course, course]])


def distance(here: FloatArray, there: FloatArray) -> float:
    """Least distance in a step between a hull and the other's safety area, whichever is nearer."""
    share = np.linspace(0.0, 1.0, 201)[:, None]
    paths = [rows[:1] + share * (rows[1:] - rows[:1]) for rows in (here, there)]
    for path, rows in zip(paths, (here, there), strict=True):
        path[:, 2] = rows[1, 2]
    found = [
        shapely.distance(rectangles(paths[0], *a), rectangles(paths[1], *b))
        for a, b in (
            ((ONE.length, ONE.beam), (OTHER.safety_length, OTHER.safety_beam)),
            ((ONE.safety_length, ONE.safety_beam), (OTHER.length, OTHER.beam)),
        )
    ]
    return float(np.min(found))


def test_gap_is_never_more_than_the_distance_and_negative_where_areas_overlap() -> None:
    generator = np.random.default_rng(2)
    looked = 2.0 * 80.0 / 5.0  # the way of both ships between two looks [m]

    for _ in range(300):
        here, there = poses(generator, 120.0), poses(generator, 120.0)
        gap = float(gaps(ONE, here[None], OTHER, there)[0, 0])
        exact = distance(here, there)
        assert gap <= exact + looked
        assert (exact > 0.0) or gap <= looked
        if gap < 0.0:
            assert exact == 0.0


def test_gaps_of_many_plans_are_those_of_each() -> None:
    generator = np.random.default_rng(3)
    plans = np.stack([poses(generator, 200.0) for _ in range(7)])
    there = poses(generator, 200.0)

    together = gaps(ONE, plans, OTHER, there)

    for n in range(7):
        assert np.array_equal(together[n], gaps(ONE, plans[n : n + 1], OTHER, there)[0])


def walks(generator: np.random.Generator, count: int) -> FloatArray:
    """Wandering plans of 20 steps, (count, 21, 3)."""
    course = np.cumsum(generator.normal(0.0, 0.2, (count, 21)), axis=1) + generator.uniform(-np.pi, np.pi)
    steps = 60.0 * np.stack([np.cos(course), np.sin(course)], axis=2)
    steps[:, 0] = 0.0
    places = np.cumsum(steps, axis=1) + generator.uniform(-500.0, 500.0, 2)
    return np.concatenate([places, course[:, :, None]], axis=2)


def test_bounds_never_hide_the_step_in_which_two_ships_are_nearest() -> None:
    generator = np.random.default_rng(5)
    one, other = clearance._sizes(ONE), clearance._sizes(OTHER)

    for _ in range(100):
        plan, there = walks(generator, 1), walks(generator, 1)[0]
        found = gaps(ONE, plan, OTHER, there)[0]
        exact = np.array([gap_in_step(one, plan[0], other, there, k) for k in range(20)])
        if found.min() < clearance.FAR:
            assert np.isclose(found.min(), exact.min(), rtol=0.0, atol=1e-9)
            assert found.argmin() == exact.argmin()
        assert np.all(found[exact < clearance.FAR / 2.0] < clearance.FAR)


def test_compiled_gaps_are_those_of_the_loop_as_it_is_written() -> None:
    generator = np.random.default_rng(6)
    plans, there = walks(generator, 9), walks(generator, 1)[0]
    found = np.empty((9, 20))

    find_gaps(clearance._sizes(ONE), plans, clearance._sizes(OTHER), there, found)

    np.testing.assert_allclose(found, gaps(ONE, plans, OTHER, there), rtol=1e-12, atol=1e-9)


def test_where_numba_is_missing_the_loop_runs_as_it_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiling, "find_spec", lambda _: None)
    clearance._loop.cache_clear()
    try:
        assert clearance._loop() is find_gaps
    finally:
        clearance._loop.cache_clear()


def test_gap_to_what_is_not_a_number_is_not_a_number() -> None:
    here = np.zeros((1, 2, 3))

    for column in range(3):
        there = np.array([[0.0, 30.0, 0.0], [0.0, 30.0, 0.0]])
        there[1, column] = np.nan
        assert np.isnan(gaps(ONE, here, OTHER, there)[0, 0])


def test_gap_is_the_same_seen_from_the_other_ship() -> None:
    generator = np.random.default_rng(4)

    for _ in range(50):
        here, there = poses(generator, 100.0), poses(generator, 100.0)
        assert np.allclose(gaps(ONE, here[None], OTHER, there), gaps(OTHER, there[None], ONE, here))


def test_a_ship_that_turns_towards_a_bank_swings_its_ends_out() -> None:
    room = np.array([[-30.0, 30.0]])
    straight = np.array([[[0.0, 20.0, 0.0], [60.0, 20.0, 0.0]]])
    turned = np.array([[[0.0, 20.0, 0.0], [60.0, 20.0, 0.2]]])

    assert bank_gaps(ONE, straight, room)[0, 0] == 10.0
    assert bank_gaps(ONE, turned, room)[0, 0] < 10.0 - 45.0 * np.sin(0.2) + 0.2
