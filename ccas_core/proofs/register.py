"""The register: one page of all faults found in some rulesets, with ships, pictures, and what is done.

The page says by a digest which rulesets it was made from, and by another what it lists, so that a test can
tell that it is stale without proving everything again.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Final, TypeAlias

from ..errors import CcasError
from .evidence import Entry, Evidence
from .findings import Fault, Finding
from .telling import MEANINGS, domain, duty_of, ship_lines, sights, water_line

PAGE: Final = "README.md"  # what is shown when the folder is opened
Told: TypeAlias = tuple[Entry, Sequence[Sequence[Evidence]]]

_TESTS: Final = re.compile(r"^tests:.*?(?=^\w|\Z)", re.MULTILINE | re.DOTALL)
_MADE_FROM: Final = re.compile(r"^<!-- made from (?P<id>\S+) (?P<digest>[0-9a-f]{16}) -->$", re.MULTILINE)
_LISTED: Final = re.compile(r"^<!-- lists (?P<digest>[0-9a-f]{16}) -->$", re.MULTILINE)
_TITLE: Final = re.compile(r"^#### (?P<title>.+)$", re.MULTILINE)
_LEVEL: Final = "####"  # of the heading of a fault


def write_register(told: Sequence[Told], folder: Path) -> Path:
    """Write the page into the folder in which the evidence lies already."""
    folder.mkdir(parents=True, exist_ok=True)
    page = folder / PAGE
    page.write_text("\n".join(_page(told, folder)) + "\n", encoding="utf-8")
    return page


def _page(told: Sequence[Told], folder: Path) -> Iterator[str]:
    yield "# Faults found in the regulations"
    yield ""
    yield (
        "What `ccas check-consistency` finds in the rulesets as they are encoded: contradictions, gaps,\n"
        "rings of ships, roles that change, and borders.  Each fault is shown by ships that the rules as\n"
        "they run have judged.  A *waiver* says that the fault is in the law itself.\n"
        "[How to read this](../check-consistency.md)."
    )
    yield ""
    borders = [f" --border {' '.join(entry.id.split('|'))}" for entry, _ in told if len(entry.rulesets) > 1]
    yield f"This page is made by `ccas check-consistency --register docs/findings{''.join(borders)}`."
    yield ""
    yield from _table([entry for entry, _ in told])
    titles = []
    for entry, evidence in told:
        yield ""
        yield f"## {entry.id}"
        yield ""
        yield from _summary(entry)
        for finding, shown in zip(entry.findings, evidence, strict=True):
            if not shown:
                continue
            yield ""
            yield f"### {entry.id}: {finding.property}"
            for each in shown:
                title = f"{each.fault.title}"
                titles.append(title)
                yield ""
                yield f"{_LEVEL} {title}"
                yield ""
                yield from _fault(entry, each, folder)
    yield ""
    for entry, _ in told:
        for ruleset in entry.rulesets:
            yield f"<!-- made from {ruleset.id} {digest_of(sources_of(entry.name, ruleset.text.source))} -->"
    yield f"<!-- lists {_digest(titles)} -->"


def _table(entries: Sequence[Entry]) -> Iterator[str]:
    names = list(dict.fromkeys(finding.property for entry in entries for finding in entry.findings))
    yield f"| ruleset | {' | '.join(names)} |"
    yield f"| --- |{' --- |' * len(names)}"
    for entry in entries:
        by_name = {finding.property: finding for finding in entry.findings}
        cells = [_cell(by_name.get(name)) for name in names]
        name, anchor = entry.id.replace("|", "\\|"), entry.id.replace("|", "")
        yield f"| [{name}](#{anchor}) | {' | '.join(cells)} |"


def _cell(finding: Finding | None) -> str:
    if finding is None:
        return ""
    if not finding.faults:
        return finding.outcome.value
    return f"{finding.outcome}, {'waived' if finding.waived else 'not waived'}"


def _summary(entry: Entry) -> Iterator[str]:
    for ruleset in entry.rulesets:
        yield f"{ruleset.title}, version {ruleset.version}; for ships of {domain(ruleset.text.domain)}."
    for finding in entry.findings:
        meaning = MEANINGS.get(finding.property, "")
        left = f"; open: {'; '.join(finding.open)}" if finding.open else ""
        yield f"- **{finding.property}** ({meaning}): {finding.outcome} ({finding.method}){left}"


def _fault(entry: Entry, evidence: Evidence, folder: Path) -> Iterator[str]:
    fault = evidence.fault
    kind = fault.kind or "fault"
    yield f"- **{kind}**; {', '.join(fault.articles) or 'no article'}"
    if fault.rules:
        yield f"- rules: {', '.join(f'`{rule.id}`' for rule in fault.rules)}"
    ships = fault.ships
    if ships is not None:
        vocabulary = entry.rulesets[0].vocabulary
        for line in ship_lines(ships, vocabulary):
            yield f"- {' '.join(line.split())}"
        if waters := water_line(ships.case, vocabulary):
            yield f"- waters: {waters}"
        for line in sights(ships, vocabulary):
            yield f"- {line}"
        for view in ships.verdicts:
            yield f"- {duty_of(view)}"
    yield f"- {_done_about(fault)}"
    links = {"scenario": evidence.scenario, "encounter file": evidence.encounter}
    written = [f"[{name}]({_inside(path, folder)})" for name, path in links.items() if path]
    yield f"- {', '.join(written) or 'no ships'}"
    if evidence.picture is not None:
        yield ""
        yield f"![{fault.title.replace('[', '(').replace(']', ')')}]({_inside(evidence.picture, folder)})"


def _inside(path: Path, folder: Path) -> str:
    return path.relative_to(folder).as_posix()


def _done_about(fault: Fault) -> str:
    if fault.waiver is None:
        return "neither waived nor repaired"
    state = "waiver expired on" if fault.expired else "waived until"
    return f"{state} {fault.waiver.expires}: {' '.join(fault.waiver.reason.split())}"


# -- is it stale? --------------------------------------------------------------------------------


def sources_of(name: str, source: str) -> tuple[str, ...]:
    """Texts of a ruleset file and of those that it extends, as far as they lie beside it."""
    path = Path(source)
    texts: list[str] = []
    seen: set[Path] = set()
    while path.is_file() and path not in seen:
        seen.add(path)
        text = path.read_text(encoding="utf-8")
        texts.append(text)
        base = re.search(r"^extends:[ \t]*[\"']?([^\s\"'#]+)", text, re.MULTILINE)
        if base is None:
            break
        path = path.with_name(f"{base[1]}.yaml")
    return tuple(texts) or (name,)


def digest_of(texts: Iterable[str]) -> str:
    r"""Digest of what ruleset files say, without their tests, in which nothing is decided.

    >>> digest_of(["id: a\ntests:\n  - name: x\n"]) == digest_of(["id: a\n"])
    True
    """
    return _digest(_TESTS.sub("", text) for text in texts)


def _digest(texts: Iterable[str]) -> str:
    return sha256("\n".join(text.rstrip() for text in texts).encode()).hexdigest()[:16]


def stale(page: str, sources: Callable[[str], Sequence[str]], shipped: Iterable[str]) -> Mapping[str, str]:
    """Say why a page is stale: by ruleset, or by `page` for what it lists; empty where it is not.

    `sources` gives the texts of a ruleset's files by its id; `shipped` are the ids that the page must have.
    """
    why: dict[str, str] = {}
    made_from = {match["id"]: match["digest"] for match in _MADE_FROM.finditer(page)}
    for id_, digest in made_from.items():
        try:
            now = digest_of(sources(id_))
        except (CcasError, KeyError):
            why[id_] = "there is no such ruleset any more"
            continue
        if now != digest:
            why[id_] = "the ruleset has changed"
    why |= {id_: "it is missing" for id_ in shipped if id_ not in made_from}
    listed = _LISTED.search(page)
    titles = [match["title"] for match in _TITLE.finditer(page)]
    if listed is None or listed["digest"] != _digest(titles):
        why["page"] = "its faults are not those that were found"
    return why
