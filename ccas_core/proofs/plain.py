"""Ships with no more facts than it takes: what a solver states beyond that only hides what matters."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

from ..tapd.cases import Case, CaseShip

USUAL_LENGTH: Final = 80.0  # of a ship whose length does not matter [m]
_SIZE: Final = ("length", "beam")  # every ship has these


def plainer(case: Case, holds: Callable[[Case], bool]) -> Case:
    """Leave out one stated fact after the other, as long as something holds of the ships."""
    for simpler in (_length, _ship_fact, _waterway_fact, _regime, _encounter_fact):
        case = _as_far_as_it_holds(case, simpler, holds)
    return case


def beam_of(length: float) -> float:
    """Breadth of a ship that does not state it [m].

    >>> beam_of(80.0), beam_of(5.0)
    (10.0, 2.0)
    """
    return max(2.0, round(length / 8.0, 1))


def _as_far_as_it_holds(
    case: Case, simpler: Callable[[Case], Iterator[tuple[object, Case]]], holds: Callable[[Case], bool]
) -> Case:
    tried: set[object] = set()
    going = True
    while going:
        going = False
        for what, candidate in simpler(case):
            if what in tried:
                continue
            tried.add(what)
            if holds(candidate):
                case, going = candidate, True
                break
    return case


def _with_ship(case: Case, ship: CaseShip, facts: Mapping[str, Any]) -> Case:
    ships = tuple(replace(each, facts=dict(facts)) if each is ship else each for each in case.ships)
    return replace(case, ships=ships)


def _length(case: Case) -> Iterator[tuple[object, Case]]:
    usual = {"length": USUAL_LENGTH, "beam": beam_of(USUAL_LENGTH)}
    for ship in case.ships:
        yield ship.id, _with_ship(case, ship, {**ship.facts, **usual})


def _ship_fact(case: Case) -> Iterator[tuple[object, Case]]:
    for ship in case.ships:
        for name in ship.facts:
            if name not in _SIZE:
                yield (ship.id, name), _with_ship(case, ship, _without(ship.facts, name))


def _waterway_fact(case: Case) -> Iterator[tuple[object, Case]]:
    for name in case.waterway:
        yield name, replace(case, waterway=_without(case.waterway, name))


def _regime(case: Case) -> Iterator[tuple[object, Case]]:
    words = str(case.waterway.get("regime", "")).split()
    for word in words if len(words) > 1 else ():
        regime = " ".join(each for each in words if each != word)
        yield word, replace(case, waterway={**case.waterway, "regime": regime})


def _encounter_fact(case: Case) -> Iterator[tuple[object, Case]]:
    for name in case.encounter:
        yield name, replace(case, encounter=_without(case.encounter, name))


def _without(facts: Mapping[str, Any], name: str) -> dict[str, Any]:
    return {each: value for each, value in facts.items() if each != name}
