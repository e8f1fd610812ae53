"""One ship as a state machine without input and output of its own.

`step(now, inbox)` takes what has reached the ship and returns what it wants: messages to send, a local
problem to be solved, the time at which to be woken, and, once a period, its decision.  The driver
solves and hands the `Solved` back, so that the problems of a generation can be solved together.

A period runs through four phases: the ship *listens* to reports, *settles* its verdicts with
those of the others, *waits* its turn and negotiates, and is *done*.  Whatever happens, a decision
leaves the ship before the deadline.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from ..dmpc import negotiate
from ..dmpc.local_problem import shifted
from ..dmpc.negotiate import Negotiation, Neighbour
from ..dmpc.parameters import Expectation, Settings
from ..dmpc.prediction import AbstractPredictor, ConstantVelocity, carried_on, resized
from ..dmpc.resolve import Memory
from ..frames import FloatArray, NedPose, NedTrajectory
from ..priority import NO_BEARING, Opening, PriorityGraph, settle
from ..regions import InForce, Law
from ..roles import Geometry
from ..ships import Hull, Ship, ShipId
from ..tapd.aboard import Aboard, judging
from ..tapd.assign import assign_by_law, judged_by_law, remembered
from ..tapd.deadlock import Waiting, opened_orders, released
from ..tapd.encounters import NO_ENCOUNTER, Encounter
from ..tapd.ruleset import AbstractRuleset, Pair, Situation
from ..verdict import Kind, Verdict
from ..waterway import OFFSET_LIMIT, GuidingLine, Waters
from ..world import ShipReport, World
from .events import AgentSettings, Conduct, Decision, Event, Request, Sensed, Solved, Step
from .knowledge import Period, Phase
from .messages import Gossip, Intention, Message, Report, Verdicts
from .sightings import Sightings, silent

BROKEN_BEYOND: Final = 3.0  # a ship that is so far from where it promised to be has broken its promise [m]
FORGOTTEN: Final = 10  # periods of silence after which an encounter is forgotten


class ShipAgent:
    """One ship: its knowledge, and what it does with it.

    Parameters
    ----------
    ship, guiding_line, speed
        Who it is, where it goes, and its nominal speed U^d [m/s].
    waters
        The chart.
    rulesets
        Those aboard, by id.  For want of one that the chart asks for, the ship judges by the first.
    settings
        Of the controller and the timers.
    predictor
        For ships whose intention is not known; constant velocity unless given.
    """

    def __init__(
        self,
        ship: Ship,
        guiding_line: GuidingLine,
        speed: float,
        waters: Waters,
        rulesets: Aboard,
        settings: AgentSettings,
        predictor: AbstractPredictor | None = None,
    ) -> None:
        self.ship: Final = ship
        self._line: Final = guiding_line
        self._speed: Final = speed
        self._waters: Final = waters
        self._rulesets: Final = rulesets
        self._settings: Final = settings
        self._predictor: Final = predictor or ConstantVelocity()
        self._law: InForce | None = None
        self._encounters: dict[Pair, Encounter] = {}
        self._kept_starboard: frozenset[ShipId] = frozenset()  # a period ago
        self._last_controls: FloatArray | None = None
        self._last_offset = 0.0
        self._memory = Memory()
        self._distrusted: set[ShipId] = set()  # ships that did not do what they told
        self._promises: dict[ShipId, NedTrajectory] = {}  # intentions of the last period
        self._last_reports: dict[ShipId, ShipReport] = {}  # for ships that fall silent
        self._last_heard: dict[ShipId, int] = {}  # period of the last report
        self._sightings: Final = Sightings()
        self._period: Period | None = None

    def step(self, now: float, inbox: Sequence[Event]) -> Step:
        """Take what has come, go on as far as possible, and say what is wanted."""
        step = self._step(now, inbox)
        if self._settings.conduct is not Conduct.SILENT:
            return step
        return replace(step, outbox=tuple(each for each in step.outbox if not isinstance(each, Intention)))

    def _step(self, now: float, inbox: Sequence[Event]) -> Step:
        outbox: list[Message] = []
        for event in inbox:
            outbox += self._take(now, event)
        period = self._period
        if period is None:
            return Step()
        timers = self._settings.timers
        if period.phase is Phase.LISTENING and now >= period.began + timers.listen:
            outbox += self._judge(period)
        if period.phase is Phase.SETTLING and self._may_settle(now, period):
            outbox += self._settle(now, period)
        negotiation = period.negotiation
        if period.phase is not Phase.WAITING or negotiation is None:
            return self._rest(now, period, outbox)
        if period.asked:
            return Step(outbox=tuple(outbox))
        if negotiation.done:
            return self._decide(now, period, negotiation, outbox)
        if now >= period.began + timers.deadline:
            late = "the deadline came before the ship's turn"
            return self._give_up(now, period, negotiation, outbox, late)
        if any(isinstance(event, Solved) for event in inbox):
            return Step(outbox=tuple(outbox), wake_at=now)  # first let what was told arrive
        self._open_orders(period)
        detects = self._settings.deadlock_detection
        impatient = detects and now >= period.began + timers.patience
        if (
            impatient
            or self._my_turn(period, negotiation)
            or self._released(now, period, negotiation, outbox)
        ):
            return self._ask(period, negotiation, outbox)
        wake_at = period.began + timers.deadline
        if detects:
            wake_at = min(period.began + timers.patience, period.progressed + timers.deadlock)
        return Step(outbox=tuple(outbox), wake_at=wake_at)

    # -- taking what comes -----------------------------------------------------------------------

    def _take(self, now: float, event: Event) -> list[Message]:
        """Take one event; the answer to a request may be told at once."""
        if isinstance(event, Sensed):
            return [self._begin(now, event)]
        period = self._period
        if period is None:
            return []
        if isinstance(event, Solved):
            return self._take_solution(now, period, event)
        period.take(now, event)
        return []

    def _begin(self, now: float, sensed: Sensed) -> Message:
        leg = self._line.leg_at(self._line.frame.to_path(sensed.pose).x)
        waters = self._waters
        self._law = waters.laws.in_force(sensed.pose, now, self._law, waters.hysteresis)
        own = ShipReport(
            ship=self.ship,
            pose=sensed.pose,
            speed=sensed.speed,
            waterway=leg.waterway,
            towards=leg.towards,
            ruleset=self._law.law.ruleset,
        )
        if self._period is not None:
            promised = self._period.decided
            told = self._period.intentions.items()
            self._promises = {ship: carried_on(plan) for ship, plan in told if ship in promised}
            self._last_reports = {**self._period.reports}
        self._period = Period(index=sensed.period, began=now, own=own, progressed=now)
        return Report(self.ship.id, sensed.period, own)

    def _take_solution(self, now: float, period: Period, solved: Solved) -> list[Message]:
        period.asked = False
        if period.negotiation is None:
            return []
        period.negotiation = negotiate.advance(period.negotiation, solved.problem, solved.solution)
        period.progressed = now
        if period.negotiation.done:
            return []  # told with the decision
        return [self._intention(period, period.negotiation)]

    # -- layer 1 ---------------------------------------------------------------------------------

    def _situation(self, period: Period) -> Situation:
        reports = {**period.reports, self.ship.id: period.own}
        world = World(time=period.began, waters=self._waters, reports=reports)
        return Situation(world=world, encounters=self._encounters, kept_starboard=self._kept_starboard)

    def _own_ruleset(self, period: Period) -> AbstractRuleset:
        """Ruleset under which the ship sails itself."""
        return judging(self._rulesets, Law(period.own.ruleset))

    def _judge(self, period: Period) -> list[Message]:
        period.reports, period.saw = self._sightings.believed(period.began, period.own.pose, period.reports)
        period.silent = silent(period.reports.values())
        period.situation = situation = self._situation(period)
        period.judged = assign_by_law(self._rulesets, situation, self.ship.id)
        self._kept_starboard = situation.on_starboard_side(self._own_ruleset(period).vocabulary)
        period.phase = Phase.SETTLING
        return [Verdicts(self.ship.id, period.index, period.judged)]

    def _may_settle(self, now: float, period: Period) -> bool:
        return period.heard.keys() >= period.talking or now >= period.began + self._settings.timers.settle

    def _settle(self, now: float, period: Period) -> list[Message]:
        masses = {ship: report.ship.mass for ship, report in period.reports.items()}
        masses[self.ship.id] = self.ship.mass
        situation = period.situation or self._situation(period)
        settlements = []
        for mine in period.judged:
            theirs = self._heard_on_me(period, situation, mine)
            pair, encounter = remembered(situation, mine, theirs)
            if encounter is NO_ENCOUNTER:
                self._encounters.pop(pair, None)
            else:
                self._encounters[pair] = encounter
            if (mine.kind, theirs.kind) != (Kind.NONE, Kind.NONE):
                settlements.append(settle(mine, theirs, masses))
        self._forget(period)
        period.settlements = tuple(settlements)
        graph = PriorityGraph(masses=masses, settlements=period.settlements)
        period.bearings = {ship: graph.bearing(self.ship.id, ship) for ship in period.reports}
        self._check_promises(period)
        edges = [
            each.edge
            for each in settlements
            if each.edge is not None
            and each.edge.then == self.ship.id
            and each.edge.first not in period.silent  # whose word would never come
        ]
        period.waits_for = {edge.first for edge in edges}
        ruleset = self._own_ruleset(period)
        kinds = {edge.first: edge.kind for edge in edges}
        waiting = Waiting(ruleset.rank(self.ship), kinds, ruleset.criterion)
        period.waiting[self.ship.id] = waiting
        period.phase = Phase.WAITING
        period.progressed = now
        period.negotiation = negotiate.begin(self._negotiating(period))
        return [Gossip(self.ship.id, period.index, {self.ship.id: waiting}, frozenset())]

    def _check_promises(self, period: Period) -> None:
        """Trust no more in the intentions of a ship that is not where it promised to be, while it is met."""
        met = {ship for ship, bearing in period.bearings.items() if bearing.geometry is not Geometry.NONE}
        self._distrusted &= met
        for ship in met & self._promises.keys():
            promised, pose = self._promises[ship].poses[0], period.reports[ship].pose
            if math.hypot(promised[0] - pose.x, promised[1] - pose.y) > BROKEN_BEYOND:
                self._distrusted.add(ship)

    def _forget(self, period: Period) -> None:
        """Forget encounters with ships that have long been silent or out of reach: memory is bounded."""
        self._last_heard |= dict.fromkeys(period.reports, period.index)
        for other in [o for o, last in self._last_heard.items() if period.index - last > FORGOTTEN]:
            del self._last_heard[other]
            self._encounters.pop((min(self.ship.id, other), max(self.ship.id, other)), None)

    def _heard_on_me(self, period: Period, situation: Situation, mine: Verdict) -> Verdict:
        """The other ship's verdict on this one; one that did not come decides nothing.

        A ship that does not cooperate tells none: what its ruleset expects of it is judged for it.
        """
        if mine.other in period.silent:
            return judged_by_law(self._rulesets, situation, mine.other, self.ship.id)
        for verdict in period.heard.get(mine.other, ()):
            if verdict.other == self.ship.id and verdict.own == mine.other:
                return verdict
        kind = Kind.NONE if mine.kind is Kind.NONE else Kind.UNKNOWN_FACT
        return Verdict(
            own=mine.other,
            other=self.ship.id,
            kind=kind,
            ruleset=mine.ruleset,
            version=mine.version,
            geometry=mine.geometry,
            reason="its verdict did not arrive",
        )

    def _my_turn(self, period: Period, negotiation: Negotiation) -> bool:
        told = negotiate.progress_of(period.told, sorted(period.waits_for))
        return negotiate.may_update(negotiation.situation.settings.wait, negotiation.iteration, told)

    def _open_orders(self, period: Period) -> None:
        """Wait no longer where an order edge lies on a cycle: nobody owes anything by it."""
        if not self._settings.deadlock_detection:
            return
        openings = opened_orders(self.ship.id, period.waiting, period.decided)
        self._open(period, openings)

    def _open(self, period: Period, openings: tuple[Opening, ...]) -> None:
        new = [opening for opening in openings if opening not in period.openings]
        period.openings += new
        period.waits_for -= {opening.edge.first for opening in new}

    def _released(self, now: float, period: Period, negotiation: Negotiation, outbox: list[Message]) -> bool:
        """Open a deadlock, if there is one and this ship is the one to open it."""
        if not self._settings.deadlock_detection or now < period.progressed + self._settings.timers.deadlock:
            return False
        openings = released(self.ship.id, period.waiting, period.decided)
        period.progressed = now
        if openings is None:
            outbox.append(Gossip(self.ship.id, period.index, period.waiting, period.decided))
            return False
        self._open(period, openings)
        return self._my_turn(period, negotiation)

    # -- layer 2 ---------------------------------------------------------------------------------

    def _negotiating(self, period: Period) -> negotiate.Situation:
        settings = self._profile(period)
        initial = self._line.frame.to_path(period.own.pose)
        hull, roles = self.ship.hull, settings.roles
        steps = np.arange(settings.horizon, dtype=np.float64)
        ahead = initial.x + self._speed * settings.kinematics.time_step * steps
        room = self._line.room_at(ahead, hull.beam)
        swing = roles.swing * hull.length / 2.0 if roles else 0.0
        low, high = room.T
        limits = np.column_stack([np.minimum(low + swing, 0.0), np.maximum(high - swing, 0.0)])
        limits = np.minimum(np.maximum(limits, -OFFSET_LIMIT), OFFSET_LIMIT)
        period.limits = limits
        last = self._last_controls
        return negotiate.Situation(
            hull=self.ship.hull,
            frame=self._line.frame,
            initial=initial,
            last_offset=self._last_offset,
            speed=self._speed,
            settings=settings,
            offset_limits=limits,
            room=room,
            last_controls=None if last is None else shifted(last),
            memory=self._memory,
        )

    def _profile(self, period: Period) -> Settings:
        """Control settings for the encounters at hand: crossing prevails over head-on (Sec. 5.4)."""
        profile = self._settings.profile
        if profile is None:
            met = {bearing.geometry for bearing in period.bearings.values()}
            profile = Geometry.CROSSING if Geometry.CROSSING in met else Geometry.HEAD_ON
        return self._settings.profiles[profile]

    def _neighbours(self, period: Period, settings: Settings) -> list[Neighbour]:
        """Where all others will be: their intention if told, or a prediction (steps 5 to 11)."""
        horizon, time_step = settings.horizon, settings.kinematics.time_step
        neighbours = []
        for ship, report in sorted({**self._last_reports, **period.reports}.items()):
            told = None if ship in self._distrusted else period.intentions.get(ship)
            if told is None and settings.expectation is Expectation.LAST_PLAN:
                told = self._promises.get(ship)
            unmoved = self._predictor.predict(report.pose, report.speed, horizon, time_step)
            if told is None or ship in self._distrusted:
                told = unmoved
            bearing = period.bearings.get(ship, NO_BEARING)
            neighbours.append(Neighbour(report.ship.hull, resized(told, horizon), ship, bearing, unmoved))
        for obstacle in self._waters.obstacles:
            pose = NedPose(obstacle.x, obstacle.y, 0.0)
            circle = Hull(
                length=2.0 * obstacle.radius,
                beam=2.0 * obstacle.radius,
                safety_beam=2.0 * obstacle.radius,
            )
            neighbours.append(Neighbour(circle, ConstantVelocity().predict(pose, 0.0, horizon, time_step)))
        return neighbours

    def _ask(self, period: Period, negotiation: Negotiation, outbox: list[Message]) -> Step:
        settings = negotiation.situation.settings
        neighbours = self._neighbours(period, settings) if negotiation.heeds else []
        negotiation = period.negotiation = negotiate.face(negotiation, neighbours)
        problem = negotiate.local_problem(negotiation, neighbours)
        period.asked = True
        return Step(outbox=tuple(outbox), request=Request(problem, negotiate.guesses(negotiation)))

    # -- deciding --------------------------------------------------------------------------------

    def _decide(self, now: float, period: Period, negotiation: Negotiation, outbox: list[Message]) -> Step:
        if not negotiation.usable:
            return self._give_up(now, period, negotiation, outbox, negotiation.worst.value)
        settings = negotiation.situation.settings
        if settings.roles is not None and period.limits is not None and negotiation.heeds:
            neighbours = self._neighbours(period, settings)
            negotiation = negotiate.secured(negotiation, neighbours, period.limits)
        return self._close(now, period, negotiation, outbox, "")

    def _give_up(
        self, now: float, period: Period, negotiation: Negotiation, outbox: list[Message], why: str
    ) -> Step:
        """Decide without a solution: by the last plan, or by slowing down."""
        situation = negotiation.situation
        plan, what = negotiate.fallback(situation, self._neighbours(period, situation.settings))
        iterate = replace(negotiation.iterate, local=plan.trajectory.poses)
        settled = replace(negotiation, plan=plan, iterate=iterate, iteration=situation.settings.iterations)
        return self._close(now, period, settled, outbox, f"{why}: {what}")

    def _close(
        self, now: float, period: Period, negotiation: Negotiation, outbox: list[Message], fallback: str
    ) -> Step:
        """Issue the decision of this period, and promise its plan."""
        if self._settings.conduct in (Conduct.IGNORES, Conduct.SILENT):
            negotiation = negotiate.sailing_on(negotiation)
        period.negotiation = negotiation
        period.phase = Phase.DONE
        period.resent = now
        intention = self._intention(period, negotiation)
        outbox.append(intention)
        plan = intention.trajectory
        if self._settings.conduct is Conduct.BREAKS_PROMISES:  # after it has promised
            negotiation = negotiate.sailing_on(negotiation)
            plan = negotiation.told()
        controls = negotiation.plan.controls
        stopped = bool(fallback) and not controls[:, 1].any()
        self._last_controls = None if stopped else controls  # a ship that stopped starts anew from sailing on
        self._last_offset = float(controls[0, 0])
        if negotiation.stance is not None:
            self._memory = negotiate.remembered(negotiation.stance, negotiation.plan)
        decision = Decision(
            offset=float(controls[0, 0]),
            speed_factor=float(controls[0, 1]),
            ruleset=period.own.ruleset,
            plan=plan,
            settlements=period.settlements,
            openings=tuple(period.openings),
            outcome="" if negotiation.worst.usable else negotiation.worst.value,
            fallback=fallback,
            update_ms=tuple(1000.0 * seconds for seconds in negotiation.seconds),
            residuals=negotiation.residuals,
            saw=period.saw,
        )
        wake_at = now + self._settings.timers.resend
        return Step(outbox=tuple(outbox), wake_at=wake_at, decision=decision)

    def _rest(self, now: float, period: Period, outbox: list[Message]) -> Step:
        """Wait for the end of a window, or, when done, repeat the promise to those that still need it."""
        timers = self._settings.timers
        if period.phase is Phase.LISTENING:
            return Step(outbox=tuple(outbox), wake_at=period.began + timers.listen)
        if period.phase is Phase.SETTLING:
            return Step(outbox=tuple(outbox), wake_at=period.began + timers.settle)
        if period.decided >= period.talking or now >= period.began + timers.deadline:
            return Step(outbox=tuple(outbox))
        if now >= period.resent + timers.resend and period.negotiation is not None:
            period.resent = now
            outbox.append(self._intention(period, period.negotiation))
        return Step(outbox=tuple(outbox), wake_at=period.resent + timers.resend)

    def _intention(self, period: Period, negotiation: Negotiation) -> Intention:
        decided = period.phase is Phase.DONE
        if self._settings.conduct is Conduct.IGNORES:
            negotiation = negotiate.sailing_on(negotiation)
        return Intention(self.ship.id, period.index, negotiation.iteration, negotiation.told(), decided)
