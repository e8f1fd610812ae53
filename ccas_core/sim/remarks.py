"""What ships had to say on a voyage: wrong reports of others, and plans that do not do what they should.

What a ship says again and again is told once, with the first and the last time.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from ..ships import ShipId
from .frame import Frame, ShipFrame
from .hulls import under_way


@dataclass(frozen=True, slots=True, kw_only=True)
class Remark:
    """A ship's word, and how often it was said."""

    ship: ShipId
    text: str  # as it was said first
    first: float  # [s]
    last: float  # [s]
    count: int = 1


def remarks(frames: Sequence[Frame]) -> tuple[Remark, ...]:
    """All that ships said, in the order in which it was first said; numbers do not tell two words apart."""
    found: dict[tuple[ShipId, str], Remark] = {}
    for frame in frames:
        for id_, ship in under_way(frame).items():
            for text in _said(ship):
                key = id_, re.sub(r"[-\d.]+", "#", text)
                before = found.get(
                    key, Remark(ship=id_, text=text, first=frame.time, last=frame.time, count=0)
                )
                found[key] = replace(before, last=frame.time, count=before.count + 1)
    return tuple(found.values())


def _said(ship: ShipFrame) -> Iterator[str]:
    yield from ship.saw
    if ship.motion is not None:  # of cooperative ships, outcomes are told with their fall-backs
        yield from filter(None, (ship.outcome, ship.fallback))


def remark_entry(remark: Remark) -> dict[str, object]:
    """Tell a remark as an entry of `summary.json`."""
    return {
        "ship": remark.ship,
        "text": remark.text,
        "first_s": remark.first,
        "last_s": remark.last,
        "count": remark.count,
    }
