"""What a ruleset is: something that emits a priority graph for a situation.

Most rulesets judge pairs; for them `PairRuleset` assembles the graph.  A ruleset may also emit a
whole graph, say the order given by a traffic centre.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations
from types import MappingProxyType

from ..priority import PriorityGraph, settle
from ..ships import ShipId
from ..verdict import Kind, Verdict
from ..world import World
from .encounters import NO_ENCOUNTER, Encounter
from .facts import PairFacts, assess

Pair = tuple[ShipId, ShipId]  # sorted


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Situation:
    """The world now, and what is remembered of every pair's encounter."""

    world: World
    encounters: Mapping[Pair, Encounter] = field(default_factory=dict)
    _assessed: dict[Pair, PairFacts] = field(default_factory=dict, init=False, repr=False)  # so far

    def __post_init__(self) -> None:
        object.__setattr__(self, "encounters", MappingProxyType(dict(self.encounters)))

    def facts(self, own: ShipId, other: ShipId) -> PairFacts:
        """Facts about two ships, as `own` sees them."""
        if (own, other) not in self._assessed:
            reports = self.world.reports
            memory = self.encounters.get((min(own, other), max(own, other)), NO_ENCOUNTER)
            self._assessed[own, other] = assess(self.world.waters, reports[own], reports[other], memory)
        return self._assessed[own, other]


class AbstractRuleset(ABC):
    """A ruleset: an id, a version, a title, and the graph that it emits."""

    id: str
    version: str
    title: str

    @abstractmethod
    def emit(self, situation: Situation) -> PriorityGraph:
        """Emit the priority graph of a situation: every edge from verdicts with a source."""

    def view(self, situation: Situation, own: ShipId, other: ShipId) -> Verdict | None:
        """Verdict of `own`'s view on `other`, read from the emitted graph; None where it says nothing."""
        for settlement in self.emit(situation).settlements:
            if settlement.pair == (min(own, other), max(own, other)):
                return settlement.one if settlement.one.own == own else settlement.other
        return None


class PairRuleset(AbstractRuleset):
    """A ruleset that judges two ships at a time."""

    @abstractmethod
    def judge(self, facts: PairFacts) -> Verdict:
        """Judge a pair from `facts.own`'s side."""

    def view(self, situation: Situation, own: ShipId, other: ShipId) -> Verdict | None:
        """Judge one pair, from one side."""
        return self.judge(situation.facts(own, other))

    def emit(self, situation: Situation) -> PriorityGraph:
        """Judge every pair from both sides, and settle."""
        reports = situation.world.reports
        masses = {ship: report.ship.mass for ship, report in reports.items()}
        settlements = []
        for own, other in combinations(sorted(reports), 2):
            facts = situation.facts(own, other)
            one, two = self.judge(facts), self.judge(facts.mirrored())
            if (one.kind, two.kind) != (Kind.NONE, Kind.NONE):
                settlements.append(settle(one, two, masses))
        return PriorityGraph(masses=masses, settlements=tuple(settlements))
