"""What the roles of a ship ask of its controller: its stance in one period (Sec. 4.2, 5.4).

Of a neighbour the stance knows the role, the passing side and the geometry, and nothing else of a rule.

A ship whose guiding line at full speed stays clear of all to whom it owes something *holds*: it is on its
line, or returns to it.  A ship that stands on holds as well, as long as the other's plan clears
the situation, or there is still time.  The last moment has come when a ship that goes on for `reserve` more
periods finds no manoeuvre at hand that clears; then it acts, until the ships are past and clear.
A ship that is to give way acts at once, and visibly: head-on and overtaking to one side, which it keeps;
crossing by its speed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..frames import FloatArray, PathTrajectory
from ..roles import Role
from ..ships import Hull, ShipId
from ..waterway import BANK_MARGIN
from .clearance import bank_gaps, gaps
from .local_problem import LocalPlan, LocalProblem
from .manoeuvres import DEAR, Manoeuvres, at_hand, both_at_hand, together
from .parameters import Roles, Settings, blended
from .resolve import Memory, Resolve, Seen, gap_to_hold, must_slow, relies, resolve_of, resolved, resumed
from .trajectories import sailed

_STEADY_OFFSET: Final = 0.05  # of a ship that holds [m]: solvers want some room between bounds
_STEADY_FACTOR: Final = 1e-3
_MUCH: Final = 2.0  # periods that another plan must save to be taken instead of the last
_FAR_DEARER: Final = 10.0  # periods by which a start may cost more than the best
_WATER: Final = DEAR  # what a metre of water is worth that is missing: a period
_RETURNS: Final = (0.0, 0.5, 0.75, 0.875)  # shares of the present offset to which a ship returns at once
_BETTER: Final = 1.0  # gap that a manoeuvre must gain over the solver's plan to replace it [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stance:
    """How a ship goes into a period's negotiation."""

    settings: Settings
    offset_limits: FloatArray  # (N, 2) [m]
    speed_limits: FloatArray  # (N, 2)
    gains: tuple[float, ...]  # factor of K_ca towards each neighbour
    starts: tuple[FloatArray, ...]  # controls, (N, 2) each
    anchor: FloatArray  # controls of the trajectory that the negotiation begins with
    until: int  # period up to which `offset_limits` keep the ship aside
    memory: Memory


def take_stance(
    hull: Hull,
    problem: LocalProblem,
    room: FloatArray,
    last: FloatArray | None,
    seen: Sequence[Seen],
    memory: Memory,
    roles: Roles,
) -> Stance:
    """Take a stance towards all neighbours.

    Parameters
    ----------
    hull
        Of the own ship.
    problem
        Its local problem without threats.
    room
        Offsets between which the hull keeps its margin to the banks, (N, 2) [m].
    last
        Controls of the last period's plan, shifted; None if there is none.
    seen
        Neighbours, and where they will be.
    memory
        Of the period before.
    roles
        How much a role weighs.
    """
    known = {each.id for each in seen if each.bearing.role is not Role.NONE}
    resolves = {id_: resolve for id_, resolve in memory.resolves.items() if id_ in known}
    enough = gap_to_hold(memory, roles)
    base = _base(problem, seen, resolves)
    held = _holding(hull, problem, room, base, seen, resolves)
    resolves |= _alarmed(hull, problem, room, base, seen, resolves, held, roles)
    concerned = _concerned(seen, resolves, held, enough)
    if concerned and base:  # where it is, it cannot stay: what counts is its line
        base = 0.0
        held = _holding(hull, problem, room, base, seen, resolves)
        concerned = _concerned(seen, resolves, held, enough)
    committed = [
        n
        for n, each in enumerate(seen)
        if each.bearing.role is Role.BOTH and resolve_of(each, resolves).side and n not in concerned
    ]
    if not concerned and not committed:
        idle = replace(memory, resolves=resolves, acting=False, rested=memory.rested + 1)
        return _hold(problem, held.controls, len(seen), idle)
    until = _until(held.ahead[[*concerned, *committed]], enough)
    hand, worst = _ways_out(hull, problem, room, base, until, seen, roles.clear_by)
    for n in concerned:
        resolves = resolved(seen[n], resolves, hand, worst, roles)
    active = [seen[n] for n in (*concerned, *committed)]
    offset_limits, speed_limits = _limits(problem, active, resolves, until, roles)
    if _is_packed_in(hand, worst, offset_limits, speed_limits, roles):
        unseen = replace(roles, visible_offset=0.0, visible_factor=1.0)
        offset_limits, speed_limits = _limits(problem, active, resolves, until, unseen)
    for n in concerned:
        id_ = seen[n].id
        if id_ is not None and must_slow(problem, seen[n], active, resolves, roles):
            resolves[id_] = replace(resolve_of(seen[n], resolves), slowed=True)
    limited = replace(problem, offset_limits=offset_limits, speed_limits=speed_limits)
    crossing = _share(memory, active)
    return Stance(
        settings=_settings(problem.settings, seen, active, resolves, crossing, roles),
        offset_limits=offset_limits,
        speed_limits=speed_limits,
        gains=tuple(_gain(each, resolves, roles) for each in seen),
        starts=(starts := _starts(hull, limited, room, last, seen, hand, worst, roles)),
        anchor=starts[0],
        until=until,
        memory=resumed(memory, resolves, crossing),
    )


