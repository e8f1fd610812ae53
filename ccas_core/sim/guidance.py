"""Line-of-sight guidance along a route: the command that the model follows, in the ship's path frame."""

from __future__ import annotations

from dataclasses import dataclass

from ..waterway import GuidingLine


@dataclass(frozen=True, slots=True)
class Command:
    """What the collision avoidance asks of the guidance for one period."""

    offset: float  # u^y [m]
    speed_factor: float  # u^s, 0 to 1


def held(command: Command, line: GuidingLine, x: float, beam: float) -> Command:
    """Hold a command within the banks at distance x [m] along the line, and the speed within 0 and 1."""
    low, high = line.offset_limits(x, beam)
    return Command(min(max(command.offset, low), high), min(max(command.speed_factor, 0.0), 1.0))
