"""A moment of a voyage, from its run folder: what was decided, and what that rested on.

The facts are computed again from the poses in `frames.csv`, period by period, so that what the ships
remembered is remembered here, too.  Where that does not lead to what was recorded, only the record is told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ccas_core.errors import Diagnostic, InputError
from ccas_core.ships import ShipId

from .meetings import Meeting, checked, in_situation

if TYPE_CHECKING:
    from ccas_core.plugins import Plugins
    from ccas_core.priority import Settlement
    from ccas_core.sim.run_reading import Row, Run
    from ccas_core.sim.scenario import Scenario
    from ccas_core.tapd.aboard import Aboard
    from ccas_core.tapd.ruleset import Pair, Situation
    from ccas_core.waterway import GuidingLine
    from ccas_core.world import World

_REMEMBERED = "the encounter is remembered from its beginning, not recognised anew"
_TOLD = ("kind", "rule", "article", "confidence", "ruleset", "version", "reason", "facts")
_SAME = 1e-6  # instants that lie no farther apart are one [s]


def of_run(folder: Path, time: float | None, plugins: Plugins, pair: tuple[str, str] | None) -> list[Meeting]:
    """Pairs at the last period that began at a time or before it.

    Raises
    ------
    InputError
        If the folder holds no run, or the time lies outside of it.
    """
    from ccas_core.sim.run_reading import read_run

    run = read_run(folder)
    began = _began(run, folder, time)
    present = sorted({row.ship for row in run.rows if abs(row.time - began) < _SAME})
    wanted = checked(pair, present)
    recorded = _recorded(run, folder, began)
    pairs = [each for each in combinations(present, 2) if each in recorded or wanted == set(each)]
    pairs = [each for each in pairs if wanted in (None, set(each))]
    heading = f"at {began:g} s"
    try:
        again = _recomputed(run, folder, began, pairs, plugins)
    except InputError as error:
        told = str(error).splitlines()[0]
        note = f"only what was recorded is told, for the scenario cannot be used: {told}"
        return [_as_recorded(each, recorded.get(each), heading, note) for each in pairs]
    return [_compared(meeting, recorded.get(meeting.pair), heading) for meeting in again]


def _began(run: Run, folder: Path, time: float | None) -> float:
    times = sorted({row.time for row in run.rows})
    if not times:
        raise InputError(Diagnostic(source=str(folder), message="the run has no frames"))
    expected = f"a time from {times[0]:g} to {times[-1]:g} s"
    if time is None:
        message = "a run is a voyage: say when"
        raise InputError(Diagnostic(source="--time", message=message, expected=expected))
    if not times[0] - _SAME <= time <= times[-1] + _SAME:
        message = f"nothing was sailed at {time:g} s"
        raise InputError(Diagnostic(source="--time", message=message, expected=expected))
    return max(each for each in times if each <= time + _SAME)


def _recorded(run: Run, folder: Path, began: float) -> dict[tuple[ShipId, ...], Mapping[str, Any]]:
    """Decisions of a period, by the pair."""
    from ccas_core.sim.run_folder import DECISIONS

    found: dict[tuple[ShipId, ...], Mapping[str, Any]] = {}
    for number, each in enumerate(run.decisions, start=1):
        told: Mapping[str, Any] = each
        try:
            if abs(float(told["time_s"]) - began) < _SAME:
                pair = tuple(map(ShipId, told["pair"]))
                for ship in pair:
                    _ = [told["verdicts"][ship][key] for key in _TOLD]
                found[pair] = told
        except (KeyError, TypeError, ValueError):
            source = str(folder / DECISIONS)
            expected = "a line as `ccas simulate` writes it"
            message = "cannot be understood"
            raise InputError(
                Diagnostic(source=source, line=number, column=1, message=message, expected=expected)
            ) from None
    return found


def _as_recorded(
    pair: tuple[ShipId, ShipId], told: Mapping[str, Any] | None, heading: str, note: str
) -> Meeting:
    about = {"recomputed": False}
    return Meeting(
        pair=pair, settlement=None, sides={}, told=told or {}, about=about, heading=heading, notes=(note,)
    )


def _compared(meeting: Meeting, told: Mapping[str, Any] | None, heading: str) -> Meeting:
    """Keep what was computed again where it says the same as the record."""
    settlement = meeting.settlement
    assert settlement is not None  # noqa: S101 - it has just been made
    if told is None:
        note = "no decision is recorded: they did not meet"
        return replace(meeting, heading=heading, notes=(note,), about={"recomputed": True})
    verdicts = told["verdicts"]
    same = all(
        (verdicts[each.own]["kind"], verdicts[each.own]["rule"]) == (each.kind, each.rule)
        for each in (settlement.one, settlement.other)
    )
    if same:
        notes = (_REMEMBERED,) if meeting.sides[settlement.one.own].is_remembered else ()
        return replace(meeting, told=told, heading=heading, notes=notes, about={"recomputed": True})
    views = (settlement.one, settlement.other)
    got = ", ".join(f"{each.own} {each.kind} by {each.rule or 'no rule'}" for each in views)
    note = f"only what was recorded is told: computed again from frames.csv, it would be {got}"
    return _as_recorded(meeting.pair, told, heading, note)


def _recomputed(
    run: Run, folder: Path, began: float, pairs: Sequence[tuple[ShipId, ShipId]], plugins: Plugins
) -> list[Meeting]:
    """Sail along with the ships of some pairs, as far as their memory goes."""
    from ccas_core.priority import PriorityGraph
    from ccas_core.sim.run_folder import SCENARIO
    from ccas_core.sim.scenario_file import parse_scenario
    from ccas_core.sim.start import rulesets_aboard
    from ccas_core.tapd.ruleset import Situation
    from ccas_core.waterway import guiding_line

    scenario = parse_scenario(
        run.scenario,
        str(folder / SCENARIO),
        plugins.rulesets,
        regions=plugins.regions,
        vocabulary=plugins.vocabulary,
        controllers=plugins.controllers,
    )
    ships = {ship for pair in pairs for ship in pair}
    rows: dict[float, list[Row]] = {}
    for row in run.rows:
        if row.ship in ships and row.time <= began + _SAME:
            rows.setdefault(row.time, []).append(row)
    last: list[Settlement] = []
    plans = [plan for plan in scenario.ships if plan.ship.id in ships]
    lines = {plan.ship.id: guiding_line(scenario.waters, plan.route) for plan in plans}
    if unknown := sorted(ships - lines.keys()):
        message = f"does not have ship '{unknown[0]}', which was sailed"
        raise InputError(Diagnostic(source=str(folder / SCENARIO), message=message))
    carried = rulesets_aboard(scenario, plugins.rulesets)
    before = Situation(world=_world(scenario, lines, [], {}))
    now = before
    sailed: dict[ShipId, float] = {}  # speed of each ship in the period before [m/s]
    for _, present in sorted(rows.items()):
        now = replace(before, world=_world(scenario, lines, present, sailed))
        sailed = {row.ship: row.speed for row in present}  # under the command that was given then
        there = [pair for pair in pairs if set(pair) <= now.world.reports.keys()]
        last, encounters = _judged(now, there, carried)
        kept = now.on_starboard_side(plugins.vocabulary)
        before = Situation(world=now.world, encounters=encounters, kept_starboard=kept)
    fresh = Situation(world=now.world, kept_starboard=now.kept_starboard)
    masses = {ship: report.ship.mass for ship, report in now.world.reports.items()}
    graph = PriorityGraph(masses=masses, settlements=tuple(last))
    return [in_situation(each, now, fresh, carried, graph) for each in last]


def _judged(
    now: Situation, pairs: Sequence[tuple[ShipId, ShipId]], carried: Mapping[ShipId, Aboard]
) -> tuple[list[Settlement], dict[Pair, Any]]:
    """Verdicts of a period, and what is remembered of the pairs after it."""
    from ccas_core.priority import settle
    from ccas_core.tapd.assign import judged_by_law, remembered
    from ccas_core.tapd.encounters import NO_ENCOUNTER

    reports = now.world.reports
    masses = {ship: report.ship.mass for ship, report in reports.items()}
    settlements, encounters = [], {}
    for one, other in pairs:
        mine = judged_by_law(carried[one], now, one, other)
        theirs = judged_by_law(carried[other], now, other, one)
        settlements.append(settle(mine, theirs, masses))
        pair, encounter = remembered(now, mine, theirs)
        if encounter is not NO_ENCOUNTER:
            encounters[pair] = encounter
    return settlements, encounters


def _world(
    scenario: Scenario,
    lines: Mapping[ShipId, GuidingLine],
    rows: Sequence[Row],
    sailed: Mapping[ShipId, float],
) -> World:
    """Chart and reports of some ships where a frame has them, at the speed of the period before."""
    from ccas_core.frames import NedPose
    from ccas_core.world import ShipReport, World

    plans = {plan.ship.id: plan for plan in scenario.ships}
    reports = {}
    for row in rows:
        plan = plans[row.ship]
        pose = NedPose(row.north, row.east, row.course)
        line = lines[row.ship]
        leg = line.leg_at(line.frame.to_path(pose).x)
        reports[row.ship] = ShipReport(
            ship=plan.ship,
            pose=pose,
            speed=sailed.get(row.ship, plan.speed),
            waterway=leg.waterway,
            towards=leg.towards,
            ruleset=row.ruleset,
        )
    return World(time=rows[0].time if rows else 0.0, waters=scenario.waters, reports=reports)
