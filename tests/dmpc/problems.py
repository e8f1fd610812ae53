"""Random local problems: meetings, crossings and overtakings with one to five threats."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ccas_core.dmpc.local_problem import LocalProblem, free_speeds
from ccas_core.dmpc.parameters import CROSSING, HEAD_ON, Settings, Start
from ccas_core.dmpc.risk import threat
from ccas_core.dmpc.trajectories import rollout
from ccas_core.frames import FloatArray, PathPose, PathTrajectory
from ccas_core.ships import Hull

SPEED = 3.0  # [m/s]
_HULL = Hull(length=103.0, beam=11.45)


def guess(problem: LocalProblem, start: Start) -> FloatArray:
    """Controls from which a solver sets out."""
    horizon = problem.settings.horizon
    offset = problem.offset_limits[:, 1] / 2.0 if start is Start.STARBOARD else np.zeros(horizon)
    factor = 1.0 / 3.0 if start is Start.SLOW else 1.0
    return np.column_stack([offset, np.full(horizon, factor)])


def guesses(problem: LocalProblem) -> list[FloatArray]:
    """Nominal, to starboard, slow: in this order."""
    return [guess(problem, start) for start in (Start.NOMINAL, Start.STARBOARD, Start.SLOW)]


def random_problem(generator: np.random.Generator, threats: int | None = None) -> LocalProblem:
    """Make a problem as it comes up in the first or second update of a negotiation."""
    count = int(generator.integers(1, 6)) if threats is None else threats
    profile = HEAD_ON if generator.random() < 0.5 else CROSSING
    share = float(generator.choice([0.05, 1.0, 5.0]))  # of the risk, by role
    settings = replace(profile, weights=replace(profile.weights, K_ca=share * profile.weights.K_ca))
    rows = [_threat(generator, settings) for _ in range(count)]
    horizon = settings.horizon
    problem = LocalProblem(
        initial=PathPose(0.0, float(generator.uniform(-20.0, 20.0)), float(generator.uniform(-0.2, 0.2))),
        last_offset=float(generator.choice([0.0, generator.uniform(-30.0, 30.0)])),
        speed=SPEED,
        settings=settings,
        offset_limits=np.tile([-60.0, 60.0], (horizon, 1)),
        speed_limits=free_speeds(horizon),
        threats=np.array(rows).reshape(count, horizon, 6),
        multiplier=np.zeros((horizon + 1, 3)),
        broadcast=PathTrajectory(np.zeros((horizon + 1, 3))),
    )
    nominal = rollout(problem, guess(problem, Start.NOMINAL)).trajectory
    if generator.random() < 0.5:
        return replace(problem, broadcast=nominal)
    first, last = sorted(generator.integers(0, horizon, 2))
    controls = guess(problem, Start.NOMINAL)
    factor = generator.choice([1.0, generator.uniform(0.3, 1.0)])
    controls[first : last + 1] = [generator.uniform(-30.0, 30.0), factor]
    changed = rollout(problem, controls).trajectory
    multiplier = settings.beta * (changed.poses - nominal.poses)
    told = PathTrajectory(2.0 * changed.poses - nominal.poses)
    return replace(problem, multiplier=multiplier, broadcast=told)


def _threat(generator: np.random.Generator, settings: Settings) -> FloatArray:
    """Another ship that comes near at some step of the horizon."""
    course = float(generator.choice([math.pi, math.pi / 2, -math.pi / 2, 0.0]) + generator.uniform(-0.3, 0.3))
    speed = SPEED * float(generator.uniform(0.3, 1.2))
    step = float(generator.uniform(3.0, 35.0))
    period = settings.kinematics.time_step
    meeting = (SPEED * period * step + generator.uniform(-60.0, 60.0), generator.uniform(-25.0, 25.0))
    sailed = speed * period * (np.arange(settings.horizon + 1) - step)
    poses = np.column_stack(
        [
            meeting[0] + sailed * math.cos(course),
            meeting[1] + sailed * math.sin(course),
            np.full(settings.horizon + 1, course),
        ]
    )
    return threat(_HULL, _HULL, PathTrajectory(poses), settings.risk, settings.weights)
