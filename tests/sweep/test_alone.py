"""What a ship could have done all by itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from ccas_core import plugins
from ccas_core.agent.events import Conduct
from ccas_core.dmpc.solvers import make_solver
from ccas_core.frames import PathPose
from ccas_core.sim.frame import Frame
from ccas_core.sim.scenario import Scenario
from ccas_core.sim.voyage import voyage
from ccas_core.sweep.alone import could_avoid
from ccas_core.sweep.draw import Kind, Risk, draw_encounter
from ccas_core.waterway import guiding_line


def beside(conduct: Conduct) -> Scenario:
    """Two ships head-on, of which the second breaks its duty."""
    drawn = draw_encounter(np.random.default_rng(1), Kind.HEAD_ON, Risk.RISKY, "tran2026")
    one, other = drawn.ships
    return replace(drawn, ships=(one, replace(other, conduct=conduct)))


def near(scenario: Scenario, metres: float) -> Scenario:
    """The same, with so little water between the two ships that meet."""
    one, other = scenario.ships
    line = guiding_line(scenario.waters, one.route).frame
    there = line.to_path(other.start)
    length = (one.ship.hull.length + other.ship.hull.length) / 2.0
    start = line.to_ned(PathPose(there.x - metres - length, there.y, 0.0))
    return replace(scenario, ships=(replace(one, start=start), other))


@pytest.mark.parametrize(("metres", "avoidable"), [(1500.0, True), (30.0, False)])
def test_far_away_a_ship_can_avoid_one_that_sails_on_and_right_before_it_cannot(
    metres: float, avoidable: bool
) -> None:
    scenario = near(beside(Conduct.IGNORES), metres)
    frames = tuple(frame for _, frame in zip(range(2), sailed(scenario), strict=False))

    assert could_avoid(scenario, frames) is avoidable


def test_where_all_do_their_duty_nobody_asks() -> None:
    scenario = beside(Conduct.DUTIFUL)

    assert could_avoid(scenario, (next(iter(sailed(scenario))),)) is None


def sailed(scenario: Scenario) -> Iterator[Frame]:
    return voyage(scenario, plugins.load().rulesets, make_solver("riccati"))
