"""Cases that were run, as they are told: expected beside got, in the words of encounter files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from .case_run import Judged, Result, told
from .cases import Case, Expected

_PAIR = ("kind", "give_way", "stand_on", "pass", "strength", "side_chosen_by", "must_follow", "facilitates",
         "required_manoeuvre", "initiator", "by", "reason")  # fmt: skip
_NAMES = {"pass": "passing_side", "required_manoeuvre": "manoeuvre", "by": "rule"}
_GROUP = ("diagnosis", "gives_way_to", "mutual", "no_rule", "cycle", "order")


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A case under one ruleset.

    One that is skipped counts neither as passed nor as failed; one that cannot be read counts as failed.
    """

    id: str
    ruleset: str
    expected: Mapping[str, Any] = field(default_factory=dict)
    got: Mapping[str, Any] = field(default_factory=dict)
    passed: bool = False
    required: bool = True
    skipped: bool = False
    differences: tuple[str, ...] = ()
    confidence: str = ""
    source: str = ""
    line: int = 0

    @property
    def failed(self) -> bool:
        """Whether it counts as a failure."""
        return self.required and not self.passed


def entry(result: Result) -> Entry:
    """Tell the result of a case."""
    case, expected = result.case, result.expected
    skipped = result.judged is None
    hard = case.hard or len(case.ships) > 2
    return Entry(
        id=case.id,
        ruleset=result.ruleset,
        expected=wanted(expected),
        got={} if result.judged is None else _got(result.judged, hard=hard),
        passed=result.passed and not skipped,
        required=expected.required and not skipped,
        skipped=skipped,
        differences=result.differences,
        confidence=expected.confidence.value if expected.confidence else "",
        source=case.source,
        line=case.line,
    )


def broken(case: Case | str, ruleset: str, source: str, why: str) -> Entry:
    """Tell of a case that could not be read, or not be judged."""
    id_, line = (case, 0) if isinstance(case, str) else (case.id, case.line)
    return Entry(id=id_, ruleset=ruleset, differences=(why,), source=source, line=line)


def as_json(entries: Iterable[Entry]) -> dict[str, Any]:
    """Tell all cases, and how many passed and failed; only those that are required can fail."""
    listed = list(entries)
    return {
        "cases": [
            {
                "id": each.id,
                "ruleset": each.ruleset,
                "expected": dict(each.expected),
                "got": dict(each.got),
                "passed": each.passed,
                "required": each.required,
                "skipped": each.skipped,
                "differences": list(each.differences),
                "confidence": each.confidence or None,
                "source": each.source,
                "line": each.line,
            }
            for each in listed
        ],
        "passed": sum(each.passed for each in listed),
        "failed": sum(each.failed for each in listed),
        "skipped": sum(each.skipped for each in listed),
    }


def wanted(expected: Expected) -> dict[str, Any]:
    """Tell what is expected, as far as it is stated."""
    found: dict[str, Any] = {}
    for name in (*_PAIR, *_GROUP, "article"):
        value = getattr(expected, _NAMES.get(name, name))
        if value is not None and value != "":
            found[name] = _plain(value)
    return found


def _got(judged: Judged, *, hard: bool) -> dict[str, Any]:
    pair = told(judged) if len(judged.settlements) == 1 else {}
    if not hard:
        return pair
    return {
        **pair,
        "diagnosis": judged.diagnosis,
        "gives_way_to": _plain(judged.gives_way_to),
        "mutual": _plain(judged.mutual),
        "no_rule": _plain(judged.no_rule),
        "cycle": [list(ring) for ring in judged.cycles],
        "order": list(judged.order),
    }


def _plain(value: Any) -> Any:
    """Lists for sets and tuples, in an order that is always the same.

    >>> _plain(frozenset({("B", "A"), ("A", "C")}))
    [['A', 'C'], ['B', 'A']]
    """
    if isinstance(value, frozenset):
        return sorted(_plain(each) for each in value)
    return [_plain(each) for each in value] if isinstance(value, tuple) else value
