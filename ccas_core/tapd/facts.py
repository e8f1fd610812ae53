"""Facts about two ships, Eq. (3) and Sec. 3.1: stated, remembered, or computed from reports and chart.

All come from what both ships have heard, so that both compute the same; `PairFacts.mirrored` is the
other ship's view.  Two ships on one waterway are looked at in the frame of its centreline, so that a bend
between them changes neither a bearing nor a closest approach.

Here are the quantities; the conditions on them, such as HEADON, stand in the rulesets.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

from ..quantities import ANGLE
from ..ships import UNKNOWN, FactValue, ShipId
from ..units import DEGREE
from ..waterway import Towards, Waters, Waterway
from ..world import ShipReport
from .encounters import NO_ENCOUNTER, Encounter
from .language.code import MOTION, Missing, Values
from .language.polynomial import mirrored_name
from .vocabulary import Scope, Vocabulary

STOPPED: Final = 0.1  # a ship slower than this is not under way [m/s]
KEEPS_STARBOARD: Final = 5.0  # a ship this far to starboard of the centreline follows the starboard side [m]
LEAVES_STARBOARD: Final = 0.0  # and does so until it is no farther than this [m]
GRID: Final = 2.0**-20  # positions [m] and velocities [m/s] are shared in multiples of this

_MIRRORED_PLACES: Final = {"ox": "tx", "oy": "ty", "tx": "ox", "ty": "oy"}
_SHIP_OF: Final = {"own": "other", "other": "own"}
_MIRRORED_MOTION: Final = tuple(
    MOTION.index(_MIRRORED_PLACES.get(name, mirrored_name(name))) for name in MOTION
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PairFacts:
    """What is true between `own` and `other`, as values in the order of a vocabulary.

    `facts["own.length"]`, `facts["waterway.current"]`, `facts["geometry"]` and `facts["tcpa"]` give single
    values, in SI units and radians; what nobody knows is `UNKNOWN`.  A fact of the pair that is neither
    stated nor remembered is None until a ruleset has recognised the encounter.
    """

    vocabulary: Vocabulary
    own: ShipId
    other: ShipId
    own_values: Values
    other_values: Values
    waterway_values: Values
    pair_values: Values
    motion: Values  # in the order of `language.code.MOTION`

    def mirrored(self) -> PairFacts:
        """Give the same facts as the other ship sees them."""
        m = self.motion
        motion = tuple(-m[n] if n < 4 else m[n] for n in _MIRRORED_MOTION) if self.moving else m
        return PairFacts(
            vocabulary=self.vocabulary,
            own=self.other,
            other=self.own,
            own_values=self.other_values,
            other_values=self.own_values,
            waterway_values=self.waterway_values,
            pair_values=tuple(
                _SHIP_OF.get(each, each) if isinstance(each, str) else each for each in self.pair_values
            ),
            motion=motion,
        )

    @property
    def moving(self) -> bool:
        """Whether positions and velocities are known."""
        return not isinstance(self.motion[0], Missing)

    def __getitem__(self, name: str) -> Any:
        head, _, tail = name.partition(".")
        places = self.vocabulary.places
        if head in _SHIP_OF and tail in places[Scope.SHIP]:
            values = self.own_values if head == "own" else self.other_values
            return plain(values[places[Scope.SHIP][tail]])
        if head == "waterway" and tail in places[Scope.WATERWAY]:
            return plain(self.waterway_values[places[Scope.WATERWAY][tail]])
        if name in places[Scope.PAIR]:
            return plain(self.pair_values[places[Scope.PAIR][name]])
        if name in MOTION:
            return plain(self.motion[MOTION.index(name)])
        if not self.moving:
            return UNKNOWN
        if tail == "speed" and head in _SHIP_OF:
            return math.hypot(*self._velocity(head))
        return self.quantity((name,))

    def quantity(self, measured: tuple[str, ...]) -> float:
        """Value of a quantity of motion: ("tcpa",), ("bearing", "own", "other"), ("speed", "own") [SI, rad].

        Raises
        ------
        KeyError
            If there is no such quantity.
        """
        if not self.moving:
            return math.nan
        name, *ships = measured
        rx, ry, wx, wy = self.motion[:4]
        if name == "tcpa":
            return closest_approach(rx, ry, wx, wy)[0]
        if name == "dcpa":
            return closest_approach(rx, ry, wx, wy)[1]
        if name == "distance":
            return math.hypot(rx, ry)
        if name == "course_difference":
            return abs(_turn(self._velocity("own"), self._velocity("other")))
        if name in ("bearing", "abs"):
            sight = (rx, ry) if ships[0] == "own" else (-rx, -ry)
            bearing = _turn(self._velocity(ships[0]), sight)
            return abs(bearing) if name == "abs" else bearing
        if name == "speed":
            return math.hypot(*self._velocity(ships[0]))
        if name == "time_to_intersection":
            return float(self.motion[MOTION.index(f"{ships[0]}.{name}")])
        raise KeyError(name)

    def _velocity(self, ship: str) -> tuple[float, float]:
        north, east = self.motion[4:6] if ship == "own" else self.motion[6:8]
        return north, east


def plain(value: Any) -> Any:
    """Value of a fact, or `UNKNOWN`."""
    return UNKNOWN if isinstance(value, Missing) else value


def _turn(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Angle from one vector to another, clockwise, (-pi, pi]; 0 where one of them is zero."""
    across, along = a[0] * b[1] - a[1] * b[0] + 0.0, a[0] * b[0] + a[1] * b[1]  # no -0.0: astern is +pi
    return math.atan2(across, along) if across or along else 0.0


