"""The track of a ship that is known by AIS alone: given in a scenario, or recorded in a table (CSV).

A row says what AIS told from then on, and may be wrong, as AIS is: without position, course or speed, or with
what cannot be.  The ship itself sails straight between rows that have a position; after the last it is gone.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ..frames import FloatArray, NedPose, frozen_array

COLUMNS: Final = ("time_s", "east_m", "north_m")  # that a recorded track must have
MORE: Final = ("course_rad", "speed_mps")  # that it may have
MADE_GOOD: Final = math.inf  # as a course or a speed: that of the way to the next position


@dataclass(frozen=True, slots=True, eq=False)
class GivenTrack:
    """Rows (K, 5): time [s], north, east [m], course [rad], speed [m/s]; not a number was not told.

    >>> track = GivenTrack(np.array([[0.0, 0.0, 0.0, MADE_GOOD, 9.0], [10.0, 0.0, 50.0, MADE_GOOD, 9.0]]))
    >>> track.sailed(4.0)[0].y, track.reported(4.0)[1]  # it sails 5 m/s, and reports 9 m/s
    (20.0, 9.0)
    """

    rows: FloatArray
    _sailed: FloatArray = field(init=False, repr=False)  # rows with a position; course and speed made good

    def __post_init__(self) -> None:
        rows = np.array(self.rows, dtype=np.float64)
        if rows.ndim != 2 or rows.shape[1] != 5 or not np.all(np.diff(rows[:, 0]) > 0.0):
            raise ValueError("a track is (K, 5) with times that rise")
        lost = np.isnan(rows[:, 1:3].sum(axis=1))
        rows[lost, 1:] = math.nan
        if np.count_nonzero(~lost) < 2:
            raise ValueError("a track needs two rows with a position")
        sailed = _made_good(rows[~lost])
        ahead = np.full_like(rows, math.nan)
        ahead[~lost] = sailed
        rows = np.where(np.isinf(rows), ahead, rows)
        object.__setattr__(self, "rows", frozen_array(rows))
        object.__setattr__(self, "_sailed", frozen_array(sailed))

    @property
    def end(self) -> float:
        """Time of the last row [s]."""
        return float(self.rows[-1, 0])

    def sailed(self, time: float) -> tuple[NedPose, float]:
        """Where the ship is at a time [s], on the way that it makes, and how fast it goes there [m/s]."""
        table = self._sailed
        row = int(np.clip(np.searchsorted(table[:, 0], time, side="left") - 1, 0, len(table) - 2))
        share = (time - table[row, 0]) / (table[row + 1, 0] - table[row, 0])
        share = min(max(share, 0.0), 1.0)
        north, east = table[row, 1:3] + share * (table[row + 1, 1:3] - table[row, 1:3])
        return NedPose(float(north), float(east), float(table[row, 3])), float(table[row, 4])

    def reported(self, time: float) -> tuple[NedPose, float]:
        """What the ship reports at a time [s]: where it is, with course and speed of the row in force."""
        row = self.rows[max(int(np.searchsorted(self.rows[:, 0], time, side="right")) - 1, 0)]
        if math.isnan(float(row[1])):
            return NedPose(math.nan, math.nan, math.nan), math.nan
        pose, _ = self.sailed(time)
        return NedPose(pose.x, pose.y, float(row[3])), float(row[4])


def _made_good(known: FloatArray) -> FloatArray:
    """Rows with the course and the speed of the way to the next row; the last one's are those before it."""
    found = known.copy()
    way = np.diff(known[:, 1:3], axis=0)
    found[:-1, 3] = np.arctan2(way[:, 1], way[:, 0])
    found[:-1, 4] = np.hypot(way[:, 0], way[:, 1]) / np.diff(known[:, 0])
    for row in np.flatnonzero(
        ~way.any(axis=1)
    ).tolist():  # a ship that lies still keeps the course that it had
        found[row, 3] = found[max(row - 1, 0), 3] if row else 0.0
    found[-1, 3:] = found[-2, 3:]
    return np.asarray(found)


def recorded(lines: Iterable[str], ship: str = "") -> GivenTrack:
    """Read a table with the columns `COLUMNS`, and `MORE` where it has them, as `frames.csv` of a run has.

    An empty field, or one that is not a number, is not known.  With `ship` only its rows count.

    Raises
    ------
    ValueError
        If a column is missing, or the rows make no track.
    """
    table = csv.DictReader(lines)
    columns = table.fieldnames or ()
    missing = [name for name in (*COLUMNS, *(["ship"] if ship else [])) if name not in columns]
    if missing:
        raise ValueError(f"the column '{missing[0]}' is missing")
    rows = [row for row in table if not ship or row["ship"] == ship]
    if not rows:
        raise ValueError(f"no row of ship {ship!r}" if ship else "no rows")
    names = ("time_s", "north_m", "east_m", *MORE)
    found = np.array([[_number(row, name) for name in names] for row in rows])
    if not np.isfinite(found[:, 0]).all():
        raise ValueError("a row has no time")
    found[:, [name not in columns for name in names]] = MADE_GOOD
    return GivenTrack(found)


def _number(row: Mapping[str, str | None], name: str) -> float:
    try:
        value = float(row.get(name) or "nan")
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan
