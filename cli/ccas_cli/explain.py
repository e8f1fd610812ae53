"""`ccas explain`: who gives way to whom and why, condition by condition."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ccas_core.errors import Diagnostic, InputError, did_you_mean

from . import inputs, talk
from .explanation_text import as_json as told_as_json
from .explanation_text import show

if TYPE_CHECKING:
    from ccas_core.plugins import Plugins
    from ccas_core.tapd.cases import Case
    from ccas_core.tapd.ruleset import PairRuleset
    from ccas_core.verdict import Kind

    from .meetings import Meeting


def explain(
    context: typer.Context,
    what: Annotated[
        str,
        typer.Argument(
            metavar="WHAT",
            help="A scenario, by path or name; an encounter file, a ruleset file or the id of a ruleset, "
            "with --case; or a run folder, with --time.",
            show_default=False,
        ),
    ],
    pair: Annotated[
        tuple[str, str] | None,
        typer.Option("--pair", metavar="A B", help="Two ships; else all pairs.", show_default=False),
    ] = None,
    ruleset: inputs.RulesetId = None,
    case: Annotated[
        str | None,
        typer.Option(
            "--case", metavar="ID", help="Case of an encounter file, or name of a test.", show_default=False
        ),
    ] = None,
    time: Annotated[
        float | None,
        typer.Option("--time", metavar="S", help="Moment of a voyage, in seconds.", show_default=False),
    ] = None,
    why_not: Annotated[
        str | None,
        typer.Option(
            "--why-not",
            metavar="ROLE",
            help="Say what keeps each ship from this: stand_on, give_way, mutual, …",
            show_default=False,
        ),
    ] = None,
    flip: Annotated[
        bool,
        typer.Option("--flip", help="Say which smallest change of course or speed would change the verdict."),
    ] = False,
    as_json: talk.AsJson = False,
) -> None:
    """Explain who gives way to whom: at the start of a scenario, in a case, or at a moment of a voyage.

    Both ships of a pair judge for themselves. Told are both verdicts, each with its rule, its article and
    every condition of the rule: its value, and how far it lies from its limit. Facts that were recognised
    from positions and courses have the conditions of that below them. With --why-not, the rules that would
    have said otherwise, the nearest to applying first. With --json a pair has the keys of a line of
    `decisions.jsonl`, and more.

    Example:
        ccas explain tran2026/fig_12 --pair ship_1 ship_2 --flip
        ccas explain bpr --case 'a fast ship yields' --why-not stand_on
        ccas explain runs/fig_12 --time 340
    """
    plugins = inputs.load_plugins(context)
    role = _role(why_not)
    found = list(_meetings(what, plugins, pair, ruleset, case, time))
    if as_json:
        talk.show_json([told_as_json(meeting, role, flip=flip) for meeting in found])
        return
    if not found:
        nobody = "one ship alone meets nobody" if time is None else "no two ships meet at this time"
        talk.show(nobody)
    for number, meeting in enumerate(found):
        if number:
            talk.show("")
        show(meeting, role, flip=flip)


def _role(text: str | None) -> Kind | None:
    from ccas_core.verdict import Kind

    if text is None:
        return None
    known = [kind.value for kind in Kind if kind is not Kind.UNKNOWN_FACT]
    if text not in known:
        expected = f"one of {', '.join(known)}"
        hint = did_you_mean(text, known)
        raise InputError(
            Diagnostic(
                source="--why-not",
                message=f"there is no role '{text}'",
                expected=expected,
                hint=hint if "mean" in hint else "",
            )
        )
    return Kind(text)


def _meetings(
    what: str,
    plugins: Plugins,
    pair: tuple[str, str] | None,
    ruleset: str | None,
    case: str | None,
    time: float | None,
) -> Iterator[Meeting]:
    from . import meetings

    kind = _kind(what, plugins)
    _refuse_options(kind, case=case, time=time, ruleset=ruleset)
    if kind == "run":
        from .moments import of_run

        yield from of_run(Path(what), time, plugins, pair)
    elif kind == "scenario":
        yield from meetings.of_scenario(inputs.read_scenario(what, plugins, ruleset), plugins, pair)
    else:
        found, judges = _case(what, kind, plugins, ruleset, case)
        yield from meetings.of_case(found, judges, pair)


def _kind(what: str, plugins: Plugins) -> str:
    """Whether this is a run, a scenario, a ruleset, or a file of cases."""
    from ccas_core.findings import read_text
    from ccas_core.strict_yaml import Reader
    from ccas_core.tapd.case_file import is_case_file
    from ccas_core.tapd.ruleset_draft import SCHEMA
    from ccas_core.yaml_nodes import Mapping, Scalar

    path = Path(what)
    if path.is_dir():
        return "run"
    if not path.is_file():
        return "ruleset" if what in plugins.rulesets else "scenario"
    reader = Reader(read_text(path), what)
    if is_case_file(reader):
        return "cases"
    root = reader.root
    schema = reader.block(root).find("schema") if isinstance(root, Mapping) else None
    same = isinstance(schema, Scalar) and schema.text.partition("@")[0] == SCHEMA.partition("@")[0]
    return "ruleset" if same else "scenario"


def _refuse_options(kind: str, *, case: str | None, time: float | None, ruleset: str | None) -> None:
    """Refuse what has no meaning for what is explained."""
    wrong = {
        "--case": case is not None and kind in ("run", "scenario"),
        "--time": time is not None and kind != "run",
        "--ruleset": ruleset is not None and kind == "run",
    }
    hints = {
        "--case": "cases are in encounter files and ruleset files",
        "--time": "only a run folder has moments: `ccas simulate SCENARIO --out FOLDER` makes one",
        "--ruleset": "a voyage was sailed by its own rulesets",
    }
    told = [
        Diagnostic(source=option, message="has no meaning here", hint=hints[option])
        for option, is_wrong in wrong.items()
        if is_wrong
    ]
    if told:
        raise InputError(*told)


def _case(
    what: str, kind: str, plugins: Plugins, ruleset: str | None, id_: str | None
) -> tuple[Case, list[PairRuleset]]:
    """The case that is asked for, and the rulesets to judge it by."""
    from ccas_core.tapd.case_file import load_cases
    from ccas_core.tapd.ruleset import PairRuleset
    from ccas_core.tapd.written import WrittenRuleset

    judges = [plugins.ruleset(ruleset)] if ruleset is not None else []
    if kind == "ruleset":
        own = plugins.ruleset(what)
        cases = own.text.tests if isinstance(own, WrittenRuleset) else ()
        judges = judges or [own]
        found = _named(what, cases, id_)
    else:
        file = load_cases(what, plugins.vocabulary)
        if id_ in file.broken or (id_ is None and file.broken):
            raise InputError(*file.findings)
        found = _named(what, file.cases, id_)
        judges = judges or [plugins.ruleset(each) for each in found.expected if each in plugins.rulesets]
    if not found.ships:
        raise InputError(Diagnostic(source=what, message=f"case '{found.id}' has no ships to explain"))
    pairs = [each for each in judges if isinstance(each, PairRuleset)]
    if not pairs:
        hint = "choose one with --ruleset; `ccas rulesets` lists them"
        message = f"no ruleset of which case '{found.id}' expects something judges pairs here"
        raise InputError(Diagnostic(source=what, message=message, hint=hint))
    return found, pairs


def _named(what: str, cases: tuple[Case, ...], id_: str | None) -> Case:
    by_id = {case.id: case for case in cases}
    if id_ is None and len(by_id) == 1:
        return next(iter(by_id.values()))
    if id_ in by_id:
        return by_id[id_]
    message = "say which case" if id_ is None else f"there is no case '{id_}'"
    hint = did_you_mean(id_ or "", by_id) if by_id else "it has no cases"
    raise InputError(Diagnostic(source=f"{what}, --case", message=message, hint=hint))
