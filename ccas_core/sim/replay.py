"""What a replay shows, as plain data: `replay_page` puts it into a page, whose script draws it.

Numbers are whole, and those that run along a voyage are differences from one to the next, so that a page is
small.  The names say the units; points are east and north, one after the other.  Frames are counted from 0:
`times_s` has the instant of each, and what is decided in one holds until the next.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from ..frames import FloatArray
from ..regions import Region
from ..ships import ShipId
from ..waterway import Waters
from .replay_events import told_events
from .replay_ships import DECIMETRES, Sailed, clearances, frame_times, refusal, sailed_ships, told_ship
from .run_folder import DECISIONS, PLANS, SUMMARY
from .run_reading import Run
from .scenario import Scenario

FORMAT: Final = "ccas/replay@1"
MOST_PLANS: Final = 20_000  # rows of ships at instants, with plans
_BEND: Final = 0.3  # of a bank, within which it is drawn straight [m]


def replay(scenario: Scenario, run: Run, folder: Path) -> dict[str, Any]:
    """Gather what a replay shows; `folder` is named where something in it cannot be understood.

    Raises
    ------
    InputError
        If nothing was sailed, if there is more than a page can show, or if the files do not fit together.
    """
    times = frame_times(run.rows, folder)
    ships = sailed_ships(scenario, run.rows, times, folder)
    apart = clearances(ships, times)
    verdicts, spans = _duties(run, times, {each.ship.id for each in ships}, folder)
    rulesets = list(
        dict.fromkeys(
            [
                *(law.ruleset for law in scenario.waters.laws.laws),
                *(row.ruleset for row in run.rows if row.ruleset),
            ]
        )
    )
    plans = _plans(run, times, ships, folder)
    try:
        events = told_events(run, ships, times, verdicts, spans, apart)
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        what = {"expected": "ships with `arrived`, deadlocks with `time_s`, `ships`, `opened`"}
        raise refusal(folder / SUMMARY, 1, message="cannot be understood", **what) from error
    return {
        "format": FORMAT,
        "name": scenario.name,
        "title": scenario.title,
        "description": scenario.description,
        "complete": run.summary is not None and not run.summary.get("interrupted"),
        "step_s": scenario.time_step,
        "times_s": times,
        "rulesets": rulesets,
        "waters": _waters(scenario.waters, rulesets),
        "ships": [told_ship(each, apart[each.ship.id], rulesets) for each in ships],
        "verdicts": verdicts,
        "spans": spans,
        "plans": plans if len(run.rows) <= MOST_PLANS else [],
        "events": events,
    }


# --- who gives way to whom ------------------------------------------------------------------------


def _duties(
    run: Run, times: Sequence[float], ships: set[ShipId], folder: Path
) -> tuple[list[dict[str, Any]], list[tuple[int, int, int]]]:
    """Different verdicts, and spans in which one held: first frame, frame after the last, its number."""
    index = {round(time, 3): number for number, time in enumerate(times)}
    numbers: dict[str, int] = {}
    verdicts: list[dict[str, Any]] = []
    open_: dict[tuple[str, str], list[int]] = {}
    spans: list[list[int]] = []
    for line, decision in enumerate(run.decisions, start=1):
        try:
            time, pair = round(float(decision["time_s"]), 3), _pair(decision)  # type: ignore[arg-type]
            told = _verdict(decision, pair)
        except (AttributeError, KeyError, TypeError, ValueError, IndexError) as error:
            raise refusal(
                folder / DECISIONS,
                line,
                message="cannot be understood",
                expected="a decision: time_s, pair, verdicts of both views, applied",
            ) from error
        if time not in index or not set(pair) <= ships:
            continue  # frames.csv was cut short, or the ship has arrived
        if not told:
            continue
        number = numbers.setdefault(repr(told), len(verdicts))
        if number == len(verdicts):
            verdicts.append(told)
        frame, last = index[time], open_.get(pair)
        if last and last[1] == frame and last[2] == number:
            last[1] = frame + 1
        else:
            spans.append([frame, frame + 1, number])
            open_[pair] = spans[-1]
    return verdicts, [(first, after, number) for first, after, number in spans]


def _pair(decision: Mapping[str, Any]) -> tuple[ShipId, ShipId]:
    one, other = decision["pair"]
    return ShipId(one), ShipId(other)


def _verdict(decision: Mapping[str, Any], pair: tuple[ShipId, ShipId]) -> dict[str, Any]:
    """What a decision says, for people; nothing where the pair is not in an encounter."""
    views = [decision["verdicts"][id_] for id_ in pair]
    fallback = decision["applied"] == "fallback"
    edge = decision.get("edge") or {}
    gives_way = list(pair) if fallback else [ShipId(id_) for id_ in views[0]["give_way"]]
    if not fallback and views[0]["kind"] == "none":
        return {}
    return {
        "pair": list(pair),
        "gives_way": gives_way,
        "first": edge.get("first"),
        "dashed": edge.get("kind") == "order",
        "kind": views[0]["kind"],
        "geometry": decision["geometry"],
        "fallback": (decision.get("why") or "views differ") if fallback else "",
        "opened": sorted({criterion for _, _, criterion in decision.get("opened", ())}),
        "views": [_view(each) for each in (views if fallback else views[:1])],
    }


def _view(verdict: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "kind": verdict["kind"],
        "pass": verdict["pass"],
        "article": verdict["article"],
        "ruleset": verdict["ruleset"],
        "version": verdict["version"],
        "reason": verdict.get("reason") or "",
    }


# --- plans ----------------------------------------------------------------------------------------


def _plans(run: Run, times: Sequence[float], ships: Sequence[Sailed], folder: Path) -> list[dict[str, Any]]:
    """Plans, one mapping a frame, a ship's by its place: seconds, east, north of the first point, then on."""
    index = {round(time, 3): number for number, time in enumerate(times)}
    place = {each.ship.id: str(number) for number, each in enumerate(ships)}
    found: list[dict[str, Any]] = [{} for _ in times] if run.plans else []
    for line, told in enumerate(run.plans, start=1):
        try:
            frame = index.get(round(float(told["time_s"]), 3))  # type: ignore[arg-type]
            for id_, plan in told["ships"].items():  # type: ignore[attr-defined]
                points = np.array([plan["after_s"], plan["east_m"], plan["north_m"]], dtype=np.float64).T
                if not len(points) or not np.all(np.isfinite(points)):
                    raise ValueError("no points, or not numbers")  # noqa: TRY301
                if frame is not None and id_ in place:
                    whole = np.rint(points * [1.0, DECIMETRES, DECIMETRES]).astype(int)
                    steps = np.diff(whole, axis=0, prepend=0)
                    found[frame][place[id_]] = steps.ravel().tolist()
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise refusal(
                folder / PLANS,
                line,
                message="cannot be understood",
                expected="time_s, and of each ship after_s, east_m, north_m",
                hint="without this file the run is shown without plans",
            ) from error
    return found


