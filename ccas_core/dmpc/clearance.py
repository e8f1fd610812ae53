"""Gap between the hulls of ships along their trajectories, for many plans at once.

A hull is a rectangle along the course.  From row k to row k + 1 a ship sails straight on the course of
row k + 1, as the plant does.  The gap is that between a hull and the other's safety area, whichever
is nearer, along the axis that parts them best; it is never more than their distance, and
negative where they overlap.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Final, TypeAlias

import numpy as np

from ..compiling import fast
from ..frames import FloatArray
from ..ships import Hull

FAR: Final = 60.0  # gaps of plans that stay farther away are told by the centres alone [m]
LOOKS: Final = 5  # in a step; a ship moves by less than its beam and length between two of them

Sizes: TypeAlias = tuple[float, float, float, float]  # of a hull and of its safety area: length, beam [m]


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
    least = np.empty((len(plans), plans.shape[1] - 1))
    _loop()(_sizes(own), plans, _sizes(other), poses, least)
    return least


def find_gaps(own: Sizes, plans: FloatArray, other: Sizes, poses: FloatArray, least: FloatArray) -> None:
    """Write the gaps of all plans into `least`; those that cannot be a plan's least, as bounds.

    One of two axes at right angles sees at least a distance over sqrt(2).  Where even that leaves a greater
    gap than there is in the step in which the centres are nearest, a step need not be looked at.
    """
    reach = (own[2] + own[3] + other[2] + other[3]) / 2.0
    for m in range(least.shape[0]):
        plan = plans[m]
        nearest, bound = 0, math.inf
        x, y = poses[0, 0] - plan[0, 0], poses[0, 1] - plan[0, 1]
        away = math.hypot(x, y)
        for k in range(least.shape[1]):
            new_x, new_y = poses[k + 1, 0] - plan[k + 1, 0], poses[k + 1, 1] - plan[k + 1, 1]
            new_away = math.hypot(new_x, new_y)
            way = math.hypot(new_x - x, new_y - y)  # towards one another
            least[m, k] = min(away, new_away) - way / 2.0 - reach
            if least[m, k] < bound:
                nearest, bound = k, least[m, k]
            x, y, away = new_x, new_y, new_away
        if bound < FAR:
            worth = max(FAR, gap_in_step(own, plan, other, poses, nearest))
            worth = math.sqrt(2.0) * (worth + reach) - reach
            for k in range(least.shape[1]):
                if least[m, k] <= worth:
                    least[m, k] = gap_in_step(own, plan, other, poses, k)


def gap_in_step(own: Sizes, plan: FloatArray, other: Sizes, poses: FloatArray, k: int) -> float:
    """Gap between two ships in step k, by the axes of both, at all looks."""
    course, other_course = plan[k + 1, 2], poses[k + 1, 2]
    cos, sin = abs(math.cos(other_course - course)), abs(math.sin(other_course - course))
    own_cos, own_sin = math.cos(course), math.sin(course)
    other_cos, other_sin = math.cos(other_course), math.sin(other_course)
    least = math.inf
    for look in range(1, LOOKS + 1):
        share = look / LOOKS
        x = poses[k, 0] + share * (poses[k + 1, 0] - poses[k, 0])
        x -= plan[k, 0] + share * (plan[k + 1, 0] - plan[k, 0])
        y = poses[k, 1] + share * (poses[k + 1, 1] - poses[k, 1])
        y -= plan[k, 1] + share * (plan[k + 1, 1] - plan[k, 1])
        along, aside = abs(own_cos * x + own_sin * y), abs(own_cos * y - own_sin * x)
        other_along, other_aside = abs(other_cos * x + other_sin * y), abs(other_cos * y - other_sin * x)
        for area in (0, 2):  # the own hull and the other's safety area, then the other way round
            a, b, c, d = own[area], own[area + 1], other[2 - area], other[3 - area]
            gap = max(along - (a + c * cos + d * sin) / 2.0, aside - (b + c * sin + d * cos) / 2.0)
            gap = max(gap, other_along - (c + a * cos + b * sin) / 2.0)
            gap = max(gap, other_aside - (d + a * sin + b * cos) / 2.0)
            if not gap >= least:  # nor does one that is not a number go unseen
                least = gap
    return least


def _sizes(hull: Hull) -> Sizes:
    return hull.length, hull.beam, hull.safety_length, hull.safety_beam


@cache
def _loop() -> Callable[[Sizes, FloatArray, Sizes, FloatArray, FloatArray], None]:
    return fast(gap_in_step, find_gaps, FAR=FAR, LOOKS=LOOKS)[1]


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
