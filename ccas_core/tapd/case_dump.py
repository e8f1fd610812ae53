"""Cases written as encounter files, which read back as the same cases."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..ships import UNKNOWN
from ..units import DEGREE
from ..yaml_nodes import written
from .cases import Case, CaseShip
from .vocabulary import VOCABULARY, Kind, Scope, Vocabulary

Told = Mapping[str, Any]  # a verdict, as encounter files write it


def dump_cases(cases: Iterable[tuple[Case, Mapping[str, Told]]], vocabulary: Vocabulary = VOCABULARY) -> str:
    """Write cases, each with what rulesets say of it, as an encounter file."""
    lines = ["schema_version: 1", "cases:"]
    for case, said in cases:
        tree = case_tree(case, said, vocabulary)
        pairs = iter(tree.items())
        lines += [f"- {key}: {flow(value)}" for key, value in [next(pairs)]]
        for key, value in pairs:
            if key in ("ships", "expected"):
                lines += [f"  {key}:", *(f"    {written(k)}: {flow(v)}" for k, v in value.items())]
            else:
                lines.append(f"  {key}: {flow(value)}")
    return "\n".join(lines) + "\n"


def case_tree(case: Case, said: Mapping[str, Told], vocabulary: Vocabulary = VOCABULARY) -> dict[str, Any]:
    """What an encounter file says of a case, as plain values."""
    encounter = {
        name: value
        for name, value in case.encounter.items()
        if not (value == "none" and name in ("overtaker", "has_other_on_starboard"))
    }
    tree: dict[str, Any] = {"id": case.id, "title": case.title}
    tree["waterway"] = _facts(case.waterway, Scope.WATERWAY, vocabulary)
    tree["encounter"] = {name: _plain(value) for name, value in encounter.items()}
    tree["ships"] = {ship.id: _ship(ship, vocabulary) for ship in case.ships}
    tree["expected"] = {ruleset: _expected(view) for ruleset, view in said.items()}
    return {key: value for key, value in tree.items() if value}


def _ship(ship: CaseShip, vocabulary: Vocabulary) -> dict[str, Any]:
    tree = _facts(ship.facts, Scope.SHIP, vocabulary)
    if ship.pose is not None and ship.speed is not None:
        north, east, course = ship.pose
        tree["kinematics"] = {
            "north_m": _number(north),
            "east_m": _number(east),
            "course_deg": _number(course / DEGREE),
            "speed_mps": _number(ship.speed),
        }
        if "heading_deg" in tree:
            tree["kinematics"]["heading_deg"] = tree.pop("heading_deg")
    return tree


def _facts(facts: Mapping[str, Any], scope: Scope, vocabulary: Vocabulary) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for name, value in facts.items():
        fact = vocabulary.find(scope, name)
        if fact is None:
            raise ValueError(f"there is no fact {name!r} of a {scope}")
        if fact.kind is Kind.FLAGS and isinstance(value, str):
            tree[fact.key] = value.split()
        elif fact.kind is Kind.NUMBER and value is not UNKNOWN:
            tree[fact.key] = _number(value / fact.quantity.units[fact.quantity.unit])
        else:
            tree[fact.key] = _plain(value)
    return tree


def _expected(view: Told) -> dict[str, Any]:
    tree = {"kind": view["kind"], "give_way": view["give_way"], "stand_on": view["stand_on"]}
    more = {key: view[key] for key in ("pass", "initiator", "article") if view.get(key)}
    return {**tree, **more, "confidence": "derived"}


def _plain(value: Any) -> Any:
    return UNKNOWN.value if value is UNKNOWN else value


def _number(value: float) -> float:
    return float(f"{value:.9g}")


def flow(value: Any) -> str:
    """Write a plain value on one line, as a file says it.

    >>> flow({"length_m": 12.0, "regime": ["a", "b"]})
    '{length_m: 12.0, regime: [a, b]}'
    """
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{written(str(key))}: {flow(each)}" for key, each in value.items()) + "}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ", ".join(flow(each) for each in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, int | float) else written(str(value))
