"""The second paper's simulations: what its text says of them is true of ours."""

from __future__ import annotations

from pathlib import Path

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


def test_every_claim_of_a_simulation_holds_and_its_picture_is_drawn(tmp_path: Path) -> None:
    made = reproduction(tmp_path)
    CASES["sim-2"](made)

    assert [claim.text for found in made.findings.values() for claim in found if not claim.holds] == []
    assert sum(map(len, made.findings.values())) >= 10
    assert (tmp_path / "sim_2.png").is_file()


def test_claims_of_the_crossing_hold_and_those_of_another_simulation_do_not(tmp_path: Path) -> None:
    case = reproduction(tmp_path).sail("zhenjiang/sim_4")
    claims = [*congested._always(case), *congested._manoeuvres("sim_4", case)]
    others = congested._manoeuvres("sim_2", case)

    assert [claim.text for claim in claims if not claim.holds] == []
    assert not all(claim.holds for claim in others)


def test_simulations_are_sailed_at_a_tenth_of_a_second_with_domains_and_a_current() -> None:
    for name in names():
        if name.startswith("zhenjiang/"):
            scenario = simulation(name.partition("/")[2])

            assert scenario.time_step == 0.1
            assert scenario.waters.ruleset == "cn_inland"
            assert scenario.waters.current.speed > 0.0
            assert {plan.control.by for plan in scenario.ships} == {"bumper", "tracked"}
            assert all(plan.ship.stated_domain is not None for plan in scenario.ships)
