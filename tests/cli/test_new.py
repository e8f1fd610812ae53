"""`ccas new` and `ccas schema`: what they write passes all checks, and nothing is overwritten."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ccas_core import plugins
from ccas_core.tapd.case_run import run_case
from ccas_core.tapd.coverage import covered
from ccas_core.tapd.ruleset_schema import FILE_NAME, MODELINE
from ccas_core.tapd.written import WrittenRuleset

from . import ccas


def read(path: Path) -> WrittenRuleset:
    found = plugins.load().ruleset(str(path))
    assert isinstance(found, WrittenRuleset)
    return found


def failed(ruleset: WrittenRuleset) -> list[str]:
    return [
        case.id
        for case in ruleset.text.tests
        if not run_case(ruleset, case, case.expected[ruleset.id]).passed
    ]


def test_new_ruleset_passes_its_tests_and_has_nothing_to_remark(tmp_path: Path) -> None:
    done = ccas("new", "ruleset", "my_river", "--out", tmp_path)
    ruleset = read(tmp_path / "my_river.yaml")

    assert done.exit_code == 0
    assert done.stdout.splitlines() == [str(tmp_path / "my_river.yaml"), str(tmp_path / FILE_NAME)]
    assert "next: ccas check" in done.stderr
    assert (ruleset.id, ruleset.title, ruleset.text.lineage) == ("my_river", "My river", ("common",))
    assert (failed(ruleset), ruleset.text.remarks) == ([], ())
    found = covered(ruleset, ruleset.text.tests)
    assert (found.missed, found.survivors) == ((), ())


@pytest.mark.parametrize("base", ["bpr", "tran2026"])
def test_new_ruleset_on_a_base_with_rules_is_an_overlay(base: str, tmp_path: Path) -> None:
    done = ccas("new", "ruleset", "my_harbour", "--extends", base, "--out", tmp_path)
    ruleset = read(tmp_path / "my_harbour.yaml")

    assert done.exit_code == 0
    assert ruleset.text.lineage[0] == base
    assert ruleset.text.rules[0].id == "my_harbour.short"
    assert (failed(ruleset), ruleset.text.remarks) == ([], ())


def test_new_ruleset_names_its_schema_which_lies_beside_it(tmp_path: Path) -> None:
    ccas("new", "ruleset", "my_river", "--out", tmp_path)

    assert (tmp_path / "my_river.yaml").read_text(encoding="utf-8").startswith(f"{MODELINE}\n")
    assert json.loads((tmp_path / FILE_NAME).read_text(encoding="utf-8"))["$schema"].endswith(
        "draft-07/schema#"
    )


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    ccas("new", "ruleset", "my_river", "--out", tmp_path)
    (tmp_path / "my_river.yaml").write_text("mine", encoding="utf-8")

    done = ccas("new", "ruleset", "my_river", "--out", tmp_path)

    assert done.exit_code == 2
    assert "it is there already" in done.stderr
    assert (tmp_path / "my_river.yaml").read_text(encoding="utf-8") == "mine"
    assert ccas("new", "ruleset", "other_river", "--out", tmp_path).exit_code == 0


@pytest.mark.parametrize("name", ["My", "1st", "a b", "a.yaml", "../a", "-", "null", "", "a" * 61])
@pytest.mark.parametrize("what", ["ruleset", "plugin"])
def test_name_that_cannot_be_is_refused(what: str, name: str, tmp_path: Path) -> None:
    done = ccas("new", what, "--out", tmp_path, "--", name)

    assert done.exit_code == 2
    assert f"this cannot be the name of a {what}" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_id_of_a_ruleset_that_there_is_is_refused(tmp_path: Path) -> None:
    assert "there is a ruleset of this id" in ccas("new", "ruleset", "bpr", "--out", tmp_path).stderr


def test_base_that_there_is_not_is_told_with_the_nearest(tmp_path: Path) -> None:
    done = ccas("new", "ruleset", "x", "--extends", "comon", "--out", tmp_path)

    assert done.exit_code == 2
    assert "did you mean 'common'?" in done.stderr


def test_new_plugin_can_be_installed_and_its_tests_pass(tmp_path: Path) -> None:
    done = ccas("new", "plugin", "my-harbour", "--out", tmp_path)
    folder, site = tmp_path / "ccas-my-harbour", tmp_path / "site"
    assert done.exit_code == 0

    command = ("-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--no-build-isolation")
    installed = subprocess.run(
        (sys.executable, *command, "--target", site, folder), capture_output=True, text=True, check=False
    )
    assert installed.returncode == 0, installed.stderr
    path = os.pathsep.join(filter(None, (str(site), os.environ.get("PYTHONPATH", ""))))
    tested = subprocess.run(
        (sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"),
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert tested.returncode == 0, tested.stdout
    assert "2 passed" in tested.stdout


def test_schema_is_printed_or_written(tmp_path: Path) -> None:
    shown = ccas("schema").stdout

    assert json.loads(shown)["title"] == "Ruleset of CCAS (ccas/ruleset@1)"
    assert ccas("schema", "ruleset", "--write", tmp_path).exit_code == 0
    assert (tmp_path / FILE_NAME).read_text(encoding="utf-8") == shown
    assert ccas("schema", "--write", tmp_path / "none" / "x.json").exit_code == 2
