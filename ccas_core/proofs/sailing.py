"""Ships that show a fault as files: a scenario that can be sailed, and an encounter file.

A scenario is kept only if the ships, on its chart, judge one another as they did without one: it is written,
read back, and judged at its start.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ..errors import InputError
from ..ships import ShipId
from ..sim.case_scenario import scenario_of
from ..sim.scenario import Scenario
from ..sim.scenario_dump import dump_scenario
from ..sim.scenario_file import parse_scenario
from ..sim.start import world_at_start
from ..tapd.assign import judged
from ..tapd.case_dump import case_tree, flow
from ..tapd.case_run import judge_case, told
from ..tapd.cases import Case
from ..tapd.ruleset import PairRuleset, Situation
from ..tapd.vocabulary import VOCABULARY, Vocabulary
from ..verdict import Verdict
from ..yaml_nodes import written
from .search import Ships


def sailed(
    ships: Ships,
    rulesets: Mapping[ShipId, PairRuleset],
    name: str,
    title: str = "",
    description: str = "",
    vocabulary: Vocabulary = VOCABULARY,
) -> str | None:
    """Text of a scenario file in which the ships judge as they should; None where there is none.

    `rulesets` are those by which each ship judges.
    """
    try:
        case = replace(ships.case, id=name, title=title)
        ids = {ship.id: rulesets[ship.id].id for ship in case.ships if ship.id in rulesets}
        text = dump_scenario(scenario_of(case, ids, description), vocabulary)
        read = parse_scenario(text, vocabulary=vocabulary)
    except (ValueError, InputError):
        return None
    return text if not _differs(read, ships, rulesets) else None


def _differs(scenario: Scenario, ships: Ships, rulesets: Mapping[ShipId, PairRuleset]) -> bool:
    """Whether on the chart a ship has another verdict than it should."""
    situation = Situation(world=world_at_start(scenario))
    for view in ships.verdicts:
        here = judged(rulesets[view.own], situation, view.own, view.other)
        if _said(here) != _said(view):
            return True
    return False


def _said(view: Verdict) -> tuple[object, ...]:
    return view.kind, view.rule, view.geometry, view.initiator, view.passing_side


def encounter_file(
    ships: Ships,
    rulesets: Mapping[ShipId, PairRuleset],
    name: str,
    title: str,
    vocabulary: Vocabulary = VOCABULARY,
) -> str:
    """Text of an encounter file with the ships, and with what the rulesets say of them now."""
    tree = case_tree(replace(ships.case, id=name, title=title), {}, vocabulary)
    tree["expected"] = {each.id: _expected(each, ships.case) for each in rulesets.values()}
    lines = ["schema_version: 1", "cases:"]
    for key, value in tree.items():
        lead = "- " if len(lines) == 2 else "  "
        if key in ("ships", "expected"):
            lines += [f"{lead}{key}:", *(f"    {written(k)}: {flow(v)}" for k, v in value.items())]
        else:
            lines.append(f"{lead}{key}: {flow(value)}")
    return "\n".join(lines) + "\n"


def _expected(ruleset: PairRuleset, case: Case) -> dict[str, Any]:
    found = judge_case(ruleset, case)
    if len(case.ships) == 2:
        view = told(found)
        keys = ("kind", "give_way", "stand_on", "pass", "initiator", "article")
        plain = {key: view[key] for key in keys if view[key] is not None and view[key] != ""}
        return {**plain, "confidence": "derived"}
    return {
        "diagnosis": found.diagnosis,
        "gives_way_to": [list(pair) for pair in sorted(found.gives_way_to)],
        "confidence": "derived",
    }
