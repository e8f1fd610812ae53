"""Single values of a ruleset file: words, conditions, citations, numbers with units, days."""

from __future__ import annotations

import re
from datetime import date
from enum import StrEnum
from fractions import Fraction
from typing import Final, TypeVar

from ..quantities import QUANTITY_OF
from ..strict_yaml import Block, Reader
from ..verdict import Citation, Confidence
from ..yaml_nodes import Node, Scalar, Sequence
from .language import syntax
from .language.compiler import DIMENSIONS, UNITS, Dimensions
from .language.syntax import MAX_DIGITS
from .ruleset_draft import Condition, refuse

MOST_DIGITS: Final = 12
MOST: Final = Fraction(10) ** MOST_DIGITS  # that a parameter may be, in SI units
_E = TypeVar("_E", bound=StrEnum)


class ValueReader:
    """Reads single values; `regulation` and `edition` are those of citations that name none."""

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self._regulation = self._edition = ""

    def _matching(self, node: Node, pattern: re.Pattern[str], expected: str) -> str:
        text = self._reader.text(node)
        if text and not pattern.fullmatch(text):
            self._reader.refuse(node, f"got '{text[:40]}'", expected=expected)
        return text

    def _word(self, node: Node | None) -> Scalar | None:
        if node is None or not self._reader.text(node):
            return None
        return node if isinstance(node, Scalar) else None

    def _words(self, node: Node | None) -> list[Scalar]:
        """One word, or a list of words."""
        if isinstance(node, Scalar):
            return [node] if self._word(node) else []
        return [word for each in self._reader.items(node) if (word := self._word(each))]

    def _optional(self, block: Block, key: str) -> str:
        node = block.find(key)
        return self._reader.text(node) if node else ""

    def _choice(self, block: Block, key: str, options: type[_E]) -> _E | None:
        node = block.find(key)
        return self._reader.choice(node, options) if node else None

    def _regulated(self, node: Node | None) -> tuple[str, str]:
        if node is None:
            return "", ""
        block = self._reader.block(node)
        name = self._reader.text(block.require("name"))
        edition = self._reader.text(block.require("version"))
        for key in ("title", "url", "language"):
            self._optional(block, key)
        block.done()
        return name, edition

    def _conditions(self, node: Node | None) -> tuple[Condition, ...]:
        """A condition, or a list of conditions that must all hold."""
        if node is None:
            return ()
        nodes = node.items if isinstance(node, Sequence) else (node,)
        if not nodes:
            self._reader.refuse(node, "an empty list", expected="a condition")
        return tuple(
            Condition(text, each, self._reader) for each in nodes if (text := self._reader.text(each))
        )

    def _citation(self, node: Node) -> Citation:
        block = self._reader.block(node)
        article = self._reader.text(block.require("article"))
        regulation = self._optional(block, "regulation") or self._regulation
        if not regulation and article:
            hint = "say which: 'regulation: {name: …, version: …}' at the top of the file, or here"
            self._reader.refuse(node, "a citation without regulation", hint=hint)
        citation = Citation(
            regulation=regulation,
            article=article,
            version=self._optional(block, "version") or self._edition,
            confidence=self._choice(block, "confidence", Confidence) or Confidence.UNVERIFIED,
            text=self._optional(block, "text"),
        )
        block.done()
        return citation

    def _named(self, key: Scalar, what: str) -> bool:
        if syntax.is_name(key.text) and key.text not in ("own", "other"):
            return True
        expected = "letters, digits and '_', beginning with a letter"
        self._reader.refuse(key, f"'{key.text[:40]}' cannot be the name of a {what}", expected=expected)
        return False

    def _quantity(self, node: Node) -> tuple[Fraction, Dimensions]:
        """A number with its unit, exactly."""
        text = self._reader.text(node)
        match = re.fullmatch(r"(-?\d+(?:\.\d+)?(?:[eE][+-]?\d{1,2})?)(?: +(\S+))?", text)
        unit = (match[2] or "") if match else ""
        if len(text) > MAX_DIGITS:
            self._reader.refuse(node, "a number beyond all measure", expected=f"at most {MAX_DIGITS} letters")
            return Fraction(0), DIMENSIONS["a number without unit"]
        if match is None or unit not in UNITS:
            hint = "an angle is written in degrees" if unit == "rad" else ""
            if match and unit in QUANTITY_OF and not hint:
                hint = f"not in a condition: use one of {', '.join(filter(None, UNITS))}"
            expected = "a number with its unit, such as 300 s or 22.5 deg"
            if text:
                self._reader.refuse(node, f"got '{text[:40]}'", expected=expected, hint=hint)
            return Fraction(0), DIMENSIONS["a number without unit"]
        size, dimensions = UNITS[unit]
        value = Fraction(match[1]) * size
        if value and not 1 / MOST <= abs(value) <= MOST:
            self._reader.refuse(node, "a number beyond all measure", expected=f"at most 1e{MOST_DIGITS}")
        return value, dimensions

    def _range(self, node: Node, dimensions: Dimensions) -> tuple[Fraction, Fraction]:
        ends = self._reader.items(node, 2, 2)
        if len(ends) != 2:
            return Fraction(0), Fraction(0)
        (low, one), (high, two) = (self._quantity(end) for end in ends)
        if one != dimensions or two != dimensions:
            self._reader.refuse(node, "the range has another unit than the value")
        elif low > high:
            self._reader.refuse(node, "the range is empty", expected="the least value first")
        return low, high

    def _parsed(self, condition: Condition) -> syntax.Expression | None:
        try:
            return syntax.parse(condition.text)
        except syntax.Fault as fault:
            refuse(condition, fault)
            return None

    def _date(self, node: Node) -> date:
        text = self._reader.text(node)
        try:
            return date.fromisoformat(text)
        except ValueError:
            if text:
                self._reader.refuse(node, f"got '{text[:40]}'", expected="a day such as 2027-06-30")
            return date.min
