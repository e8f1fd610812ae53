"""`ccas replay`: a page for every run that can be read, a clear message for others; and in a browser."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from . import TWO_SHIPS, ccas

BROWSERS = ("chromium", "chromium-browser", "chromium-headless-shell", "google-chrome")
QUIET = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND",  # no network
    "--window-size=1200,800",
)


@pytest.fixture(scope="module")
def sailed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Sail the two ships, once for all tests."""
    folder = tmp_path_factory.mktemp("sailed")
    (folder / "two_ships.yaml").write_text(TWO_SHIPS, encoding="utf-8")
    done = ccas("simulate", folder / "two_ships.yaml", "--out", folder / "run", "--no-pictures")
    assert done.exit_code == 0
    assert done.stderr.endswith(f"ccas replay {folder / 'run'} plays it\n")
    return folder / "run"


@pytest.fixture
def run(sailed: Path, two_ships: Path) -> Path:
    """Copy the run into the folder of the test."""
    return Path(shutil.copytree(sailed, "run"))


def test_page_is_put_into_the_run_folder(run: Path) -> None:
    done = ccas("replay", run)

    assert (done.exit_code, done.stderr) == (0, "")
    assert re.fullmatch(rf"replay: {re.escape(str(run / 'replay.html'))} \(\d+ kB\)\n", done.stdout)
    assert (run / "replay.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_page_is_put_where_it_is_asked_for_and_json_tells_what_it_shows(run: Path) -> None:
    done = ccas("replay", run, "--out", "two ships.html", "--json")

    told = json.loads(done.stdout)
    assert told["replay"] == "two ships.html"
    assert told["bytes"] == Path("two ships.html").stat().st_size
    assert (told["scenario"], told["complete"], told["plans"]) == ("two ships cross", True, True)
    assert (told["ships"], told["rulesets"]) == (2, ["tran2026"])
    assert "closest" in {event["kind"] for event in told["events"]}
    assert not (run / "replay.html").exists()


def test_runs_with_controllers_of_plugins_are_played_and_explained(tmp_path: Path) -> None:
    run = tmp_path / "run"
    ccas("simulate", "zhenjiang/sim_2", "--out", run, "--no-pictures", "--quiet")

    assert ccas("replay", run, "--json").exit_code == 0
    assert ccas("explain", run, "--time", "0").exit_code == 0


def test_same_run_gives_the_same_page(run: Path) -> None:
    for name in ("one.html", "two.html"):
        ccas("replay", run, "--out", name)

    assert Path("one.html").read_bytes() == Path("two.html").read_bytes()


def test_run_of_an_earlier_version_is_shown_without_plans(run: Path) -> None:
    (run / "plans.jsonl").unlink()

    done = ccas("replay", run, "--json")

    assert done.exit_code == 0
    assert json.loads(done.stdout)["plans"] is False
    assert done.stderr.startswith("run: no plans were kept")


def test_run_without_a_summary_is_shown_as_far_as_it_went(run: Path) -> None:
    (run / "summary.json").unlink()

    done = ccas("replay", run, "--json")

    assert done.exit_code == 0
    assert json.loads(done.stdout)["complete"] is False


# What is spoilt (a file of the run, what stands in it, what stands there instead; None: the file is gone),
# and what the message says.
SPOILT = (
    ("summary.json frames.csv", None, "", "run: no run is here", "`ccas simulate SCENARIO --out FOLDER`"),
    ("scenario.yaml", None, "", "scenario.yaml: cannot be read: No such file", "is the run complete"),
    ("frames.csv", None, "", "frames.csv: cannot be read: No such file", "is the run complete"),
    ("decisions.jsonl", None, "", "decisions.jsonl: cannot be read: No such file", "is the run complete"),
    (
        "scenario.yaml",
        "length",
        "lenght",
        "scenario.yaml:11:5: unknown key 'lenght'",
        "did you mean 'length'?",
    ),
    ("frames.csv", "ship_1", "ship_9", "frames.csv:2:1: ship 'ship_9' is not one of", "files of one run?"),
    ("frames.csv", "u_s", "us", "frames.csv:2:1: cannot be understood", "expected: columns time_s"),
    ("frames.csv", r"(?s)\n.*", "\n", "frames.csv: no ship has sailed", "sail the scenario again"),
    (
        "decisions.jsonl",
        '"pair"',
        '"pear"',
        "decisions.jsonl:1:1: cannot be understood",
        "a decision: time_s",
    ),
    ("plans.jsonl", "north", "nord", "plans.jsonl:1:1: cannot be understood", "shown without plans"),
)


@pytest.mark.parametrize(("files", "found", "instead", "message", "hint"), SPOILT)
def test_run_that_cannot_be_shown_gets_one_clear_message(
    files: str, found: str | None, instead: str, message: str, hint: str, run: Path
) -> None:
    for file in (run / name for name in files.split()):
        text = file.read_text(encoding="utf-8")
        file.unlink()
        if found is not None:
            assert re.search(found, text)
            file.write_text(re.sub(found, instead, text), encoding="utf-8", newline="\n")

    done = ccas("replay", run)

    assert (done.exit_code, done.stdout) == (2, "")
    assert message in done.stderr
    assert hint in done.stderr
    assert not (run / "replay.html").exists()


def test_folder_that_has_the_name_of_the_page_is_left_alone(run: Path) -> None:
    (run / "replay.html").mkdir()

    done = ccas("replay", run)

    assert (done.exit_code, done.stdout) == (2, "")
    assert f"{run / 'replay.html'}: cannot be written: " in done.stderr
    assert not list(run.glob(".*"))


@pytest.mark.parametrize(
    ("out", "message"),
    [
        ("run", "run: is a folder"),
        ("two_ships.yaml", "two_ships.yaml: is not the name of a page"),
        ("nowhere/a.html", "cannot be written: No such file"),
    ],
)
def test_page_is_not_written_over_something_else(out: str, message: str, run: Path) -> None:
    before = Path("two_ships.yaml").read_bytes()

    done = ccas("replay", run, "--out", out)

    assert (done.exit_code, done.stdout) == (2, "")
    assert message in done.stderr
    assert "hint: " in done.stderr
    assert Path("two_ships.yaml").read_bytes() == before


# --- in a browser


@pytest.fixture
def browser() -> str:
    """Find a browser that needs no display."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        pytest.skip(f"none of {', '.join(BROWSERS)} is installed, so that no page can be looked at")
    return found


def seen(browser: str, page: Path, profile: Path, *options: str) -> dict[str, Any]:
    """Open a page, let it move its own slider, and tell what came of it."""
    address = f"{page.resolve().as_uri()}#t=0&probe=60"
    command = (browser, *QUIET, *options, f"--user-data-dir={profile}", "--dump-dom", address)
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    found = re.search(r'data-probe="([^"]*)"', done.stdout)
    assert found is not None, f"the script of the page did not come to its end\n{done.stderr[-2000:]}"
    told: dict[str, Any] = json.loads(html.unescape(found[1]))
    return told


def test_slider_keys_and_zoom_change_the_picture_and_nothing_is_asked_for(
    browser: str, run: Path, tmp_path: Path
) -> None:
    ccas("replay", run)

    told = seen(browser, run / "replay.html", tmp_path / "profile")

    assert (told["requests"], told["errors"]) == ([], [])
    assert (told["time"], told["stepped"]) == (60, 80)
    assert told["arrows"] == "ship_1>ship_2"
    assert len({told["before"], told["after"], told["zoomed"]}) == 3
    assert told["ready_ms"] < 1000.0


def test_page_is_dark_where_the_user_wants_it_so(browser: str, run: Path, tmp_path: Path) -> None:
    ccas("replay", run)

    shown = [
        seen(
            browser,
            run / "replay.html",
            tmp_path / f"{which}",
            f"--blink-settings=preferredColorScheme={which}",
        )
        for which in (0, 1)
    ]

    assert [told["colours"] for told in shown] == ["#171e27", "#ffffff"]
    assert shown[0]["after"] != shown[1]["after"]
