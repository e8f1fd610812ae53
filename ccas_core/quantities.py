"""Numbers with units, as files write them: what they measure, how they are written, their bounds.

Inside, a number is in SI units; a file is read with any of the units of its quantity.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from . import units
from .errors import did_you_mean

DIGITS: Final = 12  # that a file keeps of a number with a unit

_FINITE = r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?"
NUMERAL: Final = rf"{_FINITE}|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)"
MEASURE: Final = re.compile(rf"({NUMERAL})( *)(\S*)")  # numeral, spaces, unit


def as_float(numeral: str) -> float:
    """Read a number, as YAML writes it.

    >>> as_float("1e3"), as_float("-.inf")
    (1000.0, -inf)
    """
    return float(re.sub(r"\.(?=[inIN])", "", numeral))


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a number measures: its units and their sizes in SI; files are written in the first."""

    name: str
    units: Mapping[str, float]

    @property
    def unit(self) -> str:
        """The first of the units."""
        return next(iter(self.units))

    @property
    def expected(self) -> str:
        """What a file must say: the quantity and its units."""
        *others, last = self.units
        return f"{self.name} in {', '.join(others)}{' or ' if others else ''}{last}" if last else self.name

    def keep(self, value: float) -> float:
        """Round an SI value to what a file keeps of it: written and read, it stays the same."""
        size = self.units[self.unit]
        return float(f"{value / size:.{DIGITS}g}") * size

    def write(self, value: float) -> str:
        """Say an SI value as files do.

        >>> TIME.write(20.0), ANGLE.write(units.DEGREE * 22.5)
        ('20 s', '22.5 deg')
        """
        return f"{value / self.units[self.unit]:.{DIGITS}g} {self.unit}".rstrip()


NUMBER: Final = Quantity("a number without unit", {"": 1.0})
TIME: Final = Quantity("a time", {"s": 1.0, "min": units.MINUTE, "h": units.HOUR})
LENGTH: Final = Quantity("a length", {"m": 1.0, "km": units.KILOMETRE, "NM": units.NAUTICAL_MILE})
SPEED: Final = Quantity("a speed", {"m/s": 1.0, "km/h": units.KILOMETRE_PER_HOUR, "kn": units.KNOT})
ANGLE: Final = Quantity("an angle", {"deg": units.DEGREE, "rad": 1.0})
MASS: Final = Quantity("a weight", {"t": units.TONNE, "kg": 1.0})
AREA: Final = Quantity("an area", {"m2": 1.0})
CURVATURE: Final = Quantity("a curvature", {"1/m": 1.0})
ACCELERATION: Final = Quantity("an acceleration", {"m/s2": 1.0})
YAW_RATE: Final = Quantity("a yaw rate", {"deg/s": units.DEGREE, "rad/s": 1.0})
YAW_ACCELERATION: Final = Quantity("a change of a yaw rate", {"deg/s2": units.DEGREE, "rad/s2": 1.0})
_QUANTITIES = (
    *(NUMBER, TIME, LENGTH, SPEED, ANGLE, MASS, AREA, CURVATURE),
    *(ACCELERATION, YAW_RATE, YAW_ACCELERATION),
)
QUANTITY_OF: Final = {unit: quantity for quantity in _QUANTITIES for unit in quantity.units}


@dataclass(frozen=True, slots=True, kw_only=True)
class Range:
    """Bounds of a number, in SI."""

    above: float = -math.inf
    at_least: float = -math.inf
    below: float = math.inf
    at_most: float = math.inf

    def holds(self, value: float) -> bool:
        """Whether a value lies within the bounds."""
        return self.above < value < self.below and self.at_least <= value <= self.at_most

    def words(self, quantity: Quantity) -> str:
        """Say the bounds as files do."""
        lower = {"above": self.above, "at least": self.at_least}
        bounds = lower | {"below": self.below, "at most": self.at_most}
        finite = {word: bound for word, bound in bounds.items() if math.isfinite(bound)}
        return " and ".join(f"{word} {quantity.write(bound)}" for word, bound in finite.items())


ANY: Final = Range()


def fault(digits: str, space: str, unit: str, quantity: Quantity) -> tuple[str, str] | None:
    """What is wrong with a number and its unit, and a hint."""
    if not digits:
        return f"is not {quantity.name}", ""
    if not unit:
        usual = quantity.unit
        return ("has no unit", f"if it is in {usual}, write '{digits} {usual}'") if usual else None
    if unit in quantity.units:
        return None if space else ("has no space before its unit", f"write '{digits} {unit}'")
    if unit in QUANTITY_OF:
        return f"is {QUANTITY_OF[unit].name}, not {quantity.name}", ""
    return "has an unknown unit", did_you_mean(unit[:40], quantity.units) if quantity.unit else ""
