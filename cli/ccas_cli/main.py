"""The program `ccas`: puts the commands together."""

from __future__ import annotations

import inspect
import io
import sys
from collections.abc import Callable
from typing import Annotated, Final

import typer

from . import (
    bench,
    check,
    codes,
    consistency,
    diff,
    explain,
    facts,
    graph,
    inputs,
    new,
    plugins,
    replaying,
    reproduce,
    rulesets,
    scenarios,
    schema,
    simulate,
    sweep,
    testing,
    verify_certificate,
)
from .exits import answered

COMMANDS: Final[tuple[Callable[..., None], ...]] = (
    simulate.simulate,
    replaying.replay,
    check.check,
    codes.code,
    testing.test,
    consistency.check_consistency,
    verify_certificate.verify_certificate,
    graph.graph,
    explain.explain,
    diff.diff,
    scenarios.scenarios,
    rulesets.rulesets,
    facts.facts,
    plugins.plugins,
    schema.schema,
    reproduce.reproduce,
    sweep.sweep,
    bench.bench,
)

# Without markup: rich alone would take longer to import than `ccas --help` may take.
app = typer.Typer(name="ccas", no_args_is_help=True, add_completion=False, rich_markup_mode=None)


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"ccas {version('ccas')}")
        raise typer.Exit


def ccas(
    context: typer.Context,
    trace_hooks: Annotated[
        bool, typer.Option("--trace-hooks", help="Say on stderr which plugin answered which hook with what.")
    ] = False,
    no_plugins: Annotated[
        bool,
        typer.Option(
            "--no-plugins",
            help="Load none but those that come with ccas. CCAS_PLUGINS=a,b loads just these besides.",
        ),
    ] = False,
    version: Annotated[  # noqa: ARG001 - its callback does it
        bool,
        typer.Option("--version", help="Show the version and exit.", callback=_show_version, is_eager=True),
    ] = False,
) -> None:
    """Collision avoidance for inland ships: who gives way to whom, and how the ships then move.

    Data goes to stdout, talk to stderr. Exit codes: 0 clean; 1 findings, such as a collision; 2 wrong use, or
    input that cannot be read; 3 undecided; 101 a fault of ours; 130 interrupted.

    Example:
        ccas scenarios
        ccas simulate tran2026/fig_12 --out runs/fig_12
        ccas explain tran2026/fig_12
    """
    context.obj = inputs.Wanted(trace=trace_hooks, none=no_plugins)


def _manual(command: Callable[..., None]) -> str:
    """Docstring of a command as a help text, in which lines of an example stay as they are."""
    return inspect.cleandoc(command.__doc__ or "").replace("\n\nExample:\n", "\n\n\b\nExample:\n")


app.callback(help=_manual(ccas))(ccas)
for _command in COMMANDS:
    app.command(help=_manual(_command), short_help=_manual(_command).partition("\n")[0])(answered(_command))


_new = typer.Typer(
    help="Write a ruleset file, or a plugin, to begin with.", no_args_is_help=True, rich_markup_mode=None
)
for _command in (new.ruleset, new.plugin):
    _new.command(help=_manual(_command), short_help=_manual(_command).partition("\n")[0])(answered(_command))
app.add_typer(_new, name="new")


def main() -> None:
    """Run the program; how it ends is decided in `exits`."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # a name that a terminal has no letters for
    app(prog_name="ccas")
