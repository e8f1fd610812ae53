"""The controller: reads an outlook, states the optimisation, has it solved, and says what came of it."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ccas_core.controllers import AbstractController, Outlook, Steering
from ccas_core.frames import FloatArray

from . import local
from .options import OPTIONS, number
from .watch import Seen, looks, watched

if TYPE_CHECKING:
    from .problem import Programme

RELAXED_BY: Final = 0.02  # lengths by which constraints are relaxed from which on other starts are tried
TURN: Final = math.radians(30.0)  # of the starts to either side [rad]


@dataclass(frozen=True, slots=True, eq=False)
class Memory:
    """What the controller carries from one period to the next."""

    increments: FloatArray  # of the last plan, (N, 2)
    seen: Seen
    relaxed: bool = False  # it did not keep the domains apart


@dataclass(frozen=True, slots=True, eq=False)
class _Stated:
    """One problem, ready to be solved from any start."""

    outlook: Outlook
    reference: local.Reference
    programme: Programme
    state: FloatArray
    parameters: FloatArray
    low: FloatArray  # (N, 8)
    high: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    increments: FloatArray  # (N, 2)
    value: float
    relaxed: float  # greatest relaxation of a constraint [m]
    converged: bool


class BumperController(AbstractController):
    """The controller of the second paper: one ship that avoids all others by itself."""

    name = "bumper"
    options = OPTIONS

    def steer(self, outlook: Outlook, memory: Any) -> Steering:  # noqa: ANN401 - a `Memory`, or None
        """Solve the optimisation of one step, from the last plan, and from others where that does not do."""
        began = time.perf_counter()
        known = memory if isinstance(memory, Memory) else None
        stated, seen = _stated(outlook, known)
        found = _solved(stated, known)
        motions, poses = local.rolled_out(outlook, found.increments)
        return Steering(
            motion=motions[0],
            plan=local.trajectory(poses),
            memory=Memory(found.increments, seen, _is_relaxed(found, outlook)),
            outcome=_outcome(found, outlook),
            seconds=time.perf_counter() - began,
        )


def _stated(outlook: Outlook, memory: Memory | None) -> tuple[_Stated, Seen]:
    from .problem import KINDS, Shape, programme

    horizon = round(number(outlook.options, "horizon"))
    reference = local.reference(outlook, horizon)
    state = local.initial(outlook, reference)
    velocity = outlook.motion.surge * np.array([math.cos(outlook.pose.course), math.sin(outlook.pose.course)])
    velocity += np.array([outlook.waters.current.north, outlook.waters.current.east])
    seen = watched(outlook, velocity, memory.seen if memory else Seen(), horizon)
    shape = Shape(
        horizon=horizon,
        looks=looks(outlook, seen.targets),
        own=type(outlook.domain),
        targets=tuple(type(target.domain) for target in seen.targets),
        obstacles=len(seen.obstacles),
        ruled=len(seen.rules),
    )
    gives_way = seen.crosses or seen.goes_aside(outlook)
    fastest = reference.surge if gives_way else outlook.limits.max_speed
    low, high = local.bounds(outlook, reference, state, may_stop=seen.crosses, fastest=fastest)
    surge = seen.surge(outlook, reference.surge)
    sizes = {each: local.sizes_of(each.domain, KINDS[type(each.domain)]) for each in seen.targets}
    parameters = np.concatenate(
        [
            [*reference.current, outlook.period, outlook.hull.length, outlook.speed, surge],
            state,
            local.sizes_of(outlook.domain, KINDS[type(outlook.domain)]),
            reference.stages.ravel(),
            *(
                local.target_row(reference, target, sizes[target], seen.domain_speed(target))
                for target in seen.targets
            ),
            *(local.obstacle_row(reference, each) for each in seen.obstacles),
            *(local.rule_row(reference, rule) for rule in seen.rules),
        ]
    )
    return _Stated(outlook, reference, programme(shape), state, parameters, low, high), seen


def _solved(stated: _Stated, memory: Memory | None) -> _Found:
    """Solve from the last plan; where constraints stay relaxed, from others as well: the least value wins."""
    best: _Found | None = None
    for increments in _starts(stated, memory):
        found = _from(stated, increments)
        if found is not None and (best is None or found.value < best.value):
            best = found
        if best is not None and best.converged and not _is_relaxed(best, stated.outlook):
            return best
    if best is None:
        raise RuntimeError("no start of the optimisation gave finite numbers")
    return best


def _from(stated: _Stated, increments: FloatArray) -> _Found | None:
    horizon, width = len(increments), stated.low.shape[1]
    motions, poses = local.rolled_out(stated.outlook, increments)
    states = local.states_of(stated.reference, stated.state, motions, poses)
    changes = np.diff(states[:, 3:], axis=0)
    rows = np.hstack([changes, np.zeros((horizon, 1)), states[1:]])
    free = np.full(len(stated.state), np.inf)
    equal = stated.programme.equalities > 0.0
    solved = stated.programme.solve(
        x0=np.concatenate([stated.state, rows.ravel()]),
        p=stated.parameters,
        lbx=np.concatenate([-free, stated.low.ravel()]),
        ubx=np.concatenate([free, stated.high.ravel()]),
        lbg=0.0,
        ubg=np.where(equal, 0.0, np.inf),
    )
    table = np.asarray(solved["x"], dtype=np.float64).ravel()[len(stated.state) :].reshape(horizon, width)
    value = float(solved["f"])
    if not (np.all(np.isfinite(table)) and math.isfinite(value)):
        return None
    statistics = stated.programme.solve.stats()
    return _Found(table[:, :2], value, float(table[:, 2].max()), bool(statistics["success"]))


def _starts(stated: _Stated, memory: Memory | None) -> Iterator[FloatArray]:
    """Increments to start from: the last plan, going on, and turns to either side, and slowing down.

    Where no start did in the period before, the others are not tried again.
    """
    horizon = len(stated.low)
    nothing = np.zeros((horizon, 2))
    if memory is not None and len(memory.increments) == horizon:
        yield np.vstack([memory.increments[1:], nothing[:1]])
    yield nothing
    if memory is not None and memory.relaxed:
        return
    for turn in (TURN, -TURN):
        yield _turning(stated, turn)
    slowing = nothing.copy()
    slowing[:, 0] = stated.low[:, 0]
    yield slowing


def _turning(stated: _Stated, turn: float) -> FloatArray:
    """Turn to an angle from the path for half of the horizon, then back."""
    horizon, period, limits = len(stated.low), stated.outlook.period, stated.outlook.limits
    yaw, rate, found = float(stated.state[2]), float(stated.state[4]), np.zeros((horizon, 2))
    for k in range(horizon):
        wanted = turn if k < horizon // 2 else 0.0
        next_rate = (wanted - yaw) / (2.0 * period)
        most = limits.yaw_acceleration * period
        change = min(max(min(max(next_rate, -limits.max_yaw_rate), limits.max_yaw_rate) - rate, -most), most)
        rate += change
        yaw += period * rate
        found[k, 1] = change
    return found


def _is_relaxed(found: _Found, outlook: Outlook) -> bool:
    return found.relaxed > RELAXED_BY * outlook.hull.length


def _outcome(found: _Found, outlook: Outlook) -> str:
    """Say what is wrong with a plan; nothing where nothing is."""
    if _is_relaxed(found, outlook):
        return f"no plan keeps the domains apart; the best lacks {found.relaxed:.1f} m"
    return "" if found.converged else "the optimisation did not converge; the best plan found is sailed"
