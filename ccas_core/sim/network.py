"""A made-up network of waterways with ships all over it, to see how far the program carries.

Rivers run north, canals east; they cross every few kilometres.  A waterway is cut after a few
crossings, and the cuts are staggered, so that everything hangs together and no chart is endless.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..frames import FloatArray, PathPose, frozen_array
from ..ships import Hull, Ship, ShipId
from ..waterway import Leg, Towards, Waters, Waterway, guiding_line
from .scenario import ControlChoice, Plan, Profile, Scenario

FEWEST: Final = 10  # ships of a network
SPACING: Final = (
    100_000.0 / 9.0
)  # between waterways of one direction, about: just so for 100 and 10,000 ships [m]
CROSSINGS: Final = 3  # of one waterway, at most
MEANDER: Final = 150.0  # of a river, to either side [m]
VERTEX: Final = 1_250.0  # between vertices of a river [m]
CLEAR: Final = 500.0  # of a crossing, and of the ends of a waterway, no ship starts nearer [m]
APART: Final = 400.0  # ships of one lane at the start, at least [m]
TURNS: Final = 0.25  # share of the ships that turn off at the next crossing


@dataclass(frozen=True, slots=True)
class _Kind:
    """Vessels of one class (CEMT): length, beam [m], mass [kg], greatest speed [m/s]."""

    length: float
    beam: float
    mass: float
    speed: float


_KINDS: Final = (
    _Kind(55.0, 7.2, 6e5, 3.2),
    _Kind(80.0, 9.5, 1.5e6, 3.6),
    _Kind(110.0, 11.4, 3e6, 4.2),
)


@dataclass(frozen=True, slots=True, eq=False)
class _Reach:
    """A waterway, and the distances along it at which others cross."""

    waterway: Waterway
    crossings: tuple[tuple[float, str], ...]  # distance from the start [m], id of the other


def network(ships: int, seed: int = 0, density: float = 0.5, profile: Profile = Profile.CROSSING) -> Scenario:
    """Lay out waterways, and put ships on them.

    Parameters
    ----------
    ships
        How many.
    seed
        Of all that is drawn by lot.
    density
        Ships a kilometre of waterway.  The European network has some ten thousand vessels on
        some thirty thousand kilometres, and a few on each kilometre where it is busiest.
    profile
        Of all ships: the paper's for junctions, or `AUTO`, by which ships also weigh their roles.
    """
    if ships < FEWEST or not density > 0.0:
        raise ValueError(
            f"a network has {FEWEST} ships or more, and a density above zero, got {ships}, {density:g}"
        )
    generator = np.random.default_rng([seed, ships])
    lines = max(1, round(math.sqrt(ships / density * 1000.0 / (2.0 * SPACING))))
    spacing = ships / density * 1000.0 / (2.0 * lines**2)
    reaches = _reaches(lines, spacing)
    waters = Waters(ruleset="tran2026", waterways=tuple(reach.waterway for reach in reaches.values()))
    plans: list[Plan] = []
    names = sorted(reaches)
    lanes = [(name, towards) for name in names for towards in (Towards.START, Towards.END)]
    lengths = np.array([reaches[name].waterway.frame(Towards.END).length for name, _ in lanes])
    for (name, towards), count in zip(lanes, _shared_out(ships, lengths), strict=True):
        plans += _lane(waters, reaches, name, towards, count, len(plans), generator)
    return Scenario(
        name=f"network of {ships} ships",
        waters=waters,
        ships=tuple(plans),
        control=ControlChoice(profile=profile),
    )


def _reaches(lines: int, spacing: float) -> dict[str, _Reach]:
    """All waterways: `lines` rivers and `lines` canals, cut into pieces."""
    found = {}
    pieces = {
        (way, line): _pieces(lines, (line * 2 + way) % CROSSINGS) for way in (0, 1) for line in range(lines)
    }
    homes = {
        (way, line, cross): f"{'river' if way == 0 else 'canal'}_{line}_{number}"
        for (way, line), parts in pieces.items()
        for number, part in enumerate(parts)
        for cross in part
    }
    for (way, line), parts in pieces.items():
        for part in parts:
            name = homes[way, line, part[0]]
            first, last = (part[0] - 0.5) * spacing, (part[-1] + 0.5) * spacing
            centreline = (
                _river(line * spacing, first, last) if way == 0 else _canal(line * spacing, first, last)
            )
            crossings = tuple((cross * spacing - first, homes[1 - way, cross, line]) for cross in part)
            found[name] = _Reach(
                Waterway(
                    id=name,
                    centreline=centreline,
                    width=200.0 if way == 0 else 100.0,
                    upstream=Towards.END if way == 0 else Towards.NONE,
                ),
                crossings,
            )
    return found


def _pieces(lines: int, first: int) -> list[list[int]]:
    """Cut a line after `first` crossings, then after every `CROSSINGS`."""
    cuts = [*range(first or CROSSINGS, lines, CROSSINGS)]
    return [list(range(a, b)) for a, b in zip([0, *cuts], [*cuts, lines], strict=True)]


def _river(east: float, first: float, last: float) -> FloatArray:
    """Centreline (n, 2) of a river that winds about a line to the north, a whole wave between canals."""
    north = np.linspace(first, last, max(2, round((last - first) / VERTEX) + 1))
    return frozen_array(np.column_stack([north, east + MEANDER * np.sin(2.0 * math.pi * north / SPACING)]))


def _canal(north: float, first: float, last: float) -> FloatArray:
    return frozen_array([[north, first], [north, last]])


def _shared_out(ships: int, lengths: FloatArray) -> list[int]:
    """Share ships out over lanes by their lengths, without a remainder."""
    ends = np.round(np.cumsum(lengths) / np.sum(lengths) * ships).astype(int)
    return [int(count) for count in np.diff(ends, prepend=0)]


def _lane(
    waters: Waters,
    reaches: dict[str, _Reach],
    name: str,
    towards: Towards,
    count: int,
    known: int,
    generator: np.random.Generator,
) -> list[Plan]:
    """Ships of one waterway and direction: clear of crossings, apart from one another."""
    reach = reaches[name]
    length = reach.waterway.frame(towards).length
    crossings = sorted(
        (at if towards is Towards.END else length - at, other) for at, other in reach.crossings
    )
    places = _places(length, [at for at, _ in crossings], count, generator)
    plans = []
    for number, x in enumerate(places, start=known):
        kind = _KINDS[int(generator.integers(len(_KINDS)))]
        offset = 0.2 * reach.waterway.width
        legs = [Leg(name, towards, offset)]
        ahead = [other for at, other in crossings if at > x + CLEAR]
        if ahead and generator.random() < TURNS:
            other = reaches[ahead[0]].waterway
            side = Towards.START if generator.random() < 0.5 else Towards.END
            legs.append(Leg(other.id, side, 0.2 * other.width))
        line = guiding_line(waters, legs)
        plans.append(
            Plan(
                ship=Ship(
                    id=ShipId(f"ship_{number:05d}"),
                    hull=Hull(length=kind.length, beam=kind.beam),
                    mass=kind.mass,
                ),
                route=tuple(legs),
                start=line.frame.to_ned(PathPose(float(x), 0.0, 0.0)),
                speed=kind.speed * float(generator.uniform(0.7, 1.0)),
            )
        )
    return plans


def _places(length: float, crossings: list[float], count: int, generator: np.random.Generator) -> FloatArray:
    """Distances along a lane at which ships start, sorted [m]."""
    edges = [CLEAR, *(at + side * CLEAR for at in crossings for side in (-1.0, 1.0)), length - CLEAR]
    first, last = np.array(edges[0::2]), np.array(edges[1::2])
    room = last - first
    free = float(np.sum(room)) - APART * (count - 1)
    if free <= 0.0:
        raise ValueError(f"{count} ships do not fit on {length:.0f} m of water")
    along = np.sort(generator.uniform(0.0, free, count)) + APART * np.arange(count)
    before = np.concatenate([[0.0], np.cumsum(room)])
    stretch = np.clip(np.searchsorted(before, along, side="right") - 1, 0, len(room) - 1)
    places: FloatArray = first[stretch] + along - before[stretch]
    return places
