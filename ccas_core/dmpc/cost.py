"""Cost of a ship's controls, Eq. (8) and Eq. (9), with the behaviour functions B_1 and B_2.

Eq. (7) adds the collision risk (`risk`) to these two; `model` does.  The sums run over the
N controls u(t) ... u(t + N - 1); the offset applied last, u^y(t - 1), is known.
"""

from __future__ import annotations

import casadi as ca

from .symbolic import Scalar


def control_effort(
    offset: Scalar, last_offset: Scalar, speed_factor: Scalar, K_y: Scalar, K_s: Scalar
) -> Scalar:
    """One term of J^e, Eq. (8): what a change of offset [m] and of speed costs.

    >>> control_effort(10.0, 0.0, 0.5, 1e-2, 2e-2)
    1.005
    """
    return K_y * (offset - last_offset) ** 2 + K_s * (1.0 - speed_factor) ** 2


def small_change_penalty(change: Scalar, width: Scalar) -> Scalar:
    """B_1(x, r) = 1 - exp(-x^2 / r): dear for small changes, no dearer for great ones.

    >>> small_change_penalty(0.0, 1.0), round(small_change_penalty(1.0, 1.0), 4)
    (0.0, 0.6321)
    """
    return 1.0 - ca.exp(-(change**2) / width)


def port_penalty(change_to_port: Scalar, r_1: Scalar, r_2: Scalar) -> Scalar:
    """B_2(x, r_1, r_2) = r_1 x [tanh(x + r_2) + 1]: grows slowly with a turn to port.

    >>> port_penalty(0.0, 1.0, 0.0), round(port_penalty(5.0, 1.0, 0.0), 3)
    (0.0, 10.0)
    """
    return r_1 * change_to_port * (ca.tanh(change_to_port + r_2) + 1.0)


def behaviour(
    offset: Scalar,
    last_offset: Scalar,
    speed_factor: Scalar,
    *,
    mu_1: Scalar,
    mu_2: Scalar,
    mu_3: Scalar,
    r_2: Scalar,
    side: Scalar,
    gamma_s: Scalar,
    gamma_y: Scalar,
) -> Scalar:
    """One term of J^b, Eq. (9): act visibly or not at all, and rather to starboard (`side` 1) than to port.

    Notes
    -----
    The print calls B_2 with two arguments of three; r_1 = mu_3, and r_2 is a parameter (0).
    Where ships are to pass starboard to starboard, `side` is -1, and B_2 makes starboard dear.
    """
    change = offset - last_offset
    return (
        mu_1 * small_change_penalty(1.0 - speed_factor, gamma_s)
        + mu_2 * small_change_penalty(change, gamma_y)
        + port_penalty(-side * change, mu_3, r_2)
    )
