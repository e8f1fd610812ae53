"""What the roles ask of a ship's controller."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ccas_core.dmpc.local_problem import LocalPlan, LocalProblem, free_speeds
from ccas_core.dmpc.negotiate import remembered
from ccas_core.dmpc.parameters import FAITHFUL, Roles
from ccas_core.dmpc.resolve import Memory, Resolve, Seen
from ccas_core.dmpc.stance import Stance, safest, take_stance
from ccas_core.dmpc.trajectories import rollout
from ccas_core.frames import FloatArray, PathPose, PathTrajectory
from ccas_core.priority import Bearing
from ccas_core.roles import Geometry, PassingSide, Role
from ccas_core.ships import Hull, ShipId

HULL = Hull(length=80.0, beam=9.0)
OTHER = ShipId("other")
HORIZON, STEP, SPEED = FAITHFUL.horizon, 20.0, 3.0
ROOM = np.tile([-70.0, 70.0], (HORIZON, 1))
ROLES = Roles()


def problem(last_offset: float = 0.0, room: float = 60.0) -> LocalProblem:
    return LocalProblem(
        initial=PathPose(0.0, last_offset, 0.0),
        last_offset=last_offset,
        speed=SPEED,
        settings=FAITHFUL,
        offset_limits=np.tile([-room, room], (HORIZON, 1)),
        speed_limits=free_speeds(HORIZON),
        threats=np.zeros((0, HORIZON, 6)),
        multiplier=np.zeros((HORIZON + 1, 3)),
        broadcast=PathTrajectory(np.zeros((HORIZON + 1, 3))),
    )


def sails(x: float, y: float, course: float, speed: float = SPEED) -> PathTrajectory:
    """A ship that goes on as it is, in the own path frame."""
    way = speed * STEP * np.arange(HORIZON + 1)
    return PathTrajectory(
        np.column_stack([x + way * np.cos(course), y + way * np.sin(course), np.full(HORIZON + 1, course)])
    )


def met(
    role: Role,
    geometry: Geometry,
    path: PathTrajectory,
    side: PassingSide | None = None,
    unmoved: PathTrajectory | None = None,
) -> Seen:
    return Seen(OTHER, HULL, path, Bearing(role=role, passing_side=side, geometry=geometry), unmoved)


def stance(
    seen: Seen, memory: Memory | None = None, last: FloatArray | None = None, room: float = 60.0
) -> Stance:
    return take_stance(HULL, problem(room=room), ROOM, last, [seen], memory or Memory(), ROLES)


AHEAD = sails(2400.0, 0.0, math.pi)  # head-on, on the same line, in 400 s
CLEAR = sails(2400.0, 70.0, math.pi)
ACROSS = sails(1200.0, -1200.0, math.pi / 2.0)  # from port, at the same point in 400 s
SLOWER = sails(600.0, 0.0, 0.0, speed=1.5)


@pytest.mark.parametrize("role", Role)
def test_a_ship_whose_line_is_clear_stays_on_it(role: Role) -> None:
    found = stance(met(role, Geometry.HEAD_ON, CLEAR))

    assert np.all(np.abs(found.offset_limits) <= 0.05)
    assert np.all(found.speed_limits[:, 0] >= 0.999)
    assert not found.memory.acting


def test_a_ship_that_stands_on_holds_while_there_is_time() -> None:
    found = stance(met(Role.STAND_ON, Geometry.CROSSING, ACROSS))

    assert not found.memory.acting
    assert np.all(np.abs(found.offset_limits) <= 0.05)


@pytest.mark.parametrize(
    ("geometry", "path"),
    [
        (Geometry.HEAD_ON, sails(320.0, 0.0, math.pi)),
        (Geometry.CROSSING, sails(130.0, -130.0, math.pi / 2.0)),
    ],
)
def test_a_ship_that_stands_on_acts_at_the_last_moment(geometry: Geometry, path: PathTrajectory) -> None:
    found = stance(met(Role.STAND_ON, geometry, path))

    assert found.memory.resolves[OTHER].alarmed
    assert found.memory.acting
    assert found.gains == (ROLES.give_way,)


def test_an_alarmed_ship_stays_alarmed_until_the_encounter_is_over() -> None:
    memory = Memory(resolves={OTHER: Resolve(alarmed=True)}, acting=True)

    during = stance(met(Role.STAND_ON, Geometry.HEAD_ON, AHEAD), memory)
    after = stance(met(Role.NONE, Geometry.NONE, CLEAR), memory)

    assert during.memory.acting
    assert not after.memory.resolves


@pytest.mark.parametrize(
    ("side", "sign"),
    [
        (PassingSide.PORT_TO_PORT, 1.0),
        (PassingSide.STARBOARD_TO_STARBOARD, -1.0),
        (None, 1.0),
    ],
)
def test_a_ship_that_gives_way_head_on_goes_to_its_side_at_once_and_visibly(
    side: PassingSide | None, sign: float
) -> None:
    found = stance(met(Role.GIVE_WAY, Geometry.HEAD_ON, AHEAD, side))

    inner = found.offset_limits[0, 0] if sign > 0.0 else -found.offset_limits[0, 1]
    assert inner == ROLES.visible_offset
    assert all(sign * start[0, 0] >= ROLES.visible_offset for start in found.starts)
    assert found.settings.weights.side == sign


@pytest.mark.parametrize(
    ("side", "sign"),
    [(PassingSide.OVERTAKE_ON_PORT, -1), (PassingSide.OVERTAKE_ON_STARBOARD, 1)],
)
def test_an_overtaking_ship_passes_on_the_side_that_is_prescribed(side: PassingSide, sign: int) -> None:
    found = stance(met(Role.GIVE_WAY, Geometry.OVERTAKING, SLOWER, side))

    assert found.memory.resolves[OTHER].side == sign


def test_a_ship_that_gives_way_in_a_crossing_slows_down_at_once_and_visibly() -> None:
    found = stance(met(Role.GIVE_WAY, Geometry.CROSSING, ACROSS))

    assert found.speed_limits[0, 1] == ROLES.visible_factor
    assert found.memory.resolves[OTHER].slowed
    assert found.settings.weights.K_y == ROLES.crossing.K_y


def test_a_ship_that_crosses_one_other_stays_slow_until_its_line_is_clear() -> None:
    slowed = Memory(resolves={OTHER: Resolve(slowed=True)}, acting=True)
    another = replace(met(Role.GIVE_WAY, Geometry.CROSSING, ACROSS), id=ShipId("third"))
    both = [met(Role.GIVE_WAY, Geometry.CROSSING, ACROSS), another]
    before = replace(slowed, resolves={each.id: Resolve(slowed=True) for each in both if each.id})

    alone = stance(both[0], slowed)
    among_two = take_stance(HULL, problem(), ROOM, None, both, before, ROLES)

    assert alone.speed_limits[0, 1] == ROLES.visible_factor
    assert among_two.speed_limits[0, 1] == 1.0  # or it might never get through


def test_a_ship_that_acts_again_soon_returns_with_twice_the_gap_only() -> None:
    seen = met(Role.GIVE_WAY, Geometry.HEAD_ON, AHEAD)
    clear = met(Role.GIVE_WAY, Geometry.HEAD_ON, CLEAR)  # by 59 m

    soon, later = (stance(seen, Memory(rested=rested)).memory for rested in (2, 50))

    assert (soon.relapses, later.relapses) == (1, 0)
    assert not stance(clear, Memory(acting=True, rested=0)).memory.acting
    assert stance(clear, Memory(acting=True, rested=0, relapses=2)).memory.acting


def test_a_ship_that_has_waited_long_takes_the_first_gap() -> None:
    clear = met(Role.GIVE_WAY, Geometry.CROSSING, sails(1200.0, -1000.0, math.pi / 2.0))  # by 100 m
    careful = Memory(acting=True, rested=0, relapses=3)

    assert stance(clear, careful).memory.acting
    assert not stance(clear, replace(careful, waited=ROLES.patience + 1.0)).memory.acting


def test_a_ship_remembers_how_long_it_has_waited_until_it_has_rested() -> None:
    seen = met(Role.GIVE_WAY, Geometry.CROSSING, ACROSS)
    found = stance(seen, Memory(acting=True, rested=0, waited=2.0))

    after = remembered(found, plan(np.tile([0.0, 0.25], (HORIZON, 1))))

    assert after.waited == 2.75
    assert stance(seen, replace(after, acting=False, rested=50)).memory.waited == 0.0


def test_a_ship_without_room_to_go_aside_shows_by_its_speed_that_it_gives_way() -> None:
    found = stance(met(Role.GIVE_WAY, Geometry.HEAD_ON, AHEAD, PassingSide.PORT_TO_PORT), room=8.0)

    assert found.speed_limits[0, 1] == ROLES.visible_factor


def test_where_both_are_to_act_a_ship_acts_though_the_other_has_told_that_it_will() -> None:
    found = stance(met(Role.BOTH, Geometry.HEAD_ON, CLEAR, PassingSide.PORT_TO_PORT, AHEAD))

    assert found.memory.resolves[OTHER].side == 1
    assert found.offset_limits[0, 0] == ROLES.visible_offset


def test_a_ship_near_a_bank_returns_by_steps_for_its_stern_swings_out() -> None:
    aside = problem(last_offset=50.0)
    wide, narrow = (np.tile([-room, room], (HORIZON, 1)) for room in (90.0, 52.0))
    clear = [met(Role.NONE, Geometry.NONE, sails(5000.0, 500.0, math.pi))]

    free, near = (
        take_stance(HULL, aside, room, None, clear, Memory(), ROLES).anchor[0, 0] for room in (wide, narrow)
    )

    assert free == 0.0
    assert 0.0 < near < 50.0


def test_a_plan_that_clears_is_kept() -> None:
    first = stance(met(Role.GIVE_WAY, Geometry.HEAD_ON, AHEAD))
    kept = np.tile([30.0, 1.0], (HORIZON, 1))

    found = stance(met(Role.GIVE_WAY, Geometry.HEAD_ON, AHEAD), first.memory, kept)

    assert len(found.starts) == 1
    assert np.array_equal(found.starts[0], kept)


def test_profiles_go_over_into_one_another_by_thirds() -> None:
    memory = Memory(crossing=0.0, acting=True)

    found = stance(met(Role.GIVE_WAY, Geometry.CROSSING, ACROSS), memory)

    assert found.memory.crossing == pytest.approx(1.0 / 3.0)
    assert FAITHFUL.weights.K_y < found.settings.weights.K_y < ROLES.crossing.K_y


def test_risk_towards_a_ship_on_which_one_relies_weighs_little() -> None:
    danger = Seen(
        ShipId("third"),
        HULL,
        AHEAD,
        Bearing(role=Role.GIVE_WAY, passing_side=None, geometry=Geometry.HEAD_ON),
    )
    relied = met(Role.STAND_ON, Geometry.CROSSING, ACROSS)

    found = take_stance(HULL, problem(), ROOM, None, [danger, relied], Memory(), ROLES)

    assert found.gains == (ROLES.give_way, ROLES.stand_on)
    assert found.settings.weights.mu_2 == ROLES.steadiness * FAITHFUL.weights.mu_2


def abeam(id_: str, y: float, speed: float = 2.5) -> Seen:
    """A slower ship ahead, on a line of its own, to which the own ship gives way."""
    bearing = Bearing(role=Role.GIVE_WAY, passing_side=None, geometry=Geometry.OVERTAKING)
    return Seen(ShipId(id_), HULL, sails(300.0, y, 0.0, speed=speed), bearing)


def test_a_ship_between_two_others_goes_on_where_going_aside_would_lead_nearer_to_one() -> None:
    between = [abeam("port", -21.0), abeam("starboard", 21.0)]  # by 10 m; aside by 12 m, nearer than 0 m

    found = take_stance(HULL, problem(room=20.0), ROOM, None, between, Memory(), ROLES)
    sailed = plan(np.tile([12.0, 1.0], (HORIZON, 1)), room=20.0)
    secured = safest(HULL, problem(room=20.0), ROOM, sailed, between, found, ROLES.clear_by)

    assert found.offset_limits[0, 0] <= 0.0 <= found.offset_limits[0, 1]  # nothing has to be visible
    assert found.speed_limits[0, 1] == 1.0
    assert secured is not None
    assert np.all(secured.controls == [0.0, 1.0])


def plan(controls: FloatArray, last_offset: float = 0.0, room: float = 60.0) -> LocalPlan:
    return rollout(problem(last_offset, room), controls)


def test_a_ship_that_is_aside_for_one_stays_there_when_it_has_to_stop_for_another() -> None:
    """If it turned back to its line as it stops, its bow would come too near to the one that it meets."""
    ahead = met(Role.GIVE_WAY, Geometry.HEAD_ON, sails(900.0, 2.0, math.pi))
    third = met(Role.GIVE_WAY, Geometry.CROSSING, sails(330.0, -330.0, math.pi / 2.0))
    seen = [ahead, replace(third, id=ShipId("third"))]
    aside = replace(problem(last_offset=-20.0), offset_limits=np.tile([-25.0, 5.0], (HORIZON, 1)))
    on = rollout(aside, np.tile([-20.0, 1.0], (HORIZON, 1)))
    memory = Memory(resolves={OTHER: Resolve(side=-1)}, acting=True)
    found = take_stance(HULL, aside, ROOM, None, seen, memory, ROLES)

    secured = safest(HULL, aside, ROOM, on, seen, found, ROLES.clear_by)

    assert secured is not None
    assert secured.controls[0, 0] <= -16.0
    assert secured.controls[0, 1] < 1.0


def test_a_ship_that_stands_on_to_one_and_is_aside_for_another_keeps_its_side() -> None:
    """Where it is it could not stay for good: its line says for whom it acts, not its present offset."""
    relied = met(Role.STAND_ON, Geometry.HEAD_ON, sails(4000.0, 90.0, math.pi))
    seen = [relied, abeam("overtaken", -8.0), abeam("farther", 40.0)]
    memory = Memory(resolves={ShipId("overtaken"): Resolve(side=1)}, acting=True)

    found = take_stance(HULL, problem(last_offset=22.0), ROOM, None, seen, memory, ROLES)

    assert found.memory.resolves == memory.resolves
    assert found.offset_limits[0, 0] >= 0.0
    assert found.starts[0][0, 0] > 0.0


def test_a_ship_does_not_stop_for_good_for_a_metre_of_water() -> None:
    """Between two lines of ships that meet it, 4 m from the safety areas of both."""
    bearing = Bearing(role=Role.GIVE_WAY, passing_side=None, geometry=Geometry.HEAD_ON)
    lanes = [Seen(ShipId(f"at {y}"), HULL, sails(2690.0, y, math.pi), bearing) for y in (-3.5, 29.0)]

    beside_bank = replace(problem(), offset_limits=np.tile([-3.0, 20.0], (HORIZON, 1)))

    found = take_stance(HULL, beside_bank, ROOM, None, lanes, Memory(), ROLES)

    assert all(np.all(start[:, 1] == 1.0) for start in found.starts)
    assert found.starts[0][0, 0] == 12.0


def test_a_plan_that_waits_for_nothing_gives_way_to_one_that_goes_on() -> None:
    """Nothing clears an overtaken ship by more than 3 m: stops and starts would not, either."""
    seen = [abeam("overtaken", -14.0)]
    beside = replace(problem(last_offset=0.0, room=0.3), initial=PathPose(300.0, 0.0, 0.0))
    found = take_stance(HULL, beside, ROOM, None, seen, Memory(), ROLES)
    stops = np.tile([0.0, 1.0], (HORIZON, 1))
    stops[::4, 1] = 0.7

    secured = safest(HULL, beside, ROOM, rollout(beside, stops), seen, found, ROLES.clear_by)

    assert secured is not None
    assert np.all(secured.controls[:, 1] == 1.0)


def test_a_manoeuvre_taken_in_the_end_stays_aside_as_long_as_the_stance_asks() -> None:
    """For one that it would pass by 13 m as well, which alone would not make it take another plan."""
    later = met(Role.GIVE_WAY, Geometry.HEAD_ON, sails(4000.0, -24.0, math.pi), PassingSide.PORT_TO_PORT)
    seen = [
        met(Role.GIVE_WAY, Geometry.HEAD_ON, AHEAD, PassingSide.PORT_TO_PORT),
        replace(later, id=ShipId("later")),
    ]
    found = take_stance(HULL, problem(), ROOM, None, seen, Memory(), ROLES)
    across = plan(np.tile([0.0, 1.0], (HORIZON, 1)))

    secured = safest(HULL, problem(), ROOM, across, seen, found, ROLES.clear_by)

    assert secured is not None
    assert np.all(secured.controls[:, 0] >= found.offset_limits[:, 0])
