"""What stands in a panel of a picture: water, ships to scale, lines, arrows, labels.

Drawn as in the paper: waterway white, land grey, safety areas as dashed rectangles (Fig. 5).  East is
right and north is up, so points (n, 2) of {n} are turned round here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import shapely

from ..frames import FloatArray
from ..ships import ShipId
from ..waterway import Waters
from .chart import Duty, Label, Sailed, Style, View, bow_arrow, place
from .hulls import hulls

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase

SMALL, NORMAL, LARGE = 8.0, 9.0, 10.0  # sizes of letters [pt]
LAND: Final = "#D0D0D0"
TINTS: Final = ("#FFF3C4", "#DDEBFF", "#E9DDF5", "#DFF2DF")  # of regions
THIN: Final = 0.6  # width of a line [pt]
DASHED: Final = (0.0, (3.0, 2.0))
CENTRELINE: Final = (0.0, (8.0, 5.0))
_AREAS: Final = 4.0  # z-order of safety areas; hulls, arrows and labels lie above
_BEND: Final = 0.2  # of an arrow, over its length
_CLOSE: Final = 0.8  # hull lengths within which an arrow would be a blot


def water(axes: Axes, waters: Waters, view: View) -> list[Label]:
    """Water white, land grey, centrelines dashed, regions tinted, obstacles; labels name the rulesets."""
    axes.set_facecolor(LAND)
    edge = {"edgecolor": "0.45", "linewidth": THIN}
    banks = waters.banks()
    parts = [part for part in getattr(banks, "geoms", [banks]) if not part.is_empty]
    for part in sorted(parts, key=lambda part: -float(shapely.Polygon(part.exterior).area)):
        fill(axes, shapely.get_coordinates(part.exterior), facecolor="white", **edge)
        for island in part.interiors:
            fill(axes, shapely.get_coordinates(island), facecolor=LAND, **edge)
    labels = []
    window = shapely.box(view.south, view.west, view.north, view.east)
    for number, region in reversed([*enumerate(waters.laws.regions)]):  # what prevails comes last
        tint = TINTS[number % len(TINTS)]
        fill(axes, region.polygon, facecolor=tint, edgecolor="0.4", alpha=0.6, linestyle=":", linewidth=THIN)
        inside = region.shape.intersection(window)
        if not inside.is_empty:
            middle = inside.representative_point()
            name = region.law.ruleset
            labels.append(Label(text=name, north=middle.x, east=middle.y, colour="0.3", keep=True))
    for waterway in waters.waterways:
        north, east = waterway.centreline.T
        axes.plot(east, north, color="0.55", linewidth=THIN, linestyle=CENTRELINE, zorder=1.5)
    for obstacle in waters.obstacles:
        around = shapely.Point(obstacle.x, obstacle.y).buffer(obstacle.radius)
        fill(axes, shapely.get_coordinates(around), facecolor="0.25", edgecolor="black", zorder=2.0)
    return labels


def hull(axes: Axes, ship: Sailed, time: float) -> None:
    """Draw a hull to scale, its safety domain dashed, and an arrow from its bow; nothing if not under way."""
    pose = ship.at(time)
    if not len(pose):
        return
    own, colour = ship.track.ship, ship.style.colour
    fill(
        axes,
        ship.domain(time),
        fill=False,
        edgecolor="black",
        linewidth=THIN,
        linestyle=DASHED,
        zorder=_AREAS,
    )
    outline = shapely.get_coordinates(hulls(own, pose))
    fill(axes, outline, facecolor=colour, edgecolor=colour, alpha=0.75, linewidth=THIN, zorder=_AREAS + 1.0)
    _arrow(axes, bow_arrow(ship, pose[0]), colour, head="->", zorder=_AREAS + 1.0)


def beside(ship: Sailed, time: float, text: str, *, keep: bool) -> Label:
    """Label of a ship that is under way."""
    north, east, _ = ship.at(time)[0]
    return Label(text=text, north=north, east=east, colour=ship.style.colour, keep=keep)


def arrows(
    axes: Axes, ships: Sequence[Sailed], duties: Sequence[Duty], time: float, view: View
) -> list[Label]:
    """Arrows from ships that give way to those they owe it, both ways if mutual; labels name the articles."""
    shown = {ship.id: ship.at(time)[0, :2] for ship in ships if len(ship.at(time))}
    lengths: dict[ShipId, float] = {ship.id: ship.track.ship.hull.length for ship in ships}
    owed = {(duty.obliged, duty.other): duty.article for duty in duties}
    scale = np.array([view.stretch, 1.0])
    labels = []
    for (obliged, other), article in owed.items():
        mutual = (other, obliged) in owed
        if not {obliged, other} <= shown.keys() or (mutual and other < obliged):
            continue
        tail, head = shown[obliged], shown[other]
        if not (view.holds(tail) and view.holds(head)):
            continue
        way = (head - tail) * scale
        middle = (tail + head) / 2.0
        if math.hypot(*way) > _CLOSE * lengths[obliged]:
            bulge = middle + _BEND * np.array([way[1], -way[0]]) / scale
            middle = (middle + bulge) / 2.0
            share = np.linspace(0.06, 0.94, 25)[:, None]
            curve = (1.0 - share) ** 2 * tail + 2.0 * share * (1.0 - share) * bulge + share**2 * head
            _arrow(axes, curve, "black", head="-|>", zorder=_AREAS + 2.0)
            if mutual:
                _arrow(axes, curve[::-1], "black", head="-|>", zorder=_AREAS + 2.0)
        labels.append(Label(text=article, north=middle[0], east=middle[1], colour="black", keep=False))
    return labels


def _arrow(axes: Axes, curve: FloatArray, colour: str, *, head: str, zorder: float) -> None:
    """Draw an arrow along a curve (n, 2): a line, which labels keep clear of, and a head."""
    axes.plot(curve[:-1, 1], curve[:-1, 0], color=colour, linewidth=0.8, zorder=zorder)
    looks = {"arrowstyle": head, "color": colour, "linewidth": 0.8, "mutation_scale": 8.0}
    looks |= {"shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", _on_paper(curve[-1]), _on_paper(curve[-2]), arrowprops=looks, zorder=zorder)


def line(
    axes: Axes,
    table: FloatArray,
    looks: Style,
    *,
    label: str = "_",
    width: float = 1.3,
    steps: bool = False,
    zorder: float = 3.0,
) -> None:
    """Draw a table (K, 2), across and up, in the style of a ship."""
    axes.plot(
        table[:, 0],
        table[:, 1],
        color=looks.colour,
        linewidth=width,
        linestyle=(0.0, looks.dashes),
        drawstyle="steps-post" if steps else "default",
        label=label,
        zorder=zorder,
    )


def sail(axes: Axes, ship: Sailed, poses: FloatArray) -> None:
    """Draw a track through poses (K, 3)."""
    line(axes, poses[:, [1, 0]], ship.style, width=1.0)


def fill(axes: Axes, outline: FloatArray, **looks: Any) -> None:  # noqa: ANN401  (handed on to matplotlib)
    """Draw a polygon (n, 2)."""
    from matplotlib.patches import Polygon

    axes.add_patch(Polygon(outline[:, ::-1], closed=True, **{"zorder": 1.0, **looks}))


def samples(ships: Sequence[Sailed]) -> list[Artist]:
    """Entries of a legend, one a ship."""
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], color=ship.style.colour, linestyle=(0.0, ship.style.dashes), label=ship.name)
        for ship in ships
    ]


def chart_samples(waters: Waters) -> list[Artist]:
    """Entries of a legend for what else stands in a chart."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    area = Patch(fill=False, edgecolor="black", linestyle=DASHED, linewidth=THIN, label="safety area")
    middle = Line2D([], [], color="0.55", linewidth=THIN, linestyle=CENTRELINE, label="centreline")
    obstacle = Patch(facecolor="0.25", edgecolor="black", label="obstacle")
    return [area, middle, obstacle] if waters.obstacles else [area, middle]


