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
from typing import Any

from ..priority import LIGHTEST_FIRST, PriorityGraph, settle
from ..regions import Law
from ..ships import Ship, ShipId
from ..verdict import Kind, Verdict
from ..world import World
from .encounters import NO_ENCOUNTER, Encounter
from .facts import PairFacts, assess, known_values
from .pair_law import law_of_pair
from .vocabulary import VOCABULARY, Scope, Vocabulary

Pair = tuple[ShipId, ShipId]  # sorted


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Situation:
    """The world now, what is remembered of every pair's encounter, and who kept the starboard side."""

    world: World
    encounters: Mapping[Pair, Encounter] = field(default_factory=dict)
    kept_starboard: frozenset[ShipId] = frozenset()  # a period ago
    _values: dict[tuple[int, ShipId], tuple[Any, ...]] = field(default_factory=dict, init=False, repr=False)
    _assessed: dict[tuple[int, ShipId, ShipId], PairFacts] = field(
        default_factory=dict, init=False, repr=False
    )

    def __post_init__(self) -> None:
        object.__setattr__(self, "encounters", MappingProxyType(dict(self.encounters)))

    def facts(self, own: ShipId, other: ShipId, vocabulary: Vocabulary = VOCABULARY) -> PairFacts:
        """Facts about two ships, as `own` sees them."""
        key = id(vocabulary), own, other
        if key not in self._assessed:
            reports = self.world.reports
            values = {ship: self.ship_values(ship, vocabulary) for ship in (own, other)}
            memory = self.encounter(own, other)
            self._assessed[key] = assess(
                vocabulary, self.world.waters, reports[own], reports[other], memory, values
            )
        return self._assessed[key]

    def ship_values(self, ship: ShipId, vocabulary: Vocabulary = VOCABULARY) -> tuple[Any, ...]:
        """Facts of one ship, computed once."""
        key = id(vocabulary), ship
        if key not in self._values:
            report, kept = self.world.reports[ship], ship in self.kept_starboard
            self._values[key] = known_values(vocabulary, self.world.waters, report, kept_starboard=kept)
        return self._values[key]

    def on_starboard_side(self, vocabulary: Vocabulary = VOCABULARY) -> frozenset[ShipId]:
        """Ships that follow the starboard side of their waterways now."""
        place = vocabulary.places[Scope.SHIP]["follows_starboard_side"]
        values = {ship: self.ship_values(ship, vocabulary)[place] for ship in self.world.reports}
        return frozenset(ship for ship, value in values.items() if value is True)

    def law(self, own: ShipId, other: ShipId) -> Law:
        """Law by which two ships judge one another: that of their encounter, or of where they will meet."""
        world = self.world
        known = world.waters.laws.everywhere or self.encounter(own, other).law
        return known or law_of_pair(world.waters, world.reports[own], world.reports[other])

    def encounter(self, own: ShipId, other: ShipId) -> Encounter:
        """What is remembered of two ships."""
        return self.encounters.get((min(own, other), max(own, other)), NO_ENCOUNTER)


class AbstractRuleset(ABC):
    """A ruleset: an id, a version, a title, and the graph that it emits."""

    id: str
    version: str
    title: str

    @abstractmethod
    def emit(self, situation: Situation) -> PriorityGraph:
        """Emit the priority graph of a situation: every edge from verdicts with a source."""

    @property
    def vocabulary(self) -> Vocabulary:
        """Facts that the ruleset may ask for."""
        return VOCABULARY

    def view(self, situation: Situation, own: ShipId, other: ShipId) -> Verdict | None:
        """Verdict of `own`'s view on `other`, read from the emitted graph; None where it says nothing."""
        for settlement in self.emit(situation).settlements:
            if settlement.pair == (min(own, other), max(own, other)):
                return settlement.one if settlement.one.own == own else settlement.other
        return None

    @property
    def criterion(self) -> str:
        """What `rank` goes by, for the log."""
        return LIGHTEST_FIRST

    def rank(self, ship: Ship) -> tuple[float, ...]:
        """Place of a ship among those that wait for one another in a ring: the least decides first.

        By displacement (Sec. 3.2); ships that are alike are told apart by their ids.
        """
        return (ship.mass,)


class PairRuleset(AbstractRuleset):
    """A ruleset that judges two ships at a time."""

    @abstractmethod
    def judge(self, facts: PairFacts) -> Verdict:
        """Judge a pair from `facts.own`'s side."""

    def view(self, situation: Situation, own: ShipId, other: ShipId) -> Verdict | None:
        """Judge one pair, from one side."""
        return self.judge(situation.facts(own, other, self.vocabulary))

    def emit(self, situation: Situation) -> PriorityGraph:
        """Judge every pair from both sides, and settle."""
        reports = situation.world.reports
        masses = {ship: report.ship.mass for ship, report in reports.items()}
        settlements = []
        for own, other in combinations(sorted(reports), 2):
            facts = situation.facts(own, other, self.vocabulary)
            one, two = self.judge(facts), self.judge(facts.mirrored())
            if (one.kind, two.kind) != (Kind.NONE, Kind.NONE):
                settlements.append(settle(one, two, masses))
        ranks = {ship: self.rank(report.ship) for ship, report in reports.items()}
        return PriorityGraph(
            masses=masses, settlements=tuple(settlements), ranks=ranks, criterion=self.criterion
        )
