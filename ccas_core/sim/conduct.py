"""How ships met and how they behaved: encounters, whether they were risky, whether sailed faithfully.

Pure functions of a scenario and its frames.  *In force* at a frame is the command of the frame before;
at the first frame, the undisturbed one: no offset, nominal speed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..controllers import COOPERATIVE
from ..frames import FloatArray, NedPose, PathFrame
from ..priority import Settlement
from ..roles import Geometry, PassingSide
from ..ships import ShipId
from ..verdict import Kind
from .frame import Frame, ShipFrame
from .hulls import Meeting, Track, clearances, instants, meeting, states, track, under_way
from .scenario import Plan, Scenario
from .undisturbed import undisturbed

RISKY_WITHIN: Final = 10.0  # undisturbed clearance of a risky encounter [m]
CALM_BEYOND: Final = 50.0  # undisturbed clearance of a calm encounter [m]
ACTING_OFFSET: Final = 10.0  # change of offset that counts as acting [m]
ACTING_FACTOR: Final = 0.9  # speed factor below which a ship acts
KEEPING_OFFSET: Final = 5.0  # change of offset that a stand-on ship is allowed [m]
KEEPING_FACTOR: Final = 0.95  # least speed factor of a stand-on ship
LOST_AFTER: Final = 2  # periods without a settlement that end an encounter


@dataclass(frozen=True, slots=True, kw_only=True)
class Encounter:
    """Two ships from their first verdict until none; geometry and duty as at the first verdict."""

    ships: tuple[ShipId, ShipId]  # sorted
    begin: int  # frame of the first verdict
    end: int  # first frame after the encounter
    geometry: Geometry
    kind: Kind
    ruleset: str
    give_way: tuple[ShipId, ...]
    stand_on: tuple[ShipId, ...]
    article: str
    passing_side: PassingSide | None
    side_to_follow: bool  # the stand-on ship has a side to follow


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """How an encounter stood, and how it was sailed; `faithful` is None where not judged."""

    risky: bool
    calm: bool
    faithful: bool | None


def is_met(settlement: Settlement) -> bool:
    """Whether a settlement puts its pair in an encounter: a verdict other than `none`."""
    return bool(settlement.fallback) or settlement.one.kind is not Kind.NONE


def encounters(frames: Sequence[Frame]) -> tuple[Encounter, ...]:
    """All encounters, in the order in which they began.

    One a pair, from its first verdict other than `none` until `none` again, or until the pair has not been
    settled for `LOST_AFTER` periods.
    """
    begun: dict[tuple[ShipId, ShipId], tuple[int, Settlement]] = {}
    last: dict[tuple[ShipId, ShipId], int] = {}
    over = []
    for index, frame in enumerate(frames):
        settled = {each.pair: each for each in frame.settlements}
        for pair in tuple(begun):
            none_again = pair in settled and not is_met(settled[pair])
            if none_again or (pair not in settled and index - last[pair] >= LOST_AFTER):
                over.append(_encounter(*begun.pop(pair), last[pair] + 1))
        for pair, settlement in settled.items():
            if is_met(settlement):
                begun.setdefault(pair, (index, settlement))
                last[pair] = index
    over.extend(_encounter(*start, last[pair] + 1) for pair, start in begun.items())
    return tuple(sorted(over, key=lambda each: (each.begin, each.ships)))


def _encounter(begin: int, first: Settlement, end: int) -> Encounter:
    view = first.one
    kind = Kind.GIVE_WAY if view.kind is Kind.STAND_ON else view.kind
    side_is_chosen = view.passing_side is not None and view.side_chosen_by in view.give_way
    return Encounter(
        ships=first.pair,
        begin=begin,
        end=end,
        geometry=first.geometry,
        kind=Kind.MUTUAL if first.fallback else kind,
        ruleset=view.ruleset,
        give_way=first.pair if first.fallback else view.give_way,
        stand_on=() if first.fallback else view.stand_on,
        article=view.article,
        passing_side=None if first.fallback else view.passing_side,
        side_to_follow=view.passing_required or side_is_chosen,
    )


def judge(
    encounter: Encounter, scenario: Scenario, frames: Sequence[Frame], lines: Mapping[ShipId, PathFrame]
) -> Judgement:
    """Judge one encounter by the definitions of risky, calm and faithful (contract).

    Beside a ship that does not cooperate nobody's faithfulness is judged.
    """
    plans = {plan.ship.id: plan for plan in scenario.ships}
    now = frames[encounter.begin]
    one, other = (
        undisturbed(plans[id_], now.ships[id_].pose, now.time, lines[id_]) for id_ in encounter.ships
    )
    left_alone = meeting(one, other)
    if left_alone is None:
        raise ValueError(f"{encounter.ships} were not under way together at frame {encounter.begin}")
    risky = left_alone.clearance <= RISKY_WITHIN
    faithful = None
    cooperate = all(plans[id_].control.by == COOPERATIVE for id_ in encounter.ships)
    if cooperate and risky and len(plans) == 2 and encounter.kind in (Kind.GIVE_WAY, Kind.MUTUAL):
        faithful = _faithful(encounter, plans, frames, lines, left_alone)
    return Judgement(risky=risky, calm=left_alone.clearance > CALM_BEYOND, faithful=faithful)


@dataclass(frozen=True, slots=True)
class _InForce:
    """What a ship did when the first verdict fell: the command of the period before."""

    offset: float  # [m]
    speed: float  # [m/s]


def _in_force(plan: Plan, frames: Sequence[Frame], index: int) -> _InForce:
    before = frames[index - 1].ships.get(plan.ship.id) if index else None
    return _InForce(before.offset, before.speed) if before else _InForce(0.0, plan.speed)


def has_acted(frames: Sequence[Frame], id_: ShipId) -> bool:
    """Whether a ship ever changed its offset or its speed so that others would see it."""
    before = _InForce(0.0, 0.0)
    return any(_acts(ship, before) for ship in states(frames, id_))


def _faithful(
    encounter: Encounter,
    plans: Mapping[ShipId, Plan],
    frames: Sequence[Frame],
    lines: Mapping[ShipId, PathFrame],
    left_alone: Meeting,
) -> bool:
    since = frames[encounter.begin :]
    in_force = {id_: _in_force(plans[id_], frames, encounter.begin) for id_ in encounter.ships}
    tcpa = _tcpa(*((since[0].ships[id_].pose, in_force[id_].speed) for id_ in encounter.ships))
    if tcpa <= 0.0:  # where a line bends, courses may part and the ships still meet
        tcpa = left_alone.time - since[0].time
    early = [frame for frame in since if frame.time < since[0].time + tcpa / 2.0]
    if not all(any(_acts(ship, in_force[id_]) for ship in states(early, id_)) for id_ in encounter.give_way):
        return False
    one, other = (track(plans[id_].ship, lines[id_], since) for id_ in encounter.ships)
    if encounter.kind is Kind.MUTUAL:
        return _passed_on(encounter.passing_side, one, other)
    if encounter.side_to_follow:
        return True
    bound = since[: _past_and_clear(one, other, since)]
    return all(_keeps(ship, in_force[id_]) for id_ in encounter.stand_on for ship in states(bound, id_))


def _acts(ship: ShipFrame, before: _InForce) -> bool:
    return abs(ship.offset - before.offset) > ACTING_OFFSET or ship.speed_factor < ACTING_FACTOR


def _keeps(ship: ShipFrame, before: _InForce) -> bool:
    return abs(ship.offset - before.offset) <= KEEPING_OFFSET and ship.speed_factor >= KEEPING_FACTOR


def _tcpa(one: tuple[NedPose, float], other: tuple[NedPose, float]) -> float:
    """Time to the closest approach of two centres at constant velocity [s]; negative when past."""
    (here, speed), (there, other_speed) = one, other
    away = np.array([there.x - here.x, there.y - here.y])
    drift = other_speed * _along(there.course) - speed * _along(here.course)
    squared = float(drift @ drift)
    return -float(away @ drift) / squared if squared > 0.0 else math.inf


def _along(course: float) -> FloatArray:
    return np.array([math.cos(course), math.sin(course)])


def _past_and_clear(one: Track, other: Track, frames: Sequence[Frame]) -> int:
    """Index of the frame at which hulls separate and clearance has grown for two periods."""
    pair = {one.ship.id, other.ship.id}
    times = np.array([frame.time for frame in frames if pair <= under_way(frame).keys()])
    apart = (other.at(times) - one.at(times))[:, :2]
    growing = (np.diff(clearances(one, other, times)) > 0.0) & (np.diff(np.hypot(*apart.T)) > 0.0)
    clear = np.flatnonzero(growing[1:] & growing[:-1])
    return int(clear[0]) + 2 if len(clear) else len(times)


def _passed_on(side: PassingSide | None, one: Track, other: Track) -> bool:
    """Whether each ship had the other on the prescribed side when their centres were closest."""
    signs = {PassingSide.PORT_TO_PORT: -1.0, PassingSide.STARBOARD_TO_STARBOARD: 1.0}
    if side not in signs:
        return True
    times = instants(one, other)
    here, there = one.at(times), other.at(times)
    closest = int(np.argmin(np.hypot(*(there - here)[:, :2].T)))
    pairs = ((here[closest], there[closest]), (there[closest], here[closest]))
    return all(signs[side] * _to_starboard(own, target) > 0.0 for own, target in pairs)


def _to_starboard(own: FloatArray, target: FloatArray) -> float:
    north, east = target[:2] - own[:2]
    return float(math.cos(own[2]) * east - math.sin(own[2]) * north)
