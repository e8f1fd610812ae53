"""What is known at one instant: the chart, and what every ship reports of itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from .frames import NedPose
from .ships import Ship, ShipId
from .waterway import Towards, Waters


@dataclass(frozen=True, slots=True, kw_only=True)
class ShipReport:
    """What a ship tells the others at the beginning of a period; shared facts come from nothing else."""

    ship: Ship
    pose: NedPose
    speed: float  # over ground, along the course [m/s]
    waterway: str  # id of the waterway it follows now
    towards: Towards  # the end of the centreline it makes for
    ruleset: str  # id of the ruleset that holds where it is
    cooperates: bool = True  # it tells its verdicts and its intention; if not, it is known by AIS alone
    facts: dict[object, tuple[Any, ...]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )  # what `tapd.facts` has read from it so far: all who heard it ask for the same

    @property
    def id(self) -> ShipId:
        """Id of the ship."""
        return self.ship.id


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class World:
    """Chart and reports at one instant, as one ship has them, or as all do."""

    time: float  # [s]
    waters: Waters
    reports: Mapping[ShipId, ShipReport]

    def __post_init__(self) -> None:
        object.__setattr__(self, "reports", MappingProxyType(dict(self.reports)))
