"""The picture of `ccas bench`: how long updates take, and what a ship costs as the network grows."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from .drawing import LARGE, NORMAL, SMALL, dress

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLOURS: Final = {"ipopt": "#7A7A7A", "fatrop": "#3B6FB6", "riccati": "#C8501E", "all_starts": "#E39B3B"}
_NAMES: Final = {"all_starts": "riccati, all starts"}
_DOTS: Final = 150  # per inch


def draw_bench(result: Mapping[str, Any], file: Path) -> None:
    """Draw the figures of a run, with the times of single updates, into a file."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    _updates(left, result["update"])
    _scale(right, result["scale"])
    machine = result["machine"]
    figure.suptitle(
        f"{machine['cores']} cores, Python {machine['python']}, casadi {machine['casadi']}, "
        f"numba {machine['numba']}",
        fontsize=SMALL,
    )
    figure.savefig(file, dpi=_DOTS)


def _updates(axes: Axes, update: Mapping[str, Any]) -> None:
    """Share of the updates that are done within a time, a step a solver."""
    for name, times in update["times_ms"].items():
        sorted_times = np.sort(times)
        shares = 100.0 * np.arange(1, len(times) + 1) / len(times)
        axes.step(sorted_times, shares, where="post", color=_COLOURS.get(name), linewidth=1.3)
        axes.annotate(
            f"{_NAMES.get(name, name)}\n{np.median(times):.2g} ms",
            (float(np.median(times)), 50.0),
            textcoords="offset points",
            xytext=(5.0, -14.0 if name == "fatrop" else 8.0),
            fontsize=SMALL,
            color=_COLOURS.get(name),
        )
    axes.set_xscale("log")
    axes.set_title(f"{update['problems']} updates, six ships, N = 45", fontsize=LARGE)
    dress(axes, "time of a solver call [ms]", "updates done [%]")


def _scale(axes: Axes, scale: list[Mapping[str, Any]]) -> None:
    """Cost of a ship over the number of ships, with the room for growth."""
    axes.set_title("one control period, 3 iterations, 0.5 ships a kilometre", fontsize=LARGE)
    if not scale:
        axes.text(0.5, 0.5, "not measured", transform=axes.transAxes, ha="center", fontsize=NORMAL)
        return
    ships = [row["ships"] for row in scale]
    costs = [row["cost_per_ship_ms"] for row in scale]
    axes.axhspan(costs[0], 1.3 * costs[0], color="0.93", label="up to 1.3 times the smallest")
    axes.plot(ships, costs, color=_COLOURS["riccati"], marker="o", linewidth=1.3)
    for row in scale:
        axes.annotate(
            f"{row['seconds']:.2g} s",
            (row["ships"], row["cost_per_ship_ms"]),
            textcoords="offset points",
            xytext=(0.0, -14.0),
            ha="center",
            fontsize=SMALL,
        )
    axes.set_xscale("log")
    axes.set_ylim(0.0, 1.5 * max(costs))
    axes.margins(x=0.12)
    axes.legend(fontsize=SMALL, frameon=False, loc="lower right")
    dress(axes, "ships", "wall time a ship [ms]")
