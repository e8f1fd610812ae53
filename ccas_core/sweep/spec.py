"""What a sweep is to sail: cells of drawn encounters or scenario files, by rulesets and by parameters."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Final

from ..agent.events import Conduct
from ..controllers import RESERVED
from ..dmpc.parameters import PARAMETERS
from ..errors import InputError
from ..findings import read_text
from ..quantities import QUANTITY_OF, TIME, Range
from ..strict_yaml import Block, Reader
from ..yaml_nodes import Node
from .draw import Risk

SCHEMA: Final = "ccas/sweep@1"
_MOST: Final = 1_000_000  # cases of a cell
_SHIPS: Final = (2, 12)  # of a group


class Draw(StrEnum):
    """What a cell draws."""

    HEAD_ON = "head_on"
    CROSSING = "crossing"
    OVERTAKING = "overtaking"
    JUNCTION = "junction"
    REACH = "reach"


TWO_SHIPS: Final = (Draw.HEAD_ON, Draw.CROSSING, Draw.OVERTAKING)


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """Cases of one kind: drawn, or one scenario file."""

    name: str
    count: int
    draw: Draw | None = None
    scenario: str = ""  # path or name of a scenario, where nothing is drawn
    risk: Risk = Risk.RISKY  # of two ships
    ships: tuple[int, int] = (2, 2)  # least and greatest number in a group
    breach: Conduct = Conduct.DUTIFUL  # how the ship that is obliged to give way behaves
    border: tuple[str, str] | None = None  # rulesets on either side of a border through two ships' encounter
    lacking: bool = False  # one of the two ships has not the second of these aboard
    control: tuple[str, str] | None = None  # who steers ship 1 and ship 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """Parameters that take the place of the defaults."""

    name: str = ""
    parameters: tuple[tuple[str, float], ...] = ()  # by name, SI


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """A whole specification."""

    name: str
    seed: int
    rulesets: tuple[str, ...]
    cells: tuple[Cell, ...]
    variants: tuple[Variant, ...] = (Variant(),)
    executor: str = "local"
    deadline: float = 60.0  # of one case [s]
    solver: str = "riccati"
    jointly: int = 0  # cases of each cell of groups that are solved by one mind as well
    title: str = ""


def load_sweep(
    path: str | Path, rulesets: Collection[str] | None = None, controllers: Collection[str] | None = None
) -> Sweep:
    """Read a specification.

    Raises
    ------
    InputError
        With all that is wrong, each with its place.
    """
    return parse_sweep(read_text(path, InputError), str(path), rulesets, controllers)


def parse_sweep(
    text: str,
    source: str = "sweep",
    rulesets: Collection[str] | None = None,
    controllers: Collection[str] | None = None,
) -> Sweep:
    """Read the text of a specification; `source` is what findings call it."""
    reader = Reader(text, source, InputError)
    root = reader.document(SCHEMA)
    names: dict[str, Node] = {}
    variant_names: dict[str, Node] = {}
    title = root.find("title")
    each_cell = reader.items(root.require("cells"), 1)
    cells = tuple(_cell(reader, each, names, rulesets, controllers) for each in each_cell)
    sweep = Sweep(
        name=reader.text(root.require("name")),
        title=reader.text(title) if title else "",
        seed=reader.integer(root.optional("seed", "1"), 0, 2**63 - 1),
        executor=reader.text(root.optional("executor", "local")),
        deadline=reader.number(root.optional("deadline", "60 s"), TIME, Range(above=0.0)),
        solver=reader.text(root.optional("solver", "riccati")),
        jointly=reader.integer(root.optional("jointly", "0"), 0, _MOST),
        cells=cells,
        rulesets=_rulesets(reader, root, cells, rulesets),
        variants=tuple(_variant(reader, each, variant_names) for each in reader.items(root.find("variants")))
        or (Variant(),),
    )
    root.done()
    reader.finish()
    return sweep


def _rulesets(
    reader: Reader, root: Block, cells: Sequence[Cell], known: Collection[str] | None
) -> tuple[str, ...]:
    """Rulesets by which cells are sailed; those with a border have their own, and need no others."""
    node = root.find("rulesets") if all(cell.border for cell in cells) else root.require("rulesets")
    return tuple(_ruleset(reader, each, known) for each in reader.items(node, 1)) if node else ()


def _ruleset(reader: Reader, node: Node, rulesets: Collection[str] | None) -> str:
    ruleset = reader.text(node)
    if ruleset and rulesets is not None and ruleset not in rulesets:
        reader.unknown(node, "ruleset", ruleset, rulesets)
    return ruleset


def _cell(
    reader: Reader,
    node: Node,
    names: dict[str, Node],
    rulesets: Collection[str] | None,
    controllers: Collection[str] | None,
) -> Cell:
    block = reader.block(node)
    name = reader.unique(names, block.require("name"), "cell")
    scenario, draw, ships = block.find("scenario"), block.find("draw"), block.find("ships")
    if (scenario is None) == (draw is None):
        reader.refuse(node, "a cell has either 'draw' or 'scenario'", expected="one of the two")
    border = block.find("border")
    sides = [_ruleset(reader, each, rulesets) for each in reader.items(border, 2, 2)] if border else []
    control = block.find("control")
    steered = [_steerer(reader, each, controllers) for each in reader.items(control, 2, 2)] if control else []
    bounds = [reader.integer(each, *_SHIPS) for each in reader.items(ships, 2, 2)] if ships else [2, 2]
    cell = Cell(
        name=name,
        count=reader.integer(block.optional("count", "1"), 1, _MOST),
        draw=reader.choice(draw, Draw) if draw else None,
        scenario=reader.text(scenario) if scenario else "",
        risk=reader.choice(block.optional("risk", "risky"), Risk),
        ships=(min(bounds, default=2), max(bounds, default=2)),
        breach=reader.choice(block.optional("breach", "dutiful"), Conduct),
        border=(sides[0], sides[1]) if len(sides) == 2 else None,
        control=(steered[0], steered[1]) if len(steered) == 2 else None,
        lacking=reader.flag(lacking := block.optional("lacking", "false")),
    )
    if control and cell.draw not in TWO_SHIPS:
        expected = f"'draw' one of {', '.join(TWO_SHIPS)}"
        reader.refuse(control, "'control' is for encounters of two ships", expected=expected)
    if cell.lacking and not border:
        reader.refuse(lacking, "a ship lacks the ruleset beyond a border", expected="a 'border'")
    if border and cell.draw not in TWO_SHIPS:
        expected = f"'draw' one of {', '.join(TWO_SHIPS)}"
        reader.refuse(border, "a border is drawn through an encounter of two ships", expected=expected)
    block.done()
    return cell


def _steerer(reader: Reader, node: Node, controllers: Collection[str] | None) -> str:
    by = reader.text(node)
    if by and controllers is not None and by not in {*RESERVED, *controllers}:
        reader.unknown(node, "controller", by, [*RESERVED, *controllers])
    return by


def _variant(reader: Reader, node: Node, names: dict[str, Node]) -> Variant:
    block = reader.block(node)
    name = reader.unique(names, block.require("name"), "variant")
    values: dict[str, float] = {}
    for key, value in reader.entries(block.find("parameters")):
        if (parameter := PARAMETERS.get(key.text)) is None:
            reader.unknown(key, "parameter", key.text, PARAMETERS)
            continue
        bounds = Range(at_least=parameter.low, at_most=parameter.high)
        values[key.text] = reader.number(value, QUANTITY_OF[parameter.unit], bounds)
    block.done()
    return Variant(name=name, parameters=tuple(values.items()))
