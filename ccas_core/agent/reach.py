"""Who can come near whom within a horizon: only those need to hear one another.

A ship sails along its guiding line, never back, and no faster than its nominal speed U.  At step k it is
therefore beside the stretch of the line that begins where it is now and is k U dT long, and no farther
from it than `WIDTH`.  All these stretches lie within that of the whole horizon.  So two ships whose
stretches lie d + 2 `WIDTH` apart are never nearer to one another than d, at no step and whatever
they do; and `risk.cut_off` says for which d the risk of one to the other, over all steps, is
below `TOLERANCE`.  Ten thousand ships that are left out have less than 1e-6 together, what two
objectives may differ by and still tie.

The bound is on plans that can be sailed: the extrapolation of (13d), and a prediction of a ship that
has not yet told its plan, may lie outside.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..dmpc.parameters import Settings
from ..dmpc.risk import cut_off
from ..frames import FloatArray
from ..ships import Hull, ShipId
from ..waterway import OFFSET_LIMIT, GuidingLine

TOLERANCE: Final = 1e-10  # of the risk of one ship to another, summed over the horizon
ROLE_FACTOR: Final = 100.0  # by which K_ca may be greater towards a neighbour
FORESIGHT: Final = 900.0  # rulesets look so far ahead at least [s]
WIDTH: Final = OFFSET_LIMIT + 150.0  # from the guiding line: y_max, and U T_1 for the turn back [m]


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """Water that a ship may get to: points of its guiding line from where it is, (n, 2), in {n}."""

    points: FloatArray


def reach(line: GuidingLine, x: float, speed: float, seconds: float) -> Reach:
    """Stretch of a guiding line that a ship at distance x [m] can sail within `seconds`."""
    return Reach(line.frame.stretch(x, x + max(1.0, speed * seconds)))


def separation(profiles: Iterable[Settings], hulls: Collection[Hull]) -> float:
    """Distance [m] between two stretches beyond which no two of these ships concern one another."""
    greatest = Hull(
        length=max(max(hull.length, hull.safety_length) for hull in hulls),
        beam=max(max(hull.beam, hull.safety_beam) for hull in hulls),
    )
    bound = TOLERANCE / ROLE_FACTOR
    return 2.0 * WIDTH + max(cut_off(greatest, greatest, settings, bound) for settings in profiles)


def neighbours(reaches: Mapping[ShipId, Reach], apart: float) -> dict[ShipId, tuple[ShipId, ...]]:
    """Find for each ship those whose reach lies nearer than `apart` [m], by a spatial index."""
    import shapely

    if not reaches:
        return {}
    ships = sorted(reaches)
    points = [reaches[ship].points for ship in ships]
    owners = np.repeat(np.arange(len(ships)), [len(each) for each in points])
    lines = np.asarray(shapely.linestrings(np.vstack(points), indices=owners))
    one, other = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=apart)
    found: dict[ShipId, list[ShipId]] = {ship: [] for ship in ships}
    for a, b in zip(one.tolist(), other.tolist(), strict=True):
        if a != b:
            found[ships[a]].append(ships[b])
    return {ship: tuple(sorted(near)) for ship, near in found.items()}
