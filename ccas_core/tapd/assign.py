"""The priority assignment of one ship, Algorithm 1: a verdict on every ship it knows of.

The rules themselves are a ruleset's.  A ruleset that raises, or says nothing where it should, gives a
verdict of `conflict`, so that the safe mutual rule applies and the log says why.
"""

from __future__ import annotations

from typing import Final

from ..ships import ShipId
from ..verdict import Kind, Verdict
from .encounters import Encounter, remember
from .ruleset import AbstractRuleset, Pair, Situation

FAILED: Final = "the ruleset failed: "  # begins the reason of a verdict that stands for what a ruleset raised


def assign(ruleset: AbstractRuleset, situation: Situation, own: ShipId) -> tuple[Verdict, ...]:
    """Judge every other ship from the side of `own`, in the order of ids."""
    others = sorted(ship for ship in situation.world.reports if ship != own)
    return tuple(judged(ruleset, situation, own, other) for other in others)


def judged(ruleset: AbstractRuleset, situation: Situation, own: ShipId, other: ShipId) -> Verdict:
    """Judge one pair; whatever a plugin raises becomes a verdict that says so."""
    try:
        verdict = ruleset.view(situation, own, other)
        if verdict is not None and not isinstance(verdict, Verdict):
            raise TypeError(f"expected a Verdict, got {type(verdict).__name__}")
        if verdict is not None and (verdict.own, verdict.other) != (own, other):
            raise ValueError(f"expected a verdict of {own} on {other}, got {verdict.own} on {verdict.other}")
    except Exception as error:  # a plugin may raise anything, and no ship may be left without a verdict
        return failed(ruleset, own, other, error)
    if verdict is not None:
        return verdict
    return Verdict(
        own=own, other=other, kind=Kind.NONE, ruleset=ruleset.id, version=ruleset.version, reason="no_rule"
    )


def failed(ruleset: AbstractRuleset, own: ShipId, other: ShipId, error: Exception) -> Verdict:
    """Verdict that stands for what a ruleset raised: a conflict, so that both ships give way."""
    return Verdict(
        own=own,
        other=other,
        kind=Kind.CONFLICT,
        ruleset=ruleset.id,
        version=ruleset.version,
        reason=f"{FAILED}{type(error).__name__}: {error}",
    )


def remembered(situation: Situation, verdict: Verdict) -> tuple[Pair, Encounter]:
    """Carry the memory of a pair on by a period, given the verdict of one of its views."""
    own, other = verdict.own, verdict.other
    before = situation.encounter(own, other)
    return (min(own, other), max(own, other)), remember(before, situation.facts(own, other), verdict)
