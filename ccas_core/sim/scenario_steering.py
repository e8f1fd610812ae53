"""Who steers a ship of a scenario, its domain, its limits and its track: read from a file, and written."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from ..controllers import COOPERATIVE, RESERVED, AbstractController, Control, Option
from ..domains import AbstractDomain, DynamicBumper, Ellipse
from ..quantities import ACCELERATION, ANGLE, NUMBER, SPEED, TIME, YAW_ACCELERATION, YAW_RATE, Range
from ..ships import Hull
from ..strict_yaml import Block, Reader
from ..surge_yaw import Current, Manoeuvrability, usual
from ..units import DEGREE
from ..yaml_nodes import Mapping as Keys
from ..yaml_nodes import Node, Scalar, written
from .given_track import MADE_GOOD, GivenTrack, recorded
from .plane import Plane

if TYPE_CHECKING:
    from .scenario import Plan

Tree: TypeAlias = "str | Mapping[str, Tree] | Sequence[Tree]"  # leaves are YAML already

_POSITIVE: Final = Range(above=0.0)
_SPEED: Final = Range(at_least=0.0, at_most=30.0)
_COURSE: Final = Range(at_least=-360.0 * DEGREE, at_most=360.0 * DEGREE)
_UNKNOWN: Final = "unknown"
_LIMITS: Final = {  # key in files -> field, quantity
    "max_speed": ("max_speed", SPEED),
    "yaw_rate": ("max_yaw_rate", YAW_RATE),
    "acceleration": ("acceleration", ACCELERATION),
    "yaw_acceleration": ("yaw_acceleration", YAW_ACCELERATION),
}


class Shape(StrEnum):
    """Safety domains that a file may name."""

    RECTANGLE = "rectangle"
    ELLIPSE = "ellipse"
    DYNAMIC_BUMPER = "dynamic_bumper"


def domain_of(shape: Shape, hull: Hull, full_speed: float) -> AbstractDomain | None:
    """Domain of a shape for a hull; None is the safety area of the hull, the rectangle.

    The ellipse has the length of a dynamic bumper at full speed, half ahead and half astern, and its breadth.
    """
    bumper = DynamicBumper(length=hull.length, full_speed=full_speed)
    if shape is Shape.DYNAMIC_BUMPER:
        return bumper
    if shape is Shape.ELLIPSE:
        aside = bumper.at_rest * hull.length
        return Ellipse(ahead=(bumper.reach(full_speed) + aside) / 2.0, aside=aside)
    return None


def read_current(reader: Reader, node: Node | None) -> Current:
    """Read the current of the waters; none stated is still water."""
    if node is None:
        return Current()
    block = reader.block(node)
    speed = reader.number(block.require("speed"), SPEED, _SPEED)
    towards = reader.number(block.require("towards"), ANGLE, _COURSE)
    block.done()
    return Current(north=speed * math.cos(towards), east=speed * math.sin(towards))


def read_control(reader: Reader, node: Node, controllers: Mapping[str, AbstractController] | None) -> Control:
    """Read who steers a ship: a word, or keys with the word under `by` and options of that controller."""
    if not isinstance(node, Keys):
        return Control(by=_steerer(reader, node, controllers))
    block = reader.block(node)
    by = _steerer(reader, block.require("by"), controllers)
    if controllers is None:  # whatever its options are, they are not looked at
        return Control(by=by)
    controller = controllers.get(by)
    options = {}
    for name, option in (controller.options if controller else {}).items():
        if (stated := block.find(name)) is not None:
            options[name] = _option(reader, stated, option)
    block.done()
    return Control(by=by, options=options)


def _steerer(reader: Reader, node: Node, controllers: Mapping[str, AbstractController] | None) -> str:
    by = reader.text(node)
    if by and by not in RESERVED and controllers is not None and by not in controllers:
        reader.unknown(node, "controller", by, [*RESERVED, *controllers])
    return by


def _option(reader: Reader, node: Node, option: Option) -> float | str:
    if option.quantity is not None:
        return reader.number(node, option.quantity, option.within)
    word = reader.text(node)
    if word and word not in option.choices:
        reader.unknown(node, "choice", word, option.choices)
    return word


def read_limits(reader: Reader, node: Node | None, length: float, speed: float) -> Manoeuvrability | None:
    """Read what a ship can do; what is not stated is usual for its length and speed."""
    if node is None:
        return None
    block = reader.block(node)
    stated = {
        name: reader.number(found, quantity, _POSITIVE)
        for key, (name, quantity) in _LIMITS.items()
        if (found := block.find(key)) is not None
    }
    if not block.done() or not (length > 0.0 and speed > 0.0):
        return None
    usually = usual(length, stated.get("max_speed", speed))
    return Manoeuvrability(**{name: stated.get(name, getattr(usually, name)) for name, _ in _LIMITS.values()})


def read_track(reader: Reader, node: Node | None, plane: Plane, folder: Path) -> GivenTrack | None:
    """Read a track: rows with a time and a position, or the name of a table (CSV) beside the scenario."""
    if node is None:
        return None
    try:
        if isinstance(node, Keys):
            return _read_table(reader, reader.block(node), folder)
        before = reader.count
        rows = [_row(reader, each, plane) for each in reader.items(node, 2)]
        return GivenTrack(np.array(rows)) if reader.count == before else None
    except ValueError as error:
        hint = "times rise from row to row, and two rows at least have a position"
        reader.refuse(node, f"no track can be made of this: {error}", hint=hint)
        return None


def _read_table(reader: Reader, block: Block, folder: Path) -> GivenTrack | None:
    name = reader.text(place := block.require("csv"))
    ship = block.find("ship")
    of = reader.text(ship) if ship else ""
    if not block.done():
        return None
    try:
        text = (folder / name).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or "is not text in UTF-8"
        reader.refuse(place, f"the table '{name}' cannot be read: {why}", hint="paths begin at the scenario")
        return None
    try:
        return recorded(text.splitlines(), of)
    except ValueError as error:
        expected = "columns time_s, east_m, north_m, and course_rad and speed_mps where they are known"
        reader.refuse(place, f"the table '{name}' is no track: {error}", expected=expected)
        return None


def _row(reader: Reader, node: Node, plane: Plane) -> list[float]:
    block = reader.block(node)
    time = reader.number(block.require("time"), TIME)
    place = block.require("at")
    north, east = (math.nan, math.nan) if _is_unknown(place) else plane.point(place)
    more = []
    for key, quantity in (("course", ANGLE), ("speed", SPEED)):
        said = block.find(key)
        if said is None:
            more.append(MADE_GOOD)
        else:
            more.append(math.nan if _is_unknown(said) else reader.number(said, quantity))
    block.done()
    return [time, north, east, *more]


def _is_unknown(node: Node) -> bool:
    return isinstance(node, Scalar) and node.text == _UNKNOWN


def current_tree(current: Current) -> dict[str, Tree]:
    """Write the current of the waters; nothing for still water."""
    if not current.speed:
        return {}
    return {"current": {"speed": SPEED.write(current.speed), "towards": ANGLE.write(current.course)}}


def steering_tree(plan: Plan, controllers: Mapping[str, AbstractController]) -> dict[str, Tree]:
    """Write who steers a ship, and how; nothing for a ship of the core with the usual safety area."""
    tree: dict[str, Tree] = {}
    if plan.control.by != COOPERATIVE:
        tree["control"] = _control_tree(plan.control, controllers)
    domain = plan.ship.stated_domain
    if domain is not None:
        tree["domain"] = Shape.DYNAMIC_BUMPER if isinstance(domain, DynamicBumper) else Shape.ELLIPSE
    if plan.limits is not None:
        tree["manoeuvring"] = {
            key: quantity.write(getattr(plan.limits, name)) for key, (name, quantity) in _LIMITS.items()
        }
    if plan.track is not None:
        tree["track"] = [_row_tree(row.tolist()) for row in plan.track.rows]
    return tree


def _control_tree(control: Control, controllers: Mapping[str, AbstractController]) -> Tree:
    if not control.options:
        return control.by
    known = controllers[control.by].options
    tree: dict[str, Tree] = {"by": control.by}
    for name, value in control.options.items():
        quantity = known[name].quantity
        tree[name] = quantity.write(float(value)) if quantity else written(str(value))
    return tree


def _row_tree(row: Sequence[float]) -> dict[str, Tree]:
    time, north, east, course, speed = row
    tree: dict[str, Tree] = {"time": TIME.write(time)}
    if math.isnan(north):
        return {**tree, "at": _UNKNOWN}
    tree["at"] = [NUMBER.write(east), NUMBER.write(north)]
    tree["course"] = _UNKNOWN if math.isnan(course) else ANGLE.write(course)
    tree["speed"] = _UNKNOWN if math.isnan(speed) else SPEED.write(speed)
    return tree
