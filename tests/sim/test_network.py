"""The made-up network: as many ships as asked for, at the density asked for, clear of one another."""

from __future__ import annotations

import numpy as np
import pytest

from ccas_core import plugins
from ccas_core.dmpc.solvers import make_solver
from ccas_core.sim.network import network
from ccas_core.sim.scenario_dump import dump_scenario
from ccas_core.sim.voyage import voyage
from ccas_core.waterway import Towards


@pytest.mark.parametrize("ships", [10, 100, 640])
def test_network_has_so_many_ships_at_one_density(ships: int) -> None:
    scenario = network(ships)
    length = sum(waterway.frame(Towards.END).length for waterway in scenario.waters.waterways)

    assert len({plan.ship.id for plan in scenario.ships}) == ships
    assert 1000.0 * ships / length == pytest.approx(0.5, rel=0.02)


def test_ships_lie_on_their_water_and_apart() -> None:
    scenario = network(200)
    places = np.array([(plan.start.x, plan.start.y) for plan in scenario.ships])
    gaps = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) + 1e9 * np.eye(len(places))

    assert np.min(gaps) > 20.0  # lanes of one waterway are so far apart
    for plan in scenario.ships:
        assert scenario.waters.waterway(plan.route[0].waterway).holds(plan.start)


def test_same_seed_makes_the_same_network_and_another_seed_another() -> None:
    assert dump_scenario(network(50, seed=4)) == dump_scenario(network(50, seed=4))
    assert dump_scenario(network(50, seed=4)) != dump_scenario(network(50, seed=5))


@pytest.mark.parametrize(("ships", "density"), [(9, 0.5), (-3, 0.5), (10, 0.0), (10, float("nan"))])
def test_network_of_few_ships_or_no_density_is_refused(ships: int, density: float) -> None:
    with pytest.raises(ValueError, match="a network has"):
        network(ships, density=density)


def test_network_with_more_ships_than_water_is_refused() -> None:
    with pytest.raises(ValueError, match="do not fit"):
        network(100, density=10.0)


def test_every_ship_of_a_network_has_a_command_whatever_the_number_of_threads() -> None:
    pytest.importorskip("numba")
    from ccas_core.dmpc.riccati import Riccati

    scenario, rulesets = network(60), plugins.load().rulesets
    told = []
    for solver in (make_solver("riccati"), Riccati(threads=1), Riccati(threads=3)):
        frames = voyage(scenario, rulesets, solver)
        next(frames)
        frame = next(frames)
        told.append([(ship.offset, ship.speed_factor, ship.pose) for ship in frame.ships.values()])

    assert len(told[0]) == 60
    assert told[0] == told[1] == told[2]
    assert all(abs(offset) <= 60.0 and 0.0 <= factor <= 1.0 for offset, factor, _ in told[0])
