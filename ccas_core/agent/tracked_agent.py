"""A ship that is known by AIS alone: it reports where it is, and hears nobody."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from ..frames import NedTrajectory, frozen_array
from ..ships import Ship
from ..waterway import GuidingLine, Waters
from ..world import ShipReport
from .events import Decision, Event, Sensed, Step
from .messages import Report


def sighted(ship: Ship, line: GuidingLine, waters: Waters, sensed: Sensed) -> ShipReport:
    """Report of a ship that does not cooperate; its instruments may fail, and its report then says so."""
    pose = sensed.pose
    known = math.isfinite(pose.x) and math.isfinite(pose.y)
    leg = line.leg_at(line.frame.to_path(pose).x) if known else line.legs[0]
    return ShipReport(
        ship=ship,
        pose=pose,
        speed=sensed.speed,
        waterway=leg.waterway,
        towards=leg.towards,
        ruleset=waters.ruleset_at(pose) if known else waters.laws.laws[0].ruleset,
        cooperates=False,
    )


class TrackedAgent:
    """Reports, and sails on whatever the others do."""

    def __init__(self, ship: Ship, line: GuidingLine, waters: Waters) -> None:
        self._ship: Final = ship
        self._line: Final = line
        self._waters: Final = waters

    def step(self, now: float, inbox: Sequence[Event]) -> Step:  # noqa: ARG002 - as every agent's
        """Report at the beginning of a period; that is all."""
        sensed = next((event for event in inbox if isinstance(event, Sensed)), None)
        if sensed is None:
            return Step()
        report = sighted(self._ship, self._line, self._waters, sensed)
        decision = Decision(
            offset=0.0,
            speed_factor=1.0,
            ruleset=report.ruleset,
            plan=NedTrajectory(frozen_array([[sensed.pose.x, sensed.pose.y, sensed.pose.course]])),
            settlements=(),
            openings=(),
            outcome="",
            fallback="",
            update_ms=(),
            residuals=(),
        )
        return Step(outbox=(Report(self._ship.id, sensed.period, report),), decision=decision)
