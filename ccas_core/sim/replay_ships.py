"""Ships of a replay: their rows, how near they came to one another, and both as numbers for a page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import shapely

from ..errors import Diagnostic, InputError
from ..frames import FloatArray
from ..ships import Ship, ShipId
from .chart import style
from .hulls import STEP, Track, hulls
from .run_folder import FRAMES, SCENARIO
from .run_reading import Row
from .scenario import Scenario

MOST_ROWS: Final = 100_000  # of ships at instants, that a page can show
FEW: Final = 12  # ships of which all pairs are looked at
PARTS: Final = 4  # of a period, for each of which the least clearance is told
DECIMETRES: Final = 10.0
_MILLIRADIANS: Final = 1000.0
_CENTIMETRES: Final = 100.0
_PERCENT: Final = 100.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sailed:
    """A ship of a run: its rows follow one another from frame `first` on."""

    ship: Ship
    speed: float  # nominal [m/s]
    colour: str
    first: int
    rows: tuple[Row, ...]

    @property
    def track(self) -> Track:
        """Where it was, north and east."""
        poses = np.array([[row.north, row.east, row.course] for row in self.rows])
        return Track(ship=self.ship, times=np.array([row.time for row in self.rows]), poses=poses)


def frame_times(rows: Sequence[Row], folder: Path) -> list[float]:
    """Instants of all frames [s]; refuses rows that cannot be shown."""
    if not rows:
        raise refusal(folder / FRAMES, message="no ship has sailed", hint="sail the scenario again")
    if len(rows) > MOST_ROWS:
        raise refusal(
            folder / FRAMES,
            message=f"{len(rows)} rows are more than a page can show",
            expected=f"at most {MOST_ROWS}",
            hint="sail fewer ships, or a shorter voyage",
        )
    for line, row in enumerate(rows, start=2):
        if not np.all(np.isfinite([row.time, row.east, row.north, row.course, row.speed, row.offset])):
            raise refusal(folder / FRAMES, line, message="a number is not finite")
    return sorted({row.time for row in rows})


def sailed_ships(
    scenario: Scenario, rows: Sequence[Row], times: Sequence[float], folder: Path
) -> list[Sailed]:
    """Ships that sailed, in the order of the scenario."""
    index = {time: number for number, time in enumerate(times)}
    known = {plan.ship.id for plan in scenario.ships}
    found: dict[ShipId, list[Row]] = {}
    for line, row in enumerate(rows, start=2):
        if row.ship not in known:
            what = f"ship {row.ship!r} is not one of {SCENARIO}"
            raise refusal(folder / FRAMES, line, message=what, hint="are these files of one run?")
        own = found.setdefault(row.ship, [])
        if own and index[row.time] != index[own[-1].time] + 1:
            raise refusal(
                folder / FRAMES,
                line,
                message=f"ship {row.ship!r} was at {own[-1].time:g} s and is at {row.time:g} s",
                expected="one row in each period",
            )
        own.append(row)
    return [
        Sailed(
            ship=plan.ship,
            speed=plan.speed,
            colour=style(number).colour,
            first=index[own[0].time],
            rows=tuple(own),
        )
        for number, plan in enumerate(scenario.ships)
        if (own := found.get(plan.ship.id, []))
    ]


def told_ship(sailed: Sailed, clearance: FloatArray, rulesets: Sequence[str]) -> dict[str, Any]:
    """Tell a ship and its voyage in whole numbers; one of `rulesets` is told by its place."""
    rows, hull = sailed.rows, sailed.ship.hull
    under = [rulesets.index(row.ruleset) if row.ruleset else -1 for row in rows]
    return {
        "id": sailed.ship.id,
        "length_m": hull.length,
        "beam_m": hull.beam,
        "safety_length_m": hull.safety_length,
        "safety_beam_m": hull.safety_beam,
        "mass_t": sailed.ship.mass / 1000.0,
        "nominal_mps": sailed.speed,
        "colour": sailed.colour,
        "first": sailed.first,
        "count": len(rows),
        "east_dm": _differences((row.east for row in rows), DECIMETRES),
        "north_dm": _differences((row.north for row in rows), DECIMETRES),
        "course_mrad": _differences((row.course for row in rows), _MILLIRADIANS),
        "speed_cmps": _differences((row.speed for row in rows), _CENTIMETRES),
        "offset_dm": _differences((row.offset for row in rows), DECIMETRES),
        "speed_percent": _differences((row.speed_factor for row in rows), _PERCENT),
        "index_dm": _whole((row.safety_index for row in rows), DECIMETRES),
        "clearance_dm": _whole(clearance[sailed.first * PARTS :][: len(rows) * PARTS].tolist(), DECIMETRES),
        "rulesets": [(under[0], 0), *((now, k) for k, now in enumerate(under) if k and now != under[k - 1])],
    }


def clearances(ships: Sequence[Sailed], times: Sequence[float]) -> dict[ShipId, FloatArray]:
    """Least clearance [m] of every ship to any other, in each part of a period; NaN where it was alone.

    Hulls are followed at steps of at most `STEP`; the last frame has its first part only.
    """
    found = {each.ship.id: np.full(len(times) * PARTS, np.nan) for each in ships}
    tracks = [each.track for each in ships]
    for frame, begin in enumerate(times):
        end = times[frame + 1] if frame + 1 < len(times) else begin
        fine = max(1, int(np.ceil((end - begin) / PARTS / STEP)))
        for step in range(fine * PARTS if end > begin else 1):
            now = begin + (end - begin) * step / (fine * PARTS)
            here = [track for track in tracks if track.times[0] <= now <= track.times[-1]]
            for track, apart in zip(here, _apart(here, now), strict=True):
                own = found[track.ship.id]
                part = frame * PARTS + step // fine
                own[part] = np.fmin(own[part], apart)
    return found


def _apart(tracks: Sequence[Track], now: float) -> FloatArray:
    """Clearance of every ship to the one that is nearest to it [m]."""
    if len(tracks) < 2:
        return np.full(len(tracks), np.nan)
    shapes = np.concatenate([hulls(track.ship, track.at(np.array([now]))) for track in tracks])
    if len(tracks) <= FEW:
        table = shapely.distance(shapes[:, None], shapes)
        np.fill_diagonal(table, np.inf)
        return np.asarray(table.min(axis=1), dtype=np.float64)
    (own, _), apart = shapely.STRtree(shapes).query_nearest(
        shapes, exclusive=True, return_distance=True, all_matches=False
    )
    least = np.full(len(tracks), np.nan)
    least[own] = apart
    return least


def _differences(values: Iterable[float], scale: float) -> list[int]:
    """Whole numbers: the first, then what each adds to the one before.

    >>> _differences([1.0, 1.5, 1.4], 10.0)
    [10, 5, -1]
    """
    whole = [round(value * scale) for value in values]
    return [now - before for before, now in zip([0, *whole], whole, strict=False)]


def _whole(values: Iterable[float | None], scale: float) -> list[int | None]:
    """Whole numbers; null where there is none."""
    return [None if each is None or not np.isfinite(each) else round(each * scale) for each in values]


def refusal(file: Path, line: int = 0, *, message: str, expected: str = "", hint: str = "") -> InputError:
    """Refuse a file of a run, or a line of it."""
    column = 1 if line else 0
    return InputError(
        Diagnostic(source=str(file), line=line, column=column, message=message, expected=expected, hint=hint)
    )
