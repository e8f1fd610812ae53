"""Laws in scenario files: rulesets in a version, regions drawn or named, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..errors import did_you_mean
from ..quantities import LENGTH, TIME, Range
from ..regions import Hysteresis, Law, Region, contested
from ..strict_yaml import Block, Reader
from ..tapd.ruleset import AbstractRuleset
from ..waterway import Towards, Waters, Waterway
from ..yaml_nodes import Node, Scalar
from ..yaml_nodes import Sequence as List
from .plane import IN_DEGREES, Plane, Point

_PRECEDENCE: Final = 1000  # greatest
_NOT_NEGATIVE: Final = Range(at_least=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawn:
    """A region of a file, and where it stands there."""

    region: Region
    at: Node
    small: bool = False  # its numbers are no larger than those of degrees
    tiny: bool = False  # and it is smaller than any ship


def read_law(reader: Reader, node: Node, rulesets: Collection[str] | None) -> str:
    """A ruleset that is in force somewhere: `ID`, or `ID@VERSION` where just this version will do."""
    text = _named(reader, node, rulesets)
    _refuse_version(reader, node, Law.parsed(text), rulesets)
    return text


def _refuse_version(reader: Reader, node: Node, law: Law, rulesets: Collection[str] | None) -> None:
    """Refuse a version that is not the one installed, where rulesets are known with their versions."""
    if not law.version or not isinstance(rulesets, Mapping) or law.ruleset not in rulesets:
        return
    installed: AbstractRuleset = rulesets[law.ruleset]
    if installed.version != law.version:
        message = f"version {law.version} of ruleset '{law.ruleset}' is not installed"
        hint = f"installed is {law.ruleset}@{installed.version}; without a version, that one is meant"
        reader.refuse(node, message, hint=hint)


def read_carried(reader: Reader, node: Node | None, rulesets: Collection[str] | None) -> tuple[str, ...]:
    """Rulesets aboard a ship, in versions that need not be installed; none where nothing is stated."""
    if node is None:
        return ()
    found: dict[str, str] = {}
    for each in reader.items(node, 1, hint="a ship needs a ruleset; without this key it has all"):
        text = _named(reader, each, rulesets)
        id_ = Law.parsed(text).ruleset
        if id_ in found:
            reader.refuse(each, f"ruleset '{id_}' is aboard twice", hint="remove one")
        found.setdefault(id_, text)
    return tuple(found.values())


def _named(reader: Reader, node: Node, rulesets: Collection[str] | None) -> str:
    text = reader.text(node)
    law = Law.parsed(text)
    if text and rulesets is not None and law.ruleset not in rulesets:
        reader.unknown(node, "ruleset", law.ruleset, rulesets)
    elif text.endswith("@"):
        reader.refuse(node, "no version follows '@'", hint=f"write '{law.ruleset}' for any version")
    return text


def read_hysteresis(reader: Reader, node: Node | None) -> Hysteresis:
    """What keeps ships from changing their law again and again."""
    block, usual = reader.block(node), Hysteresis()
    width = reader.number(block.optional("width", LENGTH.write(usual.width)), LENGTH, _NOT_NEGATIVE)
    time = reader.number(block.optional("time", TIME.write(usual.time)), TIME, _NOT_NEGATIVE)
    block.done()
    return Hysteresis(width=width, time=time)


def read_region(
    reader: Reader,
    node: Node,
    plane: Plane,
    ids: dict[str, Node],
    waterways: Mapping[str, Waterway | None],
    rulesets: Collection[str] | None,
    offered: Mapping[str, Region],
) -> Drawn | None:
    """A region that is drawn here, by a polygon or along a waterway, or one of a plugin, by its id.

    `waterways` are those of the file, by their ids; None stands for one that was refused.
    """
    if isinstance(node, Scalar) and not node.is_null:
        return _offered(reader, node, ids, rulesets, offered)
    block = reader.block(node)
    id_ = reader.unique(ids, block.require("id"), "region")
    ruleset = read_law(reader, block.require("ruleset"), rulesets)
    precedence = reader.integer(block.optional("precedence", "0"), -_PRECEDENCE, _PRECEDENCE)
    stretch = block.find("stretch")
    border = block.find("polygon")
    if bool(stretch) == bool(border):
        reader.refuse(stretch or node, "a region has a polygon or a stretch", expected="one of the two")
    if stretch:
        points = _stretch(reader, stretch, waterways)
    else:
        points = _corners(reader, border, plane) if border else []
    if not block.done() or not points:
        return None
    if border and not _is_ring(points):
        reader.refuse(border, "the polygon crosses itself or has no area", hint="go once around the region")
        return None
    region = Region(id=id_, ruleset=ruleset, polygon=np.array(points), precedence=precedence)
    if border is None:
        return Drawn(region=region, at=node)
    return Drawn(region=region, at=border, small=plane.may_be_degrees(points), tiny=plane.are_degrees(points))


def _offered(
    reader: Reader,
    node: Scalar,
    ids: dict[str, Node],
    rulesets: Collection[str] | None,
    offered: Mapping[str, Region],
) -> Drawn | None:
    name = reader.unique(ids, node, "region")
    region = offered.get(name)
    if name and region is None:
        reader.unknown(node, "region", name, offered)
    elif region and rulesets is not None and region.law.ruleset not in rulesets:
        message = f"region '{name}' is under the unknown ruleset '{region.law.ruleset}'"
        reader.refuse(node, message, hint=did_you_mean(region.law.ruleset, rulesets))
    elif region:
        _refuse_version(reader, node, region.law, rulesets)
    return Drawn(region=region, at=node) if region else None


def _corners(reader: Reader, node: Node, plane: Plane) -> list[Point]:
    ring = node.items[0] if isinstance(node, List) and node.items else None
    if isinstance(ring, List) and ring.items and isinstance(ring.items[0], List):
        hint = "what lies inside is a region of its own, with a greater `precedence`"
        reader.refuse(node, "a polygon with a hole", expected="one ring of positions", hint=hint)
        return []
    return plane.points(node, 3)


def _is_ring(points: Sequence[Point]) -> bool:
    from shapely import Polygon

    return len(set(points)) >= 3 and Polygon(points).is_valid


def _stretch(reader: Reader, node: Node, waterways: Mapping[str, Waterway | None]) -> list[Point]:
    """Corners of a stretch of a waterway, from bank to bank."""
    from shapely import Polygon

    block = reader.block(node)
    name = reader.text(along := block.require("waterway"))
    waterway = waterways.get(name)
    if name and name not in waterways:
        reader.unknown(along, "waterway", name, waterways)
    length = waterway.frame(Towards.END).length if waterway else float("inf")
    first = reader.number(block.optional("from", "0 m"), LENGTH, _NOT_NEGATIVE)
    until = block.find("to")
    last = reader.number(until, LENGTH, _NOT_NEGATIVE) if until else length
    if not block.done() or waterway is None:
        return []
    if not first < last <= length + LENGTH.keep(1e-3):
        expected = f"'from' less than 'to', and both on the {length:.0f} m of '{name}'"
        reader.refuse(until or node, f"a stretch from {first:g} m to {last:g} m", expected=expected)
        return []
    strip = waterway.strip(first, min(last, length))
    if not isinstance(strip, Polygon) or strip.interiors:
        reader.refuse(node, "the stretch runs round land", hint="draw a polygon instead")
        return []
    return [(LENGTH.keep(x), LENGTH.keep(y)) for x, y in strip.exterior.coords[:-1]]


def refuse_together(reader: Reader, block: Block, waters: Waters, drawn: Sequence[Drawn]) -> None:
    """Refuse what is wrong with regions that are each well for itself: overlaps, holes, degrees."""
    places = {id(each.region): each.at for each in drawn}
    for one, other in contested([each.region for each in drawn]):
        message = f"regions '{one.id}' and '{other.id}' overlap, under {one.law} and {other.law}"
        hint = "say which of them prevails there: give it a greater `precedence: 1`"
        reader.refuse(places[id(other)], message, expected="a precedence", hint=hint)
    water = waters.water()
    for each in drawn:
        if each.tiny or (each.small and not each.region.shape.intersects(water)):
            reader.refuse(each.at, "the polygon lies on no water: are these degrees?", hint=IN_DEGREES)
    hole = waters.laws.uncovered(water)
    if hole is not None:
        message = f"no ruleset is in force at [{hole.y:.0f}, {hole.x:.0f}]: the regions leave a hole"
        hint = "draw a region there, or give the waters a 'ruleset' for all that lies outside"
        reader.refuse(block.find("regions") or Node(0, 0), message, hint=hint)
