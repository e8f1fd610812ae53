"""Voyages over borders: the shipped ones sail clean, laws are agreed and kept, layer 2 notices nothing."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

from ccas_core.agent.events import AgentSettings
from ccas_core.agent.ship_agent import ShipAgent
from ccas_core.dmpc.solvers import AbstractLocalSolver, Fatrop, make_solver
from ccas_core.plugins import load
from ccas_core.regions import Hysteresis, Region
from ccas_core.ships import Ship
from ccas_core.sim.law_log import LawLog, counted, law_log, laws_named
from ccas_core.sim.metrics import summary
from ccas_core.sim.run_folder import RunWriter
from ccas_core.sim.run_reading import read_run
from ccas_core.sim.scenario import BusChoice, ControlChoice, Scenario
from ccas_core.sim.scenario_dump import dump_scenario
from ccas_core.sim.scenario_file import load_scenario
from ccas_core.sim.voyage import voyage
from ccas_core.tapd.aboard import Aboard
from ccas_core.waterway import GuidingLine, Waters
from ccas_scenarios import names, path

from . import EAST, WEST, A, B, plan, scenario, waters

RULESETS = load().rulesets
SHIPPED = [name.partition("/")[2] for name in names() if name.startswith("borders/")]
QUICK = ControlChoice(horizon=12, iterations=2)
SWITCHES = {  # by scenario: ship, from, to
    "another_version": [],
    "bpr_ccnr_crossing": [("across", "bpr", "ccnr")],
    "bpr_ccnr_head_on": [("downbound", "ccnr", "bpr"), ("upbound", "bpr", "ccnr")],
    "bpr_de_seesch_estuary": [("inbound", "de_seesch", "bpr"), ("outbound", "bpr", "de_seesch")],
    "ccnr_bpr_overtaking": [("coming", "bpr", "ccnr"), ("fast", "ccnr", "bpr"), ("slow", "ccnr", "bpr")],
    "ccnr_de_binsch_crossing": [
        ("from_tributary", "ccnr", "de_binsch"),
        ("from_tributary", "de_binsch", "ccnr"),
    ],
    "cevni_de_danube_head_on": [
        ("downbound", "de_danube", "cevni"),
        ("first", "cevni", "de_danube"),
        ("second", "cevni", "de_danube"),
    ],
    "convoy_of_five": [
        *((f"convoy_{n}", "bpr", "ccnr") for n in range(1, 6)),
        *((f"down_{n}", "ccnr", "bpr") for n in (1, 2)),
    ],
    "there_and_back": [
        *((ship, "bpr", "ccnr") for ship in ("eastbound", "westbound")),
        *((ship, "ccnr", "bpr") for ship in ("eastbound", "westbound")),
    ],
    "without_the_new_ruleset": [("rhenish", "ccnr", "bpr"), ("stranger", "bpr", "ccnr")],
}


@pytest.fixture(scope="module")
def solver() -> AbstractLocalSolver:
    return make_solver()


@dataclass(frozen=True, eq=False)
class Sailed:
    """A voyage over a border: its log, its summary, and what the two say of laws."""

    decisions: list[Mapping[str, Any]]
    summary: Mapping[str, Any]
    laws: LawLog


@cache
def sailed(name: str) -> Sailed:
    """Sail a shipped scenario, and read again what it leaves."""
    of = load_scenario(path(f"borders/{name}"), RULESETS)
    frames = []
    with TemporaryDirectory() as folder, RunWriter(Path(folder), of, dump_scenario(of)) as writer:
        for frame in voyage(of, RULESETS, make_solver()):
            writer.write(frame)
            frames.append(frame)
        writer.finish(summary(of, frames, "x"))
        run = read_run(Path(folder))
    assert run.summary is not None
    return Sailed(list(run.decisions), run.summary, counted(of, frames, run.decisions))


# --- the shipped scenarios ------------------------------------------------------------------------


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_borders_sail_clean_and_both_ships_of_a_pair_name_one_law_or_fall_back(name: str) -> None:
    run = sailed(name)
    harm = {key: run.summary[key] for key in ("collisions", "entries", "groundings", "allisions", "frozen")}
    switches = sorted((each["ship"], each["from"], each["to"]) for each in run.summary["ruleset_switches"])
    unlike = [each for each in run.decisions if len(laws_named(each)) > 1]

    assert harm == dict.fromkeys(harm, 0)
    assert switches == sorted(SWITCHES[name])
    assert run.laws.faults == 0
    assert all(each["applied"] == "fallback" and " judges by " in str(each["why"]) for each in unlike)
    assert bool(unlike) is (name in {"another_version", "without_the_new_ruleset"})


def test_an_encounter_ends_under_the_law_it_began_with() -> None:
    run = sailed("ccnr_bpr_overtaking")
    over = max(each["time_s"] for each in run.summary["ruleset_switches"] if each["ship"] != "coming")
    pair = [told for told in run.decisions if told["pair"] == ["fast", "slow"]]
    beyond = [told for told in pair if told["time_s"] > over and told["geometry"] == "overtaking"]

    assert len(beyond) >= 4  # both are in Dutch waters, and one still overtakes the other
    assert {ruleset for told in beyond for ruleset, _ in laws_named(told)} == {"ccnr"}
    met = {tuple(each["ships"]): each["ruleset"] for each in run.summary["encounters"]}
    assert met == {("fast", "slow"): "ccnr", ("coming", "fast"): "bpr"}


def test_a_ship_may_go_by_two_laws_towards_two_ships() -> None:
    met = sailed("bpr_ccnr_crossing").summary["encounters"]

    assert {tuple(each["ships"]): each["ruleset"] for each in met} == {
        ("across", "upbound"): "bpr",
        ("downbound", "upbound"): "ccnr",
    }


def test_a_line_of_ships_meets_one_ship_by_two_laws_as_the_border_passes() -> None:
    met = {tuple(each["ships"]): each for each in sailed("convoy_of_five").summary["encounters"]}
    first = [met[f"convoy_{n}", "down_1"] for n in range(1, 6)]

    assert [each["ruleset"] for each in first] == ["ccnr", "ccnr", "bpr", "bpr", "bpr"]
    assert [each["give_way"] for each in first] == [
        ["convoy_1"],
        ["convoy_2"],
        ["down_1"],
        ["down_1"],
        ["down_1"],
    ]


def test_a_ship_without_the_ruleset_falls_back_where_it_holds_and_nowhere_else() -> None:
    decisions = sailed("without_the_new_ruleset").decisions
    met = [
        each
        for each in decisions
        if each["pair"] == ["rhenish", "stranger"] and each["applied"] == "fallback"
    ]
    dutch = [each for each in decisions if each["pair"] == ["dutch", "stranger"]]

    assert len(met) > 10
    assert {each["why"] for each in met} == {
        "rhenish judges by ccnr 2022.3.26, stranger by bpr 2026.6.17 for want of ccnr"
    }
    assert {each["verdicts"]["stranger"]["lacks"] for each in met} == {"ccnr"}
    assert {each["applied"] for each in dutch} == {"agreed"}


# --- faults of messages and views -----------------------------------------------------------------


def border(ruleset: str = "ccnr", east: float = 0.0) -> Region:
    """Waters under another ruleset, east of a line."""
    corners = np.array([[-4e3, east], [-4e3, 9e3], [4e3, 9e3], [4e3, east]])
    return Region(id="east", ruleset=ruleset, polygon=corners)


def head_on(bus: BusChoice | None = None) -> Scenario:
    on = replace(waters(), ruleset="bpr", regions=(border(),))
    of = scenario(plan(A, EAST, before=900.0, aside=5.0), plan(B, WEST, before=700.0, aside=-5.0), on=on)
    return replace(of, control=QUICK, bus=bus or BusChoice())


def test_ships_with_two_charts_fall_back_and_agree_again_where_the_charts_do(
    monkeypatch: pytest.MonkeyPatch, solver: AbstractLocalSolver
) -> None:
    """Ship b has an old chart, with the border 600 m further west; after a while it gets the new one."""
    of = head_on()
    whole, outdated = ShipAgent.__init__, list[ShipAgent]()

    def with_chart(
        self: ShipAgent,
        ship: Ship,
        line: GuidingLine,
        speed: float,
        chart: Waters,
        aboard: Aboard,
        own: AgentSettings,
    ) -> None:
        mine = replace(chart, regions=(border(east=-600.0),)) if ship.id == B else chart
        whole(self, ship, line, speed, mine, aboard, own)
        if ship.id == B:
            outdated.append(self)

    monkeypatch.setattr(ShipAgent, "__init__", with_chart)
    sailing = voyage(of, RULESETS, solver)
    frames = list(itertools.islice(sailing, 5))
    outdated[0]._waters = of.waters  # type: ignore[misc]
    frames += itertools.islice(sailing, 5)
    laws = [each.one.ruleset for frame in frames for each in frame.settlements]
    told = [each.fallback for frame in frames for each in frame.settlements]

    assert told == ["a judges by bpr 2026.6.17, b by ccnr 2022.3.26"] * 5 + [""] * 5
    assert laws == ["bpr"] * 10
    log = law_log(of, frames)
    assert (log.two_laws, log.both_stand_on, log.fallbacks, log.law_changes) == (0, 0, 5, 1)


def test_ships_come_together_again_where_messages_are_lost(solver: AbstractLocalSolver) -> None:
    seen = []
    for seed in range(4):
        of = head_on(bus=BusChoice(loss=0.3, delay=0.5, seed=seed))
        frames = list(voyage(of, RULESETS, solver))
        log = law_log(of, frames)
        assert (log.two_laws, log.both_stand_on, log.flaps) == (0, 0, 0)
        seen.append(summary(of, frames, solver.name)["collisions"])
    assert seen == [0] * 4


# --- what it costs layer 2 ------------------------------------------------------------------------


def test_layer_2_builds_nothing_when_ships_go_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """One programme is built, in the first period, and the same object solves on both sides of the border."""
    built: list[tuple[int, int]] = []
    build = Fatrop.build

    def counting(self: Fatrop, horizon: int, threats: int) -> object:
        built.append((horizon, threats))
        return build(self, horizon, threats)

    monkeypatch.setattr(Fatrop, "build", counting)
    solver = Fatrop()
    of = replace(head_on(), control=ControlChoice(horizon=5, iterations=1))
    programmes = []
    frames = []
    for frame in itertools.islice(voyage(of, RULESETS, solver), 20):
        frames.append(frame)
        programmes.append(dict(solver.programmes))

    assert law_log(of, frames).switches == 2
    assert len(built) == 1
    assert all(each.keys() == programmes[0].keys() for each in programmes)
    assert all(each[key] is programmes[0][key] for each in programmes for key in each)


def test_the_code_of_layer_2_is_untouched_by_a_border(solver: AbstractLocalSolver) -> None:
    modules = {name: module for name, module in sys.modules.items() if name.startswith("ccas_core.dmpc")}
    contents = {name: dict(vars(module)) for name, module in modules.items()}
    frames = list(itertools.islice(voyage(head_on(), RULESETS, solver), 20))

    assert {ship.ruleset for frame in frames for ship in frame.ships.values()} == {"bpr", "ccnr"}
    for name, module in modules.items():
        assert all(vars(module).get(key) is value for key, value in contents[name].items())


# --- flapping -------------------------------------------------------------------------------------


def along(amplitude: float, hysteresis: Hysteresis) -> Scenario:
    """One ship along a canal whose middle is a border that winds about its line."""
    east = np.arange(-3500.0, 3501.0, 20.0)
    winding = np.column_stack([amplitude * np.sin(east / 40.0), east])
    corners = np.vstack([winding, [[4000.0, 3500.0], [4000.0, -3500.0]]])
    on = replace(
        waters(),
        regions=(Region(id="north", ruleset="ccnr", polygon=corners),),
        hysteresis=hysteresis,
    )
    return replace(scenario(plan(A, EAST, before=1500.0), on=on), control=QUICK)


@pytest.mark.parametrize("amplitude", [5.0, 15.0, 40.0])
def test_along_a_border_a_ship_switches_once_a_minute_and_crossing_at_most(
    amplitude: float, solver: AbstractLocalSolver
) -> None:
    of = along(amplitude, Hysteresis())
    frames = list(voyage(of, RULESETS, solver))
    times = [each["time_s"] for each in summary(of, frames, "x")["ruleset_switches"]]  # type: ignore[attr-defined]

    assert all(later - sooner >= 60.0 for sooner, later in itertools.pairwise(times))
    assert (law_log(of, frames).flaps, len(times) > 0) == (0, amplitude > 10.0)


def test_without_hysteresis_the_same_ship_flaps_and_the_log_tells(solver: AbstractLocalSolver) -> None:
    of = along(15.0, Hysteresis(width=0.0, time=0.0))
    frames = list(voyage(of, RULESETS, solver))
    judged = law_log(replace(of, waters=replace(of.waters, hysteresis=Hysteresis())), frames)

    assert judged.flaps > 10


# --- the counts can fail --------------------------------------------------------------------------


def told(
    time: float, laws: tuple[str, str], kinds: tuple[str, str], applied: str = "agreed"
) -> dict[str, Any]:
    views = {
        ship: {"ruleset": law, "version": "1", "kind": kind}
        for ship, law, kind in zip((A, B), laws, kinds, strict=True)
    }
    return {"time_s": time, "pair": [A, B], "verdicts": views, "applied": applied}


@pytest.mark.parametrize(
    ("lines", "fault"),
    [
        ([told(0.0, ("bpr", "ccnr"), ("give_way", "stand_on"))], "two_laws"),
        ([told(0.0, ("bpr", "bpr"), ("stand_on", "stand_on"))], "both_stand_on"),
        (
            [told(20.0 * n, (law, law), ("give_way", "stand_on")) for n, law in enumerate(("bpr", "ccnr"))],
            "law_changes",
        ),
    ],
)
def test_each_fault_of_a_log_is_counted(lines: list[dict[str, Any]], fault: str) -> None:
    log: LawLog = counted(head_on(), [], lines)

    assert (getattr(log, fault), log.faults) == (1, 1)


def test_a_new_encounter_under_a_new_law_is_no_fault() -> None:
    lines = [
        told(0.0, ("bpr", "bpr"), ("give_way", "stand_on")),
        told(20.0, ("ccnr", "ccnr"), ("none", "none")),
        told(40.0, ("ccnr", "ccnr"), ("give_way", "stand_on")),
        told(60.0, ("bpr", "ccnr"), ("give_way", "give_way"), "fallback"),
    ]

    log = counted(head_on(), [], lines)
    assert (log.faults, log.fallbacks, log.decisions) == (0, 1, 4)
