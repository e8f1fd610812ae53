"""Eq. (8) and (9), control effort and behaviour: what the text and Fig. 4 say of them."""

from __future__ import annotations

from itertools import pairwise

import casadi as ca
import numpy as np
import pytest

from ccas_core.dmpc.cost import behaviour, control_effort, port_penalty, small_change_penalty
from ccas_core.dmpc.parameters import CROSSING, HEAD_ON

HABITS = {
    name: getattr(HEAD_ON.weights, name)
    for name in ("mu_1", "mu_2", "mu_3", "r_2", "side", "gamma_s", "gamma_y")
}


def test_effort_is_a_square_of_the_change_of_offset_and_of_the_loss_of_speed() -> None:
    assert control_effort(12.0, 7.0, 0.4, 3.0, 11.0) == pytest.approx(3.0 * 5.0**2 + 11.0 * 0.6**2)


def test_going_on_as_planned_costs_nothing() -> None:
    assert control_effort(-20.0, -20.0, 1.0, 5.0, 2e-2) == 0.0
    assert behaviour(-20.0, -20.0, 1.0, **HABITS) == 0.0


def test_crossing_ships_rather_change_speed_and_head_on_ships_course() -> None:
    ratio = [each.weights.K_y / each.weights.K_s for each in (HEAD_ON, CROSSING)]

    assert ratio == pytest.approx([1e-2 / 2e-2, 5.0 / 2e-2])


def test_B_1_lies_between_zero_and_one_and_is_zero_for_no_change_only() -> None:
    changes = np.linspace(-6.0, 6.0, 121)
    values = [small_change_penalty(float(change), 1.04) for change in changes]

    assert min(values) == 0.0 == small_change_penalty(0.0, 1.04)
    assert all(0.0 < value < 1.0 for value, change in zip(values, changes, strict=True) if abs(change) > 1e-9)


def test_B_1_is_steep_for_small_changes_and_flat_for_great_ones() -> None:
    def rise(change: float) -> float:
        return small_change_penalty(change + 0.01, 1.04) - small_change_penalty(change, 1.04)

    assert rise(0.5) > 5e-3
    assert 0.0 <= rise(5.0) < 1e-9


def test_B_1_is_the_same_to_either_side() -> None:
    assert small_change_penalty(-0.7, 0.5) == small_change_penalty(0.7, 0.5)


def test_B_1_is_wider_the_greater_r() -> None:
    assert small_change_penalty(1.0, 10.0) < small_change_penalty(1.0, 1.0)


def test_B_2_grows_with_a_turn_to_port_and_slowly() -> None:
    values = [port_penalty(change, HEAD_ON.weights.mu_3, 0.0) for change in (1.0, 5.0, 20.0, 60.0)]

    assert all(after > before > 0.0 for before, after in pairwise(values))
    assert values[-1] == pytest.approx(2.0 * HEAD_ON.weights.mu_3 * 60.0)  # linear, not quadratic


def test_B_2_is_small_to_starboard() -> None:
    for change in (1.0, 5.0, 20.0, 60.0):
        port, starboard = port_penalty(change, 1.0, 0.0), port_penalty(-change, 1.0, 0.0)

        assert abs(starboard) < 0.3
        assert abs(starboard) < port / 5.0


def test_turn_to_port_is_a_falling_offset_and_costs_more_than_one_to_starboard() -> None:
    port, starboard = behaviour(-20.0, 0.0, 1.0, **HABITS), behaviour(20.0, 0.0, 1.0, **HABITS)

    assert port - starboard == pytest.approx(2.0 * HABITS["mu_3"] * 20.0, rel=1e-6)


def test_ships_that_are_to_pass_starboard_to_starboard_rather_turn_to_port() -> None:
    habits = {**HABITS, "side": -1.0}
    port, starboard = behaviour(-20.0, 0.0, 1.0, **habits), behaviour(20.0, 0.0, 1.0, **habits)

    assert starboard - port == pytest.approx(2.0 * HABITS["mu_3"] * 20.0, rel=1e-6)


def test_behaviour_is_the_sum_of_eq_9() -> None:
    habits = {**HABITS, "r_2": 0.3}

    assert behaviour(4.0, 6.5, 0.9, **habits) == pytest.approx(
        habits["mu_1"] * (1.0 - np.exp(-(0.1**2) / habits["gamma_s"]))
        + habits["mu_2"] * (1.0 - np.exp(-(2.5**2) / habits["gamma_y"]))
        + habits["mu_3"] * 2.5 * (np.tanh(2.5 + 0.3) + 1.0)
    )


def test_symbols_give_the_same_numbers() -> None:
    symbols = ca.SX.sym("symbols", 12)
    offset, last, factor, K_y, K_s, *rest = ca.vertsplit(symbols)
    habits = dict(zip(HABITS, rest, strict=True))
    total = control_effort(offset, last, factor, K_y, K_s) + behaviour(offset, last, factor, **habits)
    symbolic = ca.Function("cost", [symbols], [total])
    generator = np.random.default_rng(9)

    for _ in range(100):
        offset_, last_ = map(float, generator.uniform(-60, 60, 2))
        factor_, K_y_, K_s_ = map(float, generator.uniform(0, 1, 3))
        values = dict(zip(HABITS, map(float, generator.uniform(0.01, 2, 7)), strict=True))
        numeric = control_effort(offset_, last_, factor_, K_y_, K_s_) + behaviour(
            offset_, last_, factor_, **values
        )
        found = float(symbolic(ca.DM([offset_, last_, factor_, K_y_, K_s_, *values.values()])))
        assert found == pytest.approx(numeric, rel=1e-13, abs=1e-13)
