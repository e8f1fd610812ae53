"""Conditions in words: names of ships, values of parameters, and what was found, in their units."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from ..ships import UNKNOWN
from ..units import DEGREE
from .facts import PairFacts
from .language.compiler import DIMENSIONS, Dimensions
from .language.formula import Formula, Known, Measured, Named, Not, Same, Sign, Test
from .language.polynomial import Polynomial, number
from .language.threefold import Finding
from .rules import RulesetText

_UNITS: Final[dict[Dimensions, str]] = {
    (1, 0, 0, 0): "m",
    (0, 1, 0, 0): "s",
    (1, -1, 0, 0): "m/s",
    (0, 0, 1, 0): "t",
    (0, 0, 0, 1): "deg",
}
_TONNE: Final = 1000.0
_ANGLES: Final = ("bearing", "abs", "course_difference")  # given in radians
_FROM_STARBOARD: Final = re.compile(r"from_starboard\((own|other), (own|other)\)")


@dataclass(frozen=True, slots=True)
class Reading:
    """What a comparison measures: the value found, and the limit, both in the unit; infinite is never."""

    value: float
    limit: float
    unit: str

    @property
    def found(self) -> str:
        """The value in words.

        >>> Reading(125.0, 900.0, "s").found, Reading(math.inf, 900.0, "s").found
        ('125.0 s', 'never')
        """
        if math.isinf(self.value):
            return "never"
        return f"{self.value:.1f} {self.unit}" if self.unit else f"{self.value:g}"

    @property
    def away(self) -> float:
        """How far the value lies from the limit."""
        return abs(self.value - self.limit)

    def margin(self, side: str) -> str:
        """How far the value lies from the limit, in words.

        >>> Reading(125.0, 900.0, "s").margin("inside")
        '775.0 s inside'
        """
        if not math.isfinite(self.away):
            return ""
        if self.away == 0.0:
            return f"on the limit, {side}"
        digits = f"{self.away:.1f}" if self.away >= 0.1 else f"{self.away:.2g}"
        return f"{digits if self.unit else f'{self.away:g}'} {self.unit} {side}".replace("  ", " ")

    @property
    def relative(self) -> float:
        """How far the value lies from the limit, as a part of the larger of the two; at most 1."""
        largest = max(abs(self.value), abs(self.limit))
        return min(1.0, self.away / largest) if 0.0 < largest < math.inf else 1.0


class Words:
    """Says the conditions of a ruleset for two ships."""

    def __init__(self, text: RulesetText, facts: PairFacts) -> None:
        self._facts = facts
        self._parameters = text.parameters
        self._values = {f"parameter.{name}": number(each.value) for name, each in text.parameters.items()}

    def named(self, text: str) -> str:
        """Put names of ships for own and other, and values of parameters for their names."""
        for name, parameter in self._parameters.items():
            if name in text:
                shown = amount(parameter.value, parameter.dimensions)
                text = re.sub(rf"(?<![\w.]){name}(?![\w.(])", shown, text)
        ships = {"own": self._facts.own, "other": self._facts.other}
        return re.sub(r"(?<![\w.])(own|other)(?!\w)", lambda word: ships[word[1]], text)

    @staticmethod
    def say(leaf: Formula) -> str:
        """Say a condition that is not made of others, as a ruleset file would."""
        match leaf:
            case Test(fact="waterway.regime"):
                return f"regime.{leaf.value}"
            case Test():
                return leaf.fact if leaf.value is True else f"{leaf.fact} == {leaf.value}"
            case Same():
                return f"{leaf.one} == {leaf.other}"
            case Known():
                return f"known({leaf.fact})"
            case _:
                return "what its name says"

    def found(self, finding: Finding) -> str:
        """Say what was found where a fact was looked at; nothing where true and false say it all."""
        core = stripped(finding.formula)
        match core:
            case Named() if core.measure is not None:
                reading = self.reading(finding)
                return reading.found if reading is not None else ""
            case Named(part=Sign()):
                return self._sign(core.name)
            case Test() if core.value is True or core.fact == "waterway.regime":
                return ""
            case Test():
                return self._fact(core.fact)
            case Same():
                return f"{self._fact(core.one)}, {self._fact(core.other)}"
            case Known():
                return self._fact(core.fact)
        return ""

    def _fact(self, name: str) -> str:
        value = self._facts[name]
        ships = {"own": self._facts.own, "other": self._facts.other}
        if value is UNKNOWN or value is None:
            return "unknown"
        if isinstance(value, frozenset):
            return " ".join(sorted(value)) or "none"
        return str(ships.get(value, value)) if isinstance(value, str) else f"{value}"

    def _sign(self, name: str) -> str:
        """Say by how much ships come nearer, or courses cross."""
        if not self._facts.moving:
            return ""
        rx, ry, wx, wy, ovx, ovy, tvx, tvy = self._facts.motion[:8]
        if name == "closing":
            away = math.hypot(rx, ry)
            return f"{-(rx * wx + ry * wy) / away:.1f} m/s" if away else ""
        if match := _FROM_STARBOARD.fullmatch(name):
            turn = math.atan2(ovx * tvy - ovy * tvx, ovx * tvx + ovy * tvy) / DEGREE
            turn = turn if match[1] == "own" else -turn
            side = "starboard" if turn < 0 else "port"
            return f"from {side}, courses {abs(turn):.1f} deg apart"
        return ""

    def reading(self, finding: Finding) -> Reading | None:
        """What a comparison measures; none where it is not known, or where nothing is measured."""
        core = stripped(finding.formula)
        if not isinstance(core, Named) or core.measure is None:
            return None
        value, limit = (self._measured(each) for each in (core.measure.quantity, core.measure.limit))
        if value is None or limit is None:
            return None
        dimensions = core.measure.dimensions
        size = _TONNE if dimensions == DIMENSIONS["a weight"] else 1.0
        return Reading(value / size, limit / size, _UNITS.get(dimensions, ""))

    def _measured(self, measured: Measured) -> float | None:
        """Value of a quantity, in the units of conditions: angles in degrees, all else in SI."""
        if not isinstance(measured, Polynomial):
            value = self._facts.quantity(measured)
            value = value / DEGREE if measured[0] in _ANGLES else value
            return None if math.isnan(value) else value
        polynomial = measured.with_values(self._values)
        facts = {name: self._facts[name] for name in polynomial.variables}
        if any(isinstance(value, bool) or not isinstance(value, int | float) for value in facts.values()):
            return None
        return polynomial.evaluated({name: float(value) for name, value in facts.items()}, float)


def stripped(formula: Formula) -> Formula:
    """What stands behind all `not`."""
    while isinstance(formula, Not):
        formula = formula.part
    return formula


def amount(value: Fraction, dimensions: Dimensions) -> str:
    """Say a number with its unit.

    >>> amount(Fraction(45, 2), DIMENSIONS["an angle"])
    '22.5 deg'
    """
    size = _TONNE if dimensions == DIMENSIONS["a weight"] else 1
    return f"{float(value / Fraction(size)):.12g} {_UNITS.get(dimensions, '')}".rstrip()
