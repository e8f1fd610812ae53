"""The priority assignment of one ship, Algorithm 1: a verdict on every ship it knows of.

The rules themselves are a ruleset's, and which ruleset that is goes by the law of each pair.  A ruleset that
raises, or says nothing where it should, gives a verdict of `conflict`, so that the safe mutual rule applies
and the log says why.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from ..regions import Law
from ..ships import ShipId
from ..verdict import Kind, Verdict
from .aboard import Aboard, judging
from .encounters import Encounter, remember
from .ruleset import AbstractRuleset, Pair, Situation

FAILED: Final = "the ruleset failed: "  # begins the reason of a verdict that stands for what a ruleset raised


def assign(ruleset: AbstractRuleset, situation: Situation, own: ShipId) -> tuple[Verdict, ...]:
    """Judge every other ship from the side of `own`, in the order of ids."""
    others = sorted(ship for ship in situation.world.reports if ship != own)
    return tuple(judged(ruleset, situation, own, other) for other in others)


def assign_by_law(rulesets: Aboard, situation: Situation, own: ShipId) -> tuple[Verdict, ...]:
    """Judge every other ship by the law of the pair, in the order of ids."""
    everywhere = situation.world.waters.laws.everywhere
    if everywhere is None:
        others = sorted(ship for ship in situation.world.reports if ship != own)
        return tuple(judged_by_law(rulesets, situation, own, other) for other in others)
    ruleset = judging(rulesets, everywhere)
    verdicts = assign(ruleset, situation, own)
    if everywhere.is_met_by(ruleset.id, ruleset.version):  # as a rule
        return verdicts
    return tuple(_without(everywhere, verdict) for verdict in verdicts)


def judged_by_law(rulesets: Aboard, situation: Situation, own: ShipId, other: ShipId) -> Verdict:
    """Judge one pair by its law; a ship that has not got it judges by what it has, and says so."""
    law = situation.law(own, other)
    ruleset = judging(rulesets, law)
    verdict = judged(ruleset, situation, own, other)
    return verdict if law.is_met_by(ruleset.id, ruleset.version) else _without(law, verdict)


def _without(law: Law, verdict: Verdict) -> Verdict:
    """Say that a verdict is not by the law of the pair."""
    return replace(verdict, lacks=str(law))


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


def remembered(situation: Situation, mine: Verdict, theirs: Verdict | None = None) -> tuple[Pair, Encounter]:
    """Carry the memory of a pair on by a period, given one of its views, and the other if it was heard.

    Ships that have judged by two laws forget what law they had, and look anew at where they meet: so they
    come together again, whatever one of them has not heard.
    """
    own, other = mine.own, mine.other
    agreed = theirs is None or (mine.ruleset, mine.version) == (theirs.ruleset, theirs.version)
    one_for_all = situation.world.waters.laws.everywhere  # then there is no law to remember
    law = situation.law(own, other) if agreed and not one_for_all else None
    after = remember(situation.encounter(own, other), situation.facts(own, other), mine, law)
    return (min(own, other), max(own, other)), after
