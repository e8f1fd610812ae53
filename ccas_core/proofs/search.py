"""Ships that show a fault: found by trying encounters on round numbers, judged by the code that runs at sea.

Facts come from the solver's suggestion; positions, courses and speeds from a seeded sampler that knows how
ships meet: courses in whole degrees, speeds in half metres a second, positions in whole metres.  Of those
that show the fault the one is kept that shows it with the widest margin: how far the other ship can be
moved in any of eight directions before the fault is gone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Final, TypeAlias

import numpy as np

from ..ships import ShipId
from ..tapd.case_run import pair_facts
from ..tapd.cases import Case, CaseShip
from ..tapd.rules import RulesetText
from ..tapd.vocabulary import Kind, Scope
from ..tapd.written import WrittenRuleset
from ..units import DEGREE
from ..verdict import Verdict
from .plain import USUAL_LENGTH, beam_of, plainer
from .solver import Answer

Goal: TypeAlias = Callable[[Verdict, Verdict], bool]  # of the views of A and of B

A, B = ShipId("A"), ShipId("B")
TRIES: Final = 1500
ENOUGH: Final = 12  # hits among which the one with the widest margin is taken
_REACHES: Final = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 80.0)  # [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ships:
    """An encounter that shows something, what both ships say of it, and its margin [m]."""

    case: Case
    verdicts: tuple[
        Verdict, ...
    ]  # views of A and of B; of a ring, of each ship on the one that it gives way to
    margin: float


@dataclass(frozen=True, slots=True)
class Facts:
    """Stated facts of ships and waters."""

    ships: Mapping[str, Mapping[str, Any]]
    waterway: Mapping[str, Any]
    pair: Mapping[str, Any]


def suggested(text: RulesetText, answer: Answer, ships: Sequence[str] = (A, B)) -> Facts:
    """Facts of a model, by ship; what it leaves open has its default."""
    by_ship: dict[str, dict[str, Any]] = {ship: {"length": USUAL_LENGTH} for ship in ships}
    waterway: dict[str, Any] = {}
    pair: dict[str, Any] = {}
    regimes: list[str] = []
    for name, value in answer.flags.items():
        owner, _, fact = name.partition(".")
        fact, _, word = fact.partition("=")
        if owner == "waterway":
            if fact == "regime" and value:
                regimes.append(word)
            elif fact != "regime" and (value or not word):
                waterway[fact] = word or value
        elif owner in by_ship and (value or not word):
            by_ship[owner][fact] = word or value
        elif "-" in owner:
            pair[fact] = value
    for name, number in answer.numbers.items():
        owner, _, fact = name.partition(".")
        known = text.vocabulary.find(Scope.SHIP, fact)
        if name.endswith((".beam", ".weight")) and number <= 0:
            continue  # no ship is so; it has a usual one
        if owner in by_ship and known is not None and known.kind is Kind.NUMBER and "*" not in name:
            by_ship[owner][fact] = _round(number, fact)
    for stated in by_ship.values():
        stated.setdefault("beam", beam_of(stated["length"]))
    if regimes:
        waterway["regime"] = " ".join(sorted(regimes))
    return Facts(by_ship, waterway, pair)


def _round(value: Fraction, fact: str) -> float:
    """A number as people write it, on the same side of every whole number."""
    if value.denominator == 1:
        return float(value)
    near = Fraction(round(value * 2), 2)
    return float(near if fact != "passengers_max" and math.floor(near) == math.floor(value) else value)


def case_of(
    facts: Facts, places: Mapping[str, tuple[float, float, float, float]], name: str = "ships"
) -> Case:
    """A case from facts and, by ship, north, east [m], course [deg] and speed [m/s]."""
    ships = tuple(
        CaseShip(
            id=ShipId(ship),
            facts=facts.ships[ship],
            pose=(north, east, course * DEGREE),
            speed=speed,
        )
        for ship, (north, east, course, speed) in places.items()
    )
    return Case(id=name, ships=ships, waterway=facts.waterway, encounter=dict(facts.pair))


def judged(rulesets: tuple[WrittenRuleset, WrittenRuleset], case: Case) -> tuple[Verdict, Verdict]:
    """Views of A and of B, each by its own ruleset."""
    one = pair_facts(case, A, B, rulesets[0].vocabulary)
    two = pair_facts(case, B, A, rulesets[1].vocabulary)
    return rulesets[0].judge(one), rulesets[1].judge(two)


def meetings(
    rng: np.random.Generator, speeds: tuple[float, float], separation: float, count: int
) -> Iterator[dict[str, tuple[float, float, float, float]]]:
    """Two ships that come near one another: head-on, overtaking, crossing, parallel, or just anyhow."""
    for n in range(count):
        kind = n % 6
        course = float(rng.integers(0, 360))
        turn = {
            0: 180.0 + rng.integers(-20, 21),
            1: float(rng.integers(-20, 21)),
            2: float(rng.integers(20, 161)) * rng.choice((-1.0, 1.0)),
            3: float(rng.choice((0.0, 180.0, 90.0, -90.0))),
            4: float(rng.integers(20, 161)) * rng.choice((-1.0, 1.0)),
            5: float(rng.integers(0, 360)),
        }[kind]
        placed = _pair(rng, course if kind != 3 else 0.0, float(turn), speeds, separation)
        if placed is not None:
            yield placed


def _pair(
    rng: np.random.Generator, course: float, turn: float, speeds: tuple[float, float], separation: float
) -> dict[str, tuple[float, float, float, float]] | None:
    low, high = math.ceil(2.0 * speeds[0]), math.floor(2.0 * speeds[1])
    own, other = (float(rng.integers(low, high + 1)) / 2.0 for _ in range(2))
    courses = (course % 360.0, (course + turn) % 360.0)
    relative = math.hypot(
        other * math.cos(courses[1] * DEGREE) - own * math.cos(courses[0] * DEGREE),
        other * math.sin(courses[1] * DEGREE) - own * math.sin(courses[0] * DEGREE),
    )
    until = float(rng.uniform(20.0, 400.0))
    if relative > 0.0:
        until = max(until, 1.2 * separation / relative)
    aside = float(rng.choice((0.0, 0.0, 10.0, 30.0, 100.0))) * rng.normal()
    places = []
    for each, speed in zip(courses, (own, other), strict=True):
        places.append((-speed * until * math.cos(each * DEGREE), -speed * until * math.sin(each * DEGREE)))
    across = (course + turn + 90.0) * DEGREE
    north = round(places[1][0] - places[0][0] + aside * math.cos(across))
    east = round(places[1][1] - places[0][1] + aside * math.sin(across))
    if math.hypot(north, east) < max(separation, 1.0):
        return None
    return {A: (0.0, 0.0, courses[0], own), B: (float(north), float(east), courses[1], other)}


def find(
    rulesets: tuple[WrittenRuleset, WrittenRuleset],
    facts: Facts,
    goal: Goal,
    seed: int = 0,
    tries: int = TRIES,
) -> Ships | None:
    """Find ships with these facts that reach a goal; None if none of the tries does."""
    domain = rulesets[0].text.domain
    speeds = (float(domain.speed[0]), float(domain.speed[1]))
    rng = np.random.default_rng(seed)
    hits: list[Ships] = []
    for places in meetings(rng, speeds, float(domain.separation), tries):
        case = case_of(facts, places)
        if (verdicts := _reaches(rulesets, case, goal)) is not None:
            hits.append(Ships(case=case, verdicts=verdicts, margin=0.0))
            if len(hits) == ENOUGH:
                break
    if not hits:
        return None
    best = max(
        (replace(hit, margin=margin(rulesets, hit.case, goal)) for hit in hits), key=lambda h: h.margin
    )
    return _plain(rulesets, best, goal)


def _plain(rulesets: tuple[WrittenRuleset, WrittenRuleset], ships: Ships, goal: Goal) -> Ships:
    """The same ships, with no more facts than it takes to show the same by the same rules."""
    rules = [view.rule for view in ships.verdicts]

    def shows(case: Case) -> bool:
        verdicts = _reaches(rulesets, case, goal)
        return verdicts is not None and [view.rule for view in verdicts] == rules

    case = plainer(ships.case, shows)
    return Ships(case=case, verdicts=judged(rulesets, case), margin=margin(rulesets, case, goal))


def _reaches(
    rulesets: tuple[WrittenRuleset, WrittenRuleset], case: Case, goal: Goal
) -> tuple[Verdict, Verdict] | None:
    verdicts = judged(rulesets, case)
    return verdicts if goal(*verdicts) and _in_domain(rulesets, case) else None


def _in_domain(rulesets: tuple[WrittenRuleset, WrittenRuleset], case: Case) -> bool:
    """Whether what the rulesets assume of ships holds, as both see it."""
    return all(
        ruleset.assumptions(pair_facts(case, own, other, ruleset.vocabulary))
        for ruleset in dict.fromkeys(rulesets)
        if ruleset.text.domain.assume
        for own, other in ((A, B), (B, A))
    )


def margin(rulesets: tuple[WrittenRuleset, WrittenRuleset], case: Case, goal: Goal) -> float:
    """How far ship B can be moved in any of eight directions, and the goal is still reached [m]."""
    found = 0.0
    for reach in _REACHES:
        for direction in range(8):
            moved = _moved(case, reach, direction * math.pi / 4.0)
            if _reaches(rulesets, moved, goal) is None:
                return found
        found = reach
    return found


def _moved(case: Case, reach: float, direction: float) -> Case:
    own, other = case.ships
    assert other.pose is not None  # noqa: S101
    north, east, course = other.pose
    pose = (north + reach * math.cos(direction), east + reach * math.sin(direction), course)
    return replace(case, ships=(own, replace(other, pose=pose)))
