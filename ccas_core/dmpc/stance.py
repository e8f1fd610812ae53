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
from .manoeuvres import Manoeuvres, at_hand
from .parameters import Roles, Settings, blended
from .resolve import Memory, Resolve, Seen, must_slow, relapses_of, relies, resolve_of, resolved
from .trajectories import sailed

_STEADY_OFFSET: Final = 0.05  # of a ship that holds [m]: solvers want some room between bounds
_STEADY_FACTOR: Final = 1e-3
_MUCH: Final = 2.0  # periods that another plan must save to be taken instead of the last
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
    base = _base(problem, seen, resolves)
    hold, held = _holding(hull, problem, room, base)
    ahead = _each_gap(hull, held, seen)[0]  # (n, N)
    least = ahead.min(axis=1, initial=math.inf)
    for n, each in enumerate(seen):
        if each.bearing.role is Role.BOTH and each.unmoved and resolve_of(each, resolves) == Resolve():
            alone = gaps(hull, held, each.hull, each.unmoved.poses)
            least[n] = min(least[n], float(alone.min()))  # both act, whatever the other has told
    for n, each in enumerate(seen):
        if each.id is not None and each.bearing.role is Role.STAND_ON and least[n] < roles.clear_by:
            resolve = resolves.get(each.id, Resolve())
            if not resolve.alarmed and _is_last_moment(hull, problem, room, base, each, ahead[n], roles):
                resolves[each.id] = replace(resolve, alarmed=True)
    enough = roles.resume_beyond * 2.0**memory.relapses if memory.acting else roles.act_within
    concerned = [n for n, each in enumerate(seen) if not relies(each, resolves) and least[n] < enough]
    committed = [
        n
        for n, each in enumerate(seen)
        if each.bearing.role is Role.BOTH and resolve_of(each, resolves).side and n not in concerned
    ]
    if not concerned and not committed:
        idle = replace(memory, resolves=resolves, acting=False, rested=memory.rested + 1)
        return _hold(problem, hold, len(seen), idle)
    until = _until(ahead[[*concerned, *committed]], enough)
    hand = at_hand(problem, base, until)
    worst = _least_gap(hull, hand.paths, seen, room)
    for n in concerned:
        resolves = resolved(seen[n], resolves, hand, worst, roles)
    active = [seen[n] for n in (*concerned, *committed)]
    offset_limits, speed_limits = _limits(problem, active, resolves, until, roles)
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
        memory=Memory(
            resolves=resolves,
            crossing=crossing,
            acting=True,
            rested=0,
            relapses=relapses_of(memory),
        ),
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
    hand = at_hand(problem, 0.0, _until(ahead, enough))
    worst = _least_gap(hull, hand.paths, seen, room)
    allowed = _within(hand, stance.offset_limits, stance.speed_limits)
    best = _gentlest(hand, worst, allowed, enough)
    if best is None or worst[best] < enough:
        best = _gentlest(hand, worst, np.ones_like(allowed), enough)
    if best is None or worst[best] < min(gap + _BETTER, enough):
        return None
    return LocalPlan(controls=hand.controls[best], trajectory=PathTrajectory(hand.paths[best]))


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


def _holding(
    hull: Hull, problem: LocalProblem, room: FloatArray, base: float
) -> tuple[FloatArray, FloatArray]:
    """Controls of a ship that holds, and their path (1, N + 1, 3).

    Near a bank it returns to its line by steps, for its stern swings out.
    """
    for share in _RETURNS:
        plan = _steady(problem, base + share * (problem.last_offset - base))
        path = sailed(problem, plan[None])
        if bank_gaps(hull, path, room).min() >= -BANK_MARGIN / 2.0:
            break
    return plan, path


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
        memory=memory,
    )


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
    found.sort(key=lambda best: -min(float(worst[best]), roles.clear_by))
    starts = [np.clip(hand.controls[best], low, high) for best in found]
    if last is not None:
        kept = np.clip(last, low, high)
        if _least_gap(hull, sailed(problem, kept[None]), seen, room)[0] < roles.clear_by:
            starts.append(kept)
        elif not (found and worst[found[0]] >= roles.clear_by and _lost(starts[0]) + _MUCH < _lost(kept)):
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
    """Smallest manoeuvre that clears by `enough`, or the one that clears best."""
    rows = np.flatnonzero(among)
    if not len(rows):
        return None
    clear = rows[worst[rows] >= enough]
    return int(clear[np.argmin(hand.size[clear])]) if len(clear) else int(rows[np.argmax(worst[rows])])
