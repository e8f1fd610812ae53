"""A strict reader of YAML files, which tells the user all that is wrong with a file at once.

What a scalar means is decided by who reads it, not by how it looks: `no` is the text "no" where
a text is wanted, and refused where a flag is wanted.

A refused value comes back as a stand-in, so that reading goes on and finds more: ask
`Block.done` whether a block may be used, and call `Reader.finish` before the whole is used.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from enum import StrEnum
from typing import Final, TypeVar

from .errors import InputError, did_you_mean
from .findings import Findings, quoted
from .quantities import ANY, MEASURE, QUANTITY_OF, Quantity, Range, as_float, fault
from .yaml_nodes import MAX_NODES, Mapping, Node, Scalar, Sequence, compose, is_missing, shown

_E = TypeVar("_E", bound=StrEnum)


class Reader(Findings):
    """Reads the values of one file, and collects all that is wrong with them; made as `Findings` are.

    Raises
    ------
    InputError
        If the text is not YAML of the strict kind: then nothing more can be known.
    """

    def __init__(self, text: str, source: str, kind: type[InputError] = InputError) -> None:
        super().__init__(text, source, kind)
        self.root: Final = compose(self)

    def document(self, schema: str) -> Block:
        """Keys of the file, the first of which must be `schema`, with this value."""
        root, begin = self.root, f"begin with 'schema: {schema}'"
        if not isinstance(root, Mapping):
            self.stop(root, f"the file holds {shown(root)}", expected="keys with values", hint=begin)
        block = self.block(root)
        named = block.find("schema")
        if named is None:
            self.stop(root, "the file does not say of which kind it is", hint=begin)
        if root.entries[0][0].text != "schema":
            self.refuse(root.entries[0][0], "'schema' must come first", hint=begin)
        if not isinstance(named, Scalar) or named.text != schema:
            newer = isinstance(named, Scalar) and named.text.partition("@")[0] == schema.partition("@")[0]
            hint = "written for another version of ccas" if newer else ""
            self.stop(named, f"{shown(named)} is not the kind that is read here", expected=schema, hint=hint)
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
        if node is not None and not is_missing(node) and not at_least <= len(items) <= at_most:
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
            self.refuse(node, f"a second {what} {quoted(text)}", hint=hint)
        elif text:
            seen[text] = node
        return text

    def flag(self, node: Node) -> bool:
        """True or false, and no other words for it."""
        value = node.value if isinstance(node, Scalar) else None
        if self._scalar(node, "true or false") is not None and not isinstance(value, bool):
            self.refuse(node, f"got {shown(node)}", expected="true or false")
        return value is True

    def choice(self, node: Node, options: Iterable[_E]) -> _E:
        """One of some words."""
        known = {option.value: option for option in options}
        expected = f"one of {', '.join(known)}"
        text = self._scalar(node, expected)
        if text is not None and text not in known:
            hint = did_you_mean(text[:40], known)
            self.refuse(node, f"got {shown(node)}", expected=expected, hint=hint if "mean" in hint else "")
        return known.get(text or "", next(iter(known.values())))

    def integer(self, node: Node, low: int, high: int) -> int:
        """A whole number between two bounds, both allowed."""
        expected = f"a whole number from {low} to {high}"
        value = node.value if isinstance(node, Scalar) else None
        if self._scalar(node, expected) is None:
            return low
        if type(value) is not int or not low <= value <= high:
            self.refuse(node, f"got {shown(node)}", expected=expected)
            return low
        return value

    def number(self, node: Node, quantity: Quantity, within: Range = ANY, *, bare: bool = False) -> float:
        """A finite number, in SI; its unit must be there, unless `bare` says that SI is understood."""
        text = self._scalar(node, quantity.expected)
        if text is None:
            return math.nan
        match = MEASURE.fullmatch(text)
        digits, space, unit = match.groups() if match else ("", "", "")
        if not (bare and digits and not unit) and (wrong := fault(digits, space, unit, quantity)):
            self.refuse(node, f"{shown(node)} {wrong[0]}", expected=quantity.expected, hint=wrong[1])
            return math.nan
        value = quantity.keep(as_float(digits) * quantity.units.get(unit, 1.0))
        if not math.isfinite(value):
            self.refuse(node, f"{shown(node)} is not finite", expected=quantity.expected)
            return math.nan
        if not within.holds(value):
            self.refuse(node, f"{shown(node)} is out of range", expected=within.words(quantity))
        return value

    def value(self, node: Node) -> bool | int | float | str:
        """A flag, a text, or a number with any unit or none: by what it looks like."""
        text = self._scalar(node, "true, false, a number or a text")
        if text is None or not isinstance(node, Scalar):
            return ""
        match = MEASURE.fullmatch(text) if node.plain else None
        if match and match[3] and match[3] in QUANTITY_OF:
            return self.number(node, QUANTITY_OF[match[3]])
        if match and match[3] and match[2]:
            hint = f"{did_you_mean(match[3][:40], filter(None, QUANTITY_OF))}; a text needs quotes"
            self.refuse(node, f"{shown(node)} has an unknown unit", hint=hint)
        value = node.value
        if isinstance(value, float) and not math.isfinite(value):
            self.refuse(node, f"{shown(node)} is not finite", expected="a finite number")
        return text if value is None else value

    def _scalar(self, node: Node, expected: str) -> str | None:
        if isinstance(node, Scalar) and not node.is_null:
            return node.text
        if not is_missing(node):
            self.refuse(node, f"got {shown(node)}", expected=expected)
        return None

    def _refuse_shape(self, node: Node | None, expected: str) -> bool:
        if node is None or is_missing(node) or (isinstance(node, Scalar) and node.is_null):
            return False
        self.refuse(node, f"got {shown(node)}", expected=expected)
        return True


class Block:
    """Keys with values, being read: a key that nobody has asked for is unknown."""

    def __init__(self, reader: Reader, node: Node | None) -> None:
        self._reader, self._before = reader, reader.count
        self._keys = {key.text: (key, value) for key, value in reader.entries(node)}
        self._place = node or Node(0, 0)
        self._readable = reader.count == self._before and not is_missing(self._place)
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
