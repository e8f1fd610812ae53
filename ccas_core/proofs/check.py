"""All properties of a ruleset, one after the other, with its waivers."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace
from datetime import date
from functools import cached_property
from typing import Final, Protocol

from ..errors import Diagnostic, RulesetError
from ..tapd.language import syntax
from ..tapd.language.compiler import Compiler
from ..tapd.rules import Claim, Waiver
from ..tapd.written import WrittenRuleset
from . import borders, claims, cycles, pairs, roles
from .branches import unfolded
from .findings import Fault, Finding, Outcome
from .questions import Questions
from .solver import Budget

BUDGET: Final = 60.0  # for all properties of a ruleset [s]
MAX_SHIPS: Final = 4  # of rings that are looked for


class Progress(Protocol):
    """Whoever is told how proving goes."""

    def begun(self, ruleset: str, name: str) -> None:
        """Take note that a property is looked at."""

    def done(self, ruleset: str, finding: Finding) -> None:
        """Take note of what came of it."""


class Silence:
    """Takes note of nothing."""

    def begun(self, ruleset: str, name: str) -> None:
        """Say nothing."""

    def done(self, ruleset: str, finding: Finding) -> None:
        """Say nothing."""


@dataclass(eq=False)
class Task:
    """A ruleset that is looked at, and how much may be spent on it."""

    ruleset: WrittenRuleset
    budget: Budget
    max_ships: int

    @cached_property
    def questions(self) -> Questions:
        """What may be asked of two ships."""
        return Questions((self.ruleset, self.ruleset), self.budget)

    @cached_property
    def followed(self) -> tuple[Task, tuple[str, ...]]:
        """The same with a rule for each way through one in Python, and what could not be followed."""
        if not any(rule.python for rule in self.ruleset.text.rules):
            return self, ()
        ruleset, left = unfolded(self.ruleset)
        return Task(ruleset, self.budget, self.max_ships), left


@dataclass(frozen=True, slots=True)
class Property:
    """A property by its name, and how to look at it; None where a ruleset cannot have it."""

    name: str
    ask: Callable[[Task], Finding | None]


def _followed(ask: Callable[[Questions], Finding | None]) -> Callable[[Task], Finding | None]:
    """Ask about the ways through rules in Python; they themselves judge the ships that come of it."""

    def asked(task: Task) -> Finding | None:
        ways, left = task.followed
        finding = ask(ways.questions)
        return finding and replace(finding, notes=finding.notes + left)

    return asked


# The cheap ones come first, and those on which the others rest.
PROPERTIES: Final = (
    Property("domain_not_empty", lambda task: pairs.domain_not_empty(task.questions)),
    Property("mirror_sound", lambda task: pairs.mirror_sound(task.questions)),
    Property("consistent", _followed(pairs.consistent)),
    Property("complete", _followed(pairs.complete)),
    Property("exclusive", _followed(pairs.exclusive)),
    Property("tie_break_total", lambda task: pairs.tie_break_total(task.questions)),
    Property("no_dead_rule", lambda task: pairs.no_dead_rule(task.questions)),
    Property("no_irrelevant_rule", lambda task: pairs.no_irrelevant_rule(task.questions)),
    Property("role_stable", lambda task: roles.role_stable(task.questions)),
    Property("acyclic", lambda task: cycles.acyclic(task.ruleset, task.budget, task.max_ships)),
    Property("parameters", lambda task: pairs.parameters(task.ruleset, task.budget)),
)


def check(
    ruleset: WrittenRuleset,
    *,
    today: date,
    budget_s: float = BUDGET,
    max_ships: int = MAX_SHIPS,
    only: Collection[str] = (),
    progress: Progress | None = None,
) -> tuple[Finding, ...]:
    """Look at all properties of a ruleset, or at some, with its waivers.

    Parameters
    ----------
    ruleset
        From a file.
    today
        By which waivers expire.
    budget_s
        Time for all of it [s]; what is left over when it is spent is undecided.
    max_ships
        Of rings that are looked for.
    only
        Names of properties; none: all.
    progress
        Is told before and after each property.
    """
    watch = progress or Silence()
    task = Task(ruleset, Budget(budget_s), max_ships)
    found = []
    for each in (*PROPERTIES, *map(_claim, ruleset.text.claims)):
        if only and each.name not in only:
            continue
        watch.begun(ruleset.id, each.name)
        finding = each.ask(task)
        if finding is not None:
            finding = waived(finding, ruleset.text.waivers, today)
            watch.done(ruleset.id, finding)
            found.append(finding)
    return tuple(found)


def names_of(ruleset: WrittenRuleset) -> tuple[str, ...]:
    """Names of the properties of a ruleset, and of what it claims of some ships only."""
    return (*(each.name for each in PROPERTIES), *(claim.name for claim in ruleset.text.claims))


def _claim(claim: Claim) -> Property:
    return Property(claim.name, lambda task: claims.claimed(task.ruleset, claim, task.budget, task.max_ships))


def check_against(
    new: WrittenRuleset,
    old: WrittenRuleset,
    *,
    today: date,
    budget_s: float = BUDGET,
    progress: Progress | None = None,
) -> Finding:
    """Look for ships that a new version judges otherwise than an old one, with the waivers of the new one."""
    watch = progress or Silence()
    watch.begun(new.id, "against")
    finding = waived(borders.against(new, old, Budget(budget_s)), new.text.waivers, today)
    watch.done(new.id, finding)
    return finding


def check_border(
    one: WrittenRuleset,
    other: WrittenRuleset,
    *,
    today: date,
    budget_s: float = BUDGET,
    most: int = borders.MOST,
    progress: Progress | None = None,
) -> Finding:
    """Look at what happens between two ships under two rulesets, with the waivers of both.

    `most` pairs of rules are shown, either way round.
    """
    watch = progress or Silence()
    names = f"{one.id}|{other.id}"
    watch.begun(names, "border")
    finding = borders.border(one, other, Budget(budget_s), most)
    finding = waived(finding, (*one.text.waivers, *other.text.waivers), today)
    watch.done(names, finding)
    return finding


def waived(finding: Finding, waivers: Iterable[Waiver], today: date) -> Finding:
    """The same finding, each of its faults with the waiver that covers it; of two, one that has not expired.

    A waiver that names rules covers faults that are about some of these and no other rule.
    """
    mine = [waiver for waiver in waivers if waiver.check == finding.property]
    if not mine:
        return finding
    used: list[Waiver] = []
    faults = []
    for fault in finding.faults:
        fitting = [waiver for waiver in mine if _covers(waiver, fault)]
        used += fitting
        best = max(fitting, key=lambda waiver: waiver.expires, default=None)
        faults.append(replace(fault, waiver=best, expired=best is not None and best.expires < today))
    notes = list(finding.notes)
    if finding.outcome is not Outcome.UNDECIDED:
        idle = [waiver for waiver in mine if waiver not in used]
        notes += [
            f"the waiver in line {each.source.line} of {each.source.file} covers nothing" for each in idle
        ]
    return replace(finding, faults=tuple(faults), notes=tuple(notes))


def _covers(waiver: Waiver, fault: Fault) -> bool:
    if not waiver.rules:
        return True
    return bool(fault.rules) and all(rule.id in waiver.rules for rule in fault.rules)


def overall(findings: Iterable[Finding]) -> Outcome:
    """What findings come to together: refuted if a fault is not waived, else undecided if one of them is."""
    outcomes = {Outcome.PROVED if each.waived else each.outcome for each in findings}
    for worst in (Outcome.REFUTED, Outcome.UNDECIDED):
        if worst in outcomes:
            return worst
    return Outcome.PROVED


def narrowed(ruleset: WrittenRuleset, condition: str) -> WrittenRuleset:
    """The same ruleset, meant only for ships of which a condition holds, as (own, other) and swapped.

    Raises
    ------
    RulesetError
        If it is no condition in the words of the ruleset.
    """
    text = ruleset.text
    compiler = Compiler(
        vocabulary=text.vocabulary,
        parameters=text.parameters,
        definitions=text.definitions,
        regimes=text.regimes,
        tangents=dict(text.tangents),
    )
    try:
        formula = compiler.condition(condition)
    except syntax.Fault as fault:
        told = Diagnostic(
            source="--assume",
            line=1,
            column=fault.span.begin + 1,
            message=fault.message,
            expected=fault.expected,
            hint=fault.hint,
            excerpt=condition,
            width=max(1, fault.span.end - fault.span.begin),
        )
        raise RulesetError(told) from None
    return claims.assuming(ruleset.with_text(replace(text, tangents=compiler.tangents)), formula)
