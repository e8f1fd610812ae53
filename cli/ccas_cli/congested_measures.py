"""What the five simulations of the second paper came to: offsets, speeds and distances of the own ship."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from ccas_core.sim.frame import Frame, ShipFrame

    from .reproduction import Case

OWN: Final = "asv"
SWING: Final = 0.5  # change of speed that counts as one [m/s]
STEADY: Final = 30  # last periods of the voyage, in which nobody is near any more


def own_states(frames: Sequence[Frame]) -> list[ShipFrame]:
    """States of the own ship while it is steered."""
    return [ship for frame in frames for id_, ship in frame.ships.items() if id_ == OWN and ship.motion]


def surges(case: Case) -> list[float]:
    """Surge speeds of the own ship, period by period [m/s]."""
    return [now.motion.surge for now in own_states(case.frames) if now.motion]


def slowest(case: Case) -> float:
    """Least surge speed of the own ship [m/s]."""
    return min(surges(case))


def usual_surge(case: Case) -> float:
    """Surge speed on the path while nobody is near [m/s]."""
    return surges(case)[-1]


def domains_met(case: Case) -> list[dict[str, float]]:
    """Domains of the own ship and of each other ship and obstacle."""
    return [each for each in case.summary["domains"] if OWN in each["ships"]]


def swings(case: Case) -> int:
    """How often the surge speed turns from falling to rising by more than `SWING`."""
    count, falling = 0, False
    low = high = surges(case)[0]
    for surge in surges(case):
        if falling:
            low = min(low, surge)
            if surge > low + SWING:
                count, falling, high = count + 1, False, surge
        else:
            high = max(high, surge)
            if surge < high - SWING:
                falling, low = True, surge
    return count


def cross_track_error(case: Case) -> float:
    """Greatest distance from the path in steady sailing, when all are past [m]."""
    return max(abs(now.path_y) for now in own_states(case.frames)[-STEADY:])


def turn_from_path(case: Case, now: ShipFrame) -> float:
    """Angle between the ship and its path [deg]; the guiding lines are straight."""
    from ccas_core.units import wrap

    return math.degrees(wrap(now.pose.course - path_course(case)))


def path_course(case: Case) -> float:
    """Course of the own path, which is straight [rad]."""
    from ccas_core.sim.metrics import guiding_frames

    lines = guiding_frames(case.scenario)
    return next(line.course_at(0.0) for id_, line in lines.items() if id_ == OWN)


def together(case: Case, other: str) -> list[tuple[ShipFrame, ShipFrame]]:
    """The own ship and another, in all frames that have both."""
    found = []
    for frame in case.frames:
        ships = {str(id_): ship for id_, ship in frame.ships.items()}
        if OWN in ships and other in ships:
            found.append((ships[OWN], ships[other]))
    return found


def offset_abeam(case: Case, other: str) -> float:
    """Offset from the path when another ship is abeam, starboard positive [m]."""
    course = path_course(case)

    def ahead(pair: tuple[ShipFrame, ShipFrame]) -> float:
        own, there = (each.pose for each in pair)
        return abs((there.x - own.x) * math.cos(course) + (there.y - own.y) * math.sin(course))

    return min(together(case, other), key=ahead)[0].path_y


def is_astern(case: Case, other: str) -> bool:
    """Whether the ship was astern of another when it came to its track."""
    own, there = min(together(case, other), key=lambda pair: abs(as_seen_by_other(pair)[1]))
    return as_seen_by_other((own, there))[0] < 0.0


def as_seen_by_other(pair: tuple[ShipFrame, ShipFrame]) -> tuple[float, float]:
    """The own ship as the other sees it: ahead, and to starboard [m]."""
    own, there = (each.pose for each in pair)
    north, east = own.x - there.x, own.y - there.y
    cos, sin = math.cos(there.course), math.sin(there.course)
    return north * cos + east * sin, east * cos - north * sin


def offset_beside_obstacle(case: Case) -> float:
    """Offset from the path where the obstacle is nearest, starboard positive [m]."""
    obstacle = case.scenario.waters.obstacles[0]
    return min(
        own_states(case.frames),
        key=lambda now: (now.pose.x - obstacle.x) ** 2 + (now.pose.y - obstacle.y) ** 2,
    ).path_y


def room_on_track(case: Case) -> tuple[float, float]:
    """Distance from the other ship, on its track, when the own ship is there [m], and the time [s]."""
    pairs = [
        (frame.time, *pair) for frame, pair in zip(case.frames, together(case, "obstacle"), strict=False)
    ]
    time, own, there = min(pairs, key=lambda each: abs(as_seen_by_other((each[1], each[2]))[1]))
    return abs(as_seen_by_other((own, there))[0]), time
