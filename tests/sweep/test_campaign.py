"""A sweep from its specification to its folder."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from ccas_core import plugins
from ccas_core.errors import InputError
from ccas_core.sim.scenario_dump import dump_scenario
from ccas_core.sim.scenario_file import load_scenario
from ccas_core.sweep.campaign import Progress, run, run_jointly, write
from ccas_core.sweep.case import Case, cases, scenario
from ccas_core.sweep.journal import FILE, Journal, code_digest
from ccas_core.sweep.report import write_report
from ccas_core.sweep.spec import load_sweep, parse_sweep
from ccas_core.sweep.tally import Result, faults, upper_bound, worst
from ccas_core.sweep.task import Program, program, sail_case
from ccas_core.sweep.workers import Status
from ccas_scenarios import names, path

SPEC = """
schema: ccas/sweep@1
name: tiny
seed: 4
executor: local:1
rulesets: [tran2026]
cells:
  - {name: head_on, draw: head_on, count: 2}
  - {name: crossing, draw: crossing, count: 1}
  - {name: crossing_calm, draw: crossing, risk: calm}
  - {name: ignored, draw: crossing, breach: ignores}
"""
CELL_KEYS = {
    *("name", "ruleset", "geometry", "n", "risky", "judged", "faithful", "calm", "calm_acted"),
    *("collisions", "entries", "groundings", "frozen", "mean_delay_s"),
}


def test_shipped_sweeps_can_be_read() -> None:
    shipped = [name for name in names() if name.startswith("sweeps/")]

    assert {"sweeps/two_ship_short", "sweeps/groups_short", "sweeps/border_short"} <= set(shipped)
    for name in shipped:
        sweep = load_sweep(path(name), plugins.load().rulesets)
        counts = (cell.count * (1 if cell.border else len(sweep.rulesets)) for cell in sweep.cells)
        assert sum(1 for _ in cases(sweep)) == sum(counts)


def test_a_sweep_counts_goes_on_where_it_stopped_and_is_not_run_again(tmp_path: Path) -> None:
    sweep, told = parse_sweep(SPEC), list[int]()

    def stop(progress: Progress) -> None:
        told.append(progress.known)
        if progress.done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(sweep, tmp_path / "out", program(), stop)
    results = run(sweep, tmp_path / "out", program(), lambda progress: told.append(progress.known))
    again = run(sweep, tmp_path / "out", program(), lambda progress: told.append(progress.known))
    summary = write(sweep, results, {}, tmp_path / "out", plugins.load().rulesets)
    report = write_report(sweep, results, summary, tmp_path / "out", plugins.load().rulesets)

    assert told[0] == 0
    assert 2 in told
    assert told[-1] == 5
    assert results == again
    assert json.loads((tmp_path / "out/summary.json").read_text()) == summary
    assert (summary["spec"], summary["seed"]) == ("tiny", 4)
    entries = {cell["name"]: cell for cell in summary["cells"]}
    assert all(cell.keys() >= CELL_KEYS for cell in entries.values())
    assert [entries["head_on"][key] for key in ("n", "risky", "judged", "faithful")] == [2, 2, 2, 2]
    assert [entries["crossing_calm"][key] for key in ("calm", "calm_acted")] == [1, 0]
    assert entries["ignored"]["judged"] == 0  # a ship that was made to break its duty is not judged
    assert all(cell["collisions"] == cell["entries"] == cell["frozen"] == 0 for cell in entries.values())
    page = report.read_text()
    assert "http" not in page
    assert "head_on" in page


def test_a_case_is_the_same_wherever_it_is_sailed_and_its_file_replays_it(tmp_path: Path) -> None:
    case = next(cases(parse_sweep(SPEC)))
    rulesets = plugins.load().rulesets
    file = tmp_path / "case.yaml"
    file.write_text(dump_scenario(scenario(case, rulesets)), encoding="utf-8")

    once, twice = sail_case(case, program()), sail_case(case, program())

    assert {**once, "seconds": 0} == {**twice, "seconds": 0}
    assert load_scenario(file).ships == scenario(case, rulesets).ships


def test_a_crossing_ship_slows_down_once_and_not_by_fits_and_starts() -> None:
    sweep = replace(load_sweep(path("sweeps/two_ship_long")), seed=1002)
    case = next(each for each in cases(sweep) if each.name == "crossing-colregs-00002")

    kept = sail_case(case, program())

    assert kept["changes_of_mind"] == {"ship_1": 0, "ship_2": 0}  # it changed its mind three times
    assert kept["restless"] == []
    assert kept["actions"] == {"ship_1": 1, "ship_2": 0}


def test_another_seed_or_another_code_is_another_case() -> None:
    case = next(cases(parse_sweep(SPEC)))
    other = next(cases(parse_sweep(SPEC.replace("seed: 4", "seed: 5"))))

    assert len({case.key("a"), case.key("b"), other.key("a")}) == 3
    assert code_digest(["ccas_core"]) == code_digest(["ccas_core"]) != code_digest(["ccas_scenarios"])


def test_a_case_is_the_same_in_a_cell_of_any_size() -> None:
    few, many = (next(cases(parse_sweep(SPEC.replace("count: 2", f"count: {n}")))) for n in (2, 9))

    assert few.key("a") == many.key("a")


def test_a_worker_with_another_program_refuses_a_case() -> None:
    case = next(cases(parse_sweep(SPEC)))

    with pytest.raises(RuntimeError, match="other sources or plugins"):
        sail_case(case, Program(None, "sources of last week"))


def test_a_case_that_fails_is_named_and_the_rest_goes_on(tmp_path: Path) -> None:
    broken = SPEC + "  - {name: lost, scenario: nowhere.yaml}\n"

    results = run(parse_sweep(broken), tmp_path / "out", program())
    summary = write(parse_sweep(broken), results, {}, tmp_path / "out", plugins.load().rulesets)

    assert [each.status for each in results].count(Status.DONE) == 5
    assert summary["failures"] == {"failed": 1}
    assert summary["worst"][0] == {"case": "lost-tran2026-00000", "faults": ["failed"]}
    assert "nowhere.yaml" in next(str(each.kept["why"]) for each in results if each.status is Status.FAILED)


def test_a_journal_that_was_cut_off_is_read_up_to_there(tmp_path: Path) -> None:
    journal = Journal(tmp_path / FILE)
    journal.add("k1", "one", {"collisions": 0})
    with (tmp_path / FILE).open("a") as file:
        file.write('{"key": "k2", "resu')

    read = Journal(tmp_path / FILE)
    read.add("k3", "three", {"collisions": 1})

    assert Journal(tmp_path / FILE).results == {"k1": {"collisions": 0}, "k3": {"collisions": 1}}


def test_a_folder_with_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("dear all")

    with pytest.raises(InputError, match="not empty and not a sweep"):
        run(parse_sweep(SPEC), tmp_path, program())


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("draw: head_on,", "drow: head_on,", "a cell has either 'draw' or 'scenario'"),
        ("count: 2", "count: 0", "whole number from 1"),
        ("[tran2026]", "[tran2027]", "tran2027"),
        ("breach: ignores", "breach: sleeps", "one of"),
    ],
)
def test_a_wrong_specification_is_told_with_its_place(old: str, new: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as error:
        parse_sweep(SPEC.replace(old, new), "tiny.yaml", {"tran2026"})

    assert "tiny.yaml:" in str(error.value)


def test_groups_are_set_beside_one_mind_that_steers_all(tmp_path: Path) -> None:
    groups = SPEC.partition("cells:")[0] + (
        "jointly: 1\ncells:\n  - {name: junction, draw: junction, ships: [2, 3], count: 2}\n"
    )
    sweep, told = parse_sweep(groups), list[tuple[int, int]]()
    results = run(sweep, tmp_path / "out", program())

    def tell(progress: Progress) -> None:
        told.append((progress.known, progress.done))

    once = run_jointly(sweep, results, tmp_path / "out", program(), tell)
    again = run_jointly(sweep, results, tmp_path / "out", program(), tell)
    summary = write(sweep, results, once, tmp_path / "out", plugins.load().rulesets)
    page = write_report(sweep, results, summary, tmp_path / "out", plugins.load().rulesets).read_text()

    assert list(once) == ["junction-tran2026-00000"]
    assert once == again
    assert told == [(0, 0), (0, 1), (1, 0)]
    (compared,) = summary["jointly"].values()
    assert compared["joint_cost"] <= compared["sailed_cost"] + 1e-6
    assert (summary["price"]["solved"], summary["price"]["free"]) == (1, 1)
    assert "The price of being distributed" in page


def kept(**changes: object) -> dict[str, object]:
    """What is kept of a case without a fault, but for some changes."""
    return {
        **dict.fromkeys(("collisions", "entries", "groundings", "frozen"), 0),
        "min_clearance_m": 20.0,
        "calm": False,
        "acted": True,
        "avoidable": None,
        "restless": [],
        "encounters": [],
        **changes,
    }


def test_worst_cases_come_first() -> None:
    case: Case = next(cases(parse_sweep(SPEC)))
    results = [
        Result(case, Status.DONE, kept()),
        Result(case, Status.DONE, kept(encounters=[{"faithful": False}])),
        Result(case, Status.DONE, kept(restless=["ship_1"])),
        Result(case, Status.DONE, kept(entries=1, min_clearance_m=1.0)),
        Result(case, Status.DONE, kept(collisions=1, entries=1)),
        Result(case, Status.TIMEOUT, {"why": "took more than 60 s"}),
    ]

    found = [what for _, what in worst(results)]

    assert found == [("timeout",), ("collisions", "entries"), ("entries",), ("unfaithful",), ("restless",)]
    assert faults(results[0]) == ()


def test_upper_bound_is_that_of_clopper_and_pearson() -> None:
    assert upper_bound(0, 10) == pytest.approx(1.0 - 0.05 ** (1.0 / 10.0))
    assert upper_bound(1, 20) == pytest.approx(0.2161, abs=1e-4)
    assert upper_bound(3, 3) == 1.0
    assert upper_bound(0, 0) is None
