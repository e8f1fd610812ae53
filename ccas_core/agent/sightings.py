"""What a ship believes of those that it knows by AIS alone: reports may be wrong, late, or cease.

A report that cannot be true is replaced by the last that could be, carried on at its course and speed; what
was wrong is said.  A ship that is somewhere else than it can be is believed when it says so twice.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Final

from ..frames import NedPose
from ..ships import ShipId
from ..world import ShipReport

FASTEST: Final = 25.0  # no ship is believed to be faster [m/s]
SLACK: Final = 10.0  # by which a speed may have been wrong, or changed, since the last report [m/s]
SILENT_FOR: Final = 200.0  # after so long a ship that has fallen silent is forgotten [s]


@dataclass(frozen=True, slots=True)
class _Known:
    report: ShipReport
    time: float  # when it was true [s]
    away: float  # distance from the own ship, then [m]


class Sightings:
    """Memory of one ship for reports of ships that do not cooperate."""

    def __init__(self) -> None:
        self._known: dict[ShipId, _Known] = {}
        self._odd: dict[ShipId, _Known] = {}  # somewhere else than it can be
        self._own = 0.0, 0.0  # where the own ship is, north and east [m]

    def believed(
        self, now: float, own: NedPose, reports: Mapping[ShipId, ShipReport]
    ) -> tuple[dict[ShipId, ShipReport], tuple[str, ...]]:
        """Reports as they are believed at a time [s], and what was found wrong with them.

        Reports of ships that cooperate are taken as they are.  A ship that has gone out of sight behind `own`
        is not missed.
        """
        self._own = own.x, own.y
        found = {id_: report for id_, report in reports.items() if report.cooperates}
        said: list[str] = []
        for id_ in sorted(self._known.keys() | (reports.keys() - found.keys())):
            if id_ in found:
                continue
            report, wrong = self._seen(now, id_, reports.get(id_))
            said += [f"{id_} {each}" for each in wrong]
            if report is not None:
                found[id_] = report
        return found, tuple(said)

    def _seen(
        self, now: float, id_: ShipId, report: ShipReport | None
    ) -> tuple[ShipReport | None, list[str]]:
        known = self._known.get(id_)
        if report is None:
            return self._silent(now, id_, known)
        if not _is_finite(report.pose.x, report.pose.y):
            return self._reckoned(now, known), ["reports no position"]
        wrong = []
        if not _is_finite(report.pose.course):
            wrong.append("reports no course")
            report = replace(report, pose=replace(report.pose, course=_course(known, report)))
        if not 0.0 <= report.speed <= FASTEST:  # not a number is neither
            wrong.append("reports no speed" if math.isnan(report.speed) else f"reports {report.speed:g} m/s")
            report = replace(report, speed=_speed(known, report, now))
        if known is not None and not _may_be(known, report, now):
            odd = self._odd.get(id_)
            self._odd[id_] = self._noted(report, now)
            if odd is None or not _may_be(odd, report, now):
                away = math.dist(_place(self._reckoned(now, known) or report), _place(report))
                return self._reckoned(now, known), [*wrong, f"has jumped by {away:.0f} m"]
            wrong.append("is believed where it has jumped to")
        self._odd.pop(id_, None)
        self._known[id_] = self._noted(report, now)
        return report, wrong

    def _noted(self, report: ShipReport, now: float) -> _Known:
        return _Known(report, now, math.dist(self._own, _place(report)))

    def _silent(self, now: float, id_: ShipId, known: _Known | None) -> tuple[ShipReport | None, list[str]]:
        reckoned = self._reckoned(now, known)
        if known is None or reckoned is None:
            return None, []
        gone = math.dist(self._own, _place(reckoned)) > known.away
        if gone or now - known.time > SILENT_FOR:
            del self._known[id_]
            self._odd.pop(id_, None)
            return None, [] if gone else ["is forgotten"]
        return reckoned, [f"has been silent for {now - known.time:.0f} s"]

    @staticmethod
    def _reckoned(now: float, known: _Known | None) -> ShipReport | None:
        """Carry the last report that was believed on; None where there never was one."""
        if known is None:
            return None
        pose, sailed = known.report.pose, known.report.speed * (now - known.time)
        north, east = pose.x + sailed * math.cos(pose.course), pose.y + sailed * math.sin(pose.course)
        return replace(known.report, pose=NedPose(north, east, pose.course))


def _is_finite(*values: float) -> bool:
    return all(map(math.isfinite, values))


def _place(report: ShipReport) -> tuple[float, float]:
    return report.pose.x, report.pose.y


def _may_be(known: _Known, report: ShipReport, now: float) -> bool:
    """Whether a ship can be where it says, given where it was."""
    passed = now - known.time
    reckoned = Sightings._reckoned(now, known) or report  # noqa: SLF001 - its own
    slack = SLACK * passed + known.report.ship.hull.length
    return math.dist(_place(reckoned), _place(report)) <= slack


def _course(known: _Known | None, report: ShipReport) -> float:
    """Course over ground since the last report [rad]; without one, that of a ship that lies still: north."""
    if known is None:
        return 0.0
    north, east = (there - here for here, there in zip(_place(known.report), _place(report), strict=True))
    return math.atan2(east, north) if math.hypot(north, east) > 1.0 else known.report.pose.course


def _speed(known: _Known | None, report: ShipReport, now: float) -> float:
    """Speed made good since the last report [m/s]; without one, none."""
    if known is None or now <= known.time:
        return 0.0
    return min(math.dist(_place(known.report), _place(report)) / (now - known.time), FASTEST)


def silent(reports: Iterable[ShipReport]) -> frozenset[ShipId]:
    """Ships that do not cooperate: nobody waits for their word."""
    return frozenset(report.id for report in reports if not report.cooperates)
