"""`ccas explain`: the verdicts of both ships of a pair, each with its rule, its article and its facts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from ccas_core.errors import Diagnostic, InputError, did_you_mean

from . import inputs, talk

if TYPE_CHECKING:
    from ccas_core.priority import PriorityGraph, Settlement
    from ccas_core.ships import FactValue
    from ccas_core.verdict import Verdict


def explain(
    context: typer.Context,
    scenario: inputs.ScenarioName,
    pair: Annotated[
        tuple[str, str] | None,
        typer.Option("--pair", metavar="A B", help="Two ships; else all pairs.", show_default=False),
    ] = None,
    ruleset: inputs.RulesetId = None,
    as_json: talk.AsJson = False,
) -> None:
    """Explain who gives way to whom at the start of a scenario, pair by pair.

    Both ships of a pair judge for themselves. Told are both verdicts, each with its rule, its article,
    the reason in words and the facts that it rests on, and what the two make of them. With --json a pair
    has the keys of a line of `decisions.jsonl`.

    Example:
        ccas explain tran2026/fig_12 --pair ship_1 ship_2
    """
    from .start import graph_at_start, settlements_at_start, world_at_start

    plugins = inputs.load_plugins(context)
    found = inputs.read_scenario(scenario, plugins, ruleset)
    world = world_at_start(found)
    wanted = _checked(pair, sorted(world.reports)) if pair else None
    settlements = [
        each for each in settlements_at_start(world, plugins.rulesets) if wanted in (None, set(each.pair))
    ]
    if as_json:
        talk.show_json(_as_json(settlements, graph_at_start(world, plugins.rulesets)))
        return
    if not settlements:
        talk.show("one ship alone meets nobody")
    for number, settlement in enumerate(settlements):
        if number:
            talk.show("")
        _show(settlement)


def _checked(pair: tuple[str, str], known: Sequence[str]) -> set[str]:
    for ship in pair:
        if ship not in known:
            hint = did_you_mean(ship, known)
            raise InputError(Diagnostic(source="--pair", message=f"unknown ship '{ship}'", hint=hint))
    if pair[0] == pair[1]:
        raise InputError(Diagnostic(source="--pair", message=f"'{pair[0]}' twice", expected="two ships"))
    return set(pair)


def _as_json(settlements: Sequence[Settlement], graph: PriorityGraph) -> object:
    """Tell pairs as `decisions.jsonl` does."""
    from ccas_core.sim.frame import Frame
    from ccas_core.sim.metrics import plain
    from ccas_core.sim.run_folder import decision

    frame = Frame(
        index=0,
        time=0.0,
        ships={},
        settlements=graph.settlements,
        openings=graph.openings,
        generations=graph.generations(),
        arrived={},
    )
    return plain([decision(settlement, frame) for settlement in settlements])


def _show(settlement: Settlement) -> None:
    views = settlement.one, settlement.other
    talk.show(f"{' and '.join(settlement.pair)}: {_outcome(settlement)}")
    for view in views:
        source = f", {view.article} ({view.citation.confidence})" if view.citation else ""
        side = f", to pass {view.passing_side}" if view.passing_side else ""
        talk.show(f"  {view.own} judges: {view.kind}{side}")
        talk.show(f"    by {view.ruleset} {view.version}, rule {view.rule or 'none'}{source}")
        if view.reason:
            talk.show(f"    because {view.reason}")
    rows = _fact_rows(*views)
    if rows:
        talk.show("")
        talk.show_table(("fact", f"as {views[0].own} sees it", f"as {views[1].own} sees it"), rows)


def _outcome(settlement: Settlement) -> str:
    view = settlement.one
    if settlement.fallback:
        edge = settlement.edge
        first = f", {edge.first} decides first" if edge else ""
        return f"both give way by the safe mutual rule{first}, because {settlement.fallback}"
    if not view.give_way:
        return "no encounter" if view.kind == "none" else view.kind.value
    stands_on = f", {view.stand_on[0]} stands on" if view.stand_on else ""
    verb = "gives way" if len(view.give_way) == 1 else "give way"
    return f"{view.geometry}: {' and '.join(view.give_way)} {verb}{stands_on}"


def _fact_rows(one: Verdict, other: Verdict) -> list[tuple[str, str, str]]:
    names = dict.fromkeys((*one.facts, *other.facts))
    return [(name, _fact(one.facts.get(name)), _fact(other.facts.get(name))) for name in names]


def _fact(value: FactValue | None) -> str:
    """Fact as a person reads it.

    >>> _fact(True), _fact(12.3456), _fact(None)
    ('yes', '12.3', '')
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.1f}"
    return "" if value is None else str(getattr(value, "value", value))
