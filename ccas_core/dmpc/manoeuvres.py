"""Manoeuvres at hand: plans that a navigator would think of first, sailed all at once.

To go on; to one side by so much until the others are past; slower by so much for so long; each at once, or
after going on as before for some periods.  Both together, where none of these clears: a ship that is aside
for one and has to stop for another stays aside.  They are starts of the local problem, they say whether a
ship can still get clear by itself, and one of them is sailed if the solver's answer does not clear.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from ..frames import FloatArray, frozen_array
from .local_problem import LocalProblem
from .trajectories import sailed

OFFSETS: Final = (4.0, 8.0, 12.0, 16.0, 20.0, 25.0, 30.0, 36.0, 43.0, 51.0, 60.0)  # to either side [m]
FACTORS: Final = (0.75, 0.5, 0.25, 0.0)  # of speed
PERIODS: Final = (1, 2, 3, 4, 5, 6, 8, 10, 13, 17, 22, 28, 36)  # for which a ship is slower
BOTH_FACTORS: Final = (0.5, 0.0)  # of a ship that also goes, or stays, aside
BOTH_PERIODS: Final = (1, 2, 3, 5, 8, 13, 22, 36)
DEAR: Final = 30.0  # offset that is as dear as a period lost [m]

_ASIDE: Final = frozen_array([side * size for side in (1.0, -1.0) for size in OFFSETS])
_SLOWER: Final = frozen_array(list(product(FACTORS, PERIODS)))
_BOTH: Final = frozen_array(list(product(BOTH_FACTORS, BOTH_PERIODS)))
_SIDE: Final = frozen_array([*np.sign(_ASIDE), *np.zeros(len(_SLOWER)), 0.0])
_SIZE: Final = frozen_array([*np.abs(_ASIDE), *(DEAR * (1.0 - _SLOWER[:, 0]) * _SLOWER[:, 1]), 0.0])


@dataclass(frozen=True, slots=True, eq=False)
class Manoeuvres:
    """Manoeuvres and where they lead."""

    controls: FloatArray  # (M, N, 2)
    paths: FloatArray  # (M, N + 1, 3), in the own path frame
    side: FloatArray  # (M,): +1 to starboard, -1 to port, 0 neither
    size: FloatArray  # (M,): greatest offset, or what the loss of time is worth [m]


def at_hand(problem: LocalProblem, base: float, until: int, after: int = 0) -> Manoeuvres:
    """Make the manoeuvres of a ship.

    Parameters
    ----------
    problem
        Of the ship: where it is, its limits, its model.
    base
        Offset at which it sails otherwise [m].
    until
        Periods after which it need not stay aside any more.
    after
        Periods for which it first goes on as it is.
    """
    horizon = problem.settings.horizon
    begin = min(after, horizon)
    aside = len(_ASIDE)
    controls = np.ones((len(_SIDE), horizon, 2))
    controls[:, :, 0] = base
    controls[:aside, begin : max(until, begin + 1), 0] = _ASIDE[:, None]
    controls[:, :, 0] = np.clip(controls[:, :, 0], problem.offset_limits[:, 0], problem.offset_limits[:, 1])
    stage = np.arange(horizon) - begin
    slowed = (stage >= 0) & (stage < _SLOWER[:, 1:])
    controls[aside:-1, :, 1] = np.where(slowed, _SLOWER[:, :1], 1.0)
    return Manoeuvres(controls, sailed(problem, controls), _SIDE, _SIZE)


def both_at_hand(problem: LocalProblem, until: int) -> Manoeuvres:
    """Make the manoeuvres by course and speed at once: aside, or at the present offset, and slower.

    A ship stays aside for the periods that it loses longer than `until`.
    """
    horizon = problem.settings.horizon
    offsets = np.repeat([*_ASIDE, problem.last_offset], len(_BOTH))
    slower = np.tile(_BOTH, (len(_ASIDE) + 1, 1))
    lost = (1.0 - slower[:, 0]) * slower[:, 1]
    stage = np.arange(horizon)
    controls = np.empty((len(offsets), horizon, 2))
    aside = np.where(stage < np.ceil(until + lost)[:, None], offsets[:, None], 0.0)
    controls[:, :, 0] = np.clip(aside, problem.offset_limits[:, 0], problem.offset_limits[:, 1])
    controls[:, :, 1] = np.where(stage < slower[:, 1:], slower[:, :1], 1.0)
    return Manoeuvres(controls, sailed(problem, controls), np.sign(offsets), np.abs(offsets) + DEAR * lost)


def together(one: Manoeuvres, other: Manoeuvres) -> Manoeuvres:
    """All manoeuvres of both."""
    return Manoeuvres(
        np.concatenate([one.controls, other.controls]),
        np.concatenate([one.paths, other.paths]),
        np.concatenate([one.side, other.side]),
        np.concatenate([one.size, other.size]),
    )
