"""Rulesets that a ship has aboard: as a rule all, but a ship may lack one, or have it in another version."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from ..priority import PriorityGraph, settle
from ..regions import Law
from ..ships import Ship, ShipId
from ..verdict import Kind, Verdict
from .ruleset import AbstractRuleset, Situation
from .vocabulary import Vocabulary

Aboard: TypeAlias = Mapping[str, AbstractRuleset]  # by id; the first is for want of the one that is asked for


def aboard(installed: Mapping[str, AbstractRuleset], named: Sequence[str]) -> Aboard:
    """Rulesets of a ship that names them, as `ID` or `ID@VERSION`; where it names none, all."""
    if not named:
        return installed
    laws = [Law.parsed(each) for each in named]
    return {law.ruleset: _in_version(installed[law.ruleset], law.version) for law in laws}


def judging(rulesets: Aboard, law: Law) -> AbstractRuleset:
    """Ruleset by which a ship judges under a law: that of the law, or the first that it has aboard."""
    found = rulesets.get(law.ruleset)
    return next(iter(rulesets.values())) if found is None else found


def _in_version(installed: AbstractRuleset, version: str) -> AbstractRuleset:
    return installed if version in ("", installed.version) else OtherVersion(installed, version)


class OtherVersion(AbstractRuleset):
    """A ruleset in a version whose rules are not installed here.

    It sees how ships meet, as the installed version does, and does not know who gives way: a verdict that
    is not `none` becomes `unknown_fact`.  Beside a ship with the installed version the versions differ, and
    beside one with this version nobody knows; either way both give way by the safe mutual rule.
    """

    def __init__(self, installed: AbstractRuleset, version: str) -> None:
        self._installed = installed
        self.id, self.version, self.title = installed.id, version, installed.title

    @property
    def vocabulary(self) -> Vocabulary:
        """Facts of the installed version."""
        return self._installed.vocabulary

    @property
    def criterion(self) -> str:
        """What `rank` goes by."""
        return self._installed.criterion

    def rank(self, ship: Ship) -> tuple[float, ...]:
        """Place of a ship in a ring, as the installed version has it."""
        return self._installed.rank(ship)

    def view(self, situation: Situation, own: ShipId, other: ShipId) -> Verdict | None:
        """How two ships meet, and that nobody knows who gives way."""
        seen = self._installed.view(situation, own, other)
        if seen is None or seen.kind is Kind.NONE:
            return None if seen is None else replace(seen, version=self.version)
        return Verdict(
            own=own,
            other=other,
            kind=Kind.UNKNOWN_FACT,
            ruleset=self.id,
            version=self.version,
            geometry=seen.geometry,
            overtaker=seen.overtaker,
            has_other_on_starboard=seen.has_other_on_starboard,
            reason=f"the rules of {self.id} {self.version} are not installed",
        )

    def emit(self, situation: Situation) -> PriorityGraph:
        """Give way all: what `view` says of every pair, settled."""
        masses = {ship: report.ship.mass for ship, report in situation.world.reports.items()}
        ships = sorted(masses)
        settlements = []
        for place, own in enumerate(ships):
            for other in ships[place + 1 :]:
                views = self.view(situation, own, other), self.view(situation, other, own)
                if views[0] is not None and views[1] is not None:
                    settlements.append(settle(views[0], views[1], masses))
        return PriorityGraph(masses=masses, settlements=tuple(settlements))
