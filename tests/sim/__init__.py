"""Tests of the simulation, and voyages made by hand for them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ccas_core.frames import NedPose, NedTrajectory, PathPose
from ccas_core.priority import Settlement, settle
from ccas_core.roles import Geometry, PassingSide
from ccas_core.ships import Hull, Ship, ShipId
from ccas_core.sim.frame import Frame, ShipFrame
from ccas_core.sim.scenario import Plan, Scenario
from ccas_core.verdict import Citation, Kind, Verdict
from ccas_core.waterway import Leg, Obstacle, Towards, Waters, Waterway, guiding_line

A, B, C = ShipId("a"), ShipId("b"), ShipId("c")
STEP = 20.0  # [s]
SPEED = 3.0  # [m/s]
PAPER_HULL = Hull(length=103.0, beam=11.4, safety_length=103.0, safety_beam=17.2)
EAST = Leg("canal", Towards.END)
WEST = Leg("canal", Towards.START)
NORTH = Leg("river", Towards.END)

Commands = Sequence[tuple[float, float]]  # offset [m] and speed factor, one a period; the last one stays
Settled = Callable[[int], tuple[Settlement, ...]]


def ship(id_: ShipId, hull: Hull = PAPER_HULL) -> Ship:
    return Ship(id=id_, hull=hull, mass=2e6)


def waters(width: float = 400.0, obstacles: tuple[Obstacle, ...] = ()) -> Waters:
    """Lay a canal from west to east and a river from south to north, 6 km each, through the origin."""
    canal = Waterway(id="canal", centreline=np.array([[0.0, -3000.0], [0.0, 3000.0]]), width=width)
    river = Waterway(id="river", centreline=np.array([[-3000.0, 0.0], [3000.0, 0.0]]), width=width)
    return Waters(ruleset="bpr", waterways=(canal, river), obstacles=obstacles)


def plan(id_: ShipId, leg: Leg, before: float, aside: float = 0.0) -> Plan:
    """Start a ship so far before the middle of a waterway, and so far to starboard of its line."""
    line = guiding_line(waters(), (leg,)).frame
    start = line.to_ned(PathPose(line.length / 2.0 - before, aside, 0.0))
    return Plan(ship=ship(id_), route=(leg,), start=start, speed=SPEED)


def scenario(*plans: Plan, on: Waters | None = None) -> Scenario:
    return Scenario(name="by hand", waters=on or waters(), ships=plans, time_step=STEP)


def settlement(
    one: Kind,
    other: Kind,
    *,
    pair: tuple[ShipId, ShipId] = (A, B),
    geometry: Geometry = Geometry.HEAD_ON,
    side: PassingSide | None = None,
    required: bool = False,
    chosen_by: ShipId | None = None,
) -> Settlement:
    def view(own: ShipId, target: ShipId, kind: Kind) -> Verdict:
        return Verdict(
            own=own,
            other=target,
            kind=kind,
            ruleset="bpr",
            version="1",
            rule="by_hand",
            citation=Citation(regulation="BPR", article="6.04"),
            geometry=geometry,
            passing_side=side,
            passing_required=required,
            side_chosen_by=chosen_by,
            initiator=pair[0] if kind in (Kind.COOPERATE, Kind.PROHIBITED) else None,
            reason="made by hand",
            facts={"tcpa_s": math.inf, "is_near": True},
        )

    first, second = pair
    return settle(view(first, second, one), view(second, first, other), {A: 1.0, B: 2.0, C: 3.0})


def always(*settlements: Settlement) -> Settled:
    """Settle the pairs so in every period in which both ships are under way."""
    return lambda _: settlements


def voyage(
    of: Scenario, commands: Mapping[ShipId, Commands], settled: Settled = lambda _: (), periods: int = 200
) -> list[Frame]:
    """Sail by hand: a ship is at its commanded offset at the end of each period."""
    lines = {each.ship.id: guiding_line(of.waters, each.route).frame for each in of.ships}
    state = {each.ship.id: lines[each.ship.id].to_path(each.start) for each in of.ships}
    frames: list[Frame] = []
    arrived: dict[ShipId, float] = {}
    for index in range(periods):
        ships = {}
        for id_, here in state.items():
            offset, factor = commands[id_][min(index, len(commands[id_]) - 1)]
            ships[id_] = _ship_frame(lines[id_].to_ned(here), here, offset, factor)
        frames.append(
            Frame(
                index=index,
                time=index * STEP,
                ships=ships,
                settlements=tuple(each for each in settled(index) if set(each.pair) <= ships.keys()),
                openings=(),
                generations=(tuple(ships),),
                arrived=dict(arrived),
            )
        )
        if not ships:
            break
        for id_, now in ships.items():
            ahead = now.speed * STEP
            turn = math.atan2(now.offset - now.path_y, ahead)
            left = lines[id_].length - now.path_x
            state[id_] = PathPose(now.path_x + ahead, now.offset, turn)
            if ahead >= left:
                arrived[id_] = index * STEP + left / now.speed
                del state[id_]
    return frames


def _ship_frame(pose: NedPose, here: PathPose, offset: float, factor: float) -> ShipFrame:
    return ShipFrame(
        pose=pose,
        path_x=here.x,
        path_y=here.y,
        speed=factor * SPEED,
        offset=offset,
        speed_factor=factor,
        ruleset="bpr",
        plan=NedTrajectory(np.array([[pose.x, pose.y, pose.course]])),
        outcome="",
        fallback="",
        update_ms=(1.0, 3.0),
        residuals=(0.0,),
    )
