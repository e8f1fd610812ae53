"""What shows a fault, as files: a scenario that can be sailed, an encounter file, a picture."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from ..ships import ShipId
from ..tapd.written import WrittenRuleset
from .findings import Fault, Finding
from .picture import draw_ships
from .sailing import encounter_file, sailed
from .search import Ships
from .telling import description


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """What was found of a ruleset, or of two across a border; `name` is what it was asked for by."""

    name: str
    rulesets: tuple[WrittenRuleset, ...]
    findings: Sequence[Finding]
    old: WrittenRuleset | None = None  # earlier version that it was compared with

    @property
    def id(self) -> str:
        """Ids of the rulesets."""
        return "|".join(each.id for each in self.rulesets)

    def judging(self, finding: Finding) -> tuple[WrittenRuleset, ...]:
        """Rulesets by which the ships of a finding judge."""
        return (*self.rulesets, self.old) if self.old and finding.property == "against" else self.rulesets


_OURS: Final = re.compile(r"(?P<property>\w+)-\d+(\.encounter)?\.(yaml|png)")


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """A fault and its files; there is no scenario where the ships would not meet so on a chart."""

    fault: Fault
    scenario: Path | None = None
    encounter: Path | None = None
    picture: Path | None = None


def clear(folder: Path, properties: Iterable[str]) -> None:
    """Remove what an earlier look at these properties has left in a folder."""
    names = set(properties)
    for file in folder.glob("*-*.*"):
        match = _OURS.fullmatch(file.name)
        if match is not None and match["property"] in names and file.is_file():
            file.unlink()


def shown(entry: Entry, folder: Path, *, pictures: bool = True) -> tuple[tuple[Evidence, ...], ...]:
    """Write files of all faults of an entry into a folder of its own, in place of earlier ones."""
    home = folder / entry.id.replace("|", "-")
    clear(home, (finding.property for finding in entry.findings))
    return tuple(
        write_evidence(each, entry.judging(each), home, pictures=pictures) for each in entry.findings
    )


def write_evidence(
    finding: Finding, rulesets: tuple[WrittenRuleset, ...], folder: Path, *, pictures: bool = True
) -> tuple[Evidence, ...]:
    """Write files of all faults of a finding into a folder, named after the property.

    `rulesets` is the one that was looked at, or those of own ship and of the others.
    """
    if any(fault.ships is not None for fault in finding.faults):
        folder.mkdir(parents=True, exist_ok=True)
    return tuple(
        _written(finding.property, fault, rulesets, folder / f"{finding.property}-{number}", pictures)
        for number, fault in enumerate(finding.faults, start=1)
    )


def _written(
    property_: str,
    fault: Fault,
    rulesets: tuple[WrittenRuleset, ...],
    stem: Path,
    pictures: bool,
) -> Evidence:
    ships = fault.ships
    if ships is None:
        return Evidence(fault=fault)
    judges = judges_of(ships, rulesets)
    vocabulary = rulesets[0].vocabulary
    name = f"{'_'.join(dict.fromkeys(each.id for each in rulesets))}-{stem.name}"
    about = description(property_, fault, vocabulary)
    scenario, encounter, picture = (
        stem.with_name(stem.name + end) for end in (".yaml", ".encounter.yaml", ".png")
    )
    encounter.write_text(encounter_file(ships, judges, name, fault.title, vocabulary), encoding="utf-8")
    text = sailed(ships, judges, name, fault.title, about)
    if text is not None:
        scenario.write_text(text, encoding="utf-8")
    placed = all(ship.pose is not None and ship.speed is not None for ship in ships.case.ships)
    if pictures and placed:
        draw_ships(ships, picture, f"{rulesets[0].id}, {property_}: {fault.title}")
    return Evidence(
        fault=fault,
        scenario=None if text is None else scenario,
        encounter=encounter,
        picture=picture if pictures and placed else None,
    )


def judges_of(ships: Ships, rulesets: tuple[WrittenRuleset, ...]) -> Mapping[ShipId, WrittenRuleset]:
    """The ruleset by which each ship judges: that of its verdict; of two versions, own ship by the first."""
    by_id = {ruleset.id: ruleset for ruleset in rulesets}
    own = ships.case.ships[0].id
    if len(by_id) == len(rulesets):
        return {view.own: by_id[view.ruleset] for view in ships.verdicts}
    return {view.own: rulesets[0] if view.own == own else rulesets[-1] for view in ships.verdicts}
