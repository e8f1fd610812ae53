"""`ccas check-consistency`: what is told, how it ends, and which files are left."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import Result

from ..proofs import SOUND, broken, with_waiver_text, written
from . import MAIN, ccas


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Run the program from a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def prove(text: str, *options: str | Path) -> Result:
    file = written(Path.cwd(), text).relative_to(Path.cwd())
    return ccas("check-consistency", file, *options)


def proved(text: str, *options: str | Path) -> tuple[int, dict[str, Any]]:
    """Exit code, and what is told of one ruleset."""
    done = prove(text, "--json", *options)
    (found,) = json.loads(done.stdout)
    return done.exit_code, found


CONSISTENT = ("--property", "consistent")
TIE = ("--property", "tie_break_total")


# -- JSON and exit codes -------------------------------------------------------------------------


def test_what_is_proved_ends_clean() -> None:
    code, found = proved(SOUND, *CONSISTENT, "--property", "complete")

    assert code == 0
    assert found["ruleset"] == "mini"
    assert [each["name"] for each in found["properties"]] == ["consistent", "complete"]
    for each in found["properties"]:
        assert (each["verdict"], each["waived"], each["counterexamples"]) == ("proved", False, [])
        assert each["method"]
        assert each["seconds"] >= 0.0


def test_what_is_refuted_ends_with_findings_and_leaves_ships(folder: Path) -> None:
    code, found = proved(broken("consistent"), *CONSISTENT)
    (finding,) = found["properties"]

    assert code == 1
    assert (finding["verdict"], finding["waived"]) == ("refuted", False)
    assert finding["counterexamples"] == ["counterexamples/mini/consistent-1.yaml"]
    (fault,) = finding["faults"]
    assert fault["rules"] == ["crossing"]
    assert fault["articles"] == ["Mini 3"]
    assert {view["kind"] for view in fault["views"]} == {"give_way"}
    for key in ("scenario", "encounter", "picture"):
        assert (folder / fault[key]).is_file()


def test_counterexample_is_read_by_the_other_commands(folder: Path) -> None:
    _, found = proved(broken("consistent"), *CONSISTENT, "--no-pictures")
    (scenario,) = found["properties"][0]["counterexamples"]
    encounter = found["properties"][0]["faults"][0]["encounter"]
    told = json.loads(ccas("explain", scenario, "--ruleset", "mini.yaml", "--json").stdout)

    assert ccas("test", encounter, "--ruleset", "mini.yaml").exit_code == 0
    assert {view["kind"] for view in told[0]["verdicts"].values()} == {"give_way"}
    assert not list(folder.rglob("*.png"))


def test_folder_of_the_ships_can_be_chosen(folder: Path) -> None:
    _, found = proved(broken("consistent"), *CONSISTENT, "--out", "here", "--no-pictures")

    assert found["properties"][0]["counterexamples"] == ["here/mini/consistent-1.yaml"]
    assert not (folder / "counterexamples").exists()


def test_ships_of_an_earlier_look_are_removed(folder: Path) -> None:
    proved(broken("consistent"), *CONSISTENT, "--no-pictures")
    proved(SOUND, *CONSISTENT)

    assert not list(folder.rglob("consistent-*"))


def test_what_is_refuted_and_waived_ends_clean() -> None:
    code, found = proved(with_waiver_text(broken("tie_break_total"), "tie_break_total"), *TIE)
    (finding,) = found["properties"]

    assert code == 0
    assert (finding["verdict"], finding["waived"]) == ("refuted", True)
    assert finding["faults"][0]["waiver"] == {
        "reason": "the law says so",
        "expires": "2999-12-31",
        "expired": False,
    }


def test_waiver_that_has_expired_covers_nothing() -> None:
    code, found = proved(with_waiver_text(broken("tie_break_total"), "tie_break_total", "2020-01-01"), *TIE)
    (finding,) = found["properties"]

    assert code == 1
    assert (finding["verdict"], finding["waived"]) == ("refuted", False)
    assert finding["faults"][0]["waiver"]["expired"]


def test_time_that_does_not_suffice_ends_undecided() -> None:
    code, found = proved(SOUND, *CONSISTENT, "--budget", "0")
    (finding,) = found["properties"]

    assert code == 3
    assert (finding["verdict"], finding["counterexamples"]) == ("undecided", [])
    assert finding["open"]


def test_fault_without_waiver_counts_for_more_than_what_is_undecided() -> None:
    code, _ = proved(broken("tie_break_total"), *CONSISTENT, *TIE, "--budget", "0")

    assert code == 1


def test_several_rulesets_are_told_in_their_order() -> None:
    written(Path.cwd(), SOUND.replace("id: mini", "id: other"), "other.yaml")
    done = prove(SOUND, "other.yaml", "--json", *TIE)

    assert [each["ruleset"] for each in json.loads(done.stdout)] == ["mini", "other"]


def test_assumption_narrows_the_domain() -> None:
    code, found = proved(
        broken("complete"), "--property", "complete", "--assume", "own.ferry and other.ferry"
    )

    assert code == 0
    assert "assumed" in found["domain"]


def test_older_version_is_compared_with() -> None:
    old = written(Path.cwd(), SOUND.replace("has_starboard(own)", "has_starboard(other)"), "old.yaml")
    code, found = proved(SOUND, *TIE, "--against", old.name, "--no-pictures")

    assert code == 1
    assert [each["name"] for each in found["properties"]] == ["tie_break_total", "against"]
    assert found["properties"][1]["counterexamples"]


def test_border_is_looked_at_without_a_ruleset() -> None:
    written(Path.cwd(), SOUND, "one.yaml")
    swapped = SOUND.replace("id: mini", "id: swapped").replace("has_starboard(own)", "has_starboard(other)")
    written(Path.cwd(), swapped, "two.yaml")
    done = ccas("check-consistency", "--border", "one.yaml", "two.yaml", "--json", "--no-pictures")
    (found,) = json.loads(done.stdout)

    assert done.exit_code == 1
    assert found["ruleset"] == "mini|swapped"
    assert [each["name"] for each in found["properties"]] == ["border"]


# -- text ----------------------------------------------------------------------------------------


def test_text_shows_rule_ships_views_and_how_to_sail_them() -> None:
    done = prove(broken("consistent"), *CONSISTENT, "--no-pictures")
    lines = done.stdout.splitlines()

    assert done.exit_code == 1
    assert lines[0].startswith("mini 1.0.0   3 rules, ")
    assert "  consistent  REFUTED    1 fault; " in done.stdout
    assert "consistent 1: both ships give way by rule 'crossing'" in lines
    assert "  --> mini.yaml:18:9: rule 'crossing', Mini 3" in lines
    excerpt = next(n for n, line in enumerate(lines) if "|   - id: crossing" in line)
    assert lines[excerpt + 1].index("^") == lines[excerpt].index("crossing")
    assert lines[excerpt + 1].count("^") == len("crossing")
    assert "  = A gives way to B (Mini 3), by 'crossing'" in lines
    assert "  = B gives way to A (Mini 3), by 'crossing'" in lines
    assert any(line.startswith("  = A sees B ") for line in lines)
    assert any(line.startswith("  = margin ") for line in lines)
    assert "ccas simulate counterexamples/mini/consistent-1.yaml --ruleset mini.yaml" in done.stdout


def test_text_shows_a_waiver_with_reason_and_day() -> None:
    done = prove(with_waiver_text(broken("tie_break_total"), "tie_break_total"), *TIE)

    assert "tie_break_total 1, waived: " in done.stdout
    assert "= waived until 2999-12-31 (mini.yaml:" in done.stdout
    assert "): the law says so" in done.stdout


def test_progress_is_told_on_stderr_a_line_a_property() -> None:
    done = prove(SOUND, *TIE, *CONSISTENT)

    assert [line.partition(",")[0] for line in done.stderr.splitlines()] == [
        "mini: consistent proved",
        "mini: tie_break_total proved",
    ]


def test_json_leaves_stderr_silent() -> None:
    assert prove(SOUND, *TIE, "--json").stderr == ""


def test_register_is_written_with_its_files(folder: Path) -> None:
    done = prove(broken("consistent"), *CONSISTENT, "--register", "findings")
    page = (folder / "findings" / "README.md").read_text(encoding="utf-8")

    assert done.exit_code == 1
    assert "both ships give way by rule 'crossing'" in page
    assert (folder / "findings" / "mini" / "consistent-1.png").is_file()
    assert not (folder / "counterexamples").exists()


# -- wrong use -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ((), "nothing to check"),
        (("nope",), "unknown ruleset 'nope'"),
        (("nowhere.yaml",), "nowhere.yaml: cannot be read"),
        (("bpr", "--property", "consistant"), "did you mean 'consistent'?"),
        (("bpr", "--assume", "own.lenght > 5 m"), "--assume:1:1: unknown fact 'own.lenght'"),
        (("bpr", "--assume", "((("), "--assume:1:4"),
        (("bpr", "--budget", "soon"), "--budget"),
        (("bpr", "--max-ships", "1"), "--max-ships"),
        (("--border", "bpr", "nope"), "unknown ruleset 'nope'"),
        (("bpr", "--against", "nope"), "unknown ruleset 'nope'"),
    ],
)
def test_nonsense_is_refused_with_a_reason(arguments: tuple[str, ...], told: str) -> None:
    done = ccas("check-consistency", *arguments)

    assert done.exit_code == 2
    assert told in done.stderr
    assert done.stdout == ""


def test_file_that_is_no_ruleset_is_refused_with_its_place() -> None:
    done = prove("schema: ccas/ruleset@1\nid: mini\nrules: 3\n")

    assert done.exit_code == 2
    assert "mini.yaml:3:8" in done.stderr


# -- Ctrl-C --------------------------------------------------------------------------------------


def interrupted(monkeypatch: pytest.MonkeyPatch, name: str) -> Callable[..., None]:
    """Let a property end as Ctrl-C would end it."""
    from ccas_core.proofs import pairs

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(pairs, name, stop)
    return stop


def test_ctrl_c_shows_what_is_known_by_then(monkeypatch: pytest.MonkeyPatch) -> None:
    interrupted(monkeypatch, "tie_break_total")
    code, found = proved(SOUND, *TIE, *CONSISTENT)

    assert code == 130
    assert [(each["name"], each["verdict"]) for each in found["properties"]] == [
        ("consistent", "proved"),
        ("tie_break_total", "undecided"),
    ]


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_reaches_a_proof_at_work(folder: Path) -> None:
    written(folder, SOUND)
    command = (sys.executable, "-c", MAIN, "check-consistency", "mini.yaml", "--no-pictures")
    with subprocess.Popen(
        command, cwd=folder, env=dict(os.environ), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as running:
        assert running.stderr is not None
        running.stderr.readline()  # the first property is done
        running.send_signal(signal.SIGINT)
        told, _ = running.communicate(timeout=60)

    assert running.returncode == 130
    assert "domain_not_empty" in told
