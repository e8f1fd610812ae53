"""Cases: encounters with the verdicts that are expected of rulesets, as values.

They come from the tests of a ruleset file and from encounter files alike.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..ships import ShipId
from ..verdict import Confidence

DIAGNOSES = (
    "ok", "cycle", "acyclic", "gap", "no_rule", "conflict", "both_stand_on", "both_obliged", "both_give_way",
    "dual_obligation", "doubt", "unknown_fact", "incomplete", "design_decision", "inconsistent",
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CaseShip:
    """A ship of a case: stated facts, and where it is, if that is stated."""

    id: ShipId
    facts: Mapping[str, Any]
    pose: tuple[float, float, float] | None = None  # north, east [m], course [rad]
    speed: float | None = None  # [m/s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Expected:
    """What a ruleset is expected to say; None where the case leaves it open.

    Of a pair: `kind` and the lists.  Of a group: the pairs, the diagnosis and the order of decision.
    """

    kind: str | None = None
    give_way: frozenset[ShipId] | None = None
    stand_on: frozenset[ShipId] | None = None
    initiator: ShipId | None = None
    passing_side: str | None = None
    strength: str | None = None
    side_chosen_by: ShipId | None = None
    must_follow: frozenset[ShipId] | None = None
    facilitates: frozenset[ShipId] | None = None
    manoeuvre: str | None = None
    reason: str | None = None
    rule: str | None = None
    article: str = ""
    diagnosis: str | None = None
    gives_way_to: frozenset[tuple[ShipId, ShipId]] | None = None
    mutual: frozenset[frozenset[ShipId]] | None = None
    no_rule: frozenset[frozenset[ShipId]] | None = None
    cycle: frozenset[ShipId] | None = None
    order: tuple[ShipId, ...] | None = None
    confidence: Confidence | None = None

    @property
    def required(self) -> bool:
        """Whether a verdict that differs is a failure."""
        return self.confidence not in (Confidence.DERIVED, Confidence.UNVERIFIED)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Case:
    """An encounter of two or more ships, and what rulesets are expected to say of it."""

    id: str
    title: str = ""
    ships: tuple[CaseShip, ...] = ()
    waterway: Mapping[str, Any] = field(default_factory=dict)
    encounter: Mapping[str, Any] = field(
        default_factory=dict
    )  # stated facts of the pair, ships by id; and, by
    # ship, times to the intersection of the waterways [s]
    expected: Mapping[str, Expected] = field(default_factory=dict)  # by ruleset
    tags: tuple[str, ...] = ()
    hard: bool = False
    strict: bool = False  # everything that is expected is compared, and not the duty alone
    source: str = ""
    line: int = 0
