"""Kinematic model of a ship along its guiding line, Eq. (4) and Eq. (5)."""

from __future__ import annotations

import casadi as ca

from .symbolic import Scalar


def step(
    pose: tuple[Scalar, Scalar, Scalar],
    offset: Scalar,
    speed_factor: Scalar,
    *,
    speed: Scalar,
    time_step: Scalar,
    time_constant: Scalar,
    course_limit: Scalar,
    steering_gain: Scalar,
) -> tuple[Scalar, Scalar, Scalar]:
    """Sail one period: f_i(p(k - 1), u(k)) of Eq. (5).

    The course follows the line-of-sight command first; the position then moves on the *new*
    course, as Eq. (4) prints it.

    Parameters
    ----------
    pose
        x, y [m] and course [rad] in the path frame {w_i}.
    offset
        Cross-track offset u^y [m].
    speed_factor
        Speed modification u^s, 0 to 1.
    speed, time_step, time_constant, course_limit, steering_gain
        U^d [m/s], delta T [s], T_1 [s], chi_max [rad], K_e [1/m].

    Examples
    --------
    >>> x, y, course = step((0.0, 0.0, 0.0), 0.0, 1.0, speed=3.0, time_step=20.0,
    ...                     time_constant=28.458, course_limit=0.5236, steering_gain=0.0092)
    >>> x, y, course
    (60.0, 0.0, 0.0)
    """
    x, y, course = pose
    command = course_limit * ca.tanh(steering_gain * (offset - y))
    turned = course + time_step / time_constant * (command - course)
    sailed = time_step * speed_factor * speed
    return x + sailed * ca.cos(turned), y + sailed * ca.sin(turned), turned
