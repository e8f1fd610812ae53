"""How much should a role weigh?  Safety, faithfulness, delay and actions for each parameter of the roles.

One parameter is changed at a time; `default` is what is shipped.  The study goes on where it was stopped:

    python studies/weigh_roles.py --count 25 --out runs/weigh_roles --picture docs/pictures/weigh_roles.png

Each variant sails the same drawn encounters: risky ones of two ships, crossings beside a ship that ignores
its duty, and groups: with `--count 25`, 105 cases a variant.  docs/parameters.md has table and picture.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from ccas_core.agent.events import Conduct
from ccas_core.sim.drawing import NORMAL, SMALL, dress
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
    "patience": (4.0, 16.0),
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
COUNTS: Final = ("collisions", "entries", "unfaithful", "frozen", "restless")


def sums(entries: list[dict[str, Any]]) -> dict[str, dict[str, float]]:
    """Sums, the least safety index and means over all cells, for each variant."""
    found = {}
    for variant in dict.fromkeys(entry["variant"] for entry in entries):
        rows = [entry for entry in entries if entry["variant"] == variant]
        rows = [{**row, "unfaithful": row["judged"] - row["faithful"]} for row in rows]
        found[variant] = {
            **{key: sum(row[key] for row in rows) for key in COUNTS},
            "index": min(row["min_safety_index_m"] for row in rows if row["min_safety_index_m"] is not None),
            "delay": mean(rows, "mean_delay_s"),
            "stand_on": mean(rows, "mean_stand_on_delay_share"),
            "actions": mean(rows, "mean_actions"),
        }
    return found


def table(found: Mapping[str, Mapping[str, float]]) -> list[str]:
    """A line for each variant."""
    lines = [f"| {' | '.join(HEAD)} |", "|" + " --- |" * len(HEAD)]
    for variant, each in found.items():
        told = [variant, *(f"{each[key]:.0f}" for key in COUNTS), f"{each['index']:.1f}"]
        told += [f"{each['delay']:.1f}", f"{each['stand_on']:.3%}", f"{each['actions']:.2f}"]
        lines.append(f"| {' | '.join(told)} |")
    return lines


def draw(found: Mapping[str, Mapping[str, float]], file: Path) -> None:
    """Draw safety, faithfulness, delay and actions, a row for each variant; the default as a line."""
    from matplotlib.figure import Figure

    panels = (
        ("index", "least safety index [m]"),
        ("unfaithful", "encounters not faithful"),
        ("delay", "mean delay of a ship [s]"),
        ("actions", "actions of a ship"),
    )
    rows = [variant for variant in found if variant != "default"]
    figure = Figure(figsize=(9.6, 4.6), layout="constrained")
    for axes, (key, title) in zip(figure.subplots(1, len(panels), sharey=True), panels, strict=True):
        axes.axvline(found["default"][key], color="#7A7A7A", linewidth=1.0)
        for n, variant in enumerate(rows):
            each = found[variant]
            unsafe = each["entries"] > 0
            axes.plot(each[key], n, "X" if unsafe else "o", color="#C8501E" if unsafe else "#3B6FB6")
        dress(axes, title, "")
        axes.margins(x=0.12)
    axes.set_yticks(range(len(rows)), rows, fontsize=SMALL)
    axes.invert_yaxis()
    figure.suptitle(
        "one parameter changed at a time; line: the default; crosses: safety areas entered", fontsize=NORMAL
    )
    figure.savefig(file, dpi=110)


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
    parser.add_argument("--picture", type=Path, help="draw the table into this file")
    given = parser.parse_args()
    sweep = study(given.count, given.seed, tuple(given.ruleset or ["tran2026"]))
    sweep = replace(sweep, executor=given.executor)

    def tell(progress: Progress) -> None:
        done = progress.known + progress.done
        if done % 50 == 0 or done == progress.total:
            print(f"{done} of {progress.total}", file=sys.stderr)

    found = sums(cell_entries(run(sweep, given.out, program(), tell)))
    print("\n".join(table(found)))
    if given.picture:
        draw(found, given.picture)


if __name__ == "__main__":
    main()
