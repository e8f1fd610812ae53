"""A strict reader of YAML files, which tells the user all that is wrong with a file at once.

What a scalar means is decided by who reads it, not by how it looks: `no` is the text "no" where
a text is wanted, and refused where a flag is wanted.  Where the reader leaves it open,
`Scalar.value` resolves it as YAML 1.2 does (without octal and hexadecimal numbers).  Tags, merge
keys, directives and further documents are refused; size, nesting and aliases are bounded.

A refused value comes back as a stand-in, so that reading goes on and finds more: ask
`Block.done` whether a block may be used, and call `Reader.finish` before the whole is used.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator
from collections.abc import Mapping as MappingOf
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, Final, NoReturn, TypeAlias, TypeVar

import yaml

from . import units
from .errors import Diagnostic, InputError, did_you_mean

MAX_BYTES: Final = 2_000_000
MAX_DEPTH: Final = 40
MAX_NODES: Final = 100_000  # with aliases written out
MAX_FINDINGS: Final = 100
DIGITS: Final = 12  # that a file keeps of a number with a unit

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # only its parser is used
_FINITE = r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?"
_NUMBER = rf"{_FINITE}|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)"
_MEASURE = re.compile(rf"({_NUMBER})( *)(\S*)")
_TAB = re.compile(r"^ *\t", re.MULTILINE)
_PRINTABLE = "\t\n\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff"
_UNPRINTABLE = re.compile(f"[^{_PRINTABLE}]")
_SYNTAX_HINTS: Final = {
    "mapping values": "a text with ': ' in it needs quotes; or is the indentation wrong?",
    "',' or": "close the bracket, or put a comma between its items",
    "any token": "a text that begins with a special character needs quotes",
    "end of stream": "a quote or a bracket is not closed",
}
_E = TypeVar("_E", bound=StrEnum)
_Event: TypeAlias = Any  # of the parser; the stubs leave open which events have which fields


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a number measures: its units and their sizes in SI; files are written in the first."""

    name: str
    units: MappingOf[str, float]

    @property
    def unit(self) -> str:
        """The first of the units."""
        return next(iter(self.units))

    @property
    def expected(self) -> str:
        """What a file must say: the quantity and its units."""
        *others, last = self.units
        return f"{self.name} in {', '.join(others)}{' or ' if others else ''}{last}" if last else self.name

    def keep(self, value: float) -> float:
        """Round an SI value to what a file keeps of it: written and read, it stays the same."""
        size = self.units[self.unit]
        return float(f"{value / size:.{DIGITS}g}") * size

    def write(self, value: float) -> str:
        """Say an SI value as files do.

        >>> TIME.write(20.0), ANGLE.write(units.DEGREE * 22.5)
        ('20 s', '22.5 deg')
        """
        return f"{value / self.units[self.unit]:.{DIGITS}g} {self.unit}".rstrip()


NUMBER: Final = Quantity("a number without unit", {"": 1.0})
TIME: Final = Quantity("a time", {"s": 1.0, "min": units.MINUTE, "h": units.HOUR})
LENGTH: Final = Quantity("a length", {"m": 1.0, "km": units.KILOMETRE, "NM": units.NAUTICAL_MILE})
SPEED: Final = Quantity("a speed", {"m/s": 1.0, "km/h": units.KILOMETRE_PER_HOUR, "kn": units.KNOT})
ANGLE: Final = Quantity("an angle", {"deg": units.DEGREE, "rad": 1.0})
MASS: Final = Quantity("a weight", {"t": units.TONNE, "kg": 1.0})
AREA: Final = Quantity("an area", {"m2": 1.0})
CURVATURE: Final = Quantity("a curvature", {"1/m": 1.0})
_QUANTITIES = (NUMBER, TIME, LENGTH, SPEED, ANGLE, MASS, AREA, CURVATURE)
QUANTITY_OF: Final = {unit: quantity for quantity in _QUANTITIES for unit in quantity.units}


