"""A ruleset that is written in a file, as it judges pairs: a ladder of rules, tried from both sides.

Each rule is written once, for (own, other).  From own ship's side the ladder is gone down rule by rule; a rule
may apply as it is written, or with the ships swapped, and then says the opposite.  The other ship does the
same from its own side.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from typing import Any, Final

from ..priority import LIGHTEST_FIRST
from ..roles import Geometry
from ..ships import FactValue, Ship, ShipId
from ..units import DEGREE
from ..verdict import OPPOSITE, Kind, Verdict
from .facts import PairFacts
from .language.code import Missing, UnknownFact, Values, program
from .language.formula import Measure, Named, alike, facts_of, mirrored, walk
from .language.polynomial import RELATIVE
from .python_rules import PairView, PythonRule, ruled
from .rules import DEFAULT_ORDER, Criterion, Mirror, Outcome, Policy, Rule, RulesetText, Side
from .ruleset import PairRuleset
from .vocabulary import MOTIONS, Scope, Vocabulary
from .vocabulary import Kind as FactKind

MOST_GUESSES: Final = 512  # values of unknown facts that are tried
_RECOGNISED: Final = ("risk_of_collision", "geometry", "overtaker", "has_other_on_starboard")

Arguments = tuple[Values, Values, Values, Values, Values, list[Any]]
Recognised = tuple[Any, Any, Any, Any]


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
        self._places = tuple(places[name] for name in _RECOGNISED)

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
            return self._guessed(facts, unknown.missing)

    def _judged(self, facts: PairFacts) -> Verdict:
        seen, own, swapped = self.recognised(facts)
        applied = self.applied(own, swapped, seen)
        if not applied:
            return self._no_rule(seen)
        if len(applied) > 1 and len({_duty(each, seen) for each in applied}) > 1:
            return self._contradiction(seen, applied)
        return self.verdict(seen, applied[0])

    def recognised(self, facts: PairFacts) -> tuple[PairFacts, Arguments, Arguments]:
        """Recognise the encounter where it is neither stated nor remembered.

        Gives the facts completed, and what conditions are called with, as written and with the ships swapped.
        """
        turned = facts.mirrored()
        memory = self._program.memory
        own: Arguments = (*_arguments(facts), [None] * memory)
        swapped: Arguments = (*_arguments(turned), [None] * memory)
        risk, geometry, overtaker, starboard = self._places
        if all(facts.pair_values[place] is not None for place in self._places):
            return facts, own, swapped
        found = self._recognised_by_both(own, swapped)
        completed = []
        for values, recognition in zip((facts.pair_values, turned.pair_values), found, strict=True):
            filled = list(values)
            for place, value in zip((risk, geometry, overtaker, starboard), recognition, strict=True):
                if filled[place] is None:
                    filled[place] = value
            completed.append(tuple(filled))
        seen = PairFacts(
            vocabulary=facts.vocabulary,
            own=facts.own,
            other=facts.other,
            own_values=facts.own_values,
            other_values=facts.other_values,
            waterway_values=facts.waterway_values,
            pair_values=completed[0],
            motion=facts.motion,
        )
        return seen, (*own[:3], completed[0], *own[4:]), (*swapped[:3], completed[1], *swapped[4:])

    @cached_property
    def _symmetric(self) -> tuple[bool, bool, bool]:
        """Whether risk, head-on and crossing are the same with the ships swapped; then it is enough to look once."""
        found = self.text.recognition
        if found is None:
            return True, True, True
        risk, head_on, crossing = (alike(mirrored(f), f) for f in (found.risk, found.head_on, found.crossing))
        return risk, head_on, crossing

    def _recognised_by_both(self, own: Arguments, swapped: Arguments) -> tuple[Recognised, Recognised]:
        """Risk, geometry, overtaker and who has the other on its starboard side, as written and swapped."""
        if self._recognition is None:
            nothing = (False, "none", "none", "none")
            return nothing, nothing
        risk, overtaking, head_on, crossing, from_starboard = self._recognition
        given = own[3][self._places[1]]
        same_risk, *same_geometry = self._symmetric

        def overtakers() -> tuple[bool, bool]:
            return overtaking(*own), overtaking(*swapped)

        def geometry(seen: Arguments) -> str:
            if any(overtakers()):
                return "overtaking"
            return "head_on" if head_on(*seen) else "crossing" if crossing(*seen) else "none"

        def named(first: bool, second: bool) -> tuple[str, str]:  # noqa: FBT001
            there = "own" if second else "other" if first else "none"
            return ("own" if first else "other" if second else "none"), there

        geometries = [given if given is not None else _asked("geometry", lambda: geometry(own))]
        alike_ = given is not None or all(same_geometry)
        geometries.append(geometries[0] if alike_ else _asked("geometry", lambda: geometry(swapped)))
        risks = [_asked("risk_of_collision", lambda: risk(*own))]
        risks.append(risks[0] if same_risk else _asked("risk_of_collision", lambda: risk(*swapped)))
        overtaker: Any = ("none", "none")
        if not isinstance(geometries[0], str) or geometries[0] == "overtaking":
            overtaker = _asked("overtaker", lambda: named(*overtakers()))
        starboard = _asked(
            "has_other_on_starboard", lambda: named(from_starboard(*own), from_starboard(*swapped))
        )
        here, there = (
            (
                risks[n],
                geometries[n],
                overtaker[n] if isinstance(overtaker, tuple) else overtaker,
                starboard[n] if isinstance(starboard, tuple) else starboard,
            )
            for n in (0, 1)
        )
        return here, there

    def applied(self, own: Arguments, swapped: Arguments, facts: PairFacts) -> list[Applied]:
        """Rules that apply: the first one, or all of them where the policy is `unique`."""
        both = self.text.mirror is Mirror.AUTO
        found: list[Applied] = []
        for rule, decide in zip(self.text.rules, self._decisions, strict=True):
            for turned, arguments in ((False, own), (True, swapped)) if both else ((False, own),):
                if not decide(*arguments):
                    continue
                outcome = rule.outcome
                if rule.python:
                    view = PairView(facts.mirrored() if turned else facts)
                    decided = ruled(self._python[rule.python], view)
                    if decided is None:
                        continue
                    outcome = decided
                found.append(Applied(rule, outcome, turned))
                if self.text.policy is Policy.FIRST:
                    return found
        return found

    @cached_property
    def _program(self) -> Any:
        text = self.text
        found = text.recognition
        formulas = [] if found is None else [
            found.risk, found.overtaking, found.head_on, found.crossing, found.from_starboard
        ]  # fmt: skip
        formulas += [rule.condition for rule in text.rules]
        return program(formulas, text.vocabulary, text.constants)

    @cached_property
    def _recognition(self) -> Any:
        return None if self.text.recognition is None else self._program.decisions[:5]

    @cached_property
    def _decisions(self) -> Sequence[Any]:
        first = 0 if self.text.recognition is None else 5
        return tuple(self._program.decisions[first:])

    def with_text(self, text: RulesetText) -> WrittenRuleset:
        """Another ruleset with the same functions of plugins."""
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
        because = rule.because.replace("{own}", first).replace("{other}", then)
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
            facts=self._told(rule, facts, swapped=applied.swapped),
            **self._met(facts),
        )

    def _no_rule(self, facts: PairFacts) -> Verdict:
        geometry, risk = facts["geometry"], facts["risk_of_collision"]
        met = self._met(facts) if risk is True and geometry != "none" else {}
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

    @staticmethod
    def _met(facts: PairFacts) -> dict[str, Any]:
        ships = {"own": facts.own, "other": facts.other}
        geometry = facts["geometry"]
        return {
            "geometry": Geometry(geometry) if isinstance(geometry, str) else Geometry.NONE,
            "overtaker": ships.get(facts["overtaker"]),
            "has_other_on_starboard": ships.get(facts["has_other_on_starboard"]),
        }

    def _told(self, rule: Rule, facts: PairFacts, *, swapped: bool) -> dict[str, FactValue]:
        """Facts that a rule looked at, by their names from own ship's side, in the units of files."""
        found: dict[str, FactValue] = {}
        for names, measured in self._asked_by(rule):
            if measured is not None:
                where = tuple(_SWAPPED.get(each, each) for each in measured) if swapped else measured
                found[_label(where)] = _rounded(facts.quantity(where), where[0])
                continue
            name = names
            if swapped:
                head, dot, tail = name.partition(".")
                name = f"{_SWAPPED[head]}{dot}{tail}" if head in _SWAPPED and dot else name
            value = facts[name]
            if isinstance(value, frozenset):
                value = " ".join(sorted(value))
            if value in ("own", "other"):
                value = facts.own if value == "own" else facts.other
            found[name] = value
        return found

    def _asked_by(self, rule: Rule) -> tuple[tuple[str, tuple[str, ...] | None], ...]:
        if rule.id not in self._asked:
            asked: dict[tuple[str, tuple[str, ...] | None], None] = {}
            for part in walk(rule.condition):
                if isinstance(part, Named) and isinstance(part.measure, Measure):
                    for each in (part.measure.quantity, part.measure.limit):
                        if isinstance(each, tuple):
                            asked["", each] = None
            for name in sorted(facts_of(rule.condition)):
                known = name.startswith(("own.", "other.", "waterway.")) or name in _RECOGNISED
                known = known or name in self.vocabulary.places[Scope.PAIR]
                if known and name not in RELATIVE and not name.endswith("time_to_intersection"):
                    asked[name, None] = None
            self._asked[rule.id] = tuple(asked)
        return self._asked[rule.id]

    @cached_property
    def _asked(self) -> dict[str, tuple[tuple[str, tuple[str, ...] | None], ...]]:
        return {}

    # -- what is not known -----------------------------------------------------------------------

    def _guessed(self, facts: PairFacts, missing: Missing) -> Verdict:
        """Try all values of the facts that are not known; if they lead to one duty, that is the verdict."""
        guesses = list(islice(self._tried(facts, missing, {}), MOST_GUESSES + 1))
        verdicts = [verdict for _, verdict in guesses]
        decided = [each for each in verdicts if each is not None]
        if len(decided) == len(verdicts) <= MOST_GUESSES and len({_says(each) for each in decided}) == 1:
            return decided[0]
        names = sorted({name for guess, _ in guesses for name in guess} | {_who(missing)})
        duties = sorted({str(_view(each)) for each in decided})
        tail = f": it decides between {', '.join(duties)}" if len(duties) > 1 else ""
        alike = {each.give_way for each in decided}
        if len(duties) == 1 and len(alike) == 1 and decided[0].give_way:
            tail = (
                f": {', '.join(decided[0].give_way)} gives way whatever it is, but the side is not determined"
            )
        return Verdict(
            own=facts.own,
            other=facts.other,
            kind=Kind.UNKNOWN_FACT,
            ruleset=self.id,
            version=self.version,
            citation=decided[0].citation if decided else self.text.otherwise,
            geometry=decided[0].geometry if decided else Geometry.NONE,
            overtaker=decided[0].overtaker if decided else None,
            has_other_on_starboard=decided[0].has_other_on_starboard if decided else None,
            diagnosis="unknown_fact",
            reason=f"not known: {', '.join(names)}{tail}",
        )

    def _tried(self, facts: PairFacts, missing: Missing, guess: Mapping[str, FactValue]) -> Any:
        values = _values_of(facts, missing)
        if not values:
            yield guess, None
        for value in values:
            assumed = {**guess, _who(missing): value}
            completed = _completed(facts, missing, value)
            try:
                yield assumed, self._judged(completed)
            except UnknownFact as unknown:
                yield from self._tried(completed, unknown.missing, assumed)


