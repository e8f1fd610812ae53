"""`ccas diff`: where two rulesets disagree."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import ccas_rulesets
from ccas_core.tapd.case_file import load_cases

from . import ccas

BPR = Path(ccas_rulesets.__file__).with_name("bpr.yaml")


@pytest.fixture
def changed(tmp_path: Path) -> Path:
    """The BPR with another limit for small ships."""
    text = BPR.read_text(encoding="utf-8")
    path = tmp_path / "bpr_24.yaml"
    path.write_text(text.replace("ship.length < 20 m", "ship.length < 24 m"), encoding="utf-8")
    return path


def test_rulesets_that_agree_exit_clean() -> None:
    done = ccas("diff", "bpr", "bpr", "--samples", "50")

    assert done.exit_code == 0
    assert ": 0 of " in done.stdout


def test_disagreements_are_told_with_both_articles_and_an_example() -> None:
    done = ccas("diff", "bpr", "tran2026", "--samples", "200")

    assert done.exit_code == 1
    assert "the duty differs" in done.stdout
    assert "the side differs" in done.stdout
    assert "    BPR 6.04(3): " in done.stdout
    assert "ships: {A: {length_m: " in done.stdout


def test_same_seed_gives_the_same_answer_as_data() -> None:
    one, two, other = (
        json.loads(ccas("diff", "bpr", "tran2026", "--samples", "100", "--seed", seed, "--json").stdout)
        for seed in ("3", "3", "4")
    )

    assert one == two
    assert one != other
    assert (one["one"]["id"], one["other"]["id"], one["seed"]) == ("bpr", "tran2026", 3)
    assert sum(group["count"] for group in one["groups"]) == one["differing"] < one["tried"]


def test_examples_are_written_as_files_that_are_read_and_checked(tmp_path: Path) -> None:
    out = tmp_path / "differences"
    groups = json.loads(ccas("diff", "bpr", "tran2026", "--samples", "100", "--out", out, "--json").stdout)[
        "groups"
    ]

    files = [Path(file) for group in groups for file in group["files"]]
    scenarios = [file for file in files if file.name.endswith(".scenario.yaml")]
    assert scenarios
    assert len(files) == len(list(out.iterdir())) > len(scenarios)
    for file in set(files) - set(scenarios):
        read = load_cases(file)
        assert read.findings == ()
        assert {"bpr", "tran2026"} == read.cases[0].expected.keys()
    for scenario in scenarios[:5]:
        assert ccas("check", scenario).exit_code == 0
        (pair,) = json.loads(ccas("graph", scenario, "--json").stdout).get("edges") or [None]
        (turned,) = json.loads(ccas("graph", scenario, "--ruleset", "tran2026", "--json").stdout).get(
            "edges"
        ) or [None]
        assert pair != turned


def test_two_versions_of_one_file_are_compared(changed: Path) -> None:
    done = ccas("diff", BPR, changed, "--samples", "300", "--json")

    found = json.loads(done.stdout)
    assert done.exit_code == 1
    for group in found["groups"]:
        lengths = [ship["length_m"] for ship in group["example"]["ships"].values()]
        assert any(20.0 <= length < 24.0 for length in lengths)


def test_encounter_files_are_compared_on(tmp_path: Path, changed: Path) -> None:
    cases = tmp_path / "cases.yaml"
    cases.write_text(
        "cases:\n"
        "- id: between\n"
        "  encounter: {geometry: head_on}\n"
        "  ships: {A: {length_m: 22.0}, B: {length_m: 80.0}}\n"
        "  expected: {bpr: {kind: mutual, give_way: [A, B], stand_on: []}}\n",
        encoding="utf-8",
    )

    done = ccas("diff", "bpr", changed, "--samples", "0", "--cases", cases, "--json")

    groups = json.loads(done.stdout)["groups"]
    (group,) = (each for each in groups if each["example"]["id"] == "between")
    assert (group["one"]["article"], group["other"]["article"]) == ("BPR 6.04(4)", "BPR 6.04(3)")


def test_encounter_file_with_a_fault_is_refused(tmp_path: Path) -> None:
    cases = tmp_path / "cases.yaml"
    cases.write_text("cases:\n- id: a\n  shps: {}\n  expected: {}\n", encoding="utf-8")

    done = ccas("diff", "bpr", "bpr", "--cases", cases)

    assert done.exit_code == 2
    assert "unknown key 'shps'" in done.stderr


def test_ruleset_that_there_is_not_is_refused() -> None:
    done = ccas("diff", "bpr", "brp")

    assert done.exit_code == 2
    assert "did you mean 'bpr'?" in done.stderr
