"""The ladder of rules: those of the bases, with what a file removes, replaces, adds and cites anew."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..errors import did_you_mean
from ..verdict import Citation
from ..yaml_nodes import Scalar
from .ruleset_draft import Draft, DraftRule


@dataclass(slots=True)
class Slot:
    """A rule at its place."""

    rule: DraftRule
    citation: Citation


@dataclass(slots=True)
class Ladder:
    """Rules in the order in which they are tried."""

    slots: list[Slot] = field(default_factory=list)

    @property
    def ids(self) -> list[str]:
        """Ids of all rules, in order."""
        return [slot.rule.id for slot in self.slots]

    def stack(self, draft: Draft) -> None:
        """Put the rules of a draft into the ladder of its bases; its reader takes the findings.

        A rule that names no place stands behind the one before it in the file.
        """
        for name in draft.removed:
            if (at := self._place(draft, name, "removed")) is not None:
                del self.slots[at]
        inherited = bool(self.slots)
        last: int | None = None
        for rule in draft.rules:
            if rule.replaces is not None:
                last = self._replace(draft, rule, rule.replaces, last)
            elif not self._is_taken(draft, rule):
                last = self._insert(draft, rule, last, inherited=inherited)
        for id_, (citation, node) in draft.recited.items():
            name = Scalar(node.line, node.column, id_)
            if (at := self._place(draft, name, "cited anew")) is not None:
                self.slots[at].citation = citation

    def _replace(self, draft: Draft, rule: DraftRule, name: Scalar, last: int | None) -> int | None:
        at = self._place(draft, name, "replaced")
        if at is None or (rule.id != name.text and self._is_taken(draft, rule)):
            return last
        self.slots[at] = Slot(rule, rule.citation)
        return at

    def _insert(self, draft: Draft, rule: DraftRule, last: int | None, *, inherited: bool) -> int | None:
        near = rule.before or rule.after
        at = last
        if near is not None:
            found = self._place(draft, near, "found")
            if found is None:
                return last
            at = found - 1 if near is rule.before else found
        elif last is None and inherited:
            hint = "say 'before: ID', 'after: ID' or 'replaces: ID'; rules that follow stand behind it"
            message = f"where in the ladder of the base does '{rule.id}' stand?"
            draft.reader.refuse(rule.node, message, hint=hint, width=len(rule.id))
            return last
        at = len(self.slots) - 1 if at is None else at
        self.slots.insert(at + 1, Slot(rule, rule.citation))
        return at + 1

    def _is_taken(self, draft: Draft, rule: DraftRule) -> bool:
        if rule.id not in self.ids:
            return False
        hint = f"say 'replaces: {rule.id}' to put this in its place, or rename it"
        message = f"the base has a rule '{rule.id}' already"
        draft.reader.refuse(rule.node, message, hint=hint, width=len(rule.id))
        return True

    def _place(self, draft: Draft, name: Scalar, what: str) -> int | None:
        ids = self.ids
        if name.text in ids:
            return ids.index(name.text)
        hint = did_you_mean(name.text[:60], ids)
        message = f"there is no rule '{name.text[:60]}' to be {what}"
        draft.reader.refuse(name, message, hint=hint, width=len(name.text))
        return None
