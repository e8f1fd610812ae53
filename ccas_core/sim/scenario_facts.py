"""Stated facts of ships and waterways in scenario files: read, checked by the vocabulary, written again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

from ..ships import UNKNOWN, Facts, FactValue
from ..strict_yaml import Reader
from ..tapd.case_file import read_fact
from ..tapd.vocabulary import Fact, Kind, Scope, Vocabulary
from ..yaml_nodes import Node, Scalar, written

Written: TypeAlias = str | Sequence[str]  # what a file says: a scalar, or a list of them


def read_facts(reader: Reader, node: Node | None, scope: Scope, vocabulary: Vocabulary) -> dict[str, Any]:
    """Read stated facts, in SI; a list of words becomes one text with blanks between."""
    known = {fact.name: fact for fact in vocabulary.by_scope[scope]}
    found = {}
    for key, value in reader.entries(node):
        fact = known.get(key.text)
        if fact is None:
            reader.unknown(key, f"fact of a {scope}", key.text, known)
        elif isinstance(value, Scalar) and value.text == UNKNOWN.value:
            found[fact.name] = UNKNOWN
        else:
            found[fact.name] = read_fact(reader, value, fact, in_units=True)
    return found


def write_facts(facts: Facts, scope: Scope, vocabulary: Vocabulary) -> dict[str, Written]:
    """Write stated facts so that they are read as the same."""
    return {
        written(name): _written_fact(value, vocabulary.find(scope, name)) for name, value in facts.items()
    }


def _written_fact(value: FactValue, fact: Fact | None) -> Written:
    if value is UNKNOWN:
        return UNKNOWN.value
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return [written(word) for word in value.split()] if _is_list(fact) else written(value)
    if fact is not None and fact.quantity.unit:
        return fact.quantity.write(value)
    return repr(value)


def _is_list(fact: Fact | None) -> bool:
    return fact is not None and fact.kind is Kind.FLAGS
