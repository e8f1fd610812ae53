"""A ruleset as values: rules with their conditions and sources, and what belongs to them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import date
from enum import StrEnum
from fractions import Fraction
from typing import Final

from ..errors import Diagnostic
from ..roles import PassingSide
from ..verdict import Citation, Kind
from .cases import Case
from .language.compiler import Definition, Parameter
from .language.formula import Formula
from .language.polynomial import Polynomial
from .vocabulary import Vocabulary


class Policy(StrEnum):
    """What it means that two rules apply."""

    FIRST = "first"  # the first of them decides
    UNIQUE = "unique"  # that must not happen


class Mirror(StrEnum):
    """Whether a rule also says what the other ship sees."""

    AUTO = "auto"
    NONE = "none"


class Strength(StrEnum):
    """How much a ship owes."""

    KEEP_CLEAR = "keep_clear"
    LEAVE_ROOM = "leave_room"
    LEAVE_SUITABLE_WAY = "leave_suitable_way"
    WAIT = "wait"
    HOLD = "hold"
    NOT_IMPEDE = "not_impede"
    NOT_FORCE_SUDDEN_CHANGE = "not_force_sudden_change"
    CLEAR_ROUTE = "clear_route"


class Diagnosis(StrEnum):
    """What is wrong where a regulation contradicts itself, or decides nothing."""

    GAP = "gap"
    CONFLICT = "conflict"
    BOTH_OBLIGED = "both_obliged"
    BOTH_STAND_ON = "both_stand_on"
    DUAL_OBLIGATION = "dual_obligation"
    DOUBT = "doubt"


class Side(StrEnum):
    """One of the two ships, as a rule sees them."""

    OWN = "own"
    OTHER = "other"


class Criterion(StrEnum):
    """What decides who goes first in a ring of ships, besides criteria of plugins."""

    WEIGHT = "weight"
    LENGTH = "length"
    ID = "id"


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What a rule says, for (own, other)."""

    kind: Kind
    strength: Strength | None = None
    passing_side: PassingSide | None = None
    passing_required: bool = True
    side_chosen_by: Side | None = None
    must_follow: Side | None = None
    facilitates: Side | None = None
    signal: str = ""
    manoeuvre: str = ""
    diagnosis: Diagnosis | None = None
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a rule's condition, and where it comes from: `where`, `when`, `unless`, or a gate."""

    label: str
    formula: Formula


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Where a rule is written down: file, line, column, and the line itself."""

    file: str
    line: int
    column: int
    excerpt: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """One rule of a ladder."""

    id: str
    condition: Formula
    parts: tuple[Part, ...]
    outcome: Outcome
    citation: Citation
    because: str
    source: Source
    origin: str  # id of the ruleset that wrote it
    python: str = ""  # name of the function of a plugin that decides in place of `outcome`
    note: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Gate:
    """A condition that switches rules off; it has no verdict."""

    id: str
    formula: Formula
    citation: Citation
    off: tuple[str, ...]  # ids of the rules that it switches off
    source: Source


@dataclass(frozen=True, slots=True, kw_only=True)
class Waiver:
    """A fault that is accepted: which check, why, until when, and for which rules."""

    check: str
    reason: str
    expires: date
    rules: tuple[str, ...]
    source: Source


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A property that is claimed of some ships only: those for which further conditions hold."""

    name: str
    check: str
    assume: tuple[Formula, ...]
    texts: tuple[str, ...]
    on_a_reach: bool  # of ships that follow one reach of a river
    source: Source


@dataclass(frozen=True, slots=True, kw_only=True)
class Domain:
    """For which ships and distances a ruleset is meant: proofs and their counterexamples stay in it [SI]."""

    speed: tuple[Fraction, Fraction] = (Fraction(1, 2), Fraction(15))
    length: tuple[Fraction, Fraction] = (Fraction(5), Fraction(200))
    separation: Fraction = Fraction(50)
    assume: tuple[Formula, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Recognition:
    """How an encounter is recognised from positions and courses, for (own, other)."""

    risk: Formula
    overtaking: Formula
    head_on: Formula
    crossing: Formula
    from_starboard: Formula


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """A criterion for who decides first: the least value, or the greatest."""

    criterion: str
    descending: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RulesetText:
    """All that a ruleset file says, its base merged in, names looked up and types checked."""

    id: str
    version: str
    title: str
    description: str
    regulation: str
    edition: str  # version of the regulation
    abstract: bool
    lineage: tuple[str, ...]  # ids of the bases, nearest first
    vocabulary: Vocabulary
    parameters: Mapping[str, Parameter]
    tangents: Mapping[str, Polynomial]
    definitions: Mapping[str, Definition]
    regimes: Mapping[str, str]
    policy: Policy
    mirror: Mirror
    recognition: Recognition | None
    gates: tuple[Gate, ...]
    rules: tuple[Rule, ...]
    otherwise: Citation
    resolve_by: tuple[Order, ...]
    domain: Domain
    waivers: tuple[Waiver, ...]
    claims: tuple[Claim, ...]
    inline: tuple[Case, ...]  # tests in the file itself
    beside: Callable[[], tuple[Case, ...]]  # those in a file beside it, read when asked for
    source: str  # path of the file
    lint: Callable[[], tuple[Diagnostic, ...]] = tuple

    @property
    def tests(self) -> tuple[Case, ...]:
        """All tests; `RulesetError` where those beside the file cannot be understood."""
        return (*self.inline, *self.beside())

    @property
    def remarks(self) -> tuple[Diagnostic, ...]:
        """What the author may have overlooked (`lint`); looked for when asked."""
        return self.lint()

    def rule(self, id_: str) -> Rule:
        """Rule by its id; `KeyError` where there is none."""
        for rule in self.rules:
            if rule.id == id_:
                return rule
        raise KeyError(id_)

    @property
    def constants(self) -> dict[str, Polynomial]:
        """Values of all parameters, and tangents of limits that depend on them, for formulas."""
        from .language.motion import tangent
        from .language.polynomial import number

        values = {f"parameter.{name}": number(each.value) for name, each in self.parameters.items()}
        tangents = {name: degrees.with_values(values).constant for name, degrees in self.tangents.items()}
        return values | {name: number(tangent(deg)) for name, deg in tangents.items() if deg is not None}


DEFAULT_ORDER: Final = (Order(criterion="weight"), Order(criterion="id"))
