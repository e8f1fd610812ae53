"""Tests of a ship as an agent, and a small fleet with rules by decree, on waters where nobody is near."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ccas_core.agent.bus import Bus
from ccas_core.agent.events import AgentSettings, Sensed, Timers
from ccas_core.agent.period import PeriodLog, run_period
from ccas_core.agent.ship_agent import ShipAgent
from ccas_core.dmpc.local_problem import LocalProblem, Solution
from ccas_core.dmpc.outcome import Outcome
from ccas_core.dmpc.parameters import PROFILES, Wait
from ccas_core.dmpc.solvers import AbstractLocalSolver
from ccas_core.dmpc.trajectories import rollout
from ccas_core.frames import FloatArray, PathPose
from ccas_core.roles import Geometry
from ccas_core.ships import Hull, Ship, ShipId
from ccas_core.tapd.facts import PairFacts
from ccas_core.tapd.ruleset import PairRuleset
from ccas_core.verdict import Citation, Kind, Verdict
from ccas_core.waterway import GuidingLine, Leg, Towards, Waters, Waterway, guiding_line

A, B, C, D = (ShipId(letter) for letter in "abcd")
FLEET = (A, B, C, D)
HULL = Hull(length=40.0, beam=6.0)
HORIZON = 6
Pair = tuple[ShipId, ShipId]
CHAIN: Collection[Pair] = ((A, B), (B, C))
RING: Collection[Pair] = ((A, B), (B, C), (C, A))


class Decreed(PairRuleset):
    """Says by name who gives way to whom, and who acts together; all else is nothing."""

    def __init__(
        self, duties: Collection[Pair] = (), mutual: Collection[Pair] = (), version: str = "1"
    ) -> None:
        self.id, self.version, self.title = "decreed", version, "by decree"
        self._duties, self._mutual = frozenset(duties), frozenset(mutual)

    def judge(self, facts: PairFacts) -> Verdict:
        """Judge by name."""
        own, other = facts.own, facts.other
        kind = Kind.NONE
        if (own, other) in self._duties:
            kind = Kind.GIVE_WAY
        elif (other, own) in self._duties:
            kind = Kind.STAND_ON
        elif {(own, other), (other, own)} & self._mutual:
            kind = Kind.MUTUAL
        return Verdict(
            own=own,
            other=other,
            kind=kind,
            ruleset=self.id,
            version=self.version,
            rule="decree",
            citation=Citation(regulation="decree", article="1"),
            geometry=Geometry.CROSSING,
        )


@dataclass(slots=True)
class Nominal(AbstractLocalSolver):
    """Answers every problem with its guess, and keeps the problems; a ship is known by its speed."""

    name: str = "nominal"
    asked: list[LocalProblem] = field(default_factory=list)

    def solve(self, problem: LocalProblem, guess: FloatArray) -> Solution:
        """Answer with the guess."""
        self.asked.append(problem)
        plan = rollout(problem, guess)
        return Solution(plan=plan, objective=0.0, outcome=Outcome.CONVERGED, iterations=1, seconds=0.001)

    def order(self) -> list[ShipId]:
        """Ships in the order in which they were solved for."""
        return [next(ship for ship in FLEET if speed(ship) == problem.speed) for problem in self.asked]


def speed(ship: ShipId) -> float:
    return 3.0 + 0.125 * FLEET.index(ship)


def mass(ship: ShipId) -> float:
    return 1e6 * (1 + FLEET.index(ship))


def waters() -> Waters:
    """Lay parallel canals, 2 km from each other: one a ship."""
    canals = tuple(
        Waterway(id=ship, centreline=np.array([[2000.0 * n, 0.0], [2000.0 * n, 6000.0]]), width=200.0)
        for n, ship in enumerate(FLEET)
    )
    return Waters(ruleset="decreed", waterways=canals)


def line(ship: ShipId) -> GuidingLine:
    return guiding_line(waters(), (Leg(ship, Towards.END),))


def agent(
    ship: ShipId,
    rules: PairRuleset,
    *,
    detection: bool = True,
    iterations: int = 1,
    wait: Wait = Wait.SEQUENTIAL,
    masses: Mapping[ShipId, float] | None = None,
) -> ShipAgent:
    profiles = {
        geometry: replace(profile, horizon=HORIZON, iterations=iterations, wait=wait)
        for geometry, profile in PROFILES.items()
    }
    return ShipAgent(
        Ship(id=ship, hull=HULL, mass=(masses or {}).get(ship, mass(ship))),
        line(ship),
        speed(ship),
        waters(),
        {rules.id: rules},
        AgentSettings(profiles=profiles, deadlock_detection=detection, timers=Timers()),
    )


def sensed(ship: ShipId, index: int = 0) -> Sensed:
    x = 100.0 + 20.0 * index * speed(ship)
    return Sensed(index, line(ship).frame.to_ned(PathPose(x, 0.0, 0.0)), speed(ship))


def period(
    agents: Mapping[ShipId, ShipAgent],
    solver: AbstractLocalSolver | None = None,
    bus: Bus | None = None,
    index: int = 0,
) -> PeriodLog:
    """Let a fleet decide once."""
    readings = {ship: sensed(ship, index) for ship in agents}
    return run_period(agents, bus or Bus(), solver or Nominal(), readings, 20.0 * index)
