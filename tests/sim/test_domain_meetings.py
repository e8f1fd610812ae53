"""Domains along a voyage: exact distances and overlaps."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ccas_core.domains import Ellipse
from ccas_core.ships import ShipId
from ccas_core.sim.chart import sailed
from ccas_core.sim.domain_meetings import domains_at, nearnesses
from ccas_core.sim.domain_plotting import motions, steered
from ccas_core.sim.scenario import Plan, Scenario
from ccas_core.waterway import Obstacle

from . import EAST, NORTH, WEST, A, B, plan, scenario, voyage, waters


def with_domain(one: Plan, ahead: float = 100.0, aside: float = 20.0) -> Plan:
    return replace(one, ship=replace(one.ship, stated_domain=Ellipse(ahead=ahead, aside=aside)))


def head_on(apart: float) -> Scenario:
    """Two ships that pass at a lateral distance."""
    plans = plan(A, EAST, 600.0, apart / 2.0), plan(B, WEST, 600.0, apart / 2.0)
    return scenario(*map(with_domain, plans))


def test_domains_that_pass_one_another_keep_the_distance_between_their_edges() -> None:
    of = head_on(60.0)
    (found,) = nearnesses(of, voyage(of, {A: [(30.0, 1.0)], B: [(30.0, 1.0)]}, lambda _: ()))

    assert found.ships == (A, B)
    assert found.least == pytest.approx(20.0, abs=0.5)  # 60 - 2 x 20; outlines are polygons
    assert found.overlap == 0.0


def test_domains_that_overlap_are_told_with_their_share() -> None:
    of = head_on(0.0)
    (found,) = nearnesses(of, voyage(of, {A: [(0.0, 1.0)], B: [(0.0, 1.0)]}, lambda _: ()))

    assert found.least == 0.0
    assert found.overlap == pytest.approx(1.0)


def test_ships_without_a_domain_of_their_own_are_not_looked_at() -> None:
    of = scenario(plan(A, EAST, 600.0), plan(B, NORTH, 600.0))

    assert nearnesses(of, voyage(of, {A: [(0.0, 1.0)], B: [(0.0, 1.0)]}, lambda _: ())) == ()


def test_obstacle_within_a_domain_is_told() -> None:
    on = waters(obstacles=(Obstacle(id="pier", x=-30.0, y=0.0, radius=5.0),))
    of = scenario(with_domain(plan(A, EAST, 600.0)), on=on)
    (found,) = nearnesses(of, voyage(of, {A: [(0.0, 1.0)]}, lambda _: ()))

    assert found.ships == (ShipId("a"), "pier")
    assert found.least == pytest.approx(5.0, abs=0.5)  # 30 - 20 - 5


def test_domain_lies_around_the_ship_along_its_course() -> None:
    of = scenario(with_domain(plan(A, EAST, 600.0)))
    frames = voyage(of, {A: [(0.0, 1.0)]}, lambda _: ())
    outline = domains_at(of, frames[0])[A]

    assert outline.mean(axis=0) == pytest.approx([0.0, -600.0], abs=1e-6)
    assert outline[:, 1].max() == pytest.approx(-500.0)
    assert outline[:, 0].max() == pytest.approx(20.0, abs=0.1)


def test_picture_of_a_voyage_without_steered_ships_has_no_motions() -> None:
    of = head_on(60.0)
    frames = voyage(of, {A: [(30.0, 1.0)], B: [(30.0, 1.0)]}, lambda _: ())

    assert all(len(motions(frames, ship)) == 0 for ship in sailed(of, frames))
    assert len(steered(of, frames).get_axes()) >= 3
