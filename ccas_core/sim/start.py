"""The world at the start of a scenario: what every ship reports before any of them has moved."""

from __future__ import annotations

from ..waterway import guiding_line
from ..world import ShipReport, World
from .scenario import Scenario


def world_at_start(scenario: Scenario) -> World:
    """Chart and reports of all ships, before any of them has moved."""
    reports = {}
    for plan in scenario.ships:
        line = guiding_line(scenario.waters, plan.route)
        leg = line.leg_at(line.frame.to_path(plan.start).x)
        reports[plan.ship.id] = ShipReport(
            ship=plan.ship,
            pose=plan.start,
            speed=plan.speed,
            waterway=leg.waterway,
            towards=leg.towards,
            ruleset=scenario.waters.ruleset_at(plan.start),
        )
    return World(time=0.0, waters=scenario.waters, reports=reports)
