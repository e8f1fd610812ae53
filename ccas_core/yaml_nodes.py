"""YAML as nodes with places: scalars, lists, keys with values, and nothing else.

Where the reader leaves it open, `Scalar.value` resolves a scalar as YAML 1.2 does (without octal and
hexadecimal numbers).  Tags, merge keys, directives and further documents are refused; size, nesting and
aliases are bounded.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final, NoReturn, TypeAlias

import yaml

from .findings import Findings, Place, place_after, quoted
from .quantities import NUMERAL, as_float

MAX_DEPTH: Final = 40
MAX_NODES: Final = 100_000  # with aliases written out

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # only its parser is used
_TAB = re.compile(r"^ *\t", re.MULTILINE)
_PRINTABLE = "\t\n\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff"
_UNPRINTABLE = re.compile(f"[^{_PRINTABLE}]")
_TOO_MUCH: Final = "is this the file that you meant?"
_SYNTAX_HINTS: Final = {
    "mapping values": "a text with ': ' in it needs quotes; or is the indentation wrong?",
    "',' or": "close the bracket, or put a comma between its items",
    "any token": "a text that begins with a special character needs quotes",
    "end of stream": "a quote or a bracket is not closed",
}

_Event: TypeAlias = Any  # of the parser; the stubs leave open which events have which fields


@dataclass(frozen=True, slots=True)
class Node(Place):
    """What stands at a place.  Nothing but a place: a value that is missing, and was told to be so."""


@dataclass(frozen=True, slots=True)
class Scalar(Node):
    """A text as written, and whether it stood there without quotes."""

    text: str
    plain: bool = True

    @property
    def value(self) -> bool | int | float | str | None:
        """The scalar by the rules of YAML 1.2.

        >>> [Scalar(1, 1, text).value for text in ("no", "12:30", "1e3", "true", "~")]
        ['no', '12:30', 1000.0, True, None]
        """
        if not self.plain:
            return self.text
        if self.text in ("", "~", "null", "Null", "NULL"):
            return None
        if self.text in ("true", "True", "TRUE", "false", "False", "FALSE"):
            return self.text[0] in "tT"
        if not re.fullmatch(NUMERAL, self.text):
            return self.text
        return int(self.text) if re.fullmatch("[-+]?[0-9]{1,300}", self.text) else as_float(self.text)

    @property
    def is_null(self) -> bool:
        """Whether nothing is written here."""
        return self.value is None


@dataclass(frozen=True, slots=True)
class Sequence(Node):
    """A list."""

    items: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Mapping(Node):
    """Keys with their values, in the order of the file, each key once."""

    entries: tuple[tuple[Scalar, Node], ...]


def is_missing(node: Node) -> bool:
    """Whether nothing stands there, and was told to be so."""
    return type(node) is Node


def shown(node: Node) -> str:
    """Say what stands at a node."""
    if isinstance(node, Scalar):
        return "nothing" if node.is_null else quoted(node.text)
    return "a list" if isinstance(node, Sequence) else "keys with values"


def written(text: str) -> str:
    """Say a text as files do: in quotes, where it would be something else without.

    >>> print(written("ship 1"), written("12"), written("a: b"))
    ship 1 "12" "a: b"
    """
    if (
        re.fullmatch("[A-Za-z][A-Za-z0-9_.-]*(?: [A-Za-z0-9_.-]+)*", text)
        and Scalar(0, 0, text).value == text
    ):
        return text
    return _UNPRINTABLE.sub(lambda odd: f"\\u{ord(odd[0]):04x}", json.dumps(text, ensure_ascii=False))


def compose(findings: Findings) -> Node:
    """Build the nodes of a file; what is not YAML of the strict kind is raised at once."""
    text = findings.content
    if tab := _TAB.search(text):
        place = place_after(text[: tab.end() - 1])
        findings.stop(place, "a tab in the indentation", hint="indent with spaces")
    if odd := _UNPRINTABLE.search(text):
        place = place_after(text[: odd.start()])
        findings.stop(place, f"the character U+{ord(odd[0]):04X}", hint="remove it")
    return _Composer(findings).document()


class _Composer:
    """Builds the nodes of a file from the events of the parser, and stops at what is too much."""

    def __init__(self, findings: Findings) -> None:
        self._findings = findings
        self._events: Iterator[_Event] = yaml.parse(findings.content, Loader=_LOADER)
        self._anchors: dict[str, Node] = {}
        self._count = 0

    def document(self) -> Node:
        """The one document of the file."""
        try:
            return self._document()
        except (yaml.YAMLError, ValueError, OverflowError) as error:
            self._stop_at(error)

    def _document(self) -> Node:
        next(self._events)
        start = next(self._events)
        if isinstance(start, yaml.StreamEndEvent):
            self._findings.stop(Node(0, 0), "the file is empty", hint="is this the file that you meant?")
        if start.version or start.tags:
            self._findings.stop(_mark(start), "directives are not used here")
        root = self._node(next(self._events), 1)
        next(self._events)
        if not isinstance(after := next(self._events), yaml.StreamEndEvent):
            self._findings.stop(_mark(after), "a second document in the file", hint="remove the line '---'")
        return root

    def _node(self, event: _Event, depth: int) -> Node:
        at = _mark(event)
        if isinstance(event, yaml.AliasEvent):
            return self._alias(at, str(event.anchor), depth)
        if event.tag is not None:
            self._findings.stop(at, "tags are not used here", hint="remove the '!' and what belongs to it")
        self._count_one(at, depth)
        node: Node
        if isinstance(event, yaml.ScalarEvent):
            node = Scalar(at.line, at.column, event.value, not event.style)
        elif isinstance(event, yaml.SequenceStartEvent):
            items = tuple(self._node(each, depth + 1) for each in self._until_end())
            node = Sequence(at.line, at.column, items)
        else:
            node = Mapping(at.line, at.column, tuple(self._entries(depth)))
        if event.anchor:
            self._anchors[event.anchor] = node
        return node

    def _until_end(self) -> Iterator[_Event]:
        while not isinstance(event := next(self._events), yaml.CollectionEndEvent):
            yield event

    def _entries(self, depth: int) -> Iterator[tuple[Scalar, Node]]:
        seen: dict[str, Node] = {}
        for event in self._until_end():
            key = self._node(event, depth + 1)
            value = self._node(next(self._events), depth + 1)
            if not isinstance(key, Scalar):
                self._findings.refuse(_mark(event), f"got {shown(key)} as a key", expected="a word")
            elif key.plain and not key.text:
                self._findings.refuse(key, "a key is missing before ':'")
            elif key.plain and key.text == "<<":
                self._findings.refuse(key, "merge keys are not used here", hint="write the keys out")
            elif (first := seen.setdefault(key.text, key)) is not key:
                hint = f"the first is at line {first.line}, column {first.column}; remove one"
                self._findings.refuse(key, f"the key {quoted(key.text)} is given twice", hint=hint)
            else:
                yield key, value

    def _alias(self, at: Node, name: str, depth: int) -> Node:
        if name not in self._anchors:
            hint = "an alias stands after its anchor '&', and outside of it; a text with '*' needs quotes"
            self._findings.stop(at, f"the alias {quoted(name)} repeats nothing", hint=hint)
        self._count_again(at, self._anchors[name], depth)
        return self._anchors[name]

    def _count_again(self, at: Node, node: Node, depth: int) -> None:
        """Count what an alias repeats as if it were written out."""
        self._count_one(at, depth, hint="an alias counts for all that it repeats")
        pairs = node.entries if isinstance(node, Mapping) else ()
        below = node.items if isinstance(node, Sequence) else [each for pair in pairs for each in pair]
        for each in below:
            self._count_again(at, each, depth + 1)

    def _count_one(self, at: Node, depth: int, hint: str = _TOO_MUCH) -> None:
        self._count += 1
        if depth > MAX_DEPTH:
            self._findings.stop(at, f"nested more than {MAX_DEPTH} deep", hint=hint)
        if self._count > MAX_NODES:
            self._findings.stop(at, f"the file holds more than {MAX_NODES} values", hint=hint)

    def _stop_at(self, error: Exception) -> NoReturn:
        """Turn what the parser says into a finding."""
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        problem = str(getattr(error, "problem", None) or error)
        opened = getattr(error, "context_mark", None)
        usual = "look at the indentation, and for a missing ':', quote or bracket, here and above"
        hint = next((text for part, text in _SYNTAX_HINTS.items() if part in problem), usual)
        if opened and mark and opened.line != mark.line:
            hint = f"{hint} (begins at line {opened.line + 1})"
        at = Node(mark.line + 1, mark.column + 1) if mark else Node(0, 0)
        if "nesting depth" in problem:  # the parser has a bound of its own, and looks ahead
            self._findings.stop(at, f"nested more than {MAX_DEPTH} deep", hint=_TOO_MUCH)
        self._findings.stop(at, f"not YAML: {problem}", hint=hint)


def _mark(event: _Event) -> Node:
    return Node(event.start_mark.line + 1, event.start_mark.column + 1)
