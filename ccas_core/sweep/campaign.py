"""A sweep, run: cases that the journal does not know are sailed, and the folder says what came of them.

The folder holds `journal.jsonl`, `cases.csv`, `summary.json`, `report.html`, and `worst/` with the scenario
files of all cases that have a fault.
"""

from __future__ import annotations

import csv
import importlib
import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Final

from ..errors import Diagnostic, InputError
from ..sim.metrics import plain
from ..sim.run_folder import explained
from ..sim.scenario_dump import dump_scenario
from ..tapd.ruleset import AbstractRuleset
from .baseline import compare
from .case import cases, geometry, is_two_ships, scenario
from .executor import execute
from .journal import FILE, Journal
from .spec import Sweep
from .tally import Result, faults, price, summary, worst
from .task import Program, sail_case
from .workers import Status

SUMMARY: Final = "summary.json"
TABLE: Final = "cases.csv"
_JOINT_DEADLINE: Final = 300.0  # of one joint problem and the voyage beside it [s]
WORST: Final = "worst"
COLUMNS: Final = (
    "case",
    "cell",
    "ruleset",
    "variant",
    "geometry",
    "index",
    "status",
    "faults",
    "ships",
    "collisions",
    "entries",
    "groundings",
    "frozen",
    "min_clearance_m",
    "min_safety_index_m",
    "calm",
    "acted",
    "avoidable",
    "faithful",
    "max_delay_s",
    "changes_of_mind",
    "restless",
    "seconds",
)


@dataclass(slots=True)
class Progress:
    """How far a sweep has come."""

    total: int
    known: int  # from the journal
    done: int = 0
    failures: Counter[str] = field(default_factory=Counter)  # by kind: faults of cases, and cases that failed


def run(
    sweep: Sweep, folder: Path, sails: Program, tell: Callable[[Progress], None] = lambda _: None
) -> tuple[Result, ...]:
    """Sail what is not yet in the journal; all results, in the order of the specification.

    Parameters
    ----------
    sails
        The program that sails: results of another one do not count.
    tell
        Called after each case.
    """
    with explained(folder):
        _refuse_strangers(folder)
        folder.mkdir(parents=True, exist_ok=True)
        journal = Journal(folder / FILE)
        wanted = {case.key(sails.code): case for case in cases(sweep)}
        found = {
            key: Result(case, Status.DONE, journal.results[key])
            for key, case in wanted.items()
            if key in journal.results
        }
        progress = Progress(len(wanted), len(found))
        for result in found.values():
            progress.failures.update(faults(result))
        keys = {case: key for key, case in wanted.items() if key not in found}
        tell(progress)
        for done in execute(sweep.executor, partial(sail_case, sent_by=sails), list(keys), sweep.deadline):
            key = keys[done.task]
            if done.status is Status.DONE:
                kept = journal.add(key, done.task.name, done.result)
            else:
                kept = {"why": str(done.result)}
            found[key] = Result(done.task, done.status, kept)
            progress.done += 1
            progress.failures.update(faults(found[key]))
            tell(progress)
    return tuple(found[key] for key in wanted)


def run_jointly(
    sweep: Sweep, results: Sequence[Result], folder: Path, sails: Program, tell: Callable[[Progress], None]
) -> dict[str, dict[str, Any]]:
    """Solve groups by one mind as well: every one with a fault, and the first `jointly` of each cell.

    What `baseline.compare` says of each, by the name of the case.
    """
    chosen = [
        each.case
        for each in results
        if not is_two_ships(each.case.cell)
        and each.status is Status.DONE
        and (each.case.index < sweep.jointly or faults(each))
    ]
    journal = Journal(folder / FILE)
    wanted = {f"joint-{case.key(sails.code)}": case for case in chosen}
    found = {case.name: journal.results[key] for key, case in wanted.items() if key in journal.results}
    keys = {case: key for key, case in wanted.items() if case.name not in found}
    progress = Progress(len(wanted), len(found))
    if wanted:
        tell(progress)
    for done in execute(sweep.executor, partial(compare, sent_by=sails), list(keys), _JOINT_DEADLINE):
        result = done.result if done.status is Status.DONE else {"why": str(done.result)}
        if done.status is Status.DONE:
            result = journal.add(keys[done.task], done.task.name, result)
        found[done.task.name] = result
        progress.done += 1
        tell(progress)
    return {case.name: found[case.name] for case in chosen}