def closest_approach(rx: float, ry: float, wx: float, wy: float) -> tuple[float, float]:
    """TCPA [s] and DCPA [m] of a relative position and velocity; (inf, distance) without relative motion."""
    square = wx * wx + wy * wy
    if square == 0.0:
        return math.inf, math.hypot(rx, ry)
    return -(rx * wx + ry * wy) / square, abs(rx * wy - ry * wx) / math.sqrt(square)


def assess(
    vocabulary: Vocabulary,
    waters: Waters,
    own: ShipReport,
    other: ShipReport,
    encounter: Encounter = NO_ENCOUNTER,
    values: Mapping[ShipId, Values] | None = None,
) -> PairFacts:
    """Assess a pair of ships on a chart.

    Parameters
    ----------
    vocabulary, waters, own, other
        The facts there are, the chart, and the two reports.
    encounter
        What is remembered of the pair.
    values
        Facts of single ships, where they have been computed already.

    Notes
    -----
    In an encounter the starboard side and the direction are those of its beginning: a ship that gives
    way to starboard does not earn the right to stand on by doing so.
    """
    known = values or {}
    sides = [
        _held(
            vocabulary,
            known[each.id] if each.id in known else ship_values(vocabulary, waters, each),
            each.id,
            encounter,
        )
        for each in (own, other)
    ]
    place = meeting_waterway(waters, own, other)
    return PairFacts(
        vocabulary=vocabulary,
        own=own.id,
        other=other.id,
        own_values=sides[0],
        other_values=sides[1],
        waterway_values=waterway_values(vocabulary, place),
        pair_values=_pair_values(vocabulary, waters, own, other, encounter),
        motion=motion_of(waters, own, other),
    )


def meeting_waterway(waters: Waters, own: ShipReport, other: ShipReport) -> Waterway:
    """Waterway whose facts count for a pair: theirs; of two, the wider, then the one with the smaller id."""
    if own.waterway == other.waterway:
        return waters.waterway(own.waterway)
    both = (waters.waterway(own.waterway), waters.waterway(other.waterway))
    return min(both, key=lambda each: (-each.width, each.id))


