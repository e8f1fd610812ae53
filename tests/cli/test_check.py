"""`ccas check`: all findings of all files."""

from __future__ import annotations

import json
from pathlib import Path

from . import TWO_SHIPS, ccas


def test_file_that_is_well_has_no_findings(two_ships: Path) -> None:
    done = ccas("check", two_ships)

    assert (done.exit_code, done.stdout) == (0, "")
    assert done.stderr == "1 file read: nothing is wrong\n"


def test_all_findings_of_all_files_are_told_at_once(two_ships: Path) -> None:
    folder = two_ships.parent
    (folder / "deep").mkdir()
    two_ships.write_text(TWO_SHIPS.replace("40 m", "40").replace("beam", "beem"), encoding="utf-8")
    (folder / "deep" / "other.yaml").write_text(TWO_SHIPS.replace("speed: 3 m/s", "speed: -3 m/s"))

    done = ccas("check", folder, "--json")

    findings = json.loads(done.stdout)
    assert done.exit_code == 2
    assert len([each for each in findings if each["source"] == str(two_ships)]) >= 4
    assert {each["line"] for each in findings if each["source"].endswith("other.yaml")} == {17, 24}
    assert all(each["message"] and each["column"] for each in findings)


def test_findings_are_shown_with_their_place_and_a_hint(two_ships: Path) -> None:
    two_ships.write_text(TWO_SHIPS.replace("iterations", "iteration"), encoding="utf-8")

    done = ccas("check", two_ships)

    assert done.exit_code == 2
    assert f"{two_ships}:25:24: unknown key 'iteration'" in done.stdout
    assert "did you mean 'iterations'?" in done.stdout


def test_unknown_schema_is_told_with_what_was_probably_meant(two_ships: Path) -> None:
    two_ships.write_text(TWO_SHIPS.replace("scenario@1", "scenari@1"), encoding="utf-8")

    done = ccas("check", two_ships)

    assert done.exit_code == 2
    assert f"{two_ships}:1:9: unknown schema 'ccas/scenari@1'" in done.stdout
    assert "did you mean 'ccas/scenario@1'?" in done.stdout


def test_file_without_schema_is_told_how_to_begin(two_ships: Path) -> None:
    two_ships.write_text("name: two ships\n", encoding="utf-8")

    done = ccas("check", two_ships)

    assert done.exit_code == 2
    assert "begin with 'schema: ccas/scenario@1'" in done.stdout


def test_folder_without_files_is_a_finding(tmp_path: Path) -> None:
    done = ccas("check", tmp_path)

    assert done.exit_code == 2
    assert "no *.yaml file in this folder" in done.stdout


def test_file_that_is_not_there_is_a_finding(tmp_path: Path) -> None:
    done = ccas("check", tmp_path / "nowhere.yaml", "--json")

    assert done.exit_code == 2
    assert "No such file" in json.loads(done.stdout)[0]["message"]
