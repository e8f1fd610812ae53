"""`ccas check`: all that is wrong with files, at once, and what their authors may have overlooked."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from ccas_core.errors import Diagnostic, InputError, did_you_mean

from . import inputs, talk
from .border_notes import BorderNote, borders_of
from .exits import Code

if TYPE_CHECKING:
    from ccas_core.findings import Place
    from ccas_core.plugins import Plugins
    from ccas_core.strict_yaml import Reader

# Takes text and source; gives remarks and notes, and raises InputError with all findings.
Check: TypeAlias = "Callable[[str, str], Iterable[Diagnostic | BorderNote]]"
_CASES = "encounters"  # these files have no schema


def check(
    context: typer.Context,
    paths: Annotated[
        list[Path],
        typer.Argument(
            metavar="PATH",
            help="Files, folders that are searched for *.yaml, or shipped scenarios by name.",
            show_default=False,
        ),
    ],
    as_json: talk.AsJson = False,
) -> None:
    """Say all that is wrong with files of scenarios, rulesets, encounters and sweeps, without sailing them.

    Every finding has its file, line and column, what was found and what was expected; one with a code has a
    page: `ccas code CODE`. What kind of file it is is told by its first key, `schema`; encounter files have
    none. Of each border in a scenario it is told whether a ship under one ruleset and a ship under the other
    could both stand on, if they did not agree on one law. Exit code 2 if a file cannot be used, 1 if there
    are only remarks, on rules without a test and the like.

    Example:
        ccas check scenarios/ my_own.yaml borders/convoy_of_five
    """
    checks = _checks(inputs.load_plugins(context))
    findings: list[Diagnostic] = []
    remarks: list[Diagnostic] = []
    notes: list[BorderNote] = []
    count = 0
    for path in paths:
        try:
            files = _files(path)
        except InputError as error:
            findings += error.diagnostics
            continue
        count += len(files)
        for file in files:
            told = list(_told(file, checks, remarks, notes))
            findings += told
    _show(findings, remarks, notes, count, as_json=as_json)
    if findings:
        raise typer.Exit(Code.WRONG_USE)
    if remarks:
        raise typer.Exit(Code.FINDINGS)


def _files(path: Path) -> list[Path]:
    """Files that a path stands for: itself, all of a folder, or the scenario that is shipped by this name."""
    if not path.is_dir():
        return [path if path.exists() else inputs.scenario_file(str(path))]
    files = sorted(path.rglob("*.yaml"))
    if not files:
        hint = "a scenario, a ruleset or a file of encounters ends in .yaml"
        raise InputError(Diagnostic(source=str(path), message="no *.yaml file in this folder", hint=hint))
    return files


def _show(
    findings: list[Diagnostic],
    remarks: list[Diagnostic],
    notes: list[BorderNote],
    count: int,
    *,
    as_json: bool,
) -> None:
    if as_json:
        errors = [{**dataclasses.asdict(each), "severity": "error"} for each in findings]
        doubts = [{**dataclasses.asdict(each), "severity": "remark"} for each in remarks]
        talk.show_json([*errors, *doubts, *(each.as_data() for each in notes)])
        return
    for finding in (*findings, *remarks, *(each.told() for each in notes)):
        talk.show(str(finding))
    counts = [
        talk.one_or_more(len(found), word)
        for found, word in ((findings, "finding"), (remarks, "remark"))
        if found
    ]
    talk.note(f"{talk.one_or_more(count, 'file')} read: {' and '.join(counts) or 'nothing is wrong'}")


def _checks(plugins: Plugins) -> dict[str, Check]:
    """How to check a file, by its schema."""
    from ccas_core.sim import scenario_file
    from ccas_core.sweep import spec
    from ccas_core.tapd import tests_file
    from ccas_core.tapd.ruleset_draft import SCHEMA

    scenario = partial(
        scenario_file.parse_scenario,
        rulesets=plugins.rulesets,
        regions=plugins.regions,
        vocabulary=plugins.vocabulary,
        controllers=plugins.controllers,
    )

    def check_scenario(text: str, source: str) -> Iterable[BorderNote]:
        return borders_of(scenario(text, source), source, plugins.rulesets)

    return {
        scenario_file.SCHEMA: check_scenario,
        spec.SCHEMA: partial(_check_sweep, plugins),
        SCHEMA: partial(_check_ruleset, plugins),
        tests_file.SCHEMA: partial(_check_tests, plugins),
        _CASES: partial(_check_cases, plugins),
    }


def _check_sweep(plugins: Plugins, text: str, source: str) -> Iterable[Diagnostic]:
    from ccas_core.sweep.spec import parse_sweep

    parse_sweep(text, source, plugins.rulesets)
    return ()


def _check_ruleset(plugins: Plugins, text: str, source: str) -> Iterable[Diagnostic]:
    from ccas_core.tapd.lint import reviewed
    from ccas_core.tapd.written import WrittenRuleset

    found = plugins.rulesets.parsed(text, source)
    today = datetime.now(tz=UTC).date()
    return reviewed(found, text, today) if isinstance(found, WrittenRuleset) else ()


def _check_tests(plugins: Plugins, text: str, source: str) -> Iterable[Diagnostic]:
    from ccas_core.tapd.tests_file import parse_tests

    parse_tests(text, source, plugins.vocabulary)
    return ()


def _check_cases(plugins: Plugins, text: str, source: str) -> Iterable[Diagnostic]:
    from ccas_core.strict_yaml import Reader
    from ccas_core.tapd.case_file import parse_cases
    from ccas_core.tapd.lint import case_remarks

    found = parse_cases(text, source, plugins.vocabulary)
    if found.findings:
        raise InputError(*found.findings)
    return case_remarks(Reader(text, source), plugins.rulesets)


def _told(
    file: Path, checks: Mapping[str, Check], remarks: list[Diagnostic], notes: list[BorderNote]
) -> Iterator[Diagnostic]:
    """Findings in a file; what it may be used with all the same goes to the remarks and notes."""
    from ccas_core.findings import read_text
    from ccas_core.tapd.code_pages import coded

    try:
        text = read_text(file)
        for each in _check_for(text, str(file), checks)(text, str(file)):
            if isinstance(each, BorderNote):
                notes.append(each)
            else:
                remarks.append(each)
    except InputError as error:
        yield from map(coded, error.diagnostics)


def _check_for(text: str, source: str, checks: Mapping[str, Check]) -> Check:
    """Choose by the schema; a file that names none is left to the first check, which says what to write."""
    from ccas_core.strict_yaml import Reader
    from ccas_core.tapd.case_file import is_case_file

    reader = Reader(text, source)
    if is_case_file(reader):
        return checks[_CASES]
    schema = _schema(reader)
    if schema is None:
        return next(iter(checks.values()))
    known = [each for each in checks if each != _CASES]
    place, name = schema
    if name not in known:
        hint = did_you_mean(name, known)
        reader.stop(
            place,
            f"unknown schema '{name}'",
            expected=f"one of {', '.join(known)}",
            hint=hint if "mean" in hint else "",
            width=len(name),
        )
    return checks[name]


def _schema(reader: Reader) -> tuple[Place, str] | None:
    from ccas_core.yaml_nodes import Mapping as Keys
    from ccas_core.yaml_nodes import Scalar

    schema = reader.block(reader.root).find("schema") if isinstance(reader.root, Keys) else None
    return (schema, schema.text) if isinstance(schema, Scalar) else None
