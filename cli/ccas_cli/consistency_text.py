"""What proofs came to: on a terminal, and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from . import talk

if TYPE_CHECKING:
    from ccas_core.proofs.evidence import Entry, Evidence
    from ccas_core.proofs.findings import Fault, Finding
    from ccas_core.tapd.rules import Waiver


def show(entry: Entry, evidence: Sequence[Sequence[Evidence]]) -> None:
    """Show a ruleset: its properties, then its faults."""
    from ccas_core.proofs.telling import heading

    for ruleset in entry.rulesets:
        talk.show(heading(ruleset.text))
    talk.show("")
    width = max((len(finding.property) for finding in entry.findings), default=0)
    for finding in entry.findings:
        verdict = finding.outcome.value.upper()
        talk.show(f"  {finding.property:<{width}}  {verdict:<9}  {_told(finding)}")
        for note in (*finding.open, *finding.notes):
            talk.show(f"  {'':<{width}}  {'':<9}    {note}")
    for finding, shown in zip(entry.findings, evidence, strict=True):
        for number, each in enumerate(shown, start=1):
            talk.show("")
            for line in _fault_lines(entry, finding, each, number):
                talk.show(line)


def _told(finding: Finding) -> str:
    """Method and time; of what is refuted, how many faults, and whether they are waived."""
    told = f"{finding.method}, {finding.seconds:.2f} s"
    if not finding.faults:
        return told
    covered = sum(fault.waived for fault in finding.faults)
    waived = "" if not covered else ", waived" if covered == len(finding.faults) else f", {covered} waived"
    return f"{talk.one_or_more(len(finding.faults), 'fault')}{waived}; {told}"


def _fault_lines(entry: Entry, finding: Finding, evidence: Evidence, number: int) -> Iterator[str]:
    from ccas_core.proofs.telling import marked, ship_lines, sights, view_lines, water_line

    fault = evidence.fault
    waived = ", waived" if fault.waived else ""
    yield f"{finding.property} {number}{waived}: {fault.title}"
    for rule in fault.rules:
        place, *excerpt = str(marked(rule)).splitlines()
        yield f"  --> {place}"
        yield from (f"  {line}" for line in excerpt)
    ships = fault.ships
    if ships is not None:
        vocabulary = entry.rulesets[0].vocabulary
        lines = [
            *ship_lines(ships, vocabulary),
            water_line(ships.case, vocabulary),
            *sights(ships, vocabulary),
        ]
        yield from (f"  = {line}" for line in lines if line)
        told: list[list[str]] = []
        for view in ships.verdicts:
            first, *more = view_lines(view)
            yield f"  = {first}"
            alike = sorted(" ".join(more).split(", ")) in told
            yield from (f"      {line}" for line in (["for the same reasons"] if alike and more else more))
            told.append(sorted(" ".join(more).split(", ")))
        if ships.margin > 0.0:
            yield f"  = margin {ships.margin:g} m: so far the other ship can be moved, and it still shows"
    yield from _waiver_lines(fault)
    yield from _file_lines(entry, evidence)


def _waiver_lines(fault: Fault) -> Iterator[str]:
    from ccas_core.proofs.telling import near

    if fault.waiver is not None:
        state = "waiver expired on" if fault.expired else "waived until"
        place = f"{near(fault.waiver.source.file)}:{fault.waiver.source.line}"
        yield f"  = {state} {fault.waiver.expires} ({place}): {fault.waiver.reason}"


def _file_lines(entry: Entry, evidence: Evidence) -> Iterator[str]:
    if evidence.scenario is not None:
        yield f"  scenario: {evidence.scenario}      sail it: {sail_command(entry, evidence)}"
    elif evidence.encounter is not None:
        yield "  no scenario: on a chart the ships would not meet just so"
    if evidence.encounter is not None:
        yield f"  encounter: {evidence.encounter}"
    if evidence.picture is not None:
        yield f"  picture: {evidence.picture}"


def sail_command(entry: Entry, evidence: Evidence) -> str:
    """How to sail a scenario; a ruleset that is no part of the library must be named."""
    command = f"ccas simulate {evidence.scenario}"
    named = entry.name.endswith((".yaml", ".yml")) or "/" in entry.name
    return f"{command} --ruleset {entry.name}" if named else command


def as_data(entry: Entry, evidence: Sequence[Sequence[Evidence]]) -> dict[str, Any]:
    """Put a ruleset as JSON has it."""
    from ccas_core.proofs.telling import domain

    text = entry.rulesets[0].text
    return {
        "ruleset": entry.id,
        "version": text.version,
        "domain": domain(text.domain),
        "properties": [
            _property(finding, shown) for finding, shown in zip(entry.findings, evidence, strict=True)
        ],
    }


def _property(finding: Finding, evidence: Sequence[Evidence]) -> dict[str, Any]:
    return {
        "name": finding.property,
        "verdict": finding.outcome.value,
        "waived": finding.waived,
        "method": finding.method,
        "seconds": round(finding.seconds, 3),
        "counterexamples": [str(each.scenario) for each in evidence if each.scenario is not None],
        "faults": [_fault(each) for each in evidence],
        "open": list(finding.open),
        "notes": list(finding.notes),
    }


def _fault(evidence: Evidence) -> dict[str, Any]:
    fault = evidence.fault
    ships = fault.ships
    files = {"scenario": evidence.scenario, "encounter": evidence.encounter, "picture": evidence.picture}
    return {
        "title": fault.title,
        "kind": fault.kind,
        "rules": [rule.id for rule in fault.rules],
        "articles": list(fault.articles),
        "places": [
            {"file": rule.source.file, "line": rule.source.line, "column": rule.source.column}
            for rule in fault.rules
        ],
        "margin_m": None if ships is None else ships.margin,
        "views": []
        if ships is None
        else [
            {"own": v.own, "other": v.other, "kind": v.kind.value, "rule": v.rule, "article": v.article}
            for v in ships.verdicts
        ],
        "waiver": None if fault.waiver is None else _waiver(fault.waiver, expired=fault.expired),
        **{key: None if path is None else str(path) for key, path in files.items()},
    }


def _waiver(waiver: Waiver, *, expired: bool) -> dict[str, Any]:
    return {"reason": waiver.reason, "expires": waiver.expires.isoformat(), "expired": expired}
