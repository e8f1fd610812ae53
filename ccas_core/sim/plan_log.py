"""Plans of ships as a run folder keeps them: `plans.jsonl`, a line a period, each plan with few points.

A plan is thinned: between two of its points a ship sails straight and at one speed, to within `TOLERANCE`.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from ..frames import FloatArray
from .frame import Frame, ShipFrame
from .hulls import under_way

TOLERANCE: Final = 0.5  # greatest distance from where the plan has the ship at any step [m]
_DIGITS: Final = 1  # decimals of a position [m] and of a time [s]


def plans(frame: Frame, time_step: float) -> dict[str, object]:
    """Tell the plans of a frame as a line of `plans.jsonl`.

    `why` says why a command is not the solver's, `saw` what was wrong with reports of ships that do not
    cooperate.

    Parameters
    ----------
    frame
        In which ships have decided.
    time_step
        From one row of a plan to the next [s].
    """
    return {
        "time_s": frame.time,
        "ships": {id_: _plan(ship, time_step) for id_, ship in sorted(under_way(frame).items())},
    }


def _plan(ship: ShipFrame, time_step: float) -> dict[str, object]:
    kept = thinned(ship.plan.poses[:, :2])
    told: dict[str, object] = {
        "after_s": [_rounded(step * time_step) for step in kept],
        "east_m": [_rounded(ship.plan.poses[step, 1]) for step in kept],
        "north_m": [_rounded(ship.plan.poses[step, 0]) for step in kept],
    }
    more = {"why": ship.fallback, "saw": list(ship.saw)}
    return {**told, **{key: said for key, said in more.items() if said}}


def _rounded(value: float) -> float:
    return round(float(value), _DIGITS) + 0.0


def thinned(points: FloatArray, tolerance: float = TOLERANCE) -> list[int]:
    """Rows of points (K, 2) that are enough: a straight way between them is near enough, in time, too.

    >>> thinned(np.array([[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [20.0, 0.0]]))
    [0, 2, 3]
    """
    kept, stretches = {0, len(points) - 1}, [(0, len(points) - 1)]
    while stretches:
        first, last = stretches.pop()
        if last - first < 2:
            continue
        share = np.arange(1, last - first)[:, None] / (last - first)
        straight = points[first] + share * (points[last] - points[first])
        off = np.hypot(*(points[first + 1 : last] - straight).T)
        worst = int(np.argmax(off))
        if off[worst] > tolerance:
            middle = first + 1 + worst
            kept.add(middle)
            stretches += [(first, middle), (middle, last)]
    return sorted(kept)