def write(
    sweep: Sweep,
    results: tuple[Result, ...],
    jointly: Mapping[str, Mapping[str, Any]],
    folder: Path,
    rulesets: Mapping[str, AbstractRuleset],
) -> dict[str, Any]:
    """Write table, summary, and the scenario files of all cases with a fault; return the summary."""
    told = {**summary(sweep.name, sweep.seed, results), "price": price(jointly), "jointly": dict(jointly)}
    found: dict[str, Any] = json.loads(json.dumps(plain(told)))
    with explained(folder):
        with (folder / TABLE).open("w", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            table.writeheader()
            table.writerows(_rows(results))
        (folder / WORST).mkdir(exist_ok=True)
        for old in (folder / WORST).glob("*.yaml"):
            old.unlink()
        for each, _ in worst(results):
            try:
                text = dump_scenario(scenario(each.case, rulesets))
            except Exception:
                if each.status is Status.DONE:
                    raise
                continue  # a case that cannot be made: the report has what was said
            (folder / WORST / f"{each.case.name}.yaml").write_text(text, encoding="utf-8")
        text = json.dumps(found, indent=2, allow_nan=False) + "\n"
        (folder / SUMMARY).write_text(text, encoding="utf-8")
    return found


def parquet_writer() -> Callable[[Sequence[Result], Path], None]:
    """What writes the table of cases as Parquet; refused at once where it cannot be had."""
    try:
        arrow, parquet = (importlib.import_module(name) for name in ("pyarrow", "pyarrow.parquet"))
    except ImportError as error:
        hint = "install it with `pip install 'ccas[parquet]'`; the same table is in cases.csv"
        raise InputError(
            Diagnostic(source="--parquet", message=f"Parquet cannot be written: {error}", hint=hint)
        ) from error

    def written(results: Sequence[Result], file: Path) -> None:
        with explained(file):
            parquet.write_table(arrow.Table.from_pylist(list(_rows(results))), file)

    return written


def _rows(results: Sequence[Result]) -> Iterator[dict[str, object]]:
    for each in results:
        case, kept = each.case, each.kept
        row: dict[str, object] = dict.fromkeys(COLUMNS)
        row |= {
            "case": case.name,
            "cell": case.cell.name,
            "ruleset": case.under,
            "variant": case.variant.name,
            "geometry": geometry(case.cell),
            "index": case.index,
            "status": str(each.status),
            "faults": " ".join(faults(each)),
        }
        if each.status is Status.DONE:
            delays = [ship["delay_s"] for ship in kept["ships"].values() if ship["delay_s"] is not None]
            judged = [met["faithful"] for met in kept["encounters"] if met["faithful"] is not None]
            row |= {key: kept[key] for key in COLUMNS if key in kept}
            row |= {
                "ships": kept["count"],
                "faithful": all(judged) if judged else None,
                "max_delay_s": max(delays, default=None),
                "changes_of_mind": max(kept["changes_of_mind"].values(), default=0),
                "restless": len(kept["restless"]),
            }
        yield row


def is_sweep(folder: Path) -> bool:
    """Whether a folder holds a sweep, whole or broken off."""
    return (folder / FILE).is_file()


def _refuse_strangers(folder: Path) -> None:
    if folder.exists() and (not folder.is_dir() or (any(folder.iterdir()) and not is_sweep(folder))):
        raise InputError(
            Diagnostic(
                source=str(folder),
                message="is not empty and not a sweep" if folder.is_dir() else "is a file",
                expected="a new or empty folder, or an earlier sweep, which goes on",
                hint="choose another folder with --out",
            )
        )
