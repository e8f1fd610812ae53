"""`ccas check`: all that is wrong with files, at once."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from ccas_core.errors import Diagnostic, InputError, did_you_mean

from . import inputs, talk
from .exits import Code

if TYPE_CHECKING:
    from ccas_core.plugins import Plugins

Check: TypeAlias = Callable[[str, str], object]  # takes text and source, raises InputError with all findings


def check(
    context: typer.Context,
    paths: Annotated[
        list[Path],
        typer.Argument(
            metavar="PATH",
            help="Files, or folders that are searched for *.yaml.",
            show_default=False,
        ),
    ],
    as_json: talk.AsJson = False,
) -> None:
    """Say all that is wrong with scenario files, without sailing them.

    Every finding has its file, line and column, what was found and what was expected. What kind of file it is
    is told by its first key, `schema`. Exit code 2 if there are findings.

    Example:
        ccas check scenarios/ my_own.yaml
    """
    checks = _checks(inputs.load_plugins(context))
    findings: list[Diagnostic] = []
    count = 0
    for path in paths:
        files = sorted(path.rglob("*.yaml")) if path.is_dir() else [path]
        if not files:
            hint = "a scenario is a file that ends in .yaml"
            findings.append(Diagnostic(source=str(path), message="no *.yaml file in this folder", hint=hint))
        count += len(files)
        findings += (finding for file in files for finding in _findings(file, checks))
    if as_json:
        talk.show_json([dataclasses.asdict(finding) for finding in findings])
    else:
        for finding in findings:
            talk.show(str(finding))
        what = talk.one_or_more(len(findings), "finding") if findings else "nothing is wrong"
        talk.note(f"{talk.one_or_more(count, 'file')} read: {what}")
    if findings:
        raise typer.Exit(Code.WRONG_USE)


def _checks(plugins: Plugins) -> dict[str, Check]:
    """How to check a file, by its schema."""
    from ccas_core.sim import scenario_file

    return {scenario_file.SCHEMA: partial(scenario_file.parse_scenario, rulesets=plugins.rulesets)}


def _findings(file: Path, checks: Mapping[str, Check]) -> Iterator[Diagnostic]:
    from ccas_core.findings import read_text

    try:
        text = read_text(file)
        _check_for(text, str(file), checks)(text, str(file))
    except InputError as error:
        yield from error.diagnostics


def _check_for(text: str, source: str, checks: Mapping[str, Check]) -> Check:
    """Choose by the schema; a file that names none is left to the first check, which says what to write."""
    from ccas_core.strict_yaml import Reader
    from ccas_core.yaml_nodes import Mapping as Keys
    from ccas_core.yaml_nodes import Scalar

    reader = Reader(text, source)
    first = next(iter(checks.values()))
    schema = reader.block(reader.root).find("schema") if isinstance(reader.root, Keys) else None
    if not isinstance(schema, Scalar):
        return first
    if schema.text not in checks:
        hint = did_you_mean(schema.text, checks)
        reader.stop(
            schema,
            f"unknown schema '{schema.text}'",
            expected=f"one of {', '.join(checks)}",
            hint=hint if "mean" in hint else "",
        )
    return checks[schema.text]