@dataclass(frozen=True, slots=True, kw_only=True)
class Range:
    """Bounds of a number, in SI."""

    above: float = -math.inf
    at_least: float = -math.inf
    below: float = math.inf
    at_most: float = math.inf

    def holds(self, value: float) -> bool:
        """Whether a value lies within the bounds."""
        return self.above < value < self.below and self.at_least <= value <= self.at_most

    def words(self, quantity: Quantity) -> str:
        """Say the bounds as files do."""
        lower = {"above": self.above, "at least": self.at_least}
        bounds = lower | {"below": self.below, "at most": self.at_most}
        finite = {word: bound for word, bound in bounds.items() if math.isfinite(bound)}
        return " and ".join(f"{word} {quantity.write(bound)}" for word, bound in finite.items())


@dataclass(frozen=True, slots=True)
class Node:
    """A place in a file.  Nothing but a place: a value that is missing, and was told to be so."""

    line: int
    column: int


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
        if not re.fullmatch(_NUMBER, self.text):
            return self.text
        return int(self.text) if re.fullmatch("[-+]?[0-9]{1,300}", self.text) else _float(self.text)

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


def read_text(path: str | Path, kind: type[InputError] = InputError) -> str:
    """Read a file as UTF-8; whatever hinders it is raised as a `kind`."""
    source = str(path)
    try:
        with Path(path).open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = (isinstance(error, OSError) and error.strerror) or str(error)
        hint = "give the path of a YAML file"
        raise kind(Diagnostic(source=source, message=f"cannot be read: {reason}", hint=hint)) from None
    if len(data) > MAX_BYTES:
        raise kind(_too_large(source))
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start].decode(errors="replace").replace("\r\n", "\n").replace("\r", "\n")
        rest = data[error.start : error.start + 80].decode(errors="replace")
        message = f"byte 0x{data[error.start]:02X} is not UTF-8"
        line = before[before.rfind("\n") + 1 :] + rest.splitlines()[0]
        raise kind(_finding(source, _place(before), line, message, hint="save the file as UTF-8")) from None


def _too_large(source: str) -> Diagnostic:
    message = f"larger than {MAX_BYTES // 1_000_000} MB"
    return Diagnostic(source=source, message=message, hint="is this the file that you meant?")


def _place(before: str) -> Node:
    return Node(before.count("\n") + 1, len(before) - before.rfind("\n"))


def _finding(
    source: str, at: Node, line: str, message: str, *, expected: str = "", hint: str = ""
) -> Diagnostic:
    cut = line[: max(100, at.column + 20)]
    shown = "".join(c if c.isprintable() else " " if c == "\t" else "\ufffd" for c in cut).rstrip()
    return Diagnostic(
        source=source,
        line=at.line,
        column=at.column,
        message=message,
        expected=expected,
        hint=hint,
        excerpt=shown if at.column <= min(200, len(shown) + 1) else "",
    )


def _float(text: str) -> float:
    return float(re.sub(r"\.(?=[inIN])", "", text))


def _shown(node: Node) -> str:
    if isinstance(node, Scalar):
        return "nothing" if node.is_null else _quoted(node.text)
    return "a list" if isinstance(node, Sequence) else "keys with values"


def _quoted(text: str) -> str:
    return f"'{text[:40]}…'" if len(text) > 40 else f"'{text}'"


