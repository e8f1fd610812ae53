"""Ships as the others know them: identity, hull, mass, stated facts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType
from typing import Final, NewType, TypeAlias

from .domains import AbstractDomain, Rectangle

ShipId = NewType("ShipId", str)


class Unknown(Enum):
    """The third value of a fact: nobody knows.  Its one member is `UNKNOWN`."""

    UNKNOWN = "unknown"


UNKNOWN: Final = Unknown.UNKNOWN
FactValue: TypeAlias = bool | int | float | str | Unknown
Facts: TypeAlias = Mapping[str, FactValue]

SAFETY_BEAM_FACTOR: Final = 1.5  # safety area: length by 1.5 x beam, unless stated


@dataclass(frozen=True, slots=True, kw_only=True)
class Hull:
    """Rectangle that a ship occupies, along its course, and the safety area around it."""

    length: float  # [m]
    beam: float  # [m]
    safety_length: float = 0.0  # [m]; 0 means the length
    safety_beam: float = 0.0  # [m]; 0 means 1.5 x beam

    def __post_init__(self) -> None:
        for name in ("length", "beam"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of a hull must be positive, got {getattr(self, name)}")
        if not self.safety_length:
            object.__setattr__(self, "safety_length", self.length)
        if not self.safety_beam:
            object.__setattr__(self, "safety_beam", SAFETY_BEAM_FACTOR * self.beam)


@dataclass(frozen=True, slots=True, kw_only=True)
class Ship:
    """What does not change about a ship during a voyage, and what it tells of itself."""

    id: ShipId
    hull: Hull
    mass: float  # displacement [kg]
    facts: Facts = field(default_factory=dict)  # stated facts, by name; angles in rad, lengths in m
    stated_domain: AbstractDomain | None = None  # None: the safety area of the hull

    def __post_init__(self) -> None:
        object.__setattr__(self, "facts", MappingProxyType(dict(self.facts)))

    @property
    def domain(self) -> AbstractDomain:
        """Safety domain: the one that is stated, or the safety area of the hull."""
        area = Rectangle(length=self.hull.safety_length, breadth=self.hull.safety_beam)
        return self.stated_domain or area
