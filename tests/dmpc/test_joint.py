"""The centralised baseline."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ccas_core.dmpc.joint import JointShip, joint_cost, solve_jointly
from ccas_core.dmpc.parameters import FAITHFUL
from ccas_core.frames import FloatArray, PathFrame, PathPose
from ccas_core.ships import Hull
from ccas_core.sweep.baseline import is_free

SETTINGS = replace(FAITHFUL, horizon=20)


def ship(line: list[list[float]]) -> JointShip:
    return JointShip(
        hull=Hull(length=60.0, beam=8.0),
        frame=PathFrame(np.array(line)),
        initial=PathPose(0.0, 0.0, 0.0),
        speed=3.0,
        offset_limits=np.tile([-60.0, 60.0], (20, 1)),
    )


TWO = (ship([[-600.0, 0.0], [600.0, 0.0]]), ship([[600.0, 4.0], [-600.0, 4.0]]))  # head-on


def steady(offset: float) -> FloatArray:
    return np.tile([offset, 1.0], (2, 20, 1))


def test_one_mind_finds_a_free_answer_that_is_not_dearer_than_any_guess() -> None:
    guesses = [steady(0.0), steady(15.0)]

    answer = solve_jointly(TWO, SETTINGS, guesses)

    assert is_free(TWO, answer)
    assert not is_free(TWO, joint_cost(TWO, SETTINGS, guesses[0]))
    assert all(answer.objective <= joint_cost(TWO, SETTINGS, guess).objective for guess in guesses)


def test_joint_problem_is_refused_where_lines_bend() -> None:
    bent = ship([[0.0, 0.0], [600.0, 0.0], [900.0, 300.0]])

    with pytest.raises(ValueError, match="straight"):
        solve_jointly([bent, TWO[0]], SETTINGS, [steady(0.0)])
