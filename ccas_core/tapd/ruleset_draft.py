"""A ruleset file as it is read, before its base is merged in: keys checked, conditions still texts.

Every value keeps its place, so that a fault found later is told where it was written.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import date
from enum import StrEnum
from fractions import Fraction
from typing import Final, TypeVar

from ..errors import RulesetError
from ..findings import Place
from ..quantities import QUANTITY_OF
from ..roles import PassingSide
from ..strict_yaml import Block, Reader
from ..verdict import Citation, Confidence, Kind
from ..yaml_nodes import Mapping as Keys
from ..yaml_nodes import Node, Scalar, Sequence
from .case_file import read_tests
from .cases import Case
from .language import syntax
from .language.compiler import DIMENSIONS, UNITS, Definition, Dimensions, Parameter
from .rules import Diagnosis, Mirror, Order, Outcome, Policy, Side, Strength
from .vocabulary import Vocabulary

SCHEMA: Final = "ccas/ruleset@1"
RECOGNITION: Final = ("risk", "overtaking", "head_on", "crossing", "from_starboard")
_ID: Final = re.compile(r"[a-z][a-z0-9]*(?:[._-][a-z0-9]+)*")
_VERSION: Final = re.compile(r"[0-9]+(?:\.[0-9A-Za-z-]+)*")
_E = TypeVar("_E", bound=StrEnum)


class Then(StrEnum):
    """What a rule may say under `then`."""

    GIVE_WAY = "give_way"
    STAND_ON = "stand_on"
    MUTUAL = "mutual"
    COOPERATE = "cooperate"
    NEGOTIATE = "negotiate"
    PROHIBITED = "prohibited"
    NONE = "none"
    CONFLICT = "conflict"
    GAP = "gap"


class Passing(StrEnum):
    """How binding a passing side is."""

    REQUIRED = "required"
    PREFERRED = "preferred"


@dataclass(frozen=True, slots=True)
class Condition:
    """The text of a condition and its place; several lines of a list are joined by `and`."""

    text: str
    node: Node
    reader: Reader


@dataclass(frozen=True, slots=True)
class Exception_:
    """An exception to a rule, which may have exceptions of its own."""

    when: tuple[Condition, ...]
    unless: tuple[Exception_, ...]
    citation: Citation | None


@dataclass(frozen=True, slots=True, kw_only=True)
class DraftRule:
    """A rule as written."""

    id: str
    node: Node
    reader: Reader
    where: tuple[Condition, ...]
    when: tuple[Condition, ...]
    unless: tuple[Exception_, ...]
    outcome: Outcome | None
    python: str
    python_node: Node
    citation: Citation
    because: str
    note: str
    before: Scalar | None
    after: Scalar | None
    replaces: Scalar | None
    origin: str


@dataclass(frozen=True, slots=True, kw_only=True)
class DraftGate:
    """A gate as written."""

    id: str
    node: Node
    reader: Reader
    when: tuple[Condition, ...]
    off: tuple[Scalar, ...]
    citation: Citation


@dataclass(frozen=True, slots=True, kw_only=True)
class DraftWaiver:
    """A waiver as written."""

    check: str
    reason: str
    expires: date
    rules: tuple[Scalar, ...]
    node: Node
    reader: Reader


@dataclass(slots=True, kw_only=True)
class Draft:
    """All that one ruleset file says."""

    reader: Reader
    path: str
    id: str
    version: str
    title: str
    description: str
    abstract: bool
    extends: Scalar | None
    regulation: str
    edition: str
    parameters: dict[str, tuple[Parameter, Node]] = field(default_factory=dict)
    definitions: dict[str, tuple[Definition, Condition]] = field(default_factory=dict)
    regimes: dict[str, tuple[str, Node]] = field(default_factory=dict)
    policy: Policy | None = None
    mirror: Mirror | None = None
    recognition: dict[str, Condition] = field(default_factory=dict)
    gates: list[DraftGate] = field(default_factory=list)
    rules: list[DraftRule] = field(default_factory=list)
    removed: list[Scalar] = field(default_factory=list)
    recited: dict[str, tuple[Citation, Node]] = field(default_factory=dict)
    otherwise: Citation | None = None
    resolve_by: tuple[tuple[Order, Node], ...] | None = None
    speed: tuple[Fraction, Fraction] | None = None
    length: tuple[Fraction, Fraction] | None = None
    separation: Fraction | None = None
    assume: tuple[Condition, ...] = ()
    waivers: list[DraftWaiver] = field(default_factory=list)
    tests: tuple[Case, ...] = ()


def read_draft(text: str, source: str, vocabulary: Vocabulary) -> Draft:
    """Read the text of a ruleset file.

    Raises
    ------
    RulesetError
        With all that is wrong in it, as far as it can be told without its base.
    """
    draft = _DraftReader(text, source, vocabulary).draft()
    draft.reader.finish()
    return draft


def head_of(text: str, source: str) -> tuple[str, str, bool, str]:
    """Id, title, whether it is abstract, and the base of a ruleset file, without reading the rest of it."""
    reader = Reader(text, source, RulesetError)
    block = reader.document(SCHEMA)
    id_ = reader.text(block.require("id"))
    title = block.find("title")
    abstract = block.find("abstract")
    base = block.find("extends")
    return (
        id_,
        reader.text(title) if title else "",
        reader.flag(abstract) if abstract else False,
        base.text if isinstance(base, Scalar) else "",
    )


class _DraftReader:
    """Reads one file, block by block."""

    def __init__(self, text: str, source: str, vocabulary: Vocabulary) -> None:
        self._reader = Reader(text, source, RulesetError)
        self._source, self._vocabulary = source, vocabulary
        self._regulation = self._edition = ""
        self._id = ""

    def draft(self) -> Draft:
        """Read the whole."""
        reader = self._reader
        root = reader.document(SCHEMA)
        self._id = self._matching(root.require("id"), _ID, "an id of small letters, digits, '_', '-' and '.'")
        self._regulation, self._edition = self._regulated(root.find("regulation"))
        draft = Draft(
            reader=reader,
            path=self._source,
            id=self._id,
            version=self._matching(root.require("version"), _VERSION, "a version such as 1.0.0"),
            title=reader.text(root.require("title")),
            description=reader.text(node) if (node := root.find("description")) else "",
            abstract=reader.flag(root.optional("abstract", "false")),
            extends=self._word(root.find("extends")),
            regulation=self._regulation,
            edition=self._edition,
        )
        draft.policy = reader.choice(node, Policy) if (node := root.find("policy")) else None
        draft.mirror = reader.choice(node, Mirror) if (node := root.find("mirror")) else None
        self._parameters(draft, root.find("params"))
        self._definitions(draft, root.find("let"))
        self._regimes(draft, root.find("regimes"))
        self._recognition(draft, root.find("encounter"))
        self._gates(draft, root.find("gates"))
        draft.removed = self._words(root.find("remove"))
        self._rules(draft, root.find("rules"))
        self._recited(draft, root.find("citations"))
        if (node := root.find("otherwise")) is not None:
            block = reader.block(node)
            draft.otherwise = self._citation(block.require("cite"))
            block.done()
        self._deadlock(draft, root.find("deadlock"))
        self._domain(draft, root.find("domain"))
        self._waivers(draft, root.find("waivers"))
        draft.tests = read_tests(reader, root.find("tests"), self._id, self._vocabulary)
        root.done()
        return draft

    # -- small things ----------------------------------------------------------------------------

    def _matching(self, node: Node, pattern: re.Pattern[str], expected: str) -> str:
        text = self._reader.text(node)
        if text and not pattern.fullmatch(text):
            self._reader.refuse(node, f"got '{text[:40]}'", expected=expected)
        return text

    def _word(self, node: Node | None) -> Scalar | None:
        if node is None or not self._reader.text(node):
            return None
        return node if isinstance(node, Scalar) else None

    def _words(self, node: Node | None) -> list[Scalar]:
        """One word, or a list of words."""
        if isinstance(node, Scalar):
            return [node] if self._word(node) else []
        return [word for each in self._reader.items(node) if (word := self._word(each))]

    def _optional(self, block: Block, key: str) -> str:
        node = block.find(key)
        return self._reader.text(node) if node else ""

    def _choice(self, block: Block, key: str, options: type[_E]) -> _E | None:
        node = block.find(key)
        return self._reader.choice(node, options) if node else None

    def _regulated(self, node: Node | None) -> tuple[str, str]:
        if node is None:
            return "", ""
        block = self._reader.block(node)
        name = self._reader.text(block.require("name"))
        edition = self._reader.text(block.require("version"))
        for key in ("title", "url", "language"):
            self._optional(block, key)
        block.done()
        return name, edition

    def _conditions(self, node: Node | None) -> tuple[Condition, ...]:
        """A condition, or a list of conditions that must all hold."""
        if node is None:
            return ()
        nodes = node.items if isinstance(node, Sequence) else (node,)
        if not nodes:
            self._reader.refuse(node, "an empty list", expected="a condition")
        found = []
        for each in nodes:
            if text := self._reader.text(each):
                found.append(Condition(text, each, self._reader))
        return tuple(found)

    def _citation(self, node: Node) -> Citation:
        block = self._reader.block(node)
        article = self._reader.text(block.require("article"))
        regulation = self._optional(block, "regulation") or self._regulation
        if not regulation and article:
            hint = "say which: 'regulation: {name: …, version: …}' at the top of the file, or here"
            self._reader.refuse(node, "a citation without regulation", hint=hint)
        citation = Citation(
            regulation=regulation,
            article=article,
            version=self._optional(block, "version") or self._edition,
            confidence=self._choice(block, "confidence", Confidence) or Confidence.UNVERIFIED,
            text=self._optional(block, "text"),
        )
        block.done()
        return citation

    # -- blocks ----------------------------------------------------------------------------------

    def _parameters(self, draft: Draft, node: Node | None) -> None:
        for key, value in self._reader.entries(node):
            if not self._named(key, "parameter"):
                continue
            whole = isinstance(value, Keys)
            block = self._reader.block(value) if whole else None
            number = block.require("value") if block else value
            found, dimensions = self._quantity(number)
            low = high = found
            meaning = ""
            if block:
                if (span := block.find("range")) is not None:
                    low, high = self._range(span, dimensions)
                    if not low <= found <= high:
                        self._reader.refuse(number, "the value lies outside of its range")
                meaning = self._optional(block, "meaning")
                block.done()
            parameter = Parameter(found, low, high, dimensions, meaning)
            draft.parameters[key.text] = parameter, key

    def _named(self, key: Scalar, what: str) -> bool:
        if syntax.is_name(key.text) and key.text not in ("own", "other"):
            return True
        expected = "letters, digits and '_', beginning with a letter"
        self._reader.refuse(key, f"'{key.text[:40]}' cannot be the name of a {what}", expected=expected)
        return False

    def _quantity(self, node: Node) -> tuple[Fraction, Dimensions]:
        """A number with its unit, exactly."""
        text = self._reader.text(node)
        match = re.fullmatch(r"(-?\d+(?:\.\d+)?(?:[eE][+-]?\d{1,2})?)(?: +(\S+))?", text)
        unit = (match[2] or "") if match else ""
        if match is None or unit not in UNITS:
            hint = "an angle is written in degrees" if unit == "rad" else ""
            if match and unit in QUANTITY_OF and not hint:
                hint = f"not in a condition: use one of {', '.join(filter(None, UNITS))}"
            expected = "a number with its unit, such as 300 s or 22.5 deg"
            if text:
                self._reader.refuse(node, f"got '{text[:40]}'", expected=expected, hint=hint)
            return Fraction(0), DIMENSIONS["a number without unit"]
        size, dimensions = UNITS[unit]
        return Fraction(match[1]) * size, dimensions

    def _range(self, node: Node, dimensions: Dimensions) -> tuple[Fraction, Fraction]:
        ends = self._reader.items(node, 2, 2)
        if len(ends) != 2:
            return Fraction(0), Fraction(0)
        (low, one), (high, two) = (self._quantity(end) for end in ends)
        if one != dimensions or two != dimensions:
            self._reader.refuse(node, "the range has another unit than the value")
        elif low > high:
            self._reader.refuse(node, "the range is empty", expected="the least value first")
        return low, high

    def _definitions(self, draft: Draft, node: Node | None) -> None:
        for key, value in self._reader.entries(node):
            match = re.fullmatch(r"([A-Za-z_][A-Za-z0-9_]*)(?:\(([A-Za-z_, ]*)\))?", key.text)
            if match is None or not syntax.is_name(match[1]):
                expected = "a name, or a name with its ships: small(ship)"
                self._reader.refuse(key, f"'{key.text[:40]}' cannot be defined", expected=expected)
                continue
            ships = tuple(name.strip() for name in (match[2] or "").split(",") if name.strip())
            if match[2] is not None and (not 1 <= len(ships) <= 2 or len(set(ships)) < len(ships)):
                self._reader.refuse(
                    key, f"'{key.text[:40]}' is asked for {len(ships)} ships", expected="1 or 2"
                )
                continue
            conditions = self._conditions(value)
            if not conditions:
                continue
            condition = _joined(conditions)
            expression = self._parsed(condition)
            if expression is not None:
                draft.definitions[match[1]] = Definition(ships, expression, condition.text), condition

    def _parsed(self, condition: Condition) -> syntax.Expression | None:
        try:
            return syntax.parse(condition.text)
        except syntax.Fault as fault:
            refuse(condition, fault)
            return None

    def _regimes(self, draft: Draft, node: Node | None) -> None:
        for key, value in self._reader.entries(node):
            if self._named(key, "regime"):
                draft.regimes[key.text] = self._reader.text(value), key

    def _recognition(self, draft: Draft, node: Node | None) -> None:
        if node is None:
            return
        block = self._reader.block(node)
        for key in RECOGNITION:
            if conditions := self._conditions(block.find(key)):
                draft.recognition[key] = _joined(conditions)
        block.done()

    def _gates(self, draft: Draft, node: Node | None) -> None:
        ids: dict[str, Node] = {}
        for each in self._reader.items(node):
            block = self._reader.block(each)
            id_ = self._reader.unique(ids, block.require("id"), "gate")
            gate = DraftGate(
                id=id_,
                node=each,
                reader=self._reader,
                when=self._conditions(block.require("when")),
                off=tuple(self._words(block.require("off"))),
                citation=self._citation(block.require("cite")),
            )
            self._optional(block, "note")
            if block.done():
                draft.gates.append(gate)

    def _rules(self, draft: Draft, node: Node | None) -> None:
        ids: dict[str, Node] = {}
        for each in self._reader.items(node):
            block = self._reader.block(each)
            named = block.require("id")
            id_ = self._reader.unique(ids, named, "rule")
            if id_ and not _ID.fullmatch(id_):
                self._reader.refuse(
                    named, f"got '{id_[:40]}'", expected="small letters, digits, '.', '-', '_'"
                )
            python = block.find("python")
            rule = DraftRule(
                id=id_,
                node=named,
                reader=self._reader,
                where=self._conditions(block.find("where")),
                when=self._conditions(block.find("when") if python else block.require("when")),
                unless=self._exceptions(block.find("unless")),
                outcome=None if python else self._outcome(block),
                python=self._reader.text(python) if python else "",
                python_node=python or named,
                citation=self._citation(block.require("cite")),
                because=self._optional(block, "because"),
                note=self._optional(block, "note"),
                before=self._word(block.find("before")),
                after=self._word(block.find("after")),
                replaces=self._word(block.find("replaces")),
                origin=self._id,
            )
            if sum(x is not None for x in (rule.before, rule.after, rule.replaces)) > 1:
                self._reader.refuse(named, "two places for one rule", expected="before, after or replaces")
            if block.done():
                draft.rules.append(rule)

    def _exceptions(self, node: Node | None) -> tuple[Exception_, ...]:
        if node is None:
            return ()
        nodes = node.items if isinstance(node, Sequence) else (node,)
        found = []
        for each in nodes:
            if not isinstance(each, Keys):
                found.append(Exception_(self._conditions(each), (), None))
                continue
            block = self._reader.block(each)
            cite = block.find("cite")
            found.append(
                Exception_(
                    self._conditions(block.require("when")),
                    self._exceptions(block.find("unless")),
                    self._citation(cite) if cite else None,
                )
            )
            block.done()
        return tuple(found)

    def _outcome(self, block: Block) -> Outcome:
        then = self._reader.choice(block.require("then"), Then)
        passing = self._choice(block, "passing", Passing)
        outcome = Outcome(
            kind=Kind(then.value),
            strength=self._choice(block, "strength", Strength),
            passing_side=self._choice(block, "pass", PassingSide),
            passing_required=passing is not Passing.PREFERRED,
            side_chosen_by=self._choice(block, "side_chosen_by", Side),
            must_follow=self._choice(block, "must_follow", Side),
            facilitates=self._choice(block, "facilitates", Side),
            signal=self._optional(block, "signal"),
            manoeuvre=self._optional(block, "manoeuvre"),
            diagnosis=self._choice(block, "diagnosis", Diagnosis),
            reason=self._optional(block, "reason"),
        )
        if passing and outcome.passing_side is None and (node := block.find("passing")):
            self._reader.refuse(node, "'passing' without 'pass'", hint="say which side")
        if outcome.diagnosis and then not in (Then.CONFLICT, Then.GAP) and (node := block.find("diagnosis")):
            self._reader.refuse(node, f"a diagnosis with '{then}'", expected="then: conflict, or then: gap")
        return outcome

    def _recited(self, draft: Draft, node: Node | None) -> None:
        for key, value in self._reader.entries(node):
            draft.recited[key.text] = self._citation(value), key

    def _deadlock(self, draft: Draft, node: Node | None) -> None:
        if node is None:
            return
        block = self._reader.block(node)
        orders = []
        for each in self._reader.items(block.require("resolve_by"), 1):
            words = self._reader.text(each).split()
            if len(words) not in (1, 2) or words[1:] not in ([], ["ascending"], ["descending"]):
                expected = "a criterion, such as 'weight' or 'length descending'"
                self._reader.refuse(each, "this is no criterion", expected=expected)
                continue
            orders.append((Order(criterion=words[0], descending=words[1:] == ["descending"]), each))
        draft.resolve_by = tuple(orders)
        block.done()

    def _domain(self, draft: Draft, node: Node | None) -> None:
        if node is None:
            return
        block = self._reader.block(node)
        if (speed := block.find("speed")) is not None:
            draft.speed = self._range(speed, UNITS["m/s"][1])
        if (length := block.find("length")) is not None:
            draft.length = self._range(length, UNITS["m"][1])
        if (separation := block.find("separation")) is not None:
            draft.separation, dimensions = self._quantity(separation)
            if dimensions != UNITS["m"][1]:
                self._reader.refuse(separation, "this is no length", expected="a length such as 50 m")
        draft.assume = self._conditions(block.find("assume"))
        block.done()

    def _waivers(self, draft: Draft, node: Node | None) -> None:
        for each in self._reader.items(node):
            block = self._reader.block(each)
            expires = block.require("expires")
            waiver = DraftWaiver(
                check=self._reader.text(block.require("check")).replace("-", "_"),
                reason=self._reader.text(block.require("reason")),
                expires=self._date(expires),
                rules=tuple(self._words(block.find("rules"))),
                node=each,
                reader=self._reader,
            )
            if block.done():
                draft.waivers.append(waiver)

    def _date(self, node: Node) -> date:
        text = self._reader.text(node)
        try:
            return date.fromisoformat(text)
        except ValueError:
            if text:
                self._reader.refuse(node, f"got '{text[:40]}'", expected="a day such as 2027-06-30")
            return date.min


def _joined(conditions: Iterable[Condition]) -> Condition:
    """Several conditions as one, of which the first gives the place."""
    first, *more = conditions
    if not more:
        return first
    text = " and ".join(f"({each.text})" for each in (first, *more))
    return Condition(text, first.node, first.reader)


def refuse(condition: Condition, fault: syntax.Fault, reader: Reader | None = None, code: str = "") -> None:
    """Tell what is wrong with a condition, under the letters that are meant if the file shows them as they are."""
    reader = reader or condition.reader
    node, span = condition.node, fault.span
    line = reader.line(node.line)
    quote = 0 if isinstance(node, Scalar) and node.plain else 1
    start = node.column - 1 + quote
    if line[start : start + len(condition.text)] == condition.text:
        place, width = Place(node.line, start + span.begin + 1), max(1, span.end - span.begin)
    else:
        part = condition.text[span.begin : span.end]
        place, width = _found(reader, node, part)
    reader.refuse(place, fault.message, expected=fault.expected, hint=fault.hint, width=width, code=code)


def _found(reader: Reader, node: Node, part: str) -> tuple[Place, int]:
    """Where the letters meant stand, in a text that goes over several lines."""
    for number in range(node.line, node.line + 20):
        column = reader.line(number).find(part, node.column - 1 if number == node.line else 0)
        if part and column >= 0:
            return Place(number, column + 1), len(part)
    return Place(node.line, node.column), 1
