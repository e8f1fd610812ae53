"""A ship that a controller of a plugin steers: it judges both sides of each encounter, and decides alone.

It negotiates with nobody.  What the others owe it and it owes them comes from the ruleset, as for every ship,
for it judges for them as well; its controller gets the bearings of the priority graph and no more.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from ..controllers import AbstractController, Options, Outlook, Steering, Target
from ..frames import NedPose, NedTrajectory
from ..priority import PriorityGraph, Settlement, settle
from ..regions import InForce, Law
from ..ships import Ship, ShipId
from ..surge_yaw import Manoeuvrability, Motion, advance, within
from ..tapd.aboard import Aboard, judging
from ..tapd.assign import judged_by_law, remembered
from ..tapd.encounters import NO_ENCOUNTER, Encounter
from ..tapd.ruleset import Pair, Situation
from ..verdict import Kind
from ..waterway import GuidingLine, Waters
from ..world import ShipReport, World
from .events import Decision, Event, Sensed, Step, Timers
from .messages import Report
from .sightings import Sightings
from .tracked_agent import sighted

SAFE_PLAN: Final = 10  # periods that the plan of a safe command covers


@dataclass(frozen=True, slots=True, kw_only=True)
class Steered:
    """A ship for a controller: what it can do, and what the controller is set to."""

    ship: Ship
    line: GuidingLine
    speed: float  # nominal, over ground [m/s]
    limits: Manoeuvrability
    controller: AbstractController
    options: Options


@dataclass(slots=True, eq=False)
class _Period:
    index: int
    began: float
    own: ShipReport
    reports: dict[ShipId, ShipReport] = field(default_factory=dict)
    done: bool = False


class SteeredAgent:
    """One ship under a controller.

    Parameters
    ----------
    steered
        The ship, and what steers it.
    waters, rulesets
        The chart, and the rulesets that the ship has aboard.
    period
        Control period [s].
    """

    def __init__(
        self,
        steered: Steered,
        waters: Waters,
        rulesets: Aboard,
        period: float,
    ) -> None:
        self._steered: Final = steered
        self._waters: Final = waters
        self._rulesets: Final = rulesets
        self._length: Final = period
        self._listen: Final = min(Timers().listen, period / 2.0)
        self._encounters: dict[Pair, Encounter] = {}
        self._kept_starboard: frozenset[ShipId] = frozenset()
        self._sightings: Final = Sightings()
        self._motion = Motion(min(steered.speed, steered.limits.max_speed), 0.0)
        self._memory: Any = None
        self._law: InForce | None = None
        self._period: _Period | None = None

    def step(self, now: float, inbox: Sequence[Event]) -> Step:
        """Report, listen to reports, and then decide."""
        outbox = []
        for event in inbox:
            if isinstance(event, Sensed):
                report = self._own_report(now, event)
                self._period = _Period(event.period, now, report)
                outbox.append(Report(report.id, event.period, report))
            elif isinstance(event, Report) and self._period and event.period == self._period.index:
                self._period.reports[event.sender] = event.report
        period = self._period
        if period is None or period.done:
            return Step(outbox=tuple(outbox))
        if now < period.began + self._listen:
            return Step(outbox=tuple(outbox), wake_at=period.began + self._listen)
        return Step(outbox=tuple(outbox), decision=self._decide(period))

    def _own_report(self, now: float, sensed: Sensed) -> ShipReport:
        waters = self._waters
        self._law = waters.laws.in_force(sensed.pose, now, self._law, waters.hysteresis)
        report = sighted(self._steered.ship, self._steered.line, waters, sensed)
        return replace(report, ruleset=self._law.law.ruleset)

    def _decide(self, period: _Period) -> Decision:
        period.done = True
        reports, saw = self._sightings.believed(period.began, period.own.pose, period.reports)
        settlements = self._judge(period, reports)
        outlook = self._outlook(period, reports, settlements)
        steering, fallback = self._asked(outlook)
        self._memory, self._motion = steering.memory, steering.motion
        own = self._steered
        return Decision(
            offset=own.line.frame.to_path(period.own.pose).y,
            speed_factor=steering.motion.surge / own.speed,
            ruleset=period.own.ruleset,
            plan=steering.plan,
            settlements=settlements,
            openings=(),
            outcome=steering.outcome,
            fallback=fallback,
            update_ms=(1000.0 * steering.seconds,) if steering.seconds else (),
            residuals=(),
            motion=steering.motion,
            saw=saw,
        )

    def _judge(self, period: _Period, reports: Mapping[ShipId, ShipReport]) -> tuple[Settlement, ...]:
        """Settle every encounter from both of its sides, by the law of the pair."""
        own = period.own
        everyone = {**reports, own.id: own}
        situation = Situation(
            world=World(time=period.began, waters=self._waters, reports=everyone),
            encounters=self._encounters,
            kept_starboard=self._kept_starboard,
        )
        masses = {ship: report.ship.mass for ship, report in everyone.items()}
        settlements, encounters = [], {}
        for other in sorted(reports):
            mine = judged_by_law(self._rulesets, situation, own.id, other)
            theirs = judged_by_law(self._rulesets, situation, other, own.id)
            pair, encounter = remembered(situation, mine, theirs)
            if encounter is not NO_ENCOUNTER:
                encounters[pair] = encounter
            if (mine.kind, theirs.kind) != (Kind.NONE, Kind.NONE):
                settlements.append(settle(mine, theirs, masses))
        self._encounters = encounters
        vocabulary = judging(self._rulesets, Law(own.ruleset)).vocabulary
        self._kept_starboard = situation.on_starboard_side(vocabulary)
        return tuple(settlements)

    def _outlook(
        self, period: _Period, reports: Mapping[ShipId, ShipReport], settlements: tuple[Settlement, ...]
    ) -> Outlook:
        own, id_ = self._steered, period.own.id
        masses = {ship: report.ship.mass for ship, report in {**reports, id_: period.own}.items()}
        graph = PriorityGraph(masses=masses, settlements=settlements)
        targets = tuple(
            Target(
                id=ship,
                hull=report.ship.hull,
                domain=report.ship.domain,
                pose=report.pose,
                speed=report.speed,
                bearing=graph.bearing(id_, ship),
            )
            for ship, report in sorted(reports.items())
        )
        return Outlook(
            time=period.began,
            period=self._length,
            hull=own.ship.hull,
            domain=own.ship.domain,
            limits=own.limits,
            speed=own.speed,
            line=own.line,
            waters=self._waters,
            pose=period.own.pose,
            motion=self._motion,
            targets=targets,
            options=own.options,
        )

    def _asked(self, outlook: Outlook) -> tuple[Steering, str]:
        """Ask the controller; without an answer that can be sailed, the ship slows down, and says why."""
        controller = self._steered.controller
        try:
            steering = controller.steer(outlook, self._memory)
            if not isinstance(steering, Steering):
                raise TypeError(f"expected a Steering, got {type(steering).__name__}")  # noqa: TRY301
        except Exception as error:  # noqa: BLE001 - a plugin may raise anything
            return self._slowed(outlook), f"controller {controller.name!r} failed: {error!r}: {_SLOWS}"
        motion, poses = steering.motion, steering.plan.poses
        if not (math.isfinite(motion.surge) and math.isfinite(motion.yaw_rate) and np.isfinite(poses).all()):
            return self._slowed(outlook), f"controller {controller.name!r} gave no number: {_SLOWS}"
        held = within(outlook.limits, outlook.motion, motion, outlook.period)
        return Steering(
            motion=held,
            plan=steering.plan,
            memory=steering.memory,
            outcome=steering.outcome,
            seconds=steering.seconds,
        ), ""

    def _slowed(self, outlook: Outlook) -> Steering:
        """Keep the course, and take the way off the ship; the controller begins anew in the next period."""
        poses, motion, pose = [outlook.pose], outlook.motion, outlook.pose
        first = within(outlook.limits, motion, Motion(0.0, 0.0), outlook.period)
        for _ in range(SAFE_PLAN):
            motion = within(outlook.limits, motion, Motion(0.0, 0.0), outlook.period)
            pose = advance(pose, motion, outlook.waters.current, outlook.period)
            poses.append(pose)
        return Steering(motion=first, plan=_plan(poses))


_SLOWS: Final = "the ship slows down on its course"


def _plan(poses: Sequence[NedPose]) -> NedTrajectory:
    return NedTrajectory(np.array([[each.x, each.y, each.course] for each in poses]))
