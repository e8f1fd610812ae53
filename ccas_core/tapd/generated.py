"""Encounters made at random, over the facts that rulesets ask for: stated geometries, and ships under way.

A ship differs from the defaults in a few facts only, so that an example can be read.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..ships import UNKNOWN, ShipId
from ..units import DEGREE
from .cases import Case, CaseShip
from .language.formula import Formula, Sign, facts_of, walk
from .language.polynomial import Polynomial
from .rules import RulesetText
from .ruleset import AbstractRuleset
from .vocabulary import Fact, Kind, Scope, Vocabulary
from .written import WrittenRuleset

A: Final = ShipId("A")
B: Final = ShipId("B")
_RANGES: Final[Mapping[str, tuple[float, float]]] = {  # of numbers by their unit, in SI
    "m": (5.0, 150.0),
    "t": (2e4, 5e6),
    "deg": (0.0, 2.0 * math.pi),
    "m/s": (0.5, 6.0),
    "s": (0.0, 900.0),
    "": (0.0, 20.0),
}
_GEOMETRIES: Final = (
    {"geometry": "head_on"},
    {"geometry": "crossing", "has_other_on_starboard": A},
    {"geometry": "crossing", "has_other_on_starboard": B},
    {"geometry": "overtaking", "overtaker": A},
    {"geometry": "overtaking", "overtaker": B},
)
_MOST_STATED: Final = 4  # facts of a ship, besides its length


@dataclass(frozen=True, slots=True, kw_only=True)
class Asked:
    """Facts that rulesets ask for, values near which they change their mind, and their regimes."""

    ship: tuple[Fact, ...]
    waterway: tuple[Fact, ...]
    limits: Mapping[str, tuple[float, ...]]  # by the name of a ship's number, SI
    regimes: tuple[str, ...]


def asked_by(*rulesets: AbstractRuleset) -> Asked:
    """Collect what rulesets ask for; of one that is not a file, nothing is known."""
    names: set[str] = set()
    limits: dict[str, set[float]] = {}
    regimes: set[str] = set()
    for ruleset in rulesets:
        if not isinstance(ruleset, WrittenRuleset):
            continue
        regimes |= ruleset.text.regimes.keys()
        for formula in _formulas(ruleset.text):
            names |= facts_of(formula)
            for name, limit in _limits(formula, ruleset.text.constants):
                limits.setdefault(name, set()).add(limit)
    vocabulary = rulesets[0].vocabulary
    names |= {"own.length", "own.follows_starboard_side"}
    return Asked(
        ship=_known(vocabulary, Scope.SHIP, {name.partition(".")[2] for name in names if _of_ship(name)}),
        waterway=_known(
            vocabulary,
            Scope.WATERWAY,
            {name.removeprefix("waterway.") for name in names if name.startswith("waterway.")},
        ),
        limits={name: tuple(sorted(found)) for name, found in limits.items()},
        regimes=tuple(sorted(regimes)),
    )


def _formulas(text: RulesetText) -> Iterator[Formula]:
    if (found := text.recognition) is not None:
        yield from (found.risk, found.overtaking, found.head_on, found.crossing, found.from_starboard)
    yield from (rule.condition for rule in text.rules)


def _of_ship(name: str) -> bool:
    return name.startswith(("own.", "other."))


def _known(vocabulary: Vocabulary, scope: Scope, names: Iterable[str]) -> tuple[Fact, ...]:
    wanted = frozenset(names)
    return tuple(fact for fact in vocabulary.by_scope[scope] if fact.name in wanted)


def _limits(formula: Formula, constants: Mapping[str, Polynomial]) -> Iterator[tuple[str, float]]:
    """Numbers with which a single fact of a ship is compared."""
    for part in walk(formula):
        if not isinstance(part, Sign):
            continue
        terms = dict(part.polynomial.with_values(constants).terms)
        offset = terms.pop((), None)
        if len(terms) == 1 and offset is not None:
            ((monomial, factor),) = terms.items()
            if len(monomial) == 1 and _of_ship(monomial[0]):
                yield monomial[0].partition(".")[2], float(-offset / factor)


def encounters(asked: Asked, generator: np.random.Generator) -> Iterator[Case]:
    """Encounters of two ships A and B without end, in turn with stated geometry and with ships under way."""
    number = 0
    while True:
        number += 1
        ships = [_ship(asked, generator, id_) for id_ in (A, B)]
        encounter: dict[str, Any] = {}
        if number % 2:
            chosen = _GEOMETRIES[int(generator.integers(len(_GEOMETRIES)))]
            encounter = {
                "risk_of_collision": True,
                "overtaker": "none",
                "has_other_on_starboard": "none",
                **chosen,
            }
        else:
            ships = _under_way(ships, generator)
        yield Case(
            id=f"generated_{number}",
            ships=tuple(ships),
            waterway=_some(asked.waterway, asked, generator, 2),
            encounter=encounter,
        )


def _ship(asked: Asked, generator: np.random.Generator, id_: ShipId) -> CaseShip:
    facts = _some([f for f in asked.ship if f.name != "length"], asked, generator, _MOST_STATED)
    length = next(fact for fact in asked.ship if fact.name == "length")
    return CaseShip(id=id_, facts={"length": _number(length, asked, generator), **facts})


def _some(facts: Iterable[Fact], asked: Asked, generator: np.random.Generator, most: int) -> dict[str, Any]:
    """State a few facts, otherwise than by default."""
    known = list(facts)
    count = min(len(known), int(generator.integers(most + 1)))
    places: list[int] = generator.choice(len(known), size=count, replace=False).tolist() if count else []
    return {known[place].name: _value(known[place], asked, generator) for place in sorted(places)}


def _value(fact: Fact, asked: Asked, generator: np.random.Generator) -> Any:
    if fact.kind is Kind.FLAG:
        return fact.default is not True
    if fact.kind is Kind.NUMBER:
        return _number(fact, asked, generator)
    if fact.kind is Kind.FLAGS:
        return str(generator.choice(asked.regimes)) if asked.regimes else ""
    if fact.kind is Kind.CHOICE:
        others = [word for word in fact.choices if word != fact.default]
        return str(generator.choice(others))
    return fact.default if fact.default is not UNKNOWN else ""


def _number(fact: Fact, asked: Asked, generator: np.random.Generator) -> float:
    """A number near one of its limits, or anywhere."""
    unit = fact.quantity.units[fact.quantity.unit]
    limits = asked.limits.get(fact.name, ())
    if limits and generator.random() < 0.5:
        near = float(generator.choice(limits)) + unit * float(generator.integers(-1, 2))
        return max(near, unit)
    low, high = _RANGES[fact.quantity.unit]
    return round(float(generator.uniform(low, high)) / unit) * unit


def _under_way(ships: list[CaseShip], generator: np.random.Generator) -> list[CaseShip]:
    """Place ships so that they come close to one another within ten minutes."""
    speeds = [round(float(generator.uniform(1.0, 6.0)), 1) for _ in ships]
    turn = round(float(generator.choice([0.0, 180.0, generator.uniform(0.0, 360.0)])))
    time, beside = float(generator.uniform(60.0, 600.0)), float(generator.uniform(-60.0, 60.0))
    course = turn * DEGREE
    # both would be at the same place at that time, but for the passing distance, which is across
    north = speeds[0] * time - speeds[1] * time * math.cos(course)
    east = beside - speeds[1] * time * math.sin(course)
    one, other = ships
    return [
        CaseShip(id=one.id, facts=one.facts, pose=(0.0, 0.0, 0.0), speed=speeds[0]),
        CaseShip(id=other.id, facts=other.facts, pose=(round(north), round(east), course), speed=speeds[1]),
    ]
