"""Safety domains along a voyage: where they lie, how near they come, and whether they overlap.

Domains are drawn as polygons in {n} and compared exactly, unlike on the line that joins two ships
(`domains.gap`): two domains may overlap beside that line.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import shapely

from ..frames import FloatArray
from ..ships import Ship, ShipId
from .frame import Frame, ShipFrame
from .hulls import under_way
from .scenario import Scenario


@dataclass(frozen=True, slots=True, kw_only=True)
class Nearness:
    """How near the domains of two ships, or of a ship and an obstacle, came in a voyage."""

    ships: tuple[str, str]
    least: float  # distance of the domains, 0 where they overlapped [m]
    overlap: float  # greatest area that they shared, over the smaller of the two


def outline(ship: Ship, pose: FloatArray, surge: float) -> FloatArray:
    """Corners of a ship's domain in {n}, (n, 2), at a pose (3,) and a surge speed [m/s]."""
    ahead, aside = ship.domain.outline(surge).T
    cos, sin = math.cos(float(pose[2])), math.sin(float(pose[2]))
    return np.column_stack([pose[0] + cos * ahead - sin * aside, pose[1] + sin * ahead + cos * aside])


def surge_of(ship: ShipFrame) -> float:
    """Speed through the water, where it is known; else over ground [m/s]."""
    return ship.speed if ship.motion is None else ship.motion.surge


def domains_at(scenario: Scenario, frame: Frame) -> dict[ShipId, FloatArray]:
    """Domains of all ships under way, by id, each (n, 2)."""
    ships = {plan.ship.id: plan.ship for plan in scenario.ships}
    return {id_: _outlined(ships[id_], ship) for id_, ship in under_way(frame).items()}


def nearnesses(scenario: Scenario, frames: Sequence[Frame]) -> tuple[Nearness, ...]:
    """How near domains came, of each pair of which one states a domain, and of each such ship and obstacle.

    Looked at in each frame.
    """
    stated = {plan.ship.id for plan in scenario.ships if plan.ship.stated_domain is not None}
    least: dict[tuple[str, str], float] = {}
    share: dict[tuple[str, str], float] = {}
    circles = {
        each.id: shapely.Point(each.x, each.y).buffer(each.radius) for each in scenario.waters.obstacles
    }
    for frame in frames if stated else ():
        drawn = {id_: shapely.Polygon(each) for id_, each in domains_at(scenario, frame).items()}
        for one, other, there in _pairs(drawn, circles, stated):
            pair, here = (str(one), str(other)), drawn[one]
            apart = float(here.distance(there))
            least[pair] = min(least.get(pair, math.inf), apart)
            shared = here.intersection(there).area / min(here.area, there.area) if apart == 0.0 else 0.0
            share[pair] = max(share.get(pair, 0.0), float(shared))
    return tuple(Nearness(ships=pair, least=least[pair], overlap=share[pair]) for pair in sorted(least))


def _pairs(
    drawn: dict[ShipId, shapely.Polygon], circles: dict[str, shapely.Polygon], stated: set[ShipId]
) -> Iterator[tuple[ShipId, str, shapely.Polygon]]:
    for one, other in combinations(sorted(drawn), 2):
        if {one, other} & stated:
            yield one, other, drawn[other]
    for one in sorted(stated & drawn.keys()):
        for id_, circle in circles.items():
            yield one, id_, circle


def _outlined(ship: Ship, now: ShipFrame) -> FloatArray:
    return outline(ship, np.array([now.pose.x, now.pose.y, now.pose.course]), surge_of(now))
