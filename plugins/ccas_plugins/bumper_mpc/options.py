"""What a scenario may set for the controller, and what it is where nothing is set."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from ccas_core.controllers import Option, Options
from ccas_core.quantities import ANGLE, LENGTH, NUMBER, SPEED, Range
from ccas_core.units import DEGREE

_NOT_NEGATIVE: Final = Range(at_least=0.0)
_SHARE: Final = Range(at_least=0.0, at_most=1.0)

OPTIONS: Final[Mapping[str, Option]] = {
    "horizon": Option(
        meaning="steps N of the horizon, each a control period",
        default=20.0,
        quantity=NUMBER,
        within=Range(at_least=2.0, at_most=100.0),
    ),
    "min_speed": Option(
        meaning="least surge speed, save in a crossing: there it is 0; a fifth of the nominal unless stated",
        default=None,
        quantity=SPEED,
        within=_NOT_NEGATIVE,
    ),
    "max_turn": Option(
        meaning="greatest turn from the course of the path while avoiding",
        default=40.0 * DEGREE,
        quantity=ANGLE,
        within=Range(above=0.0, at_most=90.0 * DEGREE),
    ),
    "act_within": Option(
        meaning="distance within which a ship is avoided; 12 lengths' way of both unless stated",
        default=None,
        quantity=LENGTH,
        within=_NOT_NEGATIVE,
    ),
    "head_on_distance": Option(
        meaning="safe distance across the path, head-on; by default what both domains need",
        default=None,
        quantity=LENGTH,
        within=_NOT_NEGATIVE,
    ),
    "overtaking_distance": Option(
        meaning="safe distance across the path, overtaking; by default what both domains need",
        default=None,
        quantity=LENGTH,
        within=_NOT_NEGATIVE,
    ),
    "crossing_distance": Option(
        meaning="safe distance astern of a ship that crosses; by default what both domains need",
        default=None,
        quantity=LENGTH,
        within=_NOT_NEGATIVE,
    ),
    "rules": Option(meaning="whether the cost has its rule term", default="yes", choices=("yes", "no")),
    "knows_current": Option(
        meaning="whether the current is compensated", default="yes", choices=("yes", "no")
    ),
}


def number(options: Options, name: str) -> float:
    """Value of an option that is a number and has a default."""
    return float(options.get(name, OPTIONS[name].default or 0.0))


def stated(options: Options, name: str, otherwise: float) -> float:
    """Value of an option, or what it is where a scenario does not state it."""
    return float(options[name]) if name in options else otherwise


def is_on(options: Options, name: str) -> bool:
    """Whether an option says yes."""
    return options.get(name, OPTIONS[name].default) == "yes"