def ship_values(
    vocabulary: Vocabulary, waters: Waters, report: ShipReport, *, kept_starboard: bool = False
) -> tuple[Any, ...]:
    """Facts of one ship in the order of the vocabulary: what it states itself comes first.

    `kept_starboard` is what was true a period ago: a ship near the centreline keeps the side it had.
    """
    ship = report.ship
    found: dict[str, FactValue] = {"length": ship.hull.length, "beam": ship.hull.beam, "weight": ship.mass}
    found |= ship.facts
    waterway = waters.waterway(report.waterway)
    found.setdefault("direction", direction(waterway, report.towards))
    current = waterway.facts.get("current", "none")
    found.setdefault("with_current", with_current(current, direction(waterway, report.towards)))
    found.setdefault("follows_starboard_side", follows_starboard_side(waters, report, before=kept_starboard))
    values = []
    for fact in vocabulary.by_scope[Scope.SHIP]:
        value = found.get(fact.name, fact.default)
        if fact.name not in found and fact.compute is not None:
            value = fact.compute(report, waters)
        if fact.quantity is ANGLE and value is not UNKNOWN:
            value = float(value) / DEGREE  # conditions compare degrees
        values.append(Missing(report.id, fact.name) if value is UNKNOWN else value)
    return tuple(values)


def known_values(
    vocabulary: Vocabulary, waters: Waters, report: ShipReport, *, kept_starboard: bool = False
) -> tuple[Any, ...]:
    """As `ship_values`, computed once for a report."""
    key = vocabulary, waters, kept_starboard
    if key not in report.facts:
        report.facts[key] = ship_values(vocabulary, waters, report, kept_starboard=kept_starboard)
    return report.facts[key]


@lru_cache(maxsize=4096)  # charts change seldom, and pairs are many
def waterway_values(vocabulary: Vocabulary, waterway: Waterway) -> tuple[Any, ...]:
    """Facts of a waterway in the order of the vocabulary."""
    found: dict[str, Any] = {
        "name": waterway.id,
        "width": waterway.width,
        "upstream_defined": waterway.upstream is not Towards.NONE,
    }
    found |= waterway.facts
    return tuple(
        _waterway_value(found.get(fact.name, fact.default), fact.name)
        for fact in vocabulary.by_scope[Scope.WATERWAY]
    )


def _waterway_value(value: Any, name: str) -> Any:
    if value is UNKNOWN:
        return Missing("waterway", name)
    return frozenset(value.split()) if name == "regime" else value


def _pair_values(
    vocabulary: Vocabulary, waters: Waters, own: ShipReport, other: ShipReport, encounter: Encounter
) -> tuple[Any, ...]:
    found: dict[str, Any] = {
        "same_waterway": _between_banks(waters, own, other) and _between_banks(waters, other, own),
        "same_direction": own.waterway == other.waterway and own.towards is other.towards,
    }
    if encounter.lasts:
        names = {own.id: "own", other.id: "other", None: "none"}
        found |= {
            "risk_of_collision": True,
            "geometry": str(encounter.geometry),
            "overtaker": names[encounter.overtaker],
            "has_other_on_starboard": names[encounter.has_other_on_starboard],
        }
    values = []
    for fact in vocabulary.by_scope[Scope.PAIR]:
        value = found.get(fact.name)
        if value is None and fact.compute is not None:
            value = fact.compute(own, other, waters)
            value = Missing("pair", fact.name) if value is UNKNOWN else value
        values.append(value)
    return tuple(values)


def _held(vocabulary: Vocabulary, values: Values, ship: ShipId, encounter: Encounter) -> Values:
    held = encounter.held.get(ship)
    if not held:
        return values
    places, found = vocabulary.places[Scope.SHIP], list(values)
    for name, value in held.items():
        found[places[name]] = value
    return tuple(found)


