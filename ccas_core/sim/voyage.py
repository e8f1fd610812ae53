"""The simulator: a scenario in, an iterator of frames out.  Stopping is not asking for more."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from ..agent.bus import Bus
from ..agent.events import AgentSettings, Decision
from ..agent.period import PeriodLog, run_period
from ..agent.reach import FORESIGHT, neighbours, reach, separation
from ..controllers import COOPERATIVE, AbstractController
from ..dmpc.parameters import FAITHFUL, PROFILES, Settings, with_parameter
from ..dmpc.solvers import AbstractLocalSolver
from ..frames import NedTrajectory, frozen_array
from ..priority import Opening, Settlement
from ..roles import Geometry
from ..ships import ShipId
from ..tapd.ruleset import AbstractRuleset
from ..waterway import guiding_line
from .frame import Frame, ShipFrame
from .guidance import Command
from .scenario import ControlChoice, Profile, Scenario
from .under_way import UnderWay, command_of, launched, moved
from .vessel import KinematicVessel

PERIODS_ALLOWED = 21  # a run ends so many periods after each ship's undisturbed arrival


def voyage(
    scenario: Scenario,
    rulesets: Mapping[str, AbstractRuleset],
    solver: AbstractLocalSolver,
    controllers: Mapping[str, AbstractController] | None = None,
) -> Iterator[Frame]:
    """Sail a scenario, a frame a control period.

    The first frame stands at time 0.  The voyage ends with the frame in which the last ship has arrived, or
    at the latest `PERIODS_ALLOWED` periods after the last undisturbed arrival.

    Parameters
    ----------
    scenario
        What is sailed.
    rulesets
        By id; all that the waters and the ships name are needed.
    solver
        Of the local problems.
    controllers
        Of plugins, by name; all that ships are steered by are needed.

    Raises
    ------
    ScenarioError
        If a ship is to be steered by a controller that is not there.
    """
    settings = agent_settings(scenario)
    vessel = KinematicVessel(next(iter(settings.profiles.values())).kinematics)
    ships = {
        plan.ship.id: launched(scenario, plan, rulesets, settings, controllers or {})
        for plan in scenario.ships
    }
    apart = separation(settings.profiles.values(), [plan.ship.hull for plan in scenario.ships])
    ahead = max(FORESIGHT, scenario.time_step * scenario.control.horizon)
    bus = Bus(loss=scenario.bus.loss, delay=scenario.bus.delay, seed=scenario.bus.seed)
    limit = periods_limit(scenario)
    arrived: dict[ShipId, float] = {}
    index = 0
    while True:
        time = index * scenario.time_step
        ships = {id_: ship for id_, ship in ships.items() if not ship.is_gone(time)}
        under_way = {id_: ship for id_, ship in ships.items() if not ship.is_over}
        sensed = {id_: ship.sensed(index, time) for id_, ship in under_way.items()}
        agents = {id_: ship.agent for id_, ship in under_way.items()}
        reaches = {
            id_: reach(ship.line, ship.pose.x, ship.plan.speed, ahead) for id_, ship in under_way.items()
        }
        log = run_period(agents, bus, solver, sensed, time, neighbours(reaches, apart))
        commands = {id_: command_of(ships[id_], decision) for id_, decision in log.decisions.items()}
        yield _frame(index, time, ships, commands, log, arrived)
        if index >= limit or not (under_way or time < scenario.duration):
            return
        sailed = {}
        for id_, ship in under_way.items():
            motion = log.decisions[id_].motion
            sailed[id_] = moved(ship, commands[id_], motion, vessel, scenario, time)
            if sailed[id_].is_over:
                share = (ship.line.frame.length - ship.pose.x) / (sailed[id_].pose.x - ship.pose.x)
                arrived[id_] = time + share * scenario.time_step
        ships = sailed
        index += 1


def agent_settings(scenario: Scenario) -> AgentSettings:
    """Settings of every ship's agent: the two profiles of Sec. 5 with what the scenario overrides."""
    control = scenario.control
    profiles = {
        geometry: chosen(
            FAITHFUL if control.profile is Profile.AUTO else profile, control, scenario.time_step
        )
        for geometry, profile in PROFILES.items()
    }
    profile = None if control.profile is Profile.AUTO else Geometry(control.profile.value)
    return AgentSettings(profiles=profiles, profile=profile, deadlock_detection=control.deadlock_detection)


