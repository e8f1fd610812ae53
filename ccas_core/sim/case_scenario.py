"""Ships of a case as a scenario: each sails straight on, on a waterway through where it is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from ..frames import FloatArray, NedPose
from ..regions import Region
from ..ships import UNKNOWN, FactValue, Hull, Ship, ShipId
from ..tapd.case_run import crossing_time
from ..tapd.cases import Case, CaseShip
from ..tapd.facts import closest_approach, velocity
from ..tapd.vocabulary import VOCABULARY, Scope
from ..units import wrap
from ..waterway import Leg, Towards, Waters, Waterway
from .scenario import Plan, Scenario

NARROW: Final = 160.0  # least width of a waterway [m]
WATER_BESIDE: Final = 60.0  # that a ship finds to each side at least [m]
ASTERN: Final = 300.0  # a waterway begins so far behind its ships [m]
AHEAD: Final = 500.0  # and goes on so far, after the ships have met [m]
AFTERWARDS: Final = 300.0  # time that ships sail on after they have met [s]
LATEST: Final = 1800.0  # later meetings are not waited for [s]
FARTHEST: Final = 20_000.0  # crossings of waterways that lie farther off are left out [m]
_PARALLEL: Final = math.radians(22.5)  # courses this near to parallel or opposite share a waterway
_IN_KEYS: Final = ("length", "beam", "weight")  # facts that a scenario states as keys of their own


USUAL_LENGTH: Final = 80.0  # of a ship that does not state it [m]


@dataclass(frozen=True, slots=True)
class _Lane:
    """Ships that share a waterway, and its direction."""

    ships: tuple[CaseShip, ...]
    course: float  # [rad]

    @property
    def ahead(self) -> FloatArray:
        return np.array([math.cos(self.course), math.sin(self.course)])

    def along(self, point: Sequence[float]) -> float:
        return float(self.ahead @ np.asarray(point[:2]))

    def beside(self, point: Sequence[float]) -> float:
        return float(-self.ahead[1] * point[0] + self.ahead[0] * point[1])


def scenario_of(case: Case, rulesets: str | Mapping[ShipId, str], description: str = "") -> Scenario:
    """Lay waterways through the ships, one along the courses of those that are nearly parallel or opposite.

    `rulesets` is the id of the ruleset by which all ships judge, or of that of each; where there are two, a
    border lies half-way between the ships, and each has its own ruleset aboard and no other, for else they
    would agree on one.

    Raises
    ------
    ValueError
        If a ship has no place or no speed, for such ships cannot sail.
    """
    if len(case.ships) < 2 or any(ship.pose is None or not ship.speed for ship in case.ships):
        raise ValueError(f"case {case.id!r} is not about ships that are all under way")
    lanes = _lanes(case)
    waterways = [_waterway(f"waterway_{n}", lane, lanes, case) for n, lane in enumerate(lanes, start=1)]
    of = {ship.id: n for n, lane in enumerate(lanes) for ship in lane.ships}
    first = case.ships[0].id
    main = rulesets if isinstance(rulesets, str) else rulesets.get(first, next(iter(rulesets.values())))
    regions = () if isinstance(rulesets, str) else tuple(_regions(case, rulesets, main))

    def carried(ship: ShipId) -> tuple[str, ...]:
        return (rulesets.get(ship, main),) if regions and not isinstance(rulesets, str) else ()

    return Scenario(
        name=case.id,
        title=case.title,
        description=description,
        waters=Waters(ruleset=main, waterways=tuple(waterways), regions=regions),
        ships=tuple(
            replace(_plan(ship, waterways[of[ship.id]], lanes[of[ship.id]], case), rulesets=carried(ship.id))
            for ship in case.ships
        ),
    )


def beam_of(length: float) -> float:
    """Breadth of a ship that does not state it [m].

    >>> beam_of(80.0), beam_of(5.0)
    (10.0, 2.0)
    """
    return max(2.0, round(length / 8.0, 1))


def _lanes(case: Case) -> list[_Lane]:
    """Groups of ships on nearly parallel or opposite courses that lie between the same banks."""
    apart = case.encounter.get("same_waterway") is False
    groups: list[list[CaseShip]] = []
    for ship in case.ships:
        near = (
            group for group in groups if not apart and all(_angle(ship, each) < _PARALLEL for each in group)
        )
        group = next(near, None)
        if group is None:
            groups.append([ship])
        else:
            group.append(ship)
    return [_Lane(tuple(group), _axis([_pose(ship)[2] for ship in group])) for group in groups]


def _angle(one: CaseShip, other: CaseShip) -> float:
    """Angle between the lines that two ships sail on, 0 to 90 deg [rad]."""
    turn = abs(wrap(_pose(other)[2] - _pose(one)[2]))
    return min(turn, math.pi - turn)


def _axis(courses: Sequence[float]) -> float:
    """Direction in the middle of lines, of which the first gives the sense."""
    turns = [wrap(2.0 * (each - courses[0])) / 2.0 for each in courses]
    return wrap(courses[0] + (min(turns) + max(turns)) / 2.0)


def _waterway(id_: str, lane: _Lane, lanes: Sequence[_Lane], case: Case) -> Waterway:
    beside = [lane.beside(_pose(ship)) for ship in lane.ships]
    middle = (min(beside) + max(beside)) / 2.0
    width = max(NARROW, max(beside) - min(beside) + 2.0 * WATER_BESIDE)
    if case.encounter.get("same_waterway") is False:
        width = _narrow(lane, case)
    ends = [reach for ship in lane.ships for reach in _reach(lane, ship, case)]
    ends += [where for other in lanes if other is not lane for where in _crossings(lane, other)]
    foot = np.array([-lane.ahead[1], lane.ahead[0]]) * middle
    line = np.round([foot + (min(ends) - 50.0) * lane.ahead, foot + (max(ends) + 50.0) * lane.ahead], 3) + 0.0
    facts = {"upstream_defined": True, **case.waterway}
    stated = facts.pop("width", UNKNOWN)
    width = width if stated is UNKNOWN else float(stated)
    facts.pop("name", None)
    return Waterway(id=id_, centreline=line, width=width, facts=facts)


def _narrow(lane: _Lane, case: Case) -> float:
    """Width that leaves out a ship of another waterway."""
    here = lane.beside(_pose(lane.ships[0]))
    others = [abs(lane.beside(_pose(each)) - here) for each in case.ships if each not in lane.ships]
    return max(20.0, min(NARROW, 1.6 * min(others, default=NARROW)))


def _reach(lane: _Lane, ship: CaseShip, case: Case) -> tuple[float, float]:
    """Where on its waterway a ship comes from, and where it goes until all has been seen."""
    here = lane.along(_pose(ship))
    sense = 1.0 if math.cos(_pose(ship)[2] - lane.course) > 0.0 else -1.0
    until = max((_meeting_time(ship, each) for each in case.ships if each is not ship), default=0.0)
    way = AHEAD + (ship.speed or 0.0) * (min(max(until, 0.0), LATEST) + AFTERWARDS)
    return here - sense * ASTERN, here + sense * way


def _meeting_time(one: CaseShip, other: CaseShip) -> float:
    a, b = _pose(one), _pose(other)
    va, vb = velocity(a[2], one.speed or 0.0), velocity(b[2], other.speed or 0.0)
    time, _ = closest_approach(b[0] - a[0], b[1] - a[1], vb[0] - va[0], vb[1] - va[1])
    return time if math.isfinite(time) else 0.0


def _crossings(lane: _Lane, other: _Lane) -> list[float]:
    """Where the lines that other ships sail on cross a waterway, along it."""
    found = []
    for ship in lane.ships:
        for each in other.ships:
            pose, speed = _pose(ship), 1.0
            time = crossing_time((pose[0], pose[1], lane.course), speed, _pose(each))
            if abs(time) < FARTHEST:
                found.append(lane.along(pose) + time)
    return found


def _regions(case: Case, rulesets: Mapping[ShipId, str], main: str) -> list[Region]:
    """Waters of ships that judge by another ruleset: all that is nearer to them than to the first ship."""
    found = []
    first = np.array(_pose(case.ships[0])[:2])
    for ship in case.ships[1:]:
        ruleset = rulesets.get(ship.id, main)
        here = np.array(_pose(ship)[:2])
        if ruleset == main or not np.any(here != first):
            continue
        away = (here - first) / np.hypot(*(here - first))
        across = np.array([-away[1], away[0]]) * FARTHEST
        middle, far = (here + first) / 2.0, here + FARTHEST * away
        corners = np.round([middle - across, middle + across, far + across, far - across], 3) + 0.0
        found.append(Region(id=f"waters_of_{ship.id}", ruleset=ruleset, polygon=corners))
    return found


def _plan(ship: CaseShip, waterway: Waterway, lane: _Lane, case: Case) -> Plan:
    pose = NedPose(*_pose(ship))
    towards = Towards.END if math.cos(pose.course - lane.course) > 0.0 else Towards.START
    offset = round(waterway.frame(towards).to_path(pose).y, 2) + 0.0
    length = _number(ship, "length", USUAL_LENGTH)
    beam = _number(ship, "beam", beam_of(length))
    mass = _number(ship, "weight", round(1.5 * length * beam) * 1000.0)
    return Plan(
        ship=Ship(id=ship.id, hull=Hull(length=length, beam=beam), mass=mass, facts=_stated(ship, case)),
        route=(Leg(waterway.id, towards, offset),),
        start=pose,
        speed=ship.speed or 0.0,
    )


def _number(ship: CaseShip, name: str, usual: float) -> float:
    value = ship.facts.get(name, UNKNOWN)
    return usual if value is UNKNOWN else float(value)


def _stated(ship: CaseShip, case: Case) -> dict[str, FactValue]:
    """Facts that a ship states: its own, and those that a chart would otherwise compute."""
    computed = (fact for fact in VOCABULARY.by_scope[Scope.SHIP] if fact.computed)
    usual = {fact.name: fact.default for fact in computed if fact.default is not UNKNOWN}
    facts: dict[str, Any] = {**usual, **ship.facts}
    windward = case.encounter.get("windward")
    if windward is not None:
        facts["windward"] = windward == ship.id
    return {name: value for name, value in facts.items() if name not in _IN_KEYS}


def _pose(ship: CaseShip) -> tuple[float, float, float]:
    if ship.pose is None:
        raise ValueError(f"ship {ship.id!r} has no place")
    return ship.pose
