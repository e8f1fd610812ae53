"""What a ship believes of those that AIS alone tells of."""

from __future__ import annotations

import math

import pytest

from ccas_core.agent.sightings import SILENT_FOR, Sightings
from ccas_core.frames import NedPose
from ccas_core.ships import Hull, Ship, ShipId
from ccas_core.waterway import Towards
from ccas_core.world import ShipReport

A = ShipId("a")
STEP = 20.0  # [s]
AHEAD = NedPose(5000.0, 0.0, 0.0)  # of all that is seen here


def report(x: float, y: float = 0.0, *, course: float = 0.0, speed: float = 3.0) -> ShipReport:
    ship = Ship(id=A, hull=Hull(length=60.0, beam=8.0), mass=1e6)
    return ShipReport(
        ship=ship,
        pose=NedPose(x, y, course),
        speed=speed,
        waterway="canal",
        towards=Towards.END,
        ruleset="bpr",
        cooperates=False,
    )


def look(
    sightings: Sightings, period: int, seen: ShipReport | None, own: NedPose = AHEAD
) -> tuple[ShipReport | None, tuple[str, ...]]:
    found, said = sightings.believed(STEP * period, own, {A: seen} if seen else {})
    return found.get(A), said


def test_report_that_may_be_true_is_believed_and_nothing_is_said() -> None:
    sightings = Sightings()

    for period in range(3):
        seen = report(60.0 * period)
        assert look(sightings, period, seen) == (seen, ())


def test_jump_is_not_believed_until_it_is_told_twice() -> None:
    sightings = Sightings()
    look(sightings, 0, report(0.0))

    first, said = look(sightings, 1, report(60.0, 900.0))
    second, said_again = look(sightings, 2, report(120.0, 900.0))

    assert first is not None
    assert first.pose == NedPose(60.0, 0.0, 0.0)
    assert said == ("a has jumped by 900 m",)
    assert second is not None
    assert second.pose.y == 900.0
    assert said_again == ("a is believed where it has jumped to",)


def test_ship_that_reports_no_position_is_carried_on() -> None:
    sightings = Sightings()
    look(sightings, 0, report(0.0))

    found, said = look(sightings, 1, report(math.nan, math.nan))

    assert found is not None
    assert found.pose.x == pytest.approx(60.0)
    assert said == ("a reports no position",)


def test_ship_that_never_reported_a_position_is_nowhere() -> None:
    assert look(Sightings(), 0, report(math.nan, math.nan)) == (None, ("a reports no position",))


@pytest.mark.parametrize(
    ("speed", "said"), [(math.nan, "no speed"), (-2.0, "-2 m/s"), (400.0, "400 m/s"), (math.inf, "inf m/s")]
)
def test_speed_that_cannot_be_is_made_good_from_positions(speed: float, said: str) -> None:
    sightings = Sightings()
    look(sightings, 0, report(0.0))

    found, told = look(sightings, 1, report(50.0, speed=speed))

    assert found is not None
    assert found.speed == pytest.approx(2.5)
    assert told == (f"a reports {said}",)


def test_course_that_is_not_known_is_made_good_from_positions() -> None:
    sightings = Sightings()
    look(sightings, 0, report(0.0))

    found, told = look(sightings, 1, report(40.0, 40.0, course=math.nan))

    assert found is not None
    assert found.pose.course == pytest.approx(math.pi / 4.0)
    assert told == ("a reports no course",)


def test_ship_that_disappears_is_carried_on_and_then_forgotten() -> None:
    sightings = Sightings()
    look(sightings, 0, report(0.0))

    found, said = look(sightings, 3, None)
    late, forgotten = look(sightings, math.ceil(SILENT_FOR / STEP) + 1, None)

    assert found is not None
    assert found.pose.x == pytest.approx(180.0)
    assert said == ("a has been silent for 60 s",)
    assert (late, forgotten) == (None, ("a is forgotten",))
    assert look(sightings, 99, None) == (None, ())


def test_ship_that_falls_silent_behind_is_not_missed() -> None:
    sightings = Sightings()
    astern = NedPose(-900.0, 0.0, 0.0)
    look(sightings, 0, report(0.0), astern)

    assert look(sightings, 1, None, astern) == (None, ())
