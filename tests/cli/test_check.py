"""`ccas check`: all findings of all files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import ccas_scenarios
from ccas_cli.border_notes import borders_of
from ccas_core.plugins import load
from ccas_core.regions import Region
from ccas_core.sim.scenario import Scenario
from ccas_core.tapd.facts import PairFacts
from ccas_core.tapd.ruleset import PairRuleset
from ccas_core.verdict import Verdict
from ccas_core.waterway import Waters, Waterway

from . import TWO_SHIPS, ccas
from .test_cases import CASES, RULESET

SCENARIOS = Path(ccas_scenarios.__file__).parent


def test_file_that_is_well_has_no_findings(two_ships: Path) -> None:
    done = ccas("check", two_ships)

    assert (done.exit_code, done.stdout) == (0, "")
    assert done.stderr == "1 file read: nothing is wrong\n"


def test_a_shipped_scenario_is_checked_by_its_name() -> None:
    done = ccas("check", "tran2026/fig_12", "fig_13")

    assert (done.exit_code, done.stdout) == (0, "")
    assert done.stderr == "2 files read: nothing is wrong\n"


def test_what_is_neither_a_file_nor_a_shipped_scenario_is_told_beside_the_rest(two_ships: Path) -> None:
    done = ccas("check", "fig_21", two_ships)

    assert done.exit_code == 2
    assert done.stdout.startswith("fig_21: no shipped scenario has this name")
    assert done.stderr == "1 file read: 1 finding\n"


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
    assert f"{two_ships}:25:24: [E101] unknown key 'iteration'" in done.stdout
    assert "did you mean 'iterations'?" in done.stdout
    assert "    |                        ^^^^^^^^^\n" in done.stdout


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


def test_ruleset_that_can_be_used_has_remarks_and_ends_with_1(tmp_path: Path) -> None:
    file = tmp_path / "example.yaml"
    file.write_text(RULESET, encoding="utf-8")

    done = ccas("check", file)

    assert done.exit_code == 1
    assert done.stdout.splitlines() == [
        f"{file}:12:9: [R107] rule 'never-tested' has no test",
        " 12 |   - id: never-tested",
        "    |         ^^^^^^^^^^^^",
        "    hint: write one under 'tests', with 'expect: {by: never-tested, …}'",
    ]
    assert done.stderr == "1 file read: 1 remark\n"


def test_ruleset_that_cannot_be_used_has_errors_with_codes_and_ends_with_2(tmp_path: Path) -> None:
    file = tmp_path / "example.yaml"
    wrong = RULESET.replace("has_other_on_starboard ==", "has_other_on_starbord ==")
    file.write_text(wrong.replace("when: head_on", "when: head_on and own.length > 20"), encoding="utf-8")

    done = ccas("check", file, "--json")

    found = json.loads(done.stdout)
    assert done.exit_code == 2
    assert [(each["code"], each["line"], each["severity"]) for each in found] == [
        ("E103", 10, "error"),
        ("E104", 14, "error"),
    ]
    assert found[0]["width"] == len("has_other_on_starbord")
    assert found[0]["hint"] == "did you mean 'has_other_on_starboard'?"
    assert RULESET.splitlines()[9].startswith(found[0]["excerpt"][: found[0]["column"] - 1])


def test_carets_stand_under_the_whole_of_what_is_meant(tmp_path: Path) -> None:
    file = tmp_path / "example.yaml"
    file.write_text(RULESET.replace("when: head_on", "when: head_on and own.length > 20"), encoding="utf-8")

    lines = ccas("check", file).stdout.splitlines()

    marked = {lines[2][n] for n in range(len(lines[2])) if lines[1][n : n + 1] and lines[2][n] == "^"}
    begin, end = lines[2].index("^"), lines[2].rindex("^") + 1
    assert marked == {"^"}
    assert lines[1][begin:end] == "own.length > 20"


def test_encounter_file_is_checked(tmp_path: Path) -> None:
    file = tmp_path / "cases.yaml"
    file.write_text(CASES, encoding="utf-8")
    well = ccas("check", file)
    file.write_text(CASES.replace("length_m: 85.0}, B", "lenght_m: 85.0}, B", 1), encoding="utf-8")
    wrong = ccas("check", file)
    file.write_text(CASES.replace("tran2026:", "tran2062:"), encoding="utf-8")
    unknown = ccas("check", file)

    assert (well.exit_code, wrong.exit_code, unknown.exit_code) == (0, 2, 1)
    assert "[E103] unknown fact of a ship 'lenght_m'" in wrong.stdout
    assert "did you mean 'length_m'?" in wrong.stdout
    assert f"{file}:7:5: [R113] ruleset 'tran2062' is not installed" in unknown.stdout


def test_shipped_rulesets_can_be_used() -> None:
    import ccas_rulesets

    done = ccas("check", Path(str(ccas_rulesets.__file__)).parent, "--json")

    assert [each for each in json.loads(done.stdout) if each["severity"] == "error"] == []


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "the file is empty"),
        (bytes(range(256)), "is not UTF-8"),
        (b"schema: ccas/ruleset@1\n", "the key 'id' is missing here"),
        (b"schema: [1]\n", "expected: ccas/scenario@1"),
        (b"golden_cases: {}\n", "got keys with values"),
        (b"cases:\n- 3\n", "got '3'"),
        (b"- 1\n", "the file holds a list"),
    ],
)
def test_nonsense_is_a_finding(content: bytes, told: str, tmp_path: Path) -> None:
    file = tmp_path / "nonsense.yaml"
    file.write_bytes(content)

    done = ccas("check", file)

    assert done.exit_code == 2
    assert told in done.stdout


def test_sweeps_are_checked_and_all_that_is_shipped_is_well(tmp_path: Path) -> None:
    text = (SCENARIOS / "sweeps" / "border_short.yaml").read_text(encoding="utf-8")
    file = tmp_path / "sweep.yaml"
    file.write_text(text.replace("draw: head_on", "draw: headon", 1), encoding="utf-8")

    assert "got 'headon'" in ccas("check", file).stdout
    assert ccas("check", *(SCENARIOS / part for part in ("sweeps", "tran2026", "zhenjiang"))).exit_code == 0


# --- borders --------------------------------------------------------------------------------------


def bordered(two_ships: Path, far: str = "bpr") -> Path:
    polygon = "[[-50, -600], [900, -600], [900, 600], [-50, 600]]"
    region = f"regions: [{{id: east, ruleset: {far}, polygon: {polygon}}}]"
    two_ships.write_text(TWO_SHIPS.replace("regions: []", region), encoding="utf-8")
    return two_ships


def test_each_border_of_a_scenario_is_looked_at_and_its_verdict_told(two_ships: Path) -> None:
    done = ccas("check", bordered(two_ships))

    assert done.exit_code == 0  # ships agree on one law: a border that is refuted is no fault of the scenario
    assert (
        f"{two_ships}: border tran2026 | bpr: refuted, ships that did not agree on one law might"
        in done.stdout
    )
    assert "`ccas check-consistency --border tran2026 bpr` shows such ships" in done.stdout
    assert done.stderr == "1 file read: nothing is wrong\n"


def test_programs_are_told_the_verdict_of_a_border(two_ships: Path) -> None:
    (told,) = json.loads(ccas("check", bordered(two_ships), "--json").stdout)

    assert (told["severity"], told["border"], told["verdict"]) == ("note", ["tran2026", "bpr"], "refuted")
    assert (told["waived"], told["source"]) == (False, str(two_ships))


def test_no_border_is_told_where_the_law_is_the_same_or_there_is_no_water(two_ships: Path) -> None:
    done = ccas("check", bordered(two_ships, "tran2026"))
    assert (done.exit_code, done.stdout) == (0, "")

    text = TWO_SHIPS.replace(
        "regions: []", "regions: [{id: east, ruleset: bpr, polygon: [[900, 0], [990, 0], [990, 90]]}]"
    )
    two_ships.write_text(text, encoding="utf-8")
    assert ccas("check", two_ships).stdout == ""


def test_nothing_can_be_proved_of_a_border_with_a_ruleset_in_python() -> None:
    waters = Waters(
        ruleset="bpr",
        waterways=(Waterway(id="r", centreline=np.array([[0.0, -900.0], [0.0, 900.0]]), width=90.0),),
        regions=(
            Region(id="e", ruleset="python", polygon=np.array([[-99.0, 0], [-99, 999], [99, 999], [99, 0]])),
        ),
    )
    rulesets = {"bpr": load().rulesets["bpr"], "python": InPython()}
    (note,) = borders_of(Scenario(name="x", waters=waters, ships=()), "x.yaml", rulesets)

    assert (note.verdict, note.hint) == ("undecided", "")
    assert note.message == "border bpr | python: undecided, for nothing can be proved of a ruleset in Python"


class InPython(PairRuleset):
    """A ruleset that is not in a file."""

    id, version, title = "python", "1", "in Python"

    def judge(self, facts: PairFacts) -> Verdict:
        """Judge nothing."""
        raise NotImplementedError
