"""Eq. (4) and (5), the kinematic model: what the text says of it."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest

from ccas_core.dmpc.kinematics import step
from ccas_core.dmpc.parameters import Kinematics
from ccas_core.frames import PathFrame, PathPose, frozen_array

MODEL = Kinematics()
CONSTANTS = {
    "speed": 3.0,
    "time_step": MODEL.time_step,
    "time_constant": MODEL.time_constant,
    "course_limit": MODEL.course_limit,
    "steering_gain": MODEL.steering_gain,
}
Pose = tuple[float, float, float]


def sailed(pose: Pose, offset: float, factor: float = 1.0, periods: int = 1) -> list[Pose]:
    poses = [pose]
    for _ in range(periods):
        poses.append(step(poses[-1], offset, factor, **CONSTANTS))
    return poses


def test_course_is_a_first_order_filter_of_the_line_of_sight_command() -> None:
    _, _, course = step((0.0, 5.0, 0.1), 25.0, 1.0, **CONSTANTS)

    command = math.pi / 6.0 * math.tanh(MODEL.steering_gain * (25.0 - 5.0))
    assert course == pytest.approx(0.1 + 20.0 / 28.458 * (command - 0.1), rel=1e-15)


def test_course_turns_first_and_the_position_moves_on_the_new_course() -> None:
    x, y, course = step((0.0, 0.0, 0.0), 30.0, 1.0, **CONSTANTS)

    assert course > 0.0
    assert (x, y) == pytest.approx((60.0 * math.cos(course), 60.0 * math.sin(course)), rel=1e-15)


def test_command_is_measured_from_the_offset_before_the_step() -> None:
    _, _, course = step((0.0, 30.0, 0.0), 30.0, 1.0, **CONSTANTS)

    assert course == 0.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_positive_offset_lies_to_starboard(side: float) -> None:
    _, y, course = step((0.0, 0.0, 0.0), side * 30.0, 1.0, **CONSTANTS)
    northward = PathFrame(frozen_array([[0.0, 0.0], [1000.0, 0.0]]))
    there = northward.to_ned(PathPose(0.0, y, course))

    assert side * there.y > 0.0  # starboard of a ship bound north is east
    assert side * there.course > 0.0


@pytest.mark.parametrize("offset", [-60.0, -10.0, 0.0, 35.0, 60.0])
def test_ship_settles_on_the_commanded_offset_and_on_the_course_of_its_line(offset: float) -> None:
    _, y, course = sailed((0.0, 0.0, 0.2), offset, periods=400)[-1]

    assert y == pytest.approx(offset, abs=1e-6)
    assert course == pytest.approx(0.0, abs=1e-8)


def test_ship_without_speed_stays_where_it_is_and_still_turns() -> None:
    x, y, course = step((10.0, 0.0, 0.0), 30.0, 0.0, **CONSTANTS)

    assert (x, y) == (10.0, 0.0)
    assert course > 0.0


def test_distance_sailed_in_a_period_is_that_of_the_modified_speed() -> None:
    x, y, _ = step((0.0, 0.0, 0.3), -40.0, 0.4, **CONSTANTS)

    assert math.hypot(x, y) == pytest.approx(20.0 * 0.4 * 3.0, rel=1e-15)


def test_course_never_exceeds_the_greatest_steering_angle() -> None:
    generator = np.random.default_rng(4)
    for _ in range(50):
        pose = (0.0, float(generator.uniform(-200, 200)), float(generator.uniform(-0.5, 0.5)))
        for _ in range(30):
            offset, factor = float(generator.uniform(-60, 60)), float(generator.uniform(0, 1))
            pose = step(pose, offset, factor, **CONSTANTS)

            assert abs(pose[2]) <= MODEL.course_limit


def test_symbols_give_the_same_numbers() -> None:
    arguments = ca.SX.sym("arguments", 10)
    x, y, course, offset, factor, *constants = ca.vertsplit(arguments)
    named = dict(zip(CONSTANTS, constants, strict=True))
    symbolic = ca.Function("step", [arguments], list(step((x, y, course), offset, factor, **named)))
    generator = np.random.default_rng(5)

    for _ in range(100):
        pose = tuple(map(float, generator.uniform([-1e3, -60, -0.5], [1e3, 60, 0.5])))
        control = tuple(map(float, generator.uniform([-60, 0], [60, 1])))
        values = tuple(map(float, generator.uniform([1, 5, 20, 0.2, 0.005], [6, 20, 40, 1, 0.05])))
        numeric = step(
            (pose[0], pose[1], pose[2]), control[0], control[1], **dict(zip(CONSTANTS, values, strict=True))
        )
        found = [float(value) for value in symbolic(ca.DM([*pose, *control, *values]))]

        assert found == pytest.approx(numeric, rel=1e-14, abs=1e-12)
