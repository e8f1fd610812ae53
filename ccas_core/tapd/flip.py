"""The smallest change of one ship's course or speed that changes a verdict: on a grid, then by halving.

Everything else stays as it is: the positions, the other ship, the facts that are stated.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

from ..ships import ShipId
from ..units import DEGREE
from ..verdict import Verdict
from .facts import STOPPED, PairFacts, velocity
from .language.code import MOTION

_COURSE_STEP: Final = 1.0 * DEGREE
_SPEED_STEP: Final = 0.1  # [m/s]
_FASTEST: Final = 12.0  # as far as speeds are tried, if the ship is not faster already [m/s]
_HALVINGS: Final = 12

Views = tuple[Verdict, Verdict]
Judge = Callable[[PairFacts], Views]


class Manoeuvre(StrEnum):
    """What a ship does otherwise."""

    TO_STARBOARD = "to starboard"
    TO_PORT = "to port"
    FASTER = "faster"
    SLOWER = "slower"


@dataclass(frozen=True, slots=True, kw_only=True)
class Flip:
    """A change of course [rad] or speed [m/s] that changes the kind of verdict, and the verdicts then."""

    ship: ShipId
    manoeuvre: Manoeuvre
    change: float
    becomes: float  # course or speed after the change [rad or m/s]
    views: Views

    @property
    def turns(self) -> bool:
        """Whether it is a change of course."""
        return self.manoeuvre in (Manoeuvre.TO_STARBOARD, Manoeuvre.TO_PORT)

    @property
    def share(self) -> float:
        """Size of the change, as a part of half a circle, or of the speed before."""
        if self.turns:
            return self.change / math.pi
        before = self.becomes + (self.change if self.manoeuvre is Manoeuvre.SLOWER else -self.change)
        return self.change / max(before, _SPEED_STEP)


def flips(judge: Judge, facts: PairFacts) -> tuple[Flip, ...]:
    """Find the smallest changes, each ship and manoeuvre by itself, the smallest first.

    `judge` gives the verdicts of both views.  Nothing is found where positions and courses are not known.
    """
    if not facts.moving:
        return ()
    before = _says(judge(facts))
    found = (
        flip
        for side in ("own", "other")
        for manoeuvre in Manoeuvre
        if (flip := _nearest(judge, facts, side, manoeuvre, before)) is not None
    )
    return tuple(sorted(found, key=lambda each: each.share))


def _says(views: Views) -> tuple[object, ...]:
    return tuple((view.kind, view.initiator) for view in views)


def _nearest(
    judge: Judge, facts: PairFacts, side: str, manoeuvre: Manoeuvre, before: tuple[object, ...]
) -> Flip | None:
    """First change on the grid that changes what is said, then the least by halving."""
    course, speed = _course_and_speed(facts, side)
    if speed <= STOPPED and manoeuvre in (Manoeuvre.TO_STARBOARD, Manoeuvre.TO_PORT):
        return None

    def views(change: float) -> Views:
        return judge(_changed(facts, side, *_after(manoeuvre, course, speed, change)))

    last = 0.0
    for change in _grid(manoeuvre, speed):
        if _says(views(change)) != before:
            break
        last = change
    else:
        return None
    for _ in range(_HALVINGS):
        middle = (last + change) / 2.0
        if _says(views(middle)) != before:
            change = middle
        else:
            last = middle
    after = _after(manoeuvre, course, speed, change)
    turned = manoeuvre in (Manoeuvre.TO_STARBOARD, Manoeuvre.TO_PORT)
    ship = facts.own if side == "own" else facts.other
    becomes = after[0] % math.tau if turned else after[1]
    return Flip(ship=ship, manoeuvre=manoeuvre, change=change, becomes=becomes, views=views(change))


def _grid(manoeuvre: Manoeuvre, speed: float) -> Iterator[float]:
    if manoeuvre in (Manoeuvre.TO_STARBOARD, Manoeuvre.TO_PORT):
        yield from (_COURSE_STEP * n for n in range(1, 180))
        return
    most = speed if manoeuvre is Manoeuvre.SLOWER else max(_FASTEST - speed, speed)
    yield from (_SPEED_STEP * n for n in range(1, int(most / _SPEED_STEP) + 1))
    if manoeuvre is Manoeuvre.SLOWER and speed > 0.0:
        yield speed


def _after(manoeuvre: Manoeuvre, course: float, speed: float, change: float) -> tuple[float, float]:
    """Course and speed after a change."""
    match manoeuvre:
        case Manoeuvre.TO_STARBOARD:
            return course + change, speed
        case Manoeuvre.TO_PORT:
            return course - change, speed
        case Manoeuvre.FASTER:
            return course, speed + change
        case Manoeuvre.SLOWER:
            return course, max(0.0, speed - change)


def _course_and_speed(facts: PairFacts, side: str) -> tuple[float, float]:
    first = MOTION.index("ovx" if side == "own" else "tvx")
    north, east = facts.motion[first : first + 2]
    return math.atan2(east, north), math.hypot(north, east)


def _changed(facts: PairFacts, side: str, course: float, speed: float) -> PairFacts:
    """Give one ship another course and speed; it reaches an intersection sooner or later by its speed."""
    named = dict(zip(MOTION, facts.motion, strict=True))
    _, before = _course_and_speed(facts, side)
    north, east = ("ovx", "ovy") if side == "own" else ("tvx", "tvy")
    named[north], named[east] = velocity(course, speed)
    named["wx"], named["wy"] = named["tvx"] - named["ovx"], named["tvy"] - named["ovy"]
    time = f"{side}.time_to_intersection"
    named[time] = named[time] * before / speed if speed > STOPPED else math.inf
    return replace(facts, motion=tuple(named[name] for name in MOTION))
