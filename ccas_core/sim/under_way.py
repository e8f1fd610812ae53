"""Ships of a voyage between two periods: who decides for each, what it senses, and how it moves.

A cooperative ship moves by the paper's model along its guiding line, one under a controller by surge speed
and yaw rate, adrift with the current; a tracked ship goes where its track says, or on beside its line.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from ..agent.events import Agent, AgentSettings, Decision, Sensed
from ..agent.ship_agent import ShipAgent
from ..agent.steered_agent import Steered, SteeredAgent
from ..agent.tracked_agent import TrackedAgent
from ..controllers import COOPERATIVE, TRACKED, AbstractController
from ..errors import Diagnostic, ScenarioError, did_you_mean
from ..frames import NedPose, PathPose
from ..surge_yaw import Motion, advance, usual
from ..tapd.aboard import aboard
from ..tapd.ruleset import AbstractRuleset
from ..waterway import GuidingLine, guiding_line
from .guidance import Command, held
from .scenario import Plan, Scenario
from .vessel import AbstractVessel


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UnderWay:
    """One ship of the simulation between two periods."""

    plan: Plan
    line: GuidingLine
    pose: PathPose
    speed: float  # over ground in the last period [m/s]
    agent: Agent

    @property
    def is_over(self) -> bool:
        """Whether the ship has come to the end of its route."""
        return self.pose.x >= self.line.frame.length

    def is_gone(self, time: float) -> bool:
        """Whether a track has ended before a time [s]: nobody knows the ship any more."""
        return self.plan.track is not None and time > self.plan.track.end

    def sensed(self, index: int, time: float) -> Sensed:
        """What the ship's instruments say at the beginning of a period; those of a tracked ship may fail."""
        if self.plan.track is not None:
            return Sensed(index, *self.plan.track.reported(time))
        return Sensed(index, self.line.frame.to_ned(self.pose), self.speed)


def launched(
    scenario: Scenario,
    plan: Plan,
    rulesets: Mapping[str, AbstractRuleset],
    settings: AgentSettings,
    controllers: Mapping[str, AbstractController],
) -> UnderWay:
    """Put a ship of a scenario where it starts, with whoever decides for it.

    Raises
    ------
    ScenarioError
        If it is to be steered by a controller that nobody offers.
    """
    line = guiding_line(scenario.waters, plan.route)
    pose = plan.start if plan.track is None else plan.track.sailed(0.0)[0]
    return UnderWay(
        plan=plan,
        line=line,
        pose=line.frame.to_path(pose),
        speed=plan.speed,
        agent=_agent(scenario, plan, line, rulesets, settings, controllers),
    )


def _agent(
    scenario: Scenario,
    plan: Plan,
    line: GuidingLine,
    rulesets: Mapping[str, AbstractRuleset],
    settings: AgentSettings,
    controllers: Mapping[str, AbstractController],
) -> Agent:
    waters, by = scenario.waters, plan.control.by
    carried = aboard(rulesets, plan.rulesets)
    if by == COOPERATIVE:
        own = replace(settings, conduct=plan.conduct)
        return ShipAgent(plan.ship, line, plan.speed, waters, carried, own)
    if by == TRACKED:
        return TrackedAgent(plan.ship, line, waters)
    if by not in controllers:
        message = f"ship '{plan.ship.id}' is to be steered by '{by}', which no plugin offers"
        hint = did_you_mean(by, controllers)
        raise ScenarioError(Diagnostic(source=scenario.name, message=message, hint=hint))
    steered = Steered(
        ship=plan.ship,
        line=line,
        speed=plan.speed,
        limits=plan.limits or usual(plan.ship.hull.length, plan.speed),
        controller=controllers[by],
        options=plan.control.options,
    )
    return SteeredAgent(steered, waters, carried, scenario.time_step)


def command_of(ship: UnderWay, decision: Decision) -> Command:
    """Command that a decision gives; that of a cooperative ship is held within the banks."""
    command = Command(decision.offset, decision.speed_factor)
    if ship.plan.control.by != COOPERATIVE:
        return replace(command, offset=ship.pose.y)
    return held(command, ship.line, ship.pose.x, ship.plan.ship.hull.beam)


def moved(
    ship: UnderWay,
    command: Command,
    motion: Motion | None,
    vessel: AbstractVessel,
    scenario: Scenario,
    time: float,
) -> UnderWay:
    """Let a ship sail from a time [s] through one period."""
    step, frame = scenario.time_step, ship.line.frame
    if ship.plan.track is not None:
        there, speed = ship.plan.track.sailed(time + step)
        return replace(ship, pose=frame.to_path(there), speed=speed)
    if ship.plan.control.by == TRACKED:
        pose = PathPose(ship.pose.x + ship.plan.speed * step, ship.pose.y, 0.0)
        return replace(ship, pose=pose)
    if motion is not None:
        here = frame.to_ned(ship.pose)
        there = advance(here, motion, scenario.waters.current, step)
        return replace(ship, pose=frame.to_path(there), speed=_made_good(here, there, step))
    pose = vessel.advance(ship.pose, command, ship.plan.speed)
    return replace(ship, pose=pose, speed=math.hypot(pose.x - ship.pose.x, pose.y - ship.pose.y) / step)


def _made_good(here: NedPose, there: NedPose, time: float) -> float:
    return math.hypot(there.x - here.x, there.y - here.y) / time
