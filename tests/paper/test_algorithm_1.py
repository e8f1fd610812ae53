"""Algorithm 1: the rules that its text describes, the algorithm that is printed, and both of ours.

Two oracles, written from the paper and from nothing of ours: `text` is the three rules of Sec. 3.1,
`printed` is Algorithm 1 line by line, with the choices that a reader has.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Literal, TypeAlias

import numpy as np
import pytest

from ccas_core.roles import Geometry, PassingSide
from ccas_core.ships import UNKNOWN, FactValue
from ccas_core.tapd.ruleset import PairRuleset
from ccas_core.verdict import OPPOSITE, Kind, Verdict, agree

from ..tapd import CHART, A, B, Meeting, crossing, head_on, overtaking, random_encounter, report, ruleset

Number: TypeAlias = Literal[1, 2]
Situation: TypeAlias = Literal["head-on", "crossing", "overtaking"]
Side: TypeAlias = Literal["starboard", "port", ""]
Yields: TypeAlias = frozenset[Number]

NONE: Yields = frozenset()
ONE: Yields = frozenset((1,))
TWO: Yields = frozenset((2,))
BOTH: Yields = ONE | TWO
TEXT, PRINTED = ruleset("tran2026"), ruleset("tran2026_printed")
T_HO, T_IC = (float(TEXT.text.parameters[name].value) for name in ("T_ho", "T_IC"))  # [s]
ENCOUNTERS = [random_encounter(np.random.default_rng(seed)) for seed in range(4000)]


# --- the oracles ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """Two ships as the rules of Sec. 3.1 see them."""

    situation: Situation
    on_starboard_side: tuple[bool, bool]  # of the fairway
    one_comes_from: Side = ""  # of ship 2; crossing only
    overtaker: Number = 1  # overtaking only


def text(case: Case) -> Yields | None:
    """Who gives way by the text of Sec. 3.1; None where it has no rule."""
    one, two = case.on_starboard_side
    if case.situation == "overtaking":
        return frozenset((case.overtaker,))  # should keep out of the way of the overtaken vessel
    if one != two:
        return TWO if one else ONE  # the vessel not following the starboard side shall give way
    if case.situation == "head-on":
        return None if one else BOTH  # neither: each shall give way so that they pass port to port
    if one:
        return None  # both follow the starboard side
    return ONE if case.one_comes_from == "port" else TWO  # the ship from port gives way


def printed(case: Case, *, transposed: bool = False, flipped: bool = False, swapped: bool = False) -> Yields:
    """Who gives way by Algorithm 1 as printed.

    `transposed` reads rho_{ij} of line 21 as rho_{ji}, `flipped` turns its comparison round, and
    `swapped` exchanges the signs of lines 13 and 15.
    """
    varpi = -0.5 if swapped else 0.5
    rho: dict[tuple[Number, Number], float] = {}  # rho[j, i]: priority of j, assigned by i
    ships: tuple[tuple[Number, Number], ...] = ((1, 2), (2, 1))
    for i, j in ships:
        rho[i, i], rho[j, i] = (float(case.on_starboard_side[ship - 1]) for ship in (i, j))  # lines 1-7
        if case.situation == "crossing" and rho[j, i] < 1.0:  # lines 9, 11
            from_starboard = (case.one_comes_from == "starboard") is (i == 1)
            rho[j, i] += varpi if from_starboard else -varpi  # lines 12-16
    give_way: set[Number] = set()
    for i, j in ships:
        compared = rho[j, i] if transposed else rho[i, j]
        if rho[i, i] < compared if flipped else rho[i, i] > compared:  # line 21
            give_way.add(i)
    return frozenset(give_way)


# --- our rulesets, asked the same way -------------------------------------------------------------


def realised(case: Case, flags: tuple[FactValue, FactValue] | None = None) -> Meeting:
    """Put a case on the water; ship 1 is a, ship 2 is b."""
    one, two = flags or case.on_starboard_side
    if case.situation == "head-on":
        return head_on(one, two)
    if case.situation == "crossing":
        return crossing(one, two, other_from_starboard=case.one_comes_from == "port")
    if case.overtaker == 1:
        return overtaking(one, two)
    return Meeting(
        CHART,
        report(A, -400.0, 0.0, 0.0, starboard=one),
        report(B, -1000.0, 0.0, 0.0, speed=5.0, starboard=two),
    )


def both(rules: PairRuleset, meeting: Meeting) -> tuple[Verdict, Verdict]:
    """Judge from both sides."""
    return rules.judge(meeting.facts()), rules.judge(meeting.swapped().facts())


def yields(rules: PairRuleset, meeting: Meeting) -> Yields:
    """Ships that give way by their own view."""
    one, two = (view.kind in (Kind.GIVE_WAY, Kind.MUTUAL) for view in both(rules, meeting))
    return (ONE if one else NONE) | (TWO if two else NONE)


FLAGS = [(one, two) for one in (True, False) for two in (True, False)]
SIDES: tuple[Side, ...] = ("starboard", "port")
OVERTAKERS: tuple[Number, ...] = (1, 2)
CASES = [
    *(Case("head-on", flags) for flags in FLAGS),
    *(Case("crossing", flags, side) for flags in FLAGS for side in SIDES),
    *(Case("overtaking", flags, overtaker=ship) for flags in FLAGS for ship in OVERTAKERS),
]


def classified(meeting: Meeting) -> Case | None:
    """Read a random encounter as a case, by the text; None where the ships do not meet."""
    own, other = meeting.own, meeting.other
    if min(own.speed, other.speed) <= 0.1:
        return None
    v_1, v_2 = (r.speed * np.exp(1j * r.pose.course) for r in (own, other))
    apart = complex(other.pose.x - own.pose.x, other.pose.y - own.pose.y)
    closing = v_2 - v_1
    tcpa = -(apart * closing.conjugate()).real / abs(closing) ** 2
    angle = abs(np.angle(v_1 / v_2, deg=True))
    flags = (
        own.ship.facts["follows_starboard_side"] is True,
        other.ship.facts["follows_starboard_side"] is True,
    )
    together = all(_between_banks(each) for each in (meeting, meeting.swapped()))
    if 0.0 <= tcpa <= T_HO and together:
        for overtaker, sight, fast, slow in ((1, -apart, v_1, v_2), (2, apart, v_2, v_1)):
            abaft = abs(np.angle(sight / slow, deg=True)) > 112.5
            if abaft and abs(fast) > abs(slow) and angle < 67.5:
                return Case("overtaking", flags, overtaker=1 if overtaker == 1 else 2)
        if angle > 180.0 - 22.5:
            return Case("head-on", flags)
    times = [_time_to_centre(each) for each in (meeting, meeting.swapped())]
    if own.waterway != other.waterway and all(0.0 <= t < T_IC for t in times):
        return Case("crossing", flags, "port" if (v_1 / v_2).imag > 0.0 else "starboard")
    return None


def _between_banks(meeting: Meeting) -> bool:
    place, waterway = meeting.other.pose, meeting.waters.waterway(meeting.own.waterway)
    line = complex(*(waterway.centreline[1] - waterway.centreline[0]))
    return abs((complex(place.x, place.y) / line).imag) * abs(line) <= waterway.width / 2.0


def _time_to_centre(meeting: Meeting) -> float:
    """Time to the origin, where the waterways of these tests cross, along the own waterway."""
    frame = meeting.waters.waterway(meeting.own.waterway).frame(meeting.own.towards)
    line = complex(*(frame.vertices[1] - frame.vertices[0]))
    place = complex(meeting.own.pose.x, meeting.own.pose.y)
    return -(place / line).real * abs(line) / meeting.own.speed


# --- the whole table ------------------------------------------------------------------------------

TABLE = [  # case; text; print: literal index, index transposed, and comparison flipped, and signs swapped
    (Case("head-on", (True, False)), TWO, NONE, ONE, TWO, TWO),
    (Case("head-on", (False, True)), ONE, NONE, TWO, ONE, ONE),
    (Case("head-on", (False, False)), BOTH, NONE, NONE, NONE, NONE),
    (Case("crossing", (True, False), "starboard"), TWO, NONE, ONE, TWO, TWO),
    (Case("crossing", (True, False), "port"), TWO, TWO, ONE, TWO, TWO),
    (Case("crossing", (False, True), "starboard"), ONE, ONE, TWO, ONE, ONE),
    (Case("crossing", (False, True), "port"), ONE, NONE, TWO, ONE, ONE),
    (Case("crossing", (False, False), "starboard"), TWO, ONE, TWO, ONE, TWO),
    (Case("crossing", (False, False), "port"), ONE, TWO, ONE, TWO, ONE),
    (Case("overtaking", (True, False)), ONE, NONE, ONE, TWO, TWO),
    (Case("overtaking", (False, False)), ONE, NONE, NONE, NONE, NONE),
]


@pytest.mark.parametrize(("case", "by_text"), [row[:2] for row in TABLE])
def test_ruleset_gives_the_column_text(case: Case, by_text: Yields) -> None:
    assert text(case) == by_text
    assert yields(TEXT, realised(case)) == by_text


@pytest.mark.parametrize(("case", "by_print"), [(row[0], row[3]) for row in TABLE])
def test_printed_ruleset_gives_the_column_index_transposed(case: Case, by_print: Yields) -> None:
    assert yields(PRINTED, realised(case)) == by_print


@pytest.mark.parametrize("row", TABLE)
def test_readings_of_the_print_give_their_columns(
    row: tuple[Case, Yields, Yields, Yields, Yields, Yields],
) -> None:
    case = row[0]

    readings = (
        printed(case),
        printed(case, transposed=True),
        printed(case, transposed=True, flipped=True),
        printed(case, transposed=True, flipped=True, swapped=True),
    )

    assert readings == row[2:]


def test_no_reading_of_the_print_satisfies_the_text() -> None:
    for transposed, flipped, swapped in product((False, True), repeat=3):
        read = [printed(case, transposed=transposed, flipped=flipped, swapped=swapped) for case, *_ in TABLE]
        assert read != [row[1] for row in TABLE]


# --- tran2026: the text ---------------------------------------------------------------------------


@pytest.mark.parametrize("case", CASES)
def test_every_case_is_judged_as_the_text_says(case: Case) -> None:
    expected = text(case)
    one, two = both(TEXT, realised(case))

    assert not agree(one, two)
    assert one.geometry == case.situation.replace("-", "_")
    assert expected is None or yields(TEXT, realised(case)) == expected


def test_random_encounters_are_judged_as_the_text_says() -> None:
    seen: dict[str, int] = {}
    for meeting in ENCOUNTERS:
        case, (one, two) = classified(meeting), both(TEXT, meeting)
        if case is None:
            assert one.kind is two.kind is Kind.NONE
            continue
        assert one.geometry == two.geometry == case.situation.replace("-", "_")
        expected = text(case)
        assert expected is None or yields(TEXT, meeting) == expected
        seen[case.situation] = seen.get(case.situation, 0) + 1

    assert min(seen[situation] for situation in ("head-on", "crossing", "overtaking")) > 100


def test_two_views_are_opposite_on_every_random_encounter() -> None:
    for meeting in ENCOUNTERS:
        one, two = both(TEXT, meeting)
        assert agree(one, two) == ""
        assert OPPOSITE.get(one.kind, one.kind) is two.kind


def test_two_views_are_opposite_where_the_chart_decides_the_side() -> None:
    for seed in range(1000):
        assert agree(*both(TEXT, random_encounter(np.random.default_rng(seed), flags=False))) == ""


def test_where_both_keep_their_side_the_ship_from_port_gives_way_and_the_rule_owns_up_to_it() -> None:
    """The text has no rule for it (E5 of the analysis); the note of the rule in the file says so."""
    one, two = both(TEXT, realised(Case("crossing", (True, True), "port")))

    assert (one.kind, two.kind) == (Kind.GIVE_WAY, Kind.STAND_ON)
    assert one.rule == two.rule
    assert "applied where both do, too" in TEXT.text.rule(one.rule).note


def test_where_both_keep_their_side_head_on_ships_pass_port_to_port() -> None:
    one, two = both(TEXT, head_on(True, True))

    assert one.kind is two.kind is Kind.MUTUAL
    assert one.passing_side is two.passing_side is PassingSide.PORT_TO_PORT


@pytest.mark.parametrize("flags", [(UNKNOWN, True), (False, UNKNOWN), (UNKNOWN, UNKNOWN), (True, UNKNOWN)])
@pytest.mark.parametrize(
    "case",
    [
        Case("head-on", (True, True)),
        Case("crossing", (True, True), "port"),
        Case("crossing", (True, True), "starboard"),
    ],
)
def test_unknown_side_is_never_taken_for_a_no(case: Case, flags: tuple[FactValue, FactValue]) -> None:
    """It is not known, unless the duty is the same whatever it is: then it does not matter."""
    one, two = both(TEXT, realised(case, flags))
    own, other = ((True, False) if flag is UNKNOWN else (flag,) for flag in flags)
    duties = {yields(TEXT, realised(case, guess)) for guess in product(own, other)}

    if len(duties) == 1:
        assert yields(TEXT, realised(case, flags)) in duties
    else:
        assert one.kind is two.kind is Kind.UNKNOWN_FACT


@pytest.mark.parametrize("flags", [(UNKNOWN, True), (False, UNKNOWN)])
def test_unknown_side_of_the_ship_that_gives_way_in_any_case_does_not_matter(
    flags: tuple[FactValue, FactValue],
) -> None:
    assert yields(TEXT, realised(Case("crossing", (True, True), "port"), flags)) == ONE


def test_overtaking_does_not_ask_for_the_side() -> None:
    assert yields(TEXT, overtaking(UNKNOWN, UNKNOWN)) == ONE


def test_head_on_near_an_intersection_is_not_a_crossing() -> None:
    """E8: the print tests the times to the intersection first; ships of one waterway do not cross."""
    near = Meeting(CHART, report(A, -90.0, 0.0, 0.0), report(B, 90.0, 0.0, 180.0))

    assert {view.geometry for view in both(TEXT, near)} <= {Geometry.HEAD_ON, Geometry.NONE}


@pytest.mark.parametrize("case", [case for case in CASES if text(case)])
def test_every_verdict_that_obliges_names_its_source_and_the_facts_it_used(case: Case) -> None:
    for view in both(TEXT, realised(case)):
        assert view.article.startswith("Tran et al. 2026 Sec. 3.1")
        assert (view.ruleset, view.version) == (TEXT.id, TEXT.version)
        assert view.rule
        assert "geometry" in view.facts
        if view.rule.endswith(".starboard-side"):  # a verdict names the facts that its rule looked at
            assert view.facts.keys() >= {"own.follows_starboard_side", "other.follows_starboard_side"}


# --- the world mirrored, moved --------------------------------------------------------------------


def test_mirrored_encounter_gives_the_mirrored_verdict_except_where_the_rule_is_about_a_side() -> None:
    counted = {True: 0, False: 0}
    for meeting in ENCOUNTERS[:1500]:
        here, there = TEXT.judge(meeting.facts()), TEXT.judge(meeting.mirrored_world().facts())
        about_a_side = here.rule == "crossing.from-starboard"
        assert there.kind is (OPPOSITE[here.kind] if about_a_side else here.kind)
        assert (there.geometry, there.passing_side) == (here.geometry, here.passing_side)
        counted[about_a_side] += here.kind is not Kind.NONE

    assert min(counted.values()) > 30


def test_verdict_does_not_change_when_the_world_is_moved_and_turned() -> None:
    for n, meeting in enumerate(ENCOUNTERS[:1500]):
        moved = meeting.moved(700.0, -300.0, 0.01 * n)
        for rules in (TEXT, PRINTED):
            assert rules.judge(moved.facts()).kind is rules.judge(meeting.facts()).kind


# --- tran2026_printed: the print ------------------------------------------------------------------


@pytest.mark.parametrize("case", CASES)
def test_printed_ruleset_is_the_printed_algorithm_with_the_index_transposed(case: Case) -> None:
    assert yields(PRINTED, realised(case)) == printed(case, transposed=True)


@pytest.mark.parametrize(("flags", "wrong"), [((True, False), ONE), ((False, True), TWO)])
def test_printed_ruleset_gives_the_duty_to_the_ship_that_keeps_its_starboard_side(
    flags: tuple[bool, bool], wrong: Yields
) -> None:
    meeting = head_on(*flags)

    assert yields(PRINTED, meeting) == wrong
    assert yields(TEXT, meeting) == BOTH - wrong


def test_printed_ruleset_obliges_nobody_where_the_text_obliges_both() -> None:
    one, two = both(PRINTED, head_on(False, False))

    assert one.kind is two.kind is Kind.STAND_ON
    assert agree(one, two)


def test_printed_ruleset_is_right_on_a_crossing_where_nobody_keeps_its_side_as_in_fig_11() -> None:
    for side in SIDES:
        case = Case("crossing", (False, False), side)
        assert yields(PRINTED, realised(case)) == text(case)


def test_printed_ruleset_still_finds_ships_head_on_that_have_passed() -> None:
    past = head_on(True, False).later(400.0)

    assert PRINTED.judge(past.facts()).geometry is Geometry.HEAD_ON
    assert TEXT.judge(past.facts()).geometry is Geometry.NONE


def test_printed_ruleset_judges_ships_that_do_not_meet() -> None:
    apart = Meeting(
        CHART, report(A, 500.0, 0.0, 0.0, starboard=True), report(B, -500.0, 0.0, 180.0, starboard=False)
    )

    assert yields(PRINTED, apart) == ONE
    assert yields(TEXT, apart) == NONE


def test_printed_ruleset_is_inconsistent_on_many_random_encounters() -> None:
    disagreeing = sum(bool(agree(*both(PRINTED, meeting))) for meeting in ENCOUNTERS)

    assert disagreeing > len(ENCOUNTERS) // 4


def test_consistency_condition_as_printed_fails_for_a_pair_that_is_ordered_rightly() -> None:
    """E12: "if rho_ji > rho_ii then rho_jj > rho_ji", with shared perception of the starboard side."""
    rho_ii, rho_ji = 0.0, 1.0
    rho_jj = rho_ji  # ship j assigns itself what ship i assigns it

    assert rho_ji > rho_ii
    assert not rho_jj > rho_ji


def test_bearing_and_course_tell_the_same_side_where_the_ships_are_still_far() -> None:
    for angle, from_starboard in ((90.0, True), (-90.0, False)):
        facts = crossing(other_from_starboard=from_starboard).facts()
        assert math.copysign(1.0, facts.quantity(("bearing", "own", "other"))) == math.copysign(1.0, angle)
