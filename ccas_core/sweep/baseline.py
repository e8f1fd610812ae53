"""A case beside the centralised baseline: whether a free answer exists, and the price of distribution."""

from __future__ import annotations

import time
from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np

from ..dmpc.clearance import gaps
from ..dmpc.joint import JointAnswer, JointShip, joint_cost, solve_jointly
from ..dmpc.parameters import FAITHFUL, Settings
from ..frames import FloatArray, PathTrajectory
from ..sim.frame import Frame
from ..sim.scenario import Scenario
from ..sim.voyage import chosen, voyage
from ..waterway import guiding_line
from .case import Case, scenario
from .task import Program, rulesets, solver


def compare(case: Case, sent_by: Program) -> dict[str, Any]:
    """Sail a case, solve it jointly at its beginning, and compare over one horizon.

    `free` says whether the joint answer keeps all hulls out of all safety areas; the costs are those of the
    joint problem, for its answer and for the controls that the ships have sailed.
    """
    began = time.perf_counter()
    known = rulesets(sent_by)
    sailed = scenario(case, known)
    frames = tuple(voyage(sailed, known, solver(case.solver)))
    settings = chosen(FAITHFUL, sailed.control, sailed.time_step)
    ships = joint_ships(sailed, settings)
    own = sailed_controls(sailed, frames, settings.horizon)
    nominal = np.tile([0.0, 1.0], (len(ships), settings.horizon, 1))
    answer = solve_jointly(ships, settings, [nominal, own])
    return {
        "free": is_free(ships, answer),
        "joint_cost": answer.objective,
        "sailed_cost": joint_cost(ships, settings, own).objective,
        "converged": answer.converged,
        "seconds": time.perf_counter() - began,
    }


def joint_ships(sailed: Scenario, settings: Settings) -> tuple[JointShip, ...]:
    """Ships of a scenario at its beginning."""
    ships = []
    for plan in sailed.ships:
        line = guiding_line(sailed.waters, plan.route)
        initial = line.frame.to_path(plan.start)
        ahead = initial.x + plan.speed * settings.kinematics.time_step * np.arange(settings.horizon)
        limits = np.array([line.offset_limits(float(x), plan.ship.hull.beam) for x in ahead])
        ships.append(
            JointShip(
                hull=plan.ship.hull,
                frame=line.frame,
                initial=initial,
                speed=plan.speed,
                offset_limits=limits,
            )
        )
    return tuple(ships)


def sailed_controls(sailed: Scenario, frames: Sequence[Frame], horizon: int) -> FloatArray:
    """Controls of all ships over one horizon, (ships, N, 2); a ship that has arrived sails on."""
    controls = np.tile([0.0, 1.0], (len(sailed.ships), horizon, 1))
    for k, frame in enumerate(frames[:horizon]):
        for n, plan in enumerate(sailed.ships):
            ship = frame.ships.get(plan.ship.id)
            if ship is not None and plan.ship.id not in frame.arrived:
                controls[n, k] = ship.offset, ship.speed_factor
    return controls


def is_free(ships: Sequence[JointShip], answer: JointAnswer) -> bool:
    """Whether no hull enters a safety area."""
    for n, m in combinations(range(len(ships)), 2):
        one, other = ships[n], ships[m]
        there = one.frame.trajectory_to_path(other.frame.trajectory_to_ned(PathTrajectory(answer.paths[m])))
        if float(gaps(one.hull, answer.paths[n][None], other.hull, there.poses).min()) < 0.0:
            return False
    return True
