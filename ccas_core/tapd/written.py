"""A ruleset that is written in a file, as it judges pairs: a ladder of rules, tried from both sides.

Each rule is written once, for (own, other).  From own ship's side the ladder is gone down rule by rule; a
rule may apply as it is written, or with the ships swapped, and then says the opposite.  The other ship does
the same from its own side.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..priority import LIGHTEST_FIRST
from ..roles import Geometry
from ..ships import Ship, ShipId
from ..verdict import OPPOSITE, Kind, Verdict
from .facts import PairFacts
from .guesses import guessed
from .language.code import Decision, Program, UnknownFact, program
from .python_rules import PairView, PythonRule, ruled
from .recognition import RECOGNISED, Arguments, Recogniser, conditions_of
from .rules import DEFAULT_ORDER, Criterion, Mirror, Outcome, Policy, Rule, RulesetText, Side
from .ruleset import PairRuleset
from .told_facts import ToldFacts
from .vocabulary import Scope, Vocabulary


@dataclass(frozen=True, slots=True)
class Applied:
    """The rule that decides, and whether it does so with the ships swapped."""

    rule: Rule
    outcome: Outcome
    swapped: bool


class WrittenRuleset(PairRuleset):
    """A ruleset from a file.

    `criteria` are those of plugins: each gives a number for a ship, and the least decides first.
    """

    def __init__(
        self,
        text: RulesetText,
        python: Mapping[str, PythonRule] | None = None,
        criteria: Mapping[str, Callable[[Ship], float]] | None = None,
    ) -> None:
        self.text = text
        self.id, self.version, self.title = text.id, text.version, text.title
        self._python = dict(python or {})
        self._criteria = dict(criteria or {})
        places = text.vocabulary.places[Scope.PAIR]
        self._places = tuple(places[name] for name in RECOGNISED)
        self._told: dict[tuple[str, bool], ToldFacts] = {}

    @property
    def vocabulary(self) -> Vocabulary:
        """Facts that the ruleset may ask for."""
        return self.text.vocabulary

    @property
    def criterion(self) -> str:
        """What `rank` goes by: the lightest first, unless the file says otherwise."""
        if self.text.resolve_by == DEFAULT_ORDER:
            return LIGHTEST_FIRST
        words = (
            f"{each.criterion}{' descending' if each.descending else ''}" for each in self.text.resolve_by
        )
        return f"by {', '.join(words)}"

    def rank(self, ship: Ship) -> tuple[float, ...]:
        """Place of a ship among those that wait for one another in a ring, by the criteria of the file."""
        known: dict[str, Callable[[Ship], float]] = {
            Criterion.WEIGHT: lambda each: each.mass,
            Criterion.LENGTH: lambda each: each.hull.length,
            **self._criteria,
        }
        return tuple(
            -known[order.criterion](ship) if order.descending else known[order.criterion](ship)
            for order in self.text.resolve_by
            if order.criterion != Criterion.ID
        )

    # -- judging ---------------------------------------------------------------------------------

    def judge(self, facts: PairFacts) -> Verdict:
        """Judge a pair from `facts.own`'s side; what is not known and matters gives `unknown_fact`."""
        try:
            return self._judged(facts)
        except UnknownFact as unknown:
            found = guessed(facts, unknown.missing, self._judged)
        if found.agreed is not None:
            return found.agreed
        decided = found.decided[0] if found.decided else None
        return Verdict(
            own=facts.own,
            other=facts.other,
            kind=Kind.UNKNOWN_FACT,
            ruleset=self.id,
            version=self.version,
            citation=decided.citation if decided else self.text.otherwise,
            geometry=decided.geometry if decided else Geometry.NONE,
            overtaker=decided.overtaker if decided else None,
            has_other_on_starboard=decided.has_other_on_starboard if decided else None,
            diagnosis="unknown_fact",
            reason=found.reason,
        )

    def _judged(self, facts: PairFacts) -> Verdict:
        seen, own, swapped = self.recognised(facts)
        applied = self.applied(own, swapped, seen)
        if not applied:
            return self._no_rule(seen)
        if len(applied) > 1 and len({_duty(each) for each in applied}) > 1:
            return self._contradiction(seen, applied)
        return self.verdict(seen, applied[0])

    def recognised(self, facts: PairFacts) -> tuple[PairFacts, Arguments, Arguments]:
        """Recognise the encounter where it is neither stated nor remembered.

        Gives the facts completed, and what conditions are called with, as written and with the ships swapped.
        """
        turned = facts.mirrored()
        memory = self._program.memory
        own = _arguments(facts, memory)
        swapped = _arguments(turned, memory)
        values = facts.pair_values
        if all(values[place] is not None for place in self._places):
            return facts, own, swapped
        found = self._recogniser.both(own, swapped, values[self._places[1]])
        here, there = (
            self._completed(each.pair_values, recognised)
            for each, recognised in zip((facts, turned), found, strict=True)
        )
        seen = PairFacts(
            vocabulary=facts.vocabulary,
            own=facts.own,
            other=facts.other,
            own_values=facts.own_values,
            other_values=facts.other_values,
            waterway_values=facts.waterway_values,
            pair_values=here,
            motion=facts.motion,
        )
        return seen, (*own[:3], here, *own[4:]), (*swapped[:3], there, *swapped[4:])

    def _completed(self, pair: Sequence[Any], recognised: Sequence[Any]) -> tuple[Any, ...]:
        filled = list(pair)
        for place, value in zip(self._places, recognised, strict=True):
            if filled[place] is None:
                filled[place] = value
        return tuple(filled)

    def applied(self, own: Arguments, swapped: Arguments, facts: PairFacts) -> list[Applied]:
        """Rules that apply: the first one, or all of them where the policy is `unique`."""
        both = self.text.mirror is Mirror.AUTO
        first = self.text.policy is Policy.FIRST
        found: list[Applied] = []
        for rule, decide in zip(self.text.rules, self._decisions, strict=True):
            if decide(*own) and (outcome := self._outcome(rule, facts, swapped=False)):
                found.append(Applied(rule, outcome, swapped=False))
                if first:
                    break
            if both and decide(*swapped) and (outcome := self._outcome(rule, facts, swapped=True)):
                found.append(Applied(rule, outcome, swapped=True))
                if first:
                    break
        return found

    def assumptions(self, facts: PairFacts) -> bool:
        """Whether a pair keeps to what the ruleset assumes of its domain, as far as that is known."""
        _, own, _ = self.recognised(facts)
        try:
            return all(decide(*own[:5], [None] * self._assumed.memory) for decide in self._assumed.decisions)
        except UnknownFact:
            return True

    @cached_property
    def _assumed(self) -> Any:
        return program(self.text.domain.assume, self.text.vocabulary, self.text.constants)

    def _outcome(self, rule: Rule, facts: PairFacts, *, swapped: bool) -> Outcome | None:
        """What a rule says; a rule in Python is asked, and may have nothing to say."""
        if not rule.python:
            return rule.outcome
        return ruled(self._python[rule.python], PairView(facts.mirrored() if swapped else facts))

    @cached_property
    def _program(self) -> Program:
        text = self.text
        formulas = [*conditions_of(text.recognition), *(rule.condition for rule in text.rules)]
        return program(formulas, text.vocabulary, text.constants)

    @cached_property
    def _recogniser(self) -> Recogniser:
        recognition = self.text.recognition
        return Recogniser(recognition, self._program.decisions[: len(conditions_of(recognition))])

    @cached_property
    def _decisions(self) -> tuple[Decision, ...]:
        return self._program.decisions[len(conditions_of(self.text.recognition)) :]

    def python_rule(self, name: str) -> PythonRule:
        """Rule in Python by its name; `KeyError` where there is none."""
        return self._python[name]

    def with_text(self, text: RulesetText) -> WrittenRuleset:
        """The same ruleset with another text, and the same rules in Python and criteria."""
        return WrittenRuleset(text, self._python, self._criteria)

    def mutated(self, index: int, *, negated: bool) -> WrittenRuleset:
        """The same ruleset with one fault: a rule's condition turned round, or the rule left out."""
        mutant = WrittenRuleset(self.text, self._python, self._criteria)
        decide = self._decisions[index]
        wrong = (lambda *seen: not decide(*seen)) if negated else (lambda *_: False)
        decisions = (*self._decisions[:index], wrong, *self._decisions[index + 1 :])
        mutant.__dict__ |= {"_program": self._program, "_decisions": decisions}
        return mutant

    # -- verdicts --------------------------------------------------------------------------------

    def verdict(self, facts: PairFacts, applied: Applied) -> Verdict:
        """Verdict of own ship's view by a rule."""
        rule, outcome = applied.rule, applied.outcome
        first, then = (facts.other, facts.own) if applied.swapped else (facts.own, facts.other)

        def ship(side: Side | None) -> ShipId | None:
            return None if side is None else first if side is Side.OWN else then

        kind = OPPOSITE.get(outcome.kind, outcome.kind) if applied.swapped else outcome.kind
        wanted = outcome.kind in (Kind.COOPERATE, Kind.PROHIBITED)
        because = rule.because.replace("{own}", first).replace("{other}", then) if rule.because else ""
        return Verdict(
            own=facts.own,
            other=facts.other,
            kind=kind,
            ruleset=self.id,
            version=self.version,
            rule=rule.id,
            citation=rule.citation,
            strength=outcome.strength.value if outcome.strength else "",
            passing_side=outcome.passing_side,
            passing_required=outcome.passing_side is not None and outcome.passing_required,
            side_chosen_by=ship(outcome.side_chosen_by),
            must_follow=ship(outcome.must_follow),
            facilitates=ship(outcome.facilitates),
            initiator=first if wanted else None,
            signal=outcome.signal,
            manoeuvre=outcome.manoeuvre,
            diagnosis=_diagnosis(outcome),
            reason=outcome.reason or because or rule.citation.text,
            facts=self._told_by(rule, swapped=applied.swapped).of(facts),
            **self._met(facts),
        )

    def _told_by(self, rule: Rule, *, swapped: bool) -> ToldFacts:
        key = rule.id, swapped
        if key not in self._told:
            self._told[key] = ToldFacts(rule, self.vocabulary, swapped=swapped)
        return self._told[key]

    def _no_rule(self, facts: PairFacts) -> Verdict:
        met = self._met(facts)
        if facts.pair_values[self._places[0]] is not True or met["geometry"] is Geometry.NONE:
            met = {}
        return Verdict(
            own=facts.own,
            other=facts.other,
            kind=Kind.NONE,
            ruleset=self.id,
            version=self.version,
            citation=self.text.otherwise,
            reason="no_rule" if met else "no_risk",
            **met,
        )

    def _contradiction(self, facts: PairFacts, applied: Sequence[Applied]) -> Verdict:
        names = " and ".join(dict.fromkeys(f"'{each.rule.id}' ({each.rule.citation})" for each in applied))
        return Verdict(
            own=facts.own,
            other=facts.other,
            kind=Kind.CONFLICT,
            ruleset=self.id,
            version=self.version,
            rule=applied[0].rule.id,
            citation=applied[0].rule.citation,
            diagnosis="conflict",
            reason=f"rules {names} apply together, and say different things",
            **self._met(facts),
        )

    def _met(self, facts: PairFacts) -> dict[str, Any]:
        ships = {"own": facts.own, "other": facts.other}
        _, geometry, overtaker, starboard = (facts.pair_values[place] for place in self._places)
        return {
            "geometry": Geometry(geometry) if isinstance(geometry, str) else Geometry.NONE,
            "overtaker": ships.get(overtaker) if isinstance(overtaker, str) else None,
            "has_other_on_starboard": ships.get(starboard) if isinstance(starboard, str) else None,
        }


def _arguments(facts: PairFacts, memory: int) -> Arguments:
    return (
        facts.own_values,
        facts.other_values,
        facts.waterway_values,
        facts.pair_values,
        facts.motion,
        [None] * memory,
    )


def _diagnosis(outcome: Outcome) -> str:
    if outcome.diagnosis is not None:
        return outcome.diagnosis.value
    return outcome.kind.value if outcome.kind in (Kind.CONFLICT, Kind.GAP) else ""


def _duty(applied: Applied) -> tuple[object, ...]:
    """What a rule makes the two ships do; rules that make them do the same do not contradict one another."""
    outcome = applied.outcome
    kind = OPPOSITE.get(outcome.kind, outcome.kind) if applied.swapped else outcome.kind
    wanted = outcome.kind in (Kind.COOPERATE, Kind.PROHIBITED)
    return kind, wanted and applied.swapped, outcome.passing_side
