"""Two rulesets compared: generated encounters, what differs, and the files that tell it."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from ccas_core import plugins
from ccas_core.quantities import LENGTH
from ccas_core.ships import UNKNOWN, ShipId
from ccas_core.sim.case_scenario import scenario_of
from ccas_core.sim.scenario_dump import dump_scenario
from ccas_core.sim.scenario_file import parse_scenario
from ccas_core.tapd.case_dump import dump_cases
from ccas_core.tapd.case_file import parse_cases
from ccas_core.tapd.case_run import judge_case, run_case, told
from ccas_core.tapd.cases import Case, CaseShip
from ccas_core.tapd.comparison import compare, disagreement
from ccas_core.tapd.generated import asked_by, encounters
from ccas_core.tapd.ruleset import PairRuleset
from ccas_core.units import DEGREE, wrap

A, B = ShipId("A"), ShipId("B")
FOUND = plugins.load(only=[])


def ruleset(name: str) -> PairRuleset:
    found = FOUND.ruleset(name)
    assert isinstance(found, PairRuleset)
    return found


BPR, TRAN = ruleset("bpr"), ruleset("tran2026")


def generated(count: int, seed: int = 0) -> list[Case]:
    return list(islice(encounters(asked_by(BPR, TRAN), np.random.default_rng(seed)), count))


def plain(case: Case) -> tuple[object, ...]:
    """What a case says, to nine digits."""

    def rounded(value: object) -> object:
        return float(f"{value:.9g}") if isinstance(value, float) else value

    ships = [
        (each.id, {k: rounded(v) for k, v in each.facts.items()}, each.pose and [*map(rounded, each.pose)])
        for each in case.ships
    ]
    return case.id, ships, dict(case.waterway), dict(case.encounter)


# --- generated encounters --------------------------------------------------------------------------


def test_what_rulesets_ask_for_is_found_with_its_limits() -> None:
    asked = asked_by(BPR, TRAN)

    assert {"length", "propulsion", "blue_sign", "with_current"} <= {fact.name for fact in asked.ship}
    assert {"narrow_passage", "regime"} <= {fact.name for fact in asked.waterway}
    assert asked.limits["length"] == (20.0,)
    assert asked.regimes == ("bpr_6_05", "bpr_annex11")


def test_generated_encounters_repeat_with_their_seed() -> None:
    assert [plain(case) for case in generated(50)] == [plain(case) for case in generated(50)]
    assert [plain(case) for case in generated(50)] != [plain(case) for case in generated(50, seed=1)]


def test_half_of_the_generated_ships_are_under_way_and_have_no_geometry_stated() -> None:
    moving = [case for case in generated(40) if case.ships[0].pose is not None]

    assert len(moving) == 20
    assert not any(case.encounter for case in moving)


def test_generated_facts_differ_from_the_defaults_and_are_few() -> None:
    for case in generated(200):
        for ship in case.ships:
            assert 1 <= len(ship.facts) <= 5
        for name, value in case.waterway.items():
            assert value != "" or name == "regime"


# --- comparing -------------------------------------------------------------------------------------


def test_ruleset_agrees_with_itself() -> None:
    compared = compare(BPR, BPR, generated(200))

    assert (compared.tried, compared.differing, compared.groups) == (200, 0, ())


def test_disagreements_are_counted_in_groups_of_articles() -> None:
    compared = compare(BPR, TRAN, generated(200))
    differing = [case for case in generated(200) if disagreement(BPR, TRAN, case)]

    assert compared.differing == sum(group.count for group in compared.groups) == len(differing)
    keys = [group.example.key for group in compared.groups]
    assert len(set(keys)) == len(keys)


def test_example_states_no_fact_that_it_does_not_need() -> None:
    for group in compare(BPR, TRAN, generated(300)).groups:
        case = group.example.case
        for ship in case.ships:
            for name in ship.facts.keys() - {"length"}:
                left = {key: value for key, value in ship.facts.items() if key != name}
                smaller = Case(
                    id="smaller",
                    ships=tuple(
                        CaseShip(id=s.id, facts=left if s is ship else s.facts, pose=s.pose, speed=s.speed)
                        for s in case.ships
                    ),
                    waterway=case.waterway,
                    encounter=case.encounter,
                )
                again = disagreement(BPR, TRAN, smaller)
                assert again is None or again.key != group.example.key or len(ship.facts) > 2


def test_passing_side_alone_is_told_apart_from_a_duty() -> None:
    case = Case(
        id="overtaking",
        ships=(CaseShip(id=A, facts={"length": 80.0}), CaseShip(id=B, facts={"length": 80.0})),
        encounter={"risk_of_collision": True, "geometry": "overtaking", "overtaker": A},
    )

    found = disagreement(BPR, TRAN, case)

    assert found is not None
    assert (found.what, found.one["pass"], found.other["pass"]) == ("side", "overtake_on_port", None)


def test_group_of_ships_is_compared_pair_by_pair() -> None:
    ships = tuple(
        CaseShip(id=ShipId(id_), facts={"length": 80.0}, pose=(north, 0.0, course), speed=3.0)
        for id_, north, course in (("A", 0.0, 0.0), ("B", 900.0, 180.0 * DEGREE), ("C", 9e5, 0.0))
    )

    assert compare(BPR, TRAN, [Case(id="three", ships=ships)]).tried == 3


# --- files -----------------------------------------------------------------------------------------


def test_cases_are_written_and_read_back() -> None:
    cases = generated(100)

    text = dump_cases([(case, {"bpr": told(judge_case(BPR, case))}) for case in cases])
    read = parse_cases(text)

    assert read.findings == ()
    assert [plain(case) for case in read.cases] == [plain(case) for case in cases]
    assert all(run_case(BPR, case, case.expected["bpr"]).passed for case in read.cases)


def test_unknown_facts_and_units_are_written_as_they_are_read() -> None:
    facts = {"draught": UNKNOWN, "weight": 2e6, "heading": 90.0 * DEGREE}
    ships = (CaseShip(id=A, facts=facts, pose=(0.0, 0.0, 0.0), speed=1.0), CaseShip(id=B, facts={}))
    case = Case(id="c", ships=ships, waterway={"regime": "a b", "width": LENGTH.keep(160.0)})

    text = dump_cases([(case, {"bpr": told(judge_case(BPR, case))})])
    (read,) = parse_cases(text).cases

    assert "draught_m: unknown, weight_t: 2000.0" in text
    assert "regime: [a, b]" in text
    assert read.ships[0].facts["heading"] == pytest.approx(90.0 * DEGREE)
    assert read.ships[0].facts["draught"] is UNKNOWN


def test_ships_under_way_become_a_scenario_that_reads_back() -> None:
    moving = [case for case in generated(120) if case.ships[0].pose is not None]

    for case in moving:
        scenario = parse_scenario(dump_scenario(scenario_of(case, "bpr")), rulesets=FOUND.rulesets)
        for ship, plan in zip(case.ships, scenario.ships, strict=True):
            north, east, course = ship.pose or (0.0, 0.0, 0.0)
            assert (plan.start.x, plan.start.y) == (north, east)
            assert plan.start.course == pytest.approx(wrap(course))
            assert plan.speed == pytest.approx(ship.speed or 0.0)


def test_encounter_with_a_stated_geometry_cannot_be_sailed() -> None:
    with pytest.raises(ValueError, match="is not about two ships under way"):
        scenario_of(generated(1)[0], "bpr")
