"""Pictures of a voyage, as the paper's Fig. 5 to 14; `chart` says what they show, `drawing` how it looks.

Functions of a scenario and its frames that return a figure; `draw_run` alone writes.  matplotlib is
imported inside functions, without `pyplot` and its global state.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from ..frames import FloatArray
from ..ships import ShipId
from .chart import (
    PAGE,
    Label,
    Sailed,
    Scene,
    Style,
    duties,
    frame_at,
    framed,
    grid,
    page_size,
    points,
    safety_series,
    sailed,
    scene,
    signal,
    style,
)
from .domain_plotting import steered
from .drawing import (
    LARGE,
    NORMAL,
    SMALL,
    arrows,
    below,
    beside,
    chart_names,
    dress,
    dress_chart,
    hull,
    line,
    sail,
    samples,
    settle,
    water,
)
from .frame import Frame
from .page import NAMED, blank, charts, explain, letter, name_outside
from .scenario import Scenario

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase

TALLEST: Final = 9.6  # height of a figure [in]
CHART_TALLEST: Final = 7.2  # of one chart alone [in]
DIAGRAMS: Final = 3.1  # of the diagrams below composed charts [in]
LOWEST: Final = 6  # ships that are named in the safety index where there are more
DOTS: Final = 150  # per inch of a picture that is written
LEAST_RESIDUAL: Final = 1e-6  # residuals below are drawn there [m]
INDEX_SHOWN: Final = 300.0  # least top of the safety index, so that what happens near zero is seen [m]
LEAST_OFFSETS: Final = 10.0  # span of the offsets at least, so that noise looks like noise [m]


def paths(
    scenario: Scenario, frames: Sequence[Frame], times: Sequence[float] | None = None, title: str = ""
) -> Figure:
    """Draw the chart with all tracks, and the ships to scale at some instants (Fig. 5, 6)."""
    shown = scene(scenario, frames, times)
    figure = blank(*page_size(shown.view, 1, 1, CHART_TALLEST))
    axes = figure.subplots()
    labels = _tracks(axes, shown, shown.times, timed=True)
    dress_chart(axes, shown.view)
    axes.set(**dict(zip(("xlabel", "ylabel"), chart_names(shown.view), strict=True)))
    many = f" ({len(shown.ships)} ships)" if len(shown.ships) > NAMED else ""
    axes.set_title((title or scenario.title or scenario.name) + many, fontsize=LARGE, loc="left")
    explain(figure, shown)
    settle(figure, [(axes, labels)])
    return figure


def snapshots(scenario: Scenario, frames: Sequence[Frame], times: Sequence[float] | None = None) -> Figure:
    """Draw a panel an instant, with trails and with arrows from who gives way (Fig. 10 (a) to (d))."""
    shown = scene(scenario, frames, times)
    columns, rows = grid(len(shown.times), shown.view, TALLEST)
    figure = blank(*page_size(shown.view, columns, rows, TALLEST))
    labels = _instants(figure, charts(figure, columns, rows), columns, shown)
    settle(figure, labels)
    return figure


def signals(scenario: Scenario, frames: Sequence[Frame]) -> Figure:
    """Draw commanded offset, actual offset and speed factor of every ship over time."""
    figure = blank(PAGE, 5.6)
    ships = sailed(scenario, frames)
    upper, middle, lower = figure.subplots(3, 1, sharex=True)
    _offset_commands(upper, frames, ships)
    upper.set_title("offsets to starboard are positive", fontsize=SMALL, loc="right")
    _draw_each(middle, ships, {ship.id: signal(frames, ship.id, "path_y") for ship in ships})
    middle.axhline(0.0, color="0.6", linewidth=0.6, zorder=0)
    dress(middle, "", "actual\noffset [m]", least=LEAST_OFFSETS)
    _speed_factors(lower, frames, ships)
    for axes in (upper, middle):
        axes.tick_params(labelbottom=False)
    if 0 < len(ships) <= NAMED:
        below(figure, samples(ships))
    else:
        figure.suptitle(f"{len(ships)} ships", fontsize=LARGE)
    return figure


def safety_index(scenario: Scenario, frames: Sequence[Frame]) -> Figure:
    """Draw the safety index of every ship over time (Fig. 10 (e)); at or below zero a collision is likely."""
    figure = blank(PAGE, 3.4)
    _index(figure.subplots(), scenario, frames, above=True)
    return figure


def fleet(scenario: Scenario, frames: Sequence[Frame], times: Sequence[float] | None = None) -> Figure:
    """Compose a page: instants (a) to (d), safety index (e), offset (f) and speed (g) (Fig. 10 to 14)."""
    shown = scene(scenario, frames, times)
    columns, rows = grid(len(shown.times), shown.view, TALLEST - DIAGRAMS)
    _, height = page_size(shown.view, columns, rows, TALLEST - DIAGRAMS)
    figure = blank(PAGE, height + DIAGRAMS)
    upper, lower = figure.subfigures(2, 1, squeeze=False, height_ratios=(height, DIAGRAMS))[:, 0]
    labels = _instants(upper, charts(upper, columns, rows), columns, shown)
    diagrams = lower.subplot_mosaic([["e", "f"], ["e", "g"]], sharex=True)
    _index(diagrams["e"], scenario, frames, above=False)
    _offset_commands(diagrams["f"], frames, shown.ships)
    _speed_factors(diagrams["g"], frames, shown.ships)
    diagrams["f"].tick_params(labelbottom=False)
    for number, key in enumerate("efg", start=max(len(shown.times), 1)):
        diagrams[key].set_title(letter(number), fontsize=NORMAL, loc="left")
    settle(figure, labels)
    return figure


def residuals(runs: Mapping[int, Sequence[Frame]]) -> Figure:
    """Draw how far broadcast and planned trajectories differ, a line for each iter_max (Fig. 8).

    It is the greatest difference of all ships after the last iteration of each update.
    """
    figure = blank(PAGE, 3.4)
    axes = figure.subplots()
    axes.set_yscale("log")
    for number, (iterations, frames) in enumerate(sorted(runs.items())):
        last = [
            (frame.time, [ship.residuals[-1] for ship in frame.ships.values() if ship.residuals])
            for frame in frames
        ]
        rows = [(time, max(LEAST_RESIDUAL, *of_ships)) for time, of_ships in last if of_ships]
        name = f"{iterations} iteration" + "s" * (iterations != 1)
        line(axes, np.array(rows, dtype=np.float64).reshape(-1, 2), style(number), label=name)
    dress(axes, "time [s]", "greatest difference of broadcast\nand planned positions [m]")
    if runs:
        axes.legend(fontsize=SMALL, frameon=False, handlelength=2.8)
    return figure


def compare(
    panels: Sequence[tuple[str, Scenario, Sequence[Frame]]], times: Sequence[float] | None = None
) -> Figure:
    """Draw the paths of several runs side by side, all in one view (Fig. 7, 9), hulls at `times` [s]."""
    if not panels:
        return blank(PAGE, 2.0)
    shown = [scene(scenario, frames, times) for _, scenario, frames in panels]
    every = [points(each.scenario, each.frames, each.ships, each.times) for each in shown]
    view = framed(panels[0][1], np.vstack(every))
    columns, rows = grid(len(panels), view, TALLEST)
    if len(panels) > 4:  # many small ones, as in Fig. 7
        view = framed(panels[0][1], np.vstack(every), ratio=1.6)
        columns, rows = 3, math.ceil(len(panels) / 3)
    figure = blank(*page_size(view, columns, rows, TALLEST))
    drawn = charts(figure, columns, rows)
    for number, (chart, each, (label, _, _)) in enumerate(zip(drawn, shown, panels, strict=False)):
        _tracks(chart, each, each.times)
        chart.set_title(f"{letter(number)} {label}", fontsize=NORMAL, loc="left")
        dress_chart(chart, view)
    name_outside(figure, drawn, columns, len(panels), view)
    explain(figure, shown[0])
    return figure


def draw_run(scenario: Scenario, frames: Sequence[Frame], folder: Path) -> tuple[Path, ...]:
    """Write the pictures of a run into its folder: the same frames give the same bytes."""
    pictures: dict[str, Callable[[Scenario, Sequence[Frame]], Figure]] = {
        "paths.png": paths,
        "signals.png": signals,
        "safety_index.png": safety_index,
        "snapshots.png": snapshots,
    }
    if any(ship.motion is not None for frame in frames[:1] for ship in frame.ships.values()):
        pictures["steered.png"] = steered
    folder.mkdir(parents=True, exist_ok=True)
    for name, picture in pictures.items():
        picture(scenario, frames).savefig(folder / name, dpi=DOTS, metadata={"Software": None})
    return tuple(folder / name for name in pictures)


# --- panels ------------------------------------------------------------------------------------


def _tracks(axes: Axes, shown: Scene, times: Sequence[float], *, timed: bool = False) -> list[Label]:
    """Draw tracks and, at these instants, the ships; hand back the labels."""
    labels = water(axes, shown.scenario.waters, shown.view)
    for ship in shown.ships:
        sail(axes, ship, ship.track.poses)
        under_way = [time for time in times if len(ship.at(time))]
        for time in under_way:
            hull(axes, ship, time)
            name = [ship.name] if time == under_way[0] else []
            if timed and len(shown.ships) <= NAMED:
                text = ", ".join([*name, f"{time:.0f} s"])
                labels.append(beside(ship, time, text, keep=bool(name)))
    return labels


def _instants(
    figure: FigureBase, panels: Sequence[Axes], columns: int, shown: Scene
) -> list[tuple[Axes, list[Label]]]:
    """Draw a panel an instant; hand back the labels of each."""
    written: list[tuple[Axes, list[Label]]] = []
    named = len(shown.ships) <= NAMED
    for panel, time in zip(panels, shown.times or (0.0,), strict=False):
        labels = water(panel, shown.scenario.waters, shown.view)
        for ship in shown.ships:
            hull(panel, ship, time)
            if named:
                sail(panel, ship, ship.between(ship.track.times[0], time))
            if named and len(ship.at(time)):
                labels.append(beside(ship, time, ship.name, keep=True))
        if named:
            labels += arrows(panel, shown.ships, duties(shown.frames, time), time, shown.view)
        frame = frame_at(shown.frames, time)
        opened = ", deadlock opened" if frame and frame.openings else ""
        panel.set_title(f"{letter(len(written))} {time:.0f} s{opened}", fontsize=NORMAL, loc="left")
        dress_chart(panel, shown.view)
        written.append((panel, labels))
    name_outside(figure, panels, columns, len(written), shown.view)
    explain(figure, shown)
    return written


def _offset_commands(axes: Axes, frames: Sequence[Frame], ships: Sequence[Sailed]) -> None:
    series = {ship.id: signal(frames, ship.id, "offset", commands=True) for ship in ships}
    _draw_each(axes, ships, series, steps=True)
    axes.axhline(0.0, color="0.6", linewidth=0.6, zorder=0)
    dress(axes, "", "commanded\noffset $u^y$ [m]", least=LEAST_OFFSETS)


def _speed_factors(axes: Axes, frames: Sequence[Frame], ships: Sequence[Sailed]) -> None:
    """Draw speed factors; where all ships have one nominal speed, the speed stands on the right."""
    series = {ship.id: signal(frames, ship.id, "speed_factor", commands=True) for ship in ships}
    _draw_each(axes, ships, series, steps=True)
    dress(axes, "time [s]", "speed\nfactor $u^s$ [-]")
    axes.set_ylim(-0.05, 1.08)
    nominal = {ship.speed for ship in ships}
    if len(nominal) == 1:
        speed = nominal.pop()
        scales = (lambda u: np.multiply(u, speed), lambda v: np.divide(v, speed))
        right = axes.secondary_yaxis("right", functions=scales)
        right.set_ylabel("speed [m/s]", fontsize=NORMAL)
        right.tick_params(labelsize=SMALL)


def _index(axes: Axes, scenario: Scenario, frames: Sequence[Frame], *, above: bool) -> None:
    series = safety_series(scenario, frames)
    least = {id_: float(each[:, 1].min()) for id_, each in series.items()}
    named = sorted(least, key=lambda id_: (least[id_], id_))
    styles: dict[ShipId, Style] = {}
    if len(named) > NAMED:  # styles of ships so far apart in the scenario may be the same
        named = named[:LOWEST]
        styles = {id_: style(number) for number, id_ in enumerate(named)}
    for ship in sailed(scenario, frames):
        if ship.id in named:
            label = f"{ship.name}: min {least[ship.id]:.1f} m"
            line(axes, series[ship.id], styles.get(ship.id, ship.style), label=label)
        elif ship.id in least:
            line(axes, series[ship.id], Style("0.8", ()), width=0.7, zorder=2.0)
    axes.axhline(0.0, color="black", linewidth=0.8)
    dress(axes, "time [s]", "safety index $\\epsilon$ [m]")
    if not named:
        axes.set_title("no two ships under way", fontsize=SMALL, loc="right")
        return
    most = max(float(each[:, 1].max()) for each in series.values())
    low, top = min(0.0, *least.values()), max(INDEX_SHOWN, 3.0 * max(least[id_] for id_ in named))
    top = max(min(most, top), 1.0)
    axes.set_ylim(low - 0.06 * (top - low), top + 0.04 * (top - low))
    axes.legend(
        loc="lower right" if above else "upper right",
        bbox_to_anchor=(1.0, 1.0),
        borderaxespad=0.2,
        ncols=4 if above else 1,
        columnspacing=1.2,
        handlelength=2.4,
        fontsize=SMALL,
        edgecolor="none",
    )


def _draw_each(
    axes: Axes, ships: Sequence[Sailed], series: Mapping[ShipId, FloatArray], *, steps: bool = False
) -> None:
    width = 1.3 if len(ships) <= NAMED else 0.7
    for ship in ships:
        line(axes, series[ship.id], ship.style, label=ship.name, width=width, steps=steps)
