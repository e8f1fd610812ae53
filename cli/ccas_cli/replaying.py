"""`ccas replay`: a run as a page that plays it."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from . import inputs, talk

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

_SUFFIXES: Final = (".html", ".htm")


def replay(
    context: typer.Context,
    run: Annotated[
        Path,
        typer.Argument(metavar="RUN", help="Run folder, as `ccas simulate` leaves it.", show_default=False),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="FILE.html",
            help="The page, else replay.html in the run folder. An earlier one is replaced.",
            show_default=False,
        ),
    ] = None,
    as_json: talk.AsJson = False,
) -> None:
    """Write a run as one page that plays it in any browser, and asks for nothing from outside.

    The page shows waters and regions, ships and safety areas to scale, what they plan, who gives way to
    whom and by which article, and on a time line rulesets, fall-backs, deadlocks and how near the ships came.
    A run that was broken off plays as far as it went. Runs of earlier versions have no plans to show. On
    stdout comes the path of the page; with --json also what it shows.

    Example:
        ccas simulate tran2026/fig_12 --out runs/fig_12
        ccas replay runs/fig_12
    """
    from ccas_core.sim.replay import replay as gathered
    from ccas_core.sim.replay_page import write_page
    from ccas_core.sim.run_folder import REPLAY, SCENARIO
    from ccas_core.sim.run_reading import read_run
    from ccas_core.sim.scenario_file import parse_scenario

    file = _named(out) if out else run / REPLAY
    found = read_run(run)
    plugins = inputs.load_plugins(context)
    scenario = parse_scenario(
        found.scenario,
        str(run / SCENARIO),
        vocabulary=plugins.vocabulary,
        controllers=plugins.controllers,
    )
    shown = gathered(scenario, found, run)
    size = write_page(shown, file)
    if as_json:
        talk.show_json({"replay": str(file), "bytes": size, **_counts(shown)})
    else:
        talk.show(f"replay: {file} ({size / 1000.0:.0f} kB)")
    if not found.plans:
        talk.note(f"{run}: no plans were kept, so that none are shown; sail the scenario again to have them")
    elif not shown["plans"]:
        talk.note(f"{run}: so many ships and periods are shown without their plans")


def _named(file: Path) -> Path:
    from ccas_core.errors import Diagnostic, InputError

    if file.suffix.lower() in _SUFFIXES and not file.is_dir():
        return file
    message = "is a folder" if file.is_dir() else "is not the name of a page"
    hint = f"--out {shlex.quote(str(file / 'replay.html' if file.is_dir() else file.with_suffix('.html')))}"
    raise InputError(
        Diagnostic(source=str(file), message=message, expected="a name that ends in .html", hint=hint)
    )


def _counts(shown: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "scenario": shown["name"],
        "complete": shown["complete"],
        "until_s": shown["times_s"][-1],
        "periods": len(shown["times_s"]),
        "ships": len(shown["ships"]),
        "rulesets": shown["rulesets"],
        "plans": bool(shown["plans"]),
        "events": shown["events"],
    }
