"""Scenarios read from YAML files, with all their faults at once."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np

from ..agent.events import Conduct
from ..controllers import COOPERATIVE, TRACKED, AbstractController
from ..dmpc.parameters import PARAMETERS, RiskShape, Start, Wait
from ..errors import ScenarioError
from ..findings import read_text
from ..frames import NedPose
from ..quantities import ANGLE, LENGTH, MASS, NUMBER, QUANTITY_OF, SPEED, TIME, Range
from ..regions import Region
from ..ships import Hull, Ship, ShipId
from ..strict_yaml import Reader
from ..tapd.vocabulary import VOCABULARY, Scope, Vocabulary
from ..units import DEGREE, wrap
from ..waterway import GuidingLine, Leg, Obstacle, Towards, Waters, Waterway, guiding_line
from ..yaml_nodes import Node
from ..yaml_nodes import Sequence as List
from .plane import IN_DEGREES, Plane, Point
from .scenario import BusChoice, ControlChoice, Plan, Profile, Scenario
from .scenario_facts import read_facts
from .scenario_regions import read_carried, read_hysteresis, read_law, read_region, refuse_together
from .scenario_steering import Shape, domain_of, read_control, read_current, read_limits, read_track

SCHEMA: Final = "ccas/scenario@1"

_POSITIVE: Final = Range(above=0.0)
_NOT_NEGATIVE: Final = Range(at_least=0.0)
_SPEED: Final = Range(above=0.0, at_most=30.0)
_OFFSET: Final = Range(at_least=-1000.0, at_most=1000.0)
_COURSE: Final = Range(at_least=-360.0 * DEGREE, at_most=360.0 * DEGREE)
_MAX_LEGS: Final = 100
_SHARPEST_BEND: Final = 150.0 * DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class _Known:
    """What a scenario may name."""

    rulesets: Collection[str] | None
    regions: Mapping[str, Region]
    vocabulary: Vocabulary
    controllers: Mapping[str, AbstractController] | None
    folder: Path  # where tables that a scenario names are looked for


def load_scenario(
    path: str | Path,
    rulesets: Collection[str] | None = None,
    *,
    regions: Mapping[str, Region] | None = None,
    vocabulary: Vocabulary = VOCABULARY,
    controllers: Mapping[str, AbstractController] | None = None,
) -> Scenario:
    """Read a scenario file.

    Parameters
    ----------
    path
        The file.
    rulesets
        Rulesets that there are, by id, or ids alone: then versions are not checked; None: nothing is.
    regions
        Regions of plugins, which a scenario may name.
    vocabulary
        Facts that ships and waterways may state.
    controllers
        Controllers of plugins, which ships may name; None: neither they nor their options are looked at.

    Raises
    ------
    ScenarioError
        With all that is wrong, each with its place.
    """
    text = read_text(path, ScenarioError)
    return parse_scenario(
        text, str(path), rulesets, regions=regions, vocabulary=vocabulary, controllers=controllers
    )


def parse_scenario(
    text: str,
    source: str = "scenario",
    rulesets: Collection[str] | None = None,
    *,
    regions: Mapping[str, Region] | None = None,
    vocabulary: Vocabulary = VOCABULARY,
    controllers: Mapping[str, AbstractController] | None = None,
) -> Scenario:
    """Read the text of a scenario file; `source` is what findings call it.  See `load_scenario`."""
    reader = Reader(text, source, ScenarioError)
    root = reader.document(SCHEMA)
    plane = Plane(reader)
    known = _Known(
        rulesets=rulesets,
        regions=regions or {},
        vocabulary=vocabulary,
        controllers=controllers,
        folder=Path(source).parent,
    )
    title, description = root.find("title"), root.find("description")
    time_step, duration = _time(reader, root.require("time"))
    waters, waterways = _waters(reader, root.require("waters"), plane, known)
    scenario = Scenario(
        name=reader.text(root.require("name")),
        title=reader.text(title) if title else "",
        description=reader.text(description) if description else "",
        time_step=time_step,
        duration=duration,
        waters=waters,
        ships=_ships(reader, root.require("ships"), plane, waters, waterways, known),
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


def _waters(reader: Reader, node: Node, plane: Plane, known: _Known) -> tuple[Waters, Collection[str]]:
    """What of the waters is well, and the ids of all waterways, well or not."""
    block = reader.block(node)
    ids: tuple[dict[str, Node], ...] = ({}, {}, {})
    drawn_here = reader.items(block.find("regions"))
    everywhere = block.find("ruleset") if drawn_here else block.require("ruleset")
    ruleset = read_law(reader, everywhere, known.rulesets) if everywhere else ""
    reaches = [
        _waterway(reader, each, plane, ids[0], known.vocabulary)
        for each in reader.items(block.require("waterways"), 1)
    ]
    well = {each.id: each for each in reaches if each}
    by_id = {id_: well.get(id_) for id_ in ids[0]}
    regions = [
        read_region(reader, each, plane, ids[1], by_id, known.rulesets, known.regions) for each in drawn_here
    ]
    hysteresis = read_hysteresis(reader, block.find("hysteresis"))
    obstacles = [_obstacle(reader, each, plane, ids[2]) for each in reader.items(block.find("obstacles"))]
    current = read_current(reader, block.find("current"))
    drawn = [each for each in regions if each]
    waters = Waters(
        ruleset=ruleset,
        waterways=tuple(well.values()),
        regions=tuple(each.region for each in drawn),
        obstacles=tuple(each for each in obstacles if each),
        hysteresis=hysteresis,
        current=current,
    )
    if block.done() and drawn:
        refuse_together(reader, block, waters, drawn)
    return waters, ids[0].keys()


def _waterway(
    reader: Reader, node: Node, plane: Plane, ids: dict[str, Node], vocabulary: Vocabulary
) -> Waterway | None:
    block = reader.block(node)
    id_ = reader.unique(ids, block.require("id"), "waterway")
    centreline = _centreline(reader, block.require("centreline"), plane)
    width = reader.number(block.require("width"), LENGTH, _POSITIVE)
    upstream = reader.choice(block.optional("upstream", "none"), Towards)
    facts = read_facts(reader, block.find("facts"), Scope.WATERWAY, vocabulary)
    if not block.done():
        return None
    return Waterway(id=id_, centreline=np.array(centreline), width=width, upstream=upstream, facts=facts)


def _centreline(reader: Reader, node: Node, plane: Plane) -> list[Point]:
    refused = reader.count
    points = plane.points(node, 2)
    if reader.count == refused and plane.are_degrees(points):
        reader.refuse(node, "the centreline is shorter than a ship: are these degrees?", hint=IN_DEGREES)
    courses = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(points)]
    places = node.items[1:] if isinstance(node, List) else ()
    for place, (before, after) in zip(places, pairwise(courses), strict=False):
        if abs(wrap(after - before)) > _SHARPEST_BEND:
            reader.refuse(place, "the centreline turns back here", hint="begin another waterway instead")
    return points


def _obstacle(reader: Reader, node: Node, plane: Plane, ids: dict[str, Node]) -> Obstacle | None:
    block = reader.block(node)
    id_ = reader.unique(ids, block.require("id"), "obstacle")
    north, east = plane.point(block.require("at"))
    radius = reader.number(block.require("radius"), LENGTH, _POSITIVE)
    return Obstacle(id=id_, x=north, y=east, radius=radius) if block.done() else None


def _ships(
    reader: Reader,
    node: Node,
    plane: Plane,
    waters: Waters,
    waterways: Collection[str],
    known: _Known,
) -> tuple[Plan, ...]:
    ids: dict[str, Node] = {}
    plans = [_plan(reader, each, plane, waters, waterways, ids, known) for each in reader.items(node, 1)]
    return tuple(plan for plan in plans if plan)


def _plan(
    reader: Reader,
    node: Node,
    plane: Plane,
    waters: Waters,
    waterways: Collection[str],
    ids: dict[str, Node],
    known: _Known,
) -> Plan | None:
    block = reader.block(node)
    id_ = reader.unique(ids, block.require("id"), "ship")
    size = {key: reader.number(block.require(key), LENGTH, _POSITIVE) for key in ("length", "beam")}
    for key in ("safety_length", "safety_beam"):
        if (stated := block.find(key)) is not None:
            size[key] = reader.number(stated, LENGTH, _POSITIVE)
    mass = reader.number(block.require("weight"), MASS, _POSITIVE)
    legs = reader.items(block.require("route"), 1, _MAX_LEGS)
    route = tuple(_leg(reader, each, waterways) for each in legs)
    north, east = plane.point(at := block.require("start"))
    towards = block.find("course")
    course = reader.number(towards, ANGLE, _COURSE) if towards else None
    speed = reader.number(block.require("speed"), SPEED, _SPEED)
    facts = read_facts(reader, block.find("facts"), Scope.SHIP, known.vocabulary)
    conduct = reader.choice(block.optional("conduct", "dutiful"), Conduct)
    carried = read_carried(reader, block.find("rulesets"), known.rulesets)
    control = read_control(reader, block.optional("control", "cooperative"), known.controllers)
    shape = reader.choice(block.optional("domain", "rectangle"), Shape)
    limits = read_limits(reader, block.find("manoeuvring"), size["length"], speed)
    track = read_track(reader, block.find("track"), plane, known.folder)
    for key, whose in (("track", TRACKED), ("conduct", COOPERATIVE)):
        if control.by and control.by != whose and (stated := block.find(key)) is not None:
            reader.refuse(stated, f"only a {whose} ship has a {key}", hint="remove it, or change 'control'")
    if not block.done() or (line := _line(reader, legs, route, waters)) is None:
        return None
    start = _start(reader, at, NedPose(north, east, 0.0), course, line, waters.waterway(route[0].waterway))
    hull = Hull(**size)
    domain = domain_of(shape, hull, limits.max_speed if limits else speed)
    ship = Ship(id=ShipId(id_), hull=hull, mass=mass, facts=facts, stated_domain=domain)
    return Plan(
        ship=ship,
        route=route,
        start=start,
        speed=speed,
        conduct=conduct,
        rulesets=carried,
        control=control,
        limits=limits,
        track=track,
    )


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
    return NedPose(start.x, start.y, wrap(full_circle(angle)))


def full_circle(angle: float) -> float:
    """An angle as files write courses: from north clockwise, at least 0 and below 360 deg."""
    return ANGLE.keep(angle % math.tau) % math.tau


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
