"""What a controller of somebody else's is: it steers one ship by what it sees, and negotiates with nobody.

A controller gets an `Outlook`: its ship, its line, the waters, and of every other ship what AIS tells and
the `Bearing` that the priority graph gives.  It returns a `Steering`: motion, plan, and what it has to say.
It reads no rule and no ruleset; under another ruleset it gets other bearings.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final

from .domains import AbstractDomain
from .frames import NedPose, NedTrajectory
from .priority import Bearing
from .quantities import ANY, Quantity, Range
from .ships import Hull, ShipId
from .surge_yaw import Manoeuvrability, Motion
from .waterway import GuidingLine, Waters


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """A number or a word that a scenario may set for a controller."""

    meaning: str
    default: float | str | None = None  # None: by the ship, as the meaning says
    quantity: Quantity | None = None  # of a number
    within: Range = ANY  # of a number, SI
    choices: tuple[str, ...] = ()  # of a word


Options = Mapping[str, float | str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """Another ship, as AIS tells of it, and what the own ship owes it."""

    id: ShipId
    hull: Hull
    domain: AbstractDomain
    pose: NedPose
    speed: float  # over ground [m/s]
    bearing: Bearing


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outlook:
    """All that a controller may know when it decides for one control period."""

    time: float  # [s]
    period: float  # control period, for which the motion is kept [s]
    hull: Hull
    domain: AbstractDomain
    limits: Manoeuvrability
    speed: float  # nominal, over ground [m/s]
    line: GuidingLine
    waters: Waters  # chart, obstacles and current
    pose: NedPose  # `course` is the yaw angle
    motion: Motion  # of the period before
    targets: tuple[Target, ...]
    options: Options


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Steering:
    """What a controller decides."""

    motion: Motion
    plan: NedTrajectory  # first row now, then a row every `period`
    memory: Any = None  # handed back in the next period
    outcome: str = ""  # sentence of a solver that did not do what it should; "" where it did
    seconds: float = 0.0  # of computing


class AbstractController(ABC):
    """Steers a ship; the same object serves many ships, so that it remembers nothing itself."""

    name: str
    options: Mapping[str, Option] = MappingProxyType({})

    @abstractmethod
    def steer(self, outlook: Outlook, memory: Any) -> Steering:  # noqa: ANN401 - the controller's own
        """Decide for one period; `memory` is what the last `Steering` carried, None at first.

        Whatever is raised, and whatever is not finite, becomes a safe command: the ship slows down on its
        course, and the log says why.
        """


COOPERATIVE: Final = "cooperative"  # an agent of the fixed core, which negotiates
TRACKED: Final = "tracked"  # known by AIS alone
RESERVED: Final = (COOPERATIVE, TRACKED)


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """Who steers a ship: the core (`cooperative`), nobody that is asked (`tracked`), or a controller."""

    by: str = COOPERATIVE
    options: Options = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "options", MappingProxyType(dict(self.options)))
