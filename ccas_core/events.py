"""What happens on a voyage that a plugin may observe."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from .priority import Opening
from .ships import ShipId


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderDecided:
    """All ships have decided: those of one generation at the same time."""

    time: float  # [s]
    generations: tuple[tuple[ShipId, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class RulesetSwitched:
    """A ship has come from waters under one ruleset into waters under another."""

    time: float  # [s]
    ship: ShipId
    before: str
    after: str


@dataclass(frozen=True, slots=True, kw_only=True)
class DeadlockDetected:
    """Ships waited for one another in a ring, and these edges were left out of the order."""

    time: float  # [s]
    openings: tuple[Opening, ...]


Event: TypeAlias = OrderDecided | RulesetSwitched | DeadlockDetected
