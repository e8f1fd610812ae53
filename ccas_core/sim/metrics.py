"""What a voyage came to: safety index (Sec. 5.2), clearances, delays, deadlocks, `summary.json`.

Pure functions of a scenario and its frames.
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

from ..controllers import TRACKED
from ..frames import FloatArray, NedPose, NedTrajectory, PathFrame
from ..priority import Opening, PriorityGraph
from ..ships import Ship, ShipId
from ..waterway import guiding_line
from .conduct import Encounter, Judgement, encounters, judge
from .domain_meetings import Nearness, nearnesses
from .frame import Frame
from .hulls import Meeting, is_grounded, meetings, obstacles_struck, states, track, under_way
from .remarks import remark_entry, remarks
from .scenario import Scenario

SCHEMA: Final = "ccas/summary@1"
FROZEN_AFTER: Final = 20  # delay of a frozen ship, in periods


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
        asked = plan.control.by != TRACKED  # whoever is not asked is not frozen either
        own = np.array([each == id_ for _, each, _ in rows], dtype=np.bool_)
        sailed = list(states(frames, id_))
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
            frozen=asked and (delay is None or delay > FROZEN_AFTER * scenario.time_step),
        )
    return metrics


def _least(values: Iterable[float | None]) -> float | None:
    return min((value for value in values if value is not None), default=None)


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
        "domains": [_domain_entry(each) for each in nearnesses(scenario, frames)],
        "remarks": [remark_entry(each) for each in remarks(frames)],
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


def _domain_entry(nearness: Nearness) -> dict[str, object]:
    return {
        "ships": nearness.ships,
        "min_distance_m": nearness.least,
        "overlap": nearness.overlap,
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
