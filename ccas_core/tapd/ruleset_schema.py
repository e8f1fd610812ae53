"""The JSON Schema (draft 7) of ruleset files, for editors: every key with its meaning, all words allowed.

An editor warns by it while one writes.  What counts is the reader, which knows more: names, types, units.
"""

from __future__ import annotations

from typing import Any, Final

from ..quantities import QUANTITY_OF, TIME, Quantity
from .ruleset_draft import SCHEMA
from .ruleset_keys import BLOCKS, Key, Shape
from .vocabulary import VOCABULARY, Fact, Kind, Scope, Vocabulary

FILE_NAME: Final = "ccas-ruleset-1.schema.json"
MODELINE: Final = f"# yaml-language-server: $schema=./{FILE_NAME}"

Schema = dict[str, Any]
_SCALAR: Final = ["string", "number", "boolean"]  # a text that an editor takes for something else
_NUMERAL: Final = r"-?[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?"


def ruleset_schema(vocabulary: Vocabulary = VOCABULARY) -> Schema:
    """Schema of ruleset files; the facts that tests may state are those of the vocabulary."""
    definitions = {name: _block(keys, vocabulary) for name, keys in BLOCKS.items() if name != "ruleset"}
    definitions["exceptions"] = _one_or_more({"anyOf": [_text(), {"$ref": "#/definitions/exception"}]})
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": f"Ruleset of CCAS ({SCHEMA})",
        **_block(BLOCKS["ruleset"], vocabulary),
        "definitions": definitions,
    }


def _block(keys: tuple[Key, ...], vocabulary: Vocabulary) -> Schema:
    return {
        "type": "object",
        "additionalProperties": False,
        "required": [key.name for key in keys if key.required],
        "properties": {key.name: _described(key, vocabulary) for key in keys},
    }


def _described(key: Key, vocabulary: Vocabulary) -> Schema:
    found = {"description": key.meaning, **_held(key, vocabulary)}
    if "$ref" in found:  # draft 7 reads nothing beside a reference
        found = {"description": key.meaning, "allOf": [{"$ref": found["$ref"]}]}
    if key.example:
        found["examples"] = [key.example]
    return found


def _held(key: Key, vocabulary: Vocabulary) -> Schema:
    if key.words:
        return {"enum": list(key.words)}
    block = {"$ref": f"#/definitions/{key.block}"}
    return {
        Shape.TEXT: _text(),
        Shape.NAME: _text(),
        Shape.SHIP: _text(),
        Shape.FLAG: {"type": "boolean"},
        Shape.DATE: {"type": "string", "pattern": "^[0-9]{4}-[0-9]{2}-[0-9]{2}$"},
        Shape.CONDITION: _one_or_more(_text()),
        Shape.NUMBER: _number(None),
        Shape.SPAN: {"type": "array", "items": _number(None), "minItems": 2, "maxItems": 2},
        Shape.NAMES: _one_or_more(_text()),
        Shape.SHIPS: _one_or_more(_text(), least=0),
        Shape.CRITERIA: {"type": "array", "items": _text(), "minItems": 1},
        Shape.PAIRS: {
            "type": "array",
            "items": {"type": "array", "items": _text(), "minItems": 2, "maxItems": 2},
        },
        Shape.EXCEPTIONS: {"$ref": "#/definitions/exceptions"},
        Shape.SHIP_FACTS: {"type": "object", "minProperties": 2, "additionalProperties": _ship(vocabulary)},
        Shape.WATERWAY_FACTS: _facts(Scope.WATERWAY, vocabulary),
        Shape.BLOCK: block,
        Shape.BLOCKS: {"type": "array", "items": block},
        Shape.TIMES: {"type": "object", "additionalProperties": _number(TIME)},
        Shape.NAMED_BLOCKS: {"type": "object", "additionalProperties": _named(key, block)},
        Shape.NAMED_TEXTS: {"type": "object", "additionalProperties": _text()},
        Shape.NAMED_CONDITIONS: {"type": "object", "additionalProperties": _one_or_more(_text())},
    }[key.shape]


def _named(key: Key, block: Schema) -> Schema:
    """A parameter may be the number alone."""
    return {"anyOf": [block, _number(None)]} if key.block == "parameter" else block


def _text() -> Schema:
    return {"type": list(_SCALAR)}


def _one_or_more(one: Schema, least: int = 1) -> Schema:
    return {"anyOf": [one, {"type": "array", "items": one, "minItems": least}]}


def _number(quantity: Quantity | None) -> Schema:
    """A number with one of the units of a quantity, or of any."""
    units = [unit for unit in (quantity.units if quantity else QUANTITY_OF) if unit]
    if quantity is not None and not units:
        return {"type": "number"}
    pattern = f"^{_NUMERAL} +({'|'.join(sorted(units))})$"
    measured = {"type": "string", "pattern": pattern}
    return measured if quantity else {"anyOf": [measured, {"type": "number"}]}


def _ship(vocabulary: Vocabulary) -> Schema:
    """A ship of a test: its facts, and where it is."""
    found = _facts(Scope.SHIP, vocabulary)
    found["properties"] |= {
        "at": {
            "description": "Where it is: [east, north].",
            "type": "array",
            "items": _number(QUANTITY_OF["m"]),
            "minItems": 2,
            "maxItems": 2,
        },
        "course": {"description": "Course over ground, from north.", **_number(QUANTITY_OF["deg"])},
        "speed": {"description": "Speed over ground.", **_number(QUANTITY_OF["m/s"])},
    }
    return found


def _facts(scope: Scope, vocabulary: Vocabulary) -> Schema:
    return {
        "type": "object",
        "additionalProperties": False,
        "properties": {
            fact.name: {"description": f"{fact.meaning[:1].upper()}{fact.meaning[1:]}.", **_fact(fact)}
            for fact in vocabulary.by_scope[scope]
        },
    }


def _fact(fact: Fact) -> Schema:
    if fact.kind is Kind.FLAG:
        return {"enum": [True, False, "unknown"]}
    if fact.kind is Kind.CHOICE:
        return {"enum": [*fact.choices, "unknown"]}
    if fact.kind is Kind.NUMBER:
        return {"anyOf": [_number(fact.quantity), {"const": "unknown"}]}
    return _one_or_more(_text(), least=0) if fact.kind is Kind.FLAGS else _text()
