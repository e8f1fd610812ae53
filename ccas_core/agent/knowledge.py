"""What a ship knows in one control period: what it has heard, judged and told so far."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from ..dmpc.negotiate import Negotiation, Progress
from ..frames import FloatArray, NedTrajectory
from ..priority import Bearing, Opening, Settlement
from ..ships import ShipId
from ..tapd.deadlock import Waiting
from ..tapd.ruleset import Situation
from ..verdict import Verdict
from ..world import ShipReport
from .messages import Gossip, Message, Report, Verdicts


class Phase(Enum):
    """What a ship is doing in a period."""

    LISTENING = 1
    SETTLING = 2
    WAITING = 3
    DONE = 4


@dataclass(slots=True, eq=False)
class Period:
    """Knowledge of one control period."""

    index: int
    began: float
    own: ShipReport
    phase: Phase = Phase.LISTENING
    reports: dict[ShipId, ShipReport] = field(default_factory=dict)
    saw: tuple[str, ...] = ()  # what was wrong with reports
    silent: frozenset[ShipId] = frozenset()  # ships that do not cooperate
    situation: Situation | None = None  # as it was judged
    judged: tuple[Verdict, ...] = ()
    heard: dict[ShipId, tuple[Verdict, ...]] = field(default_factory=dict)
    settlements: tuple[Settlement, ...] = ()
    waits_for: set[ShipId] = field(default_factory=set)
    openings: list[Opening] = field(default_factory=list)
    waiting: dict[ShipId, Waiting] = field(default_factory=dict)
    told: dict[ShipId, Progress] = field(default_factory=dict)
    intentions: dict[ShipId, NedTrajectory] = field(default_factory=dict)
    bearings: dict[ShipId, Bearing] = field(default_factory=dict)
    limits: FloatArray | None = None  # of the offset, by the water alone, (N, 2) [m]
    negotiation: Negotiation | None = None
    asked: bool = False  # a request is out
    progressed: float = 0.0  # when somebody last told a decision [s]
    resent: float = 0.0  # when the ship last told its own [s]

    @property
    def talking(self) -> frozenset[ShipId]:
        """Ships whose word is awaited."""
        return frozenset(self.reports) - self.silent

    @property
    def decided(self) -> frozenset[ShipId]:
        """Ships that have told their decision."""
        return frozenset(ship for ship, progress in self.told.items() if progress.decided)

    def take(self, now: float, message: Message) -> None:
        """Take note of a message of this period; one of another period came too late, and is dropped."""
        if message.period != self.index:
            return
        if isinstance(message, Report):
            if self.phase is Phase.LISTENING:
                self.reports[message.sender] = message.report
        elif isinstance(message, Verdicts):
            self.heard[message.sender] = message.verdicts
        elif isinstance(message, Gossip):
            self.waiting |= message.waiting
            for ship in message.decided - self.decided:
                self.told.setdefault(ship, Progress(0, decided=False))
        else:
            before = self.told.get(message.sender)
            progress = Progress(message.iteration, message.decided)
            if before is None or (progress.decided, progress.iteration) > (before.decided, before.iteration):
                self.told[message.sender] = progress
                self.intentions[message.sender] = message.trajectory
                self.progressed = now
