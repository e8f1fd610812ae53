"""The vocabulary: every fact that a rule may ask for, with its type, unit, meaning and source.

A fact belongs to a ship (`own.length`), to the waterway on which two ships meet (`waterway.current`), or to
the pair (`geometry`).  Its value may be unknown.  What a file does not state has the default here.
Facts whose names a file writes with a unit (`length: 103 m`) stand in encounter files under a name
with a suffix (`length_m: 103.0`); `Fact.key` gives it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from types import MappingProxyType
from typing import Any, Final

from ..quantities import ANGLE, LENGTH, MASS, NUMBER, SPEED, TIME, Quantity
from ..ships import UNKNOWN, FactValue


class Scope(StrEnum):
    """What a fact is about."""

    SHIP = "ship"
    WATERWAY = "waterway"
    PAIR = "pair"


class Kind(StrEnum):
    """What values a fact has."""

    FLAG = "flag"  # true or false
    NUMBER = "number"
    CHOICE = "choice"  # one of some words
    FLAGS = "flags"  # any of some words
    TEXT = "text"


class Source(StrEnum):
    """Who knows a fact at first."""

    OWN = "own"  # the ship itself
    AIS = "ais"  # sent by the transponder
    CHART = "chart"  # from the electronic chart and the position
    OBSERVED = "observed"  # seen by a lookout or a camera
    SHARED = "shared"  # derived from what all have heard, so that all derive the same
    MESSAGE = "message"  # told by the ship in its report


SUFFIXES: Final = {"m": "_m", "s": "_s", "m/s": "_mps", "deg": "_deg", "t": "_t", "": ""}
WORLD: Final = "world"  # computed from positions, courses and the chart where a file does not state it


@dataclass(frozen=True, slots=True, kw_only=True)
class Fact:
    """One fact.

    `compute`, which plugins may give, takes the ship's report, and for a fact of a pair both reports, each
    with the waters, and returns the value; it must give the same on every ship.  `axioms` are conditions that
    always hold; a proof may rely on them.
    """

    name: str
    scope: Scope
    kind: Kind
    meaning: str
    source: Source
    default: FactValue = UNKNOWN
    choices: tuple[str, ...] = ()
    quantity: Quantity = NUMBER
    memory: str = ""  # for how long a value is held
    computed: bool = False  # from the world, where it is not stated
    compute: Callable[..., FactValue] | None = None
    axioms: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """Name in encounter files, with the unit as a suffix."""
        return f"{self.name}{SUFFIXES[self.quantity.unit]}"


def _flag(name: str, meaning: str, source: Source, **more: Any) -> Fact:
    more.setdefault("default", False)
    return Fact(name=name, scope=Scope.SHIP, kind=Kind.FLAG, meaning=meaning, source=source, **more)


def _number(name: str, meaning: str, source: Source, quantity: Quantity, **more: Any) -> Fact:
    return Fact(
        name=name,
        scope=Scope.SHIP,
        kind=Kind.NUMBER,
        meaning=meaning,
        source=source,
        quantity=quantity,
        **more,
    )


def _choice(name: str, choices: str, meaning: str, source: Source, **more: Any) -> Fact:
    words = tuple(choices.split())
    return Fact(
        name=name, scope=Scope.SHIP, kind=Kind.CHOICE, meaning=meaning, source=source, choices=words, **more
    )


_SHIP: Final = (
    _number("length", "length of the hull, or of the whole convoy", Source.AIS, LENGTH, computed=True),
    _number("beam", "greatest breadth", Source.AIS, LENGTH, computed=True),
    _number("draught", "draught now", Source.AIS, LENGTH),
    _number("weight", "displacement now", Source.MESSAGE, MASS, computed=True),
    _choice("propulsion", "motor sail muscle none", "what drives the ship", Source.OBSERVED, default="motor"),
    _flag("sails_set", "sails are set, besides whatever else drives it", Source.OBSERVED),
    _number("passengers_max", "passengers that it may carry", Source.AIS, NUMBER, default=0),
    _flag("scheduled_service", "sails by a timetable for passengers", Source.MESSAGE),
    _flag("ferry", "is a ferry", Source.AIS),
    _flag("pushed_barge", "is a pushed barge", Source.AIS),
    _flag("tows_large", "tows, pushes or carries a ship that is not small", Source.AIS),
    _flag(
        "authorised_tow_large", "is authorised to tow, push or carry ships that are not small", Source.MESSAGE
    ),
    _flag("convoy", "is a convoy", Source.AIS),
    _flag("convoy_only_small", "is a convoy of small craft only", Source.MESSAGE),
    _number("convoy_length", "length of the convoy", Source.AIS, LENGTH),
    _flag("high_speed", "is a fast ship by its certificate", Source.MESSAGE),
    _flag("engaged_in_fishing", "is fishing, with gear that hinders it", Source.AIS),
    _flag("nuc", "is not under command", Source.AIS),
    _flag("ram", "is restricted in its ability to manoeuvre", Source.AIS),
    _flag("constrained_by_draught", "is constrained by its draught", Source.AIS),
    _flag("confined_to_channel", "can navigate safely only inside the channel", Source.OWN),
    _flag("oversize_seagoing", "is a seagoing ship of special size", Source.MESSAGE),
    _flag("priority_light", "shows the blue scintillating light", Source.OBSERVED),
    _number("dangerous_goods_cones", "blue cones or lights that it shows", Source.AIS, NUMBER, default=0),
    _choice(
        "direction",
        "upbound downbound none",
        "towards the source, or away from it, by the nominal direction of the waterway",
        Source.SHARED,
        default="none",
        computed=True,
        memory="encounter",
    ),
    _choice(
        "with_current",
        "with against none",
        "sails with the current of now, or against it",
        Source.SHARED,
        default="none",
        computed=True,
    ),
    _flag(
        "follows_starboard_side",
        "follows the starboard side of the fairway",
        Source.SHARED,
        computed=True,
        memory="encounter, and hysteresis",
    ),
    _flag("along_channel", "proceeds along the channel or fairway", Source.SHARED),
    _flag("on_main_fairway", "is on the main fairway", Source.SHARED),
    _flag("in_prescribed_lane", "is in the lane prescribed for its direction", Source.SHARED),
    _choice(
        "manoeuvre",
        "proceeding crossing_fairway leaving_harbour entering_harbour entering_main entering_main_from_branch"
        " turning leaving_berth",
        "what it is about to do",
        Source.MESSAGE,
        default="proceeding",
    ),
    _flag("must_turn_to_enter", "must turn before it can enter", Source.MESSAGE),
    _flag("from_laterally_marked_side", "comes from a side water that has lateral marks", Source.CHART),
    _flag("wants_berth_right_bank", "makes for a berth or a water at the right bank", Source.MESSAGE),
    _flag("blue_sign", "shows the blue sign", Source.OBSERVED),
    _flag("signalled", "has signalled or asked for its manoeuvre", Source.MESSAGE),
    _flag("acknowledged", "has acknowledged what it was asked for", Source.MESSAGE),
    _choice("wind_side", "port starboard", "the side from which it has the wind", Source.OBSERVED),
    _flag("windward", "is the one to windward of the two", Source.SHARED),
    _flag("close_hauled", "sails close-hauled", Source.OBSERVED),
    _flag("tacking", "is tacking across the fairway", Source.OBSERVED),
    _flag("inside_narrow_passage", "is in the narrow passage already", Source.SHARED),
    _flag(
        "obstacle_on_starboard", "has the obstacle, or the inner bend, on its starboard side", Source.SHARED
    ),
    _flag("lays_through", "can sail through without tacking", Source.OWN),
    _flag("moving_astern_over_ground", "falls down with its bow against the current", Source.SHARED),
    _number("heading", "direction of the bow", Source.AIS, ANGLE),
)

_WATERWAY: Final = (
    Fact(
        name="name",
        scope=Scope.WATERWAY,
        kind=Kind.TEXT,
        meaning="its id on the chart",
        source=Source.CHART,
        default="",
        computed=True,
    ),
    Fact(
        name="type",
        scope=Scope.WATERWAY,
        kind=Kind.CHOICE,
        choices=("river", "canal", "lake", "sea", "harbour"),
        meaning="what kind of water it is",
        source=Source.CHART,
        default="river",
    ),
    Fact(
        name="upstream_defined",
        scope=Scope.WATERWAY,
        kind=Kind.FLAG,
        default=True,
        computed=True,
        meaning="the regulation says which direction is upstream",
        source=Source.CHART,
    ),
    Fact(
        name="current",
        scope=Scope.WATERWAY,
        kind=Kind.CHOICE,
        choices=("none", "downstream", "upstream"),
        meaning="where the current runs now",
        source=Source.CHART,
        default="none",
    ),
    Fact(
        name="width",
        scope=Scope.WATERWAY,
        kind=Kind.NUMBER,
        quantity=LENGTH,
        computed=True,
        meaning="width between the banks",
        source=Source.CHART,
    ),
    Fact(
        name="regime",
        scope=Scope.WATERWAY,
        kind=Kind.FLAGS,
        default="",
        meaning="stretches and special regimes to which it belongs",
        source=Source.CHART,
    ),
    *(
        Fact(
            name=name,
            scope=Scope.WATERWAY,
            kind=Kind.FLAG,
            meaning=meaning,
            source=Source.CHART,
            default=default,
        )
        for name, meaning, default in (
            ("narrow_passage", "no room for two ships to pass", False),
            ("fairway_has_sides", "the fairway has sides that a ship can follow", True),
            ("laterally_marked_main", "the main fairway has lateral marks", False),
            ("sign_a2", "sign A.2: no overtaking", False),
            ("sign_a3", "sign A.3: no overtaking between convoys", False),
            ("sign_a4", "sign A.4: no meeting and no overtaking", False),
            ("sign_b9", "sign B.9: give way to those on the main waterway", False),
            ("sign_b10", "sign B.10: those on the main waterway must adapt", False),
        )
    ),
)


def _pair(name: str, kind: Kind, meaning: str, **more: Any) -> Fact:
    more.setdefault("computed", True)
    return Fact(name=name, scope=Scope.PAIR, kind=kind, meaning=meaning, source=Source.SHARED, **more)


_PAIR: Final = (
    _pair("risk_of_collision", Kind.FLAG, "there is a risk of collision", memory="until past and clear"),
    _pair(
        "geometry",
        Kind.CHOICE,
        "how the ships meet",
        choices=("head_on", "crossing", "overtaking", "none"),
        memory="until past and clear",
    ),
    _pair(
        "overtaker",
        Kind.CHOICE,
        "which of the two overtakes",
        choices=("own", "other", "none"),
        memory="until past and clear",
    ),
    _pair(
        "has_other_on_starboard",
        Kind.CHOICE,
        "which of the two has the other on its starboard side",
        choices=("own", "other", "none"),
        memory="until past and clear",
    ),
    _pair(
        "same_waterway",
        Kind.FLAG,
        "each lies between the banks of the other's waterway",
        default=True,
    ),
    _pair("same_direction", Kind.FLAG, "both follow one waterway, in one direction", default=False),
)

MOTIONS: Final[Mapping[str, tuple[Quantity, str]]] = MappingProxyType(
    {
        "tcpa": (TIME, "time to the closest point of approach; negative when past"),
        "dcpa": (LENGTH, "distance at the closest point of approach"),
        "distance": (LENGTH, "distance between the ships"),
        "course_difference": (ANGLE, "angle between the courses, 0 to 180 deg"),
        "bearing": (ANGLE, "`bearing(a, b)`: of b, from the course of a, clockwise, -180 to 180 deg"),
        "speed": (SPEED, "`own.speed`: over ground"),
        "time_to_intersection": (
            TIME,
            "`own.time_to_intersection`: until it reaches the middle of the intersection; negative when past",
        ),
    }
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Vocabulary:
    """All facts by scope and name, each with its place in the tuples that hold values."""

    facts: tuple[Fact, ...]
    places: Mapping[Scope, Mapping[str, int]] = field(init=False)
    by_scope: Mapping[Scope, tuple[Fact, ...]] = field(init=False)

    def __post_init__(self) -> None:
        by_scope = {scope: tuple(f for f in self.facts if f.scope is scope) for scope in Scope}
        places = {
            scope: MappingProxyType({fact.name: n for n, fact in enumerate(facts)})
            for scope, facts in by_scope.items()
        }
        object.__setattr__(self, "places", MappingProxyType(places))
        object.__setattr__(self, "by_scope", MappingProxyType(by_scope))

    def find(self, scope: Scope, name: str) -> Fact | None:
        """Fact by its name; None where there is none."""
        place = self.places[scope].get(name)
        return None if place is None else self.by_scope[scope][place]

    def extended(self, facts: Iterable[Fact]) -> Vocabulary:
        """Add facts of plugins.

        Raises
        ------
        ValueError
            If a name is taken, or a fact is of a kind that only the vocabulary itself has.
        """
        added = tuple(facts)
        known = {(fact.scope, fact.name) for fact in self.facts}
        for fact in added:
            if fact.kind is Kind.FLAGS:
                raise ValueError(f"the fact {fact.name!r} has flags; write a fact of its own for each")
            if (fact.scope, fact.name) in known:
                raise ValueError(f"there is a fact {fact.name!r} of a {fact.scope} already")
            known.add((fact.scope, fact.name))
        return replace(self, facts=(*self.facts, *added)) if added else self


VOCABULARY: Final = Vocabulary(facts=(*_SHIP, *_WATERWAY, *_PAIR))