def safest(
    hull: Hull,
    problem: LocalProblem,
    room: FloatArray,
    plan: LocalPlan,
    seen: Sequence[Seen],
    stance: Stance,
    enough: float,
) -> LocalPlan | None:
    """Find the gentlest manoeuvre at hand that clears by `enough` [m], or best, if a plan does not.

    Those come first that the stance allows.  `problem` has the limits of the water.
    """
    if not seen:
        return None
    on_line = sailed(problem, _steady(problem, 0.0)[None])
    ahead = _each_gap(hull, np.concatenate([on_line, plan.trajectory.poses[None]]), seen).min(axis=0)
    gap = float(_least_gap(hull, plan.trajectory.poses[None], seen, room)[0])
    if gap >= enough:
        return None
    until = max(stance.until, _until(ahead, enough))
    hand, worst = _ways_out(hull, problem, room, 0.0, until, seen, enough)
    allowed = _within(hand, stance.offset_limits, stance.speed_limits)
    best = _gentlest(hand, worst, allowed, enough)
    if best is None or worst[best] < enough:
        best = _gentlest(hand, worst, np.ones_like(allowed), enough)
    if best is None:
        return None
    saved = _cost(plan.controls, gap, enough) - _cost(hand.controls[best], worst[best], enough)
    if worst[best] < min(gap + _BETTER, enough) and saved < DEAR:
        return None
    return LocalPlan(controls=hand.controls[best], trajectory=PathTrajectory(hand.paths[best]))


def _ways_out(
    hull: Hull,
    problem: LocalProblem,
    room: FloatArray,
    base: float,
    until: int,
    seen: Sequence[Seen],
    enough: float,
) -> tuple[Manoeuvres, FloatArray]:
    """Manoeuvres at hand, also by course and speed together if none else clears; their least gaps [m]."""
    hand = at_hand(problem, base, until)
    worst = _least_gap(hull, hand.paths, seen, room)
    if np.any(worst >= enough):
        return hand, worst
    more = both_at_hand(problem, until)
    return together(hand, more), np.append(worst, _least_gap(hull, more.paths, seen, room))


def _each_gap(hull: Hull, plans: FloatArray, seen: Sequence[Seen]) -> FloatArray:
    """Least gap of each plan to each neighbour in each step [m], (M, n, N)."""
    if not seen:
        return np.zeros((len(plans), 0, plans.shape[1] - 1))
    return np.stack([gaps(hull, plans, each.hull, each.path.poses) for each in seen], axis=1)


def _least_gap(hull: Hull, plans: FloatArray, seen: Sequence[Seen], room: FloatArray) -> FloatArray:
    """Least gap of each plan to all neighbours, and to the banks, (M,) [m]."""
    ships = _each_gap(hull, plans, seen).min(axis=(1, 2), initial=math.inf)
    return np.asarray(np.minimum(ships, bank_gaps(hull, plans, room).min(axis=1) + BANK_MARGIN))


def _base(problem: LocalProblem, seen: Sequence[Seen], resolves: Mapping[ShipId, Resolve]) -> float:
    """Offset of a ship that holds [m]: the present one while it stands on, else its line."""
    return problem.last_offset if any(relies(each, resolves) for each in seen) else 0.0


def _steady(problem: LocalProblem, base: float) -> FloatArray:
    offset = np.clip(base, problem.offset_limits[:, 0], problem.offset_limits[:, 1])
    return np.column_stack([offset, np.ones(len(offset))])


@dataclass(frozen=True, slots=True, eq=False)
class _Held:
    """What comes of holding."""

    controls: FloatArray  # (N, 2)
    ahead: FloatArray  # gap to each neighbour in each step, (n, N) [m]
    least: FloatArray  # least gap to each, (n,) [m]


