"""Properties that a ruleset claims of some ships only: the same questions, with further assumptions."""

from __future__ import annotations

from dataclasses import replace

from ..tapd.language.formula import Formula
from ..tapd.rules import Claim
from ..tapd.written import WrittenRuleset
from .cycles import acyclic
from .findings import Finding
from .pairs import complete, consistent
from .questions import Questions
from .solver import Budget


def claimed(ruleset: WrittenRuleset, claim: Claim, budget: Budget, max_ships: int = 4) -> Finding:
    """Settle a claim; the finding has its name."""
    narrow = assuming(ruleset, *claim.assume)
    if claim.check == "acyclic":
        found = acyclic(narrow, budget, max_ships, reach_only=claim.on_a_reach)
    else:
        questions = Questions((narrow, narrow), budget)
        found = complete(questions) if claim.check == "complete" else consistent(questions)
    of = f"of ships for which {' and '.join(claim.texts)}" + (" on a reach" if claim.on_a_reach else "")
    return replace(found, property=claim.name, notes=(*found.notes, f"{claim.check} {of}"))


def assuming(ruleset: WrittenRuleset, *conditions: Formula) -> WrittenRuleset:
    """The same ruleset for the ships of its domain for which further conditions hold."""
    text = ruleset.text
    domain = replace(text.domain, assume=(*text.domain.assume, *conditions))
    return ruleset.with_text(replace(text, domain=domain))
