"""A ruleset for the entrance of a harbour: departing ships give way to arriving ones."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ccas_core.hookspecs import hookimpl
from ccas_core.roles import Geometry
from ccas_core.tapd.facts import PairFacts, is_head_on
from ccas_core.tapd.ruleset import AbstractRuleset, PairRuleset
from ccas_core.verdict import Citation, Kind, Verdict
from ccas_core.waterway import Towards

ENTRANCE = "entrance"  # id of the waterway; its centreline is drawn from the sea into the harbour
MEETING_TIME = 900.0  # ships that come closest later than this do not meet yet [s]


@hookimpl
def ccas_rulesets() -> Iterable[AbstractRuleset]:
    """Return the ruleset of this plugin."""
    return (Harbour(),)


@dataclass(frozen=True, slots=True)
class Harbour(PairRuleset):
    """By-law of the harbour entrance (invented): two articles, and the radio for everything else."""

    id: str = "harbour"
    version: str = "1.0.0"
    title: str = "Harbour entrance: departing ships give way to arriving ones (sample)"

    def judge(self, facts: PairFacts) -> Verdict:
        """Judge a pair from `facts.own`'s side; the other side gets the opposite verdict."""
        if facts.encounter.geometry is Geometry.NONE and not is_head_on(facts, MEETING_TIME):
            return self._verdict(facts, Kind.NONE, "", "they do not meet")
        if facts.own.waterway != ENTRANCE or facts.other.waterway != ENTRANCE:
            return self._verdict(facts, Kind.NEGOTIATE, "art. 2", "outside the entrance ships agree by radio")
        if facts.own.towards is Towards.START:
            return self._verdict(facts, Kind.GIVE_WAY, "art. 1", "a departing ship waits for an arriving one")
        return self._verdict(facts, Kind.STAND_ON, "art. 1", "an arriving ship has the entrance")

    def _verdict(self, facts: PairFacts, kind: Kind, article: str, reason: str) -> Verdict:
        return Verdict(
            own=facts.own.id,
            other=facts.other.id,
            kind=kind,
            ruleset=self.id,
            version=self.version,
            rule=article,
            citation=Citation(regulation="Harbour by-law", article=article) if article else None,
            geometry=Geometry.HEAD_ON if article else Geometry.NONE,
            reason=reason,
        )