def chosen(profile: Settings, control: ControlChoice, time_step: float) -> Settings:
    """Override a profile by the `control` block of a scenario."""
    settings = replace(
        profile,
        horizon=control.horizon,
        iterations=control.iterations,
        kinematics=replace(profile.kinematics, time_step=time_step),
        wait=control.wait or profile.wait,
        starts=control.starts or profile.starts,
    )
    if control.risk_shape is not None:
        settings = replace(settings, risk=replace(settings.risk, shape=control.risk_shape))
    for name, value in control.parameters.items():
        settings = with_parameter(settings, name, value)
    return settings


def undisturbed_times(scenario: Scenario) -> dict[ShipId, float]:
    """Time at which each ship would arrive if it met nobody [s]."""
    times = {}
    for plan in scenario.ships:
        frame = guiding_line(scenario.waters, plan.route).frame
        times[plan.ship.id] = (frame.length - frame.to_path(plan.start).x) / plan.speed
    return times


def periods_limit(scenario: Scenario) -> int:
    """Index of the last frame that a voyage may have."""
    slowest = math.ceil(max(undisturbed_times(scenario).values()) / scenario.time_step) + PERIODS_ALLOWED
    return max(slowest, math.ceil(scenario.duration / scenario.time_step))


def _frame(
    index: int,
    time: float,
    ships: Mapping[ShipId, UnderWay],
    commands: Mapping[ShipId, Command],
    log: PeriodLog,
    arrived: Mapping[ShipId, float],
) -> Frame:
    settled: dict[tuple[ShipId, ShipId], Settlement] = {}
    openings: list[Opening] = []
    for _, decision in sorted(log.decisions.items()):
        openings += decision.openings
        for settlement in decision.settlements:
            if settlement.pair not in settled or settlement.fallback:
                settled[settlement.pair] = settlement
    return Frame(
        index=index,
        time=time,
        ships=MappingProxyType(
            {
                id_: _ship_frame(ship, commands.get(id_), log.decisions.get(id_))
                for id_, ship in sorted(ships.items())
            }
        ),
        settlements=tuple(settled[pair] for pair in sorted(settled)),
        openings=tuple(openings),
        generations=log.generations,
        arrived=MappingProxyType(dict(arrived)),
    )


def _ship_frame(ship: UnderWay, command: Command | None, decision: Decision | None) -> ShipFrame:
    """Frame of a ship; one that has just arrived has no decision, and sails on as it is."""
    frame = ship.line.frame
    pose = frame.to_ned(ship.pose)
    here = NedTrajectory(frozen_array([[pose.x, pose.y, pose.course]]))
    if command is None or decision is None:
        return ShipFrame(
            pose=pose,
            path_x=ship.pose.x,
            path_y=ship.pose.y,
            speed=ship.speed,
            offset=0.0,
            speed_factor=1.0,
            ruleset="",
            plan=here,
            outcome="",
            fallback="",
            update_ms=(),
            residuals=(),
        )
    return ShipFrame(
        pose=pose,
        path_x=ship.pose.x,
        path_y=ship.pose.y,
        speed=command.speed_factor * ship.plan.speed if ship.plan.control.by == COOPERATIVE else ship.speed,
        offset=command.offset,
        speed_factor=command.speed_factor,
        ruleset=decision.ruleset,
        plan=decision.plan if np.isfinite(decision.plan.poses).all() else here,  # a report may fail
        outcome=decision.outcome,
        fallback=decision.fallback,
        update_ms=decision.update_ms,
        residuals=decision.residuals,
        motion=decision.motion,
        saw=decision.saw,
    )
