"""Keys of ruleset files: the table knows what the reader asks for, and the schema takes what it takes."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import ccas_rulesets
from ccas_core.strict_yaml import Block, Reader
from ccas_core.tapd.ruleset_keys import BLOCKS, reference
from ccas_core.tapd.ruleset_reader import read_draft
from ccas_core.tapd.ruleset_schema import ruleset_schema
from ccas_core.tapd.vocabulary import VOCABULARY, Scope
from ccas_core.yaml_nodes import Mapping as Keys
from ccas_core.yaml_nodes import Node, Scalar, Sequence

SHIPPED = list(ccas_rulesets.ccas_rulesets())
GUIDE = Path(__file__).parents[2] / "docs" / "ruleset-format.md"

# Every block that there is, once.
ALL = """\
schema: ccas/ruleset@1
id: all
version: 1.0.0
title: all blocks
extends: common
regulation: {name: R, version: "1"}
params: {L: {value: 20 m}}
regimes: {tidal: waters with tide}
encounter: {risk: closing}
gates:
  - {id: g, when: waterway.sign_a2, off: [a], cite: {article: "1"}}
rules:
  - {id: a, cite: {article: "1"}, when: risk, then: give_way, unless: {when: closing, cite: {article: "2"}}}
  - {id: b, cite: {article: "1"}, python: some_rule}
otherwise: {cite: {article: "0"}}
deadlock: {resolve_by: [id]}
domain: {speed: [1 m/s, 2 m/s]}
waivers:
  - {check: complete, reason: so, expires: 2030-01-01}
claims:
  - {name: c, check: complete, assume: risk}
tests:
  - name: t
    encounter: {geometry: head_on}
    ships: {A: {length: 20 m}, B: {at: [0 m, 0 m], course: 0 deg, speed: 1 m/s}}
    expect: {kind: none}