_SWAPPED: Final = {"own": "other", "other": "own"}


def _arguments(facts: PairFacts) -> tuple[Values, Values, Values, Values, Values]:
    return facts.own_values, facts.other_values, facts.waterway_values, facts.pair_values, facts.motion


def _asked(name: str, decide: Callable[[], Any]) -> Any:
    try:
        return decide()
    except UnknownFact:
        return Missing("pair", name)


def _diagnosis(outcome: Outcome) -> str:
    if outcome.diagnosis is not None:
        return outcome.diagnosis.value
    return outcome.kind.value if outcome.kind in (Kind.CONFLICT, Kind.GAP) else ""


def _duty(applied: Applied, facts: PairFacts) -> tuple[object, ...]:
    """What a rule makes the two ships do; rules that make them do the same do not contradict one another."""
    outcome = applied.outcome
    kind = OPPOSITE.get(outcome.kind, outcome.kind) if applied.swapped else outcome.kind
    wanted = outcome.kind in (Kind.COOPERATE, Kind.PROHIBITED)
    return kind, wanted and (applied.swapped, facts.own), outcome.passing_side


def _says(verdict: Verdict) -> tuple[object, ...]:
    return verdict.kind, verdict.initiator, verdict.passing_side, verdict.side_chosen_by


def _view(verdict: Verdict) -> str:
    return f"{verdict.kind}" + (f" ({verdict.diagnosis})" if verdict.diagnosis else "")


