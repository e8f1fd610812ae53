"""`ccas test`: cases under rulesets, what could not be used, coverage and mutants."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import Result

from . import ccas

CASES = """\
golden_cases:
- id: G1
  title: two large ships cross
  encounter: {geometry: crossing, has_other_on_starboard: A}
  ships: {A: {length_m: 85.0}, B: {length_m: 85.0}}
  expected:
    tran2026: {kind: give_way, give_way: [A], stand_on: [B], strength: keep_clear, confidence: text_seen}
    bpr: {kind: give_way, give_way: [A], stand_on: [B], confidence: secondary_seen}
- id: G2
  title: two large ships meet
  encounter: {geometry: head_on}
  ships: {A: {length_m: 85.0}, B: {length_m: 85.0}}
  expected:
    tran2026: {kind: mutual, give_way: [A, B], stand_on: [], pass: port_to_port}
hard_cases:
- id: H1
  title: three ships in a ring
  ships:
    S1: {length_m: 85.0, kinematics: {east_m: 0.0, north_m: -500.0, course_deg: 0.0, speed_mps: 4.0}}
    S2: {length_m: 85.0, kinematics: {east_m: 500.0, north_m: 0.0, course_deg: 270.0, speed_mps: 4.0}}
    S3: {length_m: 85.0, kinematics: {east_m: -400.0, north_m: 400.0, course_deg: 135.0, speed_mps: 4.0}}
  expected:
    bpr: {diagnosis: cycle}
- id: H2
  title: nothing to judge
  expected:
    bpr: {diagnosis: gap}
"""
RULESET = """\
schema: ccas/ruleset@1
id: example
version: 1.0.0
title: Example
extends: common
regulation: {name: Example, version: "1"}
rules:
  - id: port
    cite: {article: "1", confidence: text_seen}
    when: crossing and has_other_on_starboard == own
    then: give_way
  - id: never-tested
    cite: {article: "2", confidence: text_seen}
    when: head_on
    then: mutual
otherwise: {cite: {article: "9", confidence: text_seen}}
tests:
  - name: the ship from port gives way
    encounter: {geometry: crossing, has_other_on_starboard: A}
    ships: {A: {length: 50 m}, B: {length: 50 m}}
    expect: {give_way: A, by: port}
