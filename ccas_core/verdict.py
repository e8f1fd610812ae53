"""What a rule says of two ships, seen from one of them, with its source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from types import MappingProxyType

from .roles import Geometry, PassingSide
from .ships import FactValue, ShipId


class Kind(StrEnum):
    """Kind of a verdict; the last three are diagnoses of the rules, not duties."""

    GIVE_WAY = "give_way"
    STAND_ON = "stand_on"
    MUTUAL = "mutual"
    COOPERATE = "cooperate"
    NEGOTIATE = "negotiate"
    NONE = "none"
    PROHIBITED = "prohibited"
    CONFLICT = "conflict"
    GAP = "gap"
    UNKNOWN_FACT = "unknown_fact"


class Confidence(StrEnum):
    """How well the source of a rule was seen."""

    TEXT_SEEN = "text_seen"
    SECONDARY_SEEN = "secondary_seen"
    DERIVED = "derived"
    UNVERIFIED = "unverified"


OPPOSITE = MappingProxyType({Kind.GIVE_WAY: Kind.STAND_ON, Kind.STAND_ON: Kind.GIVE_WAY})


@dataclass(frozen=True, slots=True, kw_only=True)
class Citation:
    """Where a rule is written: regulation, article, version, and how well it was seen."""

    regulation: str
    article: str
    version: str = ""
    confidence: Confidence = Confidence.UNVERIFIED
    text: str = ""  # what it says, in our words

    def __str__(self) -> str:
        return f"{self.regulation} {self.article}".strip()


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """Verdict of `own`'s view on its encounter with `other`.

    `initiator` is the ship that wants the manoeuvre of a `cooperate` or `prohibited` verdict; the other one
    is to adapt.  `facilitates` is a privileged ship that has a duty of its own, `must_follow` the one that
    has to take the side chosen by the other.  `diagnosis` names what is wrong where a regulation contradicts
    itself or is silent.
    `reason` says in words why the rule applied, or why none did.  `lacks` names the law of the pair where the
    ship has not got it aboard, and judges by what it has.
    """

    own: ShipId
    other: ShipId
    kind: Kind
    ruleset: str
    version: str
    rule: str = ""
    citation: Citation | None = None
    geometry: Geometry = Geometry.NONE
    strength: str = ""
    passing_side: PassingSide | None = None
    passing_required: bool = False
    side_chosen_by: ShipId | None = None
    must_follow: ShipId | None = None
    facilitates: ShipId | None = None
    initiator: ShipId | None = None
    overtaker: ShipId | None = None
    has_other_on_starboard: ShipId | None = None
    signal: str = ""
    manoeuvre: str = ""
    diagnosis: str = ""
    reason: str = ""
    lacks: str = ""
    facts: Mapping[str, FactValue] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "facts", MappingProxyType(dict(self.facts)))
        needed = self.kind in (Kind.COOPERATE, Kind.PROHIBITED)
        if self.initiator not in (self.own, self.other) and (needed or self.initiator is not None):
            raise ValueError(f"the initiator must be {self.own!r} or {self.other!r}, got {self.initiator!r}")

    @property
    def pair(self) -> frozenset[ShipId]:
        """The two ships, in no order."""
        return frozenset((self.own, self.other))

    @property
    def give_way(self) -> tuple[ShipId, ...]:
        """Ships that are obliged, sorted."""
        if self.kind is Kind.GIVE_WAY:
            return (self.own,)
        if self.kind is Kind.STAND_ON:
            return (self.other,)
        return tuple(sorted(self.pair)) if self.kind is Kind.MUTUAL else ()

    @property
    def stand_on(self) -> tuple[ShipId, ...]:
        """Ships that hold their course and speed, or are left room."""
        if self.kind is Kind.GIVE_WAY:
            return (self.other,)
        return (self.own,) if self.kind is Kind.STAND_ON else ()

    @property
    def article(self) -> str:
        """Regulation and article, or nothing where no rule applied."""
        return str(self.citation) if self.citation else ""


def agree(one: Verdict, other: Verdict) -> str:
    """Say why two views of one pair do not fit together; nothing where they do (Sec. 3.1).

    Views fit if they come from the same ruleset in the same version, and if their kinds are
    opposite: give-way against stand-on, every other kind against itself.
    """
    if (one.ruleset, one.version) != (other.ruleset, other.version):
        return f"{one.own} judges by {_judged_by(one)}, {other.own} by {_judged_by(other)}"
    if OPPOSITE.get(one.kind, one.kind) is not other.kind:
        return f"{one.own} sees {one.kind}, {other.own} sees {other.kind}"
    if one.initiator != other.initiator:
        return f"{one.own} takes {one.initiator} for the initiator, {other.own} takes {other.initiator}"
    if one.side_chosen_by != other.side_chosen_by:
        return f"{one.own} leaves the side to {one.side_chosen_by}, {other.own} to {other.side_chosen_by}"
    if one.passing_side is not other.passing_side:
        return f"{one.own} would pass {one.passing_side}, {other.own} {other.passing_side}"
    return ""


def _judged_by(view: Verdict) -> str:
    wanted = f" for want of {view.lacks}" if view.lacks else ""
    return f"{view.ruleset} {view.version}{wanted}"
