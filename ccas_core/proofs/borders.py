"""Two ships of which each judges by another ruleset: across a border, or by an old and a new version."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import z3

from ..tapd.written import WrittenRuleset
from ..verdict import OPPOSITE, Kind, Verdict
from .findings import Fault, Finding
from .ladder import Ladder, Place, duty
from .pairs import Tally
from .questions import Questions
from .search import A, B, Ships
from .solver import Budget, Found
from .symbols import Term, View, constants_of

MOST: int = 12  # examples that are told of one property


def border(one: WrittenRuleset, other: WrittenRuleset, budget: Budget, most: int = MOST) -> Finding:
    """Own ship under one ruleset, the other under another: never do both stand on.

    Ships find out when they exchange their verdicts, and fall back to the safe mutual rule; where this is
    proved, they are safe before that, too.  Where both give way is told as a note.  `most` examples are told
    either way round.
    """
    tally = Tally()
    for pair in ((one, other), (other, one)) if one is not other else ((one, other),):
        questions = Questions(pair, budget)
        names = f"{pair[0].id} | {pair[1].id}"
        both = [questions.own.says(Kind.STAND_ON), questions.other.says(Kind.STAND_ON)]
        for ships in _examples(tally, questions, both, _both(Kind.STAND_ON), names, most):
            a, b = ships.verdicts
            title = f"{names}: both stand on, by '{a.rule}' ({a.article}) and '{b.rule}' ({b.article})"
            rules = (pair[0].text.rule(a.rule), pair[1].text.rule(b.rule))
            tally.faults.append(Fault(title=title, rules=rules, ships=ships, kind="border"))
        found, _, gentle = questions.settled(
            [questions.own.says(Kind.GIVE_WAY), questions.other.says(Kind.GIVE_WAY)], _both(Kind.GIVE_WAY)
        )
        if found is Found.POSSIBLE and gentle is not None:
            a, b = gentle.verdicts
            tally.notes.append(f"{names}: both may give way, as by '{a.rule}' and '{b.rule}'")
    return tally.finding("border")


def _both(kind: Kind) -> Callable[[Verdict, Verdict], bool]:
    return lambda one, two: one.kind is two.kind is kind


def _examples(
    tally: Tally,
    questions: Questions,
    terms: list[Term],
    goal: Callable[[Verdict, Verdict], bool],
    what: str,
    most: int,
) -> Iterator[Ships]:
    """Ships for each pair of rules that reaches a goal, until no more are possible."""
    seen: set[tuple[str, str]] = set()
    left = list(terms)
    while len(seen) < most:
        tally.questions += 1
        found, method, ships = questions.settled(
            left, lambda one, two: goal(one, two) and (one.rule, two.rule) not in seen
        )
        if found is Found.IMPOSSIBLE:
            if not seen:
                tally.methods.add(method)
            return
        if ships is None:
            tally.open.append(
                f"{what}: {method}" + (f"; besides {len(seen)} that were found" if seen else "")
            )
            return
        rules = ships.verdicts[0].rule, ships.verdicts[1].rule
        seen.add(rules)
        left.append(z3.Not(z3.And(_decided(questions.own, rules[0]), _decided(questions.other, rules[1]))))
        yield ships


def _decided(ladder: Ladder, rule: str) -> Term:
    if not rule:
        return ladder.silent
    return z3.Or([ladder.decides(place) for place in ladder.places if place.rule.id == rule])


def against(new: WrittenRuleset, old: WrittenRuleset, budget: Budget) -> Finding:
    """Where two versions say different things of the same ships, as one of them sees it.

    Refuted means: they differ, and here are ships, one pair for each pair of rules; proved means that no
    ship will notice.
    """
    tally = Tally()
    questions = Questions((new, old), budget)
    before = Ladder(View(questions.symbols, old.text, A, B, constants_of(old.text, free=False)))
    terms = [z3.Or(list(_differences(questions.own, before)))]
    seen: list[Term] = []
    for ships in _examples_by_rule(tally, questions, before, terms, seen):
        a, b = ships.verdicts
        was = OPPOSITE.get(b.kind, b.kind)
        before_, now = (f"'{view.rule or 'no rule'}' ({view.article})" for view in (b, a))
        title = f"{was} by {before_} is now {a.kind} by {now}"
        rules = tuple(ruleset.text.rule(view.rule) for ruleset, view in ((new, a), (old, b)) if view.rule)
        tally.faults.append(Fault(title=title, rules=rules, ships=ships, kind="difference"))
    return tally.finding("against")


def _differences(now: Ladder, before: Ladder) -> Iterator[Term]:
    """For each verdict that one ladder may give: that it does, and the other gives no such verdict."""
    duties = {duty(place.rule.outcome, swapped=place.swapped) for place in (*now.places, *before.places)}
    for each in sorted(duties, key=str):
        here = z3.Or([now.decides(place) for place in now.places if _says(place) == each])
        there = z3.Or([before.decides(place) for place in before.places if _says(place) == each])
        yield z3.And(here, z3.Not(there))
    yield z3.And(now.silent, z3.Not(z3.Or(before.silent, before.says(Kind.NONE))))


def _says(place: Place) -> tuple[object, ...]:
    return duty(place.rule.outcome, swapped=place.swapped)


def fits(one: Verdict, two: Verdict) -> bool:
    """Whether two views fit together, whichever rulesets they are by."""
    return (
        OPPOSITE.get(one.kind, one.kind) is two.kind
        and one.initiator == two.initiator
        and one.passing_side is two.passing_side
        and one.side_chosen_by == two.side_chosen_by
    )


def _examples_by_rule(
    tally: Tally, questions: Questions, before: Ladder, terms: list[Term], left: list[Term]
) -> Iterator[Ships]:
    seen: set[tuple[str, str]] = set()
    while len(seen) < MOST:
        tally.questions += 1
        found, method, ships = questions.settled(
            [*terms, *left], lambda one, two: not fits(one, two) and (one.rule, two.rule) not in seen
        )
        if found is Found.IMPOSSIBLE:
            if not seen:
                tally.methods.add(method)
            return
        if ships is None:
            tally.open.append(f"more differences: {method}")
            return
        rules = ships.verdicts[0].rule, ships.verdicts[1].rule
        seen.add(rules)
        left.append(z3.Not(z3.And(_decided(questions.own, rules[0]), _decided(before, rules[1]))))
        yield ships


__all__ = ["B", "against", "border", "fits"]