def motion_of(waters: Waters, own: ShipReport, other: ShipReport) -> tuple[float, ...]:
    """Positions and velocities of two ships, in the frame of their waterway where they share one."""
    one, two = own.pose, other.pose
    poses = ((one.x, one.y, one.course), (two.x, two.y, two.course))
    if own.waterway == other.waterway:
        frame = waters.waterway(own.waterway).frame(Towards.END)
        if not frame.is_straight:
            along = (frame.to_path(one), frame.to_path(two))
            poses = (
                (along[0].x, along[0].y, along[0].course),
                (along[1].x, along[1].y, along[1].course),
            )
    times = tuple(time_to_intersection(waters, a, b.waterway) for a, b in ((own, other), (other, own)))
    return motion(poses[0], own.speed, poses[1], other.speed, times)


def motion(
    own: tuple[float, float, float],
    own_speed: float,
    other: tuple[float, float, float],
    other_speed: float,
    times: tuple[float, ...] = (math.inf, math.inf),
) -> tuple[float, ...]:
    """Motion of two ships from their poses (north, east [m], course [rad]) and speeds [m/s].

    All is put on a grid, fine enough for any sensor: so that every machine has the same, and so that a
    product of two of these numbers is zero only if one of them is.
    """
    ox, oy, tx, ty = (_on_grid(each) for each in (own[0], own[1], other[0], other[1]))
    ovx, ovy = velocity(own[2], own_speed)
    tvx, tvy = velocity(other[2], other_speed)
    return (
        tx - ox,
        ty - oy,
        tvx - ovx,
        tvy - ovy,
        ovx,
        ovy,
        tvx,
        tvy,
        *times,
        ox,
        oy,
        tx,
        ty,
    )


def velocity(course: float, speed: float) -> tuple[float, float]:
    """Velocity north and east [m/s], on a grid, so that every machine has the same.

    >>> velocity(math.pi, 4.0)
    (-4.0, 0.0)
    """
    north, east = speed * math.cos(course), speed * math.sin(course)
    return _on_grid(north), _on_grid(east)


def _on_grid(value: float) -> float:
    return round(value / GRID) * GRID + 0.0


def direction(waterway: Waterway, towards: Towards) -> str:
    """Whether a ship that makes for an end of a waterway is upbound or downbound."""
    if waterway.upstream is Towards.NONE:
        return "none"
    return "upbound" if towards is waterway.upstream else "downbound"


def with_current(current: FactValue, bound: str) -> FactValue:
    """Whether a ship sails with the current, from where it runs and where the ship is bound.

    >>> with_current("downstream", "upbound"), with_current("none", "upbound")
    ('against', 'none')
    """
    if current is UNKNOWN:
        return UNKNOWN
    if current == "none" or bound == "none":
        return "none"
    return "with" if (current == "downstream") == (bound == "downbound") else "against"


def time_to_intersection(waters: Waters, ship: ShipReport, across: str) -> float:
    """T^IC of a ship: time until it reaches the centre of the intersection with waterway `across` [s]."""
    if across == ship.waterway or ship.speed <= STOPPED:
        return math.inf
    centre = waters.junction(ship.waterway, across)
    if centre is None:
        return math.inf
    frame = waters.waterway(ship.waterway).frame(ship.towards)
    return (frame.to_path(centre).x - frame.to_path(ship.pose).x) / ship.speed


def follows_starboard_side(waters: Waters, ship: ShipReport, *, before: bool = False) -> FactValue:
    """Whether a ship follows the starboard side of its waterway; what it states itself comes first.

    `before` is what was true a period ago: a ship near the centreline keeps the side it had.
    """
    stated = ship.ship.facts.get("follows_starboard_side")
    if stated is not None:
        return stated
    frame = waters.waterway(ship.waterway).frame(ship.towards)
    offset = frame.to_path(ship.pose).y
    return offset > LEAVES_STARBOARD if before else offset >= KEEPS_STARBOARD


def _between_banks(waters: Waters, own: ShipReport, other: ShipReport) -> bool:
    """Whether the other ship lies between the banks of the own waterway."""
    waterway = waters.waterway(own.waterway)
    return abs(waterway.frame(own.towards).to_path(other.pose).y) <= waterway.width / 2.0
