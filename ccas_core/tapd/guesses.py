"""Facts that are not known: all values that they may have are tried, and what matters is told.

A fact that changes nothing need not be known.  One that decides what a ship is to do gives `unknown_fact`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any, Final

from ..ships import FactValue
from ..verdict import Verdict
from .facts import PairFacts
from .language.code import Missing, UnknownFact, Values
from .vocabulary import Kind, Scope

MOST_GUESSES: Final = 512  # values of unknown facts that are tried


@dataclass(frozen=True, slots=True)
class Guessed:
    """What comes of all guesses: the verdict that all lead to, or else why there is none."""

    decided: tuple[Verdict, ...]  # verdicts of the guesses that lead to one
    agreed: Verdict | None
    reason: str


def guessed(facts: PairFacts, missing: Missing, judge: Callable[[PairFacts], Verdict]) -> Guessed:
    """Try all values of the facts that are not known; `missing` is the first of them that was asked for."""
    guesses = list(islice(_tried(facts, missing, {}, judge), MOST_GUESSES + 1))
    decided = tuple(verdict for _, verdict in guesses if verdict is not None)
    whole = len(decided) == len(guesses) <= MOST_GUESSES
    if whole and len({_says(each) for each in decided}) == 1:
        return Guessed(decided, decided[0], "")
    names = sorted({name for guess, _ in guesses for name in guess} | {_who(missing)})
    return Guessed(decided, None, f"not known: {', '.join(names)}{_at_stake(decided, whole=whole)}")


def _at_stake(decided: tuple[Verdict, ...], *, whole: bool) -> str:
    duties = sorted({_view(each) for each in decided})
    if len(duties) > 1:
        return f": it decides between {', '.join(duties)}"
    if whole and duties and len({each.give_way for each in decided}) == 1 and decided[0].give_way:
        ships = ", ".join(decided[0].give_way)
        return f": {ships} gives way whatever it is, but the side is not determined"
    return ""


def _tried(
    facts: PairFacts, missing: Missing, guess: Mapping[str, FactValue], judge: Callable[[PairFacts], Verdict]
) -> Iterator[tuple[Mapping[str, FactValue], Verdict | None]]:
    values = _values_of(facts, missing)
    if not values:
        yield guess, None
    for value in values:
        assumed = {**guess, _who(missing): value}
        completed = _completed(facts, missing, value)
        try:
            yield assumed, judge(completed)
        except UnknownFact as unknown:
            yield from _tried(completed, unknown.missing, assumed, judge)


def _says(verdict: Verdict) -> tuple[object, ...]:
    return (
        verdict.kind,
        verdict.initiator,
        verdict.passing_side,
        verdict.side_chosen_by,
        verdict.must_follow,
    )


def _view(verdict: Verdict) -> str:
    return f"{verdict.kind}" + (f" ({verdict.diagnosis})" if verdict.diagnosis else "")


def _who(missing: Missing) -> str:
    return missing.name if missing.owner == "pair" else f"{missing.owner}.{missing.name}"


def _scope(facts: PairFacts, missing: Missing) -> Scope:
    """What a fact is about; a ship may be called 'pair'."""
    ships = (facts.own, facts.other)
    if missing.owner in ships and missing.name in facts.vocabulary.places[Scope.SHIP]:
        return Scope.SHIP
    return Scope.WATERWAY if missing.owner == "waterway" else Scope.PAIR


def _values_of(facts: PairFacts, missing: Missing) -> tuple[FactValue, ...]:
    """All values that an unknown fact may have; none where there are too many."""
    fact = facts.vocabulary.find(_scope(facts, missing), missing.name)
    if fact is None:
        return ()
    return (True, False) if fact.kind is Kind.FLAG else fact.choices


def _completed(facts: PairFacts, missing: Missing, value: FactValue) -> PairFacts:
    def put(values: Values) -> tuple[Any, ...]:
        return tuple(
            value
            if isinstance(each, Missing) and (each.owner, each.name) == (missing.owner, missing.name)
            else each
            for each in values
        )

    if _scope(facts, missing) is Scope.PAIR:
        place = facts.vocabulary.places[Scope.PAIR][missing.name]
        pair = tuple(value if n == place else each for n, each in enumerate(facts.pair_values))
        return replace(facts, pair_values=pair)
    return replace(
        facts,
        own_values=put(facts.own_values),
        other_values=put(facts.other_values),
        waterway_values=put(facts.waterway_values),
    )
