"""What the program says: data on stdout, talk on stderr, colours on terminals only."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias

import typer

if TYPE_CHECKING:
    from rich.console import Console

_UNBOUNDED: Final = 1000  # columns of a table that goes into a file or a pipe: nothing is wrapped there

AsJson: TypeAlias = Annotated[bool, typer.Option("--json", help="Print JSON, and nothing else, on stdout.")]


def note(text: str) -> None:
    """Say something to the user that is not data."""
    print(text, file=sys.stderr)


def show_json(value: object) -> None:
    """Print data as JSON, in ASCII so that every terminal and pipe takes it; no number may be infinite."""
    print(json.dumps(value, indent=2, allow_nan=False))


def show(text: str) -> None:
    """Print data as text."""
    print(text)


def show_table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print data as a table; a heading that begins with '>' has its column set to the right."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, show_edge=False, header_style="bold")
    for heading in headings:
        table.add_column(heading.removeprefix(">"), justify="right" if heading.startswith(">") else "left")
    for row in rows:
        table.add_row(*row)
    terminal = console()
    with terminal.capture() as text:  # a pipe that is closed is then told as for all other data
        terminal.print(table)
    show("\n".join(line.rstrip() for line in text.get().splitlines()))


def console(*, stderr: bool = False) -> Console:
    """Make a console that takes text as it is: a ship may be called '[red]'."""
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    width = None if stream.isatty() else _UNBOUNDED
    return Console(stderr=stderr, width=width, markup=False, emoji=False, highlight=False)


def one_or_more(count: int, what: str) -> str:
    """Count things.

    >>> one_or_more(1, "ship"), one_or_more(2, "ship"), one_or_more(2, "entry")
    ('1 ship', '2 ships', '2 entries')
    """
    many = f"{what[:-1]}ies" if what.endswith("y") else f"{what}s"
    return f"{count} {what if count == 1 else many}"
