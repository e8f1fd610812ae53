"""What the author of a ruleset may have overlooked, found without a solver; each finding has a code and a page."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Final

from ..errors import Diagnostic
from ..verdict import Confidence
from ..yaml_nodes import Node
from .language.formula import FALSE, TRUE, And, Formula, negated, walk
from .rules import Mirror, Rule

if TYPE_CHECKING:
    from ..strict_yaml import Reader
    from .ruleset_draft import Draft

REMARKS: Final[Mapping[str, str]] = {
    "R101": "rule can never apply",
    "R102": "rule stands behind one that always decides before it",
    "R103": "definition is not used",
    "R104": "parameter is not used",
    "R105": "regime is not used",
    "R106": "rule cites an article without saying how well it was seen",
    "R107": "rule has no test",
    "R108": "rule cites another regulation than the ruleset's",
    "R109": "waiver has expired",
    "R110": "rule that can apply both ways round gives both ships the same part",
}


def remarks(
    reader: Reader,
    draft: Draft,
    names: Mapping[str, Mapping[str, Node]],
    used: set[str],
    rules: tuple[Rule, ...],
) -> Iterable[Diagnostic]:
    """Give remarks on one file; `names` are the definitions, parameters and regimes that it introduces."""
    own = {rule.id: rule for rule in draft.rules}
    _unused(reader, names, used)
    earlier: list[Rule] = []
    for rule in rules:
        written = own.get(rule.id)
        if written is not None and rule.origin == draft.id:
            _unreachable(reader, written.node, rule, earlier)
            if rule.citation.confidence is Confidence.UNVERIFIED and not rule.note:
                hint = "say 'confidence: text_seen' or the like; or keep it, with a 'note' that says why"
                reader.refuse(written.node, f"rule '{rule.id}' rests on an unverified source", hint=hint,
                              width=len(rule.id), code="R106")  # fmt: skip
        elif (
            rule.origin != draft.id
            and draft.regulation
            and rule.citation.regulation != draft.regulation
            and draft.recited
        ):
            hint = f"write it under 'citations': {rule.id}: {{article: …}}"
            message = f"inherited rule '{rule.id}' cites {rule.citation}"
            reader.refuse(Node(1, 1), message, hint=hint, code="R108")
        earlier.append(rule)
    return reader.told()


def _unused(reader: Reader, names: Mapping[str, Mapping[str, Node]], used: set[str]) -> None:
    codes = {"definition": "R103", "parameter": "R104", "regime": "R105"}
    for what, places in names.items():
        for name, node in places.items():
            key = f"regime.{name}" if what == "regime" else name
            if key not in used:
                hint = "remove it, or is a name misspelt where it should be used?"
                reader.refuse(
                    node, f"{what} '{name}' is not used", hint=hint, width=len(name), code=codes[what]
                )


def _unreachable(reader: Reader, node: Node, rule: Rule, earlier: list[Rule]) -> None:
    """Say that a rule cannot apply, as far as its text alone shows it; the proofs find the rest."""
    parts = _conjuncts(rule.condition)
    if rule.condition == FALSE or any(negated(part) in parts for part in parts):
        hint = "its condition contradicts itself"
        reader.refuse(node, f"rule '{rule.id}' can never apply", hint=hint, width=len(rule.id), code="R101")
        return
    for before in earlier:
        if before.condition == TRUE or _conjuncts(before.condition) <= parts:
            if before.python:
                continue
            hint = f"whenever it would apply, '{before.id}' applies before it"
            reader.refuse(
                node, f"rule '{rule.id}' is never reached", hint=hint, width=len(rule.id), code="R102"
            )
            return


def _conjuncts(formula: Formula) -> frozenset[Formula]:
    """All parts that must hold together."""
    found: set[Formula] = set()
    for part in [formula]:
        if isinstance(part, And):
            for each in part.parts:
                found |= _conjuncts(each)
        else:
            found.add(part)
    return frozenset(found)


__all__ = ["REMARKS", "Mirror", "remarks", "walk"]
