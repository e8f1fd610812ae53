"""`ccas bench`: how fast this machine solves what ships ask, all solvers side by side in one run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from . import inputs, talk
from .exits import answered

if TYPE_CHECKING:
    from ccas_core.plugins import Plugins
    from ccas_core.sim.scenario import Profile, Scenario

VOYAGE: Final = "tran2026/fig_12"
UPDATES: Final = "tran2026/six_ships"
SCALE: Final = "100,1000,10000"
FEWEST_SHIPS, MOST_SHIPS = 10, 100_000


@answered
def bench(
    context: typer.Context,
    problems: Annotated[int, typer.Option(help="Local problems to solve with each solver.", min=10)] = 200,
    scale: Annotated[
        str, typer.Option(metavar="NUMBERS", help="Ships in the networks, with commas; 0 for none.")
    ] = SCALE,
    profile: Annotated[
        str,
        typer.Option(help="Of the ships in the networks: auto, crossing or head_on (the paper)."),
    ] = "auto",
    agreement: Annotated[
        int,
        typer.Option(
            metavar="NUMBER",
            help="Problems of all shipped scenarios, N = 30, 45, 60, to compare riccati with ipopt on.",
            min=0,
        ),
    ] = 0,
    picture: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the figures, as .png, .pdf or .svg.")
    ] = None,
    as_json: talk.AsJson = False,
) -> None:
    """Measure updates, voyages, growing networks, memory and start-up on this machine, side by side.

    Updates: local problems of the six-ship voyage of Table 2 (N = 45), each solved by every solver from the
    same start; only the solver call is timed. "All starts" is riccati from all of its starts against one
    start of ipopt. The voyage is that of Fig. 12. Networks: waterways with junctions at 0.5 ships a
    kilometre; one control period of 20 s with 3 iterations, from the reports to the rudder. Their ships
    weigh roles, as by default at sea; with --profile crossing they have the paper's controller for junctions.

    Example:
        ccas bench
        ccas bench --scale 100,1000 --picture bench.png
        ccas bench --agreement 2000 --scale 0 --json
    """
    sizes = _sizes(scale)
    chosen = _profile(profile)
    suffixes = (".png", ".pdf", ".svg")
    if picture is not None and (picture.suffix not in suffixes or not picture.absolute().parent.is_dir()):
        raise typer.BadParameter(
            f"got {str(picture)!r}; expected a .png, .pdf or .svg in a folder that exists"
        )
    from ccas_core.dmpc.solvers import SOLVERS

    from . import measuring

    plugins = inputs.load_plugins(context)
    solvers = {name: inputs.ready_solver(name) for name in sorted(SOLVERS)}
    fast = solvers[measuring.FAST]
    result: dict[str, Any] = {"machine": measuring.machine(), "start_up": measuring.start_up()}
    talk.note(f"recording local problems of {UPDATES}")
    tasks = measuring.recorded(inputs.read_scenario(UPDATES, plugins), plugins, fast, problems)
    talk.note(f"solving {len(tasks)} problems with each of {', '.join(solvers)}")
    result["update"] = measuring.updates(tasks, solvers)
    result["voyage"] = {"scenario": VOYAGE}
    for name, solver in solvers.items():
        talk.note(f"sailing {VOYAGE} with {name}")
        seconds = measuring.sailed(inputs.read_scenario(VOYAGE, plugins), plugins, solver)
        result["voyage"][name] = {"seconds": seconds}
    if agreement:
        talk.note(f"recording {agreement} problems or more of all shipped scenarios, and solving them")
        result["agreement"] = []
        for row in measuring.agreement(_shipped(plugins), plugins, solvers, agreement):
            result["agreement"].append(row)
            talk.note(f"N = {row['horizon']}: {row['problems']} problems, {row['worse']} worse")
    result["scale"] = []
    for found in measuring.scale(sizes, plugins, fast, profile=chosen):
        result["scale"].append(found)
        talk.note(f"{found['ships']} ships: {found['seconds']:.2f} s a period")
    result["growth"] = _growth(result["scale"], "seconds")
    result["cpu_growth"] = _growth(result["scale"], "cpu_seconds")
    result["peak_memory_mib"] = measuring.peak_memory()
    if picture is not None:
        from ccas_core.sim.bench_drawing import draw_bench

        draw_bench(result, picture)
        talk.note(f"picture: {picture}")
    del result["update"]["times_ms"]
    if as_json:
        talk.show_json(result)
    else:
        _show(result)


def _sizes(text: str) -> list[int]:
    """Numbers of ships, growing."""
    try:
        sizes = sorted({int(part) for part in text.split(",")} - {0})
    except ValueError:
        sizes = [-1]
    if any(not FEWEST_SHIPS <= size <= MOST_SHIPS for size in sizes):
        expected = f"numbers from {FEWEST_SHIPS} to {MOST_SHIPS} with commas, such as {SCALE}; or 0"
        raise typer.BadParameter(f"got {text!r}; expected {expected}")
    return sizes


def _profile(name: str) -> Profile:
    from ccas_core.sim.scenario import Profile

    known = [each.value for each in Profile]
    if name not in known:
        raise typer.BadParameter(f"--profile: got {name!r}; expected one of {', '.join(known)}")
    return Profile(name)


def _shipped(plugins: Plugins) -> list[Scenario]:
    """All scenarios that come with the program; sweeps, which lie beside them, are none."""
    from ccas_scenarios import names

    return [inputs.read_scenario(name, plugins) for name in names() if not name.startswith("sweeps/")]


def _growth(scale: Sequence[Mapping[str, Any]], key: str) -> float | None:
    """Cost of a ship in the largest network over that in the smallest."""
    if len(scale) < 2:
        return None
    smallest, largest = (row[key] / row["ships"] for row in (scale[0], scale[-1]))
    return float(largest / smallest)


# --- text --------------------------------------------------------------------------------------


def _show(result: Mapping[str, Any]) -> None:
    talk.show("machine: " + ", ".join(f"{key} {value}" for key, value in result["machine"].items()))
    memory = result["peak_memory_mib"]
    talk.show(
        f"start-up: ccas --help {result['start_up']['help_seconds']:.2f} s (least of 5)"
        + (f"; peak memory of this run: {memory:.0f} MiB" if memory else "")
    )
    _show_updates(result["update"], result["voyage"])
    if "agreement" in result:
        _show_agreement(result["agreement"])
    if result["scale"]:
        _show_scale(result["scale"], result["growth"], result["cpu_growth"])


def _show_updates(update: Mapping[str, Any], voyage: Mapping[str, Any]) -> None:
    rows = [
        (
            name,
            f"{figures['median_ms']:.2f}",
            f"{figures['p99_ms']:.2f}",
            f"{figures['max_ms']:.2f}",
            f"{figures['speed_up_median']:.1f}",
            f"{100.0 * figures['usable_share']:.1f} %",
            *(str(figures[key]) for key in ("same", "better", "worse")),
            f"{voyage[name]['seconds']:.1f}",
        )
        for name, figures in update["solvers"].items()
    ]
    talk.show(
        f"\n{update['problems']} updates of {UPDATES}, N = 45, one start each, "
        f"against {update['reference']}; voyage {VOYAGE}"
    )
    talk.show_table(
        ("solver", ">median [ms]", ">p99 [ms]", ">max [ms]", ">times faster", ">converged", ">same optimum",
         ">better", ">worse", ">voyage [s]"),
        rows,
    )  # fmt: skip
    talk.show(
        f"{update['solver']} from all starts, with everything around it: "
        f"median {update['median_ms']:.2f} ms, p99 {update['p99_ms']:.2f} ms, "
        f"{update['speed_up_all_starts_median']:.1f} times faster than one start of {update['reference']}, "
        f"not worse in {100.0 * update['not_worse_share']:.1f} %"
    )


def _show_agreement(rows: Sequence[Mapping[str, Any]]) -> None:
    count = sum(row["problems"] for row in rows)
    talk.show(f"\n{count} problems of all shipped scenarios, riccati against ipopt from the same starts")
    table = []
    for row in rows:
        for starts, figures in (("of the voyage", row), ("all", row["all_starts"])):
            table.append(
                (
                    str(row["horizon"]),
                    starts,
                    str(figures["compared"]),
                    *(str(figures[key]) for key in ("same", "better", "worse")),
                    f"{100.0 * figures['not_worse_share']:.2f} %",
                    f"{figures['worst_gap']:.1e}",
                    str(row["outside_bounds"]),
                )
            )
    talk.show_table(
        (">N", "starts", ">compared", ">same optimum", ">better", ">worse", ">not worse", ">worst gap",
         ">outside bounds"),
        table,
    )  # fmt: skip


def _show_scale(rows: Sequence[Mapping[str, Any]], growth: float | None, cpu_growth: float | None) -> None:
    talk.show(f"\nnetworks, one control period of 20 s, 3 iterations, profile {rows[0]['profile']}")
    talk.show_table(
        (">ships", ">period [s]", ">a ship [ms]", ">CPU [s]", ">first period [s]", ">encounters",
         ">generations", ">fallbacks", ">peak memory [MiB]"),
        [
            (
                str(row["ships"]),
                f"{row['seconds']:.2f}",
                f"{row['cost_per_ship_ms']:.2f}",
                f"{row['cpu_seconds']:.2f}",
                f"{row['first_seconds']:.2f}",
                str(row["encounters"]),
                str(row["generations"]),
                str(row["fallbacks"]),
                f"{row['peak_memory_mib']:.0f}" if row["peak_memory_mib"] else "-",
            )
            for row in rows
        ],
    )  # fmt: skip
    if growth is not None:
        talk.show(
            f"a ship costs {growth:.2f} times as much in the largest network as in the smallest "
            f"(CPU: {cpu_growth:.2f})"
        )
