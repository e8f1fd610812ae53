"""The loops of `riccati`: control-limited differential dynamic programming.

These functions are the text of compiled ones: `riccati` hands them to `compiling`, together
with the functions of a stage that they call, which are made from `model`.  They use numbers,
arrays and `math` only.  Notation: Q and V are the cost to go of a stage with and before its control,
`_x` and `_u` their derivatives; H is Q_uu as it is used.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..frames import FloatArray

IntArray: TypeAlias = NDArray[np.int64]

# How a descent ends; the other numbers of `NUMBERS` are tolerances.
CONVERGED: Final = 0
LIMIT: Final = 1
NOT_FINITE: Final = 2
STALLED: Final = 3

ITERATIONS: Final = 300  # of a descent
CUT: Final = 0.25  # of a step that does not descend
CUTS: Final = 6  # of a step, before the model is shifted
SUFFICIENT: Final = 1e-4  # part of the promised decrease that a step must give
GRADIENT: Final = 1e-9  # of a solution, projected
ROUGH_GRADIENT: Final = 1e-5  # the same, where rounding lets no step descend any more
DECREASE: Final = 1e-13  # of the objective, relative, for which another step is not worth while
ROUGH_DECREASE: Final = 1e-3  # the same, of the widened problem
BETTER: Final = 1e-9  # relative difference above which two objectives differ
FLOOR: Final = 1e-6  # least eigenvalue of Q_uu
SMALL_SHIFT: Final = 1e-2  # of Q_uu
GREATEST_SHIFT: Final = 1e12
SADDLE: Final = 1e-6  # eigenvalue of Q_uu below which an answer is not a minimum
NUDGE: Final = 1e-2  # by which a saddle is left: to starboard [m], and slower
NEGLIGIBLE: Final = 1e-26  # of its gain: a risk without derivatives, exp(-60)


class Task(NamedTuple):
    """A local problem as arrays, always of the same kinds, so that one compilation serves all."""

    start: FloatArray  # (4,)
    low: FloatArray  # of the controls, (N, 2)
    high: FloatArray  # (N, 2)
    constants: FloatArray
    anchors: FloatArray  # z and p~ of the stages 1 ... N, (N, 6)
    threats: FloatArray  # (n, N, 6)


class Batch(NamedTuple):
    """Local problems of one horizon as arrays, B of them.

    What comes in different numbers lies one after the other: problem b has rows `first[b]` to `first[b + 1]`.
    """

    start: FloatArray  # (B, 4)
    low: FloatArray  # (B, N, 2)
    high: FloatArray  # (B, N, 2)
    constants: FloatArray  # (B, 14)
    widening: FloatArray  # factors of the constants in the widened problem, (14,)
    anchors: FloatArray  # (B, N, 6)
    threats: FloatArray  # of all problems, (n, N, 6)
    first_threat: IntArray  # (B + 1,)
    guesses: FloatArray  # (m, N, 2)
    first_guess: IntArray  # (B + 1,)
    first_answer: IntArray  # (B + 1,)


if TYPE_CHECKING:
    # The functions of a stage; each writes into its last arguments.
    def advance(state: FloatArray, control: FloatArray, constants: FloatArray, *out: FloatArray) -> None:
        """Write the next state, and the cost of the control."""

    def closeness(state: FloatArray, anchor: FloatArray, constants: FloatArray, cost: FloatArray) -> None:
        """Write <z, p - p~> + beta/2 |p - p~|^2."""

    def risk(state: FloatArray, threat: FloatArray, cost: FloatArray) -> None:
        """Write the risk of one threat."""

    def add_closeness(
        state: FloatArray, anchor: FloatArray, constants: FloatArray, *to_go: FloatArray
    ) -> None:
        """Write V_x, V_xx and costate, which come first, with the derivatives of `closeness` added."""

    def add_risk(state: FloatArray, threat: FloatArray, *to_go: FloatArray) -> None:
        """Write V_x, V_xx and costate, which come first, with the derivatives of `risk` added."""

    def expand(state: FloatArray, control: FloatArray, constants: FloatArray, *to_go: FloatArray) -> None:
        """From V_x, V_xx, costate: write Q_x, Q_u, Q_xx, Q_ux, Q_uu, costate before, gradient."""


def sail(
    task: Task,
    controls: FloatArray,
    states: FloatArray,
    step: FloatArray,
    gain: FloatArray,
    length: float,
    new_controls: FloatArray,
    new_states: FloatArray,
    scratch: FloatArray,
) -> float:
    """Sail `controls` changed by `length` steps and the feedback, within bounds; return the cost."""
    total = 0.0
    for j in range(4):
        new_states[0, j] = states[0, j]
    for k in range(len(controls)):
        for i in range(2):
            value = controls[k, i] + length * step[k, i]
            for j in range(4):
                value += gain[k, i, j] * (new_states[k, j] - states[k, j])
            if value < task.low[k, i]:
                value = task.low[k, i]
            elif value > task.high[k, i]:
                value = task.high[k, i]
            new_controls[k, i] = value
        advance(new_states[k], new_controls[k], task.constants, new_states[k + 1], scratch)
        total += scratch[0]
        closeness(new_states[k + 1], task.anchors[k], task.constants, scratch)
        total += scratch[0]
        for n in range(len(task.threats)):
            risk(new_states[k + 1], task.threats[n, k], scratch)
            total += scratch[0]
    return total


def convexify(a: float, b: float, c: float, free: tuple[bool, bool]) -> tuple[float, float, float, float]:
    """Make H = [[a, b], [b, c]] positive definite where it is free; its least eigenvalue comes last.

    An eigenvalue below zero changes its sign, so that the step leaves a saddle at Newton's pace.
    """
    if free[0] and free[1]:
        mean, half = 0.5 * (a + c), 0.5 * (a - c)
        radius = math.sqrt(half * half + b * b)
        least = mean - radius
        if least < FLOOR:
            great, small = max(abs(mean + radius), FLOOR), max(abs(least), FLOOR)
            stretch = 0.5 * (great - small) / radius if radius > 0.0 else 0.0
            centre = 0.5 * (great + small)
            a, b, c = centre + stretch * half, stretch * b, centre - stretch * half
        return a, b, c, least
    if free[0]:
        return max(abs(a), FLOOR), 0.0, 1.0, a
    if free[1]:
        return 1.0, 0.0, max(abs(c), FLOOR), c
    return 1.0, 0.0, 1.0, math.inf


def bounded_step(
    a: float, b: float, c: float, g: float, h: float, box: tuple[float, float, float, float]
) -> tuple[float, float]:
    """Minimise g s + h t + (a s^2 + 2 b s t + c t^2) / 2 over a box, low and high of s, then of t."""
    low_s, high_s, low_t, high_t = box
    determinant = a * c - b * b
    s, t = (b * h - c * g) / determinant, (b * g - a * h) / determinant
    if low_s < s < high_s and low_t < t < high_t:
        return s, t
    least = math.inf
    for side in range(4):  # else the minimum lies on one of four sides
        if side < 2:
            p = low_s if side == 0 else high_s
            q = min(max(-(h + b * p) / c, low_t), high_t)
        else:
            q = low_t if side == 2 else high_t
            p = min(max(-(g + b * q) / a, low_s), high_s)
        value = g * p + h * q + 0.5 * (a * p * p + c * q * q) + b * p * q
        if value < least:
            least, s, t = value, p, q
    return s, t


def find_step(
    task: Task,
    controls: FloatArray,
    states: FloatArray,
    shift: float,
    step: FloatArray,
    gain: FloatArray,
    report: FloatArray,
) -> None:
    """Sweep back over the stages: step and feedback of each control.

    `report` receives slope and curvature of the model along the step, the greatest projected
    gradient, and the least eigenvalue of Q_uu that was met.
    """
    V_x, V_xx, costate = np.zeros(4), np.zeros((4, 4)), np.zeros(4)
    Q_x, Q_u, before, gradient, cost = np.empty(4), np.empty(2), np.empty(4), np.empty(2), np.empty(1)
    Q_xx, Q_ux, Q_uu = np.empty((4, 4)), np.empty((2, 4)), np.empty((2, 2))
    slope, curvature, steepest, lowest = 0.0, 0.0, 0.0, math.inf
    for k in range(len(controls) - 1, -1, -1):
        state, after = states[k], states[k + 1]
        add_closeness(after, task.anchors[k], task.constants, V_x, V_xx, costate, V_x, V_xx, costate)
        for n in range(len(task.threats)):
            risk(after, task.threats[n, k], cost)
            if not cost[0] < task.threats[n, k, 5] * NEGLIGIBLE:
                add_risk(after, task.threats[n, k], V_x, V_xx, costate, V_x, V_xx, costate)
        expand(
            state, controls[k], task.constants, V_x, V_xx, costate,
            Q_x, Q_u, Q_xx, Q_ux, Q_uu, before, gradient,
        )  # fmt: skip
        g, h = Q_u[0], Q_u[1]
        low_s, high_s = task.low[k, 0] - controls[k, 0], task.high[k, 0] - controls[k, 0]
        low_t, high_t = task.low[k, 1] - controls[k, 1], task.high[k, 1] - controls[k, 1]
        steepest = max(steepest, abs(min(max(-gradient[0], low_s), high_s)))
        steepest = max(steepest, abs(min(max(-gradient[1], low_t), high_t)))

        # A control whose bound holds it back takes no part.
        free_s = not ((low_s >= 0.0 and g >= 0.0) or (high_s <= 0.0 and g <= 0.0))
        free_t = not ((low_t >= 0.0 and h >= 0.0) or (high_t <= 0.0 and h <= 0.0))
        a, b, c, least = convexify(Q_uu[0, 0], Q_uu[0, 1], Q_uu[1, 1], (free_s, free_t))
        a, c = a + shift, c + shift
        lowest = min(lowest, least)
        if not free_s:
            low_s = high_s = 0.0
        if not free_t:
            low_t = high_t = 0.0
        s, t = bounded_step(a, b, c, g, h, (low_s, high_s, low_t, high_t))
        step[k, 0], step[k, 1] = s, t
        slope += g * s + h * t
        curvature += a * s * s + 2.0 * b * s * t + c * t * t

        # Feedback is left to controls that do not end at a bound.  With the same H in step, feedback
        # and V, all steps together are Newton's on a convex model: they descend.
        free_s, free_t = low_s < s < high_s, low_t < t < high_t
        if free_s and free_t:
            determinant = a * c - b * b
            a, b, c = -c / determinant, b / determinant, -a / determinant
        else:
            a, b, c = -1.0 / a if free_s else 0.0, 0.0, -1.0 / c if free_t else 0.0
        for j in range(4):
            gain[k, 0, j] = a * Q_ux[0, j] + b * Q_ux[1, j]
            gain[k, 1, j] = b * Q_ux[0, j] + c * Q_ux[1, j]
        for j in range(4):
            costate[j] = before[j]
            V_x[j] = Q_x[j] + Q_ux[0, j] * s + Q_ux[1, j] * t
            for i in range(j + 1):  # `expand` reads the upper half only
                V_xx[i, j] = Q_xx[i, j] + Q_ux[0, i] * gain[k, 0, j] + Q_ux[1, i] * gain[k, 1, j]
    report[0], report[1], report[2], report[3] = slope, curvature, steepest, lowest


def copy(source: FloatArray, target: FloatArray) -> None:
    """Copy a table; quicker to compile than an assignment of slices."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]


