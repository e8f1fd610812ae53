"""Criteria of plugins for who decides first where ships wait for one another in a ring."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..ships import Ship


@dataclass(frozen=True, slots=True)
class RankingCriterion:
    """A number for every ship, the same whoever computes it; the least decides first."""

    name: str
    value: Callable[[Ship], float]
    meaning: str = ""
