"""What a voyage came to: safety index (Sec. 5.2), clearances, encounters, delays, `summary.json`.

Pure functions of a scenario and its frames.  *In force* at a frame is the command of the frame before;
at the first frame, the undisturbed one: no offset, nominal speed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..frames import FloatArray, NedPose, NedTrajectory, PathFrame, PathTrajectory
from ..priority import Opening, PriorityGraph, Settlement
from ..roles import Geometry, PassingSide
from ..ships import Ship, ShipId
from ..verdict import Kind
from ..waterway import guiding_line
from .frame import Frame, ShipFrame
from .hulls import (
    STEP,
    Meeting,
    Track,
    clearances,
    instants,
    is_grounded,
    meeting,
    meetings,
    obstacles_struck,
    track,
    under_way,
)
from .scenario import Plan, Scenario

SCHEMA: Final = "ccas/summary@1"
RISKY_WITHIN: Final = 10.0  # undisturbed clearance of a risky encounter [m]
CALM_BEYOND: Final = 50.0  # undisturbed clearance of a calm encounter [m]
ACTING_OFFSET: Final = 10.0  # change of offset that counts as acting [m]
ACTING_FACTOR: Final = 0.9  # speed factor below which a ship acts
KEEPING_OFFSET: Final = 5.0  # change of offset that a stand-on ship is allowed [m]
KEEPING_FACTOR: Final = 0.95  # least speed factor of a stand-on ship
FROZEN_AFTER: Final = 20  # delay of a frozen ship, in periods
LOST_AFTER: Final = 2  # periods without a settlement that end an encounter


@dataclass(frozen=True, slots=True, kw_only=True)
class ShipMetrics:
    """One ship's voyage in numbers; None where not defined."""

    min_clearance: float | None  # [m]
    min_safety_index: float | None  # [m]
    max_offset_change: float  # greatest commanded offset from its guiding line [m]
    min_speed_factor: float
    delay: float | None  # [s]
    frozen: bool


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Deadlock:
    """A ring of ships that waited for one another, and how it was opened at first."""

    time: float  # [s]
    ships: tuple[ShipId, ...]
    openings: tuple[Opening, ...]


def guiding_frames(scenario: Scenario) -> dict[ShipId, PathFrame]:
    """Path frame {w_i} of every ship of a scenario."""
    return {plan.ship.id: guiding_line(scenario.waters, plan.route).frame for plan in scenario.ships}


def safety_indices(
    poses: Mapping[ShipId, NedPose], ships: Mapping[ShipId, Ship], lines: Mapping[ShipId, PathFrame]
) -> dict[ShipId, float | None]:
    """Safety index of every ship at one instant [m]; None for a ship alone.

    epsilon_i = min_j max(|x_ii - x_ji| - d_x, |y_ii - y_ji| - d_y) in {w_i}, with d_x and d_y half the
    length and width of the safety area (51.5 m and 8.6 m in the paper).
    """
    table = np.array([[pose.x, pose.y, pose.course] for pose in poses.values()]).reshape(-1, 3)
    whose, when = np.arange(len(poses)), np.zeros(len(poses), dtype=np.intp)
    return {
        id_: _least_index(ships[id_], lines[id_], whose == row, when, table) for row, id_ in enumerate(poses)
    }


def _least_index(
    ship: Ship, line: PathFrame, own: NDArray[np.bool_], when: NDArray[np.intp], poses: FloatArray
) -> float | None:
    """Least index of the `own` rows among rows of poses (m, 3); `when` tells the instants apart."""
    seen = line.trajectory_to_path(NedTrajectory(poses)).poses[:, :2]
    here = np.full((int(when.max(initial=0)) + 1, 2), np.nan)
    here[when[own]] = seen[own]
    away = np.abs(seen - here[when])
    beside = np.maximum(away[:, 0] - ship.hull.safety_length / 2.0, away[:, 1] - ship.hull.safety_beam / 2.0)
    beside = beside[~own & ~np.isnan(beside)]
    return float(beside.min()) if len(beside) else None


def arrivals(frames: Sequence[Frame]) -> dict[ShipId, float]:
    """Time at which each arrived ship crossed the end of its route [s]."""
    return {id_: time for frame in frames for id_, time in frame.arrived.items()}