class Reader:
    """Reads the values of one file, and collects all that is wrong with them.

    Parameters
    ----------
    text
        The text of the file.
    source
        What the file is called in findings.
    kind
        What to raise.

    Raises
    ------
    InputError
        If the text is not YAML of the strict kind: then nothing more can be known.
    """

    def __init__(self, text: str, source: str, kind: type[InputError] = InputError) -> None:
        self._source, self._kind = source, kind
        self._findings: list[Diagnostic] = []
        if len(text) > MAX_BYTES:
            raise kind(_too_large(source))
        text = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
        self._lines = text.split("\n")
        if tab := _TAB.search(text):
            self.stop(_place(text[: tab.end() - 1]), "a tab in the indentation", hint="indent with spaces")
        if odd := _UNPRINTABLE.search(text):
            self.stop(_place(text[: odd.start()]), f"the character U+{ord(odd[0]):04X}", hint="remove it")
        self.root: Final = _Composer(self, text).document()

    @property
    def count(self) -> int:
        """Number of findings so far."""
        return len(self._findings)

    def refuse(self, at: Node, message: str, *, expected: str = "", hint: str = "") -> None:
        """Add a finding; too many of them stop the reading."""
        line = self._lines[at.line - 1] if 0 < at.line <= len(self._lines) else ""
        self._findings.append(_finding(self._source, at, line, message, expected=expected, hint=hint))
        if self.count == MAX_FINDINGS:
            self.finish()

    def unknown(self, at: Node, what: str, word: str, known: Iterable[str]) -> None:
        """Add the finding that a word is not among those that are known."""
        names = list(known)
        hint = did_you_mean(word[:40], names) if names else ""
        self.refuse(at, f"unknown {what} {_quoted(word)}", hint=hint)

    def stop(self, at: Node, message: str, *, expected: str = "", hint: str = "") -> NoReturn:
        """Add a finding after which nothing more can be known, and raise."""
        self.refuse(at, message, expected=expected, hint=hint)
        self.finish()
        raise AssertionError("a finding has just been added")

    def finish(self) -> None:
        """Raise all findings, in the order of the file, if there are any."""
        if self._findings:
            ordered = sorted(self._findings, key=lambda each: (each.line, each.column))
            raise self._kind(*dict.fromkeys(ordered))  # what an alias repeats is found again

    def document(self, schema: str) -> Block:
        """Keys of the file, the first of which must be `schema`, with this value."""
        root, begin = self.root, f"begin with 'schema: {schema}'"
        if not isinstance(root, Mapping):
            self.stop(root, f"the file holds {_shown(root)}", expected="keys with values", hint=begin)
        block = self.block(root)
        named = block.find("schema")
        if named is None:
            self.stop(root, "the file does not say of which kind it is", hint=begin)
        if root.entries[0][0].text != "schema":
            self.refuse(root.entries[0][0], "'schema' must come first", hint=begin)
        if not isinstance(named, Scalar) or named.text != schema:
            newer = isinstance(named, Scalar) and named.text.partition("@")[0] == schema.partition("@")[0]
            hint = "written for another version of ccas" if newer else ""
            self.stop(named, f"{_shown(named)} is not the kind that is read here", expected=schema, hint=hint)
        return block

    def block(self, node: Node | None) -> Block:
        """Keys with values, to be asked for one by one; nothing has no keys."""
        return Block(self, node)

    def entries(self, node: Node | None) -> tuple[tuple[Scalar, Node], ...]:
        """Keys with values, whatever they are; nothing has none."""
        if isinstance(node, Mapping):
            return node.entries
        self._refuse_shape(node, "keys with values")
        return ()

    def items(
        self, node: Node | None, at_least: int = 0, at_most: int = MAX_NODES, *, hint: str = ""
    ) -> tuple[Node, ...]:
        """Items of a list; nothing has none."""
        if not isinstance(node, Sequence) and self._refuse_shape(node, "a list"):
            return ()
        items = node.items if isinstance(node, Sequence) else ()
        if node is not None and not _is_missing(node) and not at_least <= len(items) <= at_most:
            limit = f"at least {at_least}" if len(items) < at_least else f"at most {at_most}"
            expected = f"a list of {at_least if at_least == at_most else limit}"
            self.refuse(node, f"a list of {len(items)}", expected=expected, hint=hint)
        return items

    def text(self, node: Node) -> str:
        """A text, whatever it looks like, but not an empty one."""
        text = self._scalar(node, "a text")
        if text is not None and not text.strip():
            self.refuse(node, "an empty text")
        return text or ""

    def unique(self, seen: dict[str, Node], node: Node, what: str) -> str:
        """A text that no other node has used; `seen` holds those that did."""
        text = self.text(node)
        if text and (first := seen.get(text)):
            hint = f"the first is at line {first.line}, column {first.column}; rename one"
            self.refuse(node, f"a second {what} {_quoted(text)}", hint=hint)
        elif text:
            seen[text] = node
        return text

    def flag(self, node: Node) -> bool:
        """True or false, and no other words for it."""
        value = node.value if isinstance(node, Scalar) else None
        if self._scalar(node, "true or false") is not None and not isinstance(value, bool):
            self.refuse(node, f"got {_shown(node)}", expected="true or false")
        return value is True

    def choice(self, node: Node, options: Iterable[_E]) -> _E:
        """One of some words."""
        known = {option.value: option for option in options}
        expected = f"one of {', '.join(known)}"
        text = self._scalar(node, expected)
        if text is not None and text not in known:
            hint = did_you_mean(text[:40], known)
            self.refuse(node, f"got {_shown(node)}", expected=expected, hint=hint if "mean" in hint else "")
        return known.get(text or "", next(iter(known.values())))

    def integer(self, node: Node, low: int, high: int) -> int:
        """A whole number between two bounds, both allowed."""
        expected = f"a whole number from {low} to {high}"
        value = node.value if isinstance(node, Scalar) else None
        if self._scalar(node, expected) is None:
            return low
        if type(value) is not int or not low <= value <= high:
            self.refuse(node, f"got {_shown(node)}", expected=expected)
            return low
        return value

    def number(self, node: Node, quantity: Quantity, within: Range = Range(), *, bare: bool = False) -> float:
        """A finite number, in SI; its unit must be there, unless `bare` says that SI is understood."""
        text = self._scalar(node, quantity.expected)
        if text is None:
            return math.nan
        match = _MEASURE.fullmatch(text)
        digits, space, unit = match.groups() if match else ("", "", "")
        if not (bare and digits and not unit) and (fault := _fault(digits, space, unit, quantity)):
            self.refuse(node, f"{_shown(node)} {fault[0]}", expected=quantity.expected, hint=fault[1])
            return math.nan
        value = quantity.keep(_float(digits) * quantity.units.get(unit, 1.0))
        if not math.isfinite(value):
            self.refuse(node, f"{_shown(node)} is not finite", expected=quantity.expected)
            return math.nan
        if not within.holds(value):
            self.refuse(node, f"{_shown(node)} is out of range", expected=within.words(quantity))
        return value

    def value(self, node: Node) -> bool | int | float | str:
        """A flag, a text, or a number with any unit or none: by what it looks like."""
        text = self._scalar(node, "true, false, a number or a text")
        if text is None or not isinstance(node, Scalar):
            return ""
        match = _MEASURE.fullmatch(text) if node.plain else None
        if match and match[3] and match[3] in QUANTITY_OF:
            return self.number(node, QUANTITY_OF[match[3]])
        if match and match[3] and match[2]:
            hint = f"{did_you_mean(match[3][:40], filter(None, QUANTITY_OF))}; a text needs quotes"
            self.refuse(node, f"{_shown(node)} has an unknown unit", hint=hint)
        value = node.value
        if isinstance(value, float) and not math.isfinite(value):
            self.refuse(node, f"{_shown(node)} is not finite", expected="a finite number")
        return text if value is None else value

    def _scalar(self, node: Node, expected: str) -> str | None:
        if isinstance(node, Scalar) and not node.is_null:
            return node.text
        if not _is_missing(node):
            self.refuse(node, f"got {_shown(node)}", expected=expected)
        return None

    def _refuse_shape(self, node: Node | None, expected: str) -> bool:
        if node is None or _is_missing(node) or (isinstance(node, Scalar) and node.is_null):
            return False
        self.refuse(node, f"got {_shown(node)}", expected=expected)
        return True


