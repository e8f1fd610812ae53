"""What the author of a ruleset may have overlooked, found without a solver; each code has a page.

`remarks` looks at the text of one file, `reviewed` also at its tests and at the calendar; `case_remarks`
looks at encounter files.  The pages are in `code_pages`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from datetime import date
from typing import TYPE_CHECKING, Final

from ..errors import Diagnostic, RulesetError, did_you_mean
from ..findings import Findings, Place
from ..verdict import Confidence, Kind
from ..yaml_nodes import Mapping as Keys
from ..yaml_nodes import Node
from .language.formula import FALSE, TRUE, And, Formula, Named, alike, mirrored, negated
from .rules import Mirror, Rule, RulesetText, Source

if TYPE_CHECKING:
    from ..strict_yaml import Reader
    from .ruleset_draft import Draft
    from .written import WrittenRuleset

_CODES: Final[Mapping[str, str]] = {"definition": "R103", "parameter": "R104", "regime": "R105"}


def remarks(
    reader: Reader,
    draft: Draft,
    names: Mapping[str, Mapping[str, Node]],
    used: set[str],
    rules: tuple[Rule, ...],
) -> Iterable[Diagnostic]:
    """Give remarks on one file; `names` are the definitions, parameters and regimes that it introduces."""
    if not draft.abstract:  # what a base defines is for others
        _unused(reader, names, used)
    written = {rule.id: rule.node for rule in draft.rules}
    own_regulation = bool(draft.regulation and draft.recited)
    earlier: list[tuple[Rule, frozenset[Formula]]] = []
    for rule in rules:
        parts = conjuncts(rule.condition)
        if rule.origin == draft.id and rule.id in written:
            _on_rule(reader, written[rule.id], rule, parts, earlier, mirror=draft.mirror)
        elif rule.origin != draft.id and own_regulation and rule.citation.regulation != draft.regulation:
            hint = f"write it under 'citations': {rule.id}: {{article: …}}"
            message = f"inherited rule '{rule.id}' cites {rule.citation}"
            reader.refuse(Node(1, 1), message, hint=hint, code="R108")
        earlier.append((rule, parts))
    return reader.told()


def _unused(reader: Reader, names: Mapping[str, Mapping[str, Node]], used: set[str]) -> None:
    for what, places in names.items():
        for name, node in places.items():
            key = f"regime.{name}" if what == "regime" else name
            if key not in used:
                hint = "remove it, or is a name misspelt where it should be used?"
                message = f"{what} '{name}' is not used"
                place = _key_place(reader, name, node)
                reader.refuse(place, message, hint=hint, width=len(name), code=_CODES[what])


def _key_place(reader: Reader, name: str, near: Place) -> Place:
    """Where a name is written as a key: at a place, or before it, where the place is that of the value."""
    key = re.compile(rf"(?<![\w.]){re.escape(name)}(?=[\"']?\s*[:(])")
    for number in range(near.line, max(0, near.line - 20), -1):
        if found := key.search(reader.line(number)):
            return Place(number, found.start() + 1)
    return near


def _on_rule(
    reader: Reader,
    node: Node,
    rule: Rule,
    parts: frozenset[Formula],
    earlier: list[tuple[Rule, frozenset[Formula]]],
    *,
    mirror: Mirror | None,
) -> None:
    def remark(code: str, message: str, hint: str) -> None:
        reader.refuse(node, f"rule '{rule.id}' {message}", hint=hint, width=len(rule.id), code=code)

    before = _before(parts, earlier)
    if rule.condition == FALSE or any(negated(part) in parts for part in parts):
        remark("R101", "can never apply", "its condition contradicts itself")
    elif before is not None:
        remark("R102", "is never reached", f"whenever it would apply, '{before.id}' applies before it")
    elif mirror is not Mirror.NONE and _is_two_faced(rule):
        hint = "say which of the two: a condition on own that does not hold for other as well"
        remark("R110", "holds for both ships at once, and obliges each of them alone", hint)
    if rule.citation.confidence is Confidence.UNVERIFIED and not rule.note:
        hint = "say 'confidence: text_seen' or the like; or keep it, with a 'note' that says why"
        remark("R106", "rests on an unverified source", hint)


def _before(parts: frozenset[Formula], earlier: list[tuple[Rule, frozenset[Formula]]]) -> Rule | None:
    """Earlier rule that applies wherever a rule with these parts would, as far as the text alone shows it."""
    for rule, conditions in earlier:
        if not rule.python and (rule.condition == TRUE or conditions <= parts):
            return rule
    return None


def _is_two_faced(rule: Rule) -> bool:
    """Whether a rule that names one ship has a condition that is the same with the ships swapped."""
    one_sided = rule.outcome.kind in (Kind.GIVE_WAY, Kind.STAND_ON, Kind.COOPERATE, Kind.PROHIBITED)
    return one_sided and not rule.python and alike(mirrored(rule.condition), rule.condition)


def conjuncts(formula: Formula) -> frozenset[Formula]:
    """All parts that must hold together; definitions are looked into."""
    found: set[Formula] = set()
    open_ = [formula]
    while open_:
        part = open_.pop()
        if isinstance(part, And):
            open_ += part.parts
        elif isinstance(part, Named) and part.measure is None and isinstance(part.part, And | Named):
            open_.append(part.part)
        else:
            found.add(part.part if isinstance(part, Named) and part.measure is None else part)
    return frozenset(found)


def reviewed(ruleset: WrittenRuleset, content: str, today: date) -> tuple[Diagnostic, ...]:
    """Give all remarks on a ruleset whose file reads so: also on its tests, and waivers that are over."""
    text = ruleset.text
    findings = Findings(content, text.source, RulesetError)
    try:
        told = text.remarks
        _on_tests(findings, text)
        _untested(findings, ruleset)
        for waiver in text.waivers:
            if waiver.expires < today:
                hint = "mend what it excuses, or say why it may stand for longer"
                message = f"the waiver of '{waiver.check}' has expired on {waiver.expires}"
                findings.refuse(_place(waiver.source), message, hint=hint, code="R109")
    except RulesetError as too_many:
        return too_many.diagnostics
    return tuple(sorted((*told, *findings.told()), key=lambda each: (each.line, each.column)))


def _on_tests(findings: Findings, text: RulesetText) -> None:
    """Names in tests that nothing answers to: the test would not say what its author means."""
    rules = [rule.id for rule in text.rules]
    for case in text.tests:
        at = Place(case.line, _column(findings.line(case.line)))
        for expected in case.expected.values():
            if expected.rule and expected.rule not in rules:
                message = f"test '{case.id}' expects a rule '{expected.rule}' that there is not"
                findings.refuse(at, message, hint=did_you_mean(expected.rule, rules), code="R112")
        for regime in str(case.waterway.get("regime", "")).split():
            if regime not in text.regimes:
                message = f"test '{case.id}' names a regime '{regime}' that there is not"
                findings.refuse(at, message, hint=did_you_mean(regime, text.regimes), code="R111")


def _untested(findings: Findings, ruleset: WrittenRuleset) -> None:
    from .coverage import reached

    text = ruleset.text
    tested = frozenset() if text.abstract else reached(ruleset, text.tests)
    for rule in () if text.abstract else text.rules:
        if rule.origin == text.id and rule.id not in tested:
            hint = f"write one under 'tests', with 'expect: {{by: {rule.id}, …}}'"
            message = f"rule '{rule.id}' has no test"
            findings.refuse(_place(rule.source), message, hint=hint, width=len(rule.id), code="R107")


def _place(source: Source) -> Place:
    return Place(source.line, source.column)


def _column(line: str) -> int:
    """Column of the first letter of a list item.

    >>> _column("  - name: x")
    5
    """
    return len(line) - len(line.lstrip(" -")) + 1


def case_remarks(reader: Reader, rulesets: Collection[str]) -> tuple[Diagnostic, ...]:
    """Give remarks on an encounter file: rulesets of which it expects something, and that there are not."""
    told: set[str] = set()
    for key in ("golden_cases", "cases", "hard_cases"):
        for case in reader.items(_value(reader.root, key)):
            for name, _ in reader.entries(_value(case, "expected")):
                if name.text not in rulesets and name.text not in told:
                    told.add(name.text)
                    message = f"ruleset '{name.text}' is not installed"
                    hint = did_you_mean(name.text[:40], rulesets)
                    reader.refuse(name, message, hint=hint, width=len(name.text), code="R113")
    return reader.told()


def _value(node: Node, key: str) -> Node | None:
    entries = node.entries if isinstance(node, Keys) else ()
    return next((value for name, value in entries if name.text == key), None)
