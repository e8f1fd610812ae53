"""What a ship's agent is set to, what reaches it besides messages, and what it wants after a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol, TypeAlias

from ..dmpc.local_problem import LocalProblem, Solution
from ..dmpc.parameters import Settings
from ..frames import FloatArray, NedPose, NedTrajectory
from ..priority import Opening, Settlement
from ..roles import Geometry
from ..surge_yaw import Motion
from .messages import Message


class Conduct(StrEnum):
    """How a ship takes its duties: breaches are there to see what the others make of them."""

    DUTIFUL = "dutiful"
    IGNORES = "ignores"  # sails on, and tells so
    SILENT = "silent"  # sails on, and never tells its intention
    BREAKS_PROMISES = "breaks_promises"  # tells what it should do, and sails on


@dataclass(frozen=True, slots=True, kw_only=True)
class Timers:
    """Times within a period, from its beginning unless stated otherwise [s]."""

    listen: float = 1.0  # reports are awaited until then
    settle: float = 3.0  # verdicts are awaited until then
    deadlock: float = 2.0  # T_DL: without progress for so long, a deadlock is looked for
    resend: float = 1.0  # a ship repeats its last word after so long, while others still need it
    patience: float = 10.0  # a ship whose turn has not come by then goes on without those it waits for
    deadline: float = 15.0  # a decision leaves the ship by then


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentSettings:
    """How a ship's agent is set."""

    profiles: Mapping[Geometry, Settings]  # control settings by geometry (Sec. 5.4)
    profile: Geometry | None = None  # None: by the encounters at hand
    deadlock_detection: bool = True
    conduct: Conduct = Conduct.DUTIFUL
    timers: Timers = field(default_factory=Timers)


@dataclass(frozen=True, slots=True)
class Sensed:
    """The ship's own instruments, at the beginning of a period."""

    period: int
    pose: NedPose
    speed: float  # over ground [m/s]


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """The answer to a request."""

    problem: LocalProblem
    solution: Solution


@dataclass(frozen=True, slots=True, eq=False)
class Request:
    """A local problem that the ship wants solved, and the guesses to start from."""

    problem: LocalProblem
    guesses: tuple[FloatArray, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Decision:
    """What a ship does for one period, and all that led to it."""

    offset: float  # u^y [m]
    speed_factor: float  # u^s
    ruleset: str
    plan: NedTrajectory
    settlements: tuple[Settlement, ...]
    openings: tuple[Opening, ...]
    outcome: str
    fallback: str
    update_ms: tuple[float, ...]
    residuals: tuple[float, ...]
    motion: Motion | None = None  # of a ship that is steered by surge speed and yaw rate
    saw: tuple[str, ...] = ()  # what the ship found wrong with reports of others


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Step:
    """What a ship wants after a step; `wake_at` None means: not before a message comes."""

    outbox: tuple[Message, ...] = ()
    wake_at: float | None = None
    request: Request | None = None
    decision: Decision | None = None


Event: TypeAlias = Message | Sensed | Solved


class Agent(Protocol):
    """Whoever decides for a ship: a state machine without input and output of its own."""

    def step(self, now: float, inbox: Sequence[Event]) -> Step:
        """Take what has come, go on as far as possible, and say what is wanted."""
