"""What a proof came to, as values."""

from __future__ import annotations

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
    waiver: Waiver | None = None
    expired: bool = False  # there is a waiver, and its day has passed

    @property
    def waived(self) -> bool:
        """Whether a waiver that has not expired covers what is refuted."""
        return self.waiver is not None and not self.expired
