"""`ccas sweep`: thousands of encounters, sailed in processes, counted and told in a report."""

from __future__ import annotations

import sys
import time
from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from . import inputs, talk
from .exits import Code

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from ccas_core.sweep.campaign import Progress
    from ccas_core.sweep.spec import Sweep

_EVERY: Final = 10.0  # between two lines of progress in a file or a pipe [s]
_DAMAGE: Final = ("collisions", "groundings", "frozen")


def sweep(
    context: typer.Context,
    spec: Annotated[
        str,
        typer.Argument(
            metavar="SPEC",
            help="Path of a sweep file, or name of a shipped one; `ccas scenarios` lists them.",
            show_default=False,
        ),
    ],
    seed: Annotated[
        int | None,
        typer.Option("--seed", metavar="N", min=0, help="In place of the file's seed.", show_default=False),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="DIR",
            help="Folder, else runs/ and the sweep's name and seed. An earlier sweep in it goes on.",
            show_default=False,
        ),
    ] = None,
    ruleset: Annotated[
        list[str] | None,
        typer.Option("--ruleset", metavar="ID", help="In place of the file's; may be given again."),
    ] = None,
    executor: Annotated[
        str | None,
        typer.Option(
            "--executor",
            metavar="WHERE",
            help="local, local:N (processes), or tcp://host:port (Dask); in place of the file's.",
            show_default=False,
        ),
    ] = None,
    limit: Annotated[
        int | None,
        typer.Option(
            "--limit",
            metavar="N",
            min=1,
            help="At most so many cases of each cell, ruleset and variant; the rest can follow later.",
            show_default=False,
        ),
    ] = None,
    parquet: Annotated[bool, typer.Option("--parquet", help="Write the table as Parquet as well.")] = False,
    as_json: talk.AsJson = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress on stderr.")] = False,
) -> None:
    """Sail thousands of encounters, and count what came of them.

    The folder gets `cases.csv`, `summary.json`, `report.html` (with pictures of the worst cases) and the
    scenario files of all cases with a fault. Ctrl-C stops; the same command goes on where it was stopped, and
    what is finished is not sailed again. Exit code 1 if ships collided, ran aground or froze, judged by two
    laws without a fall-back, or a case failed.

    Example:
        ccas sweep two_ship_short --seed 7 --out runs/seven
    """
    from ccas_core.sweep.campaign import parquet_writer, run, run_jointly, write
    from ccas_core.sweep.report import write_report
    from ccas_core.sweep.task import program

    write_table = parquet_writer() if parquet else None
    plugins = inputs.load_plugins(context)
    wanted = _specified(inputs.read_sweep(spec, plugins), seed, ruleset, executor, limit)
    sides = (id_ for cell in wanted.cells for id_ in cell.border or ())
    for id_ in (*wanted.rulesets, *sides):
        plugins.ruleset(id_)  # refuses one that is not known
    folder = out or Path("runs", f"{wanted.name}-{wanted.seed}")
    sails = program(inputs.wanted_plugins(context).only)
    teller = _Teller(quiet=quiet)
    results = run(wanted, folder, sails, teller.tell)
    teller.end()
    beside = _Teller(quiet=quiet, what="groups beside one mind")
    jointly = run_jointly(wanted, results, folder, sails, beside.tell)
    beside.end()
    found = write(wanted, results, jointly, folder, plugins.rulesets)
    if write_table:
        write_table(results, folder / "cases.parquet")
    report = write_report(wanted, results, found, folder, plugins.rulesets)
    if as_json:
        talk.show_json(found)
    else:
        _show(found["cells"], report)
        _show_pairings(found["mixed"])
    broken = any((cell["laws"] or {}).get("faults") for cell in found["cells"])
    if found["failures"] or broken or any(cell[key] for cell in found["cells"] for key in _DAMAGE):
        raise typer.Exit(Code.FINDINGS)


def _specified(
    wanted: Sweep, seed: int | None, rulesets: list[str] | None, executor: str | None, limit: int | None
) -> Sweep:
    """Put what the command line says in place of what the file says."""
    return replace(
        wanted,
        seed=wanted.seed if seed is None else seed,
        rulesets=tuple(rulesets) if rulesets else wanted.rulesets,
        executor=executor or wanted.executor,
        cells=tuple(replace(cell, count=min(cell.count, limit or cell.count)) for cell in wanted.cells),
    )


@dataclass(slots=True)
class _Teller:
    """Tells on stderr how a sweep goes: rate, time left, failures by kind."""

    quiet: bool
    what: str = "cases"
    began: float = field(default_factory=time.monotonic)
    last: float = 0.0
    written: bool = False

    def tell(self, progress: Progress) -> None:
        """Say a line now and then, or, on a terminal, write it over the one before."""
        now = time.monotonic()
        terminal = sys.stderr.isatty()
        over = progress.known + progress.done == progress.total
        if self.quiet or (now < self.last + (0.2 if terminal else _EVERY) and not over):
            return
        self.last = now
        line = self._line(progress, now - self.began)
        if terminal:
            sys.stderr.write(f"\r\x1b[K{line}")
            sys.stderr.flush()
            self.written = True
        else:
            talk.note(line)

    def end(self) -> None:
        """End the line on a terminal."""
        if self.written:
            talk.note("")

    def _line(self, progress: Progress, seconds: float) -> str:
        done = progress.known + progress.done
        rate = progress.done / seconds if seconds > 0.0 else 0.0
        left = f", {_clock((progress.total - done) / rate)} left" if rate > 0.0 else ""
        known = f" ({progress.known} from the journal)" if progress.known else ""
        return f"{done} of {progress.total} {self.what}{known}, {rate:.1f}/s{left}{_kinds(progress.failures)}"


def _kinds(failures: Counter[str]) -> str:
    return "".join(f"; {count} {kind}" for kind, count in failures.most_common())


def _clock(seconds: float) -> str:
    """Say a time left.

    >>> _clock(75.2)
    '1:15'
    """
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"


def _show_pairings(rows: Sequence[Mapping[str, Any]]) -> None:
    """Print what each pairing of ships came to, where not all negotiate."""
    if not rows:
        return
    head = (
        "ships",
        "ruleset",
        ">n",
        ">coll. (avoidable)",
        ">entries (avoidable)",
        ">delay [s]",
        ">aside [m]",
    )
    talk.show("\nthe same encounters; delay and distance aside are those of both ships, on average")
    talk.show_table(
        head,
        [
            (
                row["pairing"],
                row["ruleset"],
                str(row["n"]),
                f"{row['collisions']} ({row['avoidable_collisions']})",
                f"{row['entries']} ({row['avoidable_entries']})",
                *("-" if row[key] is None else f"{row[key]:.0f}" for key in ("delay", "aside")),
            )
            for row in rows
        ],
    )


def _show(cells: Sequence[Mapping[str, Any]], report: Path) -> None:
    head = ("cell", "ruleset", ">n", ">judged", ">faithful", ">calm", ">acted", ">coll.", ">entries")
    rows = [
        [
            f"{cell['name']} {cell['variant']}".strip(),
            cell["ruleset"],
            *(str(cell[key]) for key in ("n", "judged", "faithful", "calm", "calm_acted")),
            *(str(cell[key]) for key in ("collisions", "entries", "groundings", "frozen")),
            "-" if cell["mean_delay_s"] is None else f"{cell['mean_delay_s']:.1f}",
        ]
        for cell in cells
    ]
    talk.show_table((*head, ">ground.", ">frozen", ">delay [s]"), rows)
    talk.show(f"\nreport: {report}")
