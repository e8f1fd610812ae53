"""Pictures as in the paper of the dynamic bumper: paths with domains at chosen times, speeds, yaw rates."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from ..frames import FloatArray
from .chart import PAGE, Sailed, grid, page_size, scene
from .drawing import NORMAL, beside, dress, dress_chart, hull, line, sail, settle, water
from .frame import Frame
from .page import blank, charts, explain, letter, name_outside
from .scenario import Scenario

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TALLEST: Final = 7.0  # height of the charts [in]
DIAGRAMS: Final = 2.2  # of the diagrams below [in]


def steered(scenario: Scenario, frames: Sequence[Frame], times: Sequence[float] | None = None) -> Figure:
    """Draw a panel an instant with all domains, and below surge speed and yaw rate of steered ships."""
    shown = scene(scenario, frames, times)
    columns, rows = grid(len(shown.times), shown.view, TALLEST)
    _, height = page_size(shown.view, columns, rows, TALLEST)
    figure = blank(PAGE, height + DIAGRAMS)
    upper, lower = figure.subfigures(2, 1, squeeze=False, height_ratios=(height, DIAGRAMS))[:, 0]
    written = []
    panels = charts(upper, columns, rows)
    for number, (panel, time) in enumerate(zip(panels, shown.times, strict=False)):
        labels = water(panel, shown.scenario.waters, shown.view)
        for ship in shown.ships:
            sail(panel, ship, ship.between(ship.track.times[0], time))
            hull(panel, ship, time)
            if len(ship.at(time)):
                labels.append(beside(ship, time, ship.name, keep=True))
        panel.set_title(f"{letter(number)} {time:.0f} s", fontsize=NORMAL, loc="left")
        dress_chart(panel, shown.view)
        written.append((panel, labels))
    name_outside(upper, panels, columns, len(shown.times), shown.view)
    explain(upper, shown)
    left, right = lower.subplots(1, 2)
    for ship in shown.ships:
        table = motions(frames, ship)
        if len(table):
            line(left, table[:, [0, 1]], ship.style, label=ship.name)
            line(right, table[:, [0, 2]], ship.style, label=ship.name)
    dress(left, "time [s]", "surge speed [m/s]", least=1.0)
    dress(right, "time [s]", "yaw rate [deg/s]", least=1.0)
    settle(figure, written)
    return figure


def motions(frames: Sequence[Frame], ship: Sailed) -> FloatArray:
    """Table (K, 3): time [s], surge speed [m/s], yaw rate [deg/s] of a steered ship; no rows of others."""
    rows = [
        (frame.time, now.motion.surge, math.degrees(now.motion.yaw_rate))
        for frame in frames
        if (now := frame.ships.get(ship.id)) is not None and now.motion is not None
    ]
    return np.array(rows, dtype=np.float64).reshape(-1, 3)
