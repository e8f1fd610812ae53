"""Why a ruleset says what it says of two ships: every condition with its value, its limit and its margin.

A rule speaks of own and other; here it names the ships, so that it reads the same from both sides.
A fact that was recognised from positions and courses has the conditions of its recognition below it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

from ..ships import ShipId
from ..verdict import OPPOSITE, Kind, Verdict
from .condition_text import Reading, Words, stripped
from .facts import PairFacts
from .language.code import Decision, UnknownFact, Values, program
from .language.formula import And, Constant, Formula, Named, Not, Or, Sign, Test
from .language.threefold import Finding, Truth, examine
from .rules import Mirror, Policy, Rule
from .vocabulary import Scope
from .written import WrittenRuleset

_Values: TypeAlias = tuple[Values, Values, Values, Values, Values]
_AGAIN: Final = "as above"
_IMPOSSIBLE: Final = 1000  # conditions that fail count as many, where one can never hold


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A condition, as it holds for two ships, and what it is made of.

    `value` is None where a fact is not known.  `label` says where a condition stands in its rule, if not
    under `when`; `joined` whether one of its parts must hold, or none; else all of them must.
    """

    text: str
    value: Truth
    found: str = ""
    reading: Reading | None = None
    joined: str = ""
    label: str = ""
    parts: tuple[Row, ...] = ()

    @property
    def margin(self) -> str:
        """How far a quantity lies from its limit, and whether on the side that is asked for."""
        if self.reading is None or self.value is None:
            return ""
        return self.reading.margin("inside" if self.value else "outside")