def dress(axes: Axes, x: str, y: str, *, least: float = 0.0) -> None:
    """Write what the axes of a diagram show; the upright one spans at least so much."""
    axes.set_xlabel(x, fontsize=NORMAL)
    axes.set_ylabel(y, fontsize=NORMAL)
    axes.tick_params(labelsize=SMALL)
    axes.grid(visible=True, color="0.9", linewidth=0.5)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    low, high = axes.get_ylim()
    if high - low < least:
        axes.set_ylim((low + high - least) / 2.0, (low + high + least) / 2.0)


def dress_chart(axes: Axes, view: View) -> None:
    """Show a part of the chart, in metres."""
    axes.set_xlim(view.west, view.east)
    axes.set_ylim(view.south, view.north)
    axes.set_aspect(view.stretch)
    axes.tick_params(labelsize=SMALL)
    axes.locator_params(nbins=6)


def chart_names(view: View) -> tuple[str, str]:
    """Names of the axes of a chart; the one that is stretched says so."""
    if view.stretch > 1.0:
        return "east [m]", f"north [m], stretched {view.stretch:.0f} times"
    if view.stretch < 1.0:
        return f"east [m],\nstretched {1.0 / view.stretch:.0f} times", "north [m]"
    return "east [m]", "north [m]"


def settle(figure: Figure, panels: Sequence[tuple[Axes, Sequence[Label]]]) -> None:
    """Lay a figure out once and for all, then write the labels of each panel where there is room."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes, labels in panels:
        _write(axes, labels)


def below(figure: FigureBase, entries: Sequence[Artist]) -> None:
    """Put a legend below everything else, in as many rows as it needs."""
    root = figure.get_figure(root=True)
    room = root.get_figwidth() * 72.0 if root else math.inf
    wanted = sum(SMALL * (5.6 + 0.62 * len(str(entry.get_label()))) for entry in entries)
    rows = max(1, math.ceil(wanted / room))
    figure.legend(
        handles=entries,
        loc="outside lower center",
        ncols=math.ceil(len(entries) / rows),
        handlelength=2.8,
        fontsize=SMALL,
        frameon=False,
    )


def _write(axes: Axes, labels: Sequence[Label]) -> None:
    from matplotlib.patches import Polygon
    from matplotlib.patheffects import withStroke

    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    inside = [each for each in labels if west <= each.east <= east and south <= each.north <= north]
    figure = axes.get_figure(root=True)
    if not inside or figure is None:
        return
    to_points = 72.0 / figure.dpi
    anchors = axes.transData.transform([(each.east, each.north) for each in inside]) * to_points
    sizes = np.array([(0.6 * SMALL * len(each.text) + 2.0, 1.25 * SMALL) for each in inside])
    outlines = [(np.asarray(each.get_xydata()), each.get_zorder()) for each in axes.lines]
    outlines += [  # with a diagonal, for the inside is no better place than the edge
        (np.vstack([each.get_xy(), each.get_xy()[2:3]]), each.get_zorder())
        for each in axes.patches
        if isinstance(each, Polygon)
    ]
    busy = [
        _dots(axes.transData.transform(outline) * to_points, weight)
        for outline, zorder in outlines
        if (weight := _weight(zorder))
    ]
    box = axes.bbox.get_points() * to_points
    dots = np.vstack([np.empty((0, 3)), *busy])
    dots = dots[np.all((dots[:, :2] > box[0]) & (dots[:, :2] < box[1]), axis=1)]
    centres = place(anchors, sizes, [each.keep for each in inside], dots, box)
    for each, anchor, centre in zip(inside, anchors, centres, strict=True):
        if centre is not None:
            axes.annotate(
                each.text,
                (each.east, each.north),
                (float(centre[0] - anchor[0]), float(centre[1] - anchor[1])),
                textcoords="offset points",
                ha="center",
                va="center",
                fontsize=SMALL,
                color=each.colour,
                zorder=_AREAS + 3.0,
                path_effects=[withStroke(linewidth=2.0, foreground="white")],
            )


def _weight(zorder: float) -> float:
    """How much a label should keep clear: of hulls most, then of arrows, then of tracks."""
    if zorder <= 1.0:
        return 0.0
    if zorder < _AREAS:
        return 0.3
    return 25.0 if zorder < _AREAS + 2.0 else 1.5


def _dots(outline: FloatArray, weight: float) -> FloatArray:
    """Points (m, 3) along a line, with a weight."""
    if len(outline) < 2:
        return np.empty((0, 3))
    share = np.linspace(0.0, 1.0, 12)[:, None, None]
    dots = ((1.0 - share) * outline[:-1] + share * outline[1:]).reshape(-1, 2)
    return np.column_stack([dots, np.full(len(dots), weight)])


def _on_paper(point: FloatArray) -> tuple[float, float]:
    return float(point[1]), float(point[0])
