"""The start of a scenario: what ships report before any of them has moved, and how they judge one another."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

from ..priority import LIGHTEST_FIRST, PriorityGraph, Settlement, settle
from ..regions import Law
from ..ships import ShipId
from ..tapd.aboard import Aboard, aboard, judging
from ..tapd.assign import judged_by_law
from ..tapd.ruleset import AbstractRuleset, Situation
from ..verdict import Kind
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


def rulesets_aboard(scenario: Scenario, rulesets: Mapping[str, AbstractRuleset]) -> dict[ShipId, Aboard]:
    """Rulesets that each ship of a scenario has aboard."""
    return {plan.ship.id: aboard(rulesets, plan.rulesets) for plan in scenario.ships}


def settlements_at_start(
    scenario: Scenario, rulesets: Mapping[str, AbstractRuleset]
) -> tuple[Settlement, ...]:
    """Settle every pair, also those that do not meet."""
    world = world_at_start(scenario)
    situation = Situation(world=world)
    carried = rulesets_aboard(scenario, rulesets)
    masses = _masses(world)

    def settled(own: ShipId, other: ShipId) -> Settlement:
        mine = judged_by_law(carried[own], situation, own, other)
        return settle(mine, judged_by_law(carried[other], situation, other, own), masses)

    return tuple(settled(own, other) for own, other in combinations(sorted(world.reports), 2))


def graph_at_start(scenario: Scenario, rulesets: Mapping[str, AbstractRuleset]) -> PriorityGraph:
    """Priority graph that the ships make of their verdicts."""
    world = world_at_start(scenario)
    carried = rulesets_aboard(scenario, rulesets)
    own = {id_: judging(carried[id_], Law(report.ruleset)) for id_, report in world.reports.items()}
    return PriorityGraph(
        masses=_masses(world),
        settlements=tuple(filter(meets, settlements_at_start(scenario, rulesets))),
        ranks={id_: own[id_].rank(report.ship) for id_, report in world.reports.items()},
        criterion=" or ".join(sorted({each.criterion for each in own.values()})) or LIGHTEST_FIRST,
    )


def meets(settlement: Settlement) -> bool:
    """Whether one of the two ships sees an encounter."""
    return (settlement.one.kind, settlement.other.kind) != (Kind.NONE, Kind.NONE)


def _masses(world: World) -> dict[ShipId, float]:
    return {id_: report.ship.mass for id_, report in world.reports.items()}
