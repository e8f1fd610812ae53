"""A small picture of ships that show a fault: hulls to scale, where they go, what each makes of the other."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from ..frames import FloatArray
from ..sim.chart import COLOURS, Label
from ..sim.drawing import THIN, fill, settle
from ..tapd.cases import CaseShip
from .plain import USUAL_LENGTH, beam_of
from .search import Ships
from .telling import duty_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE: Final = (5.4, 4.6)  # of the figure [in]
DOTS: Final = 110  # per inch
LEAST_VIEW: Final = 250.0  # extent that is shown at least [m]
ROUND_TIMES: Final = (10.0, 20.0, 30.0, 60.0, 120.0, 180.0, 300.0, 600.0)  # that arrows stand for [s]
_ARROW: Final = 0.4  # of the extent: length of the longest arrow
_SMALL: Final = 7.5  # size of letters [pt]


def draw_ships(ships: Ships, file: Path, title: str = "") -> None:
    """Draw ships that are under way into a PNG file."""
    picture(ships, title).savefig(file, dpi=DOTS, metadata={"Software": None})


def picture(ships: Ships, title: str = "") -> Figure:
    """Draw ships that are under way.

    Raises
    ------
    ValueError
        If one of them has no place or no speed.
    """
    from matplotlib.figure import Figure

    placed = ships.case.ships
    if any(ship.pose is None or ship.speed is None for ship in placed):
        raise ValueError("ships without a place cannot be drawn")
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.subplots()
    time, (low, high) = _frame(placed)
    labels = [_ship(axes, ship, COLOURS[n % len(COLOURS)], time) for n, ship in enumerate(placed)]
    axes.set(xlim=(low[1], high[1]), ylim=(low[0], high[0]), aspect="equal", facecolor="#F4F8FB")
    axes.set_xlabel(f"east [m]; arrows: the way of {time:.0f} s", fontsize=_SMALL)
    axes.set_ylabel("north [m]", fontsize=_SMALL)
    axes.tick_params(labelsize=_SMALL)
    axes.locator_params(nbins=5)
    axes.grid(visible=True, color="0.88", linewidth=0.5)
    axes.set_axisbelow(True)
    if title:
        axes.set_title("\n".join(textwrap.wrap(title, 64)), fontsize=_SMALL + 1.0, loc="left")
    views = "\n".join(
        line for view in ships.verdicts for line in textwrap.wrap(_told(ships, view.own, view.other), 84)
    )
    figure.supxlabel(views, fontsize=_SMALL, x=0.02, ha="left")
    settle(figure, [(axes, labels)])
    return figure


def _told(ships: Ships, own: str, other: str) -> str:
    view = next(each for each in ships.verdicts if (each.own, each.other) == (own, other))
    rule = f" by '{view.rule}'" if view.rule else ""
    return f"{duty_of(view)}{rule}"


def _frame(ships: Sequence[CaseShip]) -> tuple[float, tuple[FloatArray, FloatArray]]:
    """Time that arrows stand for [s], and the corners of a square that holds hulls, arrows and names."""
    hulls = np.vstack([_hull(ship) for ship in ships])
    extent = max(float(np.ptp(hulls, axis=0).max()), LEAST_VIEW)
    fastest = max(ship.speed or 0.0 for ship in ships)
    fitting = [time for time in ROUND_TIMES if time * fastest <= _ARROW * extent]
    time = max(fitting, default=ROUND_TIMES[0])
    points = np.vstack([hulls, *(_end(ship, time) for ship in ships)])
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2.0
    half = max(float((high - low).max()), LEAST_VIEW) * 0.62
    return time, (middle - half, middle + half)


def _end(ship: CaseShip, time: float) -> FloatArray:
    assert ship.pose is not None  # noqa: S101
    north, east, course = ship.pose
    way = (ship.speed or 0.0) * time
    return np.array([north + way * math.cos(course), east + way * math.sin(course)])


def _ship(axes: Axes, ship: CaseShip, colour: str, time: float) -> Label:
    """Draw a hull with a bow, and an arrow for its velocity; the label names it."""
    assert ship.pose is not None  # noqa: S101
    north, east, _ = ship.pose
    fill(axes, _hull(ship), facecolor=colour, edgecolor=colour, linewidth=THIN, zorder=5.0)
    way = np.linspace(0.0, 1.0, 12)[:, None] * (_end(ship, time) - [north, east]) + [north, east]
    axes.plot(way[:-1, 1], way[:-1, 0], color=colour, linewidth=1.2, zorder=5.0)
    looks = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.2, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", way[-1, ::-1].tolist(), way[-2, ::-1].tolist(), arrowprops=looks, zorder=5.0)
    length = float(ship.facts.get("length", USUAL_LENGTH))
    text = f"{ship.id}, {length:g} m, {ship.speed:g} m/s"
    return Label(text=text, north=north, east=east, colour=colour, keep=True)


def _hull(ship: CaseShip) -> FloatArray:
    """Outline (5, 2) of a hull, north and east: a rectangle with a bow."""
    assert ship.pose is not None  # noqa: S101
    north, east, course = ship.pose
    length = float(ship.facts.get("length", USUAL_LENGTH))
    half = float(ship.facts.get("beam", beam_of(length))) / 2.0
    shape = np.array([[-0.5, -1.0], [0.25, -1.0], [0.5, 0.0], [0.25, 1.0], [-0.5, 1.0]]) * [length, half]
    turn = np.array([[math.cos(course), math.sin(course)], [-math.sin(course), math.cos(course)]])
    return np.asarray(shape @ turn + [north, east])
