"""Driver of one control period: passes messages, wakes ships, solves what they ask for.

The driver knows no rule and takes no decision.  In each round all ships that have something to do take
a step, each on what had arrived when the round began; their problems are solved together, and their
messages arrive in the next round at the earliest.  Simulated time moves on only when nothing is left to
do now.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final, TypeAlias

from ..dmpc.local_problem import Solution
from ..dmpc.solvers import AbstractLocalSolver
from ..ships import ShipId
from .bus import Bus
from .events import Agent, Decision, Event, Request, Sensed, Solved

_Asked: TypeAlias = tuple[list[tuple[ShipId, Request]], Callable[[], list[Solution]]]
TOGETHER: Final = 128  # ships whose problems are handed to the solver at once, while the next ships step


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PeriodLog:
    """What all ships decided in a period, and in which order."""

    decisions: Mapping[ShipId, Decision]
    generations: tuple[tuple[ShipId, ...], ...]


def run_period(
    agents: Mapping[ShipId, Agent],
    bus: Bus,
    solver: AbstractLocalSolver,
    sensed: Mapping[ShipId, Sensed],
    now: float,
    neighbours: Mapping[ShipId, Iterable[ShipId]] | None = None,
) -> PeriodLog:
    """Let all ships decide once.

    It ends when every agent has decided; each does by its own deadline.  `neighbours` are those who
    hear one another, as `reach.neighbours` finds them; all, unless given.
    """
    with _uncollected():
        return _run(agents, bus, solver, sensed, now, neighbours)


def _run(
    agents: Mapping[ShipId, Agent],
    bus: Bus,
    solver: AbstractLocalSolver,
    sensed: Mapping[ShipId, Sensed],
    now: float,
    neighbours: Mapping[ShipId, Iterable[ShipId]] | None,
) -> PeriodLog:
    bus.join(agents, neighbours)
    late = bus.collect(now)  # the last promises of the period before
    inboxes: dict[ShipId, list[Event]] = {
        ship: [*late.get(ship, ()), reading] for ship, reading in sensed.items()
    }
    wake: dict[ShipId, float] = dict.fromkeys(sensed, now)
    decisions: dict[ShipId, Decision] = {}
    generations: list[tuple[ShipId, ...]] = []
    while len(decisions) < len(agents):
        for ship, messages in bus.collect(now).items():
            inboxes.setdefault(ship, []).extend(messages)
        due = {ship for ship, at in wake.items() if at <= now}
        awake = sorted(due | (inboxes.keys() & agents.keys()))
        if not awake:
            now = _next_time(bus, wake)
            continue
        decided, asked = _stepped(agents, awake, now, inboxes, wake, bus, solver)
        for requests, answers in asked:
            for (ship, request), solution in zip(requests, answers(), strict=True):
                inboxes[ship] = [Solved(request.problem, solution)]
        decisions |= decided
        if decided:
            generations.append(tuple(decided))
    return PeriodLog(decisions=decisions, generations=tuple(generations))


def _stepped(
    agents: Mapping[ShipId, Agent],
    awake: Sequence[ShipId],
    now: float,
    inboxes: dict[ShipId, list[Event]],
    wake: dict[ShipId, float],
    bus: Bus,
    solver: AbstractLocalSolver,
) -> tuple[dict[ShipId, Decision], list[_Asked]]:
    """Let ships step, take away what they have read, and send what they tell; solving begins meanwhile."""
    decided: dict[ShipId, Decision] = {}
    asked: list[_Asked] = []
    for some in (awake[n : n + TOGETHER] for n in range(0, len(awake), TOGETHER)):
        requests = []
        for ship in some:
            step = agents[ship].step(now, inboxes.pop(ship, []))
            wake.pop(ship, None)
            if step.wake_at is not None:
                wake[ship] = step.wake_at
            for message in step.outbox:
                bus.post(now, message)
            if step.request is not None:
                requests.append((ship, step.request))
            if step.decision is not None:
                decided[ship] = step.decision
        if requests:
            tasks = [(each.problem, each.guesses) for _, each in requests]
            asked.append((requests, solver.begin(tasks)))
    return decided, asked


@contextmanager
def _uncollected() -> Iterator[None]:
    """Keep the garbage collector from looking at all ships again and again; what is told has no cycles.

    Ten thousand ships take a sixth less time so.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def _next_time(bus: Bus, wake: Mapping[ShipId, float]) -> float:
    """Time of the next event [s]."""
    times = [*wake.values()]
    arrival = bus.next_arrival()
    if arrival is not None:
        times.append(arrival)
    if not times:
        raise RuntimeError("ships wait for one another, and nobody is to be woken: a fault of the agents")
    return min(times)
