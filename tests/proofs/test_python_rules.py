"""Rules in plain Python: each way through them is proved about, or they are said to be tested only."""

from __future__ import annotations

import math
from datetime import date

from ccas_core.plugins import load
from ccas_core.proofs.check import check
from ccas_core.proofs.findings import Finding, Outcome
from ccas_core.tapd.python_rules import Decide, PairView, PythonRule, RoleDecision
from ccas_core.tapd.ruleset_file import parse_ruleset

TEXT = """\
schema: ccas/ruleset@1
id: x
version: 1.0.0
title: One rule in Python
extends: common
regulation: {name: X, version: "1"}
rules:
  - id: py
    python: rule
    cite: {article: "1", confidence: derived}
otherwise: {cite: {article: "0", confidence: derived}}
"""


def shorter_gives_way(pair: PairView) -> RoleDecision | str | None:
    if pair.geometry == "none" or not pair.risk_of_collision:
        return None
    return RoleDecision("give_way", because="shorter") if pair.own.length < pair.other.length else None


def not_longer_gives_way(pair: PairView) -> RoleDecision | str | None:
    if pair.risk_of_collision and pair.own.length <= pair.other.length and pair.tcpa < 300:
        return "give_way"
    return None


def by_a_library(pair: PairView) -> RoleDecision | str | None:
    return "give_way" if math.sqrt(pair.own.length) < 3.0 else None


def consistent(rule: Decide) -> Finding:
    ruleset = parse_ruleset(
        TEXT, "x.yaml", load().rulesets.text_of, python={"rule": PythonRule("rule", rule)}
    )
    (found,) = check(ruleset, today=date(2026, 1, 1), only=["consistent"])
    return found


def test_each_way_through_a_rule_is_proved_about() -> None:
    assert consistent(shorter_gives_way).outcome is Outcome.PROVED


def test_ships_that_refute_a_rule_are_judged_by_it_as_it_runs() -> None:
    found = consistent(not_longer_gives_way)

    assert found.outcome is Outcome.REFUTED
    (fault,) = found.faults
    assert fault.ships is not None
    assert len({ship.facts["length"] for ship in fault.ships.case.ships}) == 1


def test_what_cannot_be_followed_is_told() -> None:
    found = consistent(by_a_library)

    assert found.outcome is Outcome.UNDECIDED
    assert any("py" in note for note in found.notes)
