"""What a part of a condition may be besides a formula: a number, a quantity of motion, words, a ship."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, TypeAlias

from ..vocabulary import Fact
from .dimensions import Dimensions, measured
from .formula import Formula, Measured
from .polynomial import Polynomial

SHIP_MOTIONS: Final = ("speed", "time_to_intersection")


@dataclass(frozen=True, slots=True)
class Amount:
    """A number: a polynomial, and what it measures."""

    value: Polynomial
    dimensions: Dimensions


@dataclass(frozen=True, slots=True)
class Moving:
    """A quantity of motion, which can only be compared."""

    name: str
    ships: tuple[str, ...]
    dimensions: Dimensions


@dataclass(frozen=True, slots=True)
class Chosen:
    """A fact with some words as values."""

    name: str
    fact: Fact


@dataclass(frozen=True, slots=True)
class Ship:
    """One of the two ships."""

    name: str


@dataclass(frozen=True, slots=True)
class Literal:
    """A word that is no name: perhaps a value of a fact."""

    word: str


Term: TypeAlias = Amount | Moving | Chosen | Ship | Literal
Value: TypeAlias = Formula | Term


def kind_of(value: Value) -> str:
    """Say what a part of a condition is."""
    if isinstance(value, Amount | Moving):
        return measured(value.dimensions)
    if isinstance(value, Chosen):
        return f"'{value.name}', which has words for values,"
    if isinstance(value, Ship):
        return "a ship"
    return f"'{value.word}'" if isinstance(value, Literal) else "a condition"


def shown(value: Moving) -> str:
    """Write a quantity of motion as a condition does."""
    if value.name in SHIP_MOTIONS:
        return f"{value.ships[0]}.{value.name}"
    return f"{value.name}({', '.join(value.ships)})" if value.ships else value.name


def choices_of(fact: Fact) -> str:
    """Say which values a fact has."""
    return f"one of {', '.join(fact.choices)}" if fact.choices else "a word"


def measure_of(value: Amount | Moving) -> Measured:
    """What a side of a comparison measures."""
    return value.value if isinstance(value, Amount) else (value.name, *value.ships)
