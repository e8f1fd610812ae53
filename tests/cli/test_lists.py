"""`ccas rulesets`, `ccas plugins`, `ccas scenarios`: lists for people, and as JSON."""

from __future__ import annotations

import json

import pytest

from ccas_cli import inputs
from ccas_core import plugins
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
        "version": "1.0.0",
        "title": "Priority assignment of Tran et al. 2026, Algorithm 1, corrected",
        "plugin": "rulesets",
    }


def test_table_of_rulesets_is_not_cut_where_nobody_looks_at_a_terminal() -> None:
    assert "Algorithm 1, corrected" in ccas("rulesets").stdout


def test_plugins_are_listed_with_what_they_offer() -> None:
    done = ccas("plugins", "--json")

    found = json.loads(done.stdout)
    (ours,) = [row for row in found["loaded"] if row["plugin"] == "rulesets"]
    assert ours["module"] == "ccas_rulesets"
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