def ship_metrics(
    scenario: Scenario, frames: Sequence[Frame], lines: Mapping[ShipId, PathFrame], met: Sequence[Meeting]
) -> dict[ShipId, ShipMetrics]:
    """Every ship's voyage in numbers."""
    arrived = arrivals(frames)
    rows = [(k, id_, ship.pose) for k, frame in enumerate(frames) for id_, ship in under_way(frame).items()]
    when = np.array([k for k, _, _ in rows], dtype=np.intp)
    poses = np.array([[pose.x, pose.y, pose.course] for _, _, pose in rows]).reshape(-1, 3)
    metrics = {}
    for plan in scenario.ships:
        id_ = plan.ship.id
        own = np.array([each == id_ for _, each, _ in rows], dtype=np.bool_)
        sailed = list(_rows(frames, id_))
        delay = None
        if id_ in arrived:
            left = lines[id_].length - lines[id_].to_path(plan.start).x
            delay = arrived[id_] - frames[0].time - left / plan.speed
        metrics[id_] = ShipMetrics(
            min_clearance=_least(each.clearance for each in met if id_ in each.pair),
            min_safety_index=_least_index(plan.ship, lines[id_], own, when, poses),
            max_offset_change=max((abs(ship.offset) for ship in sailed), default=0.0),
            min_speed_factor=min((ship.speed_factor for ship in sailed), default=1.0),
            delay=delay,
            frozen=delay is None or delay > FROZEN_AFTER * scenario.time_step,
        )
    return metrics


def _least(values: Iterable[float | None]) -> float | None:
    return min((value for value in values if value is not None), default=None)


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
    """Judge one encounter by the definitions of risky, calm and faithful (contract)."""
    plans = {plan.ship.id: plan for plan in scenario.ships}
    one, other = (_undisturbed(plans[id_], frames[encounter.begin], lines[id_]) for id_ in encounter.ships)
    undisturbed = meeting(one, other)
    if undisturbed is None:
        raise ValueError(f"{encounter.ships} were not under way together at frame {encounter.begin}")
    risky = undisturbed.clearance <= RISKY_WITHIN
    faithful = None
    if risky and len(plans) == 2 and encounter.kind in (Kind.GIVE_WAY, Kind.MUTUAL):
        faithful = _faithful(encounter, plans, frames, lines, undisturbed)
    return Judgement(risky=risky, calm=undisturbed.clearance > CALM_BEYOND, faithful=faithful)


def _undisturbed(plan: Plan, frame: Frame, line: PathFrame) -> Track:
    """Sail on from a frame beside the guiding line, at the present offset and nominal speed, to its end."""
    now = frame.ships[plan.ship.id]
    here = line.to_path(now.pose)
    steps = max(0, math.ceil((line.length - here.x) / plan.speed / STEP))
    times = STEP * np.arange(steps + 1, dtype=np.float64)
    x = np.minimum(here.x + plan.speed * times, max(line.length, here.x))
    path = np.column_stack([x, np.full_like(x, here.y), np.zeros_like(x)])
    poses = line.trajectory_to_ned(PathTrajectory(path)).poses
    return Track(ship=plan.ship, times=frame.time + times, poses=poses)


@dataclass(frozen=True, slots=True)
class _InForce:
    """What a ship did when the first verdict fell: the command of the period before."""

    offset: float  # [m]
    speed: float  # [m/s]


def _in_force(plan: Plan, frames: Sequence[Frame], index: int) -> _InForce:
    before = frames[index - 1].ships.get(plan.ship.id) if index else None
    return _InForce(before.offset, before.speed) if before else _InForce(0.0, plan.speed)


def _faithful(
    encounter: Encounter,
    plans: Mapping[ShipId, Plan],
    frames: Sequence[Frame],
    lines: Mapping[ShipId, PathFrame],
    undisturbed: Meeting,
) -> bool:
    since = frames[encounter.begin :]
    in_force = {id_: _in_force(plans[id_], frames, encounter.begin) for id_ in encounter.ships}
    tcpa = _tcpa(*((since[0].ships[id_].pose, in_force[id_].speed) for id_ in encounter.ships))
    if tcpa <= 0.0:  # where a line bends, courses may part and the ships still meet
        tcpa = undisturbed.time - since[0].time
    early = [frame for frame in since if frame.time < since[0].time + tcpa / 2.0]
    if not all(any(_acts(ship, in_force[id_]) for ship in _rows(early, id_)) for id_ in encounter.give_way):
        return False
    one, other = (track(plans[id_].ship, lines[id_], since) for id_ in encounter.ships)
    if encounter.kind is Kind.MUTUAL:
        return _passed_on(encounter.passing_side, one, other)
    if encounter.side_to_follow:
        return True
    bound = since[: _past_and_clear(one, other, since)]
    return all(_keeps(ship, in_force[id_]) for id_ in encounter.stand_on for ship in _rows(bound, id_))


def _rows(frames: Iterable[Frame], id_: ShipId) -> Iterator[ShipFrame]:
    return (ships[id_] for frame in frames if id_ in (ships := under_way(frame)))


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


