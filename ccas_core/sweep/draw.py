"""Two-ship encounters drawn from a seed: head-on, crossing, overtaking; risky or calm as in `sim.conduct`.

An encounter is drawn until the undisturbed hulls come as near as wanted.  The waterway leaves room:
on either side of each ship the other can pass, within its greatest offset.  Half of the crossings lie at the
mouth of a side water: the ship on the narrower waterway comes out, the other is on the main one, and sign
B.9 stands there, by which regulations rank two large ships that no other rule of theirs does.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from enum import StrEnum
from typing import Final

import numpy as np

from ..ships import FactValue, Ship
from ..sim.conduct import CALM_BEYOND, RISKY_WITHIN
from ..sim.hulls import Meeting, meeting
from ..sim.scenario import ControlChoice, Plan, Scenario
from ..sim.undisturbed import undisturbed
from ..units import DEGREE
from ..waterway import BANK_MARGIN, Leg, Towards, Waters, Waterway, guiding_line
from .fleet import SPEEDS, draw_ship, draw_upstream, place, room_needed, straight

TIMES: Final = (240.0, 840.0)  # to the conflict [s]
WIDTHS: Final = (140.0, 260.0)  # of a waterway [m]
ANGLES: Final = (35.0 * DEGREE, 145.0 * DEGREE)  # between the courses of a crossing [rad]
OVERTAKING_TIMES: Final = (240.0, 600.0)  # to the conflict [s]
LEAD: Final = 0.8  # an overtaking ship is at least this much faster [m/s]
SLACK: Final = 15.0  # water beside a passing ship, besides what safety areas take [m]
RUN_OUT: Final = 400.0  # a route goes on for so long after the conflict [s]
MOUTHS: Final = 0.5  # share of crossings at the mouth of a side water, under sign B.9
ATTEMPTS: Final = 1000


class Risk(StrEnum):
    """How near the undisturbed hulls come."""

    RISKY = "risky"
    CALM = "calm"


class Kind(StrEnum):
    """Encounters of two ships."""

    HEAD_ON = "head_on"
    CROSSING = "crossing"
    OVERTAKING = "overtaking"


def draw_encounter(rng: np.random.Generator, kind: Kind, risk: Risk, ruleset: str) -> Scenario:
    """Draw an encounter of two ships; the same generator state gives the same encounter.

    Examples
    --------
    >>> scenario = draw_encounter(np.random.default_rng(1), Kind.CROSSING, Risk.RISKY, "tran2026")
    >>> undisturbed_meeting(scenario).clearance <= RISKY_WITHIN
    True
    """
    for _ in range(ATTEMPTS):
        scenario = _DRAWN[kind](rng, risk, ruleset)
        met = undisturbed_meeting(scenario)
        wanted = met.clearance <= RISKY_WITHIN if risk is Risk.RISKY else met.clearance > CALM_BEYOND
        if wanted and met.time > TIMES[0] / 2.0:
            return scenario
    raise RuntimeError(f"no {risk} {kind} encounter in {ATTEMPTS} attempts: a fault of the generator")


def undisturbed_meeting(scenario: Scenario) -> Meeting:
    """How near two ships would come if both sailed on beside their lines."""
    one, other = (
        undisturbed(plan, plan.start, 0.0, guiding_line(scenario.waters, plan.route).frame)
        for plan in scenario.ships
    )
    met = meeting(one, other)
    if met is None:
        raise ValueError("the two ships are never under way together")
    return met


def scenario_of(name: str, waters: Waters, plans: tuple[Plan, ...]) -> Scenario:
    """Make a scenario with the default control settings."""
    return Scenario(name=name, waters=waters, ships=plans, control=ControlChoice())


def _uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(rng.uniform(low, max(low, high)))


def _side_by_side(rng: np.random.Generator, bound: float, apart: float, risk: Risk) -> tuple[float, float]:
    """Lateral positions of two lines in one frame [m]: less than `apart` from one another, or calm."""
    if risk is Risk.RISKY:
        one = _uniform(rng, -bound, bound)
        return one, _uniform(rng, max(-bound, one - apart), min(bound, one + apart))
    gap = apart + CALM_BEYOND - RISKY_WITHIN + 1.0
    one = _uniform(rng, gap / 2.0, max(gap / 2.0, bound + gap / 4.0))
    other = one - _uniform(rng, gap, gap + 20.0)
    return (one, other) if rng.random() < 0.5 else (-one, -other)


def _head_on(rng: np.random.Generator, risk: Risk, ruleset: str) -> Scenario:
    one, other = draw_ship(rng, 1), draw_ship(rng, 2)
    speeds = _uniform(rng, *SPEEDS), _uniform(rng, *SPEEDS)
    time, width = _uniform(rng, *TIMES), _uniform(rng, *WIDTHS)
    apart = (one.hull.beam + other.hull.beam) / 2.0 + RISKY_WITHIN
    bound = _bound(width, one.hull.beam, other.hull.beam, room_needed(one.hull, other.hull))
    mine, theirs = _side_by_side(rng, bound, apart, risk)
    reach = max(speeds) * (time + RUN_OUT)
    waterway = straight("reach", _course(rng), (-reach, reach), width, draw_upstream(rng))
    waters = Waters(ruleset=ruleset, waterways=(waterway,))
    plans = (
        place(waters, one, Leg("reach", Towards.END, mine), -speeds[0] * time, speeds[0]),
        place(waters, other, Leg("reach", Towards.START, -theirs), -speeds[1] * time, speeds[1]),
    )
    return scenario_of("head_on", waters, plans)


def _overtaking(rng: np.random.Generator, risk: Risk, ruleset: str) -> Scenario:
    one, other = draw_ship(rng, 1), draw_ship(rng, 2)
    slow = _uniform(rng, SPEEDS[0], SPEEDS[1] - 2.0 * LEAD)
    fast = _uniform(rng, slow + LEAD, SPEEDS[1])
    time, width = _uniform(rng, *OVERTAKING_TIMES), _uniform(rng, *WIDTHS)
    half = (one.hull.length + other.hull.length) / 2.0
    apart = (one.hull.beam + other.hull.beam) / 2.0 + RISKY_WITHIN
    bound = _bound(width, one.hull.beam, other.hull.beam, room_needed(one.hull, other.hull))
    mine, theirs = _side_by_side(rng, bound, apart, risk)
    passing = 2.0 * half / (fast - slow)  # from contact to past
    end = slow * (time + passing + RUN_OUT)
    begin = -fast * time - half - 200.0
    waterway = straight("reach", _course(rng), (begin, end), width, draw_upstream(rng))
    waters = Waters(ruleset=ruleset, waterways=(waterway,))
    plans = (
        place(waters, one, Leg("reach", Towards.END, mine), -fast * time - half, fast),
        place(waters, other, Leg("reach", Towards.END, theirs), -slow * time, slow),
    )
    return scenario_of("overtaking", waters, plans)


def _crossing(rng: np.random.Generator, risk: Risk, ruleset: str) -> Scenario:
    one, other = draw_ship(rng, 1), draw_ship(rng, 2)
    speeds = _uniform(rng, *SPEEDS), _uniform(rng, *SPEEDS)
    time = _uniform(rng, *TIMES)
    half = (one.hull.length + other.hull.length) / 2.0
    late = _uniform(rng, -1.0, 1.0) * (2.0 * half + 3.0 * CALM_BEYOND * (risk is Risk.CALM)) / min(speeds)
    times = (time, max(TIMES[0] / 2.0, time + late))
    angle, course = _uniform(rng, *ANGLES), _course(rng)
    courses = course, course + (angle if rng.random() < 0.5 else -angle)
    waterways, legs = [], []
    for ship, name, along, speed, arrival in zip(
        (one, other), ("canal", "river"), courses, speeds, times, strict=True
    ):
        width = _uniform(rng, *WIDTHS)
        towards = Towards.END if rng.random() < 0.5 else Towards.START
        ends = (-speed * arrival - 500.0, speed * (max(times) + RUN_OUT))
        turned = 0.0 if towards is Towards.END else math.pi
        reach = ends if towards is Towards.END else (-ends[1], -ends[0])
        waterways.append(straight(name, along + turned, reach, width, draw_upstream(rng)))
        lane = width / 2.0 - BANK_MARGIN - ship.hull.beam / 2.0 - SLACK
        legs.append(Leg(name, towards, _uniform(rng, -lane, lane)))
    ships = [one, other]
    if rng.random() < MOUTHS:
        ships, waterways = _at_mouth(ships, waterways)
    waters = Waters(ruleset=ruleset, waterways=tuple(waterways))
    shift = _lines_meet(legs, courses)
    plans = tuple(
        place(waters, ship, leg, along - speed * arrival, speed)
        for ship, leg, along, speed, arrival in zip(ships, legs, shift, speeds, times, strict=True)
    )
    return scenario_of("crossing", waters, plans)


def _at_mouth(ships: list[Ship], waterways: list[Waterway]) -> tuple[list[Ship], list[Waterway]]:
    """Let the wider waterway be the main one: sign B.9 stands there, and the ship on the other comes out."""
    main = max(range(len(ships)), key=lambda n: waterways[n].width)
    facts: list[dict[str, FactValue]] = [{"manoeuvre": "entering_main"} for _ in ships]
    facts[main] = {"on_main_fairway": True}
    signed = replace(waterways[main], facts={**waterways[main].facts, "sign_b9": True})
    return (
        [replace(ship, facts={**ship.facts, **more}) for ship, more in zip(ships, facts, strict=True)],
        [signed if n == main else each for n, each in enumerate(waterways)],
    )


def _lines_meet(legs: list[Leg], courses: tuple[float, float]) -> tuple[float, float]:
    """Distance along each line, from beside the origin, to where the two lines cross [m]."""
    ahead = [np.array([math.cos(c), math.sin(c)]) for c in courses]
    aside = [np.array([-math.sin(c), math.cos(c)]) for c in courses]
    gap = legs[1].offset * aside[1] - legs[0].offset * aside[0]
    found = np.linalg.solve(np.column_stack([ahead[0], -ahead[1]]), gap)
    return float(found[0]), float(found[1])


def _bound(width: float, beam: float, other_beam: float, needed: float) -> float:
    """Greatest distance of a line from the centreline that leaves room to pass on either side [m]."""
    return max(0.0, width / 2.0 - BANK_MARGIN - max(beam, other_beam) / 2.0 - needed - SLACK)


def _course(rng: np.random.Generator) -> float:
    return _uniform(rng, -math.pi, math.pi)


_DRAWN: Final[dict[Kind, Callable[[np.random.Generator, Risk, str], Scenario]]] = {
    Kind.HEAD_ON: _head_on,
    Kind.CROSSING: _crossing,
    Kind.OVERTAKING: _overtaking,
}
