"""`ccas simulate`: a run folder whatever happens, and nothing where there was nothing to sail."""

from __future__ import annotations

import csv
import io
import json
import sys
from pathlib import Path

import pytest

from ccas_cli import sailing
from ccas_cli.sailing import watched
from ccas_core.sim.frame import Frame
from ccas_core.sim.metrics import summary
from ccas_core.sim.run_folder import COLUMNS
from ccas_core.sim.run_reading import read_run
from ccas_core.sim.scenario_file import load_scenario

from . import TWO_SHIPS, ccas, ccas_alone

FILES = {"scenario.yaml", "frames.csv", "decisions.jsonl", "summary.json"}
REGION = "regions: [{id: rhine, ruleset: ccnrr, polygon: [[0, 0], [9, 0], [9, 9]]}]"

# What is written, what is written instead, and where and what the message says.
FAULTS = (
    ("length: 40 m", "length: 40", "12:13: '40' has no unit", "write '40 m'"),
    ("length: 40 m", "lenght: 40 m", "12:5: unknown key 'lenght'", "did you mean 'length'?"),
    ("speed: 3 m/s", "speed: 3 kts", "17:12: '3 kts' has an unknown unit", "km/h, kn, m/s"),
    ("waterway: river", "waterway: rivr", "22:24: unknown waterway 'rivr'", "did you mean 'river'?"),
    (
        "ruleset: tran2026",
        "ruleset: tran2062",
        "5:12: unknown ruleset 'tran2062'",
        "did you mean 'tran2026'?",
    ),
    ("regions: []", REGION, "6:34: unknown ruleset 'ccnrr'", "did you mean 'ccnr'?"),
    ("start: [-300, 0]", "start: [-300, 90]", "16:12: the ship starts outside", "90 m off a centreline"),
    ("time: {step", "time: {\tstep: 1 s}\n\t{", "4:1: a tab in the indentation", "indent with spaces"),
    ("time: {step: 20 s}", "time: {step: 20 s", "4:7: not YAML", "close the bracket"),
    ("schema: ccas/scenario@1\n", "", "1:1: the file does not say", "begin with 'schema: ccas/scenario@1'"),
)

INTERRUPTED = """
import os, signal
from ccas_cli import sailing
from ccas_cli.main import main

whole = sailing.voyage

def voyage(*arguments):
    for frame in whole(*arguments):
        if frame.index == {index}:
            for _ in range({times}):
                os.kill(os.getpid(), signal.SIGINT)
        yield frame

sailing.voyage = voyage
main()
"""


def test_voyage_leaves_all_files_of_a_run(two_ships: Path) -> None:
    done = ccas("simulate", two_ships, "--out", "run")

    folder = two_ships.parent / "run"
    assert done.exit_code == 0, done.stderr
    assert {file.name for file in folder.iterdir() if file.suffix != ".png"} == FILES
    assert any(folder.glob("*.png"))
    assert all(str(Path("run", file.name)) in done.stdout for file in folder.glob("*.png"))
    run = read_run(folder)
    assert {row.ship for row in run.rows} == {"ship_1", "ship_2"}
    assert run.decisions[0]["pair"] == ["ship_1", "ship_2"]
    assert load_scenario(folder / "scenario.yaml").name == "two ships cross"


def test_voyage_without_out_goes_to_a_folder_of_the_scenario_s_name(two_ships: Path) -> None:
    done = ccas("simulate", two_ships, "--no-pictures")

    assert done.exit_code == 0
    assert (two_ships.parent / "runs" / "two ships cross" / "summary.json").is_file()


def test_same_voyage_gives_the_same_bytes(two_ships: Path) -> None:
    for folder in ("one", "two"):
        assert ccas("simulate", two_ships, "--out", folder, "--no-pictures", "--quiet").exit_code == 0

    one, two = (two_ships.parent / folder / "frames.csv" for folder in ("one", "two"))
    assert one.read_bytes() == two.read_bytes()
    header, *rows = csv.reader(one.read_text(encoding="utf-8").splitlines())
    assert tuple(header) == COLUMNS
    assert len(rows) > 10


def test_json_is_the_summary_and_nothing_else_is_on_stdout(two_ships: Path) -> None:
    done = ccas_alone("simulate", two_ships, "--out", "run", "--no-pictures", "--json", cwd=two_ships.parent)

    assert done.returncode == 0
    assert json.loads(done.stdout) == json.loads((two_ships.parent / "run" / "summary.json").read_text())
    assert "2 ships set sail" in done.stderr


def test_table_tells_who_gave_way_and_by_which_article(two_ships: Path) -> None:
    done = ccas("simulate", two_ships, "--no-pictures", "--quiet")

    (first,) = [line.split() for line in done.stdout.splitlines() if line.strip().startswith("ship_1  ")]
    assert first[:3] == ["ship_1", "ship_2", "-"]
    assert "ship_1 to give way (Tran et al. 2026 Sec. 3.1, crossing)" in done.stdout
    assert "0 collisions, 0 entries, 0 groundings, 0 allisions" in done.stdout
    assert str(Path("runs", "two ships cross")) in done.stdout
    assert done.stderr == ""


