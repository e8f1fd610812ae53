"""Nonlinear ADMM, Eq. (1) and (2), in the form that Appendix A gives it: Eq. (13) and (A.3).

The global problem has g = 0 and B = -I, so that the last line of (2) has a closed form, (13d).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..frames import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Iterate:
    """What a ship carries from one update to the next; all (N + 1, 3), in its path frame."""

    local: FloatArray  # p, the trajectory it plans
    broadcast: FloatArray  # p~, the trajectory it tells
    multiplier: FloatArray  # z

    @property
    def residual(self) -> float:
        """Greatest distance between the planned and the told positions [m]; it is to vanish."""
        gap = self.local[:, :2] - self.broadcast[:, :2]
        return float(np.max(np.hypot(gap[:, 0], gap[:, 1])))


def start(trajectory: FloatArray) -> Iterate:
    """Begin a period: plan and promise are the same trajectory, and z is zero."""
    return Iterate(local=trajectory, broadcast=trajectory, multiplier=np.zeros_like(trajectory))


def half_step(iterate: Iterate, beta: float, relaxation: float) -> FloatArray:
    """Multiplier z^{s+1/2} with which the local problem is to be solved, (13a)."""
    return iterate.multiplier - beta * (1.0 - relaxation) * (iterate.local - iterate.broadcast)  # (13a)


def full_step(iterate: Iterate, half: FloatArray, solution: FloatArray, beta: float) -> Iterate:
    """Take the solution of (13b), and say what to broadcast, (13c) and (13d)."""
    multiplier = half + beta * (solution - iterate.broadcast)  # (13c)
    broadcast = solution + multiplier / beta  # (13d), with the new local trajectory (A.3)
    return Iterate(local=solution, broadcast=broadcast, multiplier=multiplier)


def update(
    iterate: Iterate,
    minimise: Callable[[FloatArray, FloatArray], FloatArray],
    *,
    beta: float,
    relaxation: float,
) -> Iterate:
    """One update of Eq. (13).

    Parameters
    ----------
    minimise
        Given z^{s+1/2} and the broadcast trajectory, the minimiser of (13b).
    beta, relaxation
        Penalty beta > 0, and lambda in (0, 2) (Theorem 1).

    Examples
    --------
    A quadratic cost (p - 1)^2 is its own consensus, and z goes to zero:

    >>> beta = 3.0
    >>> def minimise(z, told):
    ...     return (2.0 * 1.0 - z + beta * told) / (2.0 + beta)
    >>> iterate = start(np.zeros((1, 3)))
    >>> for _ in range(60):
    ...     iterate = update(iterate, minimise, beta=beta, relaxation=1.0)
    >>> round(float(iterate.local[0, 0]), 6), round(iterate.residual, 6)
    (1.0, 0.0)
    """
    half = half_step(iterate, beta, relaxation)
    return full_step(iterate, half, minimise(half, iterate.broadcast), beta)