def deadlocks(frames: Sequence[Frame], masses: Mapping[ShipId, float]) -> tuple[Deadlock, ...]:
    """Rings of ships that waited for one another, each told once, when it was first opened."""
    found: list[Deadlock] = []
    before: set[tuple[ShipId, ...]] = set()
    for frame in frames:
        rings = PriorityGraph(masses=masses, settlements=frame.settlements).cycles() if frame.openings else ()
        now: dict[tuple[ShipId, ...], list[Opening]] = {}
        for opening in dict.fromkeys(frame.openings):  # each of the ships may tell it
            ends = tuple(sorted((opening.edge.first, opening.edge.then)))
            ring = next((ring for ring in rings if set(ends) <= set(ring)), ends)
            now.setdefault(ring, []).append(opening)
        found.extend(
            Deadlock(time=frame.time, ships=ring, openings=tuple(openings))
            for ring, openings in now.items()
            if ring not in before
        )
        before = set(now)
    return tuple(found)


def summary(scenario: Scenario, frames: Sequence[Frame], solver: str) -> dict[str, object]:
    """Summarise a voyage as in `summary.json` (contract); null where a number is not defined."""
    if not frames:
        raise ValueError("a voyage without frames has no summary")
    lines = guiding_frames(scenario)
    sailing = {id_ for frame in frames for id_ in under_way(frame)}
    ships = [plan.ship for plan in scenario.ships]
    sailed = [track(ship, lines[ship.id], frames) for ship in ships if ship.id in sailing]
    masses = {ship.id: ship.mass for ship in ships}
    met = meetings(sailed)
    metrics = ship_metrics(scenario, frames, lines, met)
    banks = scenario.waters.banks()
    indices = (ship.min_safety_index for ship in metrics.values())
    found = {
        "schema": SCHEMA,
        "scenario": scenario.name,
        "solver": solver,
        "collisions": sum(each.collision for each in met),
        "entries": sum(each.entry for each in met),
        "groundings": sum(is_grounded(each, banks) for each in sailed),
        "allisions": sum(len(obstacles_struck(each, scenario.waters.obstacles)) for each in sailed),
        "frozen": sum(ship.frozen for ship in metrics.values()),
        "min_clearance_m": min((each.clearance for each in met), default=None),
        "min_safety_index_m": _least(indices),
        "ships": {id_: _ship_entry(ship) for id_, ship in metrics.items()},
        "encounters": [
            _encounter_entry(each, judge(each, scenario, frames, lines)) for each in encounters(frames)
        ],
        "ruleset_switches": list(_switches(frames)),
        "deadlocks": [_deadlock_entry(each) for each in deadlocks(frames, masses)],
        "update_ms": _update_ms(frames),
    }
    return {key: plain(value) for key, value in found.items()}


def _ship_entry(ship: ShipMetrics) -> dict[str, object]:
    return {
        "min_clearance_m": ship.min_clearance,
        "min_safety_index_m": ship.min_safety_index,
        "max_offset_change_m": ship.max_offset_change,
        "min_speed_factor": ship.min_speed_factor,
        "delay_s": ship.delay,
        "arrived": ship.delay is not None,
        "frozen": ship.frozen,
    }


def _encounter_entry(encounter: Encounter, judgement: Judgement) -> dict[str, object]:
    return {
        "ships": encounter.ships,
        "geometry": encounter.geometry,
        "kind": encounter.kind,
        "ruleset": encounter.ruleset,
        "give_way": encounter.give_way,
        "stand_on": encounter.stand_on,
        "article": encounter.article,
        "risky": judgement.risky,
        "faithful": judgement.faithful,
        "calm": judgement.calm,
    }


def _deadlock_entry(deadlock: Deadlock) -> dict[str, object]:
    return {
        "time_s": deadlock.time,
        "ships": deadlock.ships,
        "opened": [(each.edge.first, each.edge.then, each.criterion) for each in deadlock.openings],
    }


def _switches(frames: Sequence[Frame]) -> Iterator[dict[str, object]]:
    for before, after in pairwise(frames):
        old, new = under_way(before), under_way(after)
        for id_ in sorted(old.keys() & new.keys()):
            if old[id_].ruleset != new[id_].ruleset:
                yield {
                    "ship": id_,
                    "time_s": after.time,
                    "from": old[id_].ruleset,
                    "to": new[id_].ruleset,
                }


def _update_ms(frames: Sequence[Frame]) -> dict[str, float | None]:
    times = [ms for frame in frames for ship in frame.ships.values() for ms in ship.update_ms]
    if not times:
        return {"median": None, "p99": None, "max": None}
    median, p99, most = np.percentile(times, [50.0, 99.0, 100.0])
    return {"median": float(median), "p99": float(p99), "max": float(most)}


def plain(value: object) -> object:
    """Value as JSON can hold it: null for a number that is not finite, lists for tuples.

    >>> plain({"tcpa_s": math.inf, "ships": ("a", "b")})
    {'tcpa_s': None, 'ships': ['a', 'b']}
    """
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    if isinstance(value, Enum):
        return value.value
    return None if isinstance(value, float) and not math.isfinite(value) else value
