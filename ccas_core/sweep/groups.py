"""Groups of ships drawn from a seed: at junctions of two or three waterways, and along reaches.

Ships begin apart from one another, and would come together at about the same time.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..sim.hulls import Track, clearances
from ..sim.scenario import Plan, Scenario
from ..sim.undisturbed import undisturbed
from ..units import DEGREE
from ..waterway import BANK_MARGIN, Leg, Towards, Waters, Waterway, guiding_line
from .draw import ATTEMPTS, RUN_OUT, SLACK, scenario_of
from .fleet import draw_ship, draw_upstream, place, straight

TIMES: Final = (300.0, 720.0)  # to the junction, or to the middle of the reach [s]
SPREAD: Final = 120.0  # ships of a group come there within so long of one another [s]
SPEEDS: Final = (2.5, 4.0)  # [m/s]
WIDTHS: Final = (160.0, 260.0)  # of a waterway [m]
STARBOARD_SHARE: Final = 0.8  # of ships that follow the starboard side
APART: Final = 150.0  # least clearance at the beginning [m]


def draw_junction(rng: np.random.Generator, ships: tuple[int, int], ruleset: str) -> Scenario:
    """Draw a group that meets where two or three waterways cross."""
    ways = int(rng.integers(2, 4))
    turn = float(rng.uniform(0.0, math.pi))
    between = math.pi / ways
    courses = [turn + n * between + float(rng.uniform(-15.0, 15.0)) * DEGREE for n in range(ways)]
    return _group(rng, "junction", courses, ships, ruleset)


def draw_reach(rng: np.random.Generator, ships: tuple[int, int], ruleset: str) -> Scenario:
    """Draw a group along one reach: they meet and overtake one another."""
    return _group(rng, "reach", [float(rng.uniform(0.0, math.pi))], ships, ruleset)


def _group(
    rng: np.random.Generator, name: str, courses: list[float], ships: tuple[int, int], ruleset: str
) -> Scenario:
    count = int(rng.integers(ships[0], ships[1] + 1))
    time = float(rng.uniform(*TIMES))
    half = SPEEDS[1] * (time + SPREAD + RUN_OUT)
    waterways = tuple(
        straight(f"{name}_{n + 1}", course, (-half, half), float(rng.uniform(*WIDTHS)), draw_upstream(rng))
        for n, course in enumerate(courses)
    )
    waters = Waters(ruleset=ruleset, waterways=waterways)
    plans: list[Plan] = []
    for number in range(1, count + 1):
        for _ in range(ATTEMPTS):
            plan = _draw_plan(rng, waters, waterways, number, time)
            if all(_apart(waters, plan, other) for other in plans):
                plans.append(plan)
                break
    return scenario_of(name, waters, tuple(plans))


def _draw_plan(
    rng: np.random.Generator, waters: Waters, waterways: tuple[Waterway, ...], number: int, time: float
) -> Plan:
    ship = draw_ship(rng, number)
    waterway = waterways[int(rng.integers(len(waterways)))]
    towards = Towards.END if rng.random() < 0.5 else Towards.START
    most = waterway.width / 2.0 - BANK_MARGIN - ship.hull.beam / 2.0 - SLACK
    offset = float(rng.uniform(min(15.0, most), most))
    offset = offset if rng.random() < STARBOARD_SHARE else -offset
    speed = float(rng.uniform(*SPEEDS))
    arrival = time + float(rng.uniform(-SPREAD, SPREAD))
    return place(waters, ship, Leg(waterway.id, towards, offset), -speed * arrival, speed)


def _apart(waters: Waters, one: Plan, other: Plan) -> bool:
    def begin(plan: Plan) -> Track:
        return undisturbed(plan, plan.start, 0.0, guiding_line(waters, plan.route).frame)

    return float(clearances(begin(one), begin(other), np.zeros(1))[0]) >= APART