def _holding(
    hull: Hull,
    problem: LocalProblem,
    room: FloatArray,
    base: float,
    seen: Sequence[Seen],
    resolves: Mapping[ShipId, Resolve],
) -> _Held:
    """Hold at an offset.

    Near a bank a ship returns to its line by steps, for its stern swings out.
    """
    for share in _RETURNS:
        plan = _steady(problem, base + share * (problem.last_offset - base))
        path = sailed(problem, plan[None])
        if bank_gaps(hull, path, room).min() >= -BANK_MARGIN / 2.0:
            break
    ahead = _each_gap(hull, path, seen)[0]
    least = ahead.min(axis=1, initial=math.inf)
    for n, each in enumerate(seen):
        if each.bearing.role is Role.BOTH and each.unmoved and resolve_of(each, resolves) == Resolve():
            alone = gaps(hull, path, each.hull, each.unmoved.poses)
            least[n] = min(least[n], float(alone.min()))  # both act, whatever the other has told
    return _Held(plan, ahead, least)


def _concerned(
    seen: Sequence[Seen], resolves: Mapping[ShipId, Resolve], held: _Held, enough: float
) -> list[int]:
    """Neighbours for which a ship has to act: holding, it comes too near, and it does not rely on them."""
    return [n for n, each in enumerate(seen) if not relies(each, resolves) and held.least[n] < enough]


def _hold(problem: LocalProblem, hold: FloatArray, count: int, memory: Memory) -> Stance:
    offset = hold[:, :1]
    factor = np.ones_like(offset)
    return Stance(
        settings=problem.settings,
        offset_limits=np.hstack([offset - _STEADY_OFFSET, offset + _STEADY_OFFSET]),
        speed_limits=np.hstack([factor - _STEADY_FACTOR, factor]),
        gains=(0.0,) * count,
        starts=(hold,),
        anchor=hold,
        until=0,
        memory=memory,
    )


def _alarmed(
    hull: Hull,
    problem: LocalProblem,
    room: FloatArray,
    base: float,
    seen: Sequence[Seen],
    resolves: Mapping[ShipId, Resolve],
    held: _Held,
    roles: Roles,
) -> dict[ShipId, Resolve]:
    """Resolves towards ships on which one can rely no more."""
    found = {}
    for each, ahead, least in zip(seen, held.ahead, held.least, strict=True):
        resolve = resolve_of(each, resolves)
        if each.id is None or not relies(each, resolves) or least >= roles.clear_by:
            continue
        if _is_last_moment(hull, problem, room, base, each, ahead, roles):
            found[each.id] = replace(resolve, alarmed=True)
    return found


def _is_last_moment(
    hull: Hull,
    problem: LocalProblem,
    room: FloatArray,
    base: float,
    each: Seen,
    ahead: FloatArray,
    roles: Roles,
) -> bool:
    """Whether no manoeuvre clears any more that begins after `reserve` more periods (BPR 6.03(5))."""
    late = at_hand(problem, base, _until(ahead[None], roles.clear_by), int(roles.reserve))
    return not np.any(_least_gap(hull, late.paths, [each], room) >= roles.clear_by)


def _until(ahead: FloatArray, enough: float) -> int:
    """Period after which all that come nearer than `enough` are past; the closest instant at least."""
    near = np.flatnonzero(ahead.min(axis=0) < enough)
    return int(near[-1] if len(near) else ahead.min(axis=0).argmin()) + 2


def _limits(
    problem: LocalProblem,
    active: Sequence[Seen],
    resolves: Mapping[ShipId, Resolve],
    until: int,
    roles: Roles,
) -> tuple[FloatArray, FloatArray]:
    """Limits within which an action of a ship that gives way is visible."""
    offset, speed = problem.offset_limits.copy(), problem.speed_limits.copy()
    sides = {resolve_of(each, resolves).side for each in active} - {0}
    if sides == {1}:
        offset[:until, 0] = np.minimum(roles.visible_offset, offset[:until, 1] - _STEADY_OFFSET)
    elif sides == {-1}:
        offset[:until, 1] = np.maximum(-roles.visible_offset, offset[:until, 0] + _STEADY_OFFSET)
    if any(must_slow(problem, each, active, resolves, roles) for each in active):
        speed[0, 1] = roles.visible_factor
    return offset, speed


def _is_packed_in(
    hand: Manoeuvres, worst: FloatArray, offset_limits: FloatArray, speed_limits: FloatArray, roles: Roles
) -> bool:
    """Whether an action that is visible leads too near to others, though one that is not would not."""
    clear = worst >= roles.clear_by
    return bool(clear.any()) and not np.any(clear & _within(hand, offset_limits, speed_limits))


