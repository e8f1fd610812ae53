"""The smallest manoeuvre that changes a verdict."""

from __future__ import annotations

import math

import pytest

from ccas_core import plugins
from ccas_core.ships import ShipId
from ccas_core.tapd.case_run import pair_facts
from ccas_core.tapd.cases import Case, CaseShip
from ccas_core.tapd.facts import PairFacts
from ccas_core.tapd.flip import Manoeuvre, Views, flips
from ccas_core.tapd.written import WrittenRuleset
from ccas_core.units import DEGREE
from ccas_core.verdict import Kind

RULESET = plugins.load().rulesets["tran2026"]
A, B = ShipId("A"), ShipId("B")


def judge(facts: PairFacts) -> Views:
    assert isinstance(RULESET, WrittenRuleset)
    return RULESET.judge(facts), RULESET.judge(facts.mirrored())


def head_on(speed: float = 3.0) -> PairFacts:
    ships = (
        CaseShip(id=A, facts={"length": 100.0}, pose=(0.0, 0.0, 0.0), speed=3.0),
        CaseShip(id=B, facts={"length": 100.0}, pose=(900.0, 0.0, math.pi), speed=speed),
    )
    return pair_facts(Case(id="head on", ships=ships), A, B, RULESET.vocabulary)


def test_turn_out_of_the_sector_of_opposite_courses_is_found() -> None:
    found = [each for each in flips(judge, head_on()) if each.turns]

    assert len(found) == 4
    assert all(each.change == pytest.approx(22.5 * DEGREE, abs=0.01 * DEGREE) for each in found)
    assert {each.manoeuvre for each in found} == {Manoeuvre.TO_PORT, Manoeuvre.TO_STARBOARD}


def test_verdict_after_the_change_is_another_and_before_it_is_the_same() -> None:
    before = judge(head_on())
    for each in flips(judge, head_on()):
        assert [view.kind for view in each.views] != [view.kind for view in before]
        assert before[0].kind is Kind.MUTUAL


def test_smallest_change_comes_first() -> None:
    shares = [each.share for each in flips(judge, head_on())]

    assert shares == sorted(shares)


def test_ship_that_stops_meets_nobody() -> None:
    (slower,) = [e for e in flips(judge, head_on()) if e.ship == B and e.manoeuvre is Manoeuvre.SLOWER]

    assert slower.becomes == pytest.approx(0.1, abs=0.001)
    assert [view.kind for view in slower.views] == [Kind.NONE, Kind.NONE]


def test_nothing_is_found_where_nothing_is_known_of_the_motion() -> None:
    ships = (CaseShip(id=A, facts={}), CaseShip(id=B, facts={}))

    assert flips(judge, pair_facts(Case(id="x", ships=ships), A, B, RULESET.vocabulary)) == ()


def test_ship_at_rest_has_no_course_to_change() -> None:
    found = flips(judge, head_on(speed=0.0))

    assert not [each for each in found if each.ship == B and each.turns]
