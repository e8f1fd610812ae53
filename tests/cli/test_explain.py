"""`ccas explain`: scenarios, cases and moments of a voyage; why not, and what would change it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from . import TWO_SHIPS, ccas
from .test_cases import CASES, RULESET, cases

__all__ = ["cases"]  # a fixture

ARTICLE = "Tran et al. 2026 Sec. 3.1, crossing"
SHIPS = ("ship_1", "ship_2")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Sail two ships once."""
    folder = tmp_path_factory.mktemp("voyage")
    (folder / "two_ships.yaml").write_text(TWO_SHIPS, encoding="utf-8")
    done = ccas(
        "simulate", folder / "two_ships.yaml", "--solver", "riccati", "--out", folder / "run", "--json"
    )
    assert done.exit_code in (0, 1)
    return folder / "run"


def told(*arguments: str | Path) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(ccas("explain", *arguments, "--json").stdout)
    return found


def walked(conditions: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    for each in conditions:
        yield each
        yield from walked(each["parts"])


def test_scenario_is_explained_by_the_conditions_of_both_views(two_ships: Path) -> None:
    (pair,) = told(two_ships)

    assert pair["pair"] == list(SHIPS)
    for ship in SHIPS:
        (rule,) = pair["explanations"][ship]["rules"]
        assert (rule["rule"], rule["article"], rule["holds"]) == ("crossing.from-starboard", ARTICLE, True)
        assert rule["confidence"] == "text_seen"
        assert rule["text"]
        found = {each["condition"]: each for each in walked(rule["conditions"])}
        reaches = found["ship_1.time_to_intersection < 900 s"]
        assert (reaches["value"], reaches["number"], reaches["limit"]) == (True, 100.0, 900.0)
        assert (reaches["margin"], reaches["unit"]) == (800.0, "s")


def test_text_has_value_and_margin_in_columns(two_ships: Path) -> None:
    text = ccas("explain", two_ships).stdout

    assert "ship_1 and ship_2: crossing: ship_1 gives way, ship_2 stands on" in text
    assert f"rule crossing.from-starboard, {ARTICLE} (text_seen" in text
    line = next(line for line in text.splitlines() if "ship_1.time_to_intersection < 900 s" in line)
    assert line.split(" s ")[1].split() == ["100.0"]
    assert line.endswith("   800.0 s inside")
    assert "for the same reasons" in text


def test_why_not_tells_what_fails_for_the_ship_that_gives_way(two_ships: Path) -> None:
    text = ccas("explain", two_ships, "--why-not", "stand_on").stdout
    (pair,) = told(two_ships, "--why-not", "stand_on")

    assert text.count("why not stand_on:") == 1  # the other one does stand on
    assert "ship_1.follows_starboard_side" in text
    nearest = pair["why_not"]["ship_1"][0]
    assert (len(nearest["failed"]), nearest["possible"]) == (1, True)


def test_flip_tells_the_smallest_change_in_words(two_ships: Path) -> None:
    (pair,) = told(two_ships, "--flip")
    text = ccas("explain", two_ships, "--flip").stdout

    assert pair["flips"]
    assert all(each["words"] in text for each in pair["flips"])


def test_case_is_explained_under_every_ruleset_that_it_names(cases: Path) -> None:
    found = told(cases, "--case", "G1")

    assert [(each["case"], each["ruleset"], each["passed"]) for each in found] == [
        ("G1", "tran2026", True),
        ("G1", "bpr", True),
    ]
    assert "as expected" in ccas("explain", cases, "--case", "G1", "--ruleset", "bpr").stdout


def test_case_is_explained_under_a_ruleset_that_it_does_not_name(cases: Path) -> None:
    (found,) = told(cases, "--case", "G2", "--ruleset", "bpr")

    assert found["explanations"]["A"]["rules"][0]["rule"] == "head-on.large"


def test_pair_of_a_group_is_chosen(cases: Path) -> None:
    assert len(told(cases, "--case", "H1")) == 3
    assert [each["pair"] for each in told(cases, "--case", "H1", "--pair", "S3", "S1")] == [["S1", "S3"]]


def test_group_with_positions_has_flips(cases: Path) -> None:
    (pair,) = told(cases, "--case", "H1", "--pair", "S1", "S2", "--flip")

    assert {each["unit"] for each in pair["flips"]} == {"deg", "m/s"}


def test_case_without_positions_says_why_there_is_no_flip(cases: Path) -> None:
    text = ccas("explain", cases, "--case", "G2", "--flip").stdout

    assert "no change is looked for, for positions and courses are not known" in text


def test_test_of_a_ruleset_file_is_explained(cases: Path) -> None:
    file = cases.with_name("example.yaml")
    file.write_text(RULESET, encoding="utf-8")

    (found,) = told(file)

    assert found["explanations"]["A"]["rules"][0]["source"] == f"{file}:8"
    assert told("tran2026", "--case", "the overtaking ship gives way")[0]["passed"]


def test_moment_of_a_voyage_is_explained_from_its_poses(run: Path) -> None:
    (pair,) = told(run, "--time", "25")

    assert (pair["time_s"], pair["recomputed"]) == (20.0, True)
    assert pair["explanations"]["ship_1"]["rules"]
    text = ccas("explain", run, "--time", "25").stdout
    assert text.startswith("at 20 s\nship_1 and ship_2: ")
    assert "the encounter is remembered from its beginning" in text


def test_moments_of_a_voyage_over_a_border_are_explained_by_the_law_of_each_pair(tmp_path: Path) -> None:
    """A ship that stops at once is looked at with the speed that it still had."""
    ccas("simulate", "borders/bpr_ccnr_crossing", "--out", tmp_path / "run", "--no-pictures", "--quiet")

    for time, laws in (("0", {"bpr", "ccnr"}), ("400", {"bpr", "ccnr"}), ("520", {"bpr"})):
        pairs = told(tmp_path / "run", "--time", time)
        assert [pair["recomputed"] for pair in pairs] == [True] * len(pairs)
        assert {view["ruleset"] for pair in pairs for view in pair["verdicts"].values()} == laws


def test_record_alone_is_told_where_the_poses_say_otherwise(run: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    copy.mkdir()
    for file in run.glob("*.*"):
        copy.joinpath(file.name).write_bytes(file.read_bytes())
    decisions = (copy / "decisions.jsonl").read_text(encoding="utf-8")
    changed = decisions.replace("crossing.from-starboard", "crossing.by-another-rule")
    (copy / "decisions.jsonl").write_text(changed, encoding="utf-8")

    (pair,) = told(copy, "--time", "0")

    assert (pair["recomputed"], pair["explanations"]) == (False, {})
    text = ccas("explain", copy, "--time", "0", "--flip", "--why-not", "stand_on").stdout
    assert "only what was recorded is told: computed again from frames.csv" in text
    assert "rule crossing.by-another-rule" in text


def test_record_alone_is_told_where_the_scenario_cannot_be_used(run: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    copy.mkdir()
    for file in run.glob("*.*"):
        copy.joinpath(file.name).write_bytes(file.read_bytes())
    (copy / "scenario.yaml").write_text("schema: ccas/scenario@1\n", encoding="utf-8")

    done = ccas("explain", copy, "--time", "0")

    assert done.exit_code == 0
    assert "only what was recorded is told, for the scenario cannot be used" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "told_"),
    [
        ("{run}", "say when"),
        ("{run} --time 1e9", "expected: a time from 0 to "),
        ("{run} --time nan", "nothing was sailed at nan s"),
        ("{run} --time 0 --pair ship_1 ship_9", "did you mean 'ship_"),
        ("{run} --time 0 --case x", "--case: has no meaning here"),
        ("{run} --time 0 --ruleset bpr", "--ruleset: has no meaning here"),
        ("{cases}", "say which case"),
        ("{cases} --case G9", "known: G1, G2, H1, H2"),
        ("{cases} --case H2", "has no ships to explain"),
        ("{cases} --case G1 --ruleset brp", "did you mean 'bpr'?"),
        ("{cases} --case G1 --pair A C", "unknown ship 'C'"),
        ("{cases} --case G1 --time 4", "--time: has no meaning here"),
        ("{cases} --case G1 --why-not stand_off", "did you mean 'stand_on'?"),
        ("fig_12 --case x", "--case: has no meaning here"),
        ("bpr --case nothing", "there is no case 'nothing'"),
        ("{folder}", "no run is here"),
        ("{folder}/nowhere.yaml", "No such file"),
        ("brp", "brp"),
    ],
)
def test_wrong_use_is_told_and_ends_with_2(arguments: str, told_: str, cases: Path, run: Path) -> None:
    folder = cases.with_name("empty")
    folder.mkdir()
    filled = [each.format(run=run, cases=cases, folder=folder) for each in arguments.split()]

    done = ccas("explain", *filled)

    assert (done.exit_code, done.stdout) == (2, "")
    assert told_ in done.stderr


def test_damaged_decisions_are_told_with_their_line(run: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    copy.mkdir()
    for file in run.glob("*.*"):
        copy.joinpath(file.name).write_bytes(file.read_bytes())
    (copy / "decisions.jsonl").write_text('{"time_s": 0.0, "pair": 3}\n', encoding="utf-8")

    done = ccas("explain", copy, "--time", "0")

    assert done.exit_code == 2
    assert f"{copy / 'decisions.jsonl'}:1:1: cannot be understood" in done.stderr


def test_broken_case_is_told_with_its_findings(cases: Path) -> None:
    cases.write_text(CASES.replace("head_on}", "head_un}"), encoding="utf-8")

    done = ccas("explain", cases, "--case", "G2")

    assert done.exit_code == 2
    assert "got 'head_un'" in done.stderr
    assert ccas("explain", cases, "--case", "G1").exit_code == 0
