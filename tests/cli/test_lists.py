"""`ccas rulesets`, `ccas plugins`, `ccas scenarios`: lists for people, and as JSON."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

import ccas_rulesets
from ccas_cli import inputs
from ccas_core import plugins
from ccas_core.hookspecs import hookimpl
from ccas_scenarios import names

from . import ccas


class _Broken:
    """Entry point of a plugin that cannot be imported."""

    name = "broken"
    value = "broken_rules"

    def load(self) -> None:
        raise ImportError("no such thing")


@pytest.fixture
def broken_plugin(monkeypatch: pytest.MonkeyPatch) -> None:
    """Load a broken plugin, and no other."""
    found = plugins.load([_Broken()])
    monkeypatch.setattr(plugins, "load", lambda **_: found)


def test_rulesets_are_listed_with_what_tells_them_apart() -> None:
    done = ccas("rulesets", "--json")

    (corrected,) = [row for row in json.loads(done.stdout) if row["id"] == "tran2026"]
    assert corrected == {
        "id": "tran2026",
        "version": "2.0.0",
        "title": "Priority assignment of Tran et al. 2026, Algorithm 1, corrected",
        "plugin": "rulesets",
        "regulation": "Tran et al. 2026",
        "edition": "doi:10.1016/j.oceaneng.2026.124802",
        "base": None,
        "rules": 6,
        "confidence": {"text_seen": 6},
    }


class _Faulty:
    """Entry point of a plugin with a ruleset file that cannot be understood, and one that can."""

    name = "faulty"
    value = "faulty_rules"

    def __init__(self, *files: Path) -> None:
        self.files = files

    def load(self) -> object:
        return SimpleNamespace(ccas_rulesets=hookimpl(lambda: self.files))


def test_ruleset_that_cannot_be_understood_is_listed_with_its_first_finding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = Path(ccas_rulesets.__file__).with_name("tran2026.yaml").read_text(encoding="utf-8")
    (tmp_path / "good.yaml").write_text(sound, encoding="utf-8")
    faulty = sound.replace("id: tran2026", "id: other").replace("then: give_way", "then: giveway")
    (tmp_path / "bad.yaml").write_text(faulty, encoding="utf-8")
    found = plugins.load([_Faulty(tmp_path / "bad.yaml", tmp_path / "good.yaml")])
    monkeypatch.setattr(plugins, "load", lambda **_: found)

    done = ccas("rulesets")

    assert done.exit_code == 1
    assert "other (faulty) cannot be used: 4 findings, first" in done.stdout
    assert "bad.yaml:39:11: got 'giveway'" in done.stdout
    assert "tran2026" in done.stdout
    rows = {row["id"]: row for row in json.loads(ccas("rulesets", "--json").stdout)}
    assert rows["other"]["findings"] == 4
    assert rows["tran2026"]["rules"] == 6


def test_table_of_rulesets_is_not_cut_where_nobody_looks_at_a_terminal() -> None:
    assert "Algorithm 1, corrected" in ccas("rulesets").stdout


def test_plugins_are_listed_with_what_they_offer() -> None:
    done = ccas("plugins", "--json")

    found = json.loads(done.stdout)
    (ours,) = [row for row in found["loaded"] if row["plugin"] == "rulesets"]
    assert ours["module"] == "ccas_rulesets"
    assert ours["package"].startswith("ccas ")
    assert ours["hooks"] == ["ccas_plugin_info", "ccas_rulesets"]
    assert {"tran2026", "tran2026_printed"} <= set(ours["rulesets"])


@pytest.mark.usefixtures("broken_plugin")
def test_plugin_that_was_left_out_is_a_finding() -> None:
    done = ccas("plugins", "--json")

    assert done.exit_code == 1
    (failure,) = json.loads(done.stdout)["failures"]
    assert (failure["plugin"], failure["cause"]) == ("broken", "ImportError: no such thing")


@pytest.mark.usefixtures("broken_plugin")
def test_table_of_plugins_says_why_one_was_left_out() -> None:
    done = ccas("plugins")

    assert done.exit_code == 1
    assert "ImportError: no such thing" in done.stdout


def test_all_that_a_plugin_offers_is_told_when_asked_for() -> None:
    text = ccas("plugins", "--all").stdout

    assert "hooks: ccas_plugin_info, ccas_rulesets" in text


@pytest.mark.usefixtures("broken_plugin")
def test_traceback_of_a_plugin_that_was_left_out_is_shown_when_asked_for() -> None:
    done = ccas("plugins", "--debug", "broken")

    assert done.exit_code == 1
    assert "Traceback" in done.stdout
    assert 'raise ImportError("no such thing")' in done.stdout


def test_plugin_that_was_loaded_has_nothing_to_debug() -> None:
    assert ccas("plugins", "--debug", "rulesets").exit_code == 0


def test_plugin_that_there_is_not_is_told_with_the_nearest_name() -> None:
    done = ccas("plugins", "--debug", "rulsets")

    assert done.exit_code == 2
    assert "did you mean 'rulesets'?" in done.stderr


def test_no_plugins_leaves_those_that_come_with_the_program() -> None:
    assert ccas("--no-plugins", "rulesets").exit_code == 0
    assert "tran2026" in ccas("--no-plugins", "rulesets").stdout


def test_plugins_can_be_chosen_by_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CCAS_PLUGINS", "harbour, none_such")

    done = ccas("rulesets")

    assert "tran2026" in done.stdout
    assert "CCAS_PLUGINS: there is no plugin 'none_such'" in done.stderr


@pytest.mark.usefixtures("broken_plugin")
def test_other_commands_warn_of_a_plugin_that_was_left_out() -> None:
    done = ccas("rulesets", "--json")

    assert done.exit_code == 0
    assert json.loads(done.stdout) == []
    assert "plugin 'broken' (broken_rules) is left out" in done.stderr


def test_scenarios_are_listed_with_their_titles() -> None:
    rows = json.loads(ccas("scenarios", "--json").stdout)

    assert tuple(row["name"] for row in rows) == names()
    assert all(row["title"] for row in rows)


def test_scenario_is_found_by_the_last_part_of_its_name() -> None:
    assert inputs.scenario_file("fig_12") == inputs.scenario_file("tran2026/fig_12")
