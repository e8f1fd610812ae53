"""Who can come near whom: the reach of a ship, and the risk that is left out beyond it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ccas_core.agent.reach import FORESIGHT, ROLE_FACTOR, TOLERANCE, WIDTH, neighbours, reach, separation
from ccas_core.agent.ship_agent import FORGOTTEN
from ccas_core.dmpc.parameters import CROSSING, HEAD_ON, PROFILES, RiskShape, Settings
from ccas_core.dmpc.risk import cut_off, threat
from ccas_core.frames import PathTrajectory
from ccas_core.ships import Hull, ShipId
from ccas_core.sim.network import network
from ccas_core.waterway import Leg, Towards, Waters, Waterway, guiding_line

from . import FLEET, Decreed, agent, period

A, B, C = (ShipId(letter) for letter in "abc")
LONG = Hull(length=110.0, beam=11.4)
SMALL = Hull(length=38.0, beam=5.0)


def waters() -> Waters:
    canals = tuple(
        Waterway(id=name, centreline=np.array([[north, 0.0], [north, 20_000.0]]), width=100.0)
        for name, north in (("near", 0.0), ("far", 5_000.0))
    )
    return Waters(ruleset="none", waterways=canals)


def test_ships_that_sail_towards_one_another_are_neighbours_and_those_that_part_are_not() -> None:
    there, back = (guiding_line(waters(), [Leg("near", towards)]) for towards in (Towards.END, Towards.START))
    east = {A: reach(there, 10_000.0, 3.0, FORESIGHT)}  # at 10 km, sails east
    coming = {**east, B: reach(back, 5_000.0, 3.0, FORESIGHT)}  # at 15 km, sails west
    just_met = {**east, B: reach(back, 10_500.0, 3.0, FORESIGHT)}
    parted = {**east, B: reach(back, 11_100.0, 3.0, FORESIGHT)}

    assert neighbours(coming, 1_000.0) == neighbours(just_met, 1_000.0) == {A: (B,), B: (A,)}
    assert neighbours(parted, 1_000.0) == {A: (), B: ()}


def test_ships_on_other_water_are_no_neighbours() -> None:
    lines = [guiding_line(waters(), [Leg(name, Towards.END)]) for name in ("near", "far")]

    assert neighbours(
        {A: reach(lines[0], 0.0, 3.0, 900.0), C: reach(lines[1], 0.0, 3.0, 900.0)}, 2_000.0
    ) == {
        A: (),
        C: (),
    }


def test_nobody_has_no_neighbours() -> None:
    assert neighbours({}, 1_000.0) == {}


def test_index_finds_what_a_look_at_all_pairs_finds() -> None:
    from shapely import LineString

    scenario = network(60, seed=3)
    lines = {plan.ship.id: guiding_line(scenario.waters, plan.route) for plan in scenario.ships}
    reaches = {
        plan.ship.id: reach(lines[plan.ship.id], lines[plan.ship.id].frame.to_path(plan.start).x, 3.0, 900.0)
        for plan in scenario.ships
    }
    drawn = {ship: LineString(each.points) for ship, each in reaches.items()}
    expected = {
        ship: tuple(sorted(o for o in drawn if o != ship and drawn[o].distance(drawn[ship]) <= 1_000.0))
        for ship in drawn
    }

    assert neighbours(reaches, 1_000.0) == expected
    assert any(expected.values())


@given(
    bearing=st.floats(-math.pi, math.pi),
    course=st.floats(-math.pi, math.pi),
    own=st.sampled_from([LONG, SMALL]),
    other=st.sampled_from([LONG, SMALL]),
    settings=st.sampled_from(
        [HEAD_ON, CROSSING, replace(HEAD_ON, risk=replace(HEAD_ON.risk, shape=RiskShape.AXIS_BOUND))]
    ),
    horizon=st.integers(1, 60),
)
def test_risk_beyond_the_cut_off_is_below_the_tolerance(
    bearing: float, course: float, own: Hull, other: Hull, settings: Settings, horizon: int
) -> None:
    settings = replace(settings, horizon=horizon)
    distance = cut_off(own, other, settings, 1e-6)
    here = [distance * math.cos(bearing), distance * math.sin(bearing), course]
    rows = threat(
        own, other, PathTrajectory(np.tile(here, (horizon + 1, 1))), settings.risk, settings.weights
    )
    x, y, q_xx, q_xy, q_yy, gain = rows.T
    risk = gain * np.exp(-(q_xx * x**2 + 2.0 * q_xy * x * y + q_yy * y**2))

    assert float(np.sum(risk)) <= 1e-6


def test_risk_of_ten_thousand_ships_that_are_left_out_is_below_what_two_answers_may_differ_by() -> None:
    apart = separation(PROFILES.values(), [LONG, SMALL])
    dearest = [
        replace(s, weights=replace(s.weights, K_ca=ROLE_FACTOR * s.weights.K_ca)) for s in PROFILES.values()
    ]

    assert apart - 2.0 * WIDTH >= max(cut_off(LONG, LONG, settings, TOLERANCE) for settings in dearest) - 1e-6
    assert 10_000 * TOLERANCE <= 1e-6


@pytest.mark.parametrize("course", [0.0, 0.5, -1.2])
def test_ship_never_leaves_the_width_beside_its_line(course: float) -> None:
    from ccas_core.dmpc import kinematics

    pose = (0.0, -60.0, course)
    widest, generator = 0.0, np.random.default_rng(1)
    for _ in range(500):
        pose = kinematics.step(
            pose,
            float(generator.choice([-60.0, 60.0])),
            float(generator.uniform()),
            speed=4.2,
            time_step=20.0,
            time_constant=28.458,
            course_limit=math.pi / 6.0,
            steering_gain=0.02,
        )
        widest = max(widest, abs(pose[1]))

    assert widest < WIDTH


def test_encounter_with_a_ship_that_has_left_for_long_is_forgotten() -> None:
    rules = Decreed([(FLEET[0], FLEET[1])])
    agents = {ship: agent(ship, rules) for ship in FLEET[:2]}
    period(agents)
    known = dict(agents[FLEET[0]]._encounters)
    alone = {FLEET[0]: agents[FLEET[0]]}
    for index in range(1, FORGOTTEN + 1):
        period(alone, index=index)
    kept = dict(agents[FLEET[0]]._encounters)
    period(alone, index=FORGOTTEN + 1)

    assert known
    assert kept.keys() == known.keys()
    assert agents[FLEET[0]]._encounters == {}
    assert agents[FLEET[0]]._last_heard == {}
