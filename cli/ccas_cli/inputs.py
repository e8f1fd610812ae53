"""What commands take in: plugins, scenarios by path or by name, a ruleset by its id."""

from __future__ import annotations

import gc
import os
import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias

import typer

from . import talk

if TYPE_CHECKING:
    from ccas_core.dmpc.solvers import AbstractLocalSolver
    from ccas_core.plugins import Plugins
    from ccas_core.sim.scenario import Scenario
    from ccas_core.sweep.spec import Sweep

PLUGINS: Final = "CCAS_PLUGINS"  # environment variable with the names of the plugins that may be loaded

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
        help="Ruleset of the waters, in place of the scenario's: an id (`ccas rulesets` lists them) or the "
        "path of a file. Regions keep theirs.",
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


@dataclass(frozen=True, slots=True)
class Wanted:
    """What was asked of plugins before the name of the command."""

    trace: bool = False
    none: bool = False  # but those that come with ccas

    @property
    def only(self) -> frozenset[str] | None:
        """Names of the plugins that may be loaded; None: all."""
        if self.none:
            return frozenset()
        names = os.environ.get(PLUGINS)
        return None if names is None else frozenset(filter(None, (each.strip() for each in names.split(","))))


def wanted_plugins(context: typer.Context) -> Wanted:
    """What was asked of plugins before the name of this command."""
    return context.obj if isinstance(context.obj, Wanted) else Wanted()


def ask_plugins(context: typer.Context) -> Plugins:
    """Load all plugins, for a command that tells itself what was left out."""
    from ccas_core import plugins

    wanted = wanted_plugins(context)
    trace = (lambda line: talk.note(f"hook: {line}")) if wanted.trace else None
    found = plugins.load(trace=trace, only=wanted.only)
    for name in sorted(
        (wanted.only or frozenset()) - found.loaded.keys() - {f.plugin for f in found.failures}
    ):
        talk.note(f"{PLUGINS}: there is no plugin {name!r}")
    return found


def ready_solver(name: str | None, *, quiet: bool = False) -> AbstractLocalSolver:
    """Make a solver, the default one unless it is named; what takes a while is told on stderr."""
    from ccas_core.dmpc.solvers import make_solver

    with warnings.catch_warnings(record=True) as remarks:
        warnings.simplefilter("always", RuntimeWarning)
        solver = make_solver(name)
    for remark in remarks:
        talk.note(str(remark.message))
    solver.prepare(None if quiet else talk.note)
    _collect_seldom()
    return solver


def _collect_seldom() -> None:
    """Tell the collector that what is loaded stays, and that values of a voyage hold one another in no rings.

    With ten thousand ships it would go through millions of values, again and again, and find nothing.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(3_000_000, 50, 100)  # ten thousand ships hold two millions


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
    found = load_sweep(file, plugins.rulesets, plugins.controllers)
    cells = tuple(
        replace(cell, scenario=str(scenario_file(cell.scenario))) if cell.scenario else cell
        for cell in found.cells
    )
    return replace(found, cells=cells)


def read_scenario(name: str, plugins: Plugins, ruleset: str | None = None) -> Scenario:
    """Read a scenario whose rulesets are all known; `ruleset` replaces that of the waters."""
    from ccas_core.sim.scenario_file import load_scenario

    chosen = None if ruleset is None else plugins.ruleset(ruleset)  # before the file, for it may name it
    scenario = load_scenario(
        scenario_file(name),
        plugins.rulesets,
        regions=plugins.regions,
        vocabulary=plugins.vocabulary,
        controllers=plugins.controllers,
    )
    if chosen is None:
        return scenario
    return replace(scenario, waters=replace(scenario.waters, ruleset=chosen.id))
