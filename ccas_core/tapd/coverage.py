"""How well tests cover a ruleset: rules that no case reaches, and faults that no case would notice.

A mutant is the ruleset with one rule dropped, or with its condition turned round.  A mutant under which all
cases still pass survives: nothing that the tests say depends on that rule.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

from .case_run import Result, judge_case, run_case
from .cases import Case
from .written import WrittenRuleset


class Change(StrEnum):
    """What a mutant does to a rule."""

    DROPPED = "dropped"
    NEGATED = "negated"


@dataclass(frozen=True, slots=True)
class Mutant:
    """A ruleset with one fault in it, and the case that notices it; empty where none does."""

    rule: str
    change: Change
    killed_by: str

    @property
    def survives(self) -> bool:
        """Whether no case notices."""
        return not self.killed_by


@dataclass(frozen=True, slots=True, kw_only=True)
class Coverage:
    """Rules of a ruleset, those that decide a case, and all mutants."""

    rules: tuple[str, ...]
    reached: frozenset[str]
    mutants: tuple[Mutant, ...]

    @property
    def missed(self) -> tuple[str, ...]:
        """Rules that decide no case."""
        return tuple(rule for rule in self.rules if rule not in self.reached)

    @property
    def survivors(self) -> tuple[Mutant, ...]:
        """Mutants that no case notices."""
        return tuple(mutant for mutant in self.mutants if mutant.survives)


def own_cases(ruleset: WrittenRuleset, cases: Iterable[Case] = ()) -> list[Case]:
    """Cases that expect something of a ruleset: its own tests, and those of files."""
    given = (case for case in cases if ruleset.id in case.expected and case.ships)
    return [*ruleset.text.tests, *given]


def reached(ruleset: WrittenRuleset, cases: Sequence[Case]) -> frozenset[str]:
    """Rules that decide one of the cases."""
    return frozenset(
        settlement.one.rule for case in cases for settlement in judge_case(ruleset, case).settlements
    )


def covered(ruleset: WrittenRuleset, cases: Sequence[Case], *, mutants: bool = True) -> Coverage:
    """Run all cases against all mutants, if asked for; those that fail without any are left out."""
    sound = [case for case in cases if run_case(ruleset, case, case.expected[ruleset.id]).passed]
    return Coverage(
        rules=tuple(rule.id for rule in ruleset.text.rules),
        reached=reached(ruleset, sound),
        mutants=tuple(_mutants(ruleset, sound)) if mutants else (),
    )


def _mutants(ruleset: WrittenRuleset, cases: Sequence[Case]) -> Iterator[Mutant]:
    for index, rule in enumerate(ruleset.text.rules):
        for change in Change:
            mutant = ruleset.mutated(index, negated=change is Change.NEGATED)
            yield Mutant(rule.id, change, _killer(mutant, cases, rule.id))


def _killer(mutant: WrittenRuleset, cases: Sequence[Case], rule: str) -> str:
    """First case that fails; those that name the rule are tried first."""
    near = sorted(cases, key=lambda case: case.expected[mutant.id].rule != rule)
    for case in near:
        if not _result(mutant, case).passed:
            return case.id
    return ""


def _result(ruleset: WrittenRuleset, case: Case) -> Result:
    return run_case(ruleset, case, case.expected[ruleset.id])
