"""Properties of a ruleset that concern two ships.

Each is put as its opposite: can there be two ships for which it fails?  If the solver says no, it is
proved; if ships are found, it is refuted; otherwise it is undecided.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Final

import z3

from ..tapd.case_run import run_case
from ..tapd.coverage import reached
from ..tapd.language.formula import Formula, Test
from ..tapd.rules import Mirror, Policy, Rule
from ..tapd.rules import Outcome as Said
from ..tapd.written import WrittenRuleset
from ..verdict import Kind, Verdict, agree
from .findings import Fault, Finding, Outcome
from .ladder import Ladder, Place, duty, turned
from .questions import Questions
from .search import Goal
from .solver import LINEAR, Budget, Found
from .symbols import Term

SILENT: Final = (Kind.NONE, Kind.GAP)


@dataclass(slots=True)
class Tally:
    """What came of the questions that make up a property."""

    faults: list[Fault] = field(default_factory=list)
    open: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    methods: set[str] = field(default_factory=set)
    questions: int = 0
    _began: float = field(default_factory=time.perf_counter)

    def finding(self, name: str, method: str = "") -> Finding:
        """The property as a whole."""
        outcome = Outcome.REFUTED if self.faults else Outcome.UNDECIDED if self.open else Outcome.PROVED
        reasoning = " and ".join(sorted(self.methods)) or "nothing to ask"
        if outcome is Outcome.REFUTED:
            reasoning = "ships, judged by the rules as they run"
        elif outcome is Outcome.UNDECIDED:
            reasoning = f"no answer to {len(self.open)}"
        return Finding(
            property=name,
            outcome=outcome,
            method=method or f"{reasoning} ({self.questions} question{'s' if self.questions != 1 else ''})",
            seconds=time.perf_counter() - self._began,
            faults=tuple(self.faults),
            open=tuple(self.open),
            notes=tuple(self.notes),
        )

    def ask(
        self,
        questions: Questions,
        terms: list[Term],
        goal: Goal,
        fault: Callable[[], Fault],
        probe: WrittenRuleset | None = None,
    ) -> Found:
        """Ask one question; ships that come of it make a fault.  A probe judges in place of the ruleset."""
        self.questions += 1
        found, method, ships = questions.settled(terms, goal, (probe, probe) if probe else None)
        if found is Found.IMPOSSIBLE:
            self.methods.add(method)
        elif ships is not None:
            told = fault()
            self.faults.append(Fault(title=told.title, rules=told.rules, ships=ships, kind=told.kind))
        else:
            self.open.append(f"{fault().title}: {method}")
        return found


def consistent(questions: Questions) -> Finding:
    """Opposite verdicts in the two views, and none that is a contradiction in itself."""
    tally = Tally()
    own, other = questions.own, questions.other
    mirrored = own.view.text.mirror is Mirror.AUTO
    for place in own.places:
        rule = place.rule
        if rule.python:
            if not place.swapped:
                tally.open.append(f"rule '{rule.id}' is decided in Python that cannot be followed")
            continue
        if place.swapped:
            continue
        if rule.outcome.kind is Kind.CONFLICT:
            tally.ask(
                questions,
                [own.decides(place)],
                lambda one, two, rule=rule: rule.id in (one.rule, two.rule),  # type: ignore[misc]
                lambda rule=rule: Fault(  # type: ignore[misc]
                    title=f"the regulation contradicts itself: {rule.outcome.diagnosis or 'conflict'}, "
                    f"{rule.citation}",
                    rules=(rule,),
                    kind="contradiction",
                ),
            )
        elif mirrored:
            for other_way in own.places:
                if other_way.swapped and other_way.rule.id == rule.id and not _fit(rule, other_way.rule):
                    _both_ways(tally, questions, place, other_way)
    if not mirrored:
        _unmirrored(tally, questions, own, other)
    return tally.finding("consistent")


def _fit(one: Rule, other: Rule) -> bool:
    """Whether what both ships have by rules, each its own ship's part, goes together."""
    return turned(duty(other.outcome, swapped=False)) == duty(one.outcome, swapped=False)


