"""Where plans lead: compiled, run by CasADi, and by hand."""

from __future__ import annotations

import numpy as np
import pytest

from ccas_core.dmpc import kinematics, trajectories
from ccas_core.dmpc.model import constants
from ccas_core.dmpc.trajectories import interpreted, rollout, sailed
from ccas_core.frames import FloatArray

from .problems import random_problem


def plans(generator: np.random.Generator, count: int, horizon: int) -> FloatArray:
    """Controls that nobody would choose, some of them out of bounds."""
    offset = generator.uniform(-90.0, 90.0, (count, horizon))
    return np.stack([offset, generator.uniform(-0.2, 1.2, (count, horizon))], axis=2)


def test_paths_are_those_of_the_kinematics() -> None:
    generator = np.random.default_rng(5)
    problem = random_problem(generator)
    controls = plans(generator, 4, 45)
    model = problem.settings.kinematics

    found = sailed(problem, controls)

    for path, plan in zip(found, controls, strict=True):
        pose = (problem.initial.x, problem.initial.y, problem.initial.course)
        assert path[0].tolist() == list(pose)
        for row, (offset, factor) in zip(path[1:], plan, strict=True):
            pose = kinematics.step(
                pose,
                float(offset),
                float(factor),
                speed=problem.speed,
                time_step=model.time_step,
                time_constant=model.time_constant,
                course_limit=model.course_limit,
                steering_gain=model.steering_gain,
            )
            np.testing.assert_allclose(row, pose, rtol=1e-12, atol=1e-12)


def test_without_numba_the_paths_are_the_same() -> None:
    generator = np.random.default_rng(6)
    problem = random_problem(generator)
    controls = plans(generator, 7, 45)
    start = np.array([problem.initial.x, problem.initial.y, problem.initial.course, problem.last_offset])
    paths = np.empty((7, 46, 3))

    interpreted(start, controls, constants(problem), paths)

    np.testing.assert_allclose(paths, sailed(problem, controls), rtol=1e-12, atol=1e-12)


def test_where_numba_is_missing_casadi_sails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trajectories, "find_spec", lambda _: None)
    trajectories._loop.cache_clear()
    try:
        assert trajectories._loop() is interpreted
    finally:
        trajectories._loop.cache_clear()


def test_a_rollout_keeps_the_bounds_and_sails_what_it_kept() -> None:
    generator = np.random.default_rng(7)
    problem = random_problem(generator)
    (controls,) = plans(generator, 1, 45)

    plan = rollout(problem, controls)

    low, high = problem.offset_limits.T
    assert np.array_equal(plan.controls[:, 0], np.clip(controls[:, 0], low, high))
    assert np.array_equal(plan.controls[:, 1], np.clip(controls[:, 1], 0.0, 1.0))
    assert np.array_equal(plan.trajectory.poses, sailed(problem, plan.controls[None])[0])


def test_controls_need_not_lie_in_a_row() -> None:
    generator = np.random.default_rng(8)
    problem = random_problem(generator)
    controls = plans(generator, 3, 45)
    turned = np.asfortranarray(controls)

    assert np.array_equal(sailed(problem, turned), sailed(problem, controls))
