"""The vocabulary as a reference: rows of a table, and a page in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from ..ships import UNKNOWN
from .vocabulary import MOTIONS, Fact, Scope, Vocabulary

_OF_A_SHIP: Final = ("speed", "time_to_intersection")  # quantities of motion that belong to one ship
_HEADS: Final[Mapping[Scope, str]] = {
    Scope.SHIP: "Facts of a ship: `own.length`, `other.length`",
    Scope.WATERWAY: "Facts of the waterway: `waterway.current`",
    Scope.PAIR: "Facts of the pair: `geometry`",
}
_NO_PLUGINS: Final[Mapping[str, str]] = MappingProxyType({})
_HEAD: Final = """\
# Facts

What conditions of rulesets may ask for.  A fact that is not stated has its default; one without a default
is unknown, or computed from positions, courses and the chart.  An encounter file writes a number with its
unit in the key; a ruleset file and a scenario write it beside the number.  `ccas facts` lists the same,
with the facts that plugins add.

This page is made by `docs/make_reference.py` from what the program knows.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class FactRow:
    """A fact, or a quantity of motion, as it is listed."""

    name: str
    scope: str
    values: str  # true or false, words, or what is measured
    unit: str
    meaning: str
    source: str  # who knows it at first
    default: str
    memory: str
    key: str  # name in encounter files; none where it cannot be stated
    plugin: str  # who adds it; none where it is ours


def rows(
    vocabulary: Vocabulary, added: Mapping[str, str] = _NO_PLUGINS, scope: Scope | None = None
) -> Iterator[FactRow]:
    """List facts, and then quantities of motion; `added` says which plugin adds which."""
    for fact in vocabulary.facts:
        if scope in (None, fact.scope):
            yield _row(fact, added.get(fact.name, ""))
    for name, (quantity, meaning) in MOTIONS.items():
        belongs = Scope.SHIP if name in _OF_A_SHIP else Scope.PAIR
        if scope in (None, belongs):
            yield FactRow(
                name=name,
                scope=belongs.value,
                values=quantity.name,
                unit=quantity.unit,
                meaning=meaning,
                source="shared",
                default="computed",
                memory="",
                key="",
                plugin="",
            )


def _row(fact: Fact, plugin: str) -> FactRow:
    kinds = {"flag": "true or false", "flags": "any words", "text": "a text", "number": fact.quantity.name}
    default = "computed" if fact.computed or fact.compute is not None else "unknown"
    if fact.default is not UNKNOWN and default != "computed":
        default = str(fact.default).lower() if isinstance(fact.default, bool) else str(fact.default) or "none"
    return FactRow(
        name=fact.name,
        scope=fact.scope.value,
        values=", ".join(fact.choices) or kinds[fact.kind.value],
        unit=fact.quantity.unit,
        meaning=fact.meaning,
        source=fact.source.value,
        default=default,
        memory=fact.memory,
        key=fact.key,
        plugin=plugin,
    )


def facts_page(vocabulary: Vocabulary) -> str:
    """All facts as a page, in Markdown."""
    parts = [_HEAD]
    for scope, head in _HEADS.items():
        listed = list(rows(vocabulary, scope=scope))
        parts += [f"## {head}\n", "\n".join(_table(listed)), ""]
    return "\n".join(parts).rstrip() + "\n"


def _table(listed: Iterable[FactRow]) -> Iterator[str]:
    yield "| name | values | in encounter files | default | known from | held for | meaning |"
    yield "| --- | --- | --- | --- | --- | --- | --- |"
    for row in listed:
        key = f"`{row.key}`" if row.key else ""
        cells = (f"`{row.name}`", row.values, key, row.default, row.source, row.memory, row.meaning)
        yield f"| {' | '.join(cells)} |"
