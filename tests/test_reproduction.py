"""The paper's cases: what its text and its Table 2 say of them is true of ours."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import pytest

from ccas_cli import paper
from ccas_cli.paper import TABLE_2, Row
from ccas_core import plugins
from ccas_core.dmpc.solvers import AbstractLocalSolver, make_solver
from ccas_core.sim.metrics import plain, summary
from ccas_core.sim.scenario import Scenario
from ccas_core.sim.scenario_file import load_scenario
from ccas_core.sim.voyage import voyage
from ccas_scenarios import path

RULESETS = plugins.load().rulesets
ROWS = {row.scenario: row for row in TABLE_2}


@cache
def solver(name: str) -> AbstractLocalSolver:
    return make_solver(name)


@cache
def sailed(name: str, by: str = "riccati") -> tuple[Scenario, Mapping[str, Any]]:
    """Sail a case of the paper, once a session."""
    scenario = load_scenario(path(f"tran2026/{name}"), RULESETS)
    found = plain(summary(scenario, tuple(voyage(scenario, RULESETS, solver(by))), by))
    assert isinstance(found, dict)
    return scenario, found


def broken(claims: list[paper.Claim]) -> list[str]:
    return [claim.text for claim in claims if not claim.holds]


@pytest.mark.parametrize("row", TABLE_2, ids=list(ROWS))
def test_every_claim_of_table_2_holds(row: Row) -> None:
    claims = paper.claims_of(row, *sailed(row.scenario))

    assert len(claims) >= 7
    assert broken(claims) == []


@pytest.mark.parametrize("name", ["fig_10", "fig_12"])
def test_claims_hold_without_the_compiled_solver_as_well(name: str) -> None:
    assert broken(paper.claims_of(ROWS[name], *sailed(name, "fatrop"))) == []


@pytest.mark.parametrize("name", ["fig_10", "fig_12"])
def test_voyages_end_with_the_same_roles_whichever_solver_sails_them(name: str) -> None:
    one, other = (sailed(name, by)[1] for by in ("riccati", "fatrop"))
    keys = ("ships", "geometry", "give_way", "stand_on", "risky")

    assert [[each[key] for key in keys] for each in one["encounters"]] == [
        [each[key] for key in keys] for each in other["encounters"]
    ]
    assert (one["collisions"], one["entries"]) == (other["collisions"], other["entries"])


@pytest.mark.parametrize("name", ["fig_06a", "fig_06b", "fig_06c", "fig_07a"])
def test_claims_of_the_head_on_cases_hold(name: str) -> None:
    assert broken(paper.head_on_claims(name, sailed(name)[1])) == []


def test_deadlock_that_is_not_detected_ends_in_trouble() -> None:
    _, found = sailed("fig_14_undetected")

    assert found["collisions"] > 0 or found["frozen"] > 0
    assert found["deadlocks"] == []


def test_deadlock_that_is_detected_is_opened_at_the_lightest_ship() -> None:
    scenario, found = sailed("fig_14")
    lightest = min(scenario.ships, key=lambda plan: plan.ship.mass).ship.id

    first = found["deadlocks"][0]
    assert sorted(first["ships"]) == [plan.ship.id for plan in scenario.ships]
    assert [opened[1] for opened in first["opened"]] == [lightest]
    assert found["frozen"] == 0


def test_every_row_of_table_2_has_a_figure_for_each_of_its_ships() -> None:
    for row in TABLE_2:
        count = len(load_scenario(path(f"tran2026/{row.scenario}"), RULESETS).ships)

        assert len(row.max_s) == len(row.mean_s) == len(row.safety_index) == count
