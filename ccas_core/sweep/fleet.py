"""Ships and waterways drawn from a seed: hulls of mixed lengths, speeds, and the facts that rules ask for.

Facts follow the vocabulary that rulesets share; what a position says of a ship
(`follows_starboard_side`, `direction`) is stated as the chart has it, so that every ruleset reads the same.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..frames import NedPose, PathPose
from ..ships import FactValue, Hull, Ship, ShipId
from ..sim.scenario import Plan
from ..tapd.facts import KEEPS_STARBOARD
from ..waterway import Leg, Towards, Waters, Waterway, guiding_line

LENGTHS: Final = ((12.0, 19.0), (25.0, 80.0), (80.0, 135.0))  # small craft, medium and large ships [m]
SHARES: Final = (0.2, 0.4, 0.4)  # of the three classes
SPEEDS: Final = (2.0, 5.0)  # [m/s]
SLENDERNESS: Final = 9.0  # length over beam
BEAMS: Final = (3.5, 11.4)  # least and greatest beam [m]
SAIL_SHARE: Final = 0.1  # of small craft under sail or oars


def draw_hull(rng: np.random.Generator) -> Hull:
    """Draw a hull; small craft are shorter than 20 m, as most regulations have it."""
    low, high = LENGTHS[int(rng.choice(len(LENGTHS), p=SHARES))]
    length = round(float(rng.uniform(low, high)), 1)
    return Hull(length=length, beam=round(min(max(length / SLENDERNESS, BEAMS[0]), BEAMS[1]), 1))


def displacement(hull: Hull) -> float:
    """Displacement of a hull of usual proportions [kg]: block coefficient 0.8, draught a quarter of the beam.

    >>> displacement(Hull(length=100.0, beam=10.0))
    2000000.0
    """
    return round(1000.0 * 0.8 * hull.length * hull.beam * hull.beam / 4.0, -3)


def draw_propulsion(rng: np.random.Generator, hull: Hull) -> str:
    """Draw what drives a ship; only small craft sail or row."""
    if hull.length < LENGTHS[0][1] and rng.random() < SAIL_SHARE:
        return str(rng.choice(["sail", "muscle"]))
    return "motor"


def draw_upstream(rng: np.random.Generator) -> Towards:
    """Draw which end of a waterway lies upstream, if any: two rivers to a canal."""
    return (Towards.NONE, Towards.START, Towards.END)[int(rng.integers(3))]


def straight(
    id_: str, course: float, reach: tuple[float, float], width: float, upstream: Towards
) -> Waterway:
    """Make a straight waterway through the origin on a course [rad], from `reach[0]` to `reach[1]` [m]."""
    along = np.array([math.cos(course), math.sin(course)])
    return Waterway(id=id_, centreline=np.outer(reach, along), width=width, upstream=upstream)


def direction(waterway: Waterway, towards: Towards) -> str:
    """Whether a ship sails upbound or downbound; `none` where upstream is not defined."""
    if waterway.upstream is Towards.NONE:
        return "none"
    return "upbound" if waterway.upstream is towards else "downbound"


def place(waters: Waters, ship: Ship, leg: Leg, x: float, speed: float) -> Plan:
    """Put a ship on its line, `x` [m] before (negative) or past the point beside the origin.

    Its facts are completed by what the chart says of it.
    """
    waterway = waters.waterway(leg.waterway)
    line = guiding_line(waters, [leg]).frame
    origin = line.to_path(NedPose(0.0, 0.0, 0.0)).x
    facts: dict[str, FactValue] = {
        **ship.facts,
        "follows_starboard_side": leg.offset >= KEEPS_STARBOARD,
        "direction": direction(waterway, leg.towards),
    }
    start = line.to_ned(PathPose(origin + x, 0.0, 0.0))
    return Plan(
        ship=Ship(id=ship.id, hull=ship.hull, mass=ship.mass, facts=facts),
        route=(leg,),
        start=start,
        speed=speed,
    )


def draw_ship(rng: np.random.Generator, number: int) -> Ship:
    """Draw a ship: hull, displacement, propulsion."""
    hull = draw_hull(rng)
    facts: dict[str, FactValue] = {"propulsion": draw_propulsion(rng, hull)}
    return Ship(id=ShipId(f"ship_{number}"), hull=hull, mass=displacement(hull), facts=facts)


def room_needed(one: Hull, other: Hull) -> float:
    """Lateral distance of two centres at which neither hull meets the other's safety area [m].

    >>> room_needed(Hull(length=100.0, beam=10.0), Hull(length=100.0, beam=10.0))
    12.5
    """
    return max(one.beam + other.safety_beam, one.safety_beam + other.beam) / 2.0
