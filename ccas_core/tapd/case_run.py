"""Cases judged: what a ruleset says of the ships of a case, and whether that is what was expected."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any, Final

from ..priority import PriorityGraph, Settlement, settle
from ..quantities import ANGLE
from ..ships import UNKNOWN, ShipId
from ..units import DEGREE
from ..verdict import Kind, Verdict
from .assign import failed
from .cases import Case, CaseShip, Expected
from .facts import STOPPED, PairFacts, motion
from .language.code import MOTION, Missing
from .ruleset import PairRuleset
from .vocabulary import Scope, Vocabulary

_PARALLEL: Final = math.sin(math.radians(22.5))
_ALWAYS: Final = ("kind", "give_way", "stand_on", "pass", "strength")  # compared wherever they are stated
_STRICT: Final = (
    "side_chosen_by",
    "must_follow",
    "facilitates",
    "required_manoeuvre",
    "initiator",
    "by",
    "article",
)
_NO_WEIGHT: Final = 1.0  # of a ship whose weight a case does not state [kg]


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """What a ruleset says of a case; of a group of ships, pair by pair."""

    settlements: tuple[Settlement, ...]
    diagnosis: str
    gives_way_to: frozenset[tuple[ShipId, ShipId]] = frozenset()
    mutual: frozenset[frozenset[ShipId]] = frozenset()
    no_rule: frozenset[frozenset[ShipId]] = frozenset()
    cycles: tuple[tuple[ShipId, ...], ...] = ()
    order: tuple[ShipId, ...] = ()

    @property
    def pair(self) -> Settlement:
        """The one pair of a case with two ships."""
        return self.settlements[0]


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """A case under one ruleset: expected, got, and what differs."""

    case: Case
    ruleset: str
    expected: Expected
    judged: Judged | None  # None: skipped, for the case has no ships
    differences: tuple[str, ...] = field(default=())

    @property
    def passed(self) -> bool:
        """Whether nothing that is stated differs."""
        return not self.differences


def pair_facts(case: Case, own: ShipId, other: ShipId, vocabulary: Vocabulary) -> PairFacts:
    """Facts about two ships of a case, as `own` sees them."""
    ships = {ship.id: ship for ship in case.ships}
    one, two = ships[own], ships[other]
    return PairFacts(
        vocabulary=vocabulary,
        own=own,
        other=other,
        own_values=_ship_values(case, one, two, vocabulary),
        other_values=_ship_values(case, two, one, vocabulary),
        waterway_values=_values(case.waterway, "waterway", vocabulary, Scope.WATERWAY),
        pair_values=_pair_values(case, own, other, vocabulary),
        motion=_motion(one, two, case.encounter.get("time_to_intersection", {})),
    )


def _ship_values(case: Case, ship: CaseShip, other: CaseShip, vocabulary: Vocabulary) -> tuple[Any, ...]:
    facts = dict(ship.facts)
    windward = case.encounter.get("windward")
    if windward is not None:
        facts["windward"] = windward == ship.id
    elif other.facts.get("windward") is True:
        facts.setdefault("windward", False)
    return _values(facts, ship.id, vocabulary, Scope.SHIP)


def _values(stated: Mapping[str, Any], owner: str, vocabulary: Vocabulary, scope: Scope) -> tuple[Any, ...]:
    values = []
    for fact in vocabulary.by_scope[scope]:
        value = stated.get(fact.name, fact.default)
        if value is UNKNOWN:
            value = Missing(owner, fact.name)
        elif fact.name == "regime":
            value = frozenset(value.split())
        elif fact.quantity is ANGLE:
            value = value / DEGREE  # conditions compare degrees
        values.append(value)
    return tuple(values)


def _pair_values(case: Case, own: ShipId, other: ShipId, vocabulary: Vocabulary) -> tuple[Any, ...]:
    names = {own: "own", other: "other"}
    values = []
    for fact in vocabulary.by_scope[Scope.PAIR]:
        value = case.encounter.get(fact.name) if len(case.ships) == 2 else None
        if value is UNKNOWN:
            value = Missing("pair", fact.name)
        elif value is None and fact.name in ("same_waterway", "same_direction"):
            value = fact.default
        elif isinstance(value, str):
            value = names.get(ShipId(value), value)
        values.append(value)
    return tuple(values)


def _motion(own: CaseShip, other: CaseShip, stated: Mapping[ShipId, float]) -> tuple[Any, ...]:
    if own.pose is None or other.pose is None or own.speed is None or other.speed is None:
        return tuple(Missing("pair", name) for name in MOTION)
    times = (
        stated.get(own.id, crossing_time(own.pose, own.speed, other.pose)),
        stated.get(other.id, crossing_time(other.pose, other.speed, own.pose)),
    )
    return motion(own.pose, own.speed, other.pose, other.speed, times)


def crossing_time(own: tuple[float, float, float], speed: float, other: tuple[float, float, float]) -> float:
    """Time until a ship reaches the line on which another sails [s], as if it were the axis of its waterway.

    Negative when past; never, where the courses are within 22.5 deg of parallel: that is one waterway.
    """
    across = math.sin(other[2] - own[2])
    if abs(across) < _PARALLEL or speed <= STOPPED:
        return math.inf
    north, east = other[0] - own[0], other[1] - own[1]
    return (north * math.sin(other[2]) - east * math.cos(other[2])) / across / speed


def judge_case(ruleset: PairRuleset, case: Case) -> Judged:
    """Judge every pair of a case from both sides."""
    masses = {ship.id: _weight(ship) for ship in case.ships}
    settlements = []
    for one, other in combinations(masses, 2):
        facts = pair_facts(case, one, other, ruleset.vocabulary)
        settlements.append(settle(_view(ruleset, facts), _view(ruleset, facts.mirrored()), masses))
    met = tuple(each for each in settlements if not _nothing(each))
    graph = PriorityGraph(masses=masses, settlements=met)
    agreed = [each for each in settlements if not each.fallback]
    duties = frozenset(
        (each.one.give_way[0], each.one.stand_on[0])
        for each in agreed
        if len(each.one.give_way) == len(each.one.stand_on) == 1
    )
    cycles = graph.cycles()
    return Judged(
        settlements=tuple(settlements),
        diagnosis=_diagnosis(settlements, bool(cycles)),
        gives_way_to=duties,
        mutual=frozenset(frozenset(each.pair) for each in agreed if each.one.kind is Kind.MUTUAL),
        no_rule=frozenset(
            frozenset(each.pair)
            for each in settlements
            if each.one.kind is Kind.NONE and each.one.reason != "no_risk"
        ),
        cycles=cycles,
        order=tuple(ship for generation in graph.generations() for ship in generation),
    )


def _weight(ship: CaseShip) -> float:
    weight = ship.facts.get("weight", _NO_WEIGHT)
    return float(weight) if isinstance(weight, int | float) else _NO_WEIGHT


def _view(ruleset: PairRuleset, facts: PairFacts) -> Verdict:
    """Judge from one side; whatever a plugin raises becomes a verdict that says so."""
    try:
        return ruleset.judge(facts)
    except Exception as error:  # a plugin may raise anything
        return failed(ruleset, facts.own, facts.other, error)


def _nothing(settlement: Settlement) -> bool:
    return (settlement.one.kind, settlement.other.kind) == (Kind.NONE, Kind.NONE)


def _diagnosis(settlements: list[Settlement], cyclic: bool) -> str:  # noqa: FBT001
    """What is wrong with the verdicts of a case: the worst of it, or that all is well."""
    if cyclic and len(settlements) > 1:
        return "cycle"
    for each in settlements:
        if each.one.diagnosis and each.one.diagnosis == each.other.diagnosis:
            return each.one.diagnosis
        if found := clash(each.one, each.other):
            return found
    silent = [each.one.kind is Kind.NONE and each.one.reason != "no_risk" for each in settlements]
    if any(silent):
        decided = any(each.one.kind is not Kind.NONE for each in settlements)
        return "incomplete" if decided else "no_rule"
    return "ok"


def clash(one: Verdict, other: Verdict) -> str:
    """How two views contradict one another; nothing where they do not."""
    kinds = {one.kind, other.kind}
    if kinds == {Kind.STAND_ON}:
        return "both_stand_on"
    if kinds == {Kind.GIVE_WAY}:
        return "both_give_way"
    if one.kind in (Kind.GIVE_WAY, Kind.STAND_ON) or other.kind in (Kind.GIVE_WAY, Kind.STAND_ON):
        return "" if kinds == {Kind.GIVE_WAY, Kind.STAND_ON} else "inconsistent"
    return "inconsistent" if one.kind is not other.kind or one.initiator != other.initiator else ""


def run_case(ruleset: PairRuleset, case: Case, expected: Expected) -> Result:
    """Judge a case and compare; a case without ships is skipped."""
    if not case.ships:
        return Result(case=case, ruleset=ruleset.id, expected=expected, judged=None)
    judged = judge_case(ruleset, case)
    hard = case.hard or len(case.ships) > 2
    differences = tuple(_differences(judged, expected, hard=hard, strict=case.strict))
    return Result(case=case, ruleset=ruleset.id, expected=expected, judged=judged, differences=differences)


def _differences(judged: Judged, expected: Expected, *, hard: bool, strict: bool) -> Iterator[str]:
    if expected.diagnosis is not None:
        same = judged.diagnosis == expected.diagnosis
        if not same and not (expected.diagnosis == "acyclic" and judged.diagnosis == "ok"):
            yield f"diagnosis: expected {expected.diagnosis}, got {judged.diagnosis}"
    if hard:
        yield from _group_differences(judged, expected)
        return
    got = told(judged)
    for name in (*_ALWAYS, *(_STRICT if strict else ())):
        wanted = _stated(expected, name)
        if wanted is None:
            continue
        if name == "article":
            if expected.rule and articles(wanted).isdisjoint(articles(got["article"])):
                yield f"article: expected {wanted}, got {got['article'] or 'none'}"
        elif got[name] != wanted:
            yield f"{name}: expected {_said(wanted)}, got {_said(got[name])}"
    if (
        expected.reason in ("no_rule", "no_risk")
        and got["kind"] == "none"
        and got["reason"] != expected.reason
        and strict
    ):
        yield f"reason: expected {expected.reason}, got {got['reason']}"


def _stated(expected: Expected, name: str) -> Any:
    field_ = {"pass": "passing_side", "required_manoeuvre": "manoeuvre", "by": "rule"}.get(name, name)
    value = getattr(expected, field_)
    return sorted(value) if isinstance(value, frozenset) else value or None


def _said(value: Any) -> str:
    return ", ".join(value) or "nobody" if isinstance(value, list) else str(value or "nothing")


def _group_differences(judged: Judged, expected: Expected) -> Iterator[str]:
    for name in ("gives_way_to", "mutual", "no_rule"):
        wanted, got = getattr(expected, name), getattr(judged, name)
        if wanted is not None and wanted != got:
            yield f"{name}: expected {_pairs(wanted)}, got {_pairs(got)}"
    if expected.cycle is not None and expected.cycle not in {frozenset(ring) for ring in judged.cycles}:
        yield f"cycle: expected {', '.join(sorted(expected.cycle))}, got {judged.cycles or 'none'}"
    if (
        expected.order is not None
        and expected.diagnosis in ("cycle", "ok", "acyclic")
        and expected.order != judged.order
    ):
        yield f"order: expected {', '.join(expected.order)}, got {', '.join(judged.order)}"


def _pairs(pairs: Any) -> str:
    return (
        "; ".join(sorted(" ".join(pair if isinstance(pair, tuple) else sorted(pair)) for pair in pairs))
        or "none"
    )


def told(judged: Judged) -> dict[str, Any]:
    """Verdict of a case with two ships, as encounter files write it; views that clash are a conflict."""
    view, other = judged.pair.one, judged.pair.other
    found = clash(view, other)
    return {
        "kind": "conflict" if found else _kind(view),
        "give_way": [] if found else sorted(view.give_way),
        "stand_on": [] if found else sorted(view.stand_on),
        "pass": view.passing_side.value if view.passing_side else None,
        "strength": view.strength or None,
        "side_chosen_by": view.side_chosen_by,
        "must_follow": [view.must_follow] if view.must_follow else [],
        "facilitates": [view.facilitates] if view.facilitates else [],
        "required_manoeuvre": view.manoeuvre or None,
        "initiator": view.initiator,
        "article": view.article,
        "ruleset_version": view.version,
        "by": view.rule,
        "reason": view.reason,
        "diagnosis": judged.diagnosis,
    }


def _kind(view: Verdict) -> str:
    return Kind.GIVE_WAY.value if view.kind is Kind.STAND_ON else view.kind.value


def articles(text: str) -> frozenset[str]:
    """Numbers of the articles that a citation names, without paragraphs.

    >>> sorted(articles("RPNR 9.04(3) with 6.04(3),(5)"))
    ['6.04', '9.04']
    >>> sorted(articles("33 CFR 83.09(a)(ii)") | articles("BPR 6.07(8)c"))
    ['6.07', '83.09']
    """
    return frozenset(
        re.findall(r"(?<![\w.])\d+(?:\.\d+)?[a-z]?", re.sub(r"\([^)]*\)|\b\d+ (?=[A-Z]{2})", " ", text))
    )


def case_of(case: Case, *ships: ShipId) -> Case:
    """Restrict a case to two of its ships, whose encounter is then recognised from where they are."""
    return replace(case, ships=tuple(ship for ship in case.ships if ship.id in ships), encounter={})
