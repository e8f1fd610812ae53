"""Tests of the language of conditions, with conditions compiled by themselves and ships at random."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np
import pytest

from ccas_core.tapd.facts import PairFacts
from ccas_core.tapd.language import syntax
from ccas_core.tapd.language.code import Values, program
from ccas_core.tapd.language.compiler import UNITS, Compiler, Definition, Parameter
from ccas_core.tapd.language.formula import Formula, Named, rebuilt
from ccas_core.tapd.language.motion import tangent
from ccas_core.tapd.language.polynomial import number
from ccas_core.tapd.vocabulary import VOCABULARY

from .. import A, B, stated


@dataclass(frozen=True)
class Language:
    """Definitions, parameters (value, unit) and regimes in which conditions are compiled."""

    definitions: Mapping[str, tuple[tuple[str, ...], str]] = field(default_factory=dict)
    parameters: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    regimes: tuple[str, ...] = ()

    def compiler(self) -> Compiler:
        """Make a compiler of its own."""
        parameters = {}
        for name, (digits, unit) in self.parameters.items():
            size, dimensions = UNITS[unit]
            value = Fraction(digits) * size
            parameters[name] = Parameter(value, value, value, dimensions)
        return Compiler(
            vocabulary=VOCABULARY,
            parameters=parameters,
            definitions={
                name: Definition(ships, syntax.parse(text), text)
                for name, (ships, text) in self.definitions.items()
            },
            regimes=dict.fromkeys(self.regimes, ""),
        )

    def formula(self, text: str) -> Formula:
        """Compile a condition."""
        return self.compiler().condition(text)

    def decide(self, text: str) -> Callable[[PairFacts], bool]:
        """Compile a condition so that it can be asked."""
        compiler = self.compiler()
        formula = compiler.condition(text)
        values = {f"parameter.{name}": number(each.value) for name, each in compiler.parameters.items()}
        tangents = {name: degrees.with_values(values).constant for name, degrees in compiler.tangents.items()}
        constants = values | {
            name: number(tangent(degrees)) for name, degrees in tangents.items() if degrees is not None
        }
        made = program([formula], VOCABULARY, constants)
        return lambda facts: made.decisions[0](*values_of(facts), [None] * made.memory)

    def fault(self, text: str) -> syntax.Fault:
        """What is wrong with a condition."""
        with pytest.raises(syntax.Fault) as caught:
            self.formula(text)
        return caught.value


PLAIN = Language()


def values_of(facts: PairFacts) -> tuple[Values, Values, Values, Values, Values]:
    """What a compiled condition is called with, besides its memory."""
    return facts.own_values, facts.other_values, facts.waterway_values, facts.pair_values, facts.motion


def decided(formula: Formula, facts: PairFacts) -> bool:
    """Run a formula by itself."""
    made = program([formula], VOCABULARY, {})
    return made.decisions[0](*values_of(facts), [None] * made.memory)


def unnamed(formula: Formula) -> Formula:
    """Leave out the names of parts."""
    if isinstance(formula, Named):
        return unnamed(formula.part)
    return rebuilt(formula, unnamed)


def random_facts(generator: np.random.Generator) -> PairFacts:
    """Two ships anywhere, in any state; now and then at rest, on one spot, on one course."""
    places = []
    for _ in range(2):
        north, east = generator.choice([0.0, 100.0, -250.5, generator.normal(0.0, 500.0)], 2)
        course = generator.choice([0.0, 45.0, 90.0, 180.0, -90.0, generator.uniform(-180.0, 180.0)])
        speed = generator.choice([0.0, 3.0, 5.0, generator.uniform(0.0, 8.0)], p=[0.1, 0.2, 0.2, 0.5])
        places.append((float(north), float(east), float(course), float(speed)))
    ships = [
        {
            "length": float(generator.choice([10.0, 20.0, 110.0])),
            "propulsion": str(generator.choice(["motor", "sail", "muscle"])),
            "ferry": bool(generator.random() < 0.3),
            "follows_starboard_side": bool(generator.random() < 0.5),
            "wind_side": str(generator.choice(["port", "starboard"])),
            "passengers_max": float(generator.integers(0, 30)),
        }
        for _ in range(2)
    ]
    geometry = str(generator.choice(["head_on", "crossing", "overtaking", "none"]))
    encounter = {
        "risk_of_collision": bool(generator.random() < 0.7),
        "geometry": geometry,
        "overtaker": str(generator.choice([A, B])) if geometry == "overtaking" else "none",
        "has_other_on_starboard": str(generator.choice([A, B, "none"])),
    }
    waterway = {"current": str(generator.choice(["none", "downstream"])), "regime": "tidal"}
    return stated(ships[0], ships[1], waterway=waterway, encounter=encounter, at=(places[0], places[1]))


def moving(rx: float, ry: float, own: tuple[float, float], other: tuple[float, float]) -> PairFacts:
    """Facts of two ships with this relative position and these velocities, exactly (on the grid)."""
    facts = stated(at=((0.0, 0.0, 0.0, 0.0), (rx, ry, 0.0, 0.0)))
    values = list(facts.motion)
    values[2:8] = [other[0] - own[0], other[1] - own[1], *own, *other]
    return replace(facts, motion=tuple(values))
