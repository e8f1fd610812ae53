"""`ccas simulate`: sail a scenario, and leave a run folder."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from . import inputs, talk
from .exits import Code

if TYPE_CHECKING:
    from ccas_core.dmpc.solvers import AbstractLocalSolver
    from ccas_core.plugins import Plugins
    from ccas_core.sim.scenario import Scenario

    from .sailing import Sailed

DAMAGE: Final = ("collisions", "groundings", "allisions")  # what makes a run a finding


def simulate(
    context: typer.Context,
    scenario: inputs.ScenarioName,
    ruleset: inputs.RulesetId = None,
    solver: inputs.SolverName = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="DIR",
            help="Run folder, else runs/ and the scenario's name. An earlier run in it is replaced.",
            show_default=False,
        ),
    ] = None,
    as_json: talk.AsJson = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress and no remarks on stderr.")] = False,
    no_pictures: Annotated[bool, typer.Option("--no-pictures", help="Draw no pictures.")] = False,
) -> None:
    """Sail a scenario: ships find out who gives way, and plan together.

    The run folder gets the scenario as it was resolved, `frames.csv` and `decisions.jsonl` while the
    ships sail, then `summary.json` and pictures. On stdout comes a table, or with --json what
    `summary.json` holds. Ctrl-C ends the voyage after the present period and keeps what was sailed; a second
    one ends it at once. Exit code 1 if ships collided, ran aground or struck an obstacle.

    Example:
        ccas simulate tran2026/fig_12 --ruleset tran2026 --out runs/fig_12
    """
    from .voyage_table import show_pictures, show_summary

    plugins = inputs.load_plugins(context)
    found = inputs.read_scenario(scenario, plugins, ruleset)
    local_solver = inputs.ready_solver(solver, quiet=quiet)
    sailed = _sail(found, plugins, local_solver, out or default_folder(found.name), quiet)
    if as_json:
        talk.show_json(sailed.summary)
    else:
        show_summary(sailed.summary, sailed.folder)
    if sailed.interrupted:
        talk.note(f"interrupted at {sailed.until:.0f} s; what was sailed is in {sailed.folder}")
        raise typer.Exit(Code.INTERRUPTED)
    if not no_pictures:
        pictures = sailed.draw()
        if not as_json:
            show_pictures(pictures)
    if any(sailed.summary[key] for key in DAMAGE):
        raise typer.Exit(Code.FINDINGS)


def default_folder(name: str) -> Path:
    """Folder of a run by the name of its scenario, without what file systems do not take.

    >>> default_folder("two ships: ../a").as_posix()
    'runs/two ships_ .._a'
    """
    return Path("runs", re.sub(r'[\x00-\x1f\x7f/\\:*?"<>|]', "_", name)[:100].strip(". ") or "run")


def _sail(
    scenario: Scenario,
    plugins: Plugins,
    solver: AbstractLocalSolver,
    folder: Path,
    quiet: bool,
) -> Sailed:
    from .sailing import sail, watched

    began = time.perf_counter()
    with watched(scenario, quiet=quiet) as watcher:
        sailed = sail(scenario, plugins, solver.name, solver, folder, watcher)
    if not quiet:
        seconds = time.perf_counter() - began
        talk.note(f"{scenario.name}: sailed {sailed.until:.0f} s in {seconds:.1f} s")
    return sailed
