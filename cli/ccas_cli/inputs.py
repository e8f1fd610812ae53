"""What commands take in: plugins, scenarios by path or by name, a ruleset by its id."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from . import talk

if TYPE_CHECKING:
    from ccas_core.dmpc.solvers import AbstractLocalSolver
    from ccas_core.plugins import Plugins
    from ccas_core.sim.scenario import Scenario

ScenarioName: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="Path of a scenario file, or name of a shipped one; `ccas scenarios` lists them.",
        show_default=False,
    ),
]
RulesetId: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--ruleset",
        metavar="ID",
        help="Ruleset of the waters, in place of the scenario's; regions keep theirs. "
        "`ccas rulesets` lists them.",
        show_default=False,
    ),
]
SolverName: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--solver",
        metavar="NAME",
        help="Solver of the ships' local problems: riccati, which is the default where numba is installed, "
        "fatrop or ipopt.",
        show_default=False,
    ),
]


def load_plugins(context: typer.Context) -> Plugins:
    """Load all plugins; what was left out is told on stderr, and with --trace-hooks who answered what."""
    from ccas_core import plugins

    found = ask_plugins(context)
    plugins.warn(found.failures)
    return found


def ask_plugins(context: typer.Context) -> Plugins:
    """Load all plugins, for a command that tells itself what was left out."""
    from ccas_core import plugins

    trace = (lambda line: talk.note(f"hook: {line}")) if context.obj else None
    return plugins.load(trace=trace)


def ready_solver(name: str | None, *, quiet: bool = False) -> AbstractLocalSolver:
    """Make a solver, the default one unless it is named; what takes a while is told on stderr."""
    from ccas_core.dmpc.solvers import make_solver

    with warnings.catch_warnings(record=True) as remarks:
        warnings.simplefilter("always", RuntimeWarning)
        solver = make_solver(name)
    for remark in remarks:
        talk.note(str(remark.message))
    solver.prepare(None if quiet else talk.note)
    return solver


def scenario_file(name: str) -> Path:
    """Find a scenario: a file of this path, or a shipped one of this name."""
    import ccas_scenarios

    path = Path(name)
    if path.is_file() or path.suffix in (".yaml", ".yml"):
        return path  # one that does not exist is refused by who reads it
    return ccas_scenarios.path(name)


def read_scenario(name: str, plugins: Plugins, ruleset: str | None = None) -> Scenario:
    """Read a scenario whose rulesets are all known; `ruleset` replaces that of the waters."""
    from ccas_core.sim.scenario_file import load_scenario

    if ruleset is not None:
        plugins.ruleset(ruleset)  # refuses one that is not known, before the file is read
    scenario = load_scenario(scenario_file(name), plugins.rulesets)
    if ruleset is None:
        return scenario
    return replace(scenario, waters=replace(scenario.waters, ruleset=ruleset))