def _both_ways(tally: Tally, questions: Questions, place: Place, other_way: Place) -> None:
    """Whether a rule can apply both ways round: then both ships take its own part."""
    own = questions.own
    rule = place.rule
    apply = [own.applies(place), own.applies(other_way)]
    before = own.decides(place)

    def fault() -> Fault:
        kinds = {Kind.GIVE_WAY: "both ships give way", Kind.STAND_ON: "both ships stand on"}
        what = kinds.get(rule.outcome.kind, f"both ships begin ({rule.outcome.kind})")
        return Fault(title=f"{what} by rule '{rule.id}'", rules=(rule,), kind="contradiction")

    if (quick := questions.never(apply)) is not None:  # whatever stands before it in the ladder
        tally.questions += 1
        tally.methods.add(quick)
        return

    def shown(one: Verdict, two: Verdict) -> bool:
        return one.rule == rule.id and (bool(agree(one, two)) or one.kind is Kind.CONFLICT)

    tally.ask(questions, [*apply, before], shown, fault)


def _unmirrored(tally: Tally, questions: Questions, own: Ladder, other: Ladder) -> None:
    """Whether two rules that are written for each view apart can be in force together, and do not fit."""
    for one in own.places:
        for two in other.places:
            if turned(duty(one.rule.outcome, swapped=False)) == duty(two.rule.outcome, swapped=False):
                continue
            rules = (one.rule,) if one.rule is two.rule else (one.rule, two.rule)
            kinds = f"{one.kind} by '{one.rule.id}', the other {two.kind} by '{two.rule.id}'"
            tally.ask(
                questions,
                [own.decides(one), other.decides(two)],
                lambda a, b, one=one, two=two: (
                    (a.rule, b.rule) == (one.rule.id, two.rule.id) and bool(agree(a, b))
                ),  # type: ignore[misc]
                lambda rules=rules, kinds=kinds: Fault(  # type: ignore[misc]
                    title=f"one ship sees {kinds}", rules=rules, kind="contradiction"
                ),
            )


def complete(questions: Questions) -> Finding:
    """Risk of collision leads to a verdict that decides something, and that obliges somebody."""
    tally = Tally()
    own = questions.own
    risk = own.view.derived("risk_of_collision", value=True)
    for place in own.places:
        if place.rule.outcome.kind in SILENT and not place.swapped and not place.rule.python:
            rule = place.rule
            tally.ask(
                questions,
                [risk, own.decides(place)],
                lambda one, _two, rule=rule: one.rule == rule.id,  # type: ignore[misc]
                lambda rule=rule: Fault(  # type: ignore[misc]
                    title=f"nothing is decided: {rule.outcome.kind} by rule '{rule.id}', {rule.citation}",
                    rules=(rule,),
                    kind="gap",
                ),
            )
    tally.ask(
        questions,
        [risk, own.silent],
        lambda one, _two: one.kind is Kind.NONE and not one.rule and one.reason != "no_risk",
        lambda: Fault(title="no rule applies to ships at risk of collision", kind="gap"),
    )
    tally.ask(
        questions,
        [risk, own.says(Kind.STAND_ON), questions.other.says(Kind.STAND_ON)],
        lambda one, two: one.kind is two.kind is Kind.STAND_ON,
        lambda: Fault(title="both ships stand on: nobody is obliged", kind="gap"),
    )
    return tally.finding("complete")


def exclusive(questions: Questions) -> Finding | None:
    """Rules that apply together say the same; asked where the policy is `unique`."""
    own = questions.own
    if not own.unique:
        return None
    tally = Tally()
    for first, one in enumerate(own.places):
        for two in own.places[first + 1 :]:
            same = duty(one.rule.outcome, swapped=one.swapped) == duty(two.rule.outcome, swapped=two.swapped)
            if one.swapped or same or one.rule is two.rule:
                continue
            tally.ask(
                questions,
                [own.applies(one), own.applies(two)],
                lambda one, _two: one.kind is Kind.CONFLICT,
                lambda one=one, two=two: Fault(  # type: ignore[misc]
                    title=f"rules '{one.rule.id}' and '{two.rule.id}' apply together",
                    rules=(one.rule, two.rule),
                    kind="contradiction",
                ),
            )
    return tally.finding("exclusive")


