"""Each ruleset of `broken/` has one fault, which is found as what it is; its repaired twin is proved.

The first lines of each file say what is wrong with it, and those of its twin how it is repaired.
"""

from __future__ import annotations

import pytest

from ccas_core.proofs.findings import Fault, Outcome
from ccas_core.proofs.pairs import recognising
from ccas_core.proofs.search import Ships, judged
from ccas_core.tapd.written import WrittenRuleset
from ccas_core.verdict import Kind, Verdict, agree

from .rulesets import BROKEN, broken, finding

# By file: the property that fails, and what is at fault: a rule by its id, or words of the title.
FAULTS = {
    "both_begin": ("consistent", "leaving"),
    "both_choose": ("consistent", "upbound"),
    "both_obliged": ("consistent", "ferry-and-convoy"),
    "both_privileged": ("consistent", "both ships stand on by rule 'disabled'"),
    "both_stand_on": ("consistent", "crossing.stands-on"),
    "bearing_for_course": ("consistent", "crossing"),
    "border_port_hand": ("border", "both stand on"),
    "class_forgotten": ("complete", "no rule applies"),
    "crossing_seen_by_one": ("mirror_sound", "only one of the ships sees a crossing"),
    "dead_by_union": ("no_dead_rule", "convoy"),
    "dead_rule": ("no_dead_rule", "fishing"),
    "empty_domain": ("domain_not_empty", "no two ships"),
    "equal_ships": ("consistent", "crossing.shorter"),
    "equal_ships_unsaid": ("complete", "no rule applies"),
    "exception_swallows": ("no_dead_rule", "ferry"),
    "gate_forgotten": ("consistent", "small"),
    "head_on_seen_by_one": ("mirror_sound", "only one of the ships sees a head-on encounter"),
    "irrelevant_rule": ("no_irrelevant_rule", "crossing.ferries"),
    "last_rung_dropped": ("complete", "no rule applies"),
    "limit_shifted": ("consistent", "crossing.gives-way"),
    "not_exclusive": ("exclusive", "sail"),
    "other_waterway": ("complete", "no rule applies"),
    "overtaking_both_ways": ("mirror_sound", "each ship overtakes the other"),
    "passengers_overlap": ("consistent", "passengers"),
    "range_too_wide": ("parameters", "crossing.classes"),
    "risk_seen_by_one": ("mirror_sound", "only one of the ships sees a risk"),
    "role_flips": ("role_stable", "crossing.seen-ahead"),
    "same_time_at_junction": ("consistent", "junction"),
    "sign_swapped": ("consistent", "crossing.gives-way-too"),
    "slack_water": ("complete", "no rule applies"),
    "starboard_ring": ("acyclic", "in a ring"),
    "starboard_for_both": ("mirror_sound", "each ship has the other on its starboard side"),
    "tie_not_total": ("tie_break_total", "neither goes first"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_broken_ruleset_is_refuted_by_the_property_that_it_breaks(name: str) -> None:
    property_, culprit = FAULTS[name]

    found = finding(broken(name), property_)

    assert found.outcome is Outcome.REFUTED, found
    named = [
        fault
        for fault in found.faults
        if culprit in fault.title or culprit in [rule.id for rule in fault.rules]
    ]
    assert named, found.faults
    for fault in named:
        assert_shown(broken(name), property_, fault)


@pytest.mark.parametrize("name", FAULTS)
def test_its_repaired_twin_is_proved(name: str) -> None:
    property_, _ = FAULTS[name]

    found = finding(broken(f"{name}.repaired"), property_)

    assert found.outcome is Outcome.PROVED, found


def test_no_file_of_the_folder_is_forgotten() -> None:
    files = {path.stem for path in BROKEN.glob("*.yaml")}

    assert files == {name + tail for name in FAULTS for tail in ("", ".repaired")}


@pytest.mark.parametrize("name", FAULTS)
def test_a_broken_ruleset_is_of_the_size_that_people_read(name: str) -> None:
    assert 5 <= len(broken(name).text.rules) <= 12


def assert_shown(ruleset: WrittenRuleset, property_: str, fault: Fault) -> None:
    """Ships of a fault show it when they are judged again; dead and idle rules have none to show."""
    if property_ in ("no_dead_rule", "no_irrelevant_rule", "domain_not_empty"):
        assert fault.ships is None
        return
    assert fault.ships is not None
    if property_ in ("acyclic", "border", "role_stable", "parameters", "tie_break_total"):
        return  # judged as a ring, by two rulesets, twice, by other parameters, or not at all
    assert shows(ruleset, property_, fault.ships)


def shows(ruleset: WrittenRuleset, property_: str, ships: Ships) -> bool:
    """Whether ships, judged again, break a property."""
    judge = recognising(ruleset) if property_ == "mirror_sound" else ruleset
    one, two = judged((judge, judge), ships.case)
    if property_ == "mirror_sound":
        return recognised(one) != recognised(two)
    if property_ == "complete":
        return one.kind in (Kind.NONE, Kind.GAP) or one.kind is two.kind is Kind.STAND_ON
    return bool(agree(one, two)) or one.kind is Kind.CONFLICT


def recognised(one: Verdict) -> tuple[object, ...]:
    """What a ship recognises."""
    return one.kind, one.geometry, one.overtaker, one.has_other_on_starboard
