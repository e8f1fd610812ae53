"""Rulesets from files as they judge: from both sides, swapped, and with facts that are not known."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ccas_core.priority import LIGHTEST_FIRST, settle
from ccas_core.roles import Geometry, PassingSide
from ccas_core.ships import UNKNOWN, Hull, Ship, ShipId
from ccas_core.tapd.facts import PairFacts
from ccas_core.tapd.guesses import MOST_GUESSES
from ccas_core.tapd.language.code import Missing
from ccas_core.tapd.ranking import RankingCriterion
from ccas_core.tapd.ruleset_file import parse_ruleset
from ccas_core.tapd.written import WrittenRuleset
from ccas_core.verdict import OPPOSITE, Kind, Verdict, agree

from . import A, B, Placed, installed, ruleset, stated
from .language import random_facts
from .rulesets import HEAD, SMALL, read, with_first_rule, with_rule

CROSSING = {
    "risk_of_collision": True,
    "geometry": "crossing",
    "overtaker": "none",
    "has_other_on_starboard": A,
}


def both(rules: WrittenRuleset, facts: PairFacts) -> tuple[Verdict, Verdict]:
    return rules.judge(facts), rules.judge(facts.mirrored())


def pair(
    own: dict[str, Any] | None = None,
    other: dict[str, Any] | None = None,
    *,
    encounter: dict[str, Any] | None = None,
    waterway: dict[str, Any] | None = None,
    at: tuple[Placed, Placed] | None = None,
) -> PairFacts:
    """Facts of two ships, which cross unless it is said how they meet."""
    met = CROSSING if encounter is None else encounter
    return stated(own, other, encounter=met, waterway=waterway, at=at)


# --- verdicts -------------------------------------------------------------------------------------

EVERYTHING = with_first_rule("""\
id: all
cite: {article: "4", text: It is written}
when: own.nuc and not other.nuc
then: give_way
strength: wait
pass: port_to_port
passing: preferred
side_chosen_by: other
must_follow: own
facilitates: other
signal: blue
manoeuvre: slow down
because: "{own} waits for {other}"
""")


def test_verdict_has_what_the_rule_says() -> None:
    one, two = both(read(EVERYTHING), pair({"nuc": True}))

    assert (one.own, one.other, two.own, two.other) == (A, B, B, A)
    assert (one.kind, two.kind) == (Kind.GIVE_WAY, Kind.STAND_ON)
    for view in (one, two):
        assert (view.ruleset, view.version, view.rule, view.article) == ("small", "1.0.0", "all", "RULES 4")
        assert (view.geometry, view.overtaker, view.has_other_on_starboard) == (Geometry.CROSSING, None, A)
        assert (view.strength, view.passing_side) == ("wait", PassingSide.PORT_TO_PORT)
        assert not view.passing_required
        assert (view.side_chosen_by, view.must_follow, view.facilitates) == (B, A, B)
        assert (view.signal, view.manoeuvre, view.reason) == ("blue", "slow down", "a waits for b")
        assert (view.give_way, view.stand_on, view.initiator, view.diagnosis) == ((A,), (B,), None, "")
    assert agree(one, two) == ""


def test_swapped_rule_says_the_opposite_and_names_the_same_ships() -> None:
    one, two = both(read(EVERYTHING), pair({}, {"nuc": True}))

    assert (one.kind, two.kind) == (Kind.STAND_ON, Kind.GIVE_WAY)
    assert one.side_chosen_by == two.side_chosen_by == A
    assert one.must_follow == two.must_follow == B
    assert one.reason == two.reason == "b waits for a"


@pytest.mark.parametrize(
    ("then", "here", "there"),
    [
        ("give_way", Kind.GIVE_WAY, Kind.STAND_ON),
        ("stand_on", Kind.STAND_ON, Kind.GIVE_WAY),
        ("mutual", Kind.MUTUAL, Kind.MUTUAL),
        ("cooperate", Kind.COOPERATE, Kind.COOPERATE),
        ("prohibited", Kind.PROHIBITED, Kind.PROHIBITED),
        ("negotiate", Kind.NEGOTIATE, Kind.NEGOTIATE),
        ("none", Kind.NONE, Kind.NONE),
        ("conflict", Kind.CONFLICT, Kind.CONFLICT),
        ("gap", Kind.GAP, Kind.GAP),
    ],
)
def test_every_kind_is_seen_by_the_other_ship_as_it_should(then: str, here: Kind, there: Kind) -> None:
    rules = read(
        with_first_rule(f'id: x\ncite: {{article: "4"}}\nwhen: own.nuc and not other.nuc\nthen: {then}')
    )
    for facts, expected in ((pair({"nuc": True}), (here, there)), (pair({}, {"nuc": True}), (there, here))):
        one, two = both(rules, facts)
        assert (one.kind, two.kind) == expected
        assert agree(one, two) == ""
        wanted = then in ("cooperate", "prohibited")
        assert one.initiator == two.initiator == ((A if facts["own.nuc"] else B) if wanted else None)
        assert one.diagnosis == (then if then in ("conflict", "gap") else "")


def test_first_rule_decides_and_each_is_tried_as_written_before_it_is_swapped() -> None:
    both_ways = with_first_rule('id: x\ncite: {article: "4"}\nwhen: own.nuc\nthen: give_way')
    one, two = both(read(both_ways), pair({"nuc": True}, {"nuc": True}))

    assert one.kind is two.kind is Kind.GIVE_WAY  # the rule contradicts itself, and both ships say so
    assert settle(one, two, {A: 1.0, B: 2.0}).fallback


def test_rule_without_mirror_is_tried_as_written_alone() -> None:
    facts = pair({"wind_side": "port"}, {"nuc": True, "wind_side": "port"})
    one, two = both(read(EVERYTHING + "mirror: none\n"), facts)

    assert (one.kind, two.kind) == (Kind.NONE, Kind.GIVE_WAY)


def test_facts_are_those_that_the_rule_looked_at_from_own_side() -> None:
    rules = read(
        with_first_rule("""\
