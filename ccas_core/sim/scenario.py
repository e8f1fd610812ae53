"""A scenario: what a file says, as values in SI units and in the inertial frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from ..agent.events import Conduct
from ..controllers import Control
from ..dmpc.parameters import RiskShape, Start, Wait
from ..frames import NedPose
from ..ships import Ship
from ..surge_yaw import Manoeuvrability
from ..waterway import Leg, Waters
from .given_track import GivenTrack


class Profile(StrEnum):
    """Which of the two parameter sets of Sec. 5 a ship uses."""

    AUTO = "auto"  # by the geometry of its encounters (Sec. 5.4)
    HEAD_ON = "head_on"
    CROSSING = "crossing"


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """A ship of a scenario: who it is, where it starts, where it goes, how fast."""

    ship: Ship
    route: tuple[Leg, ...]
    start: NedPose
    speed: float  # nominal, U^d [m/s]
    conduct: Conduct = Conduct.DUTIFUL
    rulesets: tuple[str, ...] = ()  # aboard, as ID or ID@VERSION; none: all that there are
    control: Control = field(default_factory=Control)
    limits: Manoeuvrability | None = None  # of a ship under a controller; None: usual ones for its length
    track: GivenTrack | None = None  # of a tracked ship; None: on beside its guiding line at its speed


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlChoice:
    """The `control` block: what overrides the profile."""

    horizon: int = 45
    iterations: int = 3
    profile: Profile = Profile.AUTO
    parameters: Mapping[str, float] = field(default_factory=dict)  # names of dmpc.parameters.PARAMETERS, SI
    wait: Wait | None = None  # None: the default of `Settings`
    risk_shape: RiskShape | None = None
    starts: tuple[Start, ...] | None = None
    deadlock_detection: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class BusChoice:
    """The `bus` block: how messages are lost and delayed."""

    loss: float = 0.0  # probability in [0, 1)
    delay: float = 0.0  # greatest delay of a message [s]
    seed: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """Everything that a voyage starts from."""

    name: str
    waters: Waters
    ships: tuple[Plan, ...]
    time_step: float = 20.0  # control period [s]
    duration: float = 0.0  # least duration [s]; can only lengthen a run
    control: ControlChoice = field(default_factory=ControlChoice)
    bus: BusChoice = field(default_factory=BusChoice)
    title: str = ""
    description: str = ""
