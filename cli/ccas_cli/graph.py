"""`ccas graph`: the priority graph at the start of a scenario."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from . import inputs, talk

if TYPE_CHECKING:
    from ccas_core.priority import PriorityGraph, Settlement


class Format(StrEnum):
    """How a graph is printed."""

    TEXT = "text"
    DOT = "dot"
    SVG = "svg"
    JSON = "json"


def graph(
    context: typer.Context,
    scenario: inputs.ScenarioName,
    ruleset: inputs.RulesetId = None,
    form: Annotated[
        Format,
        typer.Option(
            "--format", help="Text, Graphviz (dot), a drawing (svg), or JSON.", case_sensitive=False
        ),
    ] = Format.TEXT,
    as_json: Annotated[bool, typer.Option("--json", help="The same as --format json.")] = False,
) -> None:
    """Show who decides before whom at the start of a scenario, and why.

    An arrow from u to v says that u decides before v. A duty arrow says why: u gives way to v. An order arrow
    carries no duty. Rings of ships that wait for one another are told with the arrows that are left out to
    open them, and by which criterion.

    Example:
        ccas graph tran2026/fig_12 --format svg > fig_12.svg
    """
    from ccas_core.sim.start import graph_at_start

    plugins = inputs.load_plugins(context)
    found = inputs.read_scenario(scenario, plugins, ruleset)
    priority = graph_at_start(found, plugins.rulesets)
    if as_json or form is Format.JSON:
        talk.show_json({"scenario": found.name, "time_s": 0.0, **_as_json(priority)})
    elif form is Format.DOT:
        talk.show(_as_dot(found.name, priority))
    elif form is Format.SVG:
        from .graph_svg import as_svg

        talk.show(as_svg(found.name, priority))
    else:
        _show_text(priority)


def _edges(graph: PriorityGraph) -> list[dict[str, str]]:
    return [
        {
            "first": settlement.edge.first,
            "then": settlement.edge.then,
            "kind": settlement.edge.kind.value,
            "ruleset": settlement.one.ruleset,
            "rule": settlement.one.rule,
            "article": settlement.one.article,
            "reason": _reason(settlement),
        }
        for settlement in graph.settlements
        if settlement.edge is not None
    ]


def _reason(settlement: Settlement) -> str:
    if settlement.fallback:
        return f"safe mutual rule, because {settlement.fallback}"
    return settlement.one.reason


def _without_edge(graph: PriorityGraph) -> list[Settlement]:
    return [settlement for settlement in graph.settlements if settlement.edge is None]


def _as_json(graph: PriorityGraph) -> dict[str, object]:
    return {
        "edges": _edges(graph),
        "without_edge": [
            {
                "ships": list(each.pair),
                "kind": each.one.kind.value,
                "pass": each.one.passing_side,
                "ruleset": each.one.ruleset,
                "rule": each.one.rule,
                "article": each.one.article,
                "reason": _reason(each),
            }
            for each in _without_edge(graph)
        ],
        "generations": [list(generation) for generation in graph.generations()],
        "cycles": [list(cycle) for cycle in graph.cycles()],
        "openings": [
            {
                "first": each.edge.first,
                "then": each.edge.then,
                "kind": each.edge.kind.value,
                "criterion": each.criterion,
            }
            for each in graph.openings
        ],
    }


def _show_text(graph: PriorityGraph) -> None:
    rows = [
        (f"{each['first']} -> {each['then']}", each["kind"], each["article"], each["reason"])
        for each in _edges(graph)
    ]
    rows += [
        (" -- ".join(each.pair), each.one.kind.value, each.one.article, _reason(each))
        for each in _without_edge(graph)
    ]
    if rows:
        talk.show_table(("ships", "kind", "article", "reason"), rows)
    else:
        talk.show("no two ships meet")
    talk.show("\norder of decision: " + ", then ".join(" and ".join(each) for each in graph.generations()))
    rings = "; ".join(", ".join(cycle) for cycle in graph.cycles())
    talk.show(f"rings of ships that wait for one another: {rings or 'none'}")
    for opening in graph.openings:
        arrow = f"{opening.edge.first} -> {opening.edge.then} ({opening.edge.kind})"
        talk.show(f"left out of the order: {arrow}, by: {opening.criterion}")


def _as_dot(name: str, graph: PriorityGraph) -> str:
    """Graph in the language of Graphviz: duty solid, order dashed, left out grey, mutual without arrow."""
    opened = {(each.edge.first, each.edge.then) for each in graph.openings}
    lines = [f"digraph {_quoted(name)} {{", "  rankdir=LR;"]
    lines += [f"  {{ rank=same; {' '.join(map(_quoted, each))} }}" for each in graph.generations()]
    for edge in _edges(graph):
        ends = edge["first"], edge["then"]
        style = "solid" if edge["kind"] == "duty" else "dashed"
        colour = "grey" if ends in opened else "black"
        label = _quoted(edge["article"] or edge["kind"])
        lines.append(f"  {' -> '.join(map(_quoted, ends))} [label={label}, style={style}, color={colour}];")
    for each in _without_edge(graph):
        label = _quoted(each.one.article or each.one.kind.value)
        lines.append(f"  {' -> '.join(map(_quoted, each.pair))} [label={label}, dir=none, constraint=false];")
    return "\n".join([*lines, "}"])


def _quoted(text: str) -> str:
    r"""Text as Graphviz reads it.

    >>> print(_quoted('a "b"'))
    "a \"b\""
    """
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