def _who(missing: Missing) -> str:
    return missing.name if missing.owner == "pair" else f"{missing.owner}.{missing.name}"


def _values_of(facts: PairFacts, missing: Missing) -> tuple[FactValue, ...]:
    """All values that an unknown fact may have; none where there are too many."""
    scope = {"waterway": Scope.WATERWAY, "pair": Scope.PAIR}.get(missing.owner, Scope.SHIP)
    fact = facts.vocabulary.find(scope, missing.name)
    if fact is None:
        return ()
    return (True, False) if fact.kind is FactKind.FLAG else fact.choices


def _completed(facts: PairFacts, missing: Missing, value: FactValue) -> PairFacts:
    def put(values: Values) -> tuple[Any, ...]:
        return tuple(
            value
            if isinstance(each, Missing) and (each.owner, each.name) == (missing.owner, missing.name)
            else each
            for each in values
        )

    if missing.owner == "pair":
        place = facts.vocabulary.places[Scope.PAIR][missing.name]
        pair = tuple(value if n == place else each for n, each in enumerate(facts.pair_values))
        return replace(facts, pair_values=pair)
    return replace(
        facts,
        own_values=put(facts.own_values),
        other_values=put(facts.other_values),
        waterway_values=put(facts.waterway_values),
    )


_SUFFIX: Final = {"m": "_m", "s": "_s", "m/s": "_mps", "deg": "_deg"}


def _label(measured: tuple[str, ...]) -> str:
    """Name of a quantity of motion with its unit.

    >>> _label(("bearing", "own", "other")), _label(("speed", "own"))
    ('bearing(own, other)_deg', 'own.speed_mps')
    """
    name, *ships = measured
    quantity = "bearing" if name == "abs" else name
    suffix = _SUFFIX[MOTIONS[quantity][0].unit]
    if len(ships) == 2:
        return f"{quantity}({', '.join(ships)}){suffix}"
    return f"{ships[0]}.{name}{suffix}" if ships else f"{name}{suffix}"


def _rounded(value: float, name: str) -> float:
    return round(value / DEGREE if name in ("bearing", "abs", "course_difference") else value, 6)
