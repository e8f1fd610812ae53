"""The value of a formula where facts may be unknown, part by part: what an explanation shows.

`and`, `or` and `not` are Kleene's: unknown and false is false, unknown or true is true.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from .formula import And, Constant, Formula, Measure, Named, Not, Or

Truth = bool | None  # None: not known


@dataclass(frozen=True, slots=True)
class Finding:
    """A part of a condition, its value, and what it is made of.

    What is negated has the parts of what it negates.
    """

    text: str
    value: Truth
    measure: Measure | None
    parts: tuple[Finding, ...]
    formula: Formula

    def leaves(self) -> Iterator[Finding]:
        """All parts that are not made of others."""
        if not self.parts:
            yield self
        for part in self.parts:
            yield from part.leaves()


def examine(formula: Formula, decide: Callable[[Formula], Truth], say: Callable[[Formula], str]) -> Finding:
    """Evaluate a formula and all its parts.

    Parameters
    ----------
    formula
        What to evaluate.
    decide
        Value of a part that is not made of others; None where a fact that it looks at is not known.
    say
        How such a part is written.
    """
    match formula:
        case Constant():
            return Finding(str(formula.value).lower(), formula.value, None, (), formula)
        case Not():
            part = examine(formula.part, decide, say)
            value = None if part.value is None else not part.value
            return Finding(f"not {part.text}", value, part.measure, part.parts, formula)
        case And() | Or():
            parts = tuple(examine(part, decide, say) for part in formula.parts)
            conjunctive = isinstance(formula, And)
            values = [part.value for part in parts]
            value = (
                (not conjunctive) if (not conjunctive) in values else None if None in values else conjunctive
            )
            return Finding("all of" if conjunctive else "one of", value, None, parts, formula)
        case Named():
            if formula.measure is not None:
                return Finding(formula.name, decide(formula.part), formula.measure, (), formula)
            inner = examine(formula.part, decide, say)
            parts = inner.parts if isinstance(formula.part, And | Or) else (inner,)
            return Finding(
                formula.name, inner.value, None, parts if inner.text != formula.name else (), formula
            )
        case _:
            return Finding(say(formula), decide(formula), None, (), formula)
