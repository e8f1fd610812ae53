"""What `ccas check` says of borders in a scenario: what if two ships did not agree on one law."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from ccas_core.errors import Diagnostic

if TYPE_CHECKING:
    from ccas_core.proofs.findings import Finding
    from ccas_core.sim.scenario import Scenario
    from ccas_core.tapd.ruleset import AbstractRuleset

_BUDGET: Final = 20.0  # for one border [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class BorderNote:
    """A border of a scenario, and what was found of it; no fault of the scenario, whatever it is."""

    source: str
    rulesets: tuple[str, str]
    verdict: str  # proved, refuted, undecided
    waived: bool
    message: str
    hint: str

    def told(self) -> Diagnostic:
        """The note for people."""
        return Diagnostic(source=self.source, message=self.message, hint=self.hint)

    def as_data(self) -> dict[str, Any]:
        """The note for programs."""
        return {
            **dataclasses.asdict(self.told()),
            "severity": "note",
            "border": list(self.rulesets),
            "verdict": self.verdict,
            "waived": self.waived,
        }


def borders_of(
    scenario: Scenario, source: str, rulesets: Mapping[str, AbstractRuleset]
) -> Iterator[BorderNote]:
    """Look at every border on the water of a scenario."""
    waters = scenario.waters
    if not waters.regions:
        return
    for one, other in dict.fromkeys(waters.laws.borders(waters.water())):
        yield _note(source, rulesets[one.ruleset], rulesets[other.ruleset])


def _note(source: str, one: AbstractRuleset, other: AbstractRuleset) -> BorderNote:
    finding = _looked_at(one, other)
    names = f"border {one.id} | {other.id}"
    verdict, waived, hint = "undecided", False, ""
    if finding is None:
        message = f"{names}: undecided, for nothing can be proved of a ruleset in Python"
    else:
        verdict, waived = finding.outcome.value, finding.waived
        message = f"{names}: {verdict}, {_in_words(finding)}"
        if finding.faults:
            hint = f"`ccas check-consistency --border {one.id} {other.id}` shows such ships"
    return BorderNote(
        source=source, rulesets=(one.id, other.id), verdict=verdict, waived=waived, message=message, hint=hint
    )


def _in_words(finding: Finding) -> str:
    if finding.faults:
        what = finding.faults[0].title.partition(": ")[2]
        return f"ships that did not agree on one law might {what}"
    if finding.open:
        return "it is not known whether ships that did not agree on one law might both stand on"
    return "even ships that did not agree on one law would never both stand on"


@cache
def _looked_at(one: AbstractRuleset, other: AbstractRuleset) -> Finding | None:
    """What is known of a border, by one example either way round; None where nothing can be proved."""
    from ccas_core.proofs.check import check_border
    from ccas_core.tapd.written import WrittenRuleset

    if not isinstance(one, WrittenRuleset) or not isinstance(other, WrittenRuleset):
        return None
    today = datetime.now(tz=UTC).date()
    return check_border(one, other, today=today, budget_s=_BUDGET, most=1)
