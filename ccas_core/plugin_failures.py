"""What of a plugin does not work, told with package, cause and effect; and guards around its functions.

A guard lets a function of a plugin raise what it will: the failure is written down, and an answer is given
that nobody can take for a decision of the plugin.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Final

from .ships import UNKNOWN, FactValue, Ship
from .tapd.language.code import UnknownFact
from .tapd.python_rules import PairView, PythonRule, RoleDecision, ruled
from .tapd.ranking import RankingCriterion
from .tapd.vocabulary import Fact, Kind
from .verdict import Kind as Verdicts

MEND: Final = "mend it, or uninstall its package"


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """A plugin that was left out, or a part of it that does not work, and why."""

    plugin: str
    target: str  # module of the plugin, or the part
    cause: str
    hint: str = MEND
    effect: str = "what it offers is not available"
    package: str = ""  # name and version of the distribution
    whole: bool = True  # the plugin is left out altogether
    trace: str = field(default="", repr=False)

    def __str__(self) -> str:
        what = f"plugin {self.plugin!r} ({self.target}) is left out"
        if not self.whole:
            what = f"part of plugin {self.plugin!r} does not work: {self.target}"
        lines = {"package": self.package, "cause": self.cause, "effect": self.effect, "hint": self.hint}
        return "\n".join(
            [f"warning: {what}", *(f"    {label}: {text}" for label, text in lines.items() if text)]
        )


@dataclass(slots=True)
class Troubles:
    """Failures that show only while plugins are at work, each told once."""

    _known: dict[tuple[str, str], Failure] = field(default_factory=dict)
    _told: int = 0

    def add(self, failure: Failure) -> None:
        """Write a failure down, unless that part of the plugin has failed before."""
        self._known.setdefault((failure.plugin, failure.target), failure)

    def fresh(self) -> Iterator[Failure]:
        """Failures that were not told yet."""
        while self._told < len(self._known):
            self._told += 1
            yield list(self._known.values())[self._told - 1]


@dataclass(frozen=True, slots=True)
class Guard:
    """Guards the functions of one plugin."""

    plugin: str
    package: str
    troubles: Troubles

    def _failed(self, target: str, error: Exception, effect: str) -> str:
        cause = f"{type(error).__name__}: {error}"
        self.troubles.add(
            Failure(
                plugin=self.plugin,
                target=target,
                cause=cause,
                effect=effect,
                package=self.package,
                whole=False,
            )
        )
        return cause

    def rule(self, rule: PythonRule) -> PythonRule:
        """Let a rule that raises, or answers with no decision, be a conflict: both ships act."""
        decide = rule.decide

        @wraps(decide)
        def guarded(pair: PairView) -> RoleDecision | str | None:
            try:
                decision = decide(pair)
                ruled(replace(rule, decide=lambda _: decision), pair)
            except UnknownFact:
                raise
            except Exception as error:  # a plugin may raise anything
                effect = "its verdict is a conflict: both ships give way by the safe mutual rule"
                cause = self._failed(f"rule {rule.name!r}", error, effect)
                owner = f"plugin {self.plugin!r}" + (f", package {self.package}" if self.package else "")
                return RoleDecision(Verdicts.CONFLICT, f"rule {rule.name!r} failed ({owner}): {cause}")
            return decision

        return replace(rule, decide=guarded, plugin=self.plugin)

    def fact(self, fact: Fact) -> Fact:
        """Let a fact whose computation raises, or gives another type, be unknown."""
        compute = fact.compute
        if compute is None:
            return fact

        @wraps(compute)
        def guarded(*seen: object) -> FactValue:
            try:
                return checked(fact, compute(*seen))
            except Exception as error:  # a plugin may raise anything
                self._failed(f"fact {fact.name!r}", error, "the fact is unknown")
                return UNKNOWN

        return replace(fact, compute=guarded)

    def criterion(self, criterion: RankingCriterion) -> RankingCriterion:
        """Let a criterion that raises, or gives no number, tell no two ships apart."""
        value = criterion.value

        @wraps(value)
        def guarded(ship: Ship) -> float:
            try:
                found = value(ship)
                if isinstance(found, bool) or not isinstance(found, int | float) or not math.isfinite(found):
                    raise TypeError(f"expected a finite number, got {found!r}")
            except Exception as error:  # a plugin may raise anything
                self._failed(f"criterion {criterion.name!r}", error, "it tells this ship from no other")
                return 0.0
            return float(found)

        return replace(criterion, value=guarded)


def checked(fact: Fact, value: FactValue) -> FactValue:
    """Check what was computed for a fact against its kind.

    Raises
    ------
    TypeError
        If it is of another kind.
    """
    number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    fits = {
        Kind.FLAG: isinstance(value, bool),
        Kind.NUMBER: number,
        Kind.CHOICE: value in fact.choices,
        Kind.FLAGS: isinstance(value, str),
        Kind.TEXT: isinstance(value, str),
    }[fact.kind]
    if value is not UNKNOWN and not fits:
        kind = f"one of {', '.join(fact.choices)}" if fact.choices else f"a {fact.kind}"
        raise TypeError(f"{fact.name} is {kind}, got {value!r}")
    return value