@dataclass(frozen=True, slots=True, kw_only=True)
class RuleSeen:
    """A rule asked about two ships: `own` and `other` are those that it takes for own and other."""

    rule: Rule
    own: ShipId
    other: ShipId
    value: Truth
    rows: tuple[Row, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Explanation:
    """A verdict, and what it rests on.

    `rules` are those that decide it; where a fact is not known, those that it leaves open.  `recognition`
    says how the encounter was recognised, where no rule applies.
    """

    verdict: Verdict
    rules: tuple[RuleSeen, ...]
    recognition: tuple[Row, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class NearMiss:
    """A rule that would have given another verdict: what fails, and the rule that came before it."""

    rule: Rule
    own: ShipId
    other: ShipId
    failed: tuple[Row, ...]
    possible: bool  # whether it could apply to any ships
    prevented_by: str = ""


def explain(ruleset: WrittenRuleset, facts: PairFacts) -> Explanation:
    """Explain the verdict of `facts.own`'s view."""
    verdict = ruleset.judge(facts)
    look = _Look(ruleset, facts)
    if verdict.kind is Kind.UNKNOWN_FACT:
        return Explanation(verdict=verdict, rules=tuple(look.rule(*each) for each in look.left_open()))
    if not verdict.rule:
        return Explanation(verdict=verdict, rules=(), recognition=tuple(look.recognition()))
    return Explanation(verdict=verdict, rules=tuple(look.rule(*each) for each in look.deciding(verdict)))


def why_not(ruleset: WrittenRuleset, facts: PairFacts, kind: Kind) -> tuple[NearMiss, ...]:
    """Rules that would have given `facts.own`'s view some kind of verdict, the nearest to it first."""
    verdict = ruleset.judge(facts)
    look = _Look(ruleset, facts)
    look.prepare(*(rule.condition for rule in ruleset.text.rules))
    ids = [rule.id for rule in ruleset.text.rules]
    decided = ids.index(verdict.rule) if verdict.rule in ids else len(ids)
    found: list[tuple[tuple[bool, int, float, int], NearMiss]] = []
    for place, rule in enumerate(ruleset.text.rules):
        if rule.python:
            continue
        misses = [
            look.near_miss(rule, swapped=swapped)
            for swapped in look.sides
            if _kind_of(rule, swapped=swapped) is kind
        ]
        for miss in sorted(misses, key=lambda each: len(each.failed))[:1]:
            nearness = not miss.possible, len(miss.failed), sum(map(_relative, miss.failed)), place
            found.append((nearness, replace(miss, prevented_by=verdict.rule if decided < place else "")))
    return tuple(miss for _, miss in sorted(found, key=lambda each: each[0]))


def _kind_of(rule: Rule, *, swapped: bool) -> Kind:
    kind = rule.outcome.kind
    return OPPOSITE.get(kind, kind) if swapped else kind


def _relative(row: Row) -> float:
    return 1.0 if row.reading is None else row.reading.relative


class _Look:
    """Looks at the conditions of a ruleset for one pair; `swapped` asks a rule with the ships swapped."""

    def __init__(self, ruleset: WrittenRuleset, facts: PairFacts) -> None:
        self._text = ruleset.text
        seen, own, swapped = ruleset.recognised(facts)
        self._given = facts
        self._arguments: dict[bool, _Values] = {False: own[:5], True: swapped[:5]}
        self._seen = {False: seen, True: replace(seen.mirrored(), pair_values=swapped[3])}
        self._compiled: dict[Formula, tuple[Decision, int]] = {}
        self._values: dict[tuple[bool, Formula], Truth] = {}
        self._told: set[tuple[object, bool]] = set()
        self.sides = (False, True) if ruleset.text.mirror is Mirror.AUTO else (False,)

    # -- values ----------------------------------------------------------------------------------

    def prepare(self, *formulas: Formula) -> None:
        """Compile what conditions are made of, as those that judge are, so that they mean the same."""
        leaves = dict.fromkeys(leaf for formula in formulas for leaf in _leaves(formula))
        if new := [leaf for leaf in leaves if leaf not in self._compiled]:
            compiled = program(new, self._text.vocabulary, self._text.constants)
            self._compiled |= {
                leaf: (decision, compiled.memory)
                for leaf, decision in zip(new, compiled.decisions, strict=True)
            }

    def decide(self, leaf: Formula, *, swapped: bool) -> Truth:
        """Value of a condition that is not made of others, and has been prepared."""
        key = swapped, leaf
        if key not in self._values:
            decision, memory = self._compiled[leaf]
            try:
                self._values[key] = bool(decision(*self._arguments[swapped], [None] * memory))
            except UnknownFact:
                self._values[key] = None
        return self._values[key]

    def value(self, formula: Formula, *, swapped: bool) -> Truth:
        """Value of a condition."""
        self.prepare(formula)
        return examine(formula, lambda leaf: self.decide(leaf, swapped=swapped), lambda _: "").value

    # -- rules -----------------------------------------------------------------------------------

    def rule(self, rule: Rule, swapped: bool) -> RuleSeen:  # noqa: FBT001
        """Look at all conditions of a rule."""
        self._told.clear()
        rows: list[Row] = []
        for part in rule.parts:
            label = "" if part.label == "when" else part.label
            rows += (replace(row, label=label) for row in self.rows(part.formula, swapped=swapped))
        seen = self._seen[swapped]
        value = self.value(rule.condition, swapped=swapped)
        return RuleSeen(rule=rule, own=seen.own, other=seen.other, value=value, rows=tuple(rows))

    def deciding(self, verdict: Verdict) -> Iterator[tuple[Rule, bool]]:
        """Rules that decide, each with the way round in which it does."""
        several = verdict.kind is Kind.CONFLICT and self._text.policy is Policy.UNIQUE
        for rule in self._text.rules:
            if rule.id != verdict.rule and not several:
                continue
            values = {swapped: self.value(rule.condition, swapped=swapped) for swapped in self.sides}
            holds = [swapped for swapped in self.sides if values[swapped]]
            fits = [swapped for swapped in holds if _kind_of(rule, swapped=swapped) is verdict.kind]
            if several:
                yield from ((rule, swapped) for swapped in holds[:1])
                continue
            unsure = [swapped for swapped in self.sides if values[swapped] is None]
            yield rule, [*fits, *holds, *unsure, False][0]

    def left_open(self) -> Iterator[tuple[Rule, bool]]:
        """Rules that an unknown fact leaves open, down to the first one that applies for certain."""
        for rule in self._text.rules:
            for swapped in self.sides:
                value = self.value(rule.condition, swapped=swapped)
                if value is not False:
                    yield rule, swapped
                if value:
                    return

    def recognition(self) -> Iterator[Row]:
        """How it was decided that there is no encounter, or one without a rule."""
        if self._text.recognition is None:
            return
        for name, formula in zip(("risk", "head_on", "crossing"), self._kinds, strict=True):
            yield self._whole(name, formula, swapped=False)
        for swapped in (False, True):
            yield self._whole("overtaking", self._text.recognition.overtaking, swapped=swapped)

    @property
    def _kinds(self) -> tuple[Formula, ...]:
        found = self._text.recognition
        return () if found is None else (found.risk, found.head_on, found.crossing)

    def _whole(self, name: str, formula: Formula, *, swapped: bool) -> Row:
        seen = self._seen[swapped]
        return replace(self._examined(formula, swapped=swapped), text=f"{name}({seen.own}, {seen.other})")

    # -- rows ------------------------------------------------------------------------------------

    def rows(self, formula: Formula, *, swapped: bool) -> tuple[Row, ...]:
        """Rows of a condition; those that must all hold stand side by side."""
        row = self._examined(formula, swapped=swapped)
        return row.parts if isinstance(formula, And) and row.parts else (row,)

    def _examined(self, formula: Formula, *, swapped: bool) -> Row:
        self.prepare(formula)
        words = Words(self._text, self._seen[swapped])
        found = examine(formula, lambda leaf: self.decide(leaf, swapped=swapped), words.say)
        return self._row(found, words, swapped=swapped)

    def _row(self, found: Finding, words: Words, *, swapped: bool) -> Row:
        core, text = stripped(found.formula), words.named(found.text)
        shown, joined = words.found(found), _joined(found.formula)
        parts: tuple[Row, ...] = ()
        if isinstance(core, Test):
            parts, again = self._recognised(core, swapped=swapped)
            shown = f"{shown} ({_AGAIN})".lstrip() if again else shown
        elif isinstance(core, And | Or):  # without a name of its own
            text, joined = joined or "all of", ""
            parts = tuple(self._side_by_side(found, words, swapped=swapped))
        elif found.parts and not (isinstance(core, Named) and isinstance(core.part, Sign)):
            again = self._is_told(text, swapped)
            shown = _AGAIN if again else shown
            parts = () if again else tuple(self._side_by_side(found, words, swapped=swapped))
        return Row(
            text=text,
            value=found.value,
            found=shown,
            reading=words.reading(found),
            joined=joined if len(parts) > 1 else "",
            parts=parts,
        )

    def _side_by_side(self, found: Finding, words: Words, *, swapped: bool) -> Iterator[Row]:
        """Rows of the parts; what is joined in the same way, without a name, needs no level of its own."""
        formula = found.formula
        while isinstance(formula, Not | Named):
            formula = formula.part
        for part in found.parts:
            if type(part.formula) is type(formula) and isinstance(formula, And | Or):
                yield from self._side_by_side(part, words, swapped=swapped)
            else:
                yield self._row(part, words, swapped=swapped)

    def _is_told(self, what: object, swapped: bool) -> bool:  # noqa: FBT001
        """Whether a part has been told in full already; from now on it has."""
        key = what, swapped
        told = key in self._told
        self._told.add(key)
        return told

    def _recognised(self, test: Test, *, swapped: bool) -> tuple[tuple[Row, ...], bool]:
        """Conditions by which a fact of the pair was recognised; and whether they stand above already."""
        where = self._behind(test, swapped=swapped)
        if where is None:
            return (), False
        formula, turned = where
        if self._is_told(formula, turned):
            return (), True
        return self.rows(formula, swapped=turned), False

    def _behind(self, test: Test, *, swapped: bool) -> tuple[Formula, bool] | None:
        """Condition behind a fact of the pair, and which way round; none where the fact is stated."""
        recognition = self._text.recognition
        place = self._given.vocabulary.places[Scope.PAIR].get(test.fact)
        if recognition is None or place is None or self._given.pair_values[place] is not None:
            return None
        turned = swapped if test.value == "own" else not swapped
        if test.fact == "risk_of_collision":
            return recognition.risk, swapped
        if test.fact == "geometry" and test.value in ("head_on", "crossing"):
            return (recognition.head_on if test.value == "head_on" else recognition.crossing), swapped
        if test.fact == "geometry" and test.value == "overtaking":
            other_does = self.value(recognition.overtaking, swapped=not swapped) is True
            return recognition.overtaking, swapped is not other_does
        if test.fact == "overtaker" and test.value in ("own", "other"):
            return recognition.overtaking, turned
        if test.fact == "has_other_on_starboard" and test.value in ("own", "other"):
            return recognition.from_starboard, turned
        return None

    # -- what would have had to be different -----------------------------------------------------

    def near_miss(self, rule: Rule, *, swapped: bool) -> NearMiss:
        """Conditions that keep a rule from applying: the fewest that would have to change."""
        words = Words(self._text, self._seen[swapped])
        failed = dict.fromkeys(self._needed(rule.condition, wanted=True, swapped=swapped))
        rows = tuple(self._failed(leaf, words, wanted=wanted, swapped=swapped) for leaf, wanted in failed)
        possible = not any(isinstance(leaf, Constant) for leaf, _ in failed)
        seen = self._seen[swapped]
        return NearMiss(rule=rule, own=seen.own, other=seen.other, failed=rows, possible=possible)

    def _failed(self, leaf: Formula, words: Words, *, wanted: bool, swapped: bool) -> Row:
        asked = leaf if wanted else Not(leaf)
        found = examine(asked, lambda each: self.decide(each, swapped=swapped), words.say)
        return Row(
            text=words.named(found.text),
            value=found.value,
            found=words.found(found),
            reading=words.reading(found),
        )

    def _needed(self, formula: Formula, *, wanted: bool, swapped: bool) -> list[tuple[Formula, bool]]:
        """Conditions, not made of others, that would have to change for a formula to have a value."""
        match formula:
            case Not():
                return self._needed(formula.part, wanted=not wanted, swapped=swapped)
            case And() | Or():
                parts = [self._needed(part, wanted=wanted, swapped=swapped) for part in formula.parts]
                if isinstance(formula, And) is wanted:
                    return [each for part in parts for each in part]
                return min(parts, key=_cost)
            case Named() if formula.measure is None:
                return self._needed(formula.part, wanted=wanted, swapped=swapped)
            case Named():
                value = self.decide(formula.part, swapped=swapped)
            case Constant():
                value = formula.value
            case _:
                value = self.decide(formula, swapped=swapped)
        return [] if value is wanted else [(formula, wanted)]


def _cost(needed: list[tuple[Formula, bool]]) -> int:
    return sum(_IMPOSSIBLE if isinstance(leaf, Constant) else 1 for leaf, _ in needed)


def _joined(formula: Formula) -> str:
    """How the parts of a condition are joined; nothing where all must hold."""
    negated = False
    while isinstance(formula, Not | Named):
        negated ^= isinstance(formula, Not)
        formula = formula.part
    if isinstance(formula, Or):
        return "none of" if negated else "one of"
    return "not all of" if negated and isinstance(formula, And) else ""


def _leaves(formula: Formula) -> Iterator[Formula]:
    """Parts that are not made of others, as `examine` asks for them."""
    if isinstance(formula, And | Or):
        for part in formula.parts:
            yield from _leaves(part)
    elif isinstance(formula, Not) or (isinstance(formula, Named) and formula.measure is None):
        yield from _leaves(formula.part)
    elif isinstance(formula, Named):
        yield formula.part
    elif not isinstance(formula, Constant):
        yield formula