def settle(
    task: Task,
    guess: FloatArray,
    decrease: float,
    controls: FloatArray,
    states: FloatArray,
    report: FloatArray,
) -> tuple[float, int, int]:
    """Minimise from one guess; return cost, iterations and the place of the outcome among the ends.

    The best plan found is left in `controls` (N, 2) and `states` (N + 1, 4), whatever the end;
    `report` is that of the last `find_step`.
    """
    horizon = len(guess)
    step, gain = np.zeros((horizon, 2)), np.zeros((horizon, 2, 4))
    new_controls, new_states, scratch = np.empty((horizon, 2)), np.empty((horizon + 1, 4)), np.empty(1)
    for k in range(horizon + 1):
        for j in range(4):
            states[k, j] = task.start[j]  # any number will do after the first: the gains are still zero
    value = sail(task, guess, states, step, gain, 0.0, controls, new_states, scratch)
    copy(new_states, states)
    if not math.isfinite(value):
        return value, 0, NOT_FINITE
    shift = 0.0
    for iteration in range(ITERATIONS):
        find_step(task, controls, states, shift, step, gain, report)
        promised = -(report[0] + 0.5 * report[1])
        if not math.isfinite(promised):
            return value, iteration, NOT_FINITE
        flat = promised <= decrease * max(1.0, abs(value)) and shift <= SMALL_SHIFT
        if report[2] <= GRADIENT or flat:
            return value, iteration, CONVERGED
        length = 1.0
        for _ in range(CUTS):
            new_value = sail(task, controls, states, step, gain, length, new_controls, new_states, scratch)
            if value - new_value >= -SUFFICIENT * length * (report[0] + 0.5 * length * report[1]):
                break
            length *= CUT
        else:  # no such step descends; in the end it is so short that rounding decides
            shift = max(10.0 * shift, SMALL_SHIFT)
            if shift > GREATEST_SHIFT:
                return value, iteration, CONVERGED if report[2] <= ROUGH_GRADIENT else STALLED
            continue
        value = new_value
        copy(new_controls, controls)
        copy(new_states, states)
        if length == 1.0:
            shift = 0.1 * shift if shift > SMALL_SHIFT else 0.0
    return value, ITERATIONS, LIMIT


