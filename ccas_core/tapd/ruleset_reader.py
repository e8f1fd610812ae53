"""Ruleset files read into drafts: every key is checked, and all that is wrong is told at once."""

from __future__ import annotations

import re
from enum import StrEnum
from typing import Final

from ..errors import RulesetError
from ..roles import PassingSide
from ..strict_yaml import Block, Reader
from ..verdict import Kind
from ..yaml_nodes import Mapping as Keys
from ..yaml_nodes import Node, Scalar, Sequence
from .case_file import read_tests
from .language import syntax
from .language.compiler import UNITS, Definition, Parameter
from .rules import Diagnosis, Mirror, Order, Outcome, Policy, Side, Strength
from .ruleset_draft import (
    SCHEMA,
    Draft,
    DraftClaim,
    DraftGate,
    DraftRule,
    DraftWaiver,
    Unless,
    joined,
)
from .ruleset_values import ValueReader
from .vocabulary import Vocabulary

RECOGNITION: Final = ("risk", "overtaking", "head_on", "crossing", "from_starboard")
_ID: Final = re.compile(r"[a-z][a-z0-9]*(?:[._-][a-z0-9]+)*")
_VERSION: Final = re.compile(r"[0-9]+(?:\.[0-9A-Za-z-]+)*")


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


class Claimed(StrEnum):
    """Properties that may be claimed of some ships only."""

    ACYCLIC = "acyclic"
    COMPLETE = "complete"
    CONSISTENT = "consistent"


class Passing(StrEnum):
    """How binding a passing side is."""

    REQUIRED = "required"
    PREFERRED = "preferred"


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


class _DraftReader(ValueReader):
    """Reads one file, block by block."""

    def __init__(self, text: str, source: str, vocabulary: Vocabulary) -> None:
        super().__init__(Reader(text, source, RulesetError))
        self._source, self._vocabulary = source, vocabulary
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
        self._claims(draft, root.find("claims"))
        draft.tests = read_tests(reader, root.find("tests"), self._id, self._vocabulary)
        root.done()
        return draft

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

    def _definitions(self, draft: Draft, node: Node | None) -> None:
        for key, value in self._reader.entries(node):
            match = re.fullmatch(r"([A-Za-z_][A-Za-z0-9_]*)(?:\(([A-Za-z_, ]*)\))?", key.text)
            if match is None or not syntax.is_name(match[1]):
                expected = "a name, or a name with its ships: small(ship)"
                self._reader.refuse(key, f"'{key.text[:40]}' cannot be defined", expected=expected)
                continue
            ships = tuple(name.strip() for name in match[2].split(",")) if match[2] is not None else ()
            if len(ships) > 2 or len(set(ships)) < len(ships) or not all(map(syntax.is_name, ships)):
                expected = "the names of one or two ships: small(ship)"
                self._reader.refuse(key, f"'{key.text[:40]}' cannot be defined", expected=expected)
                continue
            if match[1] in draft.definitions:
                self._reader.refuse(key, f"a second definition '{match[1]}'", hint="rename one of the two")
                continue
            conditions = self._conditions(value)
            if not conditions:
                continue
            condition = joined(conditions)
            expression = self._parsed(condition)
            if expression is not None:
                draft.definitions[match[1]] = Definition(ships, expression, condition.text), condition

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
                draft.recognition[key] = joined(conditions)
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

    def _exceptions(self, node: Node | None) -> tuple[Unless, ...]:
        if node is None:
            return ()
        nodes = node.items if isinstance(node, Sequence) else (node,)
        found = []
        for each in nodes:
            if not isinstance(each, Keys):
                found.append(Unless(self._conditions(each), (), None))
                continue
            block = self._reader.block(each)
            cite = block.find("cite")
            found.append(
                Unless(
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

    def _claims(self, draft: Draft, node: Node | None) -> None:
        names: dict[str, Node] = {}
        for each in self._reader.items(node):
            block = self._reader.block(each)
            where = block.find("on_a_reach")
            claim = DraftClaim(
                name=self._reader.unique(names, block.require("name"), "claim"),
                check=self._reader.choice(block.require("check"), Claimed).value,
                assume=self._conditions(block.require("assume")),
                on_a_reach=self._reader.flag(where) if where else False,
                node=each,
                reader=self._reader,
            )
            self._optional(block, "note")
            if block.done():
                draft.claims.append(claim)

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
