"""Ships that show a fault: found by trying encounters on round numbers, judged by the code that runs at sea.

Facts come from the solver's suggestion; positions, courses and speeds from a seeded sampler that knows how
ships meet: courses in whole degrees, speeds in half metres a second, positions in whole metres.  Of those
that show the fault the one is kept that shows it with the widest margin: how far the other ship can be
moved in any of eight directions before the fault is gone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise
from typing import Any, Final, TypeAlias

import numpy as np

from ..ships import ShipId
from ..sim.case_scenario import USUAL_LENGTH, beam_of
from ..tapd.case_run import pair_facts
from ..tapd.cases import Case, CaseShip
from ..tapd.language.polynomial import Polynomial
from ..tapd.rules import Domain, RulesetText
from ..tapd.vocabulary import Kind, Scope
from ..tapd.written import WrittenRuleset
from ..units import DEGREE
from ..verdict import Verdict
from .plain import plainer
from .solver import Answer

Goal: TypeAlias = Callable[[Verdict, Verdict], bool]  # of the views of A and of B

A, B = ShipId("A"), ShipId("B")
TRIES: Final = 600
ENOUGH: Final = 5  # hits among which the one with the widest margin is taken
_UNTIL: Final = (math.log(8.0), math.log(400.0))  # time to the closest approach, as many soon as late [ln s]
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
    times: Mapping[ShipId, float] = field(default_factory=dict)  # to a junction, if that is on a chart [s]

    def at_a_junction(self) -> Facts:
        """The same, the times to the junction stated, as a chart would show them."""
        return replace(self, pair={**self.pair, "time_to_intersection": dict(self.times)})


def suggested(
    text: RulesetText, answer: Answer, ships: Sequence[str] = (A, B), atoms: Iterable[Polynomial] = ()
) -> Facts:
    """Facts of a model, by ship; what it leaves open has its default.

    `atoms` are the polynomials whose signs are asked for: numbers are rounded as far as these allow.
    """
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
    for name, number in _written_numbers(text, answer.numbers, atoms).items():
        owner, _, fact = name.partition(".")
        if not (fact in ("beam", "weight") and number <= 0.0):  # no ship is so; it has a usual one
            (waterway if owner == "waterway" else by_ship.get(owner, {}))[fact] = number
    for stated in by_ship.values():
        stated.setdefault("beam", beam_of(stated["length"]))
    times = {
        ShipId(ship): float(answer.numbers[f"{ship}.time_to_intersection"])
        for ship in ships
        if f"{ship}.time_to_intersection" in answer.numbers
    }
    if regimes:
        waterway["regime"] = " ".join(sorted(regimes))
    return Facts(by_ship, waterway, pair, times)


def _written_numbers(
    text: RulesetText, numbers: Mapping[str, Fraction], atoms: Iterable[Polynomial]
) -> dict[str, float]:
    """Numbers of facts as people write them, if that changes no condition on facts; else as they are."""
    exact = {}
    for name, value in numbers.items():
        owner, _, fact = name.partition(".")
        known = text.vocabulary.find(Scope.WATERWAY if owner == "waterway" else Scope.SHIP, fact)
        if known is not None and known.kind is Kind.NUMBER and "*" not in name:
            exact[name] = value
    near = {name: Fraction(round(value * 2), 2) for name, value in exact.items()}
    asked = [each for each in atoms if each.variables and each.variables <= exact.keys()]
    same = all(_sign(each, exact) == _sign(each, near) for each in asked)
    return {name: float(value) for name, value in (near if same else exact).items()}


def _sign(polynomial: Polynomial, values: Mapping[str, Fraction]) -> int:
    value = polynomial.evaluated(values, Fraction)
    return (value > 0) - (value < 0)


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
    rng: np.random.Generator,
    speeds: tuple[float, float],
    separation: float,
    count: int,
    wanted: Sequence[float] = (),
) -> Iterator[dict[str, tuple[float, float, float, float]]]:
    """Two ships that come near one another: head-on, overtaking, crossing, parallel, or just anyhow.

    `wanted` are speeds of which one is often taken.
    """
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
        placed = _pair(rng, course if kind != 3 else 0.0, float(turn), speeds, separation, wanted)
        if placed is not None:
            yield placed


def _pair(
    rng: np.random.Generator,
    course: float,
    turn: float,
    speeds: tuple[float, float],
    separation: float,
    wanted: Sequence[float],
) -> dict[str, tuple[float, float, float, float]] | None:
    low, high = math.ceil(2.0 * speeds[0]), math.floor(2.0 * speeds[1])
    own, other = (
        float(rng.choice(wanted))
        if wanted and rng.random() < 0.5
        else float(rng.integers(low, high + 1)) / 2.0
        for _ in range(2)
    )
    courses = (course % 360.0, (course + turn) % 360.0)
    relative = math.hypot(
        other * math.cos(courses[1] * DEGREE) - own * math.cos(courses[0] * DEGREE),
        other * math.sin(courses[1] * DEGREE) - own * math.sin(courses[0] * DEGREE),
    )
    until = float(np.exp(rng.uniform(*_UNTIL)))
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
    enough: int = ENOUGH,
    wanted: Sequence[float] = (),
) -> Ships | None:
    """Find ships with these facts that reach a goal; None if none of the tries does.

    The search ends with `enough` of them; `wanted` are speeds worth trying.
    """
    domain = rulesets[0].text.domain
    speeds = (float(domain.speed[0]), float(domain.speed[1]))
    places = meetings(np.random.default_rng(seed), speeds, float(domain.separation), tries, wanted)
    return widest(rulesets, (case_of(facts, each) for each in places), goal, enough)


def widest(
    rulesets: tuple[WrittenRuleset, WrittenRuleset], cases: Iterable[Case], goal: Goal, enough: int = ENOUGH
) -> Ships | None:
    """Of the first cases that reach a goal the one with the widest margin; None if none does.

    Where one is enough, it is taken as it is: that there are such ships is all that is asked.
    """
    hits: list[Ships] = []
    for case in cases:
        if (verdicts := _reaches(rulesets, case, goal)) is not None:
            hits.append(Ships(case=case, verdicts=verdicts, margin=0.0))
            if len(hits) == enough:
                break
    if not hits or enough == 1:
        return hits[0] if hits else None
    best = max(
        (replace(hit, margin=margin(rulesets, hit.case, goal)) for hit in hits), key=lambda h: h.margin
    )
    return _plain(rulesets, best, goal)


def telling_speeds(atoms: Iterable[Polynomial], domain: Domain) -> tuple[float, ...]:
    """Speeds at and between those that conditions compare with; none, where speeds are compared with none."""
    limits = set()
    for atom in atoms:
        terms = dict(atom.terms)
        square = terms.pop(("A.vx", "A.vx"), None)
        if square is not None and terms.keys() == {()} and terms[()] * square < 0:
            limits.add(math.sqrt(-terms[()] / square))
    inside = sorted(each for each in limits if domain.speed[0] <= each <= domain.speed[1])
    if not inside:
        return ()
    ends = [float(domain.speed[0]), *inside, float(domain.speed[1])]
    return tuple(sorted({*inside, *((low + high) / 2.0 for low, high in pairwise(ends))}))


def placed(answer: Answer, domain: Domain) -> Iterator[dict[str, tuple[float, float, float, float]]]:
    """Places of a model of two ships, A at the origin: rounded, and as they are; none outside the domain."""
    names = ("A.vx", "w.x", "w.y", "B.x", "B.y")
    if not all(name in answer.numbers for name in names[1:]):
        return
    own, wx, wy, north, east = (float(answer.numbers.get(name, 0)) for name in names)
    speed, course = math.hypot(own + wx, wy), math.degrees(math.atan2(wy, own + wx)) % 360.0
    for digits in (0, 1, 2, 12):
        pose = tuple(round(each, digits) for each in (north, east, course))
        speeds = tuple(round(each, max(digits, 1)) for each in (own, speed))
        within = all(float(domain.speed[0]) <= each <= float(domain.speed[1]) for each in speeds)
        if within and math.hypot(*pose[:2]) >= float(domain.separation):
            yield {A: (0.0, 0.0, 0.0, speeds[0]), B: (pose[0], pose[1], pose[2], speeds[1])}


def _plain(rulesets: tuple[WrittenRuleset, WrittenRuleset], ships: Ships, goal: Goal) -> Ships | None:
    """The same ships, with no more facts than it takes to show the same by the same rules."""
    rules = [view.rule for view in ships.verdicts]

    def shows(case: Case) -> bool:
        verdicts = _reaches(rulesets, case, goal)
        return verdicts is not None and [view.rule for view in verdicts] == rules

    case = plainer(ships.case, shows)
    if not goal(*judged(rulesets, case)):  # each ship by its own facts, as at sea
        return None
    return Ships(case=case, verdicts=judged(rulesets, case), margin=margin(rulesets, case, goal))


def _reaches(
    rulesets: tuple[WrittenRuleset, WrittenRuleset], case: Case, goal: Goal
) -> tuple[Verdict, Verdict] | None:
    """Verdicts of ships within the domain, if they reach a goal."""
    one, other = rulesets
    seen = pair_facts(case, A, B, one.vocabulary)
    turned = seen.mirrored() if other is one else pair_facts(case, B, A, other.vocabulary)
    verdicts = one.judge(seen), other.judge(turned)
    if not goal(*verdicts):
        return None
    if other is not one and (one.text.domain.assume or other.text.domain.assume):
        views = (
            seen,
            pair_facts(case, B, A, one.vocabulary),
            pair_facts(case, A, B, other.vocabulary),
            turned,
        )
        met = all(
            ruleset.assumptions(view) for ruleset, view in zip((one, one, other, other), views, strict=True)
        )
    else:
        met = not one.text.domain.assume or (one.assumptions(seen) and one.assumptions(turned))
    return verdicts if met else None


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
