"""What ships tell one another.  Every message names its sender and its period."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from ..frames import NedTrajectory
from ..ships import ShipId
from ..tapd.deadlock import Waiting
from ..verdict import Verdict
from ..world import ShipReport


@dataclass(frozen=True, slots=True)
class Report:
    """Where the sender is, and what it says of itself."""

    sender: ShipId
    period: int
    report: ShipReport


@dataclass(frozen=True, slots=True)
class Verdicts:
    """How the sender judges its encounters."""

    sender: ShipId
    period: int
    verdicts: tuple[Verdict, ...]


@dataclass(frozen=True, slots=True)
class Gossip:
    """Whom each ship waits for, and who has decided, as far as the sender has heard."""

    sender: ShipId
    period: int
    waiting: Mapping[ShipId, Waiting]
    decided: frozenset[ShipId]

    def __post_init__(self) -> None:
        object.__setattr__(self, "waiting", MappingProxyType(dict(self.waiting)))


@dataclass(frozen=True, slots=True, eq=False)
class Intention:
    """Trajectory xi of the sender after an iteration of Algorithm 2, in {n} (steps 13 and 14).

    While the sender negotiates, this is the broadcast trajectory of (13d), an extrapolation.  The
    message with `decided` set holds the local plan: that is a promise.
    """

    sender: ShipId
    period: int
    iteration: int
    trajectory: NedTrajectory
    decided: bool


Message: TypeAlias = Report | Verdicts | Gossip | Intention
