"""The second paper's simulations: what its text says of them is true of ours."""

from __future__ import annotations

from pathlib import Path

import pytest

from ccas_cli import congested
from ccas_cli.reproduction import CASES, Reproduction
from ccas_core import plugins
from ccas_core.dmpc.solvers import make_solver
from ccas_core.sim.scenario import Scenario
from ccas_core.sim.scenario_file import load_scenario
from ccas_plugins.bumper_mpc import CONTROLLER
from ccas_scenarios import names, path

CONTROLLERS = {"bumper": CONTROLLER}


def reproduction(folder: Path) -> Reproduction:
    return Reproduction(
        rulesets=plugins.load().rulesets,
        solver_name="fatrop",
        solver=make_solver("fatrop"),
        out=folder,
        json=True,
        controllers=CONTROLLERS,
    )


def simulation(name: str) -> Scenario:
    return load_scenario(path(f"zhenjiang/{name}"), controllers=CONTROLLERS)


@pytest.mark.parametrize("case", ["sim-2", "sim-4"])
def test_every_claim_holds_and_its_picture_is_drawn(case: str, tmp_path: Path) -> None:
    made = reproduction(tmp_path)
    CASES[case](made)

    assert [claim.text for found in made.findings.values() for claim in found if not claim.holds] == []
    assert sum(map(len, made.findings.values())) >= 4
    assert list(tmp_path.glob(f"{case.replace('-', '_')}*.png"))


def test_claim_that_does_not_hold_is_noticed(tmp_path: Path) -> None:
    made = reproduction(tmp_path)
    case = made.sail("zhenjiang/sim_2")

    starboard = next(c for c in congested._manoeuvres("sim_2", case) if "starboard" in c.text)
    port = next(c for c in congested._manoeuvres("sim_3", case) if "port side" in c.text)

    assert starboard.holds
    assert not port.holds


def test_simulations_are_sailed_at_a_tenth_of_a_second_with_domains_and_a_current() -> None:
    for name in names():
        if name.startswith("zhenjiang/"):
            scenario = simulation(name.partition("/")[2])

            assert scenario.time_step == 0.1
            assert scenario.waters.ruleset == "cn_inland"
            assert scenario.waters.current.speed > 0.0
            assert {plan.control.by for plan in scenario.ships} == {"bumper", "tracked"}
            assert all(plan.ship.stated_domain is not None for plan in scenario.ships)
