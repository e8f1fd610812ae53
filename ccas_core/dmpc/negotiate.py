"""One ship's part in the negotiation, Algorithm 2: when it may update, on what, and what it then tells.

All are values: a `Negotiation` is carried from one iteration to the next by `advance`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from ..frames import FloatArray, NedTrajectory, PathFrame, PathPose, PathTrajectory, frozen_array
from ..priority import NO_BEARING, Bearing
from ..roles import Role
from ..ships import Hull, ShipId
from . import nadmm
from .local_problem import LocalPlan, LocalProblem, Solution, free_speeds
from .outcome import Outcome
from .parameters import Anchor, Settings, Start, Wait
from .resolve import Memory, Seen
from .risk import COLUMNS, threats
from .stance import Stance, safest, take_stance
from .trajectories import rollout

SLOW_FACTOR = 1.0 / 3.0  # speed factor of the start `slow`


@dataclass(frozen=True, slots=True, eq=False)
class Neighbour:
    """Another ship, or an obstacle, and where it will be."""

    hull: Hull
    trajectory: NedTrajectory
    id: ShipId | None = None  # None for an obstacle
    bearing: Bearing = NO_BEARING
    unmoved: NedTrajectory | None = None  # where it would be if it went on as it is


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a predecessor has come in this period."""

    iteration: int
    decided: bool


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Situation:
    """What does not change for a ship during one period's negotiation."""

    hull: Hull
    frame: PathFrame
    initial: PathPose
    last_offset: float  # u^y(t - 1) [m]
    speed: float  # nominal, U^d [m/s]
    settings: Settings
    offset_limits: FloatArray  # (N, 2) [m]
    room: FloatArray  # offsets between which the hull keeps its margin to the banks, (N, 2) [m]
    last_controls: FloatArray | None  # of the last period's plan, already shifted, (N, 2)
    memory: Memory = field(default_factory=Memory)  # of the roles, from the period before
    paths: dict[NedTrajectory, PathTrajectory] = field(default_factory=dict)  # in the own frame, so far
    rows: dict[NedTrajectory, FloatArray] = field(default_factory=dict)  # of `risk.threats`, so far


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Negotiation:
    """Where one ship stands in Algorithm 2."""

    situation: Situation
    iteration: int
    iterate: nadmm.Iterate
    plan: LocalPlan
    stance: Stance | None = None  # None before the first update, and where settings know no roles
    outcomes: tuple[Outcome, ...] = ()
    seconds: tuple[float, ...] = ()
    residuals: tuple[float, ...] = ()

    @property
    def done(self) -> bool:
        """Whether all iterations are made (steps 16 and 17)."""
        return self.iteration >= self.situation.settings.iterations

    @property
    def worst(self) -> Outcome:
        """The first outcome that was not usable, or that all converged."""
        return next((outcome for outcome in self.outcomes if not outcome.usable), Outcome.CONVERGED)

    @property
    def usable(self) -> bool:
        """Whether at least one update gave a plan that may be sailed."""
        return any(outcome.usable for outcome in self.outcomes)

    @property
    def heeds(self) -> bool:
        """Whether the next update, or `secured`, looks at neighbours: not those of a ship that holds."""
        return self.stance is None or self.stance.memory.acting

    def told(self) -> NedTrajectory:
        """Trajectory xi to broadcast now: (13d) while negotiating, the local plan at the end (step 13)."""
        told = self.iterate.local if self.done else self.iterate.broadcast
        return self.situation.frame.trajectory_to_ned(PathTrajectory(told))


def begin(situation: Situation) -> Negotiation:
    """Initialise p and z: the last plan shifted, or the nominal one, and z = 0.

    A ship that has stopped is started from a plan that sails on; started from "go on as now", the
    proximal term of (13b) would hold it for good.
    """
    controls = situation.last_controls
    if controls is None or situation.settings.anchor is Anchor.NOMINAL:
        controls = guess(Start.NOMINAL, situation.offset_limits)
    plan = rollout(_alone(situation), controls)
    return Negotiation(
        situation=situation, iteration=0, iterate=nadmm.start(plan.trajectory.poses), plan=plan
    )


def face(negotiation: Negotiation, neighbours: Sequence[Neighbour]) -> Negotiation:
    """Take a stance before the first update, if the settings know roles: limits, starts, and the anchor."""
    situation = negotiation.situation
    roles = situation.settings.roles
    if roles is None or negotiation.iteration > 0:
        return negotiation
    problem = _alone(situation)
    stance = take_stance(
        situation.hull,
        problem,
        situation.room,
        situation.last_controls,
        _seen(situation, neighbours),
        situation.memory,
        roles,
    )
    settled = replace(
        situation,
        settings=stance.settings,
        offset_limits=stance.offset_limits,
        memory=stance.memory,
        rows={},  # risk has changed with the weights
    )
    plan = rollout(replace(problem, speed_limits=stance.speed_limits), stance.anchor)
    return replace(
        negotiation,
        situation=settled,
        iterate=nadmm.start(plan.trajectory.poses),
        plan=plan,
        stance=stance,
    )


