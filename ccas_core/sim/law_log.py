"""What the log of a voyage says of laws: whether ships named one, fell back, kept it, and went over in peace.

Decisions are lines of `decisions.jsonl`, from a run folder or from `run_folder.decision`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

from ..ships import ShipId
from .frame import Frame
from .hulls import under_way
from .run_folder import decision
from .scenario import Scenario

_SAME_TIME: Final = 1e-6  # [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class LawLog:
    """Counts over all decisions of a voyage, a decision being a pair in a period."""

    decisions: int
    two_laws: int  # both judged by two rulesets or versions, and did not fall back: a fault
    fallbacks: int  # both judged by two rulesets or versions, and fell back
    both_stand_on: int  # by one law, each of the two would have stood on: a fault, even where they fell back
    law_changes: int  # an encounter went on under another law than a period before: a fault without fallbacks
    switches: int  # of ships, from one ruleset to another
    flaps: int  # switches that no crossing of a border explains, or that followed too soon: a fault

    @property
    def faults(self) -> int:
        """How often something happened that should not."""
        kept = 0 if self.fallbacks else self.law_changes
        return self.two_laws + self.both_stand_on + self.flaps + kept


def law_log(scenario: Scenario, frames: Sequence[Frame]) -> LawLog:
    """Count what the frames of a voyage say of laws."""
    return counted(scenario, frames, list(decisions_of(frames)))


def decisions_of(frames: Iterable[Frame]) -> Iterator[Mapping[str, Any]]:
    """Decisions of a voyage, as its log has them."""
    for frame in frames:
        for settlement in frame.settlements:
            yield decision(settlement, frame)


def counted(scenario: Scenario, frames: Sequence[Frame], decisions: Sequence[Mapping[str, Any]]) -> LawLog:
    """Count what a log and the frames beside it say of laws."""
    unlike = [each for each in decisions if len(laws_named(each)) > 1]
    fallbacks = sum(each["applied"] == "fallback" for each in unlike)
    switches = [switch for id_ in _ships(frames) for switch in _switches(scenario, frames, id_)]
    return LawLog(
        decisions=len(decisions),
        two_laws=len(unlike) - fallbacks,
        fallbacks=fallbacks,
        both_stand_on=sum(_kinds(each) == {"stand_on"} for each in decisions if len(laws_named(each)) == 1),
        law_changes=_law_changes(decisions, scenario.time_step),
        switches=len(switches),
        flaps=sum(switches),
    )


def laws_named(told: Mapping[str, Any]) -> set[tuple[str, str]]:
    """Rulesets and versions by which the two ships of a decision judge."""
    return {(view["ruleset"], view["version"]) for view in told["verdicts"].values()}


def _kinds(told: Mapping[str, Any]) -> set[str]:
    return {str(view["kind"]) for view in told["verdicts"].values()}


def _law_changes(decisions: Iterable[Mapping[str, Any]], step: float) -> int:
    """How often a pair that met, and meets on, names other laws than in the period before."""
    last: dict[tuple[str, ...], tuple[float, set[tuple[str, str]]]] = {}
    changes = 0
    for told in decisions:
        pair, laws = tuple(told["pair"]), laws_named(told)
        if _kinds(told) == {"none"}:
            last.pop(pair, None)
            continue
        time, before = last.get(pair, (-1.0, laws))
        changes += laws != before and told["time_s"] - time <= step + _SAME_TIME
        last[pair] = told["time_s"], laws
    return changes


def _ships(frames: Iterable[Frame]) -> list[ShipId]:
    return sorted({id_ for frame in frames for id_ in under_way(frame)})


def _switches(scenario: Scenario, frames: Sequence[Frame], id_: ShipId) -> Iterator[bool]:
    """Switches of a ship, and of each whether it flaps: no border crossed since the last, or too soon."""
    sailed = [(frame.time, ships[id_]) for frame in frames if id_ in (ships := under_way(frame))]
    crossed, since = 0, float("-inf")
    for (_, before), (time, now) in pairwise(sailed):
        crossed += scenario.waters.ruleset_at(before.pose) != scenario.waters.ruleset_at(now.pose)
        if before.ruleset != now.ruleset:
            yield crossed == 0 or time - since < scenario.waters.hysteresis.time - _SAME_TIME
            crossed, since = 0, time
