"""The page that pictures stand on: figure, charts with one view, names of axes, letters of panels, legend."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from .chart import Scene, View
from .drawing import NORMAL, below, chart_names, chart_samples, samples

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase

NAMED: Final = 8  # ships that are named; of more, colours and lines would tell nothing


def blank(width: float, height: float) -> Figure:
    """Begin a figure [in]."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def charts(figure: FigureBase, columns: int, rows: int) -> list[Axes]:
    """Panels row by row, all with the same view."""
    return list(figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).flat)


def name_outside(figure: FigureBase, panels: Sequence[Axes], columns: int, count: int, view: View) -> None:
    """Name the axes of charts once, and hide the panels that are not used."""
    x, y = chart_names(view)
    for number, panel in enumerate(panels):
        panel.set_visible(number < count)
        lowest = number + columns >= count
        panel.tick_params(labelbottom=lowest)
        panel.set_xlabel(x if lowest else "", fontsize=NORMAL)
    figure.supylabel(y, fontsize=NORMAL)


def letter(number: int) -> str:
    """Letter of a panel.

    >>> letter(0), letter(26)
    ('(a)', '(27)')
    """
    return f"({chr(ord('a') + number)})" if number < 26 else f"({number + 1})"


def explain(figure: FigureBase, shown: Scene) -> None:
    """Explain a chart below it."""
    ships = samples(shown.ships) if len(shown.ships) <= NAMED else []
    below(figure, [*ships, *chart_samples(shown.scenario.waters)])