def secured(negotiation: Negotiation, neighbours: Sequence[Neighbour], limits: FloatArray) -> Negotiation:
    """Take a manoeuvre at hand instead of a plan that leads into a safety area, if one clears.

    `limits` are those of the water, (N, 2) [m]; a ship that holds keeps its plan.
    """
    stance, situation = negotiation.stance, negotiation.situation
    roles = situation.settings.roles
    if roles is None or stance is None or not negotiation.heeds:
        return negotiation
    problem = replace(_alone(situation), offset_limits=limits)
    seen = _seen(situation, neighbours)
    plan = safest(situation.hull, problem, situation.room, negotiation.plan, seen, stance, roles.clear_by)
    if plan is None:
        return negotiation
    return replace(negotiation, plan=plan, iterate=replace(negotiation.iterate, local=plan.trajectory.poses))


def remembered(stance: Stance, plan: LocalPlan) -> Memory:
    """What a ship carries on that has taken a stance and decides on a plan."""
    return replace(stance.memory, waited=stance.memory.waited + 1.0 - float(plan.controls[0, 1]))


def sailing_on(negotiation: Negotiation) -> Negotiation:
    """Go on along the guiding line whatever the others do: a ship that breaks its duty."""
    situation = negotiation.situation
    free = np.tile([-math.inf, math.inf], (situation.settings.horizon, 1))
    problem = replace(_alone(situation), offset_limits=free)
    plan = rollout(problem, guess(Start.NOMINAL, free))
    return replace(negotiation, plan=plan, iterate=nadmm.start(plan.trajectory.poses))


def may_update(wait: Wait, iteration: int, predecessors: Iterable[Progress]) -> bool:
    """Whether wait(i) is false (step 4): all that decide before this ship have gone far enough.

    >>> may_update(Wait.SEQUENTIAL, 0, [Progress(2, decided=False)])
    False
    >>> may_update(Wait.INTERLEAVED, 0, [Progress(2, decided=False)])
    True
    """
    if wait is Wait.SEQUENTIAL:
        return all(progress.decided for progress in predecessors)
    return all(progress.decided or progress.iteration > iteration for progress in predecessors)


def local_problem(negotiation: Negotiation, neighbours: Sequence[Neighbour]) -> LocalProblem:
    """State (13b) for the next update: neighbours in the own frame (steps 5 to 11), and z^{s+1/2}.

    Neighbours of a ship that does not `heed` any need not be given.
    """
    situation = negotiation.situation
    settings = situation.settings
    half = nadmm.half_step(negotiation.iterate, settings.beta, settings.relaxation)
    stance = negotiation.stance
    dangers = _threats(situation, neighbours if negotiation.heeds else (), stance.gains if stance else None)
    return LocalProblem(
        initial=situation.initial,
        last_offset=situation.last_offset,
        speed=situation.speed,
        settings=settings,
        offset_limits=situation.offset_limits,
        speed_limits=stance.speed_limits if stance else free_speeds(settings.horizon),
        threats=dangers,
        multiplier=half,
        broadcast=PathTrajectory(negotiation.iterate.broadcast),
    )


def guesses(negotiation: Negotiation) -> tuple[FloatArray, ...]:
    """Controls from which to solve: all starts at first, then the plan so far."""
    if negotiation.iteration > 0:
        return (negotiation.plan.controls,)
    if negotiation.stance:
        return negotiation.stance.starts
    situation = negotiation.situation
    starts = situation.settings.starts
    if situation.last_controls is None:
        starts = tuple(start for start in starts if start is not Start.LAST) or (Start.NOMINAL,)
    return tuple(guess(start, situation.offset_limits, situation.last_controls) for start in starts)


def advance(negotiation: Negotiation, problem: LocalProblem, solution: Solution) -> Negotiation:
    """Take a solution (steps 12 to 18); one that is not usable leaves plan and iterate as they are."""
    iterate, plan, outcome = negotiation.iterate, negotiation.plan, solution.outcome
    if outcome.usable and not np.all(np.isfinite(solution.plan.controls)):
        outcome = Outcome.NOT_FINITE  # whatever the solver says of it
    if outcome.usable:
        plan = solution.plan
        beta = negotiation.situation.settings.beta
        iterate = nadmm.full_step(iterate, problem.multiplier, plan.trajectory.poses, beta)
    return replace(
        negotiation,
        iteration=negotiation.iteration + 1,
        iterate=iterate,
        plan=plan,
        outcomes=(*negotiation.outcomes, outcome),
        seconds=(*negotiation.seconds, solution.seconds),
        residuals=(*negotiation.residuals, iterate.residual),
    )


