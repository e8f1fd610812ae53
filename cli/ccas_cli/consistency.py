"""`ccas check-consistency`: what can be proved of rulesets, and the ships that show where it fails."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from ccas_core.errors import Diagnostic, InputError, did_you_mean

from . import inputs, talk
from .exits import Code

if TYPE_CHECKING:
    from ccas_core.plugins import Plugins
    from ccas_core.proofs.evidence import Entry
    from ccas_core.proofs.findings import Finding
    from ccas_core.tapd.written import WrittenRuleset

Rulesets: TypeAlias = "tuple[WrittenRuleset, ...]"


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """What is looked at, and how much may be spent on it."""

    budget: float
    max_ships: int
    properties: tuple[str, ...]
    out: Path
    pictures: bool


def check_consistency(
    context: typer.Context,
    rulesets: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="RULESET…", help="Ids of rulesets, or paths of their files.", show_default=False
        ),
    ] = None,
    border: Annotated[
        tuple[str, str] | None,
        typer.Option(
            "--border",
            metavar="A B",
            help="Also ask what happens between a ship under A and one under B.",
            show_default=False,
        ),
    ] = None,
    against: Annotated[
        str | None,
        typer.Option(
            "--against",
            metavar="OLD",
            help="Also ask which ships each RULESET judges otherwise than this older version.",
            show_default=False,
        ),
    ] = None,
    properties: Annotated[
        list[str] | None,
        typer.Option(
            "--property", metavar="NAME", help="Only this property; may be repeated.", show_default=False
        ),
    ] = None,
    assume: Annotated[
        list[str] | None,
        typer.Option(
            "--assume",
            metavar="CONDITION",
            help="Only ships of which this holds, in the words of a ruleset file; may be repeated.",
            show_default=False,
        ),
    ] = None,
    budget: Annotated[
        float, typer.Option("--budget", metavar="SECONDS", help="Time for each ruleset.", min=0.0)
    ] = 60.0,
    max_ships: Annotated[
        int,
        typer.Option("--max-ships", metavar="N", help="Longest ring of ships to look for.", min=3, max=12),
    ] = 4,
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Folder of the ships that show faults.")
    ] = Path("counterexamples"),
    register: Annotated[
        Path | None,
        typer.Option(
            "--register",
            metavar="DIR",
            help="Write a page with all faults into this folder; without RULESET, of all that ccas ships.",
            show_default=False,
        ),
    ] = None,
    as_json: talk.AsJson = False,
    no_pictures: Annotated[bool, typer.Option("--no-pictures", help="Draw no pictures.")] = False,
) -> None:
    """Prove, for all ships of a ruleset's domain, that its verdicts fit together, or show ships where not.

    Each property is proved, refuted by ships that the rules as they run have judged, or undecided. The ships
    are written as scenarios, which `ccas simulate` sails, as encounter files, which `ccas test` reads, and as
    pictures. A waiver in the ruleset file covers a fault of the law itself until its day. Ctrl-C shows what
    is known by then. Exit code 0 if all that is refuted is waived, 1 if not, 3 if something is undecided.

    Example:
        ccas check-consistency bpr
        ccas check-consistency my_own.yaml --property consistent --property complete
        ccas check-consistency --border bpr ccnr
    """
    plugins = inputs.load_plugins(context)
    names = list(rulesets or (_shipped(plugins) if register else ()))
    if not names and border is None:
        hint = "`ccas rulesets` lists them"
        raise InputError(
            Diagnostic(source="RULESET", message="nothing to check", expected="a ruleset", hint=hint)
        )
    chosen = [(name, _narrowed(_written(plugins, name), assume or ())) for name in dict.fromkeys(names)]
    wanted = Wanted(
        budget=budget,
        max_ships=max_ships,
        properties=_known(properties or (), [each for _, each in chosen]),
        out=register or out,
        pictures=not no_pictures,
    )
    old = None if against is None else _written(plugins, against)
    pair = None if border is None else (_written(plugins, border[0]), _written(plugins, border[1]))
    entries, interrupted = _looked(chosen, old, pair, wanted, quiet=as_json)
    _show(entries, wanted, as_json=as_json, register=register, interrupted=interrupted)
    if interrupted:
        talk.note("interrupted; what was known by then is shown")
        raise typer.Exit(Code.INTERRUPTED)
    _leave([finding for entry in entries for finding in entry.findings])


def _leave(findings: Sequence[Finding]) -> None:
    from ccas_core.proofs.check import overall
    from ccas_core.proofs.findings import Outcome

    code = {Outcome.REFUTED: Code.FINDINGS, Outcome.UNDECIDED: Code.UNDECIDED, Outcome.PROVED: Code.CLEAN}
    if (found := code[overall(findings)]) is not Code.CLEAN:
        raise typer.Exit(found)


# -- what is asked for ---------------------------------------------------------------------------


def _known(properties: Sequence[str], rulesets: Sequence[WrittenRuleset]) -> tuple[str, ...]:
    from ccas_core.proofs.check import names_of

    names = {name for ruleset in rulesets for name in names_of(ruleset)}
    found = []
    for name in properties:
        plain = name.replace("-", "_")
        if plain not in names:
            hint = did_you_mean(plain, names)
            raise InputError(Diagnostic(source="--property", message=f"unknown property '{name}'", hint=hint))
        found.append(plain)
    return tuple(found)


def _written(plugins: Plugins, name: str) -> WrittenRuleset:
    from ccas_core.tapd.written import WrittenRuleset

    ruleset = plugins.ruleset(name)
    if not isinstance(ruleset, WrittenRuleset):
        message = "it is written in Python, and nothing can be proved of it"
        hint = "rules in a file can be proved; `ccas test` tries this one on encounters"
        raise InputError(Diagnostic(source=name, message=message, hint=hint))
    return ruleset


def _narrowed(ruleset: WrittenRuleset, conditions: Sequence[str]) -> WrittenRuleset:
    from ccas_core.proofs.check import narrowed

    for condition in conditions:
        ruleset = narrowed(ruleset, condition)
    return ruleset


def _shipped(plugins: Plugins) -> list[str]:
    """Ids of the rulesets that come with ccas."""
    return [id_ for id_, owner in plugins.owners.items() if owner == "rulesets"]


# -- looking -------------------------------------------------------------------------------------


def _looked(
    chosen: Sequence[tuple[str, WrittenRuleset]],
    old: WrittenRuleset | None,
    pair: tuple[WrittenRuleset, WrittenRuleset] | None,
    wanted: Wanted,
    *,
    quiet: bool,
) -> tuple[list[Entry], bool]:
    """Look at everything, one ruleset after the other; whether Ctrl-C ended it."""
    from ccas_core.proofs.check import check, check_against, check_border
    from ccas_core.proofs.evidence import Entry

    from .consistency_progress import watched

    entries: list[Entry] = []
    today = date.today()  # noqa: DTZ011 - a waiver ends with the day where its reader is
    with watched(quiet=quiet) as watch:
        try:
            for name, ruleset in chosen:
                watch.begin()
                entries.append(Entry(name=name, rulesets=(ruleset,), findings=watch.findings, old=old))
                check(
                    ruleset,
                    today=today,
                    budget_s=wanted.budget,
                    max_ships=wanted.max_ships,
                    only=wanted.properties,
                    progress=watch,
                )
                if old is not None:
                    check_against(ruleset, old, today=today, budget_s=wanted.budget, progress=watch)
            if pair is not None:
                watch.begin()
                names = "|".join(each.id for each in pair)
                entries.append(Entry(name=names, rulesets=pair, findings=watch.findings))
                check_border(*pair, today=today, budget_s=wanted.budget, progress=watch)
        except KeyboardInterrupt:
            if not entries:
                raise
            watch.give_up()
            return entries, True
    return entries, False


def _show(
    entries: Sequence[Entry], wanted: Wanted, *, as_json: bool, register: Path | None, interrupted: bool
) -> None:
    from ccas_core.proofs.evidence import shown
    from ccas_core.proofs.register import write_register

    from .consistency_text import as_data, show

    began = time.perf_counter()
    told = [(entry, shown(entry, wanted.out, pictures=wanted.pictures)) for entry in entries]
    if register is not None and not interrupted:
        page = write_register(told, register)
        talk.note(f"register written: {page} ({time.perf_counter() - began:.1f} s)")
    if as_json:
        talk.show_json([as_data(entry, evidence) for entry, evidence in told])
        return
    for number, (entry, evidence) in enumerate(told):
        if number:
            talk.show("")
        show(entry, evidence)
