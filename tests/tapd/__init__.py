"""Tests of layer 1, with charts, reports and encounters made by hand or at random for them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from typing import Any, TypeAlias

import numpy as np

from ccas_core.frames import FloatArray, NedPose
from ccas_core.plugins import load
from ccas_core.ships import FactValue, Hull, Ship, ShipId
from ccas_core.tapd.case_run import pair_facts
from ccas_core.tapd.cases import Case, CaseShip
from ccas_core.tapd.encounters import NO_ENCOUNTER, Encounter
from ccas_core.tapd.facts import PairFacts, assess
from ccas_core.tapd.language.code import MOTION, program
from ccas_core.tapd.language.compiler import Compiler
from ccas_core.tapd.ruleset import Situation
from ccas_core.tapd.vocabulary import VOCABULARY, Scope, Vocabulary
from ccas_core.tapd.written import WrittenRuleset
from ccas_core.units import DEGREE, wrap
from ccas_core.verdict import Kind, Verdict
from ccas_core.waterway import Towards, Waters, Waterway
from ccas_core.world import ShipReport, World

Place: TypeAlias = Callable[[FloatArray], FloatArray]
Course: TypeAlias = Callable[[float], float]

Condition: TypeAlias = Callable[[PairFacts], bool]

A, B, C, D = ShipId("a"), ShipId("b"), ShipId("c"), ShipId("d")


def verdict(
    own: ShipId,
    other: ShipId,
    kind: Kind,
    *,
    version: str = "1",
    initiator: ShipId | None = None,
    reason: str = "",
) -> Verdict:
    """Make a verdict; where a kind needs an initiator and none is given, it is the smaller id."""
    if initiator is None and kind in (Kind.COOPERATE, Kind.PROHIBITED):
        initiator = min(own, other)
    return Verdict(
        own=own, other=other, kind=kind, ruleset="r", version=version, initiator=initiator, reason=reason
    )


@cache
def installed() -> Mapping[str, Any]:
    """All rulesets that are installed, by id."""
    return load().rulesets


def ruleset(id_: str) -> WrittenRuleset:
    """Ruleset of ours, from its file."""
    found = installed()[id_]
    assert isinstance(found, WrittenRuleset)
    return found


@cache
def condition(text: str, of: str = "tran2026", **limits: float) -> Condition:
    """Compile a condition in the words of a ruleset; `limits` are values of its parameters [SI, deg]."""
    rules = ruleset(of).text
    parameters = {
        name: replace(each, value=Fraction(limits.get(name, each.value)))
        for name, each in rules.parameters.items()
    }
    assert limits.keys() <= parameters.keys()
    compiler = Compiler(
        vocabulary=rules.vocabulary,
        parameters=parameters,
        definitions=rules.definitions,
        regimes=rules.regimes,
    )
    formula = compiler.condition(text)
    constants = replace(rules, parameters=parameters, tangents=compiler.tangents).constants
    made = program([formula], rules.vocabulary, constants)

    def decide(facts: PairFacts) -> bool:
        values = facts.own_values, facts.other_values, facts.waterway_values, facts.pair_values, facts.motion
        return made.decisions[0](*values, [None] * made.memory)

    return decide


def plain(facts: PairFacts) -> dict[str, Any]:
    """All facts of a pair by name, and its motion, so that they can be compared."""
    names = [f"{ship}.{fact.name}" for ship in ("own", "other") for fact in VOCABULARY.by_scope[Scope.SHIP]]
    names += [f"waterway.{fact.name}" for fact in VOCABULARY.by_scope[Scope.WATERWAY]]
    names += [fact.name for fact in VOCABULARY.by_scope[Scope.PAIR]]
    return {"ships": (facts.own, facts.other)} | {name: facts[name] for name in (*names, *MOTION)}


def waters(angle: float = 90.0, width: float = 160.0) -> Waters:
    """Lay a river from south to north, and a canal at an angle [deg] to it, 6 km each, through the origin."""
    north, east = 3000.0 * math.cos(angle * DEGREE), 3000.0 * math.sin(angle * DEGREE)
    river = Waterway(id="river", centreline=np.array([[-3000.0, 0.0], [3000.0, 0.0]]), width=width)
    canal = Waterway(id="canal", centreline=np.array([[-north, -east], [north, east]]), width=width)
    return Waters(ruleset="tran2026", waterways=(river, canal))


CHART = waters()


def report(
    id_: ShipId,
    north: float,
    east: float,
    course: float,
    *,
    speed: float = 3.0,
    waterway: str = "river",
    towards: Towards = Towards.END,
    starboard: FactValue | None = None,
    mass: float = 1e6,
) -> ShipReport:
    """Report of a ship of 100 m by 10 m; the course in degrees."""
    facts = {} if starboard is None else {"follows_starboard_side": starboard}
    return ShipReport(
        ship=Ship(id=id_, hull=Hull(length=100.0, beam=10.0), mass=mass, facts=facts),
        pose=NedPose(north, east, course * DEGREE),
        speed=speed,
        waterway=waterway,
        towards=towards,
        ruleset="tran2026",
    )


def head_on(own: FactValue | None = None, other: FactValue | None = None) -> Meeting:
    """Ship a goes up the river, and meets b, which comes down."""
    return Meeting(
        CHART,
        report(A, -1000.0, 0.0, 0.0, starboard=own),
        report(B, 1000.0, 0.0, 180.0, towards=Towards.START, starboard=other),
    )


def crossing(
    own: FactValue | None = None, other: FactValue | None = None, *, other_from_starboard: bool = True
) -> Meeting:
    """Ship a goes up the river, and meets b, which comes along the canal."""
    east, course, towards = (
        (1000.0, 270.0, Towards.START) if other_from_starboard else (-1000.0, 90.0, Towards.END)
    )
    return Meeting(
        CHART,
        report(A, -1000.0, 0.0, 0.0, starboard=own),
        report(B, 0.0, east, course, waterway="canal", towards=towards, starboard=other),
    )


def overtaking(own: FactValue | None = None, other: FactValue | None = None) -> Meeting:
    """Ship a comes up from astern of b, both up the river."""
    return Meeting(
        CHART,
        report(A, -1000.0, 0.0, 0.0, speed=5.0, starboard=own),
        report(B, -400.0, 0.0, 0.0, starboard=other),
    )


@dataclass(frozen=True)
class Meeting:
    """Two ships on a chart."""

    waters: Waters
    own: ShipReport
    other: ShipReport

    def facts(self, memory: Encounter = NO_ENCOUNTER) -> PairFacts:
        """Facts as the own ship sees them."""
        return assess(VOCABULARY, self.waters, self.own, self.other, memory)

    def situation(self, memory: Encounter | None = None) -> Situation:
        """World of the two ships, and what they remember."""
        reports = {each.id: each for each in (self.own, self.other)}
        world = World(time=0.0, waters=self.waters, reports=reports)
        pair = (min(reports), max(reports))
        return Situation(world=world, encounters={} if memory is None else {pair: memory})

    def swapped(self) -> Meeting:
        """See it from the other ship."""
        return Meeting(self.waters, self.other, self.own)

    def later(self, seconds: float, *, own_course: float | None = None) -> Meeting:
        """Let both go straight on; then turn the own ship to a course [deg]."""
        own, other = (_sailed(each, seconds) for each in (self.own, self.other))
        if own_course is not None:
            own = replace(own, pose=replace(own.pose, course=own_course * DEGREE))
        return Meeting(self.waters, own, other)

    def moved(self, north: float, east: float, turn: float) -> Meeting:
        """Move the world, after turning it about the origin by so much [rad] clockwise."""
        cos, sin = math.cos(turn), math.sin(turn)
        shift, rotation = np.array([north, east]), np.array([[cos, sin], [-sin, cos]])
        return self._mapped(lambda points: points @ rotation + shift, lambda course: wrap(course + turn))

    def mirrored_world(self) -> Meeting:
        """Swap east and west."""
        return self._mapped(lambda points: points * np.array([1.0, -1.0]), lambda course: -course)

    def _mapped(self, place: Place, course: Course) -> Meeting:
        waterways = tuple(replace(each, centreline=place(each.centreline)) for each in self.waters.waterways)

        def mapped(each: ShipReport) -> ShipReport:
            north, east = place(np.array([[each.pose.x, each.pose.y]]))[0].tolist()
            return replace(each, pose=NedPose(north, east, course(each.pose.course)))

        return Meeting(replace(self.waters, waterways=waterways), mapped(self.own), mapped(self.other))


def _sailed(each: ShipReport, seconds: float) -> ShipReport:
    way, pose = each.speed * seconds, each.pose
    north, east = pose.x + way * math.cos(pose.course), pose.y + way * math.sin(pose.course)
    return replace(each, pose=NedPose(north, east, pose.course))


def random_encounter(generator: np.random.Generator, *, flags: bool = True) -> Meeting:
    """Put two ships near the crossing of two waterways; one in ten lies still.

    With `flags` the ships state whether they follow the starboard side.
    """
    chart = _CHARTS[int(generator.integers(len(_CHARTS)))]
    ships = []
    for id_ in (A, B):
        waterway = chart.waterways[int(generator.integers(2))]
        towards = Towards.END if generator.random() < 0.5 else Towards.START
        frame = waterway.frame(towards)
        line: FloatArray = frame.vertices[-1] - frame.vertices[0]
        ahead = line / np.hypot(*line)
        along, aside = generator.uniform(-2000.0, 2000.0), generator.uniform(-75.0, 75.0)
        place = along * ahead + aside * np.array([-ahead[1], ahead[0]])
        course = math.degrees(math.atan2(ahead[1], ahead[0])) + generator.normal(0.0, 8.0)
        ships.append(
            report(
                id_,
                float(place[0]),
                float(place[1]),
                float(course),
                speed=0.0 if generator.random() < 0.1 else float(generator.uniform(0.5, 6.0)),
                waterway=waterway.id,
                towards=towards,
                starboard=bool(generator.random() < 0.5) if flags else None,
            )
        )
    return Meeting(chart, *ships)


_CHARTS = tuple(waters(angle) for angle in (30.0, 50.0, 70.0, 90.0, 110.0, 130.0, 150.0))


Placed: TypeAlias = tuple[float, float, float, float]  # north, east [m], course [deg], speed [m/s]


def stated(
    own: Mapping[str, Any] | None = None,
    other: Mapping[str, Any] | None = None,
    *,
    waterway: Mapping[str, Any] | None = None,
    encounter: Mapping[str, Any] | None = None,
    at: tuple[Placed, Placed] | None = None,
    vocabulary: Vocabulary = VOCABULARY,
) -> PairFacts:
    """Facts of ships a and b, as a file states them; of the encounter, ships by their ids."""
    ships = tuple(
        CaseShip(
            id=id_,
            facts=facts or {},
            pose=None if place is None else (place[0], place[1], place[2] * DEGREE),
            speed=None if place is None else place[3],
        )
        for id_, facts, place in zip((A, B), (own, other), at or (None, None), strict=True)
    )
    case = Case(id="case", ships=ships, waterway=waterway or {}, encounter=encounter or {})
    return pair_facts(case, A, B, vocabulary)
