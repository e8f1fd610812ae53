"""Rulesets read from YAML files: bases merged in, names looked up, types checked, all faults at once.

A ruleset that cannot be understood is not available; none of its rules is ever skipped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, TypeAlias

from ..errors import Diagnostic, RulesetError, did_you_mean
from ..findings import read_text
from ..strict_yaml import Reader
from ..verdict import Citation, Kind
from ..yaml_nodes import Node
from .ladder import Ladder, Slot
from .language import syntax
from .language.compiler import BUILT_IN, Compiler, Definition, Parameter
from .language.formula import FALSE, Formula, all_of, any_of, facts_of, negated
from .python_rules import PythonRule
from .ranking import RankingCriterion
from .rules import (
    DEFAULT_ORDER,
    Claim,
    Criterion,
    Domain,
    Gate,
    Mirror,
    Order,
    Outcome,
    Part,
    Policy,
    Recognition,
    Rule,
    RulesetText,
    Source,
    Waiver,
)
from .ruleset_draft import (
    SCHEMA,
    Condition,
    Draft,
    Unless,
    refuse,
)
from .ruleset_reader import RECOGNITION, head_of, read_draft
from .tests_file import tests_beside
from .vocabulary import VOCABULARY, Scope, Vocabulary
from .written import WrittenRuleset

__all__ = ["SCHEMA", "Library", "head_of", "load_ruleset", "parse_ruleset", "read_text_of"]

MAX_BASES: Final = 10

Library: TypeAlias = Callable[[str], tuple[str, str]]  # id -> text and source; KeyError where there is none


def load_ruleset(
    path: str | Path,
    library: Library | None = None,
    vocabulary: Vocabulary = VOCABULARY,
    python: Mapping[str, PythonRule] | None = None,
    criteria: Mapping[str, RankingCriterion] | None = None,
) -> WrittenRuleset:
    """Read a ruleset file; see `parse_ruleset`."""
    text = read_text(path, RulesetError)
    return parse_ruleset(text, str(path), library, vocabulary, python, criteria)


def parse_ruleset(
    text: str,
    source: str = "ruleset",
    library: Library | None = None,
    vocabulary: Vocabulary = VOCABULARY,
    python: Mapping[str, PythonRule] | None = None,
    criteria: Mapping[str, RankingCriterion] | None = None,
) -> WrittenRuleset:
    """Read the text of a ruleset file.

    Parameters
    ----------
    text, source
        The text, and what findings call the file.
    library
        Gives the text of a base by its id.
    vocabulary
        The facts that there are.
    python
        Rules of plugins, by name.
    criteria
        Criteria of plugins for the order in a ring of ships.

    Raises
    ------
    RulesetError
        With all that is wrong.
    """
    found = read_text_of(text, source, library, vocabulary, python, criteria)
    ranked = {name: each.value for name, each in (criteria or {}).items()}
    return WrittenRuleset(found, python, ranked)


def read_text_of(
    text: str,
    source: str,
    library: Library | None = None,
    vocabulary: Vocabulary = VOCABULARY,
    python: Mapping[str, PythonRule] | None = None,
    criteria: Mapping[str, RankingCriterion] | None = None,
) -> RulesetText:
    """Read the text of a ruleset file into what it says; see `parse_ruleset`."""
    drafts = _lineage(read_draft(text, source, vocabulary), library, vocabulary)
    return _Weaver(drafts, vocabulary, frozenset(python or ()), frozenset(criteria or ())).ruleset()


def _lineage(draft: Draft, library: Library | None, vocabulary: Vocabulary) -> list[Draft]:
    """The draft and its bases, the most basic first."""
    drafts = [draft]
    while (base := drafts[-1].extends) is not None:
        reader = drafts[-1].reader
        if base.text in [each.id for each in drafts] or len(drafts) > MAX_BASES:
            reader.stop(base, f"'{base.text}' is a base of itself", width=len(base.text))
        try:
            text, source = _base(base.text, Path(drafts[-1].path), library)
        except KeyError as error:
            hint = str(error.args[0]) if error.args else ""
            reader.stop(base, f"unknown base '{base.text}'", hint=hint, width=len(base.text))
        try:
            drafts.append(read_draft(text, source, vocabulary))
        except RulesetError as error:
            count = len(error.diagnostics)
            first = str(error.diagnostics[0]).splitlines()[0]
            message = f"the base '{base.text}' cannot be used: {count} finding(s), first {first}"
            reader.stop(base, message, hint=f"run `ccas check {source}`", width=len(base.text))
    return drafts[::-1]


def _base(name: str, beside: Path, library: Library | None) -> tuple[str, str]:
    """Text and source of a base: a file beside this one, or one that the library knows."""
    if name.endswith((".yaml", ".yml")):
        path = beside.parent / name
        try:
            found = path.is_file()
        except OSError:  # the name is too long, and the like
            found = False
        if not found:
            raise KeyError(f"there is no file {name[:60]} beside this one")
        return read_text(path, RulesetError), str(path)
    if library is None:
        raise KeyError("no rulesets are installed")
    return library(name)


@dataclass(slots=True)
class _Weaver:
    """Merges drafts from the most basic on, and compiles the result."""

    drafts: list[Draft]
    vocabulary: Vocabulary
    python: frozenset[str]
    criteria: frozenset[str]
    ladder: Ladder = field(default_factory=Ladder)
    compiler: Compiler = field(init=False)

    def ruleset(self) -> RulesetText:
        last = self.drafts[-1]
        definitions: dict[str, tuple[Definition, Condition]] = {}
        parameters: dict[str, tuple[Parameter, Node]] = {}
        regimes: dict[str, tuple[str, Node]] = {}
        for draft in self.drafts:
            definitions |= draft.definitions
            parameters |= draft.parameters
            regimes |= draft.regimes
            self.ladder.stack(draft)
        self.compiler = Compiler(
            vocabulary=self.vocabulary,
            parameters={name: each for name, (each, _) in parameters.items()},
            definitions={name: each for name, (each, _) in definitions.items()},
            regimes={name: each for name, (each, _) in regimes.items()},
        )
        self._names_apart(definitions, parameters)
        for name, (_, condition) in definitions.items():
            self._definition(name, condition)
        recognition = self._recognition()
        gates = self._gates()
        rules = tuple(self._rule(slot, gates) for slot in self.ladder.slots)
        otherwise = next((d.otherwise for d in reversed(self.drafts) if d.otherwise), None)
        if otherwise is None and not last.abstract:
            hint = "otherwise: {cite: {article: …}}, say the article on general care"
            last.reader.refuse(Node(1, 1), "nothing is said of what holds where no rule applies", hint=hint)
        if not rules and not last.abstract:
            last.reader.refuse(Node(1, 1), "a ruleset without rules", hint="write them under 'rules'")
        domain, resolve_by, waivers = self._domain(), self._resolve_by(), self._waivers(rules)
        self._finish()
        return RulesetText(
            id=last.id,
            version=last.version,
            title=last.title,
            description=last.description,
            regulation=last.regulation or self._first(lambda d: d.regulation),
            edition=last.edition or self._first(lambda d: d.edition),
            abstract=last.abstract,
            lineage=tuple(draft.id for draft in self.drafts[-2::-1]),
            vocabulary=self.vocabulary,
            parameters=self.compiler.parameters,
            tangents=self.compiler.tangents,
            definitions=self.compiler.definitions,
            regimes=self.compiler.regimes,
            policy=next((d.policy for d in reversed(self.drafts) if d.policy), Policy.FIRST),
            mirror=next((d.mirror for d in reversed(self.drafts) if d.mirror), Mirror.AUTO),
            recognition=recognition,
            gates=tuple(gate for _, gate in gates),
            rules=rules,
            otherwise=otherwise or Citation(regulation="", article=""),
            resolve_by=resolve_by,
            domain=domain,
            waivers=waivers,
            claims=self._claims(),
            inline=last.tests,
            beside=tests_beside(last.path, last.id, self.vocabulary),
            source=last.path,
            lint=lambda: tuple(self._remarks(definitions, parameters, regimes, rules)),
        )

    def _first(self, get: Callable[[Draft], str]) -> str:
        return next((found for draft in reversed(self.drafts) if (found := get(draft))), "")

    # -- findings --------------------------------------------------------------------------------

    def _finish(self) -> None:
        told = [each for draft in self.drafts[::-1] for each in draft.reader.told()]
        if told:
            raise RulesetError(*told)

    # -- conditions ------------------------------------------------------------------------------

    def _names_apart(
        self,
        definitions: Mapping[str, tuple[Definition, Condition]],
        parameters: Mapping[str, tuple[Parameter, Node]],
    ) -> None:
        for name in sorted(definitions.keys() & parameters.keys()):
            condition = definitions[name][1]
            condition.reader.refuse(
                condition.node, f"'{name}' is a parameter and a definition", hint="rename one of the two"
            )
        taken = {*BUILT_IN, *self.vocabulary.places[Scope.PAIR]}
        for draft in self.drafts:
            places = {name: condition.node for name, (_, condition) in draft.definitions.items()}
            places |= {name: node for name, (_, node) in draft.parameters.items()}
            for name in sorted(places.keys() & taken):
                hint = "rename it: the word has a meaning already, see `ccas facts`"
                draft.reader.refuse(places[name], f"'{name}' cannot be defined", hint=hint)

    def _definition(self, name: str, condition: Condition) -> None:
        try:
            self.compiler.definition(name)
        except syntax.Fault as fault:
            self.compiler.broken.add(name)
            refuse(condition, fault)

    def _formula(self, condition: Condition) -> Formula:
        try:
            return self.compiler.condition(condition.text)
        except syntax.Fault as fault:
            refuse(condition, fault)
            return FALSE

    def _recognition(self) -> Recognition | None:
        found: dict[str, Condition] = {}
        for draft in self.drafts:
            found |= draft.recognition
        if not found:
            return None
        if "risk" not in found:
            first = next(iter(found.values()))
            hint = "say under 'encounter' when there is a risk of collision"
            first.reader.refuse(first.node, "encounters are recognised, and no risk with them", hint=hint)
        return Recognition(
            **{key: self._formula(found[key]) if key in found else FALSE for key in RECOGNITION}
        )

    def _gates(self) -> list[tuple[Draft, Gate]]:
        gates: list[tuple[Draft, Gate]] = []
        ids = self.ladder.ids
        for draft in self.drafts:
            for gate in draft.gates:
                gates = [
                    each for each in gates if each[1].id != gate.id
                ]  # one of a base, which this replaces
                off: list[str] = []
                for name in gate.off:
                    stem = name.text.removesuffix(".*")
                    hits = [
                        i for i in ids if i == name.text or (stem != name.text and i.startswith(f"{stem}."))
                    ]
                    if not hits:
                        hint = did_you_mean(name.text, ids)
                        gate.reader.refuse(name, f"no rule '{name.text}' to switch off", hint=hint)
                    off += hits
                formula = all_of(self._formula(each) for each in gate.when)
                source = self._source(gate.reader, gate.node)
                gates.append(
                    (
                        draft,
                        Gate(
                            id=gate.id, formula=formula, citation=gate.citation, off=tuple(off), source=source
                        ),
                    )
                )
        return gates

    def _rule(self, slot: Slot, gates: list[tuple[Draft, Gate]]) -> Rule:
        draft = slot.rule
        parts = [
            *(Part("where", self._where(each)) for each in draft.where),
            *(Part("when", self._formula(each)) for each in draft.when),
            *(Part("unless", negated(self._exception(each))) for each in draft.unless),
            *(Part(f"gate {gate.id}", negated(gate.formula)) for _, gate in gates if draft.id in gate.off),
        ]
        if draft.python and draft.python not in self.python:
            hint = (
                did_you_mean(draft.python, self.python) if self.python else "no plugin offers rules in Python"
            )
            draft.reader.refuse(draft.python_node, f"unknown Python rule '{draft.python}'", hint=hint)
        return Rule(
            id=draft.id,
            condition=all_of(part.formula for part in parts),
            parts=tuple(parts),
            outcome=draft.outcome or _LEFT_TO_PYTHON,
            citation=slot.citation,
            because=draft.because,
            source=self._source(draft.reader, draft.node),
            origin=draft.origin,
            python=draft.python,
            note=draft.note,
        )

    def _where(self, condition: Condition) -> Formula:
        formula = self._formula(condition)
        odd = sorted(name for name in facts_of(formula) if not name.startswith("waterway."))
        if odd:
            hint = f"'{odd[0]}' is no fact of a waterway: put this under 'when'"
            condition.reader.refuse(condition.node, "'where' is about waters only", hint=hint)
        return formula

    def _exception(self, exception: Unless) -> Formula:
        met = all_of(self._formula(each) for each in exception.when)
        return all_of([met, negated(any_of(self._exception(each) for each in exception.unless))])

    def _source(self, reader: Reader, node: Node) -> Source:
        return Source(file=reader.source, line=node.line, column=node.column, excerpt=reader.line(node.line))

    # -- the rest --------------------------------------------------------------------------------

    def _domain(self) -> Domain:
        domain = Domain()
        assume: list[Formula] = []
        for draft in self.drafts:
            for name in ("speed", "length", "separation"):
                value = getattr(draft, name)
                if value is not None:
                    domain = replace(domain, **{name: value})
            assume += [self._formula(each) for each in draft.assume]
        return replace(domain, assume=tuple(assume))

    def _resolve_by(self) -> tuple[Order, ...]:
        for draft in reversed(self.drafts):
            if draft.resolve_by is None:
                continue
            known = {each.value for each in Criterion} | self.criteria
            for order, node in draft.resolve_by:
                if order.criterion not in known:
                    hint = did_you_mean(order.criterion, known)
                    draft.reader.refuse(node, f"unknown criterion '{order.criterion}'", hint=hint)
            return tuple(order for order, _ in draft.resolve_by)
        return DEFAULT_ORDER

    def _claims(self) -> tuple[Claim, ...]:
        return tuple(
            Claim(
                name=claim.name,
                check=claim.check,
                assume=tuple(self._formula(each) for each in claim.assume),
                texts=tuple(each.text for each in claim.assume),
                on_a_reach=claim.on_a_reach,
                source=self._source(claim.reader, claim.node),
            )
            for claim in self.drafts[-1].claims
        )

    def _waivers(self, rules: Iterable[Rule]) -> tuple[Waiver, ...]:
        ids = [rule.id for rule in rules]
        waivers = []
        for draft in self.drafts:
            for waiver in draft.waivers:
                for name in waiver.rules:
                    if name.text not in ids and draft is self.drafts[-1]:
                        hint = did_you_mean(name.text, ids)
                        waiver.reader.refuse(name, f"no rule '{name.text}' here", hint=hint)
                if draft is self.drafts[-1]:
                    waivers.append(
                        Waiver(
                            check=waiver.check,
                            reason=waiver.reason,
                            expires=waiver.expires,
                            rules=tuple(name.text for name in waiver.rules),
                            source=self._source(waiver.reader, waiver.node),
                        )
                    )
        return tuple(waivers)

    def _remarks(
        self,
        definitions: Mapping[str, tuple[Definition, Condition]],
        parameters: Mapping[str, tuple[Parameter, Node]],
        regimes: Mapping[str, tuple[str, Node]],
        rules: Iterable[Rule],
    ) -> Iterable[Diagnostic]:
        """What the author may have overlooked; only of this file, not of its bases."""
        from .lint import remarks

        last = self.drafts[-1]
        own = {
            "definition": {n: c.node for n, (_, c) in definitions.items() if n in last.definitions},
            "parameter": {n: node for n, (_, node) in parameters.items() if n in last.parameters},
            "regime": {n: node for n, (_, node) in regimes.items() if n in last.regimes},
        }
        reader = Reader(last.reader.content, last.reader.source, RulesetError)
        return remarks(reader, last, own, self.compiler.used, tuple(rules))


_LEFT_TO_PYTHON: Final = Outcome(kind=Kind.NONE)