def no_dead_rule(questions: Questions) -> Finding:
    """Each rule decides for some ships; a test that reaches it shows so, and else ships are looked for."""
    tally = Tally()
    own = questions.own
    ruleset = questions.rulesets[0]
    alive = _tested(ruleset)
    tested = sum(rule.id in alive for rule in ruleset.text.rules)
    tally.notes.append(f"{tested} of {len(ruleset.text.rules)} rules are reached by tests")
    for place in own.places:
        rule = place.rule
        if place.swapped or rule.id in alive or rule.python:
            continue
        tally.questions += 1
        found, method, ships = questions.settled(
            [own.decides(place)],
            lambda one, two, rule=rule: rule.id in (one.rule, two.rule),  # type: ignore[misc]
            enough=1,
        )
        if found is Found.IMPOSSIBLE:
            fault = Fault(title=f"rule '{rule.id}' can never decide", rules=(rule,), kind="dead rule")
            tally.faults.append(fault)
        elif ships is None:
            tally.open.append(f"rule '{rule.id}': {method}")
    return tally.finding("no_dead_rule", "" if tally.faults or tally.open else "tests, and ships")


def _tested(ruleset: WrittenRuleset) -> frozenset[str]:
    tests = ruleset.text.tests
    sound = [case for case in tests if run_case(ruleset, case, case.expected[ruleset.id]).passed]
    return reached(ruleset, sound)


def no_irrelevant_rule(questions: Questions) -> Finding:
    """Without any one rule, some verdict would be another."""
    tally = Tally()
    own = questions.own
    ruleset = questions.rulesets[0]
    needed = _needed(ruleset)
    for place in own.places:
        rule = place.rule
        if place.swapped or rule.id in needed or rule.python:
            continue
        other = [term for later, term in own.after(place) if later is None or _said(later) != _said(place)]
        tally.questions += 1
        mutant = ruleset.mutated(place.index, negated=False)
        found, method, ships = questions.settled(
            [own.decides(place), z3.Or(other)], _differs_without(rule), rulesets=(ruleset, mutant), enough=1
        )
        if found is Found.IMPOSSIBLE:
            fault = Fault(title=f"rule '{rule.id}' changes nothing", rules=(rule,), kind="irrelevant rule")
            tally.faults.append(fault)
        elif ships is None:
            tally.open.append(f"rule '{rule.id}': {method}")
    return tally.finding("no_irrelevant_rule", "" if tally.faults or tally.open else "tests, and ships")


def _needed(ruleset: WrittenRuleset) -> frozenset[str]:
    """Rules without which a test fails."""
    tests = [case for case in ruleset.text.tests if run_case(ruleset, case, case.expected[ruleset.id]).passed]
    found = set()
    for index, rule in enumerate(ruleset.text.rules):
        mutant = ruleset.mutated(index, negated=False)
        near = [case for case in tests if case.expected[ruleset.id].rule == rule.id]
        if any(_duty_changes(mutant, case) for case in near):
            found.add(rule.id)
    return frozenset(found)


def _duty_changes(mutant: WrittenRuleset, case: object) -> bool:
    result = run_case(mutant, case, case.expected[mutant.id])  # type: ignore[arg-type, attr-defined]
    return any(not each.startswith("by:") for each in result.differences)


def _said(place: Place) -> tuple[object, ...]:
    """All that a verdict says: the duty, how strong it is, and by which article."""
    outcome = place.rule.outcome
    return (
        duty(outcome, swapped=place.swapped),
        outcome.strength,
        outcome.facilitates and (outcome.facilitates == "own") is not place.swapped,
        outcome.diagnosis,
        str(place.rule.citation),
    )


def _differs_without(rule: Rule) -> Goal:
    """Goal: A judges by the rule, and B, without it, does not fit or judges by another article."""
    return lambda one, two: one.rule == rule.id and (bool(agree(one, two)) or one.article != two.article)


