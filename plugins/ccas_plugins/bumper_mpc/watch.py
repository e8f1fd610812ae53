"""Which ships the optimisation has to see: those near, and of those that owe way only the ones that fail to.

A ship that stands on relies on the other.  The last moment has come when the time left until the domains
would meet is no more than what it takes to go aside; from then on it acts until the encounter is over.  Of
the other's domain counts what a ship at rest has: what it has ahead by its speed is for the other to mind.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ccas_core.controllers import Outlook, Target
from ccas_core.domains import gap
from ccas_core.frames import FloatArray
from ccas_core.roles import Geometry, Role
from ccas_core.ships import ShipId
from ccas_core.waterway import Obstacle

from .encounters import LEAD, Rule, breadth, distance_of, near, passing_surge, rule_round, rule_towards
from .options import is_on, number

MOST: Final = 6  # targets and obstacles that are seen at once, the nearest first
RESERVE: Final = 1.5  # times the time that it takes to go aside, at which a ship that stands on acts
LOOKS: Final = (1, 2, 3, 4, 6, 8)  # within a step: as many as it takes for a look every half breadth
SLOWED: Final = 0.9  # surge speed over the usual one while a ship goes aside
REACHED: Final = 0.15  # of a safe distance that may be lacking when a ship has gone aside


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """What the optimisation sees, and what is remembered of it."""

    targets: tuple[Target, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    rules: tuple[Rule, ...] = ()
    asked: Mapping[ShipId, Rule] = field(default_factory=dict)  # the same, by ship
    alarmed: frozenset[ShipId] = frozenset()  # ships that fail to give way

    @property
    def crosses(self) -> bool:
        """Whether the ship crosses another's way, and may stop for it."""
        return any(rule.geometry is Geometry.CROSSING for rule in self.rules)

    def goes_aside(self, outlook: Outlook) -> bool:
        """Whether the ship is not yet where the rules want it."""
        return any(rule.lacking(outlook.pose) > REACHED * rule.distance for rule in self.rules)

    def domain_speed(self, target: Target) -> float:
        """Speed that sizes a target's domain [m/s]: none where the other fails its duty."""
        return 0.0 if target.id in self.alarmed else target.speed

    def surge(self, outlook: Outlook, usual: float) -> float:
        """Reference of the surge speed [m/s]: less while the ship goes aside, or lets another pass."""
        wanted = SLOWED * usual if self.goes_aside(outlook) else usual
        return min([wanted, *(passing_surge(outlook, rule, usual) for rule in self.rules)])


def watched(outlook: Outlook, velocity: FloatArray, before: Seen, horizon: int) -> Seen:
    """Find what counts; `velocity` is the own one over ground, (2,) [m/s], `before` of the last period."""
    ruled = is_on(outlook.options, "rules")
    targets: list[Target] = []
    asked: dict[ShipId, Rule] = {}
    alarmed: set[ShipId] = set()
    for target in sorted(outlook.targets, key=lambda each: distance_of(outlook, each)):
        if target.bearing.role is Role.STAND_ON and ruled:
            if target.id not in before.alarmed and not is_last_moment(outlook, target, velocity, horizon):
                continue
            alarmed.add(target.id)
        fails, earlier = target.id in alarmed, before.asked.get(target.id)
        rule = rule_towards(outlook, target, velocity, earlier, fails=fails) if ruled else None
        if len(targets) < MOST and (rule is not None or _within_reach(outlook, target, horizon)):
            targets.append(target)
            asked |= {target.id: rule} if rule else {}
    obstacles = [each for each in outlook.waters.obstacles if _is_near(outlook, each, horizon)][:MOST]
    round_them = [rule_round(outlook, each) for each in obstacles] if ruled else []
    return Seen(
        targets=tuple(targets),
        obstacles=tuple(obstacles),
        rules=(*asked.values(), *(rule for rule in round_them if rule)),
        asked=asked,
        alarmed=frozenset(alarmed),
    )


def is_last_moment(outlook: Outlook, target: Target, velocity: FloatArray, horizon: int) -> bool:
    """Whether a ship that goes on must act now, for the other does not."""
    limits, turn = outlook.limits, number(outlook.options, "max_turn")
    turning = turn / limits.max_yaw_rate + limits.max_yaw_rate / limits.yaw_acceleration
    needed = breadth(outlook, target)
    longest = RESERVE * (needed / (outlook.speed * math.sin(turn)) + turning) + 2.0 * outlook.period
    times = np.linspace(0.0, max(longest, horizon * outlook.period), 201)
    course = target.pose.course
    drift = target.speed * np.array([math.cos(course), math.sin(course)]) - velocity
    apart = np.array([target.pose.x - outlook.pose.x, target.pose.y - outlook.pose.y])
    away = apart + times[:, None] * drift
    sight = np.hypot(away[:, 0], away[:, 1]) + 1e-9
    bearings = (*_seen(away, outlook.pose.course), *_seen(-away, course))
    speeds = outlook.motion.surge, 0.0
    meet = gap(outlook.domain, target.domain, sight=sight, bearings=bearings, speeds=speeds) < 0.0
    if not np.any(meet):
        return False
    left = float(times[int(np.argmax(meet))])
    taken = max(needed - float(sight.min()), 0.0) / (outlook.speed * math.sin(turn)) + turning
    return left <= RESERVE * taken + 2.0 * outlook.period


def looks(outlook: Outlook, targets: Sequence[Target]) -> int:
    """How often to look within a step, so that no domain is jumped over."""
    wanted = 1.0
    for target in targets:
        sailed = (outlook.limits.max_speed + target.speed) * outlook.period
        wanted = max(wanted, sailed / breadth(outlook, target))
    return next((each for each in LOOKS if each >= wanted), LOOKS[-1])


def _within_reach(outlook: Outlook, target: Target, horizon: int) -> bool:
    """Whether domains can meet within the horizon."""
    fastest = outlook.limits.max_speed + outlook.waters.current.speed + target.speed
    edges = sum(
        float(domain.extent(1.0, 0.0, speed))
        for domain, speed in ((outlook.domain, outlook.limits.max_speed), (target.domain, target.speed))
    )
    sailed = max(fastest * outlook.period * horizon + edges, near(outlook, target))
    return distance_of(outlook, target) <= sailed


def _is_near(outlook: Outlook, obstacle: Obstacle, horizon: int) -> bool:
    fastest = outlook.limits.max_speed + outlook.waters.current.speed
    edges = float(outlook.domain.extent(1.0, 0.0, outlook.limits.max_speed)) + obstacle.radius
    sailed = max(fastest * outlook.period * horizon, LEAD * outlook.hull.length) + edges
    return math.hypot(obstacle.x - outlook.pose.x, obstacle.y - outlook.pose.y) <= sailed


def _seen(away: FloatArray, course: float) -> tuple[FloatArray, FloatArray]:
    cos, sin = math.cos(course), math.sin(course)
    return cos * away[:, 0] + sin * away[:, 1], cos * away[:, 1] - sin * away[:, 0]