# --- waters ---------------------------------------------------------------------------------------


def _waters(waters: Waters, rulesets: Sequence[str]) -> dict[str, Any]:
    banks = waters.banks()
    parts = [part for part in getattr(banks, "geoms", [banks]) if not part.is_empty]
    return {
        "ruleset": rulesets.index(waters.laws.laws[0].ruleset),
        "banks": [
            [_outline(ring.simplify(_BEND).coords) for ring in (part.exterior, *part.interiors)]
            for part in parts
        ],
        "waterways": [
            {"id": each.id, "upstream": str(each.upstream), "centreline_dm": _outline(each.centreline)}
            for each in waters.waterways
        ],
        "regions": [_region(each, banks, rulesets) for each in waters.laws.regions],
        "obstacles": [
            {"id": each.id, "at_dm": _outline([(each.x, each.y)]), "radius_m": each.radius}
            for each in waters.obstacles
        ],
    }


def _region(region: Region, banks: Any, rulesets: Sequence[str]) -> dict[str, Any]:  # noqa: ANN401
    wet = region.shape.intersection(banks)
    middle = (region.shape if wet.is_empty else wet).representative_point()
    return {
        "id": region.id,
        "ruleset": rulesets.index(region.law.ruleset),
        "polygon_dm": _outline(region.polygon),
        "label_dm": _outline([(middle.x, middle.y)]),
    }


def _outline(points: Iterable[Sequence[float]] | FloatArray) -> list[int]:
    """Points (n, 2), north and east, as east and north in decimetres, one after the other."""
    table = np.array([(point[1], point[0]) for point in points], dtype=np.float64)
    return [int(each) for each in np.rint(table * DECIMETRES).ravel()]
