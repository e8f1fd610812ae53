"""What a voyage yields: a `Frame` a control period, with all that is needed to redraw or dispute it.

A frame stands at the instant `time`.  Poses are those at that instant; commands, plans and verdicts
are those issued then, and hold until the next frame.  From one frame to the next a ship sails
straight, on the course of the *later* frame: that is Eq. (4), course first, then position.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..frames import NedPose, NedTrajectory
from ..priority import Opening, Settlement
from ..ships import ShipId
from ..surge_yaw import Motion


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShipFrame:
    """One ship at one instant, and what it decided then."""

    pose: NedPose
    path_x: float  # distance sailed along its guiding line [m]
    path_y: float  # offset from its guiding line, starboard positive [m]
    speed: float  # over ground, under the command given now [m/s]
    offset: float  # u^y commanded now [m]
    speed_factor: float  # u^s commanded now
    ruleset: str  # id of the ruleset it sails under
    plan: NedTrajectory  # its intention, (N + 1, 3), first row: now
    outcome: str  # sentence of the worst solver outcome of this period; "" where nothing was solved
    fallback: str  # why the command is not the solver's; "" where it is
    update_ms: tuple[float, ...]  # wall time of each NADMM update, or of what else the ship computed [ms]
    residuals: tuple[float, ...]  # max |broadcast - local| position after each NADMM update [m]
    motion: Motion | None = None  # commanded now, of a ship that is steered by surge speed and yaw rate
    saw: tuple[str, ...] = ()  # what it found wrong with reports of ships that do not cooperate


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Frame:
    """All ships at one instant.

    A ship that has arrived stands in one more frame, the first after it crossed the end of its route, so that
    its last stretch is known; it decides nothing there, and is gone from the next.
    """

    index: int
    time: float  # [s]
    ships: Mapping[ShipId, ShipFrame]
    settlements: tuple[Settlement, ...]  # one a pair of ships that met, sorted by pair
    openings: tuple[Opening, ...]  # edges of the priority graph opened in this period
    generations: tuple[tuple[ShipId, ...], ...]  # the order in which ships decided
    arrived: Mapping[ShipId, float]  # time at which each arrived ship crossed the end of its route [s]
