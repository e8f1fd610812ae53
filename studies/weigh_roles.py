"""How much should a role weigh?  Safety, faithfulness, delay and actions for each parameter of the roles.

One parameter is changed at a time; `default` is what is shipped.  The study goes on where it was stopped:

    python studies/weigh_roles.py --count 20 --out runs/weigh_roles

Each variant sails the same drawn encounters: risky ones of two ships, crossings beside a ship that ignores
its duty, and groups.  The table is what docs/parameters.md quotes.
"""

from __future__ import annotations

import argparse
import sys
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
    "clear_by": (1.0, 10.0),
    "reserve": (0.0, 5.0),
    "visible_offset": (4.0, 25.0),
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


def table(entries: list[dict[str, Any]]) -> list[str]:
    """A line for each variant: sums over all cells."""
    lines = ["| variant | collisions | entries | not faithful | frozen | index [m] | delay [s] | actions |"]
    lines.append("|" + " --- |" * 8)
    for variant in dict.fromkeys(entry["variant"] for entry in entries):
        rows = [entry for entry in entries if entry["variant"] == variant]
        total = {key: sum(row[key] for row in rows) for key in ("collisions", "entries", "frozen")}
        missed = sum(row["judged"] - row["faithful"] for row in rows)
        index = min(row["min_safety_index_m"] for row in rows if row["min_safety_index_m"] is not None)
        mean = {
            key: sum(row[key] * row["done"] for row in rows) / sum(row["done"] for row in rows)
            for key in ("mean_delay_s", "mean_actions")
        }
        lines.append(
            f"| {variant} | {total['collisions']} | {total['entries']} | {missed} | {total['frozen']} "
            f"| {index:.1f} | {mean['mean_delay_s']:.1f} | {mean['mean_actions']:.2f} |"
        )
    return lines


def main() -> None:
    """Run the study, and print its table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--count", type=int, default=20, help="encounters of each kind and variant")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--ruleset", action="append", help="tran2026 unless given; may be given again")
    parser.add_argument("--out", type=Path, default=Path("runs/weigh_roles"))
    given = parser.parse_args()
    sweep = study(given.count, given.seed, tuple(given.ruleset or ["tran2026"]))

    def tell(progress: Progress) -> None:
        done = progress.known + progress.done
        if done % 50 == 0 or done == progress.total:
            print(f"{done} of {progress.total}", file=sys.stderr)

    print("\n".join(table(cell_entries(run(sweep, given.out, program(), tell)))))


if __name__ == "__main__":
    main()