"""


def asked(text: str, patch: pytest.MonkeyPatch) -> set[frozenset[str]]:
    """Keys that the reader has asked for, block by block."""
    found: set[frozenset[str]] = set()
    done = Block.done

    def noted(block: Block) -> bool:
        found.add(frozenset(block._asked))
        return done(block)

    patch.setattr(Block, "done", noted)
    read_draft(text, "all.yaml", VOCABULARY)
    return found


def test_table_has_just_the_keys_that_the_reader_asks_for(monkeypatch: pytest.MonkeyPatch) -> None:
    known = {name: frozenset(key.name for key in keys) for name, keys in BLOCKS.items()}
    found = asked(ALL, monkeypatch)

    rules = {keys for keys in found if keys >= {"id", "python", "replaces"}}
    assert frozenset().union(*rules) == known.pop("rule")  # with `then`, or with `python`
    assert found - rules == set(known.values())


def test_every_key_says_what_it_means_in_a_sentence() -> None:
    for keys in BLOCKS.values():
        assert len({key.name for key in keys}) == len(keys)
        for key in keys:
            assert re.fullmatch(r"(?s)[A-Z`].*\.", key.meaning), key.name
            assert not key.block or key.block in BLOCKS


def test_schema_describes_every_key_and_lists_all_words() -> None:
    schema = ruleset_schema()

    blocks = {"ruleset": schema, **schema["definitions"]}
    for name, keys in BLOCKS.items():
        assert blocks[name]["additionalProperties"] is False
        for key in keys:
            held = blocks[name]["properties"][key.name]
            assert held["description"] == key.meaning
            assert not key.words or held["enum"] == list(key.words)
    ships = blocks["test"]["properties"]["ships"]["additionalProperties"]["properties"]
    assert {fact.name for fact in VOCABULARY.by_scope[Scope.SHIP]} | {"at", "course", "speed"} == set(ships)
    assert "towards the source" in ships["direction"]["description"].lower()
    assert ships["propulsion"]["enum"] == ["motor", "sail", "muscle", "none", "unknown"]
    json.dumps(schema, allow_nan=False)


def test_reference_in_the_docs_is_that_of_the_table() -> None:
    assert reference() in GUIDE.read_text(encoding="utf-8")


# --- the schema against files ----------------------------------------------------------------------


def plain(node: Node) -> Any:  # noqa: ANN401 - a plain value
    """What an editor sees at a node."""
    if isinstance(node, Keys):
        return {key.text: plain(value) for key, value in node.entries}
    if isinstance(node, Sequence):
        return [plain(each) for each in node.items]
    assert isinstance(node, Scalar)
    return node.text if node.value is None else node.value


TYPES: dict[str, tuple[type, ...]] = {
    "string": (str,),
    "number": (int, float),
    "boolean": (bool,),
    "array": (list,),
    "object": (dict,),
}


def faults(value: object, schema: dict[str, Any], root: dict[str, Any], at: str = "") -> Iterator[str]:
    """As much of a validator of draft 7 as this schema needs."""
    if "$ref" in schema:
        yield from faults(value, root["definitions"][schema["$ref"].rpartition("/")[2]], root, at)
        return
    for each in schema.get("allOf", ()):
        yield from faults(value, each, root, at)
    if "anyOf" in schema and all(list(faults(value, each, root, at)) for each in schema["anyOf"]):
        yield f"{at}: {value!r} is none of those"
    if not (fits(value, schema) and same(value, schema)):
        yield f"{at}: {value!r} is not {schema}"
    elif isinstance(value, list):
        for number, each in enumerate(value):
            yield from faults(each, schema.get("items", {}), root, f"{at}[{number}]")
    elif isinstance(value, dict):
        yield from (f"{at}: no {name}" for name in schema.get("required", ()) if name not in value)
        known, more = schema.get("properties", {}), schema.get("additionalProperties", {})
        for name, each in value.items():
            if name not in known and more is False:
                yield f"{at}: unknown key {name}"
            else:
                yield from faults(each, known.get(name, more or {}), root, f"{at}.{name}")


def fits(value: object, schema: dict[str, Any]) -> bool:
    """Whether a value is of the kind and the length that a schema asks for."""
    kinds = schema.get("type", [])
    allowed = [kinds] if isinstance(kinds, str) else kinds
    if allowed and not any(
        isinstance(value, TYPES[kind]) and (kind == "boolean" or not isinstance(value, bool))
        for kind in allowed
    ):
        return False
    count = len(value) if isinstance(value, list) else schema.get("minItems", 0)
    return bool(schema.get("minItems", 0) <= count <= schema.get("maxItems", count))


def same(value: object, schema: dict[str, Any]) -> bool:
    """Whether a value is one of those that a schema lists, and looks as it says."""
    if "enum" in schema and value not in schema["enum"]:
        return False
    if "const" in schema and value != schema["const"]:
        return False
    return "pattern" not in schema or re.search(schema["pattern"], str(value)) is not None


def told(text: str) -> list[str]:
    schema = ruleset_schema()
    return list(faults(plain(Reader(text, "file").root), schema, schema))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_schema_takes_every_ruleset_that_we_ship(path: Path) -> None:
    assert told(path.read_text(encoding="utf-8")) == []


def test_schema_takes_a_file_with_every_block() -> None:
    assert told(ALL) == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("then: give_way", "then: giveway"),
        ("title: all blocks", "titel: all blocks"),
        ("title: all blocks\n", ""),
        ("length: 20 m", "length: 20"),
        ("length: 20 m", "lenght: 20 m"),
        ("expires: 2030-01-01", "expires: soon"),
        ("[1 m/s, 2 m/s]", "[1 m/s]"),
        ("geometry: head_on", "geometry: headon"),
        ("schema: ccas/ruleset@1", "schema: ccas/ruleset@2"),
    ],
)
def test_schema_refuses_what_the_reader_refuses(old: str, new: str) -> None:
    assert told(ALL.replace(old, new))
