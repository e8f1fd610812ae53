"""The loops of `riccati`: control-limited differential dynamic programming.

These functions are the text of compiled ones: `riccati` hands them to `casadi_to_numba`, together
with the functions of a stage that they call, which are made from `model`.  They use numbers,
arrays and `math` only.  Notation: Q and V are the value of a stage with and before its control,
`_x` and `_u` their derivatives; `low` and `high` are (N, 2).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..frames import FloatArray

if TYPE_CHECKING:
    # The functions of a stage; each writes into its last arguments.
    def advance(
        state: FloatArray, control: FloatArray, constants: FloatArray, after: FloatArray, cost: FloatArray
    ) -> None: ...
    def closeness(state: FloatArray, anchor: FloatArray, constants: FloatArray, cost: FloatArray) -> None: ...
    def risk(state: FloatArray, threat: FloatArray, cost: FloatArray) -> None: ...
    def add_closeness(
        state: FloatArray, anchor: FloatArray, constants: FloatArray,
        V_x: FloatArray, V_xx: FloatArray, costate: FloatArray,
        sum_x: FloatArray, sum_xx: FloatArray, sum_costate: FloatArray,
    ) -> None: ...
    def add_risk(
        state: FloatArray, threat: FloatArray, V_x: FloatArray, V_xx: FloatArray, costate: FloatArray,
        sum_x: FloatArray, sum_xx: FloatArray, sum_costate: FloatArray,
    ) -> None: ...
    def expand(
        state: FloatArray, control: FloatArray, constants: FloatArray,
        V_x: FloatArray, V_xx: FloatArray, costate: FloatArray,
        Q_x: FloatArray, Q_u: FloatArray, Q_xx: FloatArray, Q_ux: FloatArray, Q_uu: FloatArray,
        before: FloatArray, gradient: FloatArray,
    ) -> None: ...


def sail(
    controls: FloatArray, states: FloatArray, step: FloatArray, gain: FloatArray, length: float,
    low: FloatArray, high: FloatArray, constants: FloatArray, anchors: FloatArray, threats: FloatArray,
    new_controls: FloatArray, new_states: FloatArray, scratch: FloatArray,
) -> float:
    """Sail `controls` changed by `length` steps and the feedback, within bounds; return the cost."""
    total = 0.0
    new_states[0, :] = states[0, :]
    for k in range(len(controls)):
        for i in range(2):
            value = controls[k, i] + length * step[k, i]
            for j in range(4):
                value += gain[k, i, j] * (new_states[k, j] - states[k, j])
            if value < low[k, i]:
                value = low[k, i]
            elif value > high[k, i]:
                value = high[k, i]
            new_controls[k, i] = value
        advance(new_states[k], new_controls[k], constants, new_states[k + 1], scratch)
        total += scratch[0]
        closeness(new_states[k + 1], anchors[k], constants, scratch)
        total += scratch[0]
        for n in range(len(threats)):
            risk(new_states[k + 1], threats[n, k], scratch)
            total += scratch[0]
    return total


def bounded_step(
    H: FloatArray, g: FloatArray, low: FloatArray, high: FloatArray, free: FloatArray, step: FloatArray
) -> None:
    """Minimise g'd + d'Hd/2 over a box that holds 0, H positive definite; clear `free` at its sides."""
    for i in range(2):
        if free[i] == 0.0:
            low[i] = high[i] = 0.0
    determinant = H[0, 0] * H[1, 1] - H[0, 1] * H[0, 1]
    step[0] = (H[0, 1] * g[1] - H[1, 1] * g[0]) / determinant
    step[1] = (H[0, 1] * g[0] - H[0, 0] * g[1]) / determinant
    if low[0] < step[0] < high[0] and low[1] < step[1] < high[1]:
        return
    least = math.inf
    for i in range(2):  # else the minimum lies on one of four sides
        j = 1 - i
        for side in range(2):
            fixed = high[i] if side == 1 else low[i]
            other = min(max(-(g[j] + H[0, 1] * fixed) / H[j, j], low[j]), high[j])
            value = fixed * (g[i] + 0.5 * H[i, i] * fixed + H[0, 1] * other) + other * (g[j] + 0.5 * H[j, j] * other)
            if value < least:
                least = value
                step[i], step[j] = fixed, other
    for i in range(2):
        if step[i] <= low[i] or step[i] >= high[i]:
            free[i] = 0.0


def convexify(H: FloatArray, free: FloatArray, shift: float, floor: float) -> float:
    """Turn H positive definite on its free part, and add `shift`; return its least eigenvalue before."""
    least = math.inf
    if free[0] != 0.0 and free[1] != 0.0:
        mean, half = 0.5 * (H[0, 0] + H[1, 1]), 0.5 * (H[0, 0] - H[1, 1])
        radius = math.sqrt(half * half + H[0, 1] * H[0, 1])
        least = mean - radius
        if least < floor:
            # H = mean + radius R with R a reflection; new eigenvalues, same R
            a, b = max(abs(mean + radius), floor), max(abs(least), floor)
            stretch = (a - b) / (2.0 * radius) if radius > 0.0 else 0.0
            H[0, 0] = 0.5 * (a + b) + stretch * half
            H[1, 1] = 0.5 * (a + b) - stretch * half
            H[0, 1] *= stretch
            H[1, 0] = H[0, 1]
    else:
        for i in range(2):
            if free[i] != 0.0:
                least = H[i, i]
                H[i, i] = max(abs(H[i, i]), floor)
            else:
                H[i, i] = 1.0
        H[0, 1] = H[1, 0] = 0.0
    H[0, 0] += shift
    H[1, 1] += shift
    return least


def find_step(
    controls: FloatArray, states: FloatArray, shift: float,
    low: FloatArray, high: FloatArray, constants: FloatArray, anchors: FloatArray, threats: FloatArray,
    step: FloatArray, gain: FloatArray, report: FloatArray,
) -> None:
    """Sweep back over the stages: step and feedback of each control.

    `report` receives slope and curvature of the model along the step, the greatest projected
    gradient, and the least eigenvalue of Q_uu that was met.
    """
    V_x, V_xx, costate = np.zeros(4), np.zeros((4, 4)), np.zeros(4)
    Q_x, Q_u, Q_xx, Q_ux, Q_uu = np.empty(4), np.empty(2), np.empty((4, 4)), np.empty((2, 4)), np.empty((2, 2))
    before, gradient, cost = np.empty(4), np.empty(2), np.empty(1)
    H, free, down, up = np.empty((2, 2)), np.empty(2), np.empty(2), np.empty(2)
    report[:] = 0.0
    report[3] = math.inf
    for k in range(len(controls) - 1, -1, -1):
        add_closeness(states[k + 1], anchors[k], constants, V_x, V_xx, costate, V_x, V_xx, costate)
        for n in range(len(threats)):
            risk(states[k + 1], threats[n, k], cost)
            if not cost[0] < threats[n, k, 5] * NEGLIGIBLE:
                add_risk(states[k + 1], threats[n, k], V_x, V_xx, costate, V_x, V_xx, costate)
        expand(
            states[k], controls[k], constants, V_x, V_xx, costate, Q_x, Q_u, Q_xx, Q_ux, Q_uu, before, gradient
        )
        costate[:] = before
        for i in range(2):
            down[i], up[i] = low[k, i] - controls[k, i], high[k, i] - controls[k, i]
            held = (down[i] >= 0.0 and Q_u[i] >= 0.0) or (up[i] <= 0.0 and Q_u[i] <= 0.0)
            free[i] = 0.0 if held else 1.0
            inward = min(max(-gradient[i], down[i]), up[i])
            report[2] = max(report[2], abs(inward))
            H[i, 0], H[i, 1] = Q_uu[i, 0], Q_uu[i, 1]
        report[3] = min(report[3], convexify(H, free, shift, FLOOR))
        bounded_step(H, Q_u, down, up, free, step[k])
        determinant = H[0, 0] * H[1, 1] - H[0, 1] * H[0, 1]
        for j in range(4):
            if free[0] != 0.0 and free[1] != 0.0:
                gain[k, 0, j] = (H[0, 1] * Q_ux[1, j] - H[1, 1] * Q_ux[0, j]) / determinant
                gain[k, 1, j] = (H[0, 1] * Q_ux[0, j] - H[0, 0] * Q_ux[1, j]) / determinant
            else:
                gain[k, 0, j] = -Q_ux[0, j] / H[0, 0] if free[0] != 0.0 else 0.0
                gain[k, 1, j] = -Q_ux[1, j] / H[1, 1] if free[1] != 0.0 else 0.0
        # The shifted H stands here too: the step is then that of Newton on a convex model, and descends.
        s, t = step[k, 0], step[k, 1]
        bend_s, bend_t = H[0, 0] * s + H[0, 1] * t, H[0, 1] * s + H[1, 1] * t
        report[0] += Q_u[0] * s + Q_u[1] * t
        report[1] += bend_s * s + bend_t * t
        for j in range(4):
            p, q = gain[k, 0, j], gain[k, 1, j]
            V_x[j] = Q_x[j] + p * (Q_u[0] + bend_s) + q * (Q_u[1] + bend_t) + Q_ux[0, j] * s + Q_ux[1, j] * t
            for i in range(j + 1):
                a, b = gain[k, 0, i], gain[k, 1, i]
                V_xx[i, j] = (
                    Q_xx[i, j]
                    + a * (H[0, 0] * p + H[0, 1] * q) + b * (H[0, 1] * p + H[1, 1] * q)
                    + a * Q_ux[0, j] + b * Q_ux[1, j] + Q_ux[0, i] * p + Q_ux[1, i] * q
                )
                V_xx[j, i] = V_xx[i, j]


def descend(
    start: FloatArray, guess: FloatArray, low: FloatArray, high: FloatArray,
    constants: FloatArray, anchors: FloatArray, threats: FloatArray,
    max_iterations: int, controls: FloatArray, states: FloatArray,
) -> tuple[float, int, int]:
    """Minimise from one guess; return cost, iterations and the place of the outcome in `ENDS`.

    The best plan found is left in `controls` (N, 2) and `states` (N + 1, 4) whatever the end.
    """
    horizon = len(guess)
    step, gain, report = np.zeros((horizon, 2)), np.zeros((horizon, 2, 4)), np.zeros(4)
    new_controls, new_states, scratch = np.empty((horizon, 2)), np.empty((horizon + 1, 4)), np.empty(1)
    states[:] = 0.0
    states[0, :] = start
    value = sail(
        guess, states, step, gain, 0.0, low, high, constants, anchors, threats, controls, new_states, scratch
    )
    states[:] = new_states
    if not math.isfinite(value):
        return value, 0, 2
    shift = 0.0
    for iteration in range(max_iterations):
        find_step(controls, states, shift, low, high, constants, anchors, threats, step, gain, report)
        expected = -(report[0] + 0.5 * report[1])
        if not math.isfinite(expected):
            return value, iteration, 2
        flat = expected <= DECREASE * max(1.0, abs(value)) and shift < 1.0
        if report[2] <= GRADIENT or flat:
            return value, iteration, 0
        length, accepted = 1.0, False
        for _ in range(HALVINGS):
            new_value = sail(
                controls, states, step, gain, length, low, high, constants, anchors, threats,
                new_controls, new_states, scratch,
            )
            model = -length * (report[0] + 0.5 * length * report[1])
            if value - new_value >= SUFFICIENT * model:
                accepted = True
                break
            length *= 0.5
        if accepted:
            value = new_value
            controls[:] = new_controls
            states[:] = new_states
            shift = shift * 0.1 if shift > 1e-6 and length == 1.0 else (shift if shift > 1e-6 else 0.0)
        else:
            shift = max(10.0 * shift, 1e-2)
            if shift > SHIFT_LIMIT:
                return value, iteration, 3
    return value, max_iterations, 1


def descend_all(
    start: FloatArray, guesses: FloatArray, low: FloatArray, high: FloatArray,
    constants: FloatArray, anchors: FloatArray, threats: FloatArray,
    max_iterations: int, controls: FloatArray, states: FloatArray, ends: FloatArray,
) -> None:
    """Minimise from guesses (m, N, 2); rows of `ends` are as `descend` returns them."""
    for m in range(len(guesses)):
        value, iterations, end = descend(
            start, guesses[m], low, high, constants, anchors, threats, max_iterations, controls[m], states[m]
        )
        ends[m, 0], ends[m, 1], ends[m, 2] = value, iterations, end
