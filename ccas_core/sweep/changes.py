"""Changes of mind: how often a ship goes back on what it does, a measure of oscillation.

A command counts as one of three, for course and for speed: to starboard, to port, neither; slower or not.
A change of mind is a turn from one side to the other, or a reduction of speed taken up again after
it was given up, without the ship having been on its line at full speed for `REST` periods in between.
A ship is *restless* if it changes its mind more than `MOST` times for each encounter that it has.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Final

from ..sim.conduct import ACTING_FACTOR, ACTING_OFFSET
from ..sim.frame import Frame
from ..sim.hulls import states, under_way

REST: Final = 5  # periods after which an action is a new one
MOST: Final = 2  # changes of mind that an encounter allows a ship


def changes_of_mind(frames: Sequence[Frame]) -> dict[str, int]:
    """Changes of mind of every ship."""
    ids = sorted({id_ for frame in frames for id_ in under_way(frame)})
    found = {}
    for id_ in ids:
        sailed = list(states(frames, id_))
        sides = [_side(ship.offset) for ship in sailed]
        slow = [int(ship.speed_factor < ACTING_FACTOR) for ship in sailed]
        found[str(id_)] = _turned(sides) + _resumed(slow)
    return found


def restless(changes: Mapping[str, int], met: Sequence[Sequence[str]]) -> list[str]:
    """Ships that change their mind too often; `met` holds the ships of each encounter.

    >>> restless({"a": 3, "b": 3, "c": 1}, [("a", "b"), ("b", "c")])
    ['a']
    """
    encounters = Counter(ship for ships in met for ship in ships)
    return [ship for ship, count in changes.items() if count > MOST * max(1, encounters[ship])]


def actions(frames: Sequence[Frame]) -> dict[str, int]:
    """How often every ship begins to act."""
    ids = sorted({id_ for frame in frames for id_ in under_way(frame)})
    found = {}
    for id_ in ids:
        acts = [bool(_side(ship.offset)) or ship.speed_factor < ACTING_FACTOR for ship in states(frames, id_)]
        found[str(id_)] = sum(now and not before for before, now in pairwise([False, *acts]))
    return found


def _side(offset: float) -> int:
    return 0 if abs(offset) <= ACTING_OFFSET else (1 if offset > 0.0 else -1)


def _turned(sides: Sequence[int]) -> int:
    """Count turns from one side to the other within `REST` periods.

    >>> _turned([0, 1, 1, 0, -1, 0, 0, 0, 0, 0, 0, 1])
    1
    """
    acts = [(k, side) for k, side in enumerate(sides) if side]
    return sum(a != b and k - j <= REST for (j, a), (k, b) in pairwise(acts))


def _resumed(slow: Sequence[int]) -> int:
    """Count reductions of speed that follow another within `REST` periods.

    >>> _resumed([0, 1, 1, 0, 1, 0, 0, 0, 0, 0, 0, 1])
    1
    """
    acts = [k for k, each in enumerate(slow) if each]
    return sum(1 < k - j <= REST for j, k in pairwise(acts))
