"""How the ships of a scenario judge one another at its start: what `graph` and `explain` show."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

from ccas_core.priority import LIGHTEST_FIRST, PriorityGraph, Settlement, settle
from ccas_core.ships import ShipId
from ccas_core.sim.start import world_at_start
from ccas_core.tapd.assign import judged
from ccas_core.tapd.ruleset import AbstractRuleset, Situation
from ccas_core.verdict import Kind
from ccas_core.world import World

__all__ = ["graph_at_start", "masses_of", "meets", "settlements_at_start", "world_at_start"]


def settlements_at_start(world: World, rulesets: Mapping[str, AbstractRuleset]) -> tuple[Settlement, ...]:
    """Settle every pair, also those that do not meet; each ship judges by the ruleset where it is."""
    situation = Situation(world=world)
    masses = masses_of(world)

    def views(own: ShipId, other: ShipId) -> Settlement:
        ruleset, theirs = (rulesets[world.reports[ship].ruleset] for ship in (own, other))
        mine, answer = judged(ruleset, situation, own, other), judged(theirs, situation, other, own)
        return settle(mine, answer, masses)

    return tuple(views(own, other) for own, other in combinations(sorted(world.reports), 2))


def graph_at_start(world: World, rulesets: Mapping[str, AbstractRuleset]) -> PriorityGraph:
    """Priority graph that the ships make of their verdicts."""
    met = (each for each in settlements_at_start(world, rulesets) if meets(each))
    ranks = {id_: rulesets[report.ruleset].rank(report.ship) for id_, report in world.reports.items()}
    criteria = {rulesets[report.ruleset].criterion for report in world.reports.values()}
    return PriorityGraph(
        masses=masses_of(world),
        settlements=tuple(met),
        ranks=ranks,
        criterion=" or ".join(sorted(criteria)) or LIGHTEST_FIRST,
    )


def meets(settlement: Settlement) -> bool:
    """Whether one of the two ships sees an encounter."""
    return (settlement.one.kind, settlement.other.kind) != (Kind.NONE, Kind.NONE)


def masses_of(world: World) -> dict[ShipId, float]:
    """Displacement of every ship [kg]."""
    return {id_: report.ship.mass for id_, report in world.reports.items()}
