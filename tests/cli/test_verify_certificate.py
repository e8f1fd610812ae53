"""`ccas verify-certificate`, and the options of `ccas check-consistency` that go with it."""

from __future__ import annotations

from pathlib import Path

from . import ccas


def test_a_certificate_is_written_and_verified(tmp_path: Path) -> None:
    file = tmp_path / "proof.json"
    wanted = ("--property", "consistent", "--certificate", file, "--out", tmp_path)

    made = ccas("check-consistency", "tran2026", *wanted)
    done = ccas("verify-certificate", file)

    assert made.exit_code == 0
    assert f"certificate written: {file}" in made.stderr
    assert done.exit_code == 0
    assert "consistent: certificate for all of 4 statements" in done.stdout


def test_a_certificate_that_was_changed_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "proof.json"
    ccas(
        "check-consistency", "tran2026", "--property", "consistent", "--certificate", file, "--out", tmp_path
    )
    file.write_text(file.read_text().replace('"version": "2', '"version": "3'))

    done = ccas("verify-certificate", file)

    assert done.exit_code == 1
    assert "version 3.0.0, the ruleset has 2.0.0" in done.stderr


def test_a_certificate_is_none_of_another_ruleset(tmp_path: Path) -> None:
    file = tmp_path / "proof.json"
    ccas(
        "check-consistency", "tran2026", "--property", "consistent", "--certificate", file, "--out", tmp_path
    )

    done = ccas("verify-certificate", file, "bpr")

    assert done.exit_code == 1
    assert "it is about ruleset tran2026, the ruleset has bpr" in done.stderr


def test_how_near_encounters_lie_to_a_limit_is_told(tmp_path: Path) -> None:
    wanted = ("--property", "consistent", "--out", tmp_path, "--sensor-error")

    done = ccas("check-consistency", "tran2026", *wanted, "10,1,0.1")
    wrong = ccas("check-consistency", "tran2026", *wanted, "10")

    assert done.exit_code == 0
    assert "with sensor errors of 10 m, 1 deg and 0.1 m/s" in done.stderr
    assert "ships disagree until they exchange verdicts" in done.stderr
    assert wrong.exit_code == 2
    assert "three numbers are needed" in wrong.stderr
