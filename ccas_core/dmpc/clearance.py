"""Gap between the hulls of ships along their trajectories, for many plans at once.

A hull is a rectangle along the course.  From row k to row k + 1 a ship sails straight on the course of
row k + 1, as the plant does.  The gap is that between a hull and the other's safety area, whichever
is nearer, along the axis that parts them best; it is never more than their distance, and
negative where they overlap.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ..frames import FloatArray
from ..ships import Hull

FAR: Final = 60.0  # gaps of plans that stay farther away are told by the centres alone [m]
LOOKS: Final = 5  # in a step; a ship moves by less than its beam and length between two of them


def gaps(own: Hull, plans: FloatArray, other: Hull, poses: FloatArray) -> FloatArray:
    """Least gap in each step of each plan [m], (M, N).

    Parameters
    ----------
    plans
        Trajectories of the own ship, (M, N + 1, 3), and
    poses
        that of the other ship, (N + 1, 3), in the same frame.

    Examples
    --------
    >>> hull = Hull(length=100.0, beam=10.0)
    >>> here, there = np.zeros((1, 2, 3)), np.array([[0.0, 30.0, 0.0], [0.0, 30.0, 0.0]])
    >>> gaps(hull, here, hull, there).tolist()  # 30 - 10 / 2 - 15 / 2
    [[17.5]]
    """
    reach = (own.safety_length + own.safety_beam + other.safety_length + other.safety_beam) / 2.0
    here, there = plans[:, :, :2], poses[None, :, :2]
    away = np.hypot(*np.moveaxis(there - here, 2, 0))
    way = np.hypot(*np.moveaxis(np.diff(there - here, axis=1), 2, 0))  # towards one another, in a step
    least = np.minimum(away[:, :-1], away[:, 1:]) - way / 2.0 - reach  # never more than the gap
    near = np.any(least < FAR, axis=1)
    if np.any(near):
        least[near] = _exact(own, plans[near], other, poses)
    return np.asarray(least)


def _exact(own: Hull, plans: FloatArray, other: Hull, poses: FloatArray) -> FloatArray:
    """Gaps by the axes of both hulls, at all looks."""
    here, there = _looks(plans), _looks(poses[None])
    apart = there[..., :2] - here[..., :2]
    turned = there[..., 2] - here[..., 2]
    cos, sin = np.abs(np.cos(turned)), np.abs(np.sin(turned))
    along_own, aside_own = _seen(apart, here[..., 2])
    along_other, aside_other = _seen(apart, there[..., 2])
    both = []
    for (a, b), (c, d) in (
        ((own.length, own.beam), (other.safety_length, other.safety_beam)),
        ((own.safety_length, own.safety_beam), (other.length, other.beam)),
    ):
        axes = (
            along_own - (a + c * cos + d * sin) / 2.0,
            aside_own - (b + c * sin + d * cos) / 2.0,
            along_other - (c + a * cos + b * sin) / 2.0,
            aside_other - (d + a * sin + b * cos) / 2.0,
        )
        both.append(np.maximum.reduce(axes))
    least = np.minimum(*both)
    return np.asarray(least.reshape(len(plans), -1, LOOKS).min(axis=2))


def bank_gaps(own: Hull, plans: FloatArray, room: FloatArray) -> FloatArray:
    """Least water between hull and banks in each step of each plan [m], (M, N), beyond the margin of `room`.

    `room` (N, 2) holds the offsets between which the hull, along the line, keeps its margin to the banks [m].

    >>> gap = bank_gaps(Hull(length=100.0, beam=10.0), np.array([[[0.0, 0.0, 0.0], [0.0, 12.0, 0.0]]]),
    ...                 np.array([[-20.0, 15.0]]))
    >>> gap.tolist()
    [[3.0]]
    """
    y, course = plans[:, 1:, 1], plans[:, 1:, 2]
    before = plans[:, :-1, 1]  # where the ship turns to the course of the step
    reach = (own.length * np.abs(np.sin(course)) + own.beam * (np.abs(np.cos(course)) - 1.0)) / 2.0
    low, high = np.minimum(y, before) - reach, np.maximum(y, before) + reach
    return np.asarray(np.minimum(low - room[:, 0], room[:, 1] - high))


def _looks(poses: FloatArray) -> FloatArray:
    """Poses within each step, (M, N * LOOKS, 3): on the line, at the course of the step's end."""
    share = (np.arange(1, LOOKS + 1) / LOOKS)[None, None, :, None]
    begin, end = poses[:, :-1, None, :], poses[:, 1:, None, :]
    looks = begin + share * (end - begin)
    looks[..., 2] = end[..., 2]
    return np.asarray(looks.reshape(len(poses), -1, 3))


def _seen(apart: FloatArray, course: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances along and across a course, without their signs [m]."""
    cos, sin = np.cos(course), np.sin(course)
    return (
        np.abs(cos * apart[..., 0] + sin * apart[..., 1]),
        np.abs(cos * apart[..., 1] - sin * apart[..., 0]),
    )