def _is_missing(node: Node) -> bool:
    return type(node) is Node


def _fault(digits: str, space: str, unit: str, quantity: Quantity) -> tuple[str, str] | None:
    """What is wrong with a number and its unit, and a hint."""
    if not digits:
        return f"is not {quantity.name}", ""
    if not unit:
        usual = quantity.unit
        return ("has no unit", f"if it is in {usual}, write '{digits} {usual}'") if usual else None
    if unit in quantity.units:
        return None if space else ("has no space before its unit", f"write '{digits} {unit}'")
    if unit in QUANTITY_OF:
        return f"is {QUANTITY_OF[unit].name}, not {quantity.name}", ""
    return "has an unknown unit", did_you_mean(unit[:40], quantity.units) if quantity.unit else ""


class Block:
    """Keys with values, being read: a key that nobody has asked for is unknown."""

    def __init__(self, reader: Reader, node: Node | None) -> None:
        self._reader, self._before = reader, reader.count
        self._keys = {key.text: (key, value) for key, value in reader.entries(node)}
        self._place = node or Node(0, 0)
        self._readable = reader.count == self._before and not _is_missing(self._place)
        self._asked: dict[str, bool] = {}  # whether it must be there

    def find(self, key: str) -> Node | None:
        """Value of a key that may be left out."""
        self._asked.setdefault(key, False)
        return self._keys[key][1] if key in self._keys else None

    def optional(self, key: str, default: str) -> Node:
        """Value of a key that may be left out, or what a file would have to say for the same."""
        return self.find(key) or Scalar(0, 0, default)

    def require(self, key: str) -> Node:
        """Value of a key that must be there."""
        self._asked[key] = True
        return self.find(key) or Node(self._place.line, self._place.column)

    def done(self) -> bool:
        """Refuse unknown and missing keys; tell whether all of the block, down to its leaves, is well."""
        if not self._readable:
            return False
        absent = {key: needed for key, needed in self._asked.items() if key not in self._keys}
        for name, (key, _) in self._keys.items():
            if name not in self._asked:
                near = did_you_mean(name[:40], absent)
                known = absent if near.startswith("did") else self._asked
                absent = {key: needed for key, needed in absent.items() if f"'{key}'" not in near}
                self._reader.unknown(key, "key", name, known)
        for name, needed in absent.items():
            if needed:
                self._reader.refuse(self._place, f"the key '{name}' is missing here")
        return self._reader.count == self._before


