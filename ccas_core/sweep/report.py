"""Report of a sweep: one HTML file that needs nothing else, with the pictures of the worst cases."""

from __future__ import annotations

import base64
import html
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from ..sim.plotting import draw_run
from ..sim.run_folder import explained
from ..tapd.ruleset import AbstractRuleset
from .case import sail, scenario
from .spec import Sweep
from .tally import CONFIDENCE, Result, worst
from .task import solver
from .workers import Status

FILE: Final = "report.html"
PICTURED: Final = 6  # worst cases that are sailed again for their pictures
LISTED: Final = 200
NOTHING: Final = "-"  # where a number is not defined
_PAIRINGS_NOTE: Final = (
    "<p>The same encounters for all.  In brackets: how many of them the first ship alone, acting from the "
    "start, could have avoided.  Delays and distances from their lines are sums of both ships.</p>"
)
PAIRINGS: Final = (
    "ships",
    "ruleset",
    "n",
    "collisions",
    "entries",
    "frozen",
    "least clearance [m]",
    "mean delay [s]",
    "mean distance aside [m]",
)

_STYLE: Final = """
body { font: 15px/1.45 system-ui, sans-serif; color: #1b2a34;
       max-width: 76rem; margin: 2rem auto; padding: 0 1rem }
h1 { font-size: 1.5rem } h2 { font-size: 1.15rem; margin-top: 2.2rem }
table { border-collapse: collapse; font-variant-numeric: tabular-nums }
th, td { padding: .25rem .6rem; border-bottom: 1px solid #d8dee2; text-align: right }
th { border-bottom: 2px solid #8a979f; font-weight: 600 } td:first-child, th:first-child { text-align: left }
td.bad { background: #fbe3dc } code { background: #eef1f3; padding: 0 .25rem }
img { max-width: 100%; border: 1px solid #d8dee2; margin: .4rem 0 }
p.note { color: #51626d }
"""


def write_report(
    sweep: Sweep,
    results: Sequence[Result],
    found: Mapping[str, Any],
    folder: Path,
    rulesets: Mapping[str, AbstractRuleset],
) -> Path:
    """Write the report of a sweep into its folder."""
    parts = [
        f"<h1>{_text(sweep.title or sweep.name)}</h1>",
        f"<p>Sweep <code>{_text(sweep.name)}</code>, seed {sweep.seed}, {len(results)} cases.</p>",
        "<h2>Counts</h2>",
        _counts(found["cells"]),
        "<h2>Rates</h2>",
        f"<p class=note>Upper bounds are one-sided, at a confidence of {CONFIDENCE:.0%}.</p>",
        _rates(found["cells"]),
        *_laws(found["cells"]),
        *_mixed(found["mixed"]),
        "<h2>Cases with a fault</h2>",
        *_faulty(results),
        *_jointly(found["price"], found["jointly"]),
        *_pictures(results, rulesets),
    ]
    page = (
        "<!doctype html><html lang=en><meta charset=utf-8>"
        f"<title>{_text(sweep.name)}</title><style>{_STYLE}</style><body>{''.join(parts)}</body></html>\n"
    )
    file = folder / FILE
    with explained(file):
        file.write_text(page, encoding="utf-8", newline="\n")
    return file


def _text(value: object) -> str:
    return html.escape(str(value))


def _table(head: Sequence[str], rows: Iterable[Sequence[tuple[str, bool]]]) -> str:
    """Table of texts, each marked bad or not."""
    body = "".join(
        "<tr>"
        + "".join(f"<td{' class=bad' if bad else ''}>{_text(text)}</td>" for text, bad in row)
        + "</tr>"
        for row in rows
    )
    return f"<table><tr>{''.join(f'<th>{_text(each)}</th>' for each in head)}</tr>{body}</table>"


def _named(cell: Mapping[str, Any]) -> list[tuple[str, bool]]:
    name = f"{cell['name']} ({cell['variant']})" if cell["variant"] else cell["name"]
    return [(name, False), (cell["ruleset"], False)]


def _counts(cells: Sequence[Mapping[str, Any]]) -> str:
    head = ("cell", "ruleset", "n", "not done", "risky", "judged", "faithful", "calm", "calm, acted")
    marks = ("collisions", "entries", "groundings", "frozen")
    alone = ("avoidable alone", "of these, collisions")
    rows = []
    for cell in cells:
        row = _named(cell)
        row += [(str(cell["n"]), False), (str(cell["n"] - cell["done"]), cell["n"] > cell["done"])]
        row += [(str(cell[key]), False) for key in ("risky", "judged")]
        row += [(str(cell["faithful"]), cell["faithful"] < cell["judged"]), (str(cell["calm"]), False)]
        row += [(str(cell[key]), cell[key] > 0) for key in ("calm_acted", *marks)]
        row += [(str(cell["avoidable"]), False)]
        row += [(str(cell["avoidable_collisions"]), cell["avoidable_collisions"] > 0)]
        rows.append(row)
    return _table((*head, *marks, *alone), rows)


