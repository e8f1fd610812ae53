"""Memory of an encounter: it lasts until past and clear, and is the same on both ships."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ccas_core.roles import Geometry
from ccas_core.ships import UNKNOWN, FactValue, ShipId
from ccas_core.tapd.assign import remembered
from ccas_core.tapd.encounters import NO_ENCOUNTER, Encounter, remember
from ccas_core.units import DEGREE
from ccas_core.verdict import OPPOSITE, Kind, Verdict
from ccas_core.waterway import Towards

from . import (
    CHART,
    A,
    B,
    Meeting,
    crossing,
    head_on,
    overtaking,
    random_encounter,
    report,
    ruleset,
    verdict,
    waters,
)

RULES = ruleset("tran2026")
STEP = 20.0  # [s]


def judged(meeting: Meeting, memory: Encounter = NO_ENCOUNTER) -> Verdict:
    return RULES.judge(meeting.facts(memory))


def carried_on(meeting: Meeting, memory: Encounter = NO_ENCOUNTER) -> Encounter:
    """Memory after this period, as the own ship has it."""
    _, encounter = remembered(meeting.situation(memory), judged(meeting, memory))
    return encounter


def sides(memory: Encounter) -> dict[ShipId, FactValue]:
    """Whether each ship follows the starboard side, as it is remembered."""
    return {ship: held["follows_starboard_side"] for ship, held in memory.held.items()}


def sailed(meeting: Meeting, periods: int) -> list[tuple[Verdict, Encounter]]:
    """Let both go straight on; give the verdict and the memory of each period."""
    memory, log = NO_ENCOUNTER, []
    for period in range(periods):
        now = meeting.later(period * STEP)
        seen = judged(now, memory)
        memory = carried_on(now, memory)
        log.append((seen, memory))
    return log


# --- beginning ------------------------------------------------------------------------------------


def test_ships_that_do_not_meet_remember_nothing() -> None:
    apart = Meeting(CHART, report(A, 500.0, 0.0, 0.0), report(B, -500.0, 0.0, 180.0))

    assert carried_on(apart) is NO_ENCOUNTER


@pytest.mark.parametrize(
    ("meeting", "geometry", "overtaker"),
    [
        (head_on(), Geometry.HEAD_ON, None),
        (crossing(), Geometry.CROSSING, None),
        (overtaking(), Geometry.OVERTAKING, A),
        (overtaking().swapped(), Geometry.OVERTAKING, A),
    ],
)
def test_encounter_begins_with_its_geometry_and_its_overtaker(
    meeting: Meeting, geometry: Geometry, overtaker: ShipId | None
) -> None:
    memory = carried_on(meeting)

    assert (memory.geometry, memory.overtaker, memory.opening_periods) == (geometry, overtaker, 0)
    assert sides(memory) == {A: False, B: False}


# --- lasting --------------------------------------------------------------------------------------


def test_overtaking_lasts_though_the_bearing_changes() -> None:
    memory = carried_on(overtaking())
    abeam = Meeting(CHART, report(A, -370.0, -60.0, 0.0, speed=5.0), report(B, -400.0, 0.0, 0.0))

    assert abs(abeam.facts().quantity(("bearing", "other", "own"))) < 112.5 * DEGREE
    assert judged(abeam).kind is Kind.NONE  # without memory it would be over
    assert judged(abeam, memory).kind is Kind.GIVE_WAY
    assert judged(abeam.swapped(), memory).kind is Kind.STAND_ON
    assert carried_on(abeam, memory).geometry is Geometry.OVERTAKING


def test_overtaken_ship_does_not_become_the_give_way_ship_when_its_overtaker_slows_down() -> None:
    memory = carried_on(overtaking())
    slower = Meeting(CHART, report(A, -350.0, -60.0, 0.0, speed=1.0), report(B, -400.0, 0.0, 0.0))

    assert judged(slower).kind is not Kind.GIVE_WAY
    assert judged(slower, memory).kind is Kind.GIVE_WAY


def test_overtaking_ends_when_past_and_clear() -> None:
    log = sailed(overtaking(), 40)
    kinds = [seen.kind for seen, _ in log]
    over = kinds.index(Kind.NONE)
    end = overtaking().later(over * STEP)

    assert set(kinds[:over]) == {Kind.GIVE_WAY}
    assert set(kinds[over:]) == {Kind.NONE}
    assert end.own.pose.x - end.other.pose.x > 100.0  # ahead by more than the two half lengths
    assert abs(end.facts().quantity(("bearing", "own", "other"))) > 90.0 * DEGREE


def test_overtaker_that_is_not_yet_past_still_overtakes_though_the_range_grew() -> None:
    memory = replace(carried_on(overtaking()), distance=100.0, opening_periods=5)
    behind = overtaking()

    assert behind.facts(memory)["tcpa"] > 0.0
    assert carried_on(behind, memory).geometry is Geometry.OVERTAKING


def test_starboard_side_is_held_during_the_encounter() -> None:
    own, other = report(A, -1000.0, 20.0, 0.0), report(B, 1000.0, 0.0, 180.0, towards=Towards.START)
    memory = carried_on(Meeting(CHART, own, other))
    aside = Meeting(CHART, replace(own, pose=replace(own.pose, y=-30.0)), other)

    assert judged(aside).kind is Kind.MUTUAL  # it left its side
    assert judged(aside, memory).kind is Kind.STAND_ON
    assert sides(carried_on(aside, memory)) == {A: True, B: False}


def test_ship_does_not_earn_the_right_to_stand_on_by_giving_way_to_starboard() -> None:
    own = report(A, -1000.0, 0.0, 0.0)
    other = report(B, 1000.0, -20.0, 180.0, towards=Towards.START)
    memory = carried_on(Meeting(CHART, own, other))
    given_way = Meeting(CHART, replace(own, pose=replace(own.pose, y=40.0)), other)

    assert judged(given_way, memory).kind is Kind.GIVE_WAY


def test_side_that_becomes_known_during_the_encounter_counts() -> None:
    unknown = head_on(UNKNOWN, False)

    assert judged(head_on(True, False), carried_on(unknown)).kind is Kind.STAND_ON


def test_duty_of_a_crossing_does_not_change_hands_when_a_ship_turns() -> None:
    chart = waters(angle=25.0)
    own = report(A, -1000.0, 0.0, 0.0)
    cos, sin = math.cos(25.0 * DEGREE), math.sin(25.0 * DEGREE)
    meeting = Meeting(chart, own, report(B, -1000.0 * cos, -1000.0 * sin, 25.0, waterway="canal"))
    first, memory = judged(meeting), carried_on(meeting)

    turned = meeting.later(STEP, own_course=30.0)

    assert (first.kind, first.geometry) == (Kind.STAND_ON, Geometry.CROSSING)
    assert judged(turned, memory).kind is first.kind


# --- ending ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("meeting", [head_on(True, False), crossing(), overtaking()])
def test_encounter_ends_after_two_opening_periods(meeting: Meeting) -> None:
    log = sailed(meeting, 60)
    opening = [memory.opening_periods for _, memory in log]
    end = next(n for n, (_, memory) in enumerate(log) if memory is NO_ENCOUNTER)
    ranges = [_range(meeting.later(n * STEP)) for n in range(60)]

    assert opening[end - 1] >= 1
    assert ranges[end] > ranges[end - 1] > ranges[end - 2]
    assert all(memory.geometry is log[0][1].geometry for _, memory in log[:end])
    assert all(memory is NO_ENCOUNTER for _, memory in log[end:])


def test_head_on_encounter_ends_in_the_second_period_in_which_the_range_grows() -> None:
    meeting = head_on(True, False)  # 2000 m apart, closing by 120 m a period: nearest at 333 s
    log = sailed(meeting, 25)

    assert [memory.opening_periods for _, memory in log[17:19]] == [0, 1]
    assert log[18][1].geometry is Geometry.HEAD_ON
    assert log[19][1] is NO_ENCOUNTER


def test_range_that_shrinks_again_starts_the_count_anew() -> None:
    memory = Encounter(geometry=Geometry.HEAD_ON, distance=5000.0, opening_periods=1)

    assert carried_on(head_on(), memory).opening_periods == 0


def test_ships_within_half_their_lengths_are_not_clear() -> None:
    memory = Encounter(geometry=Geometry.HEAD_ON, distance=50.0, opening_periods=5)
    near = Meeting(CHART, report(A, 0.0, 0.0, 0.0), report(B, 0.0, 60.0, 180.0))

    assert carried_on(near, memory).geometry is Geometry.HEAD_ON


# --- the same on both ships -----------------------------------------------------------------------


def test_both_ships_remember_the_same() -> None:
    for seed in range(300):
        meeting = random_encounter(np.random.default_rng(seed), flags=False)
        memory = carried_on(meeting)
        then = meeting.later(STEP)

        assert carried_on(meeting.swapped()) == memory
        assert carried_on(then.swapped(), memory) == carried_on(then, memory)


@pytest.mark.parametrize("kind", [Kind.GIVE_WAY, Kind.STAND_ON])
def test_both_ships_remember_the_same_overtaker_where_one_has_the_duty(kind: Kind) -> None:
    assert len(_overtakers(kind)) == 1


@pytest.mark.parametrize(
    "kind",
    [
        Kind.PROHIBITED,
        Kind.COOPERATE,
        Kind.NEGOTIATE,
        Kind.MUTUAL,
        Kind.CONFLICT,
        Kind.GAP,
        Kind.UNKNOWN_FACT,
    ],
)
def test_both_ships_remember_the_same_overtaker_whatever_the_verdict(kind: Kind) -> None:
    assert _overtakers(kind) == {A}


def test_overtaker_is_the_ship_that_comes_up_though_the_other_gives_way() -> None:
    assert _overtakers(Kind.STAND_ON) == {A}


def test_overtaker_is_remembered_by_what_the_verdicts_say_and_by_nothing_else() -> None:
    """A ruleset says who overtakes; one that does not leaves both ships with the same memory all the same."""
    assert _overtakers(Kind.GIVE_WAY, None) == {None}


def test_ruleset_tells_both_ships_of_the_same_overtaker() -> None:
    assert judged(overtaking()).overtaker == judged(overtaking().swapped()).overtaker == A


def test_ship_that_has_the_other_on_starboard_is_remembered_from_the_beginning() -> None:
    memory = carried_on(crossing())

    assert memory.has_other_on_starboard == A
    assert crossing().facts(memory)["has_other_on_starboard"] == "own"
    assert crossing().swapped().facts(memory)["has_other_on_starboard"] == "other"


def _overtakers(kind: Kind, overtaker: ShipId | None = A) -> set[ShipId | None]:
    """Who overtakes, as both ships remember it, where both verdicts name a ship."""
    found = set()
    for meeting, seen in ((overtaking(), kind), (overtaking().swapped(), OPPOSITE.get(kind, kind))):
        wanted = kind in (Kind.PROHIBITED, Kind.COOPERATE)
        told = verdict(meeting.own.id, meeting.other.id, seen, initiator=A if wanted else None)
        view = replace(told, geometry=Geometry.OVERTAKING, overtaker=overtaker)
        found.add(remembered(meeting.situation(), view)[1].overtaker)
    return found


def test_memory_cannot_be_changed() -> None:
    memory = remember(NO_ENCOUNTER, head_on(True, False).facts(), judged(head_on(True, False)))

    with pytest.raises(TypeError):
        memory.held[A] = {}  # type: ignore[index]
    with pytest.raises(TypeError):
        memory.held[A]["direction"] = "upbound"  # type: ignore[index]


def _range(meeting: Meeting) -> float:
    own, other = meeting.own.pose, meeting.other.pose
    return math.hypot(own.x - other.x, own.y - other.y)
