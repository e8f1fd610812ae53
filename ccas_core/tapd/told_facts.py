"""Facts that a verdict tells: those that its rule looked at, from own ship's side, in the units of files."""

from __future__ import annotations

from typing import Any, Final

from ..ships import FactValue
from ..units import DEGREE
from .facts import PairFacts, plain
from .language.formula import SHIP_VALUES, Measure, Named, facts_of, walk
from .rules import Rule
from .vocabulary import MOTIONS, Scope, Vocabulary

_SUFFIX: Final = {"m": "_m", "s": "_s", "m/s": "_mps", "deg": "_deg"}
_IN_DEGREES: Final = frozenset({"bearing", "abs", "course_difference"})
_OWN, _OTHER, _WATERWAY, _PAIR = range(4)


class ToldFacts:
    """Which facts a rule looks at, found once; `swapped` says that it applies with the ships swapped."""

    def __init__(self, rule: Rule, vocabulary: Vocabulary, *, swapped: bool) -> None:
        def seen(name: str) -> str:
            return _seen(name) if swapped else name

        measured: dict[tuple[str, ...], None] = {}
        for part in walk(rule.condition):
            if isinstance(part, Named) and isinstance(part.measure, Measure):
                for each in (part.measure.quantity, part.measure.limit):
                    if isinstance(each, tuple):
                        measured[each] = None
        where = [(name, *map(seen, ships)) for name, *ships in measured]
        self._quantities = tuple((label(each), each, each[0] in _IN_DEGREES) for each in where)
        places = [(seen(name), _place(seen(name), vocabulary)) for name in sorted(facts_of(rule.condition))]
        self._places = tuple((name, *place) for name, place in places if place is not None)

    def of(self, facts: PairFacts) -> dict[str, FactValue]:
        """Values of these facts."""
        found: dict[str, FactValue] = {}
        for name, measured, in_degrees in self._quantities:
            value = facts.quantity(measured)
            found[name] = round(value / DEGREE if in_degrees else value, 6)
        tuples = facts.own_values, facts.other_values, facts.waterway_values, facts.pair_values
        for name, which, place in self._places:
            found[name] = _told(tuples[which][place], facts)
        return found


def _told(value: Any, facts: PairFacts) -> FactValue:
    if isinstance(value, str):
        return facts.own if value == "own" else facts.other if value == "other" else value
    if isinstance(value, frozenset):
        return " ".join(sorted(value))
    found: FactValue = plain(value)
    return found


def _seen(name: str) -> str:
    head, dot, tail = name.partition(".")
    return f"{SHIP_VALUES.get(head, head)}{dot}{tail}"


def _place(name: str, vocabulary: Vocabulary) -> tuple[int, int] | None:
    """Which values hold a fact, and where among them; None for variables of motion and parameters."""
    head, _, tail = name.partition(".")
    which = {"own": _OWN, "other": _OTHER, "waterway": _WATERWAY}.get(head, _PAIR) if tail else _PAIR
    scope = (Scope.SHIP, Scope.SHIP, Scope.WATERWAY, Scope.PAIR)[which]
    place = vocabulary.places[scope].get(tail if which != _PAIR else name)
    return None if place is None else (which, place)


def label(measured: tuple[str, ...]) -> str:
    """Name of a quantity of motion with its unit.

    >>> label(("bearing", "own", "other")), label(("speed", "own"))
    ('bearing(own, other)_deg', 'own.speed_mps')
    """
    name, *ships = measured
    quantity = "bearing" if name == "abs" else name
    suffix = _SUFFIX[MOTIONS[quantity][0].unit]
    if len(ships) == 2:
        return f"{quantity}({', '.join(ships)}){suffix}"
    return f"{ships[0]}.{name}{suffix}" if ships else f"{name}{suffix}"
