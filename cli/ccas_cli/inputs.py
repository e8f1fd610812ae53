"""What commands take in: plugins, scenarios by path or by name, a ruleset by its id."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from . import talk

if TYPE_CHECKING:
    from ccas_core.plugins import Plugins
    from ccas_core.sim.scenario import Scenario
    from ccas_core.sweep.spec import Sweep

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
    str,
    typer.Option(
        "--solver", metavar="NAME", help="Solver of the ships' local problems: riccati, fatrop or ipopt."
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


def scenario_file(name: str) -> Path:
    """Find a scenario: a file of this path, or a shipped one of this name."""
    import ccas_scenarios

    path = Path(name)
    if path.is_file() or path.suffix in (".yaml", ".yml"):
        return path  # one that does not exist is refused by who reads it
    return ccas_scenarios.path(name)


def read_sweep(name: str, plugins: Plugins) -> Sweep:
    """Read a sweep file, or a shipped one of this name; scenarios that it names are found."""
    import ccas_scenarios
    from ccas_core.sweep.spec import load_sweep

    path = Path(name)
    file = path if path.is_file() or path.suffix in (".yaml", ".yml") else ccas_scenarios.path(name)
    found = load_sweep(file, plugins.rulesets)
    cells = tuple(
        replace(cell, scenario=str(scenario_file(cell.scenario))) if cell.scenario else cell
        for cell in found.cells
    )
    return replace(found, cells=cells)


def read_scenario(name: str, plugins: Plugins, ruleset: str | None = None) -> Scenario:
    """Read a scenario whose rulesets are all known; `ruleset` replaces that of the waters."""
    from ccas_core.sim.scenario_file import load_scenario

    if ruleset is not None:
        plugins.ruleset(ruleset)  # refuses one that is not known, before the file is read
    scenario = load_scenario(scenario_file(name), plugins.rulesets)
    if ruleset is None:
        return scenario
    return replace(scenario, waters=replace(scenario.waters, ruleset=ruleset))
