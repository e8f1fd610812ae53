"""What happened on a voyage, for the time line of a replay: each event with its instant, and in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ..frames import FloatArray
from ..ships import ShipId
from .replay_ships import PARTS, Sailed
from .run_reading import Run

Spans = Sequence[tuple[int, int, int]]  # first frame, frame after the last, number of the verdict


def told_events(
    run: Run,
    ships: Sequence[Sailed],
    times: Sequence[float],
    verdicts: Sequence[Mapping[str, Any]],
    spans: Spans,
    clearances: Mapping[ShipId, FloatArray],
) -> list[dict[str, Any]]:
    """Tell events in the order of their instants: `time_s`, `kind`, `ships`, `text`.

    The kinds are switch, deadlock, fallback, command (one that is not the solver's), collision, closest,
    arrival and end.
    """
    found = [
        *_switches(ships),
        *_deadlocks(run, times, verdicts, spans),
        *_fallbacks(times, verdicts, spans),
        *_commands(run),
        *_approaches(times, clearances),
        *_ends(run, ships, times),
    ]
    return sorted(found, key=lambda event: float(event["time_s"]))


def _event(time: float, kind: str, ships: Sequence[str], text: str) -> dict[str, Any]:
    return {"time_s": time, "kind": kind, "ships": list(ships), "text": text}


def _switches(ships: Sequence[Sailed]) -> Iterator[dict[str, Any]]:
    for ship in ships:
        for before, row in pairwise(ship.rows):
            if before.ruleset and row.ruleset and before.ruleset != row.ruleset:
                text = f"{row.ship} goes from {before.ruleset} to {row.ruleset}"
                yield _event(row.time, "switch", [row.ship], text)


def _deadlocks(
    run: Run, times: Sequence[float], verdicts: Sequence[Mapping[str, Any]], spans: Spans
) -> Iterator[dict[str, Any]]:
    """Rings as the summary has them; without one, pairs whose edge was opened, each once."""
    if run.summary is not None:
        told = run.summary.get("deadlocks")
        for each in told if isinstance(told, list) else ():
            how = ", ".join(sorted({str(criterion) for _, _, criterion in each["opened"]}))
            text = f"{_listed(each['ships'])} wait for one another; opened by: {how}"
            yield _event(float(each["time_s"]), "deadlock", each["ships"], text)
        return
    seen: set[tuple[str, ...]] = set()
    for first, _, number in spans:
        verdict = verdicts[number]
        pair = tuple(verdict["pair"])
        if verdict["opened"] and pair not in seen:
            seen.add(pair)
            text = f"an order between {_listed(pair)} is opened by: {', '.join(verdict['opened'])}"
            yield _event(times[first], "deadlock", pair, text)


def _fallbacks(
    times: Sequence[float], verdicts: Sequence[Mapping[str, Any]], spans: Spans
) -> Iterator[dict[str, Any]]:
    """Pairs that come to the safe mutual rule, or come to it for another reason."""
    until: dict[tuple[tuple[str, ...], str], int] = {}
    for first, after, number in spans:
        verdict = verdicts[number]
        if verdict["fallback"]:
            key = tuple(verdict["pair"]), verdict["fallback"]
            if until.get(key) != first:
                text = f"{_listed(key[0])} fall back to the safe mutual rule: {key[1]}"
                yield _event(times[first], "fallback", key[0], text)
            until[key] = after


def _commands(run: Run) -> Iterator[dict[str, Any]]:
    """Ships whose command is not the solver's."""
    before: dict[str, str] = {}
    for told in run.plans:
        ships: Any = told["ships"]
        now = {id_: str(plan["why"]) for id_, plan in ships.items() if plan.get("why")}
        for id_, why in now.items():
            if before.get(id_) != why:
                time: Any = told["time_s"]
                yield _event(float(time), "command", [id_], f"{id_} does not follow its solver: {why}")
        before = now


def _approaches(times: Sequence[float], clearances: Mapping[ShipId, FloatArray]) -> Iterator[dict[str, Any]]:
    """Where ships come closest, and each time that hulls touch."""
    instants = [
        begin + (end - begin) * part / PARTS
        for begin, end in pairwise([*times, times[-1]])
        for part in range(PARTS)
    ]
    table = np.array([*clearances.values()])
    if not np.any(np.isfinite(table)):
        return
    least = np.nanmin(table)
    for part in map(int, np.flatnonzero(np.any(table == 0.0, axis=0))):
        touching = [id_ for id_, each in clearances.items() if each[part] == 0.0]
        before = [id_ for id_, each in clearances.items() if part and each[part - 1] == 0.0]
        if set(touching) - set(before):
            yield _event(instants[part], "collision", touching, f"{_listed(touching)} collide")
    if least > 0.0:
        first = int(np.flatnonzero(np.any(table <= least, axis=0))[0])
        near = [id_ for id_, each in clearances.items() if each[first] <= least + 1e-6]
        text = f"closest approach: {_listed(near)}, {least:.1f} m between the hulls"
        yield _event(round(instants[first], 1), "closest", near, text)


def _ends(run: Run, ships: Sequence[Sailed], times: Sequence[float]) -> Iterator[dict[str, Any]]:
    summary = run.summary or {}
    told = summary.get("ships")
    arrived = {id_ for id_, each in (told if isinstance(told, dict) else {}).items() if each["arrived"]}
    for ship in ships:
        if ship.ship.id in arrived:
            yield _event(ship.rows[-1].time, "arrival", [ship.ship.id], f"{ship.ship.id} is about to arrive")
    if run.summary is None or summary.get("interrupted"):
        yield _event(times[-1], "end", [], "the run was broken off here")


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:-1]) + " and " + names[-1] if len(names) > 1 else "".join(names)
