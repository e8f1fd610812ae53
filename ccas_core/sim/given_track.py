"""The track of a ship that is known by AIS alone: given in a scenario, or recorded in a table (CSV).

Rows may be wrong, as what AIS tells is: a row without position, course or speed is reported so.  The ship
itself sails straight between the rows that have a position; after the last row it is gone.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np

from ..frames import FloatArray, NedPose, frozen_array

COLUMNS: Final = ("time_s", "east_m", "north_m")  # that a recorded track must have
MORE: Final = ("course_rad", "speed_mps")  # that it may have


@dataclass(frozen=True, slots=True, eq=False)
class GivenTrack:
    """Rows (K, 5): time [s], north, east [m], course [rad], speed [m/s]; not a number is not known."""

    rows: FloatArray
    _sailed: FloatArray = field(init=False, repr=False)  # rows with a position; course and speed made good

    def __post_init__(self) -> None:
        rows = frozen_array(self.rows)
        if rows.ndim != 2 or rows.shape[1] != 5 or not np.all(np.diff(rows[:, 0]) > 0.0):
            raise ValueError("a track is (K, 5) with times that rise")
        lost = np.isnan(rows[:, 1:3].sum(axis=1))
        rows = frozen_array(np.where(lost[:, None] & (np.arange(5) > 0), math.nan, rows))
        known = rows[~lost]
        if len(known) < 2:
            raise ValueError("a track needs two rows with a position")
        sailed = known.copy()
        for number, (here, there) in enumerate(pairwise(known), start=1):
            north, east = there[1:3] - here[1:3]
            moved = math.hypot(north, east)
            sailed[number, 3] = math.atan2(east, north) if moved > 0.0 else sailed[number - 1, 3]
            sailed[number, 4] = moved / (there[0] - here[0])
        sailed[0, 3:] = sailed[1, 3:]
        if not math.isfinite(sailed[0, 3]):
            sailed[:, 3] = np.nan_to_num(sailed[:, 3])
        object.__setattr__(self, "rows", rows)
        object.__setattr__(self, "_sailed", frozen_array(sailed))

    @property
    def end(self) -> float:
        """Time of the last row [s]."""
        return float(self.rows[-1, 0])

    def sailed(self, time: float) -> tuple[NedPose, float]:
        """Where the ship is at a time [s], on the way that it has come, and how fast it goes there [m/s]."""
        table = self._sailed
        row = int(np.clip(np.searchsorted(table[:, 0], time, side="left"), 1, len(table) - 1))
        share = (time - table[row - 1, 0]) / (table[row, 0] - table[row - 1, 0])
        share = min(max(share, 0.0), 1.0)
        north, east = table[row - 1, 1:3] + share * (table[row, 1:3] - table[row - 1, 1:3])
        return NedPose(float(north), float(east), float(table[row, 3])), float(table[row, 4])

    def reported(self, time: float) -> tuple[NedPose, float]:
        """What the ship reports at a time [s]: where it is, or what the row in force says amiss."""
        pose, speed = self.sailed(time)
        row = self.rows[max(int(np.searchsorted(self.rows[:, 0], time, side="right")) - 1, 0)]
        if not np.isfinite(row[1:3]).all():
            return NedPose(math.nan, math.nan, math.nan), math.nan
        stated = NedPose(pose.x, pose.y, pose.course if math.isfinite(row[3]) else math.nan)
        return stated, speed if math.isfinite(row[4]) else math.nan


def recorded(lines: Iterable[str], ship: str = "") -> GivenTrack:
    """Read a table with the columns `COLUMNS`, and `MORE` where it has them, as `frames.csv` of a run has.

    An empty field, or one that is not a number, is not known.  With `ship` only its rows count.

    Raises
    ------
    ValueError
        If a column is missing, or the rows make no track.
    """
    table = csv.DictReader(lines)
    missing = [name for name in COLUMNS if name not in (table.fieldnames or ())]
    if missing:
        raise ValueError(f"the column '{missing[0]}' is missing")
    if ship and "ship" not in (table.fieldnames or ()):
        raise ValueError("the column 'ship' is missing")
    rows = [row for row in table if not ship or row["ship"] == ship]
    if not rows:
        raise ValueError(f"no row of ship {ship!r}" if ship else "no rows")
    stated = [name in (table.fieldnames or ()) for name in MORE]
    found = [[_number(row, name) for name in ("time_s", "north_m", "east_m", *MORE)] for row in rows]
    array = np.array(found)
    if not np.isfinite(array[:, 0]).all():
        raise ValueError("a row has no time")
    for column, is_stated in zip((3, 4), stated, strict=True):
        if not is_stated:
            array[:, column] = 0.0  # made good: nothing is amiss
    return GivenTrack(array)


def _number(row: Mapping[str, str | None], name: str) -> float:
    try:
        value = float(row.get(name) or "nan")
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan
