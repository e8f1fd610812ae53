"""Cases from files, each with the rulesets of which it expects something, run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from ccas_core.errors import Diagnostic, InputError, RulesetError, did_you_mean

if TYPE_CHECKING:
    from ccas_core.plugins import Plugins
    from ccas_core.tapd.case_report import Entry
    from ccas_core.tapd.cases import Case
    from ccas_core.tapd.ruleset import AbstractRuleset, PairRuleset
    from ccas_core.tapd.written import WrittenRuleset


@dataclass(slots=True)
class Suite:
    """Cases that were run, and what could not be."""

    only: str = ""  # the one ruleset that is asked about
    entries: list[Entry] = field(default_factory=list)
    findings: list[Diagnostic] = field(default_factory=list)
    expected: set[str] = field(default_factory=set)  # rulesets that are named anywhere
    not_installed: dict[str, int] = field(default_factory=dict)  # id -> number of cases
    runs: dict[str, tuple[WrittenRuleset, list[Case]]] = field(default_factory=dict)


@dataclass(slots=True)
class _Read:
    """What the files hold."""

    cases: list[Case] = field(default_factory=list)
    unreadable: list[tuple[str, str]] = field(default_factory=list)  # id and file
    given: dict[str, AbstractRuleset] = field(default_factory=dict)  # rulesets that were named themselves


def gathered(files: Iterable[str], plugins: Plugins, ruleset: str | None) -> Suite:
    """Read files, and run what they expect of rulesets, or of one of them."""
    suite, read = Suite(), _Read()
    for file in dict.fromkeys(files):
        try:
            _read(file, plugins, read, suite)
        except InputError as error:
            suite.findings += error.diagnostics
    if ruleset is not None:
        asked = plugins.ruleset(ruleset)
        suite.only = asked.id
        if ruleset not in plugins.rulesets:
            read.given[asked.id] = asked
    _run(suite, read, plugins)
    return suite


def _read(file: str, plugins: Plugins, read: _Read, suite: Suite) -> None:
    from ccas_core.tapd.case_file import parse_cases
    from ccas_core.tapd.written import WrittenRuleset

    kind, text = kind_of(file, plugins)
    if kind == "cases":
        found = parse_cases(text, file, plugins.vocabulary)
        read.cases += found.cases
        read.unreadable += ((id_, file) for id_ in found.broken)
        suite.findings += found.findings
        return
    ruleset = plugins.ruleset(file)
    read.given[ruleset.id] = ruleset
    if isinstance(ruleset, WrittenRuleset):
        read.cases += ruleset.text.tests


def kind_of(file: str, plugins: Plugins) -> tuple[str, str]:
    """Whether a file holds a ruleset or cases, and its text; an id of a ruleset is one too.

    Raises
    ------
    InputError
        If it is neither.
    """
    from ccas_core.findings import read_text
    from ccas_core.strict_yaml import Reader
    from ccas_core.tapd.case_file import is_case_file
    from ccas_core.tapd.ruleset_draft import SCHEMA
    from ccas_core.yaml_nodes import Mapping, Scalar

    if file in plugins.rulesets:
        return "ruleset", ""
    if not Path(file).exists() and "/" not in file and not file.endswith((".yaml", ".yml")):
        hint = did_you_mean(file, plugins.rulesets)
        expected = "a file, or the id of a ruleset"
        raise RulesetError(Diagnostic(source=file, message="no such file", expected=expected, hint=hint))
    text = read_text(file, RulesetError)
    reader = Reader(text, file, RulesetError)
    if is_case_file(reader):
        return "cases", text
    root = reader.root
    schema = reader.block(root).find("schema") if isinstance(root, Mapping) else None
    if isinstance(schema, Scalar) and schema.text.partition("@")[0] == SCHEMA.partition("@")[0]:
        return "ruleset", text
    expected = f"a ruleset file ('schema: {SCHEMA}'), or an encounter file ('golden_cases: …')"
    return reader.stop(schema or root, "there are no cases in this file", expected=expected)


def _run(suite: Suite, read: _Read, plugins: Plugins) -> None:
    from ccas_core.tapd.case_report import broken, entry
    from ccas_core.tapd.case_run import run_case
    from ccas_core.tapd.written import WrittenRuleset

    suite.entries += (broken(id_, suite.only, file, "cannot be read") for id_, file in read.unreadable)
    loaded: dict[str, AbstractRuleset | InputError] = dict(read.given)
    for case in read.cases:
        for id_, expected in case.expected.items():
            suite.expected.add(id_)
            if suite.only and id_ != suite.only:
                continue
            if id_ not in loaded and id_ not in plugins.rulesets:
                suite.not_installed[id_] = suite.not_installed.get(id_, 0) + 1
                continue
            ruleset = _loaded(id_, loaded, plugins, suite)
            if ruleset is None:
                suite.entries.append(broken(case, id_, case.source, "its ruleset cannot be used"))
                continue
            try:
                result = run_case(ruleset, case, expected)
            except Exception as error:  # noqa: BLE001 - a rule of a plugin may raise anything
                why = f"the ruleset failed: {type(error).__name__}: {error}"
                suite.entries.append(broken(case, id_, case.source, why))
                continue
            suite.entries.append(entry(result))
            if isinstance(ruleset, WrittenRuleset) and case.ships:
                suite.runs.setdefault(id_, (ruleset, []))[1].append(case)
    for given in read.given.values():  # one without tests has coverage, too
        if isinstance(given, WrittenRuleset) and suite.only in ("", given.id):
            suite.runs.setdefault(given.id, (given, []))
    suite.findings += _missing(suite, plugins)


def _loaded(
    id_: str, loaded: dict[str, AbstractRuleset | InputError], plugins: Plugins, suite: Suite
) -> PairRuleset | None:
    """Ruleset that judges pairs; None where it cannot be used, which is told once."""
    from ccas_core.tapd.ruleset import PairRuleset

    if id_ not in loaded:
        try:
            loaded[id_] = plugins.ruleset(id_)
        except RulesetError as error:
            loaded[id_] = error
            suite.findings += error.diagnostics
    found = loaded[id_]
    if isinstance(found, PairRuleset):
        return found
    if not isinstance(found, InputError):
        message = "judges whole situations, not pairs, so that no case can be put to it"
        loaded[id_] = InputError(finding := Diagnostic(source=f"ruleset {id_}", message=message))
        suite.findings.append(finding)
    return None


def _missing(suite: Suite, plugins: Plugins) -> Iterator[Diagnostic]:
    for id_, count in suite.not_installed.items():
        cases = "1 case expects" if count == 1 else f"{count} cases expect"
        message = f"{cases} something of it, and it is not installed"
        hint = did_you_mean(id_, plugins.rulesets)
        yield Diagnostic(source=f"ruleset {id_}", message=message, hint=hint)
