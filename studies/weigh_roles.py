"""How much should a role weigh?  Safety, faithfulness, delay and actions for each parameter of the roles.

One parameter is changed at a time; `default` is what is shipped.  The study goes on where it was stopped:

    python studies/weigh_roles.py --count 25 --out runs/weigh_roles

Each variant sails the same drawn encounters: risky ones of two ships, crossings beside a ship that ignores
its duty, and groups: with `--count 25`, 105 cases a variant.  The table is what docs/parameters.md quotes.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from ccas_core.agent.events import Conduct
from ccas_core.sweep.campaign import Progress, run
from ccas_core.sweep.spec import Cell, Draw, Sweep, Variant
from ccas_core.sweep.tally import cell_entries
from ccas_core.sweep.task import program

TRIED: Final = {
    "give_way_gain": (1.0, 20.0),
    "stand_on_gain": (0.5, 1.0),
    "act_within": (8.0, 30.0),
    "resume_beyond": (15.0, 40.0),
    "clear_by": (1.0, 10.0),
    "reserve": (0.0, 5.0),
    "visible_offset": (4.0, 25.0),
    "visible_factor": (0.6, 0.9),
    "kappa_across": (0.6, 1.2),
}
CELLS: Final = (
    ("head_on", Draw.HEAD_ON, Conduct.DUTIFUL),
    ("crossing", Draw.CROSSING, Conduct.DUTIFUL),
    ("overtaking", Draw.OVERTAKING, Conduct.DUTIFUL),
    ("ignored", Draw.CROSSING, Conduct.IGNORES),
    ("junction", Draw.JUNCTION, Conduct.DUTIFUL),
)


def study(count: int, seed: int, rulesets: tuple[str, ...]) -> Sweep:
    """The sweep of this study; groups are a fifth as many, for they take longer."""
    variants = [Variant(name="default")]
    for name, values in TRIED.items():
        variants += [Variant(name=f"{name}={value:g}", parameters=((name, value),)) for value in values]
    cells = tuple(
        Cell(
            name=name,
            count=max(1, count // 5) if draw is Draw.JUNCTION else count,
            draw=draw,
            breach=breach,
            ships=(2, 6) if draw is Draw.JUNCTION else (2, 2),
        )
        for name, draw, breach in CELLS
    )
    return Sweep(name="weigh_roles", seed=seed, rulesets=rulesets, cells=cells, variants=tuple(variants))


HEAD: Final = (
    *("variant", "collisions", "entries", "not faithful", "frozen", "restless"),
    *("index [m]", "delay [s]", "delay of stand-on ships", "actions"),
)


def table(entries: list[dict[str, Any]]) -> list[str]:
    """A line for each variant: sums and means over all cells."""
    lines = [f"| {' | '.join(HEAD)} |", "|" + " --- |" * len(HEAD)]
    for variant in dict.fromkeys(entry["variant"] for entry in entries):
        rows = [entry for entry in entries if entry["variant"] == variant]
        counts = [sum(row[key] for row in rows) for key in ("collisions", "entries")]
        counts += [sum(row["judged"] - row["faithful"] for row in rows)]
        counts += [sum(row[key] for row in rows) for key in ("frozen", "restless")]
        index = min(row["min_safety_index_m"] for row in rows if row["min_safety_index_m"] is not None)
        told = [variant, *map(str, counts), f"{index:.1f}", f"{mean(rows, 'mean_delay_s'):.1f}"]
        told += [f"{mean(rows, 'mean_stand_on_delay_share'):.3%}", f"{mean(rows, 'mean_actions'):.2f}"]
        lines.append(f"| {' | '.join(told)} |")
    return lines


def mean(rows: list[dict[str, Any]], key: str) -> float:
    """Mean over cells that have the number, by their cases."""
    known = [row for row in rows if row[key] is not None]
    return float(sum(row[key] * row["done"] for row in known) / sum(row["done"] for row in known))


def main() -> None:
    """Run the study, and print its table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--count", type=int, default=25, help="encounters of each kind and variant")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--ruleset", action="append", help="tran2026 unless given; may be given again")
    parser.add_argument("--executor", default="local", help="as of `ccas sweep`")
    parser.add_argument("--out", type=Path, default=Path("runs/weigh_roles"))
    given = parser.parse_args()
    sweep = study(given.count, given.seed, tuple(given.ruleset or ["tran2026"]))
    sweep = replace(sweep, executor=given.executor)

    def tell(progress: Progress) -> None:
        done = progress.known + progress.done
        if done % 50 == 0 or done == progress.total:
            print(f"{done} of {progress.total}", file=sys.stderr)

    print("\n".join(table(cell_entries(run(sweep, given.out, program(), tell)))))


if __name__ == "__main__":
    main()
