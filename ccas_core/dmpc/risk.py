"""Collision risk of one ship towards another, Eq. (6)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import casadi as ca
import numpy as np

from ..frames import FloatArray, PathTrajectory
from ..ships import Hull
from .parameters import Risk, RiskShape, Settings, Weights
from .symbolic import Scalar

SWEPT = 10.0  # greatest speed of two ships towards one another that `cut_off` counts with [m/s]
COLUMNS = 6  # of a threat: x, y [m], q_xx, q_xy, q_yy [1/m^2], gain


def collision_risk(dx: Scalar, dy: Scalar, q_xx: Scalar, q_xy: Scalar, q_yy: Scalar, gain: Scalar) -> Scalar:
    """Risk of being `dx`, `dy` [m] from another ship: gain * exp(-d' Q d).

    Eq. (6) has Q = diag(1/alpha_x, 1/alpha_y), and gain = K_ca / sqrt(1 + K_d k).

    Examples
    --------
    >>> collision_risk(0.0, 0.0, 1e-4, 0.0, 1e-2, 900.0)
    900.0
    >>> round(collision_risk(100.0, 0.0, 1e-4, 0.0, 1e-2, 900.0), 3)   # 900 / e
    331.091
    """
    return gain * ca.exp(-(q_xx * dx * dx + 2.0 * q_xy * dx * dy + q_yy * dy * dy))


def threat(
    own: Hull, other: Hull, trajectory: PathTrajectory, risk: Risk, weights: Weights, own_step: float = 0.0
) -> FloatArray:
    """Another ship, or an obstacle, as the local problem sees it: (N, 6), rows k = 1 ... N.

    `trajectory` is the other's, in the *own* path frame.  The columns are those of `COLUMNS`.
    `own_step` is the way that the own ship makes in a step [m]; only `RiskShape.FITTED` asks for it.

    Notes
    -----
    As printed (`RiskShape.AXIS_BOUND`), alpha lies along the own ship's axes whatever the other's
    course, so that a crossing ship of 103 m is felt as thin as its beam.  By default the ellipse lies
    along the other's course, and its semi-axes are kappa times the half-extents of both hulls there:
    the text ties alpha to the other's "size, shape, and current speed".  `RiskShape.FITTED` goes on: the
    ellipse is drawn around both hulls as they lie, and around the way that they make towards one another
    in a step, so that small or fast ships do not slip through between two samples.
    """
    rows: FloatArray = threats(own, [other], trajectory.poses[None], risk, weights, own_step)[0]
    return rows


def threats(
    own: Hull,
    others: Sequence[Hull],
    poses: FloatArray,
    risk: Risk,
    weights: Weights,
    own_step: float = 0.0,
) -> FloatArray:
    """Several ships at once, as `threat`: their `poses` are (n, N + 1, 3), the rows (n, N, 6)."""
    rows = np.empty((len(others), poses.shape[1] - 1, COLUMNS))
    if not len(others):
        return rows
    rows[:, :, :2] = poses[:, 1:, :2]
    if risk.shape is RiskShape.AXIS_BOUND:
        rows[:, :, 2:5] = 1.0 / risk.alpha_x, 0.0, 1.0 / risk.alpha_y
    elif risk.shape is RiskShape.FITTED:
        for column, form in enumerate(_fitted(own, others, poses, risk, own_step)):
            rows[:, :, 2 + column] = form
    else:
        sizes = [(each.safety_length / 2.0, each.safety_beam / 2.0) for each in others]
        for column, form in enumerate(_course_aligned(own, np.array(sizes), poses[:, 1:, 2], risk)):
            rows[:, :, 2 + column] = form
    steps = np.arange(1, rows.shape[1] + 1)
    rows[:, :, 5] = weights.K_ca / np.sqrt(1.0 + weights.K_d * steps)
    return rows


def cut_off(own: Hull, other: Hull, settings: Settings, tolerance: float) -> float:
    """Distance [m] beyond which the risk of another ship, summed over a whole horizon, is below `tolerance`.

    No ellipse has a semi-axis longer than a, so that a step at a distance of d or more has a risk of
    at most K_ca exp(-(d/a)^2), and N steps N times that; d is where this is the tolerance.

    Examples
    --------
    >>> hull = Hull(length=103.0, beam=11.45)
    >>> round(cut_off(hull, hull, Settings(), 1e-6))
    413
    """
    risk = settings.risk
    if risk.shape is RiskShape.AXIS_BOUND:
        longest = math.sqrt(max(risk.alpha_x, risk.alpha_y))
    elif risk.shape is RiskShape.FITTED:
        swept = SWEPT * settings.kinematics.time_step / 2.0
        longest = swept + sum(
            math.hypot(risk.kappa_along * length, risk.kappa_across * beam) / 2.0
            for length, beam in ((own.length, own.beam), (other.safety_length, other.safety_beam))
        )
    else:
        diagonal = math.hypot(own.length, own.beam) / 2.0
        longest = max(
            risk.kappa_along * (other.safety_length / 2.0 + diagonal),
            risk.kappa_across * (other.safety_beam / 2.0 + diagonal),
        )
    height = settings.weights.K_ca * settings.horizon
    return longest * math.sqrt(max(0.0, math.log(height / tolerance))) if height > 0.0 else 0.0


def _course_aligned(
    own: Hull, sizes: FloatArray, course: FloatArray, risk: Risk
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Quadratic forms of ellipses along the others' courses (n, N); the own hull lies along the own line.

    `sizes` are half the length and beam of the others' safety areas, (n, 2) [m].
    """
    cos, sin = np.cos(course), np.sin(course)
    half_length, half_beam = own.length / 2.0, own.beam / 2.0
    along = sizes[:, :1] + np.hypot(half_length * cos, half_beam * sin)
    across = sizes[:, 1:] + np.hypot(half_length * sin, half_beam * cos)
    a = 1.0 / (risk.kappa_along * along) ** 2
    b = 1.0 / (risk.kappa_across * across) ** 2
    return a * cos**2 + b * sin**2, (a - b) * sin * cos, a * sin**2 + b * cos**2


def _fitted(
    own: Hull, others: Sequence[Hull], poses: FloatArray, risk: Risk, own_step: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Quadratic forms (n, N) of ellipses around both hulls and half a step of relative motion.

    Ellipses with the half-extents of either hull, and the segment of the motion, are added (as sets) in an
    ellipse around their sum: its matrix is tr_s * sum of M_i / tr_i, with tr_i the root of the trace of M_i
    and tr_s the sum of these (the least trace of all such ellipses).
    """
    half = np.array([(each.safety_length / 2.0, each.safety_beam / 2.0) for each in others])
    scale = np.array([risk.kappa_along, risk.kappa_across])
    a, b = ((half * scale) ** 2).T[:, :, None]  # squares of the other's semi-axes, (n, 1)
    c, d = ((np.array([own.length, own.beam]) / 2.0 * scale) ** 2).tolist()
    cos, sin = np.cos(poses[:, 1:, 2]), np.sin(poses[:, 1:, 2])
    north = np.diff(poses[:, :, 0], axis=1) - own_step
    east = np.diff(poses[:, :, 1], axis=1)
    parts = (
        (c, 0.0, d),
        (a * cos**2 + b * sin**2, (a - b) * sin * cos, a * sin**2 + b * cos**2),
        (north**2 / 4.0, north * east / 4.0, east**2 / 4.0),
    )
    roots = [np.sqrt(xx + yy) for xx, _, yy in parts]
    total = roots[0] + roots[1] + roots[2]
    shares = [total / np.where(root > 0.0, root, 1.0) for root in roots]
    xx, xy, yy = (sum(share * part[n] for share, part in zip(shares, parts, strict=True)) for n in range(3))
    determinant = xx * yy - xy * xy
    return yy / determinant, -xy / determinant, xx / determinant