def fallback(situation: Situation, neighbours: Sequence[Neighbour]) -> tuple[LocalPlan, str]:
    """Say what to do without a solution: the last plan if it is still clear, or slow down.

    A plan is clear if it stays outside the risk ellipse (one e-th of the height) of every neighbour.
    """
    settings = situation.settings
    rows = _threats(situation, neighbours)
    problem = _alone(situation)
    if situation.last_controls is not None:
        plan = rollout(problem, situation.last_controls)
        if _clear(plan, rows):
            return plan, "the last plan goes on"
    slow = np.column_stack([np.full(settings.horizon, situation.last_offset), np.zeros(settings.horizon)])
    return rollout(problem, slow), "the ship slows down"


def _threats(
    situation: Situation, neighbours: Sequence[Neighbour], gains: Sequence[float] | None = None
) -> FloatArray:
    """Neighbours as the local problem sees them, in the own frame, (n, N, 6); `gains` are factors of K_ca.

    A neighbour whose factor is zero is left out.
    """
    settings = situation.settings
    if not neighbours:
        return _no_threats(settings.horizon)
    weighed = [
        (each, gain)
        for each, gain in zip(neighbours, gains or (1.0,) * len(neighbours), strict=True)
        if gain > 0.0
    ]
    if not weighed:
        return _no_threats(settings.horizon)
    new = [each for each, _ in weighed if each.trajectory not in situation.rows]
    if new:
        poses = np.stack([path.poses for path in _in_path(situation, [each.trajectory for each in new])])
        hulls = [each.hull for each in new]
        step = situation.speed * settings.kinematics.time_step
        rows = threats(situation.hull, hulls, poses, settings.risk, settings.weights, step)
        situation.rows.update(zip((each.trajectory for each in new), rows, strict=True))
    found = np.array([situation.rows[each.trajectory] for each, _ in weighed])
    found[:, :, 5] *= np.array([gain for _, gain in weighed])[:, None]
    return found


def _in_path(situation: Situation, told: Sequence[NedTrajectory]) -> list[PathTrajectory]:
    """Trajectories of one length in the own frame; those not known yet are read at once."""
    new = [each for each in dict.fromkeys(told) if each not in situation.paths]
    if new:
        together = NedTrajectory(np.vstack([each.poses for each in new]))
        poses = situation.frame.trajectory_to_path(together).poses.reshape(len(new), -1, 3)
        situation.paths.update(zip(new, map(PathTrajectory, poses), strict=True))
    return [situation.paths[each] for each in told]


def _seen(situation: Situation, neighbours: Sequence[Neighbour]) -> list[Seen]:
    """Neighbours as the stance sees them, in the own frame."""
    unmoved = [each.unmoved if each.bearing.role is Role.BOTH else None for each in neighbours]  # else unused
    _in_path(situation, [*(each.trajectory for each in neighbours), *(each for each in unmoved if each)])
    paths = situation.paths
    return [
        Seen(each.id, each.hull, paths[each.trajectory], each.bearing, paths[alone] if alone else None)
        for each, alone in zip(neighbours, unmoved, strict=True)
    ]


def _clear(plan: LocalPlan, dangers: FloatArray) -> bool:
    poses = plan.trajectory.poses[1:]
    for rows in dangers:
        dx, dy = poses[:, 0] - rows[:, 0], poses[:, 1] - rows[:, 1]
        if not np.all(rows[:, 2] * dx**2 + 2.0 * rows[:, 3] * dx * dy + rows[:, 4] * dy**2 >= 1.0):
            return False  # near, or not a number
    return True


def _alone(situation: Situation) -> LocalProblem:
    """State the problem without neighbours and without (13a): what it takes to sail plans."""
    nothing = _nothing(situation.settings.horizon)
    return LocalProblem(
        initial=situation.initial,
        last_offset=situation.last_offset,
        speed=situation.speed,
        settings=situation.settings,
        offset_limits=situation.offset_limits,
        speed_limits=free_speeds(situation.settings.horizon),
        threats=_no_threats(situation.settings.horizon),
        multiplier=nothing.poses,
        broadcast=nothing,
    )


@cache
def _nothing(horizon: int) -> PathTrajectory:
    return PathTrajectory(np.zeros((horizon + 1, 3)))


@cache
def _no_threats(horizon: int) -> FloatArray:
    return frozen_array(np.empty((0, horizon, COLUMNS)))


def guess(start: Start, offset_limits: FloatArray, last_controls: FloatArray | None = None) -> FloatArray:
    """Controls (N, 2) of a start; without a last plan, `last` is nominal."""
    if start is Start.LAST and last_controls is not None:
        return last_controls
    horizon = len(offset_limits)
    offset, factor = np.zeros(horizon), np.ones(horizon)
    if start is Start.STARBOARD:
        offset = offset_limits[:, 1] / 2.0
    elif start is Start.SLOW:
        factor = np.full(horizon, SLOW_FACTOR)
    return np.column_stack([offset, factor])


def progress_of(told: Mapping[ShipId, Progress], predecessors: Iterable[ShipId]) -> tuple[Progress, ...]:
    """How far each predecessor has come; one that has told nothing has not begun."""
    return tuple(told.get(ship, Progress(0, decided=False)) for ship in predecessors)
