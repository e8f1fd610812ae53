"""Cases read from files: the tests of a ruleset file, and encounter files.

A test of a ruleset file writes numbers with units (`length: 12 m`); an encounter file has the unit in the
name of the key (`length_m: 12.0`).  Both give the same `Case`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from ..errors import Diagnostic, RulesetError
from ..findings import read_text
from ..quantities import ANGLE, LENGTH, SPEED, TIME, Range
from ..roles import Geometry
from ..ships import UNKNOWN, ShipId
from ..strict_yaml import Block, Reader
from ..units import DEGREE
from ..yaml_nodes import Mapping as Keys
from ..yaml_nodes import Node, Scalar, Sequence, is_missing
from .case_expected import ExpectationReader
from .cases import Case, CaseShip
from .vocabulary import VOCABULARY, Fact, Scope, Vocabulary
from .vocabulary import Kind as FactKind

_PROSE: Final = ("schema_version", "about", "conventions", "kinds", "strengths", "confidence", "regime_flags")
_SPEED: Final = Range(at_least=0.0, at_most=100.0)
_NAMELESS: Final = {  # where no ship is named, none is
    "overtaker": ("head_on", "crossing", "none"),
    "has_other_on_starboard": ("head_on", "overtaking", "none"),
}
_NAMED_SHIPS: Final = ("overtaker", "has_other_on_starboard")
_PLACES: Final = ("same_waterway", "same_direction")  # where the ships are, which says nothing of a risk
_HINTS: Final = ("tcpa_s", "dcpa_m")  # illustration of an encounter whose geometry is stated


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseFile:
    """The cases of an encounter file, and those that could not be read."""

    source: str
    cases: tuple[Case, ...]
    findings: tuple[Diagnostic, ...]
    broken: tuple[str, ...]  # ids of cases with findings


def read_tests(reader: Reader, node: Node | None, ruleset: str, vocabulary: Vocabulary) -> tuple[Case, ...]:
    """Read the tests of a ruleset file."""
    names: dict[str, Node] = {}
    return tuple(
        case
        for each in reader.items(node)
        if (case := _CaseReader(reader, vocabulary, in_units=True).test(each, ruleset, names)) is not None
    )


def load_cases(path: str | Path, vocabulary: Vocabulary = VOCABULARY) -> CaseFile:
    """Read an encounter file; see `parse_cases`."""
    return parse_cases(read_text(path, RulesetError), str(path), vocabulary)


def parse_cases(text: str, source: str = "cases", vocabulary: Vocabulary = VOCABULARY) -> CaseFile:
    """Read the text of an encounter file.

    A case with a fault does not hinder the others: it is named in `broken`, its faults in `findings`.

    Raises
    ------
    RulesetError
        If the file as a whole cannot be read.
    """
    reader = Reader(text, source, RulesetError)
    if not isinstance(reader.root, Keys):
        reader.stop(reader.root, "the file holds no cases", expected="golden_cases, hard_cases or cases")
    root = reader.block(reader.root)
    for key in _PROSE:
        root.find(key)
    root.find("rulesets")
    defaults = _defaults(reader, root.find("defaults"), vocabulary)
    cases: list[Case] = []
    broken: list[str] = []
    ids: dict[str, Node] = {}
    lists = [(key, root.find(key)) for key in ("golden_cases", "cases", "hard_cases")]
    if all(node is None for _, node in lists):
        reader.refuse(reader.root, "the file holds no cases", expected="golden_cases, hard_cases or cases")
    for key, node in lists:
        for each in reader.items(node):
            before = reader.count
            found = _CaseReader(reader, vocabulary, in_units=False, defaults=defaults).case(
                each, ids, hard=key == "hard_cases"
            )
            if reader.count > before or found is None:
                broken.append(found.id if found else f"line {each.line}")
            else:
                cases.append(found)
    root.done()
    return CaseFile(source=source, cases=tuple(cases), findings=reader.told(), broken=tuple(broken))


def is_case_file(reader: Reader) -> bool:
    """Whether a file without a schema is an encounter file."""
    if not isinstance(reader.root, Keys):
        return False
    keys = {key.text for key, _ in reader.root.entries}
    return "schema" not in keys and bool(keys & {"golden_cases", "hard_cases", "cases"})


def _defaults(reader: Reader, node: Node | None, vocabulary: Vocabulary) -> dict[Scope, dict[str, Any]]:
    """Values that hold where a case states none, besides those of the vocabulary."""
    block = reader.block(node)
    read = _CaseReader(reader, vocabulary, in_units=False)
    found = {
        Scope.SHIP: read.facts(block.find("ship"), Scope.SHIP),
        Scope.WATERWAY: read.facts(block.find("waterway"), Scope.WATERWAY),
    }
    block.done()
    return found


class _CaseReader:
    """Reads one case."""

    def __init__(
        self,
        reader: Reader,
        vocabulary: Vocabulary,
        *,
        in_units: bool,
        defaults: Mapping[Scope, Mapping[str, Any]] | None = None,
    ) -> None:
        self._reader, self._vocabulary, self._in_units = reader, vocabulary, in_units
        self._defaults = defaults or {}
        self._expectations = ExpectationReader(reader)

    # -- whole cases -----------------------------------------------------------------------------

    def test(self, node: Node, ruleset: str, names: dict[str, Node]) -> Case | None:
        """Read a test of a ruleset file."""
        reader = self._reader
        block = reader.block(node)
        name = reader.unique(names, block.require("name"), "test")
        ships = self._ships(block.require("ships"), least=2)
        waterway = self.facts(block.find("waterway"), Scope.WATERWAY)
        encounter = self._encounter(block.find("encounter"), ships)
        expect = block.require("expect")
        expected = self._expectations.expected(expect, ships)
        if not block.done():
            return None
        return Case(
            id=name,
            title=name,
            ships=ships,
            waterway=waterway,
            encounter=encounter,
            expected={ruleset: expected},
            strict=True,
            source=reader.source,
            line=node.line,
        )

    def case(self, node: Node, ids: dict[str, Node], *, hard: bool) -> Case | None:
        """Read a case of an encounter file."""
        reader = self._reader
        block = reader.block(node)
        id_ = reader.unique(ids, block.require("id"), "case")
        title = block.find("title")
        tags = block.find("tags")
        block.find("note")
        placed = block.find("ships")
        ships = self._ships(placed, least=2) if placed else ()
        waterway = {
            **self._defaults.get(Scope.WATERWAY, {}),
            **self.facts(block.find("waterway"), Scope.WATERWAY),
        }
        encounter = self._encounter(block.find("encounter"), ships)
        order = self._expectations.resolution(block.find("resolution"))
        expected = {
            key.text: self._expectations.expected(value, ships, hard=hard, order=order, placed=bool(ships))
            for key, value in reader.entries(block.require("expected"))
        }
        words = [reader.text(each) for each in reader.items(tags)] if tags else []
        block.done()
        if not id_:
            return None
        return Case(
            id=id_,
            title=reader.text(title) if title else "",
            ships=ships,
            waterway=waterway,
            encounter=encounter,
            expected=expected,
            tags=tuple(words),
            hard=hard,
            source=reader.source,
            line=node.line,
        )

    # -- facts -----------------------------------------------------------------------------------

    def _ships(self, node: Node | None, least: int) -> tuple[CaseShip, ...]:
        reader = self._reader
        ships = []
        entries = reader.entries(node)
        for key, value in entries:
            facts = dict(self._defaults.get(Scope.SHIP, {}))
            pose, speed, rest = self._kinematics(value)
            facts |= self.facts(rest, Scope.SHIP)
            ships.append(CaseShip(id=ShipId(key.text), facts=facts, pose=pose, speed=speed))
        if node is not None and not is_missing(node) and len(entries) < least:
            reader.refuse(node, f"{len(entries)} ship(s)", expected=f"at least {least}")
        return tuple(ships)

    def _kinematics(self, node: Node) -> tuple[tuple[float, float, float] | None, float | None, Node]:
        """Pose and speed of a ship, and the node without them."""
        if not isinstance(node, Keys):
            return None, None, node
        keys = {key.text: (key, value) for key, value in node.entries}
        if self._in_units:
            names = ("at", "course", "speed")
            rest = Keys(node.line, node.column, tuple(e for e in node.entries if e[0].text not in names))
            found = [keys[name][1] for name in names if name in keys]
            if not found:
                return None, None, node
            if len(found) < 3:
                hint = "say all three, or none of them"
                self._reader.refuse(
                    node, "a ship that is only partly placed", expected="at, course, speed", hint=hint
                )
                return None, None, rest
            ends = self._reader.items(found[0], 2, 2)
            east, north = ([self._reader.number(each, LENGTH) for each in ends] + [math.nan, math.nan])[:2]
            course = self._reader.number(found[1], ANGLE)
            return (north, east, course), self._reader.number(found[2], SPEED, _SPEED), rest
        if "kinematics" not in keys:
            return None, None, node
        rest_entries = [each for each in node.entries if each[0].text != "kinematics"]
        block = self._reader.block(keys["kinematics"][1])
        north, east = (self._bare(block.require(key)) for key in ("north_m", "east_m"))
        course = self._bare(block.require("course_deg")) * DEGREE
        speed = self._bare(block.require("speed_mps"))
        if (heading := block.find("heading_deg")) is not None:
            self._bare(heading)
            rest_entries.append((Scalar(heading.line, heading.column, "heading_deg"), heading))
        block.done()
        return (north, east, course), speed, Keys(node.line, node.column, tuple(rest_entries))

    def _bare(self, node: Node) -> float:
        value = node.value if isinstance(node, Scalar) else None
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            self._reader.refuse(
                node, "this is no finite number", expected="a number; its unit stands in the key"
            )
            return math.nan
        return float(value)

    def facts(self, node: Node | None, scope: Scope) -> dict[str, Any]:
        """Stated facts of a ship or a waterway, in SI, by their names in the vocabulary."""
        known = {self._key(fact): fact for fact in self._vocabulary.by_scope[scope]}
        found: dict[str, Any] = {}
        for key, value in self._reader.entries(node):
            fact = known.get(key.text)
            if fact is None:
                self._reader.unknown(key, f"fact of a {scope}", key.text, known)
                continue
            found[fact.name] = self.fact(value, fact)
        return found

    def _key(self, fact: Fact) -> str:
        return fact.name if self._in_units else fact.key

    def fact(self, node: Node, fact: Fact) -> Any:
        """A stated value of a fact; `unknown` is one."""
        if isinstance(node, Scalar) and node.text == UNKNOWN.value and fact.kind is not FactKind.FLAGS:
            return UNKNOWN
        return read_fact(self._reader, node, fact, in_units=self._in_units)

    def _encounter(self, node: Node | None, ships: Iterable[CaseShip]) -> dict[str, Any]:
        """Stated facts of the pair: geometry, and the ships that it names."""
        if node is None:
            return {}
        reader = self._reader
        block = reader.block(node)
        ids = [ship.id for ship in ships]
        keys = {key.text for key, _ in node.entries} if isinstance(node, Keys) else set()
        found: dict[str, Any] = {} if keys and keys <= set(_PLACES) else {"risk_of_collision": True}
        for name in _PLACES:
            if (place := block.find(name)) is not None:
                found[name] = _maybe(place, reader.flag)
        if (risk := block.find("risk_of_collision")) is not None:
            found["risk_of_collision"] = _maybe(risk, reader.flag)
        if (geometry := block.find("geometry")) is not None:
            found["geometry"] = _maybe(geometry, lambda each: reader.choice(each, Geometry).value)
        for name in _NAMED_SHIPS:
            if (named := block.find(name)) is not None:
                found[name] = _maybe(named, lambda each: self._expectations.ship(each, ids))
        if (windward := block.find("windward")) is not None:
            found["windward"] = self._expectations.ship(windward, ids)
        times = block.find("time_to_intersection" if self._in_units else "time_to_intersection_s")
        if times is not None:
            found["time_to_intersection"] = {
                ShipId(self._expectations.ship(key, ids)): self._time(value)
                for key, value in reader.entries(times)
            }
        self._illustrations(block, node)
        for name, geometries in _NAMELESS.items():
            if found.get("geometry") in geometries:
                found.setdefault(name, "none")
        block.done()
        return found

    def _illustrations(self, block: Block, node: Node) -> None:
        """Numbers that stand beside a stated geometry: they must be numbers, and decide nothing."""
        if self._in_units or not isinstance(node, Keys):
            return
        for key, value in node.entries:
            if key.text in _HINTS or re.fullmatch("bearing_of_.*_deg", key.text):
                block.find(key.text)
                self._bare(value)

    def _time(self, node: Node) -> float:
        return self._reader.number(node, TIME) if self._in_units else self._bare(node)


def read_fact(reader: Reader, node: Node, fact: Fact, *, in_units: bool) -> Any:
    """Read a known value of a fact, in SI; `in_units` says that a number has its unit beside it."""
    if fact.kind is FactKind.FLAG:
        return reader.flag(node)
    if fact.kind is FactKind.CHOICE:
        text = reader.text(node)
        if text and text not in fact.choices:
            reader.unknown(node, f"value of '{fact.name}'", text, fact.choices)
        return text
    if fact.kind is FactKind.FLAGS:
        nodes = node.items if isinstance(node, Sequence) else (node,)
        return " ".join(reader.text(each) for each in nodes)
    if fact.kind is FactKind.TEXT:
        return reader.text(node)
    value = node.value if isinstance(node, Scalar) else None
    if in_units and fact.quantity.unit:
        return reader.number(node, fact.quantity)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        reader.refuse(node, f"'{fact.name}' is a number", expected="a finite number")
        return math.nan
    return value * fact.quantity.units[fact.quantity.unit]


def _maybe(node: Node, read: Callable[[Node], Any]) -> Any:
    return UNKNOWN if isinstance(node, Scalar) and node.text == UNKNOWN.value else read(node)
