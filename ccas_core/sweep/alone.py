"""Whether a ship could have kept clear all by itself of one that breaks its duty and sails on.

A ship that stands on has to act when the other does not (BPR 6.03(5), COLREG 17(b)).  What can be asked of it
is told by what it could have done from the first verdict on: the manoeuvres at hand, begun at once, while the
other goes on along its line.  One that keeps the hulls apart, and the own hull between the banks, is enough.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..agent.events import Conduct
from ..dmpc.clearance import bank_gaps, gaps
from ..dmpc.local_problem import LocalProblem, free_speeds
from ..dmpc.manoeuvres import at_hand
from ..dmpc.parameters import FAITHFUL, Settings
from ..frames import FloatArray, NedTrajectory, PathTrajectory
from ..ships import Hull
from ..sim.conduct import encounters
from ..sim.frame import Frame
from ..sim.scenario import Plan, Scenario
from ..sim.undisturbed import undisturbed
from ..sim.voyage import chosen
from ..waterway import BANK_MARGIN, GuidingLine, guiding_line


def could_avoid(sailed: Scenario, frames: Sequence[Frame]) -> bool | None:
    """Whether a manoeuvre at hand, begun at the first verdict, keeps the hulls of two ships apart.

    None where no ship breaks its duty, where there are not two ships, or where they never met.
    """
    offenders = [plan for plan in sailed.ships if plan.conduct is not Conduct.DUTIFUL]
    met = encounters(frames)
    if len(sailed.ships) != 2 or len(offenders) != 1 or not met:
        return None
    (own,) = (plan for plan in sailed.ships if plan is not offenders[0])
    return could_keep_clear(sailed, frames, own, offenders[0], met[0].begin)


def could_keep_clear(
    sailed: Scenario, frames: Sequence[Frame], own: Plan, other: Plan, begin: int, *, areas: bool = False
) -> bool:
    """Whether a manoeuvre at hand, begun at a frame, keeps the hulls apart while the other goes on.

    With `areas`, it has to keep each hull out of the other's safety area as well.
    """
    settings = chosen(FAITHFUL, sailed.control, sailed.time_step)
    line = guiding_line(sailed.waters, own.route)
    problem, room = _problem(own, line, frames, begin, settings)
    plans = at_hand(problem, problem.last_offset, settings.horizon).paths
    apart = _apart(sailed, frames[begin], own, other, plans, areas=areas)
    afloat = bank_gaps(own.ship.hull, plans, room).min(axis=1) >= -BANK_MARGIN
    return bool(np.any((apart > 0.0) & afloat))


def _problem(
    own: Plan, line: GuidingLine, frames: Sequence[Frame], begin: int, settings: Settings
) -> tuple[LocalProblem, FloatArray]:
    """Where the ship was and how it could move at a frame; and its room between the banks, (N, 2) [m]."""
    horizon = settings.horizon
    ships = frames[begin].ships
    initial = line.frame.to_path(ships[own.ship.id].pose)
    before = frames[begin - 1].ships.get(own.ship.id) if begin else None
    ahead = initial.x + own.speed * settings.kinematics.time_step * np.arange(horizon, dtype=np.float64)
    problem = LocalProblem(
        initial=initial,
        last_offset=before.offset if before else 0.0,
        speed=own.speed,
        settings=settings,
        offset_limits=line.offset_limits_at(ahead, own.ship.hull.beam),
        speed_limits=free_speeds(horizon),
        threats=np.zeros((0, horizon, 6)),
        multiplier=np.zeros((horizon + 1, 3)),
        broadcast=PathTrajectory(np.zeros((horizon + 1, 3))),
    )
    return problem, line.room_at(ahead, own.ship.hull.beam)


def _apart(
    sailed: Scenario, frame: Frame, own: Plan, other: Plan, plans: FloatArray, *, areas: bool
) -> FloatArray:
    """Least gap between the hulls, or to areas, of each plan while both ships are under way, (M,) [m]."""
    mine = guiding_line(sailed.waters, own.route).frame
    theirs = guiding_line(sailed.waters, other.route).frame
    track = undisturbed(other, frame.ships[other.ship.id].pose, frame.time, theirs)
    times = frame.time + sailed.time_step * np.arange(plans.shape[1], dtype=np.float64)
    poses = mine.trajectory_to_path(NedTrajectory(track.at(times))).poses
    one, two = (plan.ship.hull if areas else _bare(plan.ship.hull) for plan in (own, other))
    gap = gaps(one, plans, two, poses)
    over = (times[:-1] >= track.times[-1]) | (plans[:, :-1, 0] >= mine.length)
    return np.asarray(np.where(over, np.inf, gap).min(axis=1))


def _bare(hull: Hull) -> Hull:
    """The hull without the safety area around it."""
    return Hull(length=hull.length, beam=hull.beam, safety_length=hull.length, safety_beam=hull.beam)