"""


@pytest.fixture
def cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Write an encounter file, and go to its folder."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "cases.yaml"
    file.write_text(CASES, encoding="utf-8")
    return file


def entries(done: Result) -> dict[tuple[str, str], dict[str, Any]]:
    found = json.loads(done.stdout)
    return {(each["id"], each["ruleset"]): each for each in found["cases"]}


def test_one_entry_for_each_case_and_ruleset(cases: Path) -> None:
    done = ccas("test", cases, "--json")

    found = json.loads(done.stdout)
    assert [(each["id"], each["ruleset"]) for each in found["cases"]] == [
        ("G1", "tran2026"),
        ("G1", "bpr"),
        ("G2", "tran2026"),
        ("H1", "bpr"),
        ("H2", "bpr"),
    ]
    assert (found["passed"], found["failed"], found["skipped"], done.exit_code) == (4, 0, 1, 0)
    assert found["passed"] == sum(each["passed"] for each in found["cases"])
    assert found["failed"] == sum(each["required"] and not each["passed"] for each in found["cases"])


def test_entry_tells_expected_beside_got(cases: Path) -> None:
    entry = entries(ccas("test", cases, "--json"))["G1", "tran2026"]

    assert entry["expected"] == {
        "kind": "give_way",
        "give_way": ["A"],
        "stand_on": ["B"],
        "strength": "keep_clear",
    }
    assert entry["expected"].items() <= entry["got"].items()
    assert (entry["passed"], entry["required"], entry["skipped"]) == (True, True, False)
    assert (entry["source"], entry["line"]) == (str(cases), 2)


def test_group_of_ships_is_compared_by_diagnosis(cases: Path) -> None:
    entry = entries(ccas("test", cases, "--json"))["H1", "bpr"]

    assert entry["expected"] == {"diagnosis": "cycle"}
    assert entry["got"]["diagnosis"] == "cycle"
    assert entry["got"]["cycle"] == [["S1", "S2", "S3"]]


def test_case_without_ships_counts_neither_way(cases: Path) -> None:
    entry = entries(ccas("test", cases, "--json"))["H2", "bpr"]

    assert (entry["skipped"], entry["passed"], entry["required"]) == (True, False, False)


def test_required_verdict_that_differs_is_a_failure_with_its_place(cases: Path) -> None:
    cases.write_text(CASES.replace("[A], stand_on: [B], strength", "[B], stand_on: [A], strength"))

    done = ccas("test", cases)

    assert done.exit_code == 1
    assert f"{cases}:2: G1 under tran2026: give_way: expected B, got A; stand_on: expected A" in done.stdout


@pytest.mark.parametrize("confidence", ["derived", "unverified"])
def test_verdict_that_is_not_required_may_differ(confidence: str, cases: Path) -> None:
    wrong = CASES.replace("[A], stand_on: [B], strength", "[B], stand_on: [A], strength")
    cases.write_text(wrong.replace("text_seen", confidence))

    done = ccas("test", cases, "--json")

    entry = entries(done)["G1", "tran2026"]
    assert (done.exit_code, json.loads(done.stdout)["failed"]) == (0, 0)
    assert (entry["passed"], entry["required"], entry["confidence"]) == (False, False, confidence)
    assert f"(not required: {confidence})" in ccas("test", cases).stdout


def test_one_ruleset_is_asked_about(cases: Path) -> None:
    found = entries(ccas("test", cases, "--ruleset", "bpr", "--json"))

    assert {ruleset for _, ruleset in found} == {"bpr"}


def test_case_that_cannot_be_read_fails_and_the_others_run(cases: Path) -> None:
    cases.write_text(CASES.replace("head_on}", "head_un}"), encoding="utf-8")

    done = ccas("test", cases, "--json")

    found = entries(done)
    assert done.exit_code == 2
    assert f"{cases}:11:25: got 'head_un'" in done.stderr
    assert (found["G2", ""]["passed"], found["G2", ""]["required"]) == (False, True)
    assert found["G1", "bpr"]["passed"]
    assert json.loads(done.stdout)["failed"] == 1


def test_ruleset_that_is_not_installed_is_told(cases: Path) -> None:
    cases.write_text(CASES.replace("tran2026:", "tran2062:"), encoding="utf-8")

    done = ccas("test", cases, "--json")

    assert done.exit_code == 2
    assert "ruleset tran2062: 2 cases expect something of it, and it is not installed" in done.stderr
    assert "did you mean 'tran2026'?" in done.stderr
    assert json.loads(done.stdout)["not_installed"] == {"tran2062": 2}


def test_ruleset_of_which_no_case_expects_anything_is_told(cases: Path) -> None:
    done = ccas("test", cases, "--ruleset", "tran2026_printed")

    assert (done.exit_code, done.stdout) == (2, "")
    assert "no case expects anything of 'tran2026_printed'" in done.stderr


def test_tests_of_ruleset_files_and_ids_are_run(cases: Path) -> None:
    file = cases.with_name("example.yaml")
    file.write_text(RULESET, encoding="utf-8")

    done = ccas("test", file, "tran2026", "--json")

    assert done.exit_code == 0
    assert {each["ruleset"] for each in json.loads(done.stdout)["cases"]} == {"example", "tran2026"}


def test_given_file_stands_in_for_the_installed_ruleset_of_its_id(cases: Path) -> None:
    file = cases.with_name("mine.yaml")
    text = RULESET.replace("id: example", "id: tran2026").replace("then: give_way", "then: stand_on")
    file.write_text(text.replace("give_way: A, by", "give_way: B, by"), encoding="utf-8")

    found = entries(ccas("test", file, cases, "--json"))

    assert found["the ship from port gives way", "tran2026"]["passed"]
    assert found["G1", "tran2026"]["got"]["give_way"] == ["B"]


def test_coverage_and_mutants_name_the_rule_that_no_case_reaches(cases: Path) -> None:
    file = cases.with_name("example.yaml")
    file.write_text(RULESET, encoding="utf-8")

    found = json.loads(ccas("test", file, "--mutants", "--json").stdout)["coverage"]["example"]
    text = ccas("test", file, "--coverage").stdout

    assert (found["rules"], found["reached"], found["missed"]) == (2, 1, ["never-tested"])
    assert (found["mutants"], found["killed"]) == (4, 2)
    assert {each["rule"] for each in found["survivors"]} == {"never-tested"}
    assert "example: 1 of 2 rules decide a case\n    no case reaches never-tested" in text
    assert "mutant" not in text


def test_counts_are_told_for_each_ruleset(cases: Path) -> None:
    rows = [line.split() for line in ccas("test", cases).stdout.splitlines()]

    assert ["bpr", "2", "0", "0", "1"] in rows
    assert ["tran2026", "2", "0", "0", "0"] in rows


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("empty.yaml", b"", "the file is empty"),
        ("binary.yaml", bytes(range(256)), "is not UTF-8"),
        ("list.yaml", b"[1, 2]", "there are no cases in this file"),
        ("scenario.yaml", b"schema: ccas/scenario@1\n", "there are no cases in this file"),
        ("newer.yaml", b"schema: ccas/ruleset@9\n", "written for another version of ccas"),
        ("broken.yaml", b"golden_cases: [", "expected"),
        ("text.yaml", b"golden_cases: none\n", "got 'none'"),
        ("folder.yaml", None, "Is a directory"),
        ("nowhere.yaml", None, "No such file"),
        ("brp", None, "did you mean 'bpr'?"),
    ],
)
def test_nonsense_is_told_and_the_rest_is_run(
    name: str, content: bytes | None, told: str, cases: Path
) -> None:
    file = cases.with_name(name)
    if content is not None:
        file.write_bytes(content)
    elif name == "folder.yaml":
        file.mkdir()

    done = ccas("test", name if name == "brp" else file, cases, "--json")

    assert done.exit_code == 2
    assert told in done.stderr
    assert len(json.loads(done.stdout)["cases"]) == 5


def test_unknown_ruleset_is_told_with_what_was_probably_meant(cases: Path) -> None:
    done = ccas("test", cases, "--ruleset", "brp")

    assert (done.exit_code, done.stdout) == (2, "")
    assert "unknown ruleset 'brp'" in done.stderr
    assert "did you mean 'bpr'?" in done.stderr
