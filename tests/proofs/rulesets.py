"""Rulesets of this folder, with a library in which they may find `common`."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from functools import cache
from pathlib import Path

from ccas_core import plugins
from ccas_core.proofs import pairs
from ccas_core.proofs.findings import Finding
from ccas_core.proofs.questions import Questions
from ccas_core.proofs.solver import Budget
from ccas_core.tapd.written import WrittenRuleset

BROKEN = Path(__file__).parent / "broken"
BUDGET = 20.0  # for one property [s]


@cache
def installed() -> plugins.Plugins:
    """All plugins."""
    return plugins.load()


@cache
def broken(name: str) -> WrittenRuleset:
    """A ruleset of `broken/`."""
    ruleset = installed().rulesets.loaded(BROKEN / f"{name}.yaml")
    assert isinstance(ruleset, WrittenRuleset)
    return ruleset


@cache
def shipped(name: str) -> WrittenRuleset:
    """A ruleset that is installed."""
    ruleset = installed().ruleset(name)
    assert isinstance(ruleset, WrittenRuleset)
    return ruleset


def finding(ruleset: WrittenRuleset, name: str) -> Finding:
    """What is known of a property of a ruleset."""
    budget = Budget(BUDGET)
    if name == "parameters":
        return pairs.parameters(ruleset, budget)
    if name == "acyclic":
        return _later("cycles", "acyclic")(ruleset, budget, 4)
    if name == "border":
        return _later("borders", "border")(broken("starboard_ring"), ruleset, budget)
    questions = Questions((ruleset, ruleset), budget)
    prove = _later("roles", name) if name == "role_stable" else getattr(pairs, name)
    found: Finding = prove(questions)
    return found


def _later(module: str, name: str) -> Callable[..., Finding]:
    prove: Callable[..., Finding] = getattr(importlib.import_module(f"ccas_core.proofs.{module}"), name)
    return prove
