"""`ccas test`: cases run under rulesets, with coverage of rules and mutants."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ccas_core.errors import Diagnostic, InputError, did_you_mean

from . import inputs, talk
from .exits import Code
from .suites import Suite, gathered

if TYPE_CHECKING:
    from ccas_core.tapd.case_report import Entry
    from ccas_core.tapd.coverage import Coverage


def test(
    context: typer.Context,
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE",
            help="Ruleset files, whose own tests are run, or ids of rulesets; and encounter files.",
            show_default=False,
        ),
    ],
    ruleset: Annotated[
        str | None,
        typer.Option(
            "--ruleset",
            metavar="ID",
            help="Only what is expected of this ruleset: an id, or the path of a file.",
            show_default=False,
        ),
    ] = None,
    coverage: Annotated[
        bool, typer.Option("--coverage", help="Say which rules decide none of the cases.")
    ] = False,
    mutants: Annotated[
        bool,
        typer.Option(
            "--mutants", help="Drop or negate each rule in turn, and say which such faults no case notices."
        ),
    ] = False,
    as_json: talk.AsJson = False,
) -> None:
    """Run cases: verdicts that are expected, beside those that rulesets give.

    A case is one entry for each ruleset of which it expects something. Compared is what it states: kind,
    who gives way and who stands on, passing side, strength, and so on; of a hard case, the diagnosis. A
    verdict that the file itself calls derived or unverified is compared, but not required. A hard case
    without ships is skipped: it counts neither as passed nor as failed. A ruleset file among FILE stands in
    for the installed one of its id. Exit code 1 if a required verdict differs, 2 if a case or a ruleset
    could not be used.

    Example:
        ccas test bpr encounters.yaml --ruleset bpr --mutants
    """
    plugins = inputs.load_plugins(context)
    suite = gathered(files, plugins, ruleset)
    for finding in suite.findings:
        talk.note(str(finding))
    if ruleset is not None and not suite.entries and not suite.findings:
        told = f"no case expects anything of '{suite.only}'"
        hint = did_you_mean(suite.only, suite.expected)
        raise InputError(Diagnostic(source="--ruleset", message=told, hint=hint))
    covered = dict(_covered(suite, mutants=mutants)) if coverage or mutants else {}
    if as_json:
        _show_json(suite, covered)
    else:
        _show(suite, covered, mutants=mutants)
    if suite.findings:
        raise typer.Exit(Code.WRONG_USE)
    if any(each.failed for each in suite.entries):
        raise typer.Exit(Code.FINDINGS)


def _covered(suite: Suite, *, mutants: bool) -> Iterator[tuple[str, Coverage]]:
    from ccas_core.tapd.coverage import covered

    for id_, (ruleset, cases) in suite.runs.items():
        yield id_, covered(ruleset, cases, mutants=mutants)


def _show_json(suite: Suite, covered: dict[str, Coverage]) -> None:
    from ccas_core.tapd.case_report import as_json

    found: dict[str, Any] = as_json(suite.entries)
    found["not_installed"] = dict(suite.not_installed)
    if covered:
        found["coverage"] = {id_: _coverage_as_json(each) for id_, each in covered.items()}
    talk.show_json(found)


def _coverage_as_json(found: Coverage) -> dict[str, Any]:
    return {
        "rules": len(found.rules),
        "reached": len(found.rules) - len(found.missed),
        "missed": list(found.missed),
        "mutants": len(found.mutants),
        "killed": len(found.mutants) - len(found.survivors),
        "survivors": [{"rule": each.rule, "change": each.change.value} for each in found.survivors],
    }


def _show(suite: Suite, covered: dict[str, Coverage], *, mutants: bool) -> None:
    for each in suite.entries:
        if not each.passed and not each.skipped:
            talk.show(_line(each))
    rows = list(_counts(suite.entries))
    if not rows:
        talk.note("no cases")
        return
    talk.show_table(("ruleset", ">passed", ">failed", ">differ, not required", ">skipped"), rows)
    for id_, found in covered.items():
        talk.show("")
        _show_coverage(id_, found, mutants=mutants)


def _line(entry: Entry) -> str:
    place = f"{entry.source}:{entry.line}" if entry.line else entry.source
    under = f" under {entry.ruleset}" if entry.ruleset else ""
    why = f" (not required: {entry.confidence})" if not entry.required else ""
    return f"{place}: {entry.id}{under}: {'; '.join(entry.differences)}{why}"


def _counts(entries: Sequence[Entry]) -> Iterator[tuple[str, ...]]:
    for id_ in dict.fromkeys(each.ruleset for each in entries):
        mine = [each for each in entries if each.ruleset == id_]
        differ = [each for each in mine if not (each.passed or each.skipped or each.required)]
        numbers = (_count(mine, "passed"), _count(mine, "failed"), len(differ), _count(mine, "skipped"))
        yield (id_ or "not read", *map(str, numbers))


def _count(entries: Iterable[Entry], name: str) -> int:
    return sum(bool(getattr(each, name)) for each in entries)


def _show_coverage(id_: str, found: Coverage, *, mutants: bool) -> None:
    reached = len(found.rules) - len(found.missed)
    talk.show(f"{id_}: {reached} of {talk.one_or_more(len(found.rules), 'rule')} decide a case")
    for rule in found.missed:
        talk.show(f"    no case reaches {rule}")
    if mutants:
        killed = len(found.mutants) - len(found.survivors)
        talk.show(f"{id_}: {killed} of {talk.one_or_more(len(found.mutants), 'mutant')} are noticed")
        for each in found.survivors:
            talk.show(f"    no case notices {each.rule} {each.change}")
