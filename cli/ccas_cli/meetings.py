"""Two ships that meet, with all that an explanation needs: from a scenario, or from a case."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING, Any

from ccas_core.errors import Diagnostic, InputError, did_you_mean

if TYPE_CHECKING:
    from ccas_core.plugins import Plugins
    from ccas_core.priority import PriorityGraph, Settlement
    from ccas_core.ships import ShipId
    from ccas_core.sim.scenario import Scenario
    from ccas_core.tapd.aboard import Aboard
    from ccas_core.tapd.cases import Case
    from ccas_core.tapd.facts import PairFacts
    from ccas_core.tapd.ruleset import AbstractRuleset, PairRuleset, Situation


@dataclass(frozen=True, slots=True, kw_only=True)
class Side:
    """What one ship judges by: its ruleset, and the facts as it sees them.

    `fresh` are the facts without what is stated or remembered of the encounter: what a manoeuvre would
    change.
    """

    ruleset: AbstractRuleset
    facts: PairFacts
    fresh: PairFacts
    is_remembered: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Meeting:
    """Two ships, how they judge one another, and what that rests on.

    `told` is the decision as `decisions.jsonl` has it.  `sides` is empty where nothing but that is known.
    """

    pair: tuple[ShipId, ShipId]
    settlement: Settlement | None
    sides: Mapping[ShipId, Side]
    told: Mapping[str, Any]
    about: Mapping[str, Any] = field(default_factory=dict)  # more keys for JSON
    heading: str = ""
    notes: tuple[str, ...] = ()


def checked(pair: tuple[str, str] | None, known: Sequence[str]) -> set[str] | None:
    """Two ships that are asked about; none where all are.

    Raises
    ------
    InputError
        If one of them is not known, or they are one.
    """
    if pair is None:
        return None
    for ship in pair:
        if ship not in known:
            hint = did_you_mean(ship, known)
            raise InputError(Diagnostic(source="--pair", message=f"unknown ship '{ship}'", hint=hint))
    if pair[0] == pair[1]:
        raise InputError(Diagnostic(source="--pair", message=f"'{pair[0]}' twice", expected="two ships"))
    return set(pair)


def of_scenario(scenario: Scenario, plugins: Plugins, pair: tuple[str, str] | None) -> list[Meeting]:
    """Pairs at the start of a scenario."""
    from ccas_core.sim.start import graph_at_start, rulesets_aboard, settlements_at_start, world_at_start
    from ccas_core.tapd.ruleset import Situation

    world = world_at_start(scenario)
    wanted = checked(pair, sorted(world.reports))
    graph = graph_at_start(scenario, plugins.rulesets)
    carried = rulesets_aboard(scenario, plugins.rulesets)
    situation = Situation(world=world)
    return [
        in_situation(settlement, situation, situation, carried, graph)
        for settlement in settlements_at_start(scenario, plugins.rulesets)
        if wanted in (None, set(settlement.pair))
    ]


def in_situation(
    settlement: Settlement,
    now: Situation,
    fresh: Situation,
    carried: Mapping[ShipId, Aboard],
    graph: PriorityGraph,
) -> Meeting:
    """Two ships on a chart; `fresh` is the situation without what is remembered."""
    from ccas_core.tapd.aboard import judging

    one, other = settlement.pair
    sides = {}
    for own, target in ((one, other), (other, one)):
        ruleset = judging(carried[own], now.law(own, target))
        facts = now.facts(own, target, ruleset.vocabulary)
        anew = facts if now is fresh else fresh.facts(own, target, ruleset.vocabulary)
        known = now.encounter(own, target).lasts
        sides[own] = Side(ruleset=ruleset, facts=facts, fresh=anew, is_remembered=known)
    told = as_decision(settlement, graph, now.world.time)
    return Meeting(pair=settlement.pair, settlement=settlement, sides=sides, told=told)


def as_decision(settlement: Settlement, graph: PriorityGraph, time: float) -> dict[str, Any]:
    """Tell a pair as `decisions.jsonl` does."""
    from ccas_core.sim.frame import Frame
    from ccas_core.sim.metrics import plain
    from ccas_core.sim.run_folder import decision

    frame = Frame(
        index=0,
        time=time,
        ships={},
        settlements=graph.settlements,
        openings=graph.openings,
        generations=graph.generations(),
        arrived={},
    )
    told: Any = plain(decision(settlement, frame))
    return dict(told)


def of_case(case: Case, rulesets: Iterable[PairRuleset], pair: tuple[str, str] | None) -> Iterator[Meeting]:
    """Pairs of a case, under each ruleset."""
    from ccas_core.priority import PriorityGraph
    from ccas_core.tapd.case_report import wanted as wanted_of
    from ccas_core.tapd.case_run import judge_case, pair_facts, run_case

    ids = [ship.id for ship in case.ships]
    asked = checked(pair, ids)
    bare = _without_encounter(case)
    for ruleset in rulesets:
        judged = judge_case(ruleset, case)
        masses = {ship.id: float(ship.facts.get("weight", 1.0)) for ship in case.ships}
        graph = PriorityGraph(masses=masses, settlements=judged.settlements)
        expected = case.expected.get(ruleset.id)
        about: dict[str, Any] = {"case": case.id, "ruleset": ruleset.id}
        notes: tuple[str, ...] = ()
        if expected is not None:
            result = run_case(ruleset, case, expected)
            about |= {"expected": wanted_of(expected), "passed": result.passed}
            notes = result.differences or ("as expected",)
        for settlement, (one, other) in zip(judged.settlements, combinations(ids, 2), strict=True):
            if asked not in (None, {one, other}):
                continue
            sides = {}
            for own, target in ((one, other), (other, one)):
                facts = pair_facts(case, own, target, ruleset.vocabulary)
                fresh = pair_facts(bare, own, target, ruleset.vocabulary)
                sides[own] = Side(ruleset=ruleset, facts=facts, fresh=fresh)
            yield Meeting(
                pair=settlement.pair,
                settlement=settlement,
                sides=sides,
                told=as_decision(settlement, graph, 0.0),
                about=about,
                heading=f"{case.id} under {ruleset.id}: {case.title}" if case.title != case.id else case.id,
                notes=notes,
            )


def _without_encounter(case: Case) -> Case:
    from dataclasses import replace

    return replace(case, encounter={})
