"""How near encounters lie to a limit: a ruleset may be consistent, and ships that measure still disagree.

Random encounters at risk are judged once more by each ship, from what it would measure: errors of position,
course and speed are drawn anew for both ships.  Where that changes a verdict, the encounter lies closer to a
limit than the sensors can tell; where the two views no longer fit, the ships disagree until they have
exchanged what they decided.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ..tapd.case_run import pair_facts
from ..tapd.cases import Case, CaseShip
from ..tapd.written import WrittenRuleset
from ..units import DEGREE
from ..verdict import Verdict, agree
from .search import A, B
from .trials import trials

ENCOUNTERS: Final = 4000
_NORMAL: Final = 1.959964  # of the interval of 95 %


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorError:
    """Standard deviations of what a ship measures of either ship."""

    position: float = 0.0  # [m]
    course: float = 0.0  # [deg]
    speed: float = 0.0  # [m/s]

    def __post_init__(self) -> None:
        if not all(0.0 <= each < math.inf for each in (self.position, self.course, self.speed)):
            raise ValueError(f"an error must be a number of at least 0, got {self}")


@dataclass(frozen=True, slots=True)
class Share:
    """A share of encounters, and its interval of confidence of 95 % (Wilson)."""

    hits: int
    of: int

    @property
    def value(self) -> float:
        """The share."""
        return self.hits / self.of if self.of else 0.0

    @property
    def interval(self) -> tuple[float, float]:
        """Lower and upper end.

        >>> [round(end, 4) for end in Share(10, 100).interval]
        [0.0552, 0.1744]
        """
        if not self.of:
            return 0.0, 1.0
        share, square = self.value, _NORMAL * _NORMAL
        middle = share + square / (2.0 * self.of)
        spread = share * (1.0 - share) / self.of + square / (4.0 * self.of * self.of)
        reach = _NORMAL * math.sqrt(spread)
        low, high = ((middle + s * reach) / (1.0 + square / self.of) for s in (-1.0, 1.0))
        return max(0.0, low), min(1.0, high)

    def __str__(self) -> str:
        low, high = self.interval
        return f"{100.0 * self.value:.2f} % ({100.0 * low:.2f} to {100.0 * high:.2f} %)"


@dataclass(frozen=True, slots=True, kw_only=True)
class Nearness:
    """Shares of random encounters at risk under an error; the rules that are worst come first."""

    error: SensorError
    near: Share  # some view is another than without the error
    disagreeing: Share  # the two views do not fit together
    rules: tuple[tuple[str, int], ...]  # that decide without the error, and how often the ships disagree

    def lines(self) -> tuple[str, ...]:
        """The report."""
        error = self.error
        sensors = f"{error.position:g} m, {error.course:g} deg and {error.speed:g} m/s"
        found = [
            f"with sensor errors of {sensors}, of {self.near.of} random encounters at risk",
            f"    closer to a limit than that: {self.near}",
            f"    ships disagree until they exchange verdicts: {self.disagreeing}",
        ]
        if self.rules:
            named = ", ".join(f"{rule or 'no rule'} ({count})" for rule, count in self.rules[:5])
            found.append(f"    most often by rule: {named}")
        return tuple(found)


def nearness(ruleset: WrittenRuleset, error: SensorError, count: int = ENCOUNTERS, seed: int = 0) -> Nearness:
    """Estimate how often ships disagree that measure with an error.

    Parameters
    ----------
    ruleset
        From a file; verdicts are those of its rules as they run.
    error
        Of the sensors.
    count, seed
        Of the random encounters; those without a risk of collision are not counted.
    """
    rng = np.random.default_rng(seed)
    total = near = apart = 0
    rules: dict[str, int] = {}
    for trial in trials(ruleset, count, seed, plain=True):
        if trial.seen[0]["risk_of_collision"] is not True:
            continue
        total += 1
        # Times to a junction are those of the courses here, so that they are measured, too.
        truth = _views(ruleset, trial.case, trial.case)
        measured = _views(ruleset, _measured(trial.case, error, rng), _measured(trial.case, error, rng))
        near += any(_duty(one) != _duty(two) for one, two in zip(truth, measured, strict=True))
        if agree(*measured):
            apart += 1
            rules[truth[0].rule] = rules.get(truth[0].rule, 0) + 1
    worst = tuple(sorted(rules.items(), key=lambda each: (-each[1], each[0])))
    return Nearness(error=error, near=Share(near, total), disagreeing=Share(apart, total), rules=worst)


def _views(ruleset: WrittenRuleset, by_a: Case, by_b: Case) -> tuple[Verdict, Verdict]:
    """Views of both ships, each of what it has measured."""
    one = pair_facts(by_a, A, B, ruleset.vocabulary)
    two = pair_facts(by_b, B, A, ruleset.vocabulary)
    return ruleset.judge(one), ruleset.judge(two)


def _duty(verdict: Verdict) -> tuple[object, ...]:
    return verdict.kind, verdict.initiator, verdict.passing_side, verdict.side_chosen_by


def _measured(case: Case, error: SensorError, rng: np.random.Generator) -> Case:
    return replace(case, ships=tuple(_seen(ship, error, rng) for ship in case.ships))


def _seen(ship: CaseShip, error: SensorError, rng: np.random.Generator) -> CaseShip:
    assert ship.pose is not None  # noqa: S101
    assert ship.speed is not None  # noqa: S101
    north, east, course = ship.pose
    n, e, c, s = (float(each) for each in rng.standard_normal(4))
    pose = (
        north + error.position * n,
        east + error.position * e,
        course + error.course * DEGREE * c,
    )
    return replace(ship, pose=pose, speed=max(0.0, ship.speed + error.speed * s))


def parsed(text: str) -> SensorError:
    """An error as an option states it: metres, degrees, metres a second.

    >>> parsed("10,2,0.2")
    SensorError(position=10.0, course=2.0, speed=0.2)

    Raises
    ------
    ValueError
        If these are not three numbers.
    """
    numbers = [float(each) for each in text.split(",")]
    if len(numbers) != 3:
        raise ValueError("three numbers are needed: metres, degrees, metres a second")
    return SensorError(position=numbers[0], course=numbers[1], speed=numbers[2])


__all__ = ["ENCOUNTERS", "Nearness", "SensorError", "Share", "nearness", "parsed"]
