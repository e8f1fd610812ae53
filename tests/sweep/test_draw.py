"""Encounters drawn from a seed: what they promise."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from ccas_core import plugins
from ccas_core.sim.conduct import CALM_BEYOND, RISKY_WITHIN
from ccas_core.sim.hulls import Track, clearances
from ccas_core.sim.scenario import Plan, Scenario
from ccas_core.sim.scenario_dump import dump_scenario
from ccas_core.sim.scenario_file import parse_scenario
from ccas_core.sim.start import graph_at_start
from ccas_core.sim.undisturbed import undisturbed
from ccas_core.sweep.draw import Kind, Risk, draw_encounter, undisturbed_meeting
from ccas_core.sweep.fleet import room_needed
from ccas_core.sweep.groups import APART, draw_junction, draw_reach
from ccas_core.waterway import BANK_MARGIN, Towards, guiding_line


def drawn(kind: Kind, risk: Risk, index: int) -> Scenario:
    return draw_encounter(np.random.default_rng([3, index]), kind, risk, "tran2026")


@pytest.mark.parametrize("kind", Kind)
@pytest.mark.parametrize("risk", Risk)
def test_undisturbed_ships_come_as_near_as_asked_for(kind: Kind, risk: Risk) -> None:
    clearance = [undisturbed_meeting(drawn(kind, risk, index)).clearance for index in range(20)]

    assert all(each <= RISKY_WITHIN if risk is Risk.RISKY else each > CALM_BEYOND for each in clearance)


@pytest.mark.parametrize("kind", Kind)
def test_same_seed_gives_the_same_file_and_another_seed_another(kind: Kind) -> None:
    one, again, other = (dump_scenario(drawn(kind, Risk.RISKY, index)) for index in (1, 1, 2))

    assert one == again
    assert one != other


@pytest.mark.parametrize("kind", Kind)
@pytest.mark.parametrize("risk", Risk)
def test_drawn_encounter_is_a_scenario_file(kind: Kind, risk: Risk) -> None:
    for index in range(20):
        text = dump_scenario(drawn(kind, risk, index))
        assert dump_scenario(parse_scenario(text)) == text


@pytest.mark.parametrize("kind", [Kind.HEAD_ON, Kind.OVERTAKING])
def test_waterway_leaves_room_to_pass_on_either_side(kind: Kind) -> None:
    for index in range(40):
        scenario = drawn(kind, Risk.RISKY, index)
        one, other = (plan.ship.hull for plan in scenario.ships)
        half = scenario.waters.waterways[0].width / 2.0
        for plan in scenario.ships:
            free = half - abs(plan.route[0].offset) - BANK_MARGIN - plan.ship.hull.beam / 2.0
            assert free >= room_needed(one, other)


def test_crossings_come_at_all_angles_and_from_both_sides() -> None:
    turns = []
    for index in range(60):
        one, other = drawn(Kind.CROSSING, Risk.RISKY, index).ships
        turns.append(np.sin(other.start.course - one.start.course))

    assert min(turns) < -0.8
    assert max(turns) > 0.8
    assert min(map(abs, turns)) < 0.7


def test_facts_say_what_the_chart_says() -> None:
    for index in range(20):
        scenario = drawn(Kind.CROSSING, Risk.RISKY, index)
        for plan in scenario.ships:
            leg = plan.route[0]
            upstream = scenario.waters.waterway(leg.waterway).upstream
            bound = {Towards.NONE: "none", leg.towards: "upbound"}.get(upstream, "downbound")
            assert plan.ship.facts["direction"] == bound
            assert plan.ship.facts["follows_starboard_side"] is (leg.offset >= 5.0)
            assert plan.ship.facts["propulsion"] in {"motor", "sail", "muscle"}


def test_at_a_mouth_the_ship_on_the_narrower_waterway_comes_out_and_the_sign_ranks_large_ships() -> None:
    rulesets = plugins.load().rulesets
    mouths = 0
    for index in range(60):
        scenario = draw_encounter(np.random.default_rng([3, index]), Kind.CROSSING, Risk.RISKY, "ccnr")
        facts = {plan.route[0].waterway: plan.ship.facts for plan in scenario.ships}
        main = max(scenario.waters.waterways, key=lambda each: each.width)
        if not main.facts.get("sign_b9"):
            assert all("manoeuvre" not in each for each in facts.values())
            continue
        mouths += 1
        assert facts[main.id]["on_main_fairway"] is True
        (out,) = (plan for plan in scenario.ships if plan.route[0].waterway != main.id)
        assert out.ship.facts["manoeuvre"] == "entering_main"
        if all(plan.ship.hull.length >= 20.0 for plan in scenario.ships):
            (met,) = graph_at_start(scenario, rulesets).settlements
            assert met.one.give_way == (out.ship.id,)
    assert 18 <= mouths <= 42


@pytest.mark.parametrize("draw", [draw_junction, draw_reach])
def test_groups_begin_apart_and_keep_to_their_number(draw: type) -> None:
    for index in range(10):
        scenario: Scenario = draw(np.random.default_rng([5, index]), (2, 8), "tran2026")
        parse_scenario(dump_scenario(scenario))
        assert 2 <= len(scenario.ships) <= 8
        for one, other in itertools.combinations(scenario.ships, 2):
            near = clearances(track(scenario, one), track(scenario, other), np.zeros(1))
            assert near[0] >= APART


def track(scenario: Scenario, plan: Plan) -> Track:
    return undisturbed(plan, plan.start, 0.0, guiding_line(scenario.waters, plan.route).frame)
