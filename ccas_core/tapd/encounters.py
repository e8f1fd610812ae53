"""Memory of an encounter: what was true when it began holds until the ships are past and clear.

Overtaking lasts until the overtaker is past and clear (COLREG 13(d), BPR 6.09); the starboard side and the
direction are those of the first verdict, and so is the law, whatever borders the ships cross meanwhile.
Both ships remember the same, for they remember the same messages.  Ships that part and soon meet again, say
because an overtaker has fallen back, go on under the law that they had.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from ..regions import Law
from ..roles import Geometry
from ..ships import UNKNOWN, FactValue, ShipId

if TYPE_CHECKING:
    from ..verdict import Verdict
    from .facts import PairFacts

HELD: Final = ("follows_starboard_side", "direction")  # facts of a ship that an encounter holds
_OPENING_PERIODS: Final = 2  # periods of growing range after which ships are past and clear
LINGERS: Final = 15  # periods for which ships that have parted keep the law of their encounter
_GIVEN_UP: Final = 3600.0  # an overtaker that needs longer than this has given up [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Encounter:
    """What two ships remember of their encounter; `geometry` is none where there is none.

    `law` is the one that they judge by until it is over, and for a while after; None where they have yet to
    agree on one.
    """

    geometry: Geometry = Geometry.NONE
    law: Law | None = None
    overtaker: ShipId | None = None
    has_other_on_starboard: ShipId | None = None
    held: Mapping[ShipId, Mapping[str, FactValue]] = field(default_factory=dict)
    distance: float = math.inf  # when it was last looked at [m]
    opening_periods: int = 0  # for how many periods the range has grown
    parted_periods: int = 0  # for how many periods it has been over

    def __post_init__(self) -> None:
        held = {ship: MappingProxyType(dict(facts)) for ship, facts in self.held.items()}
        object.__setattr__(self, "held", MappingProxyType(held))

    @property
    def lasts(self) -> bool:
        """Whether the ships have met, and are not yet past and clear."""
        return self.geometry is not Geometry.NONE


NO_ENCOUNTER: Final = Encounter()


def remember(before: Encounter, facts: PairFacts, verdict: Verdict, law: Law | None = None) -> Encounter:
    """Carry an encounter on by a period: begin it, keep it, or end it when past and clear.

    `law` is that of the pair in this period; None where it is not to be remembered.
    """
    distance = facts.quantity(("distance",))
    if not before.lasts:
        if verdict.geometry is Geometry.NONE:
            return _parted(before, law)
        held = {ship: _known(facts, side) for ship, side in _sides(facts)}
        return Encounter(
            geometry=verdict.geometry,
            law=law,
            overtaker=verdict.overtaker,
            has_other_on_starboard=verdict.has_other_on_starboard,
            held=held,
            distance=distance,
        )
    opening = before.opening_periods + 1 if distance > before.distance else 0
    apart = distance > (facts["own.length"] + facts["other.length"]) / 2.0
    if opening >= _OPENING_PERIODS and apart and _past(before, facts):
        return _parted(before, law)
    held = {ship: {**_known(facts, side), **before.held.get(ship, {})} for ship, side in _sides(facts)}
    return replace(before, law=law, held=held, distance=distance, opening_periods=opening)


def _parted(before: Encounter, law: Law | None) -> Encounter:
    """Keep the law of an encounter that is over; after `LINGERS` periods nothing is remembered."""
    if law is None or before.law is None or before.parted_periods >= LINGERS:
        return NO_ENCOUNTER
    return Encounter(law=before.law, parted_periods=before.parted_periods + 1)


def _sides(facts: PairFacts) -> tuple[tuple[ShipId, str], ...]:
    return (facts.own, "own"), (facts.other, "other")


def _known(facts: PairFacts, side: str) -> dict[str, FactValue]:
    values = {name: facts[f"{side}.{name}"] for name in HELD}
    return {name: value for name, value in values.items() if value is not UNKNOWN}


def _past(encounter: Encounter, facts: PairFacts) -> bool:
    """Whether an overtaker has the other abaft its beam; other encounters are past when the range grows."""
    overtaker = encounter.overtaker
    if overtaker is None:
        return True
    ships = ("own", "other") if overtaker == facts.own else ("other", "own")
    tcpa = facts.quantity(("tcpa",))
    return facts.quantity(("abs", *ships)) > math.pi / 2.0 or tcpa > _GIVEN_UP or tcpa < 0.0
