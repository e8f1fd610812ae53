"""The sample plugin, built and installed as somebody outside would, and asked by way of its hook."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from ccas_core import plugins
from ccas_core.frames import NedPose
from ccas_core.priority import EdgeKind
from ccas_core.ships import Hull, Ship, ShipId
from ccas_core.tapd.ruleset import AbstractRuleset, Situation
from ccas_core.units import DEGREE
from ccas_core.verdict import Kind, Verdict
from ccas_core.waterway import Towards, Waters, Waterway
from ccas_core.world import ShipReport, World

SAMPLE = Path(__file__).parents[1] / "plugins" / "example_harbour"
ALICE, BOB = ShipId("alice"), ShipId("bob")


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
def harbour(found: plugins.Plugins) -> AbstractRuleset:
    return found.ruleset("harbour")


def run(*command: str, path: Path | None = None) -> str:
    environment = {**os.environ, "PYTHONPATH": str(path)} if path else None
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def report(ship: ShipId, north: float, course: float, waterway: str = "entrance") -> ShipReport:
    """Report of a ship on the centreline of a waterway that runs north, into the harbour."""
    return ShipReport(
        ship=Ship(id=ship, hull=Hull(length=80.0, beam=9.0), mass=1e6),
        pose=NedPose(north, 0.0, course * DEGREE),
        speed=3.0,
        waterway=waterway,
        towards=Towards.END if course == 0.0 else Towards.START,
        ruleset="harbour",
    )


def situation(*reports: ShipReport) -> Situation:
    line = np.array([[-2000.0, 0.0], [2000.0, 0.0]])
    waterways = tuple(Waterway(id=name, centreline=line, width=100.0) for name in ("entrance", "river"))
    waters = Waters(ruleset="harbour", waterways=waterways)
    return Situation(world=World(time=0.0, waters=waters, reports={each.id: each for each in reports}))


def verdicts(ruleset: AbstractRuleset, *reports: ShipReport) -> tuple[Verdict, Verdict]:
    """Verdicts of alice on bob and of bob on alice."""
    one = ruleset.view(situation(*reports), ALICE, BOB)
    other = ruleset.view(situation(*reports), BOB, ALICE)
    assert one is not None
    assert other is not None
    return one, other


def test_installed_sample_offers_its_ruleset(found: plugins.Plugins) -> None:
    assert found.loaded["harbour"] == "ccas_example_harbour"
    assert found.owners["harbour"] == "harbour"
    assert found.failures == ()


def test_installed_sample_is_listed_by_the_program(installed: Path) -> None:
    program = "import sys; from ccas_cli.main import main; sys.exit(main())"

    assert "harbour" in run(sys.executable, "-c", program, "rulesets", path=installed)


def test_departing_ship_gives_way_and_arriving_ship_stands_on(harbour: AbstractRuleset) -> None:
    arriving, departing = verdicts(harbour, report(ALICE, -600.0, 0.0), report(BOB, 600.0, 180.0))

    assert (arriving.kind, departing.kind) == (Kind.STAND_ON, Kind.GIVE_WAY)
    assert departing.article == "Harbour by-law art. 1"


def test_departing_ship_decides_first(harbour: AbstractRuleset) -> None:
    graph = harbour.emit(situation(report(ALICE, -600.0, 0.0), report(BOB, 600.0, 180.0)))

    assert graph.generations() == ((BOB,), (ALICE,))
    assert [s.edge.kind for s in graph.settlements if s.edge is not None] == [EdgeKind.DUTY]


def test_ships_that_sail_the_same_way_do_not_meet(harbour: AbstractRuleset) -> None:
    one, other = verdicts(harbour, report(ALICE, -600.0, 0.0), report(BOB, 600.0, 0.0))

    assert one.kind is other.kind is Kind.NONE


def test_ships_outside_the_entrance_agree_by_radio(harbour: AbstractRuleset) -> None:
    one, other = verdicts(harbour, report(ALICE, -600.0, 0.0, "river"), report(BOB, 600.0, 180.0, "river"))

    assert one.kind is other.kind is Kind.NEGOTIATE
