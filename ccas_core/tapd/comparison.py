"""Where two rulesets disagree: encounters for which they name other duties, grouped by their articles."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, Final

from .case_run import case_of, judge_case, told
from .cases import Case
from .ruleset import PairRuleset

_MOST_MOVING: Final = 8  # examples with ships under way that are kept of a group

Told = Mapping[str, Any]  # a verdict, as encounter files write it


@dataclass(frozen=True, slots=True, kw_only=True)
class Disagreement:
    """What two rulesets say of one encounter of two ships."""

    case: Case
    one: Told
    other: Told

    @property
    def what(self) -> str:
        """Whether the ships' duties differ, or only the side on which they pass."""
        return "side" if _duty(self.one) == _duty(self.other) else "duty"

    @property
    def key(self) -> tuple[str, ...]:
        """What a disagreement has in common with others: the articles and kinds, on both sides."""
        return (
            self.one["article"],
            self.one["kind"],
            self.other["article"],
            self.other["kind"],
            self.what,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """Disagreements between the same articles: how many there are, and the plainest of them."""

    count: int
    example: Disagreement
    moving: tuple[Disagreement, ...]  # with ships under way, and no geometry stated; the plainest first


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Two rulesets compared: how many encounters were tried, and where they disagree; most frequent first."""

    tried: int
    groups: tuple[Group, ...]

    @property
    def differing(self) -> int:
        """Encounters on which they disagree."""
        return sum(group.count for group in self.groups)


def compare(one: PairRuleset, other: PairRuleset, cases: Iterable[Case]) -> Comparison:
    """Compare two rulesets on encounters; groups of ships are compared pair by pair."""
    found: dict[tuple[str, ...], list[Disagreement]] = {}
    tried = 0
    for case in _pairs(cases):
        tried += 1
        if (difference := disagreement(one, other, case)) is not None:
            found.setdefault(difference.key, []).append(difference)
    groups = [_group(one, other, each) for each in found.values()]
    return Comparison(tried=tried, groups=tuple(sorted(groups, key=_frequent_first)))


def _pairs(cases: Iterable[Case]) -> Iterator[Case]:
    for case in cases:
        if len(case.ships) == 2:
            yield case
        else:
            ids = [ship.id for ship in case.ships]
            yield from (
                replace(case_of(case, a, b), id=f"{case.id}_{a}_{b}") for a, b in combinations(ids, 2)
            )


def disagreement(one: PairRuleset, other: PairRuleset, case: Case) -> Disagreement | None:
    """What the two rulesets say of a case with two ships; None where they say the same."""
    mine, theirs = told(judge_case(one, case)), told(judge_case(other, case))
    if (_duty(mine), mine["pass"]) == (_duty(theirs), theirs["pass"]):
        return None
    return Disagreement(case=case, one=mine, other=theirs)


def _duty(view: Told) -> tuple[Any, ...]:
    return view["kind"], view["give_way"], view["stand_on"], view["initiator"]


def _group(one: PairRuleset, other: PairRuleset, found: list[Disagreement]) -> Group:
    plainest = sorted(found, key=_stated)
    moving = [each for each in plainest if _moves(each.case)][:_MOST_MOVING]
    return Group(
        count=len(found),
        example=simplest(one, other, plainest[0]),
        moving=tuple(simplest(one, other, each) for each in moving),
    )


def _moves(case: Case) -> bool:
    return not case.encounter and all(ship.pose is not None for ship in case.ships)


def _stated(difference: Disagreement) -> tuple[int, str]:
    """How much a case states; one that somebody wrote is plainer than a generated one."""
    case = difference.case
    facts = sum(len(ship.facts) for ship in case.ships) + len(case.waterway)
    return facts + (0 if case.source else 1), case.id


def simplest(one: PairRuleset, other: PairRuleset, found: Disagreement) -> Disagreement:
    """Leave out of a generated case every fact that the disagreement does not hang on."""
    if found.case.source:
        return found
    best = found
    for case in _without_a_fact(found.case):
        smaller = case(best.case)
        again = disagreement(one, other, smaller)
        if again is not None and again.key == found.key:
            best = again
    return best


def _without_a_fact(case: Case) -> Iterator[Any]:
    """Ways to leave one fact out of a case, as functions of a case."""
    for name in case.waterway:
        yield lambda each, name=name: replace(
            each, waterway={key: value for key, value in each.waterway.items() if key != name}
        )
    for ship in case.ships:
        for name in ship.facts:
            if name != "length":
                yield lambda each, ship=ship.id, name=name: replace(
                    each,
                    ships=tuple(
                        replace(s, facts={k: v for k, v in s.facts.items() if (s.id, k) != (ship, name)})
                        for s in each.ships
                    ),
                )


def _frequent_first(group: Group) -> tuple[Any, ...]:
    return group.example.what, -group.count, group.example.key