def _share(memory: Memory, concerned: Sequence[Seen]) -> float:
    """Share of the crossing profile: at once when a ship begins to act, then by thirds (Sec. 5.4)."""
    wanted = 1.0 if any(each.crosses for each in concerned) else 0.0
    if not memory.acting:
        return wanted
    return memory.crossing + min(max(wanted - memory.crossing, -1.0 / 3.0), 1.0 / 3.0)


def _settings(
    settings: Settings,
    seen: Sequence[Seen],
    active: Sequence[Seen],
    resolves: Mapping[ShipId, Resolve],
    crossing: float,
    roles: Roles,
) -> Settings:
    weights = blended(settings.weights, roles.crossing, crossing)
    if any(relies(each, resolves) for each in seen):
        weights = replace(weights, mu_1=roles.steadiness * weights.mu_1, mu_2=roles.steadiness * weights.mu_2)
    if {resolve_of(each, resolves).side for each in active} - {0} == {-1}:
        weights = replace(weights, side=-1.0)
    return replace(settings, weights=weights)


def _gain(each: Seen, resolves: Mapping[ShipId, Resolve], roles: Roles) -> float:
    if relies(each, resolves):
        return roles.stand_on
    return roles.none if each.bearing.role is Role.NONE else roles.give_way


def _starts(
    hull: Hull,
    problem: LocalProblem,
    room: FloatArray,
    last: FloatArray | None,
    seen: Sequence[Seen],
    hand: Manoeuvres,
    worst: FloatArray,
    roles: Roles,
) -> tuple[FloatArray, ...]:
    """Keep the last plan while it clears and loses little; else take the gentlest manoeuvres that do."""
    low = np.stack([problem.offset_limits[:, 0], problem.speed_limits[:, 0]], axis=1)
    high = np.stack([problem.offset_limits[:, 1], problem.speed_limits[:, 1]], axis=1)
    allowed = _within(hand, problem.offset_limits, problem.speed_limits)
    found = [
        best
        for kind in (hand.side != 0.0, hand.side == 0.0)
        if (best := _gentlest(hand, worst, kind & allowed, roles.resume_beyond)) is not None
    ]
    costs = {best: _cost(hand.controls[best], worst[best], roles.clear_by) for best in found}
    found.sort(key=costs.__getitem__)
    least = min(costs.values(), default=math.inf)
    starts = [
        np.clip(hand.controls[best], low, high) for best in found if costs[best] <= least + _FAR_DEARER * DEAR
    ]
    if last is not None:
        kept = np.clip(last, low, high)
        gap = float(_least_gap(hull, sailed(problem, kept[None]), seen, room)[0])
        if gap < roles.clear_by:
            starts.append(kept)
        elif least + _MUCH * DEAR >= _cost(kept, gap, roles.clear_by):
            return (kept,)
    return tuple(starts) or (np.clip(_steady(problem, 0.0), low, high),)


def _within(hand: Manoeuvres, offset_limits: FloatArray, speed_limits: FloatArray) -> NDArray[np.bool_]:
    """Which manoeuvres keep limits (N, 2), (M,)."""
    limits = np.stack([offset_limits, speed_limits], axis=1)  # (N, control, side)
    inside = (hand.controls >= limits[..., 0] - 1e-9) & (hand.controls <= limits[..., 1] + 1e-9)
    return np.asarray(np.all(inside, axis=(1, 2)), dtype=np.bool_)


def _lost(controls: FloatArray) -> float:
    """Periods that a plan loses by its speed."""
    return float(np.sum(1.0 - controls[:, 1]))


def _gentlest(hand: Manoeuvres, worst: FloatArray, among: NDArray[np.bool_], enough: float) -> int | None:
    """The manoeuvre that costs least, with the water that is missing to `enough`; None if there is none.

    One that leads into a safety area or onto a bank is taken only if all do: that which does so least.
    """
    rows = np.flatnonzero(among)
    if not len(rows):
        return None
    clear = rows[worst[rows] >= 0.0]
    if not len(clear):
        return int(rows[np.argmax(worst[rows])])
    return int(clear[np.argmin(hand.size[clear] + _missing(worst[clear], enough))])


def _cost(controls: FloatArray, gap: float, enough: float) -> float:
    """What a plan costs: its greatest offset, the time that it loses, and the water that is missing [m]."""
    return float(np.abs(controls[:, 0]).max() + DEAR * _lost(controls) + _missing(gap, enough))


def _missing(gap: FloatArray | float, enough: float) -> FloatArray:
    """What it costs that a gap [m] is not enough; more than any manoeuvre if it is negative."""
    return np.where(np.asarray(gap) >= 0.0, _WATER * np.maximum(enough - np.asarray(gap), 0.0), 1e6)
