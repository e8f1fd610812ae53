"""A ruleset file as it is read, before its base is merged in: keys checked, conditions still texts.

Every value keeps its place, so that a fault found later is told where it was written.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import date
from fractions import Fraction
from typing import Final

from ..findings import Place
from ..strict_yaml import Reader
from ..verdict import Citation
from ..yaml_nodes import Node, Scalar
from .cases import Case
from .language import syntax
from .language.compiler import Definition, Parameter
from .rules import Mirror, Order, Outcome, Policy

SCHEMA: Final = "ccas/ruleset@1"


@dataclass(frozen=True, slots=True)
class Condition:
    """The text of a condition and its place; several lines of a list are joined by `and`."""

    text: str
    node: Node
    reader: Reader


@dataclass(frozen=True, slots=True)
class Unless:
    """An exception to a rule, which may have exceptions of its own."""

    when: tuple[Condition, ...]
    unless: tuple[Unless, ...]
    citation: Citation | None


@dataclass(frozen=True, slots=True, kw_only=True)
class DraftRule:
    """A rule as written."""

    id: str
    node: Node
    reader: Reader
    where: tuple[Condition, ...]
    when: tuple[Condition, ...]
    unless: tuple[Unless, ...]
    outcome: Outcome | None
    python: str
    python_node: Node
    citation: Citation
    because: str
    note: str
    before: Scalar | None
    after: Scalar | None
    replaces: Scalar | None
    origin: str


@dataclass(frozen=True, slots=True, kw_only=True)
class DraftGate:
    """A gate as written."""

    id: str
    node: Node
    reader: Reader
    when: tuple[Condition, ...]
    off: tuple[Scalar, ...]
    citation: Citation


@dataclass(frozen=True, slots=True, kw_only=True)
class DraftWaiver:
    """A waiver as written."""

    check: str
    reason: str
    expires: date
    rules: tuple[Scalar, ...]
    node: Node
    reader: Reader


@dataclass(frozen=True, slots=True, kw_only=True)
class DraftClaim:
    """A claim as written."""

    name: str
    check: str
    assume: tuple[Condition, ...]
    on_a_reach: bool
    node: Node
    reader: Reader


@dataclass(slots=True, kw_only=True)
class Draft:
    """All that one ruleset file says."""

    reader: Reader
    path: str
    id: str
    version: str
    title: str
    description: str
    abstract: bool
    extends: Scalar | None
    regulation: str
    edition: str
    parameters: dict[str, tuple[Parameter, Node]] = field(default_factory=dict)
    definitions: dict[str, tuple[Definition, Condition]] = field(default_factory=dict)
    regimes: dict[str, tuple[str, Node]] = field(default_factory=dict)
    policy: Policy | None = None
    mirror: Mirror | None = None
    recognition: dict[str, Condition] = field(default_factory=dict)
    gates: list[DraftGate] = field(default_factory=list)
    rules: list[DraftRule] = field(default_factory=list)
    removed: list[Scalar] = field(default_factory=list)
    recited: dict[str, tuple[Citation, Node]] = field(default_factory=dict)
    otherwise: Citation | None = None
    resolve_by: tuple[tuple[Order, Node], ...] | None = None
    speed: tuple[Fraction, Fraction] | None = None
    length: tuple[Fraction, Fraction] | None = None
    separation: Fraction | None = None
    assume: tuple[Condition, ...] = ()
    waivers: list[DraftWaiver] = field(default_factory=list)
    claims: list[DraftClaim] = field(default_factory=list)
    tests: tuple[Case, ...] = ()


def joined(conditions: Iterable[Condition]) -> Condition:
    """Several conditions as one, of which the first gives the place."""
    first, *more = conditions
    if not more:
        return first
    text = " and ".join(f"({each.text})" for each in (first, *more))
    return Condition(text, first.node, first.reader)


def refuse(condition: Condition, fault: syntax.Fault, reader: Reader | None = None, code: str = "") -> None:
    """Tell what is wrong with a condition, under the letters that are meant."""
    reader = reader or condition.reader
    node, span = condition.node, fault.span
    line = reader.line(node.line)
    quote = 0 if isinstance(node, Scalar) and node.plain else 1
    start = node.column - 1 + quote
    if line[start : start + len(condition.text)] == condition.text:
        place, width = Place(node.line, start + span.begin + 1), max(1, span.end - span.begin)
    else:
        part = condition.text[span.begin : span.end]
        place, width = _found(reader, node, part)
    reader.refuse(place, fault.message, expected=fault.expected, hint=fault.hint, width=width, code=code)


def _found(reader: Reader, node: Node, part: str) -> tuple[Place, int]:
    """Where the letters meant stand, in a text that goes over several lines."""
    for number in range(node.line, node.line + 20):
        column = reader.line(number).find(part, node.column - 1 if number == node.line else 0)
        if part and column >= 0:
            return Place(number, column + 1), len(part)
    return Place(node.line, node.column), 1
