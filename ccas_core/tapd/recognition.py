"""An encounter recognised from positions and courses, where it is neither stated nor remembered.

The conditions stand in the ruleset file (`encounter`).  What is the same with the ships swapped is looked at
once; what is not is looked at from either ship.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final, TypeAlias

from .language.code import Decision, Missing, UnknownFact, Values
from .language.formula import Formula, alike, mirrored
from .rules import Recognition

RECOGNISED: Final = ("risk_of_collision", "geometry", "overtaker", "has_other_on_starboard")

Arguments: TypeAlias = tuple[Values, Values, Values, Values, Values, list[Any]]
Recognised: TypeAlias = tuple[Any, Any, Any, Any]  # in the order of RECOGNISED
_NOTHING: Final[Recognised] = (False, "none", "none", "none")


def conditions_of(recognition: Recognition | None) -> list[Formula]:
    """Conditions in the order in which a `Recogniser` takes their decisions."""
    if recognition is None:
        return []
    found = recognition
    return [found.risk, found.overtaking, found.head_on, found.crossing, found.from_starboard]


class Recogniser:
    """Recognises encounters by compiled conditions: none, or those of `conditions_of`."""

    def __init__(self, recognition: Recognition | None, decisions: Sequence[Decision]) -> None:
        self._decisions = decisions
        self._same_risk = self._same_geometry = True
        if recognition is not None:
            self._same_risk = _symmetric(recognition.risk)
            self._same_geometry = _symmetric(recognition.head_on) and _symmetric(recognition.crossing)

    def both(self, own: Arguments, swapped: Arguments, geometry: Any = None) -> tuple[Recognised, Recognised]:
        """What is recognised as written, and with the ships swapped; `geometry` may be given.

        What cannot be said because a fact is not known is `Missing`.
        """
        if not self._decisions:
            return _NOTHING, _NOTHING
        risk, overtaking, _, _, from_starboard = self._decisions
        geometries = self._geometries(own, swapped, geometry)
        risks = [_asked("risk_of_collision", lambda: risk(*own))]
        risks.append(risks[0] if self._same_risk else _asked("risk_of_collision", lambda: risk(*swapped)))
        overtakers: Any = ("none", "none")
        if not isinstance(geometries[0], str) or geometries[0] == "overtaking":
            overtakers = _asked("overtaker", lambda: _named(overtaking(*own), overtaking(*swapped)))
        starboard = _asked(
            "has_other_on_starboard", lambda: _named(from_starboard(*own), from_starboard(*swapped))
        )
        here, there = ((risks[n], geometries[n], _side(overtakers, n), _side(starboard, n)) for n in (0, 1))
        return here, there

    def _geometries(self, own: Arguments, swapped: Arguments, given: Any) -> tuple[Any, Any]:
        if given is not None:
            return given, given
        _, overtaking, head_on, crossing, _ = self._decisions

        def seen(by: Arguments) -> str:
            if overtaking(*own) or overtaking(*swapped):
                return "overtaking"
            return "head_on" if head_on(*by) else "crossing" if crossing(*by) else "none"

        one = _asked("geometry", lambda: seen(own))
        return one, one if self._same_geometry else _asked("geometry", lambda: seen(swapped))


def _symmetric(formula: Formula) -> bool:
    return alike(mirrored(formula), formula)


def _named(first: bool, second: bool) -> tuple[str, str]:  # noqa: FBT001
    """Which ship it is, as the one sees it and as the other does."""
    there = "own" if second else "other" if first else "none"
    return ("own" if first else "other" if second else "none"), there


def _side(found: Any, n: int) -> Any:
    return found[n] if isinstance(found, tuple) else found


def _asked(name: str, decide: Callable[[], Any]) -> Any:
    try:
        return decide()
    except UnknownFact:
        return Missing("pair", name)
