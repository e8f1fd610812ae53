"""The dynamic-bumper MPC: what it does alone, in encounters, by its role, and when nothing can be done."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ccas_core.controllers import Outlook, Steering, Target
from ccas_core.domains import AbstractDomain, DynamicBumper, Ellipse, Rectangle, gap
from ccas_core.frames import NedPose
from ccas_core.priority import NO_BEARING, Bearing
from ccas_core.roles import Geometry, PassingSide, Role
from ccas_core.ships import Hull, ShipId
from ccas_core.surge_yaw import Current, Manoeuvrability, Motion, advance
from ccas_core.waterway import Leg, Obstacle, Towards, Waters, Waterway, guiding_line
from ccas_plugins.bumper_mpc import CONTROLLER
from ccas_plugins.bumper_mpc.encounters import division

HULL = Hull(length=5.0, beam=2.0)
LIMITS = Manoeuvrability(max_speed=7.8, max_yaw_rate=0.35, acceleration=1.0, yaw_acceleration=0.7)
BUMPER = DynamicBumper(length=5.0, full_speed=7.8)
EAST = math.pi / 2.0


def waters(current: Current | None = None, *obstacles: Obstacle) -> Waters:
    line = np.array([[0.0, -500.0], [0.0, 1500.0]])
    return Waters(
        ruleset="cn_inland",
        waterways=(Waterway(id="river", centreline=line, width=120.0),),
        obstacles=obstacles,
        current=current or Current(),
    )


def outlook(*targets: Target, on: Waters | None = None, domain: AbstractDomain = BUMPER) -> Outlook:
    chart = on or waters()
    return Outlook(
        time=0.0,
        period=0.1,
        hull=HULL,
        domain=domain,
        limits=LIMITS,
        speed=6.0,
        line=guiding_line(chart, [Leg("river", Towards.END)]),
        waters=chart,
        pose=NedPose(0.0, 0.0, EAST),
        motion=Motion(6.0, 0.0),
        targets=targets,
        options={},
    )


def target(
    north: float,
    east: float,
    course: float,
    speed: float,
    bearing: Bearing = NO_BEARING,
    domain: AbstractDomain = BUMPER,
) -> Target:
    return Target(
        id=ShipId("b"),
        hull=HULL,
        domain=domain,
        pose=NedPose(north, east, course),
        speed=speed,
        bearing=bearing,
    )


def bearing(role: Role, geometry: Geometry, side: PassingSide | None = None) -> Bearing:
    return Bearing(role=role, passing_side=side, geometry=geometry)


def sail(begin: Outlook, seconds: float) -> list[tuple[Outlook, Steering]]:
    """Sail on in closed loop, the targets at their course and speed."""
    now, memory, sailed = begin, None, []
    for _ in range(round(seconds / begin.period)):
        steering = CONTROLLER.steer(now, memory)
        sailed.append((now, steering))
        memory = steering.memory
        pose = advance(now.pose, steering.motion, now.waters.current, now.period)
        targets = tuple(
            replace(each, pose=advance(each.pose, Motion(each.speed, 0.0), Current(), now.period))
            for each in now.targets
        )
        now = replace(now, pose=pose, motion=steering.motion, targets=targets)
    return sailed


def least_gap(sailed: list[tuple[Outlook, Steering]]) -> float:
    """Least gap of the domains on the line that joins the ships [m]."""
    found = []
    for now, _ in sailed:
        for other in now.targets:
            north, east = other.pose.x - now.pose.x, other.pose.y - now.pose.y
            here, there = now.pose.course, other.pose.course
            bearings = (
                north * math.cos(here) + east * math.sin(here),
                east * math.cos(here) - north * math.sin(here),
                -north * math.cos(there) - east * math.sin(there),
                -east * math.cos(there) + north * math.sin(there),
            )
            sight, speeds = math.hypot(north, east), (now.motion.surge, other.speed)
            found.append(gap(now.domain, other.domain, sight=sight, bearings=bearings, speeds=speeds))
    return float(min(found))


HEAD_ON = bearing(Role.BOTH, Geometry.HEAD_ON, PassingSide.PORT_TO_PORT)


def test_ship_alone_keeps_its_path_and_its_speed() -> None:
    for now, steering in sail(outlook(), 3.0):
        assert now.pose.x == pytest.approx(0.0, abs=1e-6)
        assert steering.motion.surge == pytest.approx(6.0, abs=1e-3)
        assert steering.outcome == ""


@pytest.mark.parametrize(("north", "east"), [(0.6, 0.0), (-0.4, 0.3), (0.0, -0.8)])
def test_current_is_made_up_for(north: float, east: float) -> None:
    now, _ = sail(outlook(on=waters(Current(north=north, east=east))), 12.0)[-1]

    assert now.pose.x == pytest.approx(0.0, abs=0.02)
    assert now.pose.y == pytest.approx(6.0 * 11.9, abs=0.8)


def test_current_that_is_not_known_pushes_the_ship_off_its_path() -> None:
    blind = replace(outlook(on=waters(Current(north=0.6))), options={"knows_current": "no"})

    assert abs(sail(blind, 12.0)[-1][0].pose.x) > 0.1


@pytest.mark.parametrize(
    ("side", "to_starboard"), [(PassingSide.PORT_TO_PORT, True), (PassingSide.STARBOARD_TO_STARBOARD, False)]
)
def test_head_on_is_passed_on_the_side_of_the_bearing(side: PassingSide, to_starboard: bool) -> None:
    meets = bearing(Role.BOTH, Geometry.HEAD_ON, side)
    sailed = sail(outlook(target(0.0, 100.0, -EAST, 4.0, meets)), 11.0)
    offsets = [-now.pose.x for now, _ in sailed]  # starboard of a path to the east is south

    assert max(offsets, key=abs) > 0.0 if to_starboard else max(offsets, key=abs) < 0.0
    assert least_gap(sailed) > -0.1
    assert {steering.outcome for _, steering in sailed} == {""}


def test_turn_stays_within_forty_degrees_of_the_path() -> None:
    sailed = sail(outlook(target(0.0, 60.0, -EAST, 4.0, HEAD_ON)), 6.0)

    assert max(abs(now.pose.course - EAST) for now, _ in sailed) <= math.radians(40.0) + 1e-3


def test_ship_that_crosses_is_passed_astern() -> None:
    owes = bearing(Role.GIVE_WAY, Geometry.CROSSING)
    sailed = sail(outlook(target(50.0, 70.0, math.pi, 4.0, owes)), 25.0)
    crossed = next(now for now, _ in sailed if now.pose.y >= 70.0)

    assert crossed.targets[0].pose.x < crossed.pose.x  # it goes south, and has gone by
    assert least_gap(sailed) > -0.1
    assert min(steering.motion.surge for _, steering in sailed) < 6.0


def test_ship_that_stands_on_holds_until_the_last_moment_and_then_acts() -> None:
    relies = bearing(Role.STAND_ON, Geometry.HEAD_ON)
    sailed = sail(outlook(target(0.0, 140.0, -EAST, 4.0, relies)), 15.0)
    held = [now for now, _ in sailed if abs(now.pose.x) < 0.1 and now.targets[0].pose.y > now.pose.y]
    apart = [
        math.hypot(now.targets[0].pose.x - now.pose.x, now.targets[0].pose.y - now.pose.y)
        for now, _ in sailed
    ]

    assert held[-1].targets[0].pose.y - held[-1].pose.y < 100.0
    assert min(apart) > 2.0 * 0.8 * 5.0 - 0.2  # both circles of ships at rest


def test_ship_that_is_overtaken_does_not_flee_before_the_domain_of_the_other() -> None:
    relies = bearing(Role.STAND_ON, Geometry.OVERTAKING)
    barge = DynamicBumper(length=120.0, full_speed=6.5)
    behind = replace(target(-120.0, -150.0, EAST, 6.5, relies, barge), hull=Hull(length=120.0, beam=11.0))
    sailed = sail(outlook(behind), 6.0)  # its domain is far ahead of this ship, its circle passes

    assert max(abs(now.pose.x) for now, _ in sailed) < 0.05


def test_static_obstacle_is_gone_round() -> None:
    sailed = sail(outlook(on=waters(None, Obstacle(id="buoy", x=0.5, y=60.0, radius=3.0))), 20.0)
    away = [math.hypot(now.pose.x - 0.5, now.pose.y - 60.0) for now, _ in sailed]

    assert min(away) >= 3.0 + 0.8 * 5.0 - 0.1
    assert sailed[-1][0].pose.y > 75.0


@pytest.mark.parametrize(
    "domain", [Rectangle(length=5.0, breadth=3.0), Ellipse(ahead=10.0, aside=4.0), BUMPER]
)
def test_every_domain_keeps_clear(domain: AbstractDomain) -> None:
    now = outlook(target(0.5, 60.0, -EAST, 4.0, HEAD_ON, domain), domain=domain)
    sailed = sail(now, 7.0)

    assert least_gap(sailed) > -0.1


def test_plan_that_cannot_keep_clear_is_told() -> None:
    steering = CONTROLLER.steer(outlook(target(0.0, 6.0, -EAST, 4.0, HEAD_ON)), None)

    assert steering.outcome.startswith("no plan keeps the domains apart")
    assert math.isfinite(steering.motion.surge)


def test_plan_begins_where_the_ship_is_and_covers_the_horizon() -> None:
    plan = CONTROLLER.steer(outlook(), None).plan.poses

    assert plan.shape == (21, 3)
    assert plan[0] == pytest.approx([0.0, 0.0, EAST])


@pytest.mark.parametrize(
    ("place", "velocity", "expected"),
    [
        ((100.0, 0.0), (-4.0, 0.0), Geometry.HEAD_ON),
        ((100.0, 5.0), (3.0, 0.0), Geometry.OVERTAKING),
        ((80.0, 80.0), (0.0, -5.0), Geometry.CROSSING),
        ((80.0, -80.0), (0.0, 5.0), Geometry.CROSSING),
        ((-100.0, 0.0), (9.0, 0.0), Geometry.NONE),
        ((100.0, 0.0), (9.0, 0.0), Geometry.NONE),
    ],
)
def test_encounters_are_divided_by_sight_and_velocities(
    place: tuple[float, float], velocity: tuple[float, float], expected: Geometry
) -> None:
    found = division(np.zeros(2), np.array([6.0, 0.0]), np.array(place), np.array(velocity))

    assert found is expected


def test_options_are_those_of_the_page() -> None:
    page = (Path(__file__).parents[2] / "docs" / "bumper-mpc.md").read_text(encoding="utf-8")
    options = page.partition("## Options")[2].partition("\n## ")[0]

    assert set(re.findall(r"`([a-z_]+)`", options)) - {"control"} == set(CONTROLLER.options)


def test_boat_goes_aside_for_a_barge_before_it_slows_down_for_its_domain() -> None:
    barge = DynamicBumper(length=132.0, full_speed=2.4)
    ahead = replace(target(0.0, 700.0, -EAST, 2.4, HEAD_ON, barge), hull=Hull(length=132.0, beam=11.4))

    assert max(-now.pose.x for now, _ in sail(outlook(ahead), 6.0)) > 5.0
