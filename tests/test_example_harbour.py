"""The sample plugin, built and installed as somebody outside would, and exercised by the program."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from ccas_core import plugins
from ccas_core.events import OrderDecided
from ccas_core.ships import ShipId
from ccas_core.sim.scenario_dump import dump_scenario
from ccas_core.sim.scenario_file import load_scenario
from ccas_core.tapd.case_run import run_case
from ccas_core.tapd.written import WrittenRuleset

ROOT = Path(__file__).parents[1]
SAMPLE = ROOT / "plugins" / "example_harbour"
PROGRAM = "from ccas_cli.main import main; main()"

SCENARIO = """\
schema: ccas/scenario@1
name: a tug crosses
time: {step: 20 s}
waters:
  ruleset: bpr
  regions: [example_harbour]
  waterways:
    - {id: basin, centreline: [[-390, 0], [250, 0]], width: 160 m, facts: {type: harbour}}
    - {id: dock, centreline: [[0, -390], [0, 250]], width: 150 m, facts: {type: harbour}}
ships:
  - id: alone
    length: 40 m
    beam: 6 m
    weight: 400 t
    route: [{waterway: basin, towards: end}]
    start: [-300, 0]
    speed: 3 m/s
    facts: {draught: 3 m, follows_starboard_side: false}
  - id: towed
    length: 40 m
    beam: 6 m
    weight: 500 t
    route: [{waterway: dock, towards: start}]
    start: [0, 240]
    speed: 3 m/s
    facts: {draught: 8 m, tug_assisted: true, follows_starboard_side: false}
control: {horizon: 10, iterations: 1}
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the sample and install it into a folder of its own: no network."""
    wheels, site = tmp_path_factory.mktemp("wheels"), tmp_path_factory.mktemp("site")
    python = (sys.executable, "-m")
    run(*python, "build", "--wheel", "--no-isolation", "--outdir", str(wheels), str(SAMPLE))
    (wheel,) = wheels.glob("*.whl")
    run(*python, "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", str(site), str(wheel))
    return site


@pytest.fixture
def found(installed: Path) -> Iterator[plugins.Plugins]:
    """All plugins, with the sample installed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(installed)
        yield plugins.load()


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "tug.yaml"
    path.write_text(SCENARIO, encoding="utf-8")
    return path


def run(*command: str, path: Path | None = None) -> str:
    """Run a command; with `path` before all else that Python finds."""
    paths = [str(path), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))} if path else None
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def ccas(installed: Path, *arguments: str | Path) -> str:
    return run(sys.executable, "-c", PROGRAM, *map(str, arguments), path=installed)


def test_installed_sample_offers_all_that_it_says(found: plugins.Plugins) -> None:
    assert found.failures == ()
    assert found.loaded["harbour"] == "ccas_example_harbour"
    assert found.packages["harbour"] == "ccas-example-harbour 1.0.0"
    assert found.owners["harbour"] == "harbour"
    assert found.facts == {"tug_assisted": "harbour"}
    assert {"deep_water"} == found.pair_rules.keys()
    assert {"example_harbour"} == found.regions.keys()
    assert found.infos["harbour"].name == "example harbour"
    assert "ccas_order_decided" in found.hooks["harbour"]


def test_tests_of_the_by_law_pass(found: plugins.Plugins) -> None:
    ruleset = found.ruleset("harbour")

    assert isinstance(ruleset, WrittenRuleset)
    assert ruleset.text.lineage == ("bpr", "common")
    for case in ruleset.text.tests:
        assert run_case(ruleset, case, case.expected["harbour"]).differences == (), case.id
    assert list(found.troubles.fresh()) == []


def test_rulesets_that_we_ship_are_untouched_by_the_fact_that_it_adds(found: plugins.Plugins) -> None:
    without = plugins.load(only=[])
    case = without.ruleset("bpr").text.tests[0]  # type: ignore[attr-defined]

    for each in (found, without):
        ruleset = each.ruleset("bpr")
        assert isinstance(ruleset, WrittenRuleset)
        assert run_case(ruleset, case, case.expected["bpr"]).passed


def test_observer_counts_and_changes_nothing(found: plugins.Plugins) -> None:
    event = OrderDecided(time=0.0, generations=((ShipId("a"),), (ShipId("b"),)))

    assert list(found.observers().tell(event)) == []
    assert sys.modules["ccas_example_harbour"].DECIDED[2] >= 1


def test_scenario_with_its_fact_and_its_region_is_read_and_written(
    found: plugins.Plugins, scenario: Path
) -> None:
    read = load_scenario(scenario, found.rulesets, regions=found.regions, vocabulary=found.vocabulary)
    again = dump_scenario(read, found.vocabulary)

    assert read.waters.regions[0].ruleset == "harbour"
    assert read.ships[1].ship.facts["tug_assisted"] is True
    assert "tug_assisted: true" in again
    assert "draught: 8 m" in again


def test_installed_sample_is_listed_by_the_program(installed: Path) -> None:
    rows = {row["id"]: row for row in json.loads(ccas(installed, "rulesets", "--json"))}
    (row,) = (
        each
        for each in json.loads(ccas(installed, "plugins", "--json"))["loaded"]
        if each["plugin"] == "harbour"
    )

    assert (rows["harbour"]["plugin"], rows["harbour"]["base"]) == ("harbour", "bpr")
    assert (row["package"], row["rulesets"], row["facts"]) == (
        "ccas-example-harbour 1.0.0",
        ["harbour"],
        ["tug_assisted"],
    )


def test_tests_of_the_by_law_are_run_by_the_program(installed: Path) -> None:
    found = json.loads(ccas(installed, "test", "harbour", "--json"))

    assert (found["passed"], found["failed"]) == (7, 0)


def test_its_rules_are_explained_by_the_program(installed: Path, scenario: Path) -> None:
    (pair,) = json.loads(ccas(installed, "explain", scenario, "--json"))

    assert [view["kind"] for view in pair["verdicts"].values()] == ["give_way", "stand_on"]
    assert {view["rule"] for view in pair["verdicts"].values()} == {"harbour.tug"}
    assert {view["article"] for view in pair["verdicts"].values()} == {"Harbour by-law 1"}


def test_ships_sail_by_it(installed: Path, scenario: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    summary = json.loads(
        ccas(installed, "simulate", scenario, "--out", out, "--json", "--quiet", "--no-pictures")
    )

    (met,) = summary["encounters"]
    assert (met["ruleset"], met["give_way"]) == ("harbour", ["alone"])
    assert summary["collisions"] == 0
    assert "tug_assisted: true" in (out / "scenario.yaml").read_text(encoding="utf-8")