def mirror_sound(questions: Questions) -> Finding:
    """Both ships recognise the same encounter: risk, geometry, who overtakes, who has whom to starboard."""
    tally = Tally()
    view = questions.own.view
    found = view.text.recognition
    if found is None:
        return tally.finding("mirror_sound", "encounters are stated")

    def differs(formula: Formula) -> Term:
        return z3.Xor(view.term(formula), view.swapped.term(formula))

    def both(formula: Formula) -> Term:
        return z3.And(view.term(formula), view.swapped.term(formula))

    overtaking = z3.Or(view.term(found.overtaking), view.swapped.term(found.overtaking))
    asked = [
        ("only one of the ships sees a risk of collision", [differs(found.risk)]),
        ("only one of the ships sees a head-on encounter", [z3.Not(overtaking), differs(found.head_on)]),
        (
            "only one of the ships sees a crossing",
            [
                z3.Not(overtaking),
                z3.Not(z3.Or(view.term(found.head_on), view.swapped.term(found.head_on))),
                differs(found.crossing),
            ],
        ),
        ("each ship overtakes the other", [both(found.overtaking)]),
        ("each ship has the other on its starboard side", [both(found.from_starboard), _met(questions)]),
    ]
    for title, terms in asked:
        tally.ask(
            questions,
            terms,
            _seen_differently,
            lambda title=title: Fault(title=title, kind="contradiction"),  # type: ignore[misc]
            recognising(questions.rulesets[0]),
        )
    return tally.finding("mirror_sound")


def recognising(ruleset: WrittenRuleset) -> WrittenRuleset:
    """The same ruleset without its rules, but for one that tells whether there is a risk of collision."""
    text = ruleset.text
    said = Said(kind=Kind.MUTUAL)
    risk = replace(text.rules[0], condition=Test("risk_of_collision", value=True), outcome=said, python="")
    return ruleset.with_text(replace(text, rules=(risk,), policy=Policy.FIRST, mirror=Mirror.NONE))


def _met(questions: Questions) -> Term:
    view = questions.own.view
    return z3.Not(view.derived("geometry", "none"))


def _seen_differently(one: Verdict, two: Verdict) -> bool:
    same = (one.kind, one.geometry, one.overtaker, one.has_other_on_starboard) == (
        two.kind,
        two.geometry,
        two.overtaker,
        two.has_other_on_starboard,
    )
    return not same


def tie_break_total(questions: Questions) -> Finding:
    """The criteria that open a ring of ships always name one that goes first."""
    tally = Tally()
    orders = questions.rulesets[0].text.resolve_by
    if not any(order.criterion == "id" for order in orders):
        names = ", ".join(order.criterion for order in orders) or "nothing"
        tally.questions += 1
        found, method, ships = questions.settled([z3.BoolVal(True)], lambda one, two: True)  # noqa: ARG005, FBT003
        del found, method
        title = f"two ships that are alike in {names}: neither goes first"
        tally.faults.append(Fault(title=title, ships=ships, kind="tie"))
    return tally.finding("tie_break_total", "" if tally.faults else "the ship's id decides in the end")


def domain_not_empty(questions: Questions) -> Finding:
    """There are ships at risk of collision in the domain: proofs about it say something."""
    tally = Tally()
    risk = questions.own.view.derived("risk_of_collision", value=True)
    tally.questions += 1
    found, method, ships = questions.settled(
        [risk, _met(questions)],
        lambda one, _two: one.geometry != "none" and one.reason != "no_risk",
        enough=1,
    )
    if found is Found.IMPOSSIBLE:
        tally.faults.append(Fault(title="no two ships of the domain are ever at risk", kind="empty domain"))
    elif ships is None:
        tally.open.append(method)
    return tally.finding("domain_not_empty", "" if tally.faults or tally.open else "ships")


def parameters(ruleset: WrittenRuleset, budget: Budget) -> Finding:
    """What is proved of the two views holds for all parameters within their ranges."""
    tally = Tally()
    ranged = [name for name, each in ruleset.text.parameters.items() if each.low < each.high]
    if not ranged:
        return tally.finding("parameters", "no parameter has a range")
    questions = Questions((ruleset, ruleset), budget, free=True)
    for finding in (consistent(questions), mirror_sound(questions)):
        tally.questions += 1
        tally.methods.add(LINEAR if finding.outcome is Outcome.PROVED else finding.method)
        known = [
            fault for fault in finding.faults if fault.rules and fault.rules[0].outcome.kind is Kind.CONFLICT
        ]
        tally.faults += [fault for fault in finding.faults if fault not in known]
        tally.open += list(finding.open)
    finding = tally.finding("parameters")
    return (
        finding
        if tally.faults or tally.open
        else tally.finding("parameters", f"for all of {', '.join(ranged)}")
    )


def steady(questions: Questions) -> Iterator[str]:
    """Names of rules that look at motion beyond the recognition of the encounter."""
    for rule in questions.rulesets[0].text.rules:
        if rule.python:
            yield rule.id
