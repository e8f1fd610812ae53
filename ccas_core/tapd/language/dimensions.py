"""What numbers in a condition measure: powers of metre, second, kilogram and degree, and units."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Final, TypeAlias

from ...quantities import ANGLE, LENGTH, MASS, NUMBER, SPEED, TIME

Dimensions: TypeAlias = tuple[int, int, int, int]  # powers of m, s, kg, deg

DIMENSIONS: Final[Mapping[str, Dimensions]] = {
    NUMBER.name: (0, 0, 0, 0),
    LENGTH.name: (1, 0, 0, 0),
    TIME.name: (0, 1, 0, 0),
    SPEED.name: (1, -1, 0, 0),
    MASS.name: (0, 0, 1, 0),
    ANGLE.name: (0, 0, 0, 1),
}
UNITS: Final[Mapping[str, tuple[Fraction, Dimensions]]] = {
    "": (Fraction(1), (0, 0, 0, 0)),
    "m": (Fraction(1), (1, 0, 0, 0)),
    "km": (Fraction(1000), (1, 0, 0, 0)),
    "NM": (Fraction(1852), (1, 0, 0, 0)),
    "s": (Fraction(1), (0, 1, 0, 0)),
    "min": (Fraction(60), (0, 1, 0, 0)),
    "h": (Fraction(3600), (0, 1, 0, 0)),
    "m/s": (Fraction(1), (1, -1, 0, 0)),
    "km/h": (Fraction(1000, 3600), (1, -1, 0, 0)),
    "kn": (Fraction(1852, 3600), (1, -1, 0, 0)),
    "kg": (Fraction(1), (0, 0, 1, 0)),
    "t": (Fraction(1000), (0, 0, 1, 0)),
    "deg": (Fraction(1), (0, 0, 0, 1)),
}
_NAMES: Final = {dimensions: name for name, dimensions in DIMENSIONS.items()}


def measured(dimensions: Dimensions) -> str:
    """Say what a number measures.

    >>> measured((1, 0, 0, 0)), measured((2, 0, 0, 0))
    ('a length', 'a product of quantities')
    """
    return _NAMES.get(dimensions, "a product of quantities")