def descend(
    task: Task,
    guess: FloatArray,
    decrease: float,
    controls: FloatArray,
    states: FloatArray,
) -> tuple[float, int, int]:
    """As `settle`; and where that ends on a saddle, as between two equal ways to pass, leave it."""
    report = np.zeros(4)
    trial, new_controls, new_states = np.empty_like(controls), np.empty_like(controls), np.empty_like(states)
    copy(guess, trial)
    value, iterations, end = math.inf, 0, STALLED
    for attempt in range(2):  # a loop, for one place of the call is quicker to compile than two
        new_value, more, new_end = settle(task, trial, decrease, new_controls, new_states, report)
        iterations += more
        better = new_end == CONVERGED and new_value < value - BETTER * max(1.0, abs(value))
        if attempt == 0 or better:
            value, end = new_value, new_end
            copy(new_controls, controls)
            copy(new_states, states)
        if end != CONVERGED or report[3] >= -SADDLE:
            break
        for k in range(len(trial)):
            trial[k, 0], trial[k, 1] = controls[k, 0] + NUDGE, controls[k, 1] - NUDGE
    return value, iterations, end


def descend_all(
    task: Task,
    widened: Task,
    guesses: FloatArray,
    controls: FloatArray,
    states: FloatArray,
    ends: FloatArray,
) -> None:
    """Minimise from guesses (m, N, 2); a row of `ends` is what `descend` returns.

    Where there is room for one more answer, it is found from the first guess by way of the `widened`
    problem.
    """
    count = len(guesses)
    near = np.empty_like(guesses[0])
    for m in range(len(ends)):
        guess, iterations = guesses[m % count], 0
        for leg in range(0 if m >= count else 1, 2):
            value, more, end = descend(
                task if leg == 1 else widened,
                guess,
                DECREASE if leg == 1 else ROUGH_DECREASE,
                controls[m],
                states[m],
            )
            iterations += more
            if leg == 0:
                copy(controls[m], near)
                guess = near
        ends[m, 0], ends[m, 1], ends[m, 2] = value, iterations, end


def descend_batch(
    batch: Batch, begin: int, end: int, controls: FloatArray, states: FloatArray, ends: FloatArray
) -> None:
    """Minimise the problems from `begin` until before `end`, each as `descend_all` does."""
    for b in range(begin, end):
        threats = batch.threats[batch.first_threat[b] : batch.first_threat[b + 1]]
        parts = batch.start[b], batch.low[b], batch.high[b]
        task = Task(*parts, batch.constants[b], batch.anchors[b], threats)
        widened = Task(*parts, batch.constants[b] * batch.widening, batch.anchors[b], threats)
        first, last = batch.first_answer[b], batch.first_answer[b + 1]
        descend_all(
            task,
            widened,
            batch.guesses[batch.first_guess[b] : batch.first_guess[b + 1]],
            controls[first:last],
            states[first:last],
            ends[first:last],
        )