class _Composer:
    """Builds the nodes of a file from the events of the parser, and stops at what is too much."""

    def __init__(self, reader: Reader, text: str) -> None:
        self._reader = reader
        self._events: Iterator[_Event] = yaml.parse(text, Loader=_LOADER)
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
            self._reader.stop(Node(0, 0), "the file is empty", hint="is this the file that you meant?")
        if start.version or start.tags:
            self._reader.stop(_mark(start), "directives are not used here")
        root = self._node(next(self._events), 1)
        next(self._events)
        if not isinstance(after := next(self._events), yaml.StreamEndEvent):
            self._reader.stop(_mark(after), "a second document in the file", hint="remove the line '---'")
        return root

    def _node(self, event: _Event, depth: int) -> Node:
        at = _mark(event)
        if isinstance(event, yaml.AliasEvent):
            return self._alias(at, str(event.anchor), depth)
        if event.tag is not None:
            self._reader.stop(at, "tags are not used here", hint="remove the '!' and what belongs to it")
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
                self._reader.refuse(_mark(event), f"got {_shown(key)} as a key", expected="a word")
            elif key.plain and not key.text:
                self._reader.refuse(key, "a key is missing before ':'")
            elif key.plain and key.text == "<<":
                self._reader.refuse(key, "merge keys are not used here", hint="write the keys out")
            elif (first := seen.setdefault(key.text, key)) is not key:
                hint = f"the first is at line {first.line}, column {first.column}; remove one"
                self._reader.refuse(key, f"the key {_quoted(key.text)} is given twice", hint=hint)
            else:
                yield key, value

    def _alias(self, at: Node, name: str, depth: int) -> Node:
        if name not in self._anchors:
            hint = "an alias stands after its anchor '&', and outside of it; a text with '*' needs quotes"
            self._reader.stop(at, f"the alias {_quoted(name)} repeats nothing", hint=hint)
        self._count_again(at, self._anchors[name], depth)
        return self._anchors[name]

    def _count_again(self, at: Node, node: Node, depth: int) -> None:
        """Count what an alias repeats as if it were written out."""
        self._count_one(at, depth, hint="an alias counts for all that it repeats")
        pairs = node.entries if isinstance(node, Mapping) else ()
        below = node.items if isinstance(node, Sequence) else [each for pair in pairs for each in pair]
        for each in below:
            self._count_again(at, each, depth + 1)

    def _count_one(self, at: Node, depth: int, hint: str = "") -> None:
        self._count += 1
        if depth > MAX_DEPTH:
            self._reader.stop(at, f"nested more than {MAX_DEPTH} deep", hint=hint)
        if self._count > MAX_NODES:
            self._reader.stop(at, f"the file holds more than {MAX_NODES} values", hint=hint)

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
        self._reader.stop(at, f"not YAML: {problem}", hint=hint)


def _mark(event: _Event) -> Node:
    return Node(event.start_mark.line + 1, event.start_mark.column + 1)
