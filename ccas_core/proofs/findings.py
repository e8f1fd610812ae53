"""What a proof came to, as values."""

from __future__ import annotations

import builtins
from dataclasses import dataclass
from enum import StrEnum

from ..tapd.rules import Rule, Waiver
from .search import Ships


class Outcome(StrEnum):
    """What is known of a property."""

    PROVED = "proved"
    REFUTED = "refuted"
    UNDECIDED = "undecided"


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """A way in which a property fails: which rules, in words, and ships that show it, if any can."""

    title: str
    rules: tuple[Rule, ...] = ()
    ships: Ships | None = None
    kind: str = ""  # contradiction, gap, cycle, instability, border, dead rule, …
    waiver: Waiver | None = None  # that covers it
    expired: bool = False  # its day has passed

    @property
    def waived(self) -> bool:
        """Whether a waiver that has not expired covers it."""
        return self.waiver is not None and not self.expired

    @property
    def articles(self) -> tuple[str, ...]:
        """Articles that it is about: those of its rules, else those by which the ships judge."""
        cited = [str(rule.citation) for rule in self.rules]
        if not cited and self.ships is not None:
            cited = [view.article for view in self.ships.verdicts if view.article]
        return tuple(dict.fromkeys(cited))


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """A property of a ruleset, and what is known of it."""

    property: str
    outcome: Outcome
    method: str
    seconds: float
    faults: tuple[Fault, ...] = ()
    open: tuple[str, ...] = ()  # what could not be decided
    notes: tuple[str, ...] = ()

    @builtins.property  # for there is a field of that name
    def waived(self) -> bool:
        """Whether waivers that have not expired cover all that is wrong."""
        return bool(self.faults) and all(fault.waived for fault in self.faults)