def _rates(cells: Sequence[Mapping[str, Any]]) -> str:
    head = (
        "cell",
        "ruleset",
        "cases with a collision, upper bound",
        "faithful",
        "calm, acted",
        "least safety index [m]",
        "mean delay [s]",
        "delay of ships that stand on",
        "most changes of mind",
        "restless ships",
    )

    def share(part: float, whole: float) -> str:
        return f"{part / whole:.2%}" if whole else NOTHING

    def number(value: float | None, form: str) -> str:
        return NOTHING if value is None else format(value, form)

    return _table(
        head,
        (
            [
                *_named(cell),
                (number(cell["collision_rate_upper"], ".2%"), False),
                (share(cell["faithful"], cell["judged"]), False),
                (share(cell["calm_acted"], cell["calm"]), False),
                (number(cell["min_safety_index_m"], ".1f"), False),
                (number(cell["mean_delay_s"], ".1f"), False),
                (number(cell["mean_stand_on_delay_share"], ".3%"), False),
                (str(cell["most_changes_of_mind"]), False),
                (str(cell["restless"]), cell["restless"] > 0),
            ]
            for cell in cells
        ),
    )


def _laws(cells: Sequence[Mapping[str, Any]]) -> list[str]:
    """What the logs say of laws, of cells with a border."""
    counted = [cell for cell in cells if cell["laws"]]
    if not counted:
        return []
    bad = {
        "two_laws": "two laws, no fall-back",
        "both_stand_on": "both stand on",
        "law_changes": "law changed within an encounter",
        "flaps": "flaps",
    }
    good = {"decisions": "decisions", "switches": "ships that went over", "fallbacks": "fall-backs"}
    rows = [
        [
            *_named(cell),
            *((str(cell["laws"][key]), False) for key in good),
            *((str(cell["laws"][key]), cell["laws"][key] > 0) for key in bad),
        ]
        for cell in counted
    ]
    note = "<p class=note>A decision is a pair of ships in a period, as the log has it.</p>"
    return ["<h2>Laws</h2>", note, _table(("cell", "ruleset", *good.values(), *bad.values()), rows)]


def _mixed(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Pairings of ships that do not all negotiate, side by side."""
    if not rows:
        return []

    def number(value: float | None) -> str:
        return NOTHING if value is None else f"{value:.1f}"

    told = [
        [
            (row["pairing"], False),
            (row["ruleset"], False),
            (str(row["n"]), False),
            (f"{row['collisions']} ({row['avoidable_collisions']})", row["avoidable_collisions"] > 0),
            (f"{row['entries']} ({row['avoidable_entries']})", row["avoidable_entries"] > 0),
            (str(row["frozen"]), row["frozen"] > 0),
            *((number(row[key]), False) for key in ("min_clearance", "delay", "aside")),
        ]
        for row in rows
    ]
    return [
        "<h2>Who steers the two ships</h2>",
        _PAIRINGS_NOTE,
        _table(PAIRINGS, told),
    ]


def _faulty(results: Sequence[Result]) -> list[str]:
    found = worst(results)
    if not found:
        return ["<p>None.</p>"]
    rows = []
    for each, what in found[:LISTED]:
        clearance = each.kept.get("min_clearance_m")
        said = each.kept.get("why", "")
        shown = NOTHING if clearance is None else f"{clearance:.1f}"
        rows.append([(each.case.name, False), (", ".join(what), False), (shown, False), (said, False)])
    more = len(found) - LISTED
    command = f"ccas simulate worst/NAME.yaml --solver {_text(found[0][0].case.solver)}"
    return [
        f"<p>Sail one again with <code>{command}</code> from this folder.</p>",
        _table(("case", "faults", "least clearance [m]", "what was said"), rows),
        f"<p>And {more} more, in <code>cases.csv</code>.</p>" if more > 0 else "",
    ]


def _jointly(price: Mapping[str, Any], compared: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Groups beside the centralised baseline."""
    if not compared:
        return []
    rows = [
        [
            (name, False),
            ("yes" if each["free"] else "no", not each["free"]),
            (f"{each['joint_cost']:.1f}", False),
            (f"{each['sailed_cost']:.1f}", False),
            ("yes" if each["converged"] else "no", not each["converged"]),
        ]
        for name, each in compared.items()
        if "joint_cost" in each
    ]
    rows += [
        [(name, False), (each["why"], True), *[(NOTHING, False)] * 3]
        for name, each in compared.items()
        if "joint_cost" not in each
    ]
    told = f"{price['solved']} of {price['compared']} cases were solved; {price['free']} have a free answer."
    if price["costly"]:
        times = (
            f"{price['dearer_median']:.2f} times as much at the median, {price['dearer_p90']:.2f} times at"
        )
        means = f"{price['mean_sailed_cost']:.1f} against {price['mean_joint_cost']:.1f}"
        told += (
            f" In {price['costly']} the joint optimum costs something; what the ships sailed costs {times}"
            f" the 90th percentile; over all, {means}."
        )
    return [
        "<h2>The price of being distributed</h2>",
        "<p class=note>One mind steers all ships: all costs over one horizon, every control free.</p>",
        f"<p>{_text(told)}</p>",
        _table(("case", "a free answer exists", "joint cost", "cost as sailed", "converged"), rows),
    ]


def _pictures(results: Sequence[Result], rulesets: Mapping[str, AbstractRuleset]) -> list[str]:
    parts = []
    shown = [(each, what) for each, what in worst(results) if each.status is Status.DONE][:PICTURED]
    for each, what in shown:
        sailed = scenario(each.case, rulesets)
        frames, _ = sail(sailed, rulesets, solver(each.case.solver))
        parts.append(f"<h2>{_text(each.case.name)}: {_text(', '.join(what))}</h2>")
        with tempfile.TemporaryDirectory() as folder:
            for picture in draw_run(sailed, frames, Path(folder)):
                data = base64.b64encode(picture.read_bytes()).decode("ascii")
                parts.append(f'<img alt="{_text(picture.stem)}" src="data:image/png;base64,{data}">')
    return parts
