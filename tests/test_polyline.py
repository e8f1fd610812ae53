"""The loops behind path frames: compiled and as they are written."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from ccas_core import compiling, polyline
from ccas_core.frames import NedPose, NedTrajectory, PathFrame, PathTrajectory, frozen_array
from ccas_core.polyline import WORTH, find_places, find_poses, loops


def bent(generator: np.random.Generator) -> PathFrame:
    """A line that turns by up to a right angle at each of its vertices."""
    course = np.cumsum(generator.uniform(-np.pi / 2.0, np.pi / 2.0, 9))
    steps = generator.uniform(50.0, 500.0, 9)[:, None] * np.column_stack([np.cos(course), np.sin(course)])
    return PathFrame(frozen_array(np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)])))


def test_compiled_loops_give_what_they_give_as_they_are_written() -> None:
    generator = np.random.default_rng(3)

    for _ in range(20):
        frame = bent(generator)
        poses = np.column_stack([generator.uniform(-900.0, 900.0, (40, 2)), generator.uniform(-7.0, 7.0, 40)])
        found = np.empty_like(poses)
        find_places(frame._line, 0, 9, poses, found)
        there = frame.trajectory_to_path(NedTrajectory(poses)).poses
        np.testing.assert_allclose(there, found, rtol=1e-12, atol=1e-9)
        find_poses(frame._line, poses, found)
        there = frame.trajectory_to_ned(PathTrajectory(poses)).poses
        np.testing.assert_allclose(there, found, rtol=1e-12, atol=1e-9)


def test_one_pose_is_read_like_many() -> None:
    generator = np.random.default_rng(4)
    frame = bent(generator)
    poses = np.column_stack([generator.uniform(-900.0, 900.0, (9, 2)), generator.uniform(-3.0, 3.0, 9)])
    many = frame.trajectory_to_path(NedTrajectory(poses)).poses

    for row, pose in zip(many, poses.tolist(), strict=True):
        one = frame.to_path(NedPose(*pose))
        np.testing.assert_allclose([one.x, one.y, one.course], row, rtol=1e-12, atol=1e-9)


def test_what_is_not_a_number_stays_so() -> None:
    frame = bent(np.random.default_rng(5))
    poses = np.zeros((5, 3))
    poses[[1, 2, 3], [0, 1, 2]] = np.nan

    there = frame.trajectory_to_path(NedTrajectory(poses)).poses

    assert np.isnan(there[1:3, :2]).all()
    assert np.isnan(there[3, 2])
    assert np.isfinite(there[[0, 4]]).all()
    assert np.isnan(frame.trajectory_to_ned(PathTrajectory(poses)).poses[[1, 2, 3], [0, 1, 2]]).all()


def test_without_numba_loops_run_as_they_are_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiling, "find_spec", lambda _: None)
    polyline._compiled.cache_clear()
    try:
        assert loops(WORTH) == (find_places, find_poses)
    finally:
        polyline._compiled.cache_clear()


def test_a_pose_alone_loads_no_compiler() -> None:
    program = (
        "import sys, numpy as np\n"
        "from ccas_core.frames import NedPose, PathFrame\n"
        "frame = PathFrame(np.array([[0.0, 0.0], [900.0, 0.0], [1500.0, 500.0]]))\n"
        "assert round(frame.to_path(NedPose(400.0, 20.0, 0.0)).y, 6) == 20.0\n"
        "assert 'numba' not in sys.modules\n"
    )

    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
