"""A priority graph as a drawing: a column for each generation, arrows from who decides first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final
from xml.sax.saxutils import escape

if TYPE_CHECKING:
    from ccas_core.priority import PriorityGraph, Settlement
    from ccas_core.ships import ShipId

_COLUMN, _ROW = 260.0, 100.0  # from one node to the next [px]
_HEIGHT: Final = 36.0  # of a node
_LETTER: Final = 8.0  # width of a letter
_MOST: Final = 28  # letters that are shown of a name
_MARGIN: Final = 24.0

# Both grounds are named, so that the drawing can be read wherever it is put.
_STYLE: Final = """\
  svg { --ink: #1a1a1a; --ground: #ffffff; --quiet: #8a8a8a; --fill: #eef3f8; background: var(--ground); }
  @media (prefers-color-scheme: dark) {
    svg { --ink: #e8e8e8; --ground: #16181c; --quiet: #7d8590; --fill: #243040; }
  }
  text { font: 13px sans-serif; fill: var(--ink); text-anchor: middle; dominant-baseline: central; }
  .label { font-size: 11px; paint-order: stroke; stroke: var(--ground); stroke-width: 4px; }
  .legend { font-size: 11px; text-anchor: start; fill: var(--quiet); }
  .ship { fill: var(--fill); stroke: var(--ink); }
  .edge { fill: none; stroke: var(--ink); stroke-width: 1.5px; }
  .order { stroke-dasharray: 6 4; }
  .opened { stroke: var(--quiet); }
  marker path { fill: var(--ink); }
  #quiet path { fill: var(--quiet); }
"""
_MARKERS: Final = "".join(
    f'<marker id="{id_}" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8" orient="auto">'
    '<path d="M0 0L8 4L0 8z"/></marker>'
    for id_ in ("arrow", "quiet")
)
_LEGEND: Final = (
    "solid: gives way, and decides first; dashed: decides first, no duty; no arrow: both act; "
    "grey: left out of the order"
)


@dataclass(frozen=True, slots=True)
class _Node:
    """A ship in the drawing: its middle, and half of its width."""

    x: float
    y: float
    half: float


Point = tuple[float, float]
Curve = tuple[Point, Point, Point, Point]


def as_svg(name: str, graph: PriorityGraph) -> str:
    """Draw a priority graph."""
    nodes = _nodes(graph)
    opened = {(each.edge.first, each.edge.then) for each in graph.openings}
    edges = [_edge(settlement, nodes, opened) for settlement in graph.settlements]
    curves = [curve for curve, _ in edges]
    points = [point for curve in curves for point in curve]
    left = min([node.x - node.half for node in nodes.values()] + [x for x, _ in points], default=0.0)
    right = max([node.x + node.half for node in nodes.values()] + [x for x, _ in points], default=0.0)
    right = max(right, left + 5.6 * len(_LEGEND))
    top = min([node.y - _HEIGHT for node in nodes.values()] + [y for _, y in points], default=0.0)
    bottom = max([node.y + _HEIGHT for node in nodes.values()] + [y for _, y in points], default=0.0)
    width, height = right - left + 2.0 * _MARGIN, bottom - top + 3.0 * _MARGIN
    view = f"{left - _MARGIN:.0f} {top - _MARGIN:.0f} {width:.0f} {height:.0f}"
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{view}"',
        f'  width="{width:.0f}" height="{height:.0f}">',
        f"<title>{escape(_clean(name))}: who decides before whom</title>",
        f"<style>\n{_STYLE}</style>",
        f"<defs>{_MARKERS}</defs>",
        *(drawn for _, drawn in edges),
        *(_drawn(id_, node) for id_, node in nodes.items()),
        *(_label(settlement, curve) for settlement, curve in zip(graph.settlements, curves, strict=True)),
        f'<text class="legend" x="{left:.0f}" y="{bottom + _MARGIN:.0f}">{_LEGEND}</text>',
        "</svg>",
    ]
    return "\n".join(lines)


def _nodes(graph: PriorityGraph) -> dict[ShipId, _Node]:
    """Place the ships: generations side by side, the ships of one below each other, all about one height."""
    return {
        ship: _Node(
            column * _COLUMN, (row - (len(ships) - 1) / 2.0) * _ROW, 16.0 + _LETTER / 2.0 * len(_cut(ship))
        )
        for column, ships in enumerate(graph.generations())
        for row, ship in enumerate(ships)
    }


def _edge(
    settlement: Settlement, nodes: dict[ShipId, _Node], opened: set[tuple[ShipId, ShipId]]
) -> tuple[Curve, str]:
    edge = settlement.edge
    ends = (edge.first, edge.then) if edge else settlement.pair
    curve = _curve(*(nodes[ship] for ship in ends))
    quiet = ends in opened
    kinds = ["edge", edge.kind.value if edge else "mutual", *(["opened"] if quiet else [])]
    arrow = f' marker-end="url(#{"quiet" if quiet else "arrow"})"' if edge else ""
    (x, y), *rest = curve
    path = f"M{x:.1f} {y:.1f}C" + " ".join(f"{a:.1f} {b:.1f}" for a, b in rest)
    said = f"{' - '.join(ends)}: {settlement.one.kind}, {settlement.one.article or 'no article'}"
    if settlement.fallback:
        said = f"{' - '.join(ends)}: safe mutual rule, because {settlement.fallback}"
    title = f"<title>{escape(_clean(said))}</title>"
    return curve, f'<path class="{" ".join(kinds)}" d="{path}"{arrow}>{title}</path>'


def _curve(one: _Node, other: _Node) -> Curve:
    """Curve from one node to another, past those between them."""
    columns = round(abs(other.x - one.x) / _COLUMN)
    if columns == 0:
        bow = 60.0 + abs(other.y - one.y) / 4.0
        x, y = one.x + one.half, other.x + other.half
        return (x, one.y), (x + bow, one.y), (y + bow, other.y), (y, other.y)
    forth = 1.0 if other.x > one.x else -1.0
    start, end = (one.x + forth * one.half, one.y), (other.x - forth * other.half, other.y)
    reach = forth * min(80.0, abs(end[0] - start[0]) / 2.0)
    lift = 0.0 if columns == 1 else 40.0 + 30.0 * columns
    if forth < 0.0:
        lift = -lift - 60.0  # against the order: below
    return start, (start[0] + reach, start[1] - lift), (end[0] - reach, end[1] - lift), end


def _drawn(id_: str, node: _Node) -> str:
    box = f'x="{node.x - node.half:.1f}" y="{node.y - _HEIGHT / 2.0:.1f}" width="{2.0 * node.half:.1f}"'
    name = escape(_cut(id_))
    return (
        f'<g><title>{escape(_clean(id_))}</title><rect class="ship" {box} height="{_HEIGHT:.0f}" rx="6"/>'
        f'<text x="{node.x:.1f}" y="{node.y:.1f}">{name}</text></g>'
    )


def _label(settlement: Settlement, curve: Curve) -> str:
    """Article without its regulation, in the middle of the curve."""
    x, y = (
        (curve[0][axis] + 3.0 * curve[1][axis] + 3.0 * curve[2][axis] + curve[3][axis]) / 8.0
        for axis in (0, 1)
    )
    citation = settlement.one.citation
    text = (citation.article if citation else "") or settlement.one.kind.value
    if settlement.fallback:
        text = "safe mutual rule"
    return f'<text class="label" x="{x:.1f}" y="{y - 8.0:.1f}">{escape(_cut(text))}</text>'


def _cut(text: str) -> str:
    clean = _clean(text)
    return clean if len(clean) <= _MOST else f"{clean[: _MOST - 1]}…"


def _clean(text: str) -> str:
    """Text without letters that XML does not know."""
    return "".join(letter if letter.isprintable() else "\ufffd" for letter in text)
