"""Scenarios as YAML files: read with all their faults at once, written as resolved."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from .. import strict_yaml
from ..dmpc.parameters import PARAMETERS, RiskShape, Start, Wait
from ..errors import ScenarioError
from ..frames import FloatArray, NedPose
from ..ships import UNKNOWN, Facts, FactValue, Hull, Ship, ShipId
from ..strict_yaml import ANGLE, LENGTH, MASS, NUMBER, QUANTITY_OF, SPEED, TIME, Node, Range, Reader, written
from ..units import DEGREE, KILOMETRE, wrap
from ..waterway import GuidingLine, Leg, Obstacle, Region, Towards, Waters, Waterway, guiding_line
from .scenario import BusChoice, ControlChoice, Plan, Profile, Scenario

if TYPE_CHECKING:
    from pyproj import Transformer

SCHEMA: Final = "ccas/scenario@1"

_POSITIVE: Final = Range(above=0.0)
_NOT_NEGATIVE: Final = Range(at_least=0.0)
_SPEED: Final = Range(above=0.0, at_most=30.0)
_OFFSET: Final = Range(at_least=-1000.0, at_most=1000.0)
_COURSE: Final = Range(at_least=-360.0 * DEGREE, at_most=360.0 * DEGREE)
_COORDINATE: Final = Range(at_least=-1e7, at_most=1e7)
_MAX_LEGS: Final = 100
_SAME_POINT: Final = 1e-3  # [m]
_SHARPEST_BEND: Final = 150.0 * DEGREE
_FARTHEST: Final = 500.0 * KILOMETRE  # from the first lonlat position: there the plane is still flat enough
_WIDTH: Final = 100  # of a line that is written

_Point: TypeAlias = tuple[float, float]  # north, east [m]
_Tree: TypeAlias = "str | Mapping[str, _Tree] | Sequence[_Tree]"  # leaves are YAML already


def load_scenario(path: str | Path, rulesets: Collection[str] | None = None) -> Scenario:
    """Read a scenario file.

    Parameters
    ----------
    path
        The file.
    rulesets
        Ids of the rulesets that there are; None: not checked.

    Raises
    ------
    ScenarioError
        With all that is wrong, each with its place.
    """
    return parse_scenario(strict_yaml.read_text(path, ScenarioError), str(path), rulesets)


def parse_scenario(text: str, source: str = "scenario", rulesets: Collection[str] | None = None) -> Scenario:
    """Read the text of a scenario file; `source` is what findings call it.  See `load_scenario`."""
    reader = Reader(text, source, ScenarioError)
    root = reader.document(SCHEMA)
    plane = _Plane(reader)
    title, description = root.find("title"), root.find("description")
    time_step, duration = _time(reader, root.require("time"))
    waters, known = _waters(reader, root.require("waters"), plane, rulesets)
    scenario = Scenario(
        name=reader.text(root.require("name")),
        title=reader.text(title) if title else "",
        description=reader.text(description) if description else "",
        time_step=time_step,
        duration=duration,
        waters=waters,
        ships=_ships(reader, root.require("ships"), plane, waters, known),
        control=_control(reader, root.find("control")),
        bus=_bus(reader, root.find("bus")),
    )
    root.done()
    reader.finish()
    return scenario


def _time(reader: Reader, node: Node) -> tuple[float, float]:
    block = reader.block(node)
    step = reader.number(block.require("step"), TIME, _POSITIVE)
    duration = reader.number(block.optional("duration", "0 s"), TIME, _NOT_NEGATIVE)
    block.done()
    return step, duration


def _waters(
    reader: Reader, node: Node, plane: _Plane, rulesets: Collection[str] | None
) -> tuple[Waters, Collection[str]]:
    """What of the waters is well, and the ids of all waterways, well or not."""
    block = reader.block(node)
    ids: tuple[dict[str, Node], ...] = ({}, {}, {})
    ruleset = _ruleset(reader, block.require("ruleset"), rulesets)
    reaches = [_waterway(reader, each, plane, ids[0]) for each in reader.items(block.require("waterways"), 1)]
    regions = [_region(reader, each, plane, ids[1], rulesets) for each in reader.items(block.find("regions"))]
    obstacles = [_obstacle(reader, each, plane, ids[2]) for each in reader.items(block.find("obstacles"))]
    block.done()
    waters = Waters(
        ruleset=ruleset,
        waterways=tuple(each for each in reaches if each),
        regions=tuple(each for each in regions if each),
        obstacles=tuple(each for each in obstacles if each),
    )
    return waters, ids[0].keys()


def _ruleset(reader: Reader, node: Node, rulesets: Collection[str] | None) -> str:
    ruleset = reader.text(node)
    if ruleset and rulesets is not None and ruleset not in rulesets:
        reader.unknown(node, "ruleset", ruleset, rulesets)
    return ruleset


def _waterway(reader: Reader, node: Node, plane: _Plane, ids: dict[str, Node]) -> Waterway | None:
    block = reader.block(node)
    id_ = reader.unique(ids, block.require("id"), "waterway")
    centreline = _centreline(reader, block.require("centreline"), plane)
    width = reader.number(block.require("width"), LENGTH, _POSITIVE)
    upstream = reader.choice(block.optional("upstream", "none"), Towards)
    facts = _facts(reader, block.find("facts"))
    if not block.done():
        return None
    return Waterway(id=id_, centreline=np.array(centreline), width=width, upstream=upstream, facts=facts)


def _centreline(reader: Reader, node: Node, plane: _Plane) -> list[_Point]:
    points = plane.points(node, 2)
    courses = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(points)]
    places = node.items[1:] if isinstance(node, strict_yaml.Sequence) else ()
    for place, (before, after) in zip(places, pairwise(courses), strict=False):
        if abs(wrap(after - before)) > _SHARPEST_BEND:
            reader.refuse(place, "the centreline turns back here", hint="begin another waterway instead")
    return points


def _region(
    reader: Reader, node: Node, plane: _Plane, ids: dict[str, Node], rulesets: Collection[str] | None
) -> Region | None:
    block = reader.block(node)
    id_ = reader.unique(ids, block.require("id"), "region")
    ruleset = _ruleset(reader, block.require("ruleset"), rulesets)
    border = block.require("polygon")
    points = plane.points(border, 3)
    if not block.done():
        return None
    from shapely import Polygon

    if len(set(points)) < 3 or not Polygon(points).is_valid:
        reader.refuse(border, "the polygon crosses itself or has no area", hint="go once around the region")
        return None
    return Region(id=id_, ruleset=ruleset, polygon=np.array(points))


def _obstacle(reader: Reader, node: Node, plane: _Plane, ids: dict[str, Node]) -> Obstacle | None:
    block = reader.block(node)
    id_ = reader.unique(ids, block.require("id"), "obstacle")
    north, east = plane.point(block.require("at"))
    radius = reader.number(block.require("radius"), LENGTH, _POSITIVE)
    return Obstacle(id=id_, x=north, y=east, radius=radius) if block.done() else None


def _ships(
    reader: Reader, node: Node, plane: _Plane, waters: Waters, known: Collection[str]
) -> tuple[Plan, ...]:
    ids: dict[str, Node] = {}
    plans = [_plan(reader, each, plane, waters, known, ids) for each in reader.items(node, 1)]
    return tuple(plan for plan in plans if plan)


def _plan(
    reader: Reader, node: Node, plane: _Plane, waters: Waters, known: Collection[str], ids: dict[str, Node]
) -> Plan | None:
    block = reader.block(node)
    id_ = reader.unique(ids, block.require("id"), "ship")
    size = {key: reader.number(block.require(key), LENGTH, _POSITIVE) for key in ("length", "beam")}
    for key in ("safety_length", "safety_beam"):
        if (stated := block.find(key)) is not None:
            size[key] = reader.number(stated, LENGTH, _POSITIVE)
    mass = reader.number(block.require("weight"), MASS, _POSITIVE)
    legs = reader.items(block.require("route"), 1, _MAX_LEGS)
    route = tuple(_leg(reader, each, known) for each in legs)
    north, east = plane.point(at := block.require("start"))
    towards = block.find("course")
    course = reader.number(towards, ANGLE, _COURSE) if towards else None
    speed = reader.number(block.require("speed"), SPEED, _SPEED)
    facts = _facts(reader, block.find("facts"))
    if not block.done() or (line := _line(reader, legs, route, waters)) is None:
        return None
    start = _start(reader, at, NedPose(north, east, 0.0), course, line, waters.waterway(route[0].waterway))
    ship = Ship(id=ShipId(id_), hull=Hull(**size), mass=mass, facts=facts)
    return Plan(ship=ship, route=route, start=start, speed=speed)


def _leg(reader: Reader, node: Node, known: Collection[str]) -> Leg:
    block = reader.block(node)
    waterway = reader.text(along := block.require("waterway"))
    if waterway and waterway not in known:
        reader.unknown(along, "waterway", waterway, known)
    towards = reader.choice(block.require("towards"), (Towards.START, Towards.END))
    offset = reader.number(block.optional("offset", "0 m"), LENGTH, _OFFSET)
    block.done()
    return Leg(waterway, towards, offset)


def _line(reader: Reader, places: Sequence[Node], route: Sequence[Leg], waters: Waters) -> GuidingLine | None:
    """The guiding line; None where it cannot be drawn, with a finding at the first leg that is to blame."""
    if not {leg.waterway for leg in route} <= {waterway.id for waterway in waters.waterways}:
        return None  # a waterway that was refused
    line = None
    for count, place in enumerate(places, start=1):
        try:
            with np.errstate(divide="raise", invalid="raise", over="raise"):
                line = guiding_line(waters, route[:count])
        except (ValueError, FloatingPointError) as error:
            hint = "a route goes over to the next waterway where the guiding lines cross"
            reader.refuse(place, f"no guiding line can be drawn: {error}", hint=hint)
            return None
    return line


def _start(
    reader: Reader, place: Node, start: NedPose, course: float | None, line: GuidingLine, first: Waterway
) -> NedPose:
    along = line.frame.to_path(start).x
    if not first.holds(start):
        off = abs(first.frame(Towards.END).to_path(start).y)
        hint = f"it is {off:.0f} m off a centreline with {first.width / 2.0:.0f} m to each side"
        if off <= first.width / 2.0:
            hint = "it is before the start or past the end of the centreline"
        reader.refuse(place, f"the ship starts outside its first waterway '{first.id}'", hint=hint)
    elif along >= line.frame.length:
        reader.refuse(place, "the ship starts past the end of its route", hint="is 'towards' the other end?")
    angle = line.frame.course_at(along) if course is None else course
    return NedPose(start.x, start.y, wrap(_full_circle(angle)))


def _full_circle(angle: float) -> float:
    """An angle as files write courses: from north clockwise, at least 0 and below 360 deg."""
    return ANGLE.keep(angle % math.tau) % math.tau


def _facts(reader: Reader, node: Node | None) -> Facts:
    return {key.text: _fact(reader, value) for key, value in reader.entries(node)}


def _fact(reader: Reader, node: Node) -> FactValue:
    value = reader.value(node)
    return UNKNOWN if value == UNKNOWN.value else value


def _control(reader: Reader, node: Node | None) -> ControlChoice:
    block, usual = reader.block(node), ControlChoice()
    wait, shape, starts = block.find("wait"), block.find("risk_shape"), block.find("starts")
    choice = ControlChoice(
        horizon=reader.integer(block.optional("horizon", str(usual.horizon)), 1, 200),
        iterations=reader.integer(block.optional("iterations", str(usual.iterations)), 1, 100),
        profile=reader.choice(block.optional("profile", usual.profile), Profile),
        parameters=_parameters(reader, block.find("parameters")),
        wait=reader.choice(wait, Wait) if wait else None,
        risk_shape=reader.choice(shape, RiskShape) if shape else None,
        starts=tuple(reader.choice(each, Start) for each in reader.items(starts, 1)) if starts else None,
        deadlock_detection=reader.flag(block.optional("deadlock_detection", "true")),
    )
    block.done()
    return choice


def _parameters(reader: Reader, node: Node | None) -> dict[str, float]:
    values = {}
    for key, value in reader.entries(node):
        if (parameter := PARAMETERS.get(key.text)) is None:
            reader.unknown(key, "parameter", key.text, PARAMETERS)
            continue
        bounds = Range(at_least=parameter.low, at_most=parameter.high)
        values[key.text] = reader.number(value, QUANTITY_OF[parameter.unit], bounds)
    return values


def _bus(reader: Reader, node: Node | None) -> BusChoice:
    block = reader.block(node)
    loss = reader.number(block.optional("loss", "0"), NUMBER, Range(at_least=0.0, below=1.0))
    delay = reader.number(block.optional("delay", "0 s"), TIME, _NOT_NEGATIVE)
    seed = reader.integer(block.optional("seed", "0"), 0, 2**63 - 1)
    block.done()
    return BusChoice(loss=loss, delay=delay, seed=seed)


class _Plane:
    """Reads positions: [east, north] in metres or lonlat in degrees, but not both in one file.

    Lonlat positions are laid on the plane that touches the earth at the first of them that is
    read: the first point of the first waterway (azimuthal equidistant projection).
    """

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self._firsts: dict[str, Node] = {}
        self._projection: Transformer | None = None

    def points(self, node: Node, at_least: int) -> list[_Point]:
        """Points of a line, of which no neighbours are the same."""
        places = self._reader.items(node, at_least)
        points = [self.point(each) for each in places]
        for place, (before, point) in zip(places[1:], pairwise(points), strict=True):
            if math.dist(before, point) < _SAME_POINT:
                self._reader.refuse(place, "the same point as the one before", hint="remove one")
        return points

    def point(self, node: Node) -> _Point:
        """A position as north and east [m]."""
        if not isinstance(node, strict_yaml.Mapping):
            east, north = self._pair(node, "[east, north]", LENGTH, (_COORDINATE, _COORDINATE))
            return north, east
        block = self._reader.block(node)
        bounds = Range(at_least=-180.0, at_most=180.0), Range(at_least=-90.0, at_most=90.0)
        lon, lat = self._pair(block.require("lonlat"), "lonlat", NUMBER, bounds)
        return self._projected(node, lon, lat) if block.done() else (math.nan, math.nan)

    def _pair(
        self, node: Node, kind: str, quantity: strict_yaml.Quantity, bounds: tuple[Range, Range]
    ) -> _Point:
        hint = "a position is [east, north] in metres, or {lonlat: [longitude, latitude]}"
        items = self._reader.items(node, 2, 2, hint=hint)
        if len(items) != 2:
            return math.nan, math.nan
        if kind not in self._firsts and self._firsts:
            (other, first), *_ = self._firsts.items()
            hint = f"this file began with {other}, at line {first.line}; write all positions in that way"
            self._reader.refuse(node, f"{kind} and {other} positions in one file", hint=hint)
        self._firsts.setdefault(kind, node)
        one, two = (
            self._reader.number(each, quantity, within, bare=True)
            for each, within in zip(items, bounds, strict=True)
        )
        return one, two

    def _projected(self, node: Node, lon: float, lat: float) -> _Point:
        if self._projection is None:
            self._projection = _projection(lon, lat)
        east, north = self._projection.transform(lon, lat)
        if not math.hypot(east, north) < _FARTHEST:
            hint = "lonlat is [longitude, latitude], in this order"
            distance = f"more than {_FARTHEST / KILOMETRE:.0f} km"
            self._reader.refuse(node, f"{distance} from the first position", hint=hint)
        return LENGTH.keep(north), LENGTH.keep(east)


def _projection(lon: float, lat: float) -> Transformer:
    from pyproj import Transformer

    plane = f"+proj=aeqd +lon_0={lon} +lat_0={lat} +datum=WGS84 +units=m"
    return Transformer.from_crs("EPSG:4326", plane, always_xy=True)


def dump_scenario(scenario: Scenario) -> str:
    """Write a scenario as resolved: read back, it gives the same voyage.

    What came from a file comes back bit for bit; other numbers keep twelve digits.  Positions
    are [east, north], whatever they were.
    """
    control = scenario.control
    chosen = {"wait": control.wait, "risk_shape": control.risk_shape}
    tree: dict[str, _Tree] = {
        "schema": SCHEMA,
        "name": written(scenario.name),
        **{key: written(text) for key in ("title", "description") if (text := getattr(scenario, key))},
        "time": {"step": TIME.write(scenario.time_step), "duration": TIME.write(scenario.duration)},
        "waters": _waters_tree(scenario.waters),
        "ships": [_plan_tree(plan) for plan in scenario.ships],
        "control": {
            "horizon": str(control.horizon),
            "iterations": str(control.iterations),
            "profile": control.profile,
            **{key: word for key, word in chosen.items() if word is not None},
            **({"starts": control.starts} if control.starts is not None else {}),
            "deadlock_detection": str(control.deadlock_detection).lower(),
            "parameters": {
                name: QUANTITY_OF[PARAMETERS[name].unit].write(value)
                for name, value in control.parameters.items()
            },
        },
        "bus": {
            "loss": NUMBER.write(scenario.bus.loss),
            "delay": TIME.write(scenario.bus.delay),
            "seed": str(scenario.bus.seed),
        },
    }
    return "\n".join(_lines(tree)) + "\n"


def _waters_tree(waters: Waters) -> dict[str, _Tree]:
    tree: dict[str, _Tree] = {"ruleset": written(waters.ruleset)}
    if waters.regions:
        tree["regions"] = [
            {"id": written(each.id), "ruleset": written(each.ruleset), "polygon": _points(each.polygon)}
            for each in waters.regions
        ]
    tree["waterways"] = [
        {
            "id": written(each.id),
            "centreline": _points(each.centreline),
            "width": LENGTH.write(each.width),
            "upstream": each.upstream,
            **_facts_tree(each.facts),
        }
        for each in waters.waterways
    ]
    if waters.obstacles:
        tree["obstacles"] = [
            {"id": written(each.id), "at": _position(each.x, each.y), "radius": LENGTH.write(each.radius)}
            for each in waters.obstacles
        ]
    return tree


def _plan_tree(plan: Plan) -> dict[str, _Tree]:
    hull = plan.ship.hull
    usual = Hull(length=hull.length, beam=hull.beam)
    safety = {
        key: LENGTH.write(getattr(hull, key))
        for key in ("safety_length", "safety_beam")
        if getattr(hull, key) != getattr(usual, key)
    }
    return {
        "id": written(plan.ship.id),
        "length": LENGTH.write(hull.length),
        "beam": LENGTH.write(hull.beam),
        **safety,
        "weight": MASS.write(plan.ship.mass),
        "route": [
            {"waterway": written(leg.waterway), "towards": leg.towards, "offset": LENGTH.write(leg.offset)}
            for leg in plan.route
        ],
        "start": _position(plan.start.x, plan.start.y),
        "course": ANGLE.write(_full_circle(plan.start.course)),
        "speed": SPEED.write(plan.speed),
        **_facts_tree(plan.ship.facts),
    }


def _facts_tree(facts: Facts) -> dict[str, _Tree]:
    return {"facts": {written(name): _fact_text(value) for name, value in facts.items()}} if facts else {}


def _fact_text(value: FactValue) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(float(value))
    return value.value if value is UNKNOWN else written(value) if isinstance(value, str) else str(value)


def _points(points: FloatArray) -> list[_Tree]:
    return [_position(north, east) for north, east in points]


def _position(north: float, east: float) -> list[_Tree]:
    return [NUMBER.write(east), NUMBER.write(north)]


def _lines(tree: Mapping[str, _Tree] | Sequence[_Tree], width: int = _WIDTH) -> Iterator[str]:
    """Lines in block style; what fits on a line is in flow style."""
    pairs = tree.items() if isinstance(tree, Mapping) else (("-", each) for each in tree)
    for key, value in pairs:
        lead = "- " if key == "-" else f"{key}: "
        flow = lead + _flow(value)
        if isinstance(value, str) or len(flow) <= width:
            yield flow
        elif key == "-":
            first, *rest = _lines(value, width - 2)
            yield lead + first
            yield from ("  " + line for line in rest)
        else:
            yield lead.rstrip()
            yield from ("  " + line for line in _lines(value, width - 2))


def _flow(tree: _Tree) -> str:
    if isinstance(tree, str):
        return tree
    if isinstance(tree, Mapping):
        return "{" + ", ".join(f"{key}: {_flow(value)}" for key, value in tree.items()) + "}"
    return "[" + ", ".join(_flow(each) for each in tree) + "]"
