"""Collision risk of one ship towards another, Eq. (6)."""

from __future__ import annotations

import casadi as ca
import numpy as np

from ..frames import FloatArray, PathTrajectory
from ..ships import Hull
from .parameters import Risk, RiskShape, Weights
from .symbolic import Scalar

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
    poses = trajectory.poses[1:]
    steps = np.arange(1, len(poses) + 1)
    gain = weights.K_ca / np.sqrt(1.0 + weights.K_d * steps)
    if risk.shape is RiskShape.AXIS_BOUND:
        ones = np.ones(len(poses))
        form: tuple[FloatArray, ...] = (ones / risk.alpha_x, 0.0 * ones, ones / risk.alpha_y)
    elif risk.shape is RiskShape.FITTED:
        form = _fitted(own, other, trajectory.poses, risk, own_step)
    else:
        form = _course_aligned(own, other, poses[:, 2], risk)
    return np.column_stack([poses[:, 0], poses[:, 1], *form, gain])


def _course_aligned(own: Hull, other: Hull, course: FloatArray, risk: Risk) -> tuple[FloatArray, ...]:
    """Quadratic form of an ellipse along the other's course; the own hull lies along the own line."""
    cos, sin = np.cos(course), np.sin(course)
    half_length, half_beam = own.length / 2.0, own.beam / 2.0
    along = other.safety_length / 2.0 + np.hypot(half_length * cos, half_beam * sin)
    across = other.safety_beam / 2.0 + np.hypot(half_length * sin, half_beam * cos)
    a = 1.0 / (risk.kappa_along * along) ** 2
    b = 1.0 / (risk.kappa_across * across) ** 2
    return a * cos**2 + b * sin**2, (a - b) * sin * cos, a * sin**2 + b * cos**2


def _fitted(own: Hull, other: Hull, poses: FloatArray, risk: Risk, own_step: float) -> tuple[FloatArray, ...]:
    """Quadratic form of an ellipse around both hulls and half a step of relative motion.

    Ellipses with the half-extents of either hull, and the segment of the motion, are added (as sets) in an
    ellipse around their sum: its matrix is tr_s * sum of M_i / tr_i, with tr_i the root of the trace of M_i
    and tr_s the sum of these (the least trace of all such ellipses).
    """
    course = poses[1:, 2]
    step = np.diff(poses[:, :2], axis=0) - np.array([own_step, 0.0])
    along, across = risk.kappa_along, risk.kappa_across
    zeros = np.zeros_like(course)
    parts = (
        _ellipse(zeros, along * own.length / 2.0, across * own.beam / 2.0),
        _ellipse(course, along * other.safety_length / 2.0, across * other.safety_beam / 2.0),
        np.einsum("ki,kj->kij", step, step) / 4.0,
    )
    roots = [np.sqrt(np.trace(part, axis1=1, axis2=2)) for part in parts]
    total = sum(roots, zeros)
    matrix = sum(
        (total / np.where(root > 0.0, root, 1.0))[:, None, None] * part
        for root, part in zip(roots, parts, strict=True)
    )
    form = np.linalg.inv(matrix)
    return form[:, 0, 0], form[:, 0, 1], form[:, 1, 1]


def _ellipse(course: FloatArray, along: float, across: float) -> FloatArray:
    """Matrices (N, 2, 2) of an ellipse with these semi-axes, along a course."""
    cos, sin = np.cos(course), np.sin(course)
    axes = np.stack([np.stack([cos, sin], axis=1), np.stack([-sin, cos], axis=1)], axis=1)
    sizes = np.array([along**2, across**2])
    return np.asarray(np.einsum("kai,a,kaj->kij", axes, sizes, axes))
