"""Which ships the optimisation has to see: those near, and of those that owe way only the ones that fail to.

A ship that stands on relies on the other.  The last moment has come when the time left until the domains
would meet is no more than what it takes to go aside; from then on it acts until the encounter is over.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ccas_core.controllers import Outlook, Target
from ccas_core.domains import gap
from ccas_core.frames import FloatArray
from ccas_core.roles import Role

from .encounters import NOTHING, Rule, abeam, near, rule_towards
from .options import number

MOST: Final = 6  # targets that are seen at once, the nearest first
RESERVE: Final = 1.5  # times the time that it takes to go aside, at which a ship that stands on acts
LOOKS: Final = (1, 2, 3, 4, 6, 8)  # within a step: as many as it takes for a look every half breadth


def watched(
    outlook: Outlook, velocity: FloatArray, alarmed: frozenset[str], horizon: int
) -> tuple[list[tuple[Target, Rule]], frozenset[str]]:
    """Targets that count, each with what the rules ask; and the ships that failed to give way."""
    found, alarms = [], set()
    for target in outlook.targets:
        rule = rule_towards(outlook, target, velocity)
        if target.bearing.role is Role.STAND_ON:
            if target.id not in alarmed and not is_last_moment(outlook, target, velocity, horizon):
                continue
            alarms.add(str(target.id))
        if rule is NOTHING and not _within_reach(outlook, target, horizon):
            continue
        found.append((target, rule))
    found.sort(key=lambda each: _distance(outlook, each[0]))
    return found[:MOST], frozenset(alarms)


def is_last_moment(outlook: Outlook, target: Target, velocity: FloatArray, horizon: int) -> bool:
    """Whether a ship that goes on must act now, for the other does not."""
    times = np.linspace(0.0, horizon * outlook.period, 4 * horizon + 1)
    course = target.pose.course
    drift = target.speed * np.array([math.cos(course), math.sin(course)]) - velocity
    apart = np.array([target.pose.x - outlook.pose.x, target.pose.y - outlook.pose.y])
    away = apart + times[:, None] * drift
    sight = np.hypot(away[:, 0], away[:, 1]) + 1e-9
    bearings = (*_seen(away, outlook.pose.course), *_seen(-away, course))
    speeds = outlook.motion.surge, target.speed
    meet = gap(outlook.domain, target.domain, sight=sight, bearings=bearings, speeds=speeds) < 0.0
    if not np.any(meet):
        return False
    left = float(times[int(np.argmax(meet))])
    aside = abeam(outlook.domain, outlook.motion.surge) + abeam(target.domain, target.speed)
    turn = number(outlook.options, "max_turn")
    limits = outlook.limits
    turning = turn / limits.max_yaw_rate + limits.max_yaw_rate / limits.yaw_acceleration
    taken = max(aside - float(sight.min()), 0.0) / (outlook.speed * math.sin(turn)) + turning
    return left <= RESERVE * taken + 2.0 * outlook.period


def looks(outlook: Outlook, targets: list[tuple[Target, Rule]]) -> int:
    """How often to look within a step, so that no domain is jumped over."""
    wanted = 1.0
    for target, _ in targets:
        breadth = abeam(outlook.domain, outlook.motion.surge) + abeam(target.domain, target.speed)
        wanted = max(wanted, (outlook.limits.max_speed + target.speed) * outlook.period / breadth)
    return next((each for each in LOOKS if each >= wanted), LOOKS[-1])


def _within_reach(outlook: Outlook, target: Target, horizon: int) -> bool:
    """Whether domains can meet within the horizon."""
    fastest = outlook.limits.max_speed + outlook.waters.current.speed + target.speed
    sailed = fastest * outlook.period * horizon
    edges = sum(
        float(domain.extent(1.0, 0.0, speed))
        for domain, speed in ((outlook.domain, outlook.limits.max_speed), (target.domain, target.speed))
    )
    return _distance(outlook, target) <= max(sailed + edges, 0.0) or _distance(outlook, target) <= near(
        outlook, target
    )


def _distance(outlook: Outlook, target: Target) -> float:
    return math.hypot(target.pose.x - outlook.pose.x, target.pose.y - outlook.pose.y)


def _seen(away: FloatArray, course: float) -> tuple[FloatArray, FloatArray]:
    cos, sin = math.cos(course), math.sin(course)
    return cos * away[:, 0] + sin * away[:, 1], cos * away[:, 1] - sin * away[:, 0]