def test_ruleset_of_the_command_line_is_sailed_and_written(two_ships: Path) -> None:
    options = ("--ruleset", "tran2026_printed", "--out", "run", "--no-pictures", "--quiet")
    ccas("simulate", two_ships, *options)

    run = read_run(two_ships.parent / "run")
    assert "ruleset: tran2026_printed" in run.scenario
    assert {row.ruleset for row in run.rows} - {""} == {"tran2026_printed"}


def test_solver_that_was_used_is_told(two_ships: Path) -> None:
    done = ccas("simulate", two_ships, "--solver", "ipopt", "--no-pictures", "--quiet", "--json")

    assert json.loads(done.stdout)["solver"] == "ipopt"


@pytest.mark.parametrize("key", ["collisions", "groundings", "allisions"])
def test_damage_is_a_finding(key: str, two_ships: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sailing, "summary", lambda *arguments: summary(*arguments) | {key: 1})

    assert ccas("simulate", two_ships, "--no-pictures", "--quiet").exit_code == 1


@pytest.mark.parametrize(("written", "instead", "message", "hint"), FAULTS)
def test_bad_scenario_gets_one_clear_message_and_no_folder(
    written: str, instead: str, message: str, hint: str, two_ships: Path
) -> None:
    assert written in TWO_SHIPS
    two_ships.write_text(TWO_SHIPS.replace(written, instead, 1), encoding="utf-8")

    done = ccas("simulate", two_ships)

    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith(f"{two_ships}:{message}"), done.stderr
    assert done.stderr.count(str(two_ships)) == 1
    assert "hint: " in done.stderr
    assert hint in done.stderr
    assert list(two_ships.parent.iterdir()) == [two_ships]


@pytest.mark.parametrize(
    ("options", "message", "hint"),
    [
        (("--solver", "riccatti"), "unknown solver 'riccatti'", "did you mean 'riccati'?"),
        (("--ruleset", "tran2062"), "unknown ruleset 'tran2062'", "did you mean 'tran2026'?"),
    ],
)
def test_unknown_choice_is_refused_before_anything_is_written(
    options: tuple[str, str], message: str, hint: str, two_ships: Path
) -> None:
    done = ccas("simulate", two_ships, *options)

    assert (done.exit_code, done.stdout) == (2, "")
    assert message in done.stderr
    assert hint in done.stderr
    assert list(two_ships.parent.iterdir()) == [two_ships]


@pytest.mark.parametrize(
    ("name", "message"),
    [("fig_21", "did you mean 'fig_"), ("nowhere.yaml", "nowhere.yaml: cannot be read: No such file")],
)
def test_scenario_that_is_not_there_is_refused(name: str, message: str, two_ships: Path) -> None:
    done = ccas("simulate", name)

    assert (done.exit_code, done.stdout) == (2, "")
    assert message in done.stderr


def test_folder_of_something_else_is_left_alone(two_ships: Path) -> None:
    done = ccas("simulate", two_ships, "--out", ".")

    assert (done.exit_code, done.stdout) == (2, "")
    assert "choose another folder with --out" in done.stderr
    assert list(two_ships.parent.iterdir()) == [two_ships]


@pytest.mark.parametrize(("times", "frames"), [(1, 4), (2, 3)])
def test_ctrl_c_keeps_what_was_sailed(times: int, frames: int, two_ships: Path) -> None:
    program = INTERRUPTED.format(index=3, times=times)

    done = ccas_alone("simulate", two_ships, "--out", "run", cwd=two_ships.parent, program=program)

    assert done.returncode == 130, done.stderr
    assert "what was sailed is in run" in done.stderr
    assert "Traceback" not in done.stderr
    run = read_run(two_ships.parent / "run")
    assert run.summary is not None
    assert run.summary["interrupted"] is True
    assert run.summary["frozen"] is None  # only the end of the voyage would tell
    assert len({row.time for row in run.rows}) == frames
    assert not list((two_ships.parent / "run").glob("*.png"))


def test_ctrl_c_before_the_first_period_is_over_leaves_nothing(two_ships: Path) -> None:
    program = INTERRUPTED.format(index=0, times=2)

    done = ccas_alone("simulate", two_ships, cwd=two_ships.parent, program=program)

    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr.endswith("interrupted\n")
    assert list(two_ships.parent.iterdir()) == [two_ships]


def test_progress_on_a_terminal_shows_time_and_ships(
    two_ships: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = io.StringIO()
    monkeypatch.setattr(terminal, "isatty", lambda: True)
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    frame = Frame(index=2, time=40.0, ships={}, settlements=(), openings=(), generations=(), arrived={})

    with watched(load_scenario(two_ships)) as watcher:
        watcher.sailed(frame)
        shown_before = terminal.getvalue()
        watcher.stopping()

    assert "two ships cross" in shown_before
    assert "40 s, 0 ships under way" in terminal.getvalue()
    assert "stopping after this period" in terminal.getvalue()
