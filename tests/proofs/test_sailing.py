"""Ships that show a fault become scenarios in which they judge as before, and files of encounters."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from ccas_core.proofs.plain import plainer
from ccas_core.proofs.sailing import encounter_file, sailed
from ccas_core.proofs.search import A, B, Facts, Ships, case_of, judged
from ccas_core.ships import ShipId
from ccas_core.sim.case_scenario import scenario_of
from ccas_core.sim.scenario import Scenario
from ccas_core.sim.scenario_file import parse_scenario
from ccas_core.tapd.case_file import parse_cases
from ccas_core.tapd.case_run import judge_case, pair_facts, run_case
from ccas_core.tapd.cases import Case
from ccas_core.tapd.written import WrittenRuleset
from ccas_core.units import DEGREE
from ccas_core.waterway import Towards

from . import SOUND, library, ruleset

Places = dict[str, tuple[float, float, float, float]]  # north, east [m], course [deg], speed [m/s]

CROSSING: Places = {"A": (-600.0, 0.0, 0.0, 3.0), "B": (0.0, 620.0, 270.0, 3.0)}
HEAD_ON: Places = {"A": (-900.0, 10.0, 1.0, 3.0), "B": (900.0, 0.0, 180.0, 4.0)}
OVERTAKING: Places = {"A": (-300.0, 0.0, 2.0, 5.0), "B": (0.0, 10.0, 0.0, 3.0)}


def ships(places: Places, facts: dict[str, dict[str, object]] | None = None, **water: object) -> Ships:
    stated = {ship: {"length": 80.0, "beam": 10.0, **(facts or {}).get(ship, {})} for ship in places}
    case = case_of(Facts(stated, water, {}), places)
    mini = ruleset()
    return Ships(case=case, verdicts=judged((mini, mini), case), margin=0.0)


def scenario(found: Ships, by: WrittenRuleset | None = None) -> Scenario:
    mini = by or ruleset()
    text = sailed(found, dict.fromkeys((A, B), mini), "a name", "a title", "a description")
    assert text is not None
    return parse_scenario(text)


@pytest.mark.parametrize(
    ("places", "rule", "waterways"),
    [(CROSSING, "crossing", 2), (HEAD_ON, "head-on", 1), (OVERTAKING, "overtaking", 1)],
)
def test_ships_judge_on_the_chart_as_they_did_without_one(places: Places, rule: str, waterways: int) -> None:
    found = ships(places)
    read = scenario(found)

    assert {view.rule for view in found.verdicts} == {rule}
    assert len(read.waters.waterways) == waterways
    for plan in read.ships:
        north, east, course, speed = places[plan.ship.id]
        assert (plan.start.x, plan.start.y, plan.speed) == (north, east, speed)
        assert math.isclose(math.cos(plan.start.course - course * DEGREE), 1.0)


def test_scenario_says_what_it_shows() -> None:
    read = scenario(ships(CROSSING))

    assert (read.name, read.title, read.description) == ("a name", "a title", "a description")


def test_opposite_ships_follow_one_waterway_towards_its_two_ends() -> None:
    read = scenario(ships(HEAD_ON))

    assert {plan.route[0].towards for plan in read.ships} == {Towards.START, Towards.END}


def test_facts_of_ships_and_waters_are_stated() -> None:
    facts: dict[str, dict[str, object]] = {"A": {"ferry": True}, "B": {"follows_starboard_side": True}}
    read = scenario(ships(CROSSING, facts, regime="one two", narrow_passage=True))

    assert read.ships[0].ship.facts["ferry"] is True
    assert read.ships[0].ship.facts["follows_starboard_side"] is False
    assert read.ships[1].ship.facts["follows_starboard_side"] is True
    for waterway in read.waters.waterways:
        assert waterway.facts["upstream_defined"] is True
        assert waterway.facts["narrow_passage"] is True
        assert waterway.facts["regime"] == "one two"


def test_ships_under_two_rulesets_are_parted_by_a_border() -> None:
    found = ships(CROSSING)
    other = ruleset(SOUND.replace("id: mini", "id: other"))
    views = (found.verdicts[0], other.judge(pair_facts(found.case, B, A, other.vocabulary)))
    parted = replace(found, verdicts=views)
    text = sailed(parted, {A: ruleset(), B: other}, "border")
    assert text is not None
    read = parse_scenario(text)

    assert [read.waters.ruleset_at(plan.start) for plan in read.ships] == ["mini", "other"]


def test_ships_that_would_judge_otherwise_on_the_chart_are_not_sailed() -> None:
    found = ships(CROSSING)
    wrong = replace(found, verdicts=tuple(replace(view, rule="another") for view in found.verdicts))

    assert sailed(wrong, dict.fromkeys((A, B), ruleset()), "wrong") is None


def test_ships_without_a_place_are_not_sailed() -> None:
    found = ships(CROSSING)
    nowhere = tuple(replace(ship, pose=None, speed=None) for ship in found.case.ships)
    lost = replace(found, case=replace(found.case, ships=nowhere))

    assert sailed(lost, dict.fromkeys((A, B), ruleset()), "lost") is None
    with pytest.raises(ValueError, match="under way"):
        scenario_of(lost.case, "mini")


def three() -> Case:
    places = {
        f"S{n}": (
            -500.0 * math.cos(n * 120.0 * DEGREE),
            -500.0 * math.sin(n * 120.0 * DEGREE),
            n * 120.0,
            3.0,
        )
        for n in range(3)
    }
    return case_of(Facts({ship: {"length": 80.0, "beam": 10.0} for ship in places}, {}, {}), places)


def test_ring_of_three_ships_is_a_ring_on_the_chart() -> None:
    case, mini = three(), ruleset()
    found = judge_case(mini, case)
    assert found.cycles
    views = tuple(view for each in found.settlements for view in (each.one, each.other))
    text = sailed(
        Ships(case=case, verdicts=views, margin=0.0), {ship.id: mini for ship in case.ships}, "three"
    )

    assert text is not None
    assert len(parse_scenario(text).waters.waterways) == 3


@pytest.mark.parametrize("places", [CROSSING, HEAD_ON, OVERTAKING])
def test_encounter_file_reads_back_and_passes(places: Places) -> None:
    found = ships(places, {"A": {"ferry": True}}, regime="one two")
    text = encounter_file(found, {A: ruleset()}, "an-id", "a title: with a colon")
    (case,) = parse_cases(text).cases

    assert case.ships[0].facts["ferry"] is True
    assert run_case(ruleset(), case, case.expected["mini"]).passed


def test_encounter_file_of_a_ring_expects_a_ring() -> None:
    case = three()
    text = encounter_file(
        Ships(case=case, verdicts=(), margin=0.0), {ShipId("S0"): ruleset()}, "ring", "ring"
    )
    (read,) = parse_cases(text).cases

    assert read.expected["mini"].diagnosis == "cycle"
    assert run_case(ruleset(), read, read.expected["mini"]).passed


def test_that_ships_lie_in_different_waters_says_nothing_of_a_risk() -> None:
    found = ships(CROSSING)
    apart = replace(found, case=replace(found.case, encounter={"same_waterway": False}))
    (case,) = parse_cases(encounter_file(apart, {A: ruleset()}, "apart", "apart")).cases

    assert case.encounter == {"same_waterway": False}


def test_facts_that_do_not_matter_are_left_out() -> None:
    bpr = library()["bpr"]
    assert isinstance(bpr, WrittenRuleset)
    stated: dict[str, dict[str, object]] = {
        "A": {"length": 12.0, "beam": 3.0, "ferry": False, "wind_side": "port", "blue_sign": True},
        "B": {"length": 150.0, "beam": 15.0, "nuc": True},
    }
    case = case_of(Facts(stated, {"current": "downstream"}, {"same_waterway": True}), CROSSING)
    rules = [view.rule for view in judged((bpr, bpr), case)]
    plain = plainer(case, lambda each: [view.rule for view in judged((bpr, bpr), each)] == rules)

    assert rules == ["crossing.small-large"] * 2
    assert plain.ships[0].facts == {"length": 12.0, "beam": 3.0}
    assert plain.ships[1].facts == {"length": 80.0, "beam": 10.0}
    assert (plain.waterway, plain.encounter) == ({}, {})
