"""What a ship sees of the others, and what it has resolved towards them: kept from period to period.

A resolve holds until the ships are past and clear.  It is there against changing one's mind: a side is kept
while it clears, and a ship that has to act again soon returns to its line later.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from ..frames import FloatArray, PathTrajectory
from ..priority import NO_BEARING, Bearing
from ..roles import Geometry, PassingSide, Role
from ..ships import Hull, ShipId
from .local_problem import LocalProblem
from .manoeuvres import Manoeuvres
from .parameters import Roles

_SIDE: Final = {  # to which side a ship goes to pass as prescribed: +1 starboard, -1 port
    PassingSide.PORT_TO_PORT: 1,
    PassingSide.STARBOARD_TO_STARBOARD: -1,
    PassingSide.OVERTAKE_ON_PORT: -1,
    PassingSide.OVERTAKE_ON_STARBOARD: 1,
}
_USUAL: Final = {Geometry.HEAD_ON: (1, -1), Geometry.OVERTAKING: (-1, 1)}  # where none is prescribed
_OBLIGED: Final = (Role.GIVE_WAY, Role.BOTH)
_TURNS: Final = 2  # changes of side in an encounter
_RESTED: Final = 10  # periods without an action after which one that follows is a new one
_RELAPSES: Final = 3  # that make a ship more careful each time


@dataclass(frozen=True, slots=True, kw_only=True)
class Resolve:
    """What a ship has resolved towards one neighbour; it holds until they are past and clear."""

    alarmed: bool = False  # the other does not give way: act
    side: int = 0  # side to which the ship goes, +1 starboard
    turns: int = 0  # how often it has gone back on a side that did not clear any more
    slowed: bool = False  # a visible reduction of speed was made


@dataclass(frozen=True, slots=True, kw_only=True)
class Memory:
    """What a ship carries from one period to the next."""

    resolves: Mapping[ShipId, Resolve] = field(default_factory=dict)
    crossing: float = 0.0  # share of the crossing profile, 0 to 1
    acting: bool = False
    rested: int = 1000  # periods since it last acted
    relapses: int = 0  # how often it has acted again without having rested
    waited: float = 0.0  # periods that it has lost by its speed since it rested


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """A neighbour, or an obstacle without an id, in the own path frame."""

    id: ShipId | None
    hull: Hull
    path: PathTrajectory
    bearing: Bearing = NO_BEARING
    unmoved: PathTrajectory | None = None  # where it would be if it went on as it is

    @property
    def crosses(self) -> bool:
        """Whether it is met as in a crossing; where no verdict says so, by its course."""
        if self.bearing.geometry is not Geometry.NONE:
            return self.bearing.geometry is Geometry.CROSSING
        return abs(math.sin(float(self.path.poses[0, 2]))) > math.sin(math.pi / 8.0)


def resolve_of(each: Seen, resolves: Mapping[ShipId, Resolve]) -> Resolve:
    """What is resolved towards a neighbour: nothing yet, unless it is known."""
    return Resolve() if each.id is None else resolves.get(each.id, Resolve())


def relies(each: Seen, resolves: Mapping[ShipId, Resolve]) -> bool:
    """Whether the ship stands on, and relies on the other to keep clear."""
    return each.bearing.role is Role.STAND_ON and not resolve_of(each, resolves).alarmed


def resolved(
    each: Seen, resolves: Mapping[ShipId, Resolve], hand: Manoeuvres, worst: FloatArray, roles: Roles
) -> dict[ShipId, Resolve]:
    """Choose the side on which to leave a ship to which the own ship gives way, and seldom another."""
    found = dict(resolves)
    resolve = resolve_of(each, resolves)
    geometry = each.bearing.geometry
    if each.id is None or each.bearing.role not in _OBLIGED or geometry not in _USUAL:
        return found
    side = each.bearing.passing_side
    options: tuple[int, ...] = _USUAL[geometry]
    if side in _SIDE:  # overtaking, the prescribed side is the one to be preferred
        options = (_SIDE[side], -_SIDE[side]) if geometry is Geometry.OVERTAKING else (_SIDE[side],)
    best = {s: float(worst[hand.side == s].max()) for s in options}
    if resolve.side and (best.get(resolve.side, 0.0) >= 0.0 or resolve.turns >= _TURNS):
        return found
    enough = roles.resume_beyond if geometry is Geometry.OVERTAKING and side not in _SIDE else roles.clear_by
    chosen = next((s for s in options if best[s] >= enough), max(options, key=best.__getitem__))
    if best[chosen] >= 0.0 or geometry is Geometry.HEAD_ON:
        turned = resolve.side not in (0, chosen)
        found[each.id] = replace(resolve, side=chosen, turns=resolve.turns + turned)
    elif resolve.side:
        found[each.id] = replace(resolve, side=0, turns=resolve.turns + 1)
    return found


def must_slow(
    problem: LocalProblem,
    each: Seen,
    active: Sequence[Seen],
    resolves: Mapping[ShipId, Resolve],
    roles: Roles,
) -> bool:
    """Whether a ship is to show by its speed that it gives way: crossing, or without room to go aside.

    Crossing one ship alone, it does so until its line is clear at full speed: what it loses at once it need
    not lose later by fits and starts.  Among several it does so once, or it might never get through.
    """
    resolve = resolve_of(each, resolves)
    if each.bearing.role not in _OBLIGED or (resolve.slowed and not (each.crosses and len(active) == 1)):
        return False
    low, high = problem.offset_limits[0]
    aside = high if resolve.side > 0 else -low
    return each.crosses or bool(resolve.side and aside < roles.visible_offset)


def resumed(memory: Memory, resolves: Mapping[ShipId, Resolve], crossing: float) -> Memory:
    """Memory of a ship that acts: after each relapse it returns to its line with twice the gap only."""
    relapses, waited = memory.relapses, memory.waited
    if not memory.acting and memory.rested >= _RESTED:
        relapses, waited = 0, 0.0
    elif not memory.acting:
        relapses = min(relapses + 1, _RELAPSES)
    return Memory(
        resolves=resolves, crossing=crossing, acting=True, rested=0, relapses=relapses, waited=waited
    )


def gap_to_hold(memory: Memory, roles: Roles) -> float:
    """Gap [m] that the line of a ship has to leave for it to hold.

    A ship that has waited long takes the first gap, or ships that are careful of one another would all stop.
    """
    if memory.waited > roles.patience and memory.rested < _RESTED:
        return roles.clear_by
    return roles.resume_beyond * 2.0**memory.relapses if memory.acting else roles.act_within