id: x
cite: {article: "4"}
when: own.length < 20 m and tcpa < 300 s and bearing(own, other) > 10 deg and waterway.current == none and
  regime.tidal and other.speed > 1 m/s and has_other_on_starboard == own and other.draught > 2 m
then: give_way
""")
        + "regimes: {tidal: x}\n"
    )
    facts = pair(
        {"length": 10.0},
        {"length": 90.0, "draught": 3.0},
        waterway={"regime": "tidal b"},
        at=((0, 0, 0, 3.0), (300.0, 300.0, 270.0, 3.0)),
    )

    one, two = both(rules, facts)

    assert dict(one.facts) == {
        "tcpa_s": 100.0,
        "bearing(own, other)_deg": 45.0,
        "other.speed_mps": 3.0,
        "own.length": 10.0,
        "other.draught": 3.0,
        "waterway.current": "none",
        "waterway.regime": "b tidal",
        "has_other_on_starboard": A,
    }
    assert dict(two.facts) == {
        "tcpa_s": 100.0,
        "bearing(other, own)_deg": 45.0,
        "own.speed_mps": 3.0,
        "other.length": 10.0,
        "own.draught": 3.0,
        "waterway.current": "none",
        "waterway.regime": "b tidal",
        "has_other_on_starboard": A,
    }


def test_fact_that_is_not_known_is_told_as_such() -> None:
    rules = read(
        with_first_rule(
            'id: x\ncite: {article: "4"}\nwhen: own.nuc and not known(own.wind_side)\nthen: give_way'
        )
    )

    assert rules.judge(pair({"nuc": True, "propulsion": "none"})).facts["own.wind_side"] is UNKNOWN


# --- no rule --------------------------------------------------------------------------------------


def test_ships_that_meet_and_for_which_there_is_no_rule_get_none_with_that_reason() -> None:
    for view in both(read(SMALL), pair({"wind_side": "port"}, {"wind_side": "port"})):
        assert (view.kind, view.reason, view.rule) == (Kind.NONE, "no_rule", "")
        assert (view.article, view.geometry, view.has_other_on_starboard) == ("RULES 9", Geometry.CROSSING, A)


@pytest.mark.parametrize(
    "encounter",
    [{**CROSSING, "risk_of_collision": False}, {"risk_of_collision": True, "geometry": "none"}],
)
def test_ships_that_do_not_meet_get_none_with_that_reason(encounter: dict[str, Any]) -> None:
    for view in both(read(SMALL), pair({"wind_side": "port"}, {"wind_side": "port"}, encounter=encounter)):
        assert (view.kind, view.reason, view.geometry) == (Kind.NONE, "no_risk", Geometry.NONE)
        assert view.article == "RULES 9"


def test_ruleset_without_encounters_recognises_none() -> None:
    rules = read(HEAD + SMALL[SMALL.index("rules:") :])
    facts = pair(
        {"wind_side": "port"}, {"wind_side": "port"}, encounter={}, at=((0, 0, 0, 3), (90, 0, 180, 3))
    )

    assert (rules.judge(facts).kind, rules.judge(facts).reason) == (Kind.NONE, "no_risk")


# --- recognised -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("at", "geometry", "overtaker", "starboard"),
    [
        (((0, 0, 0, 3), (900, 0, 180, 3)), Geometry.HEAD_ON, None, None),
        (((0, 0, 0, 3), (300, 300, 270, 3)), Geometry.CROSSING, None, A),
        (((0, 0, 0, 3), (300, -300, 90, 3)), Geometry.CROSSING, None, B),
        (((-300, 0, 0, 5), (0, 0, 0, 3)), Geometry.OVERTAKING, A, None),
        (((0, 0, 0, 3), (-300, 0, 0, 5)), Geometry.OVERTAKING, B, None),
    ],
)
def test_encounter_is_recognised_from_positions_the_same_from_both_sides(
    at: tuple[Placed, Placed], geometry: Geometry, overtaker: str | None, starboard: str | None
) -> None:
    for view in both(read(SMALL), pair({"ferry": True}, {}, encounter={}, at=at)):
        assert (view.geometry, view.overtaker, view.has_other_on_starboard) == (
            geometry,
            overtaker,
            starboard,
        )


def test_what_is_stated_of_an_encounter_is_not_recognised_anew() -> None:
    at = ((0, 0, 0, 3), (900, 0, 180, 3))
    facts = pair({"ferry": True}, {}, encounter={"geometry": "crossing", "risk_of_collision": True}, at=at)

    assert {view.geometry for view in both(read(SMALL), facts)} == {Geometry.CROSSING}


def test_encounter_that_each_ship_recognises_in_its_own_way_is_looked_at_from_both() -> None:
    odd = SMALL.replace(
        "  head_on: course_difference > 157.5 deg and closing", "  head_on: own.nuc and closing"
    )
    facts = pair({"ferry": True, "nuc": True}, {}, encounter={}, at=((0, 0, 0, 3), (300, 300, 270, 3)))

    one, two = both(read(odd), facts)

    assert (one.geometry, two.geometry) == (Geometry.HEAD_ON, Geometry.CROSSING)


def test_motion_that_is_not_known_leaves_the_encounter_unknown_only_where_it_matters() -> None:
    rules = read(with_rule('id: x\ncite: {article: "4"}\nwhen: geometry == head_on\nthen: mutual'))

    assert rules.judge(pair({"ferry": True}, {}, encounter={})).kind is Kind.STAND_ON
    unknown = rules.judge(pair({"wind_side": "port"}, {"wind_side": "port"}, encounter={}))
    assert unknown.kind is Kind.UNKNOWN_FACT
    assert "geometry" in unknown.reason


# --- not known ------------------------------------------------------------------------------------


def test_fact_that_is_not_known_and_matters_gives_unknown_fact_with_its_name() -> None:
    for view in both(read(SMALL), pair({"wind_side": UNKNOWN}, {"wind_side": "starboard"})):
        assert (view.kind, view.diagnosis) == (Kind.UNKNOWN_FACT, "unknown_fact")
        assert view.reason.startswith("not known: a.wind_side: it decides between ")
        assert view.geometry is Geometry.CROSSING


def test_fact_that_is_not_known_and_does_not_matter_changes_nothing() -> None:
    known = both(read(SMALL), pair({"ferry": True, "wind_side": "port"}, {}))
    unknown = both(read(SMALL), pair({"ferry": True, "wind_side": UNKNOWN}, {"propulsion": UNKNOWN}))

    assert [view.kind for view in unknown] == [view.kind for view in known]
    assert [view.rule for view in unknown] == ["ferry", "ferry"]


SAME_DUTY = with_first_rule("""\
id: x
cite: {article: "4"}
when: own.nuc and own.wind_side == port
then: give_way
- id: y
cite: {article: "5"}
when: own.nuc
then: give_way
""").replace("    - id: y", "  - id: y")


def test_fact_whose_values_all_lead_to_one_duty_need_not_be_known() -> None:
    one, two = both(read(SAME_DUTY), pair({"nuc": True, "wind_side": UNKNOWN}, {"wind_side": "port"}))

    assert (one.kind, two.kind) == (Kind.GIVE_WAY, Kind.STAND_ON)


def test_duty_that_is_the_same_with_another_side_is_told_so() -> None:
    rules = read(
        SAME_DUTY.replace(
            "    then: give_way\n  - id: y", "    then: give_way\n    pass: windward\n  - id: y"
        )
    )
    view = rules.judge(pair({"nuc": True, "wind_side": UNKNOWN}, {"wind_side": "port"}))

    assert view.kind is Kind.UNKNOWN_FACT
    assert view.reason.endswith("a.wind_side: a gives way whatever it is, but the side is not determined")


def test_number_that_is_not_known_cannot_be_tried() -> None:
    rules = read(with_first_rule('id: x\ncite: {article: "4"}\nwhen: own.draught > 2 m\nthen: give_way'))
    view = rules.judge(pair({"propulsion": "none"}, {"draught": 3.0}))

    assert (view.kind, view.reason) == (Kind.UNKNOWN_FACT, "not known: a.draught")
    assert str(view.citation) == "RULES 9"


def test_too_many_guesses_are_not_made() -> None:
    names = [
        "nuc",
        "ram",
        "convoy",
        "blue_sign",
        "signalled",
        "acknowledged",
        "high_speed",
        "tacking",
        "windward",
        "ferry",
    ]
    text = " and ".join(f"own.{name}" for name in names)
    rules = read(with_first_rule(f'id: x\ncite: {{article: "4"}}\nwhen: {text}\nthen: give_way'))
    unknown = dict.fromkeys(names, UNKNOWN)
    view = rules.judge(pair({**unknown, "propulsion": "none"}, {"propulsion": "none", "wind_side": "port"}))

    assert view.kind is Kind.UNKNOWN_FACT
    assert 2 ** len(names) > MOST_GUESSES


def test_ship_may_have_any_name() -> None:
    """A ship called 'pair' or 'own' is a ship all the same."""
    for name in ("pair", "own", "other", "waterway"):
        facts = pair({"wind_side": UNKNOWN}, {"wind_side": "starboard"})
        values = tuple(
            Missing(name, each.name) if isinstance(each, Missing) else each for each in facts.own_values
        )
        view = read(SMALL).judge(replace(facts, own=ShipId(name), own_values=values))
        assert view.kind is Kind.UNKNOWN_FACT
        assert "wind_side" in view.reason


# --- unique ---------------------------------------------------------------------------------------

UNIQUE = SMALL + "policy: unique\n"


def test_two_rules_that_apply_together_contradict_one_another_where_that_must_not_be() -> None:
    facts = pair({"ferry": True, "wind_side": "port"}, {"wind_side": "starboard"})
    for view in both(read(UNIQUE), facts):
        assert (view.kind, view.diagnosis, view.rule) == (Kind.CONFLICT, "conflict", "ferry")
        assert (
            view.reason
            == "rules 'ferry' (RULES 1) and 'sail.wind' (RULES 3) apply together, and say different things"
        )
        assert view.geometry is Geometry.CROSSING
    assert [view.kind for view in both(read(SMALL), facts)] == [Kind.STAND_ON, Kind.GIVE_WAY]


def test_two_rules_that_say_the_same_do_not_contradict_one_another() -> None:
    facts = pair(
        {"propulsion": "motor", "wind_side": "port"}, {"propulsion": "sail", "wind_side": "starboard"}
    )

    assert [view.kind for view in both(read(UNIQUE), facts)] == [Kind.GIVE_WAY, Kind.STAND_ON]


# --- all that is shipped --------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(installed()))
def test_every_verdict_carries_its_source_and_fits_that_of_the_other_ship(name: str) -> None:
    rules = ruleset(name)
    for seed in range(120):
        facts = random_facts(np.random.default_rng(seed))
        one, two = both(rules, facts)
        for view in (one, two):
            assert (view.ruleset, view.version) == (rules.id, rules.version)
            if view.kind is not Kind.UNKNOWN_FACT or view.citation:
                assert view.citation is not None
                assert view.article
                assert view.citation.version
        if name != "tran2026_printed":  # the example of a ruleset that contradicts itself
            assert OPPOSITE.get(one.kind, one.kind) is two.kind


# --- ranks ----------------------------------------------------------------------------------------


def ship(name: str, length: float, mass: float) -> Ship:
    return Ship(id=ShipId(name), hull=Hull(length=length, beam=8.0), mass=mass)


def test_ships_in_a_ring_decide_by_weight_unless_the_file_says_otherwise() -> None:
    assert read(SMALL).rank(ship("a", 40.0, 1e6)) == (1e6,)
    assert read(SMALL).criterion == LIGHTEST_FIRST


def test_ships_in_a_ring_decide_by_the_criteria_of_the_file() -> None:
    text = SMALL + "deadlock: {resolve_by: [draught descending, length, weight, id]}\n"
    rules = parse_ruleset(text, criteria={"draught": RankingCriterion("draught", lambda each: 3.0)})

    assert rules.rank(ship("a", 40.0, 1e6)) == (-3.0, 40.0, 1e6)
    assert rules.criterion == "by draught descending, length, weight, id"


# --- mutants --------------------------------------------------------------------------------------


def test_mutant_differs_in_one_rule_and_leaves_the_ruleset_as_it_was() -> None:
    rules = read(SMALL)
    facts = pair({"ferry": True, "wind_side": "port"}, {"wind_side": "starboard"})

    assert rules.mutated(0, negated=False).judge(facts).rule == "sail.wind"
    assert rules.mutated(0, negated=True).judge(facts).rule == "ferry"  # swapped: the other is no ferry
    assert rules.judge(facts).rule == "ferry"
