"""An encounter of two ships under way as a scenario: each sails straight on, on a waterway of its own."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from ..frames import NedPose
from ..ships import Hull, Ship
from ..tapd.cases import Case, CaseShip
from ..units import DEGREE, wrap
from ..waterway import Leg, Towards, Waters, Waterway
from .scenario import Plan, Scenario

_WIDTH: Final = 160.0  # of a waterway [m]
_PARALLEL: Final = 10.0 * DEGREE  # ships on such courses share a waterway, if it is wide enough
_ASTERN: Final = 300.0  # a waterway begins so far behind its ship [m]
_AHEAD: Final = 500.0  # and reaches so far [m]
_TIME: Final = 900.0  # after the way of this time [s]
_IN_KEYS: Final = ("length", "beam", "weight")  # facts that a scenario states as keys of their own


def scenario_of(case: Case, ruleset: str) -> Scenario:
    """Lay waterways through the two ships of a case.

    Raises
    ------
    ValueError
        If it is not about two ships under way.
    """
    if len(case.ships) != 2 or any(ship.pose is None or not ship.speed for ship in case.ships):
        raise ValueError(f"case {case.id!r} is not about two ships under way")
    poses = [NedPose(*ship.pose) for ship in case.ships if ship.pose is not None]
    facts = {"upstream_defined": True, **case.waterway}
    reach = _AHEAD + _TIME * max(ship.speed or 0.0 for ship in case.ships)
    first = _through("first", poses[0], reach, facts)
    towards = _along(first, poses)
    if towards is None:
        waterways: tuple[Waterway, ...] = (first, _through("second", poses[1], reach, facts))
        legs = (Leg("first", Towards.END, 0.0), Leg("second", Towards.END, 0.0))
    else:
        waterways = (_through("first", poses[0], reach, facts, behind=reach),)
        offset = waterways[0].frame(towards).to_path(poses[1]).y
        legs = (Leg("first", Towards.END, 0.0), Leg("first", towards, round(offset, 2)))
    return Scenario(
        name=case.id,
        title=case.title,
        waters=Waters(ruleset=ruleset, waterways=waterways),
        ships=tuple(_plan(ship, pose, leg) for ship, pose, leg in zip(case.ships, poses, legs, strict=True)),
    )


def _along(first: Waterway, poses: list[NedPose]) -> Towards | None:
    """The end for which the second ship makes on the first one's waterway; None where it is not on it."""
    turn = wrap(poses[1].course - poses[0].course)
    beside = abs(first.frame(Towards.END).to_path(poses[1]).y)
    if beside > _WIDTH / 2.0 - 10.0:
        return None
    if abs(turn) < _PARALLEL:
        return Towards.END
    return Towards.START if abs(turn) > math.pi - _PARALLEL else None


def _through(
    id_: str, pose: NedPose, reach: float, facts: Mapping[str, Any], behind: float = _ASTERN
) -> Waterway:
    ahead = np.array([math.cos(pose.course), math.sin(pose.course)])
    here = np.array([pose.x, pose.y])
    line = np.round([here - behind * ahead, here + reach * ahead], 2) + 0.0
    return Waterway(id=id_, centreline=line, width=_WIDTH, facts=facts)


def _plan(ship: CaseShip, pose: NedPose, leg: Leg) -> Plan:
    length = float(ship.facts.get("length", 80.0))
    beam = float(ship.facts.get("beam", max(2.0, round(length / 8.0, 1))))
    mass = float(ship.facts.get("weight", round(1.5 * length * beam) * 1000.0))
    facts = {name: value for name, value in ship.facts.items() if name not in _IN_KEYS}
    return Plan(
        ship=Ship(id=ship.id, hull=Hull(length=length, beam=beam), mass=mass, facts=facts),
        route=(leg,),
        start=pose,
        speed=ship.speed or 0.0,
    )
