"""Memory of an encounter: what was true when it began holds until the ships are past and clear.

Overtaking lasts until the overtaker is past and clear (COLREG 13(d), BPR 6.09); the starboard side is
that of the first verdict.  Both ships remember the same, for they remember the same messages.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from ..roles import Geometry
from ..ships import FactValue, ShipId

if TYPE_CHECKING:
    from .facts import PairFacts

_OPENING_PERIODS = 2  # periods of growing range after which ships are past and clear


@dataclass(frozen=True, slots=True, kw_only=True)
class Encounter:
    """What two ships remember of their encounter; `geometry` is none where there is none."""

    geometry: Geometry = Geometry.NONE
    overtaker: ShipId | None = None
    starboard_sides: Mapping[ShipId, FactValue] = field(default_factory=dict)
    crosses_from: Mapping[ShipId, float] = field(default_factory=dict)  # `courses_cross_from` of each ship
    distance: float = math.inf  # when it was last looked at [m]
    opening_periods: int = 0  # for how many periods the range has grown

    def __post_init__(self) -> None:
        object.__setattr__(self, "starboard_sides", MappingProxyType(dict(self.starboard_sides)))
        object.__setattr__(self, "crosses_from", MappingProxyType(dict(self.crosses_from)))


NO_ENCOUNTER = Encounter()


def remember(facts: PairFacts, geometry: Geometry, overtaker: ShipId | None) -> Encounter:
    """Carry an encounter on by a period: begin it, keep it, or end it when past and clear."""
    before = facts.encounter
    own, other = facts.own.pose, facts.other.pose
    distance = math.hypot(own.x - other.x, own.y - other.y)
    sides = {facts.own.id: facts.own_on_starboard_side, facts.other.id: facts.other_on_starboard_side}
    if before.geometry is Geometry.NONE:
        if geometry is Geometry.NONE:
            return NO_ENCOUNTER
        cross = {facts.own.id: facts.courses_cross_from, facts.other.id: -facts.courses_cross_from}
        return Encounter(
            geometry=geometry,
            overtaker=overtaker,
            starboard_sides=sides,
            crosses_from=cross,
            distance=distance,
        )
    opening = before.opening_periods + 1 if distance > before.distance else 0
    apart = distance > (facts.own.ship.hull.length + facts.other.ship.hull.length) / 2.0
    if opening >= _OPENING_PERIODS and apart and _past(facts):
        return NO_ENCOUNTER
    return replace(before, starboard_sides=sides, distance=distance, opening_periods=opening)


def _past(facts: PairFacts) -> bool:
    """Whether an overtaker has the other abaft its beam; other encounters are past when the range grows."""
    overtaker = facts.encounter.overtaker
    if overtaker is None:
        return True
    bearing = facts.bearing_of_other if overtaker == facts.own.id else facts.bearing_of_own
    gave_up = facts.tcpa > 3600.0 or facts.tcpa < 0.0
    return abs(bearing) > math.pi / 2.0 or gave_up
