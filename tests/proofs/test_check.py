"""All properties of a ruleset, with waivers: what a sound one proves, and what each fault refutes."""

from __future__ import annotations

from datetime import date

import pytest

from ccas_core.errors import RulesetError
from ccas_core.proofs.check import check, check_against, check_border, names_of, narrowed, overall, waived
from ccas_core.proofs.findings import Finding, Outcome

from . import BROKEN, SOUND, broken, by_name, library, ruleset, with_waiver_text

TODAY = date(2026, 6, 1)
PAIRS = (
    "domain_not_empty", "mirror_sound", "consistent", "complete", "tie_break_total", "no_dead_rule",
    "no_irrelevant_rule",
)  # fmt: skip


def test_sound_ruleset_is_proved_of_any_two_ships() -> None:
    findings = check(ruleset(), today=TODAY, only=PAIRS)

    assert {each.property: each.outcome for each in findings} == dict.fromkeys(PAIRS, Outcome.PROVED)
    assert overall(findings) is Outcome.PROVED


@pytest.mark.parametrize("property_", BROKEN)
def test_each_fault_is_refuted_by_the_property_that_it_breaks(property_: str) -> None:
    (finding,) = check(ruleset(broken(property_)), today=TODAY, only=[property_])

    assert finding.outcome is Outcome.REFUTED
    assert not finding.waived
    assert overall([finding]) is Outcome.REFUTED


def test_fault_names_rule_and_article_and_shows_ships_with_facts_that_matter_only(
    inconsistent: Finding,
) -> None:
    for fault in inconsistent.faults:
        assert [rule.id for rule in fault.rules] == ["crossing"]
        assert fault.articles == ("Mini 3",)
        assert fault.ships is not None
        assert {view.rule for view in fault.ships.verdicts} == {"crossing"}
        assert {name for ship in fault.ships.case.ships for name in ship.facts} == {"length", "beam"}


def test_three_ships_that_give_way_to_starboard_form_a_ring() -> None:
    (finding,) = check(ruleset(), today=TODAY, only=["acyclic"], max_ships=3)

    assert finding.outcome is Outcome.REFUTED
    ring = finding.faults[0].ships
    assert ring is not None
    views = ring.verdicts
    assert [view.other for view in views] == [view.own for view in (*views[1:], views[0])]


def test_property_that_a_ruleset_cannot_have_is_left_out() -> None:
    assert check(ruleset(), today=TODAY, only=["exclusive"]) == ()
    assert "exclusive" in names_of(ruleset())


def test_time_that_is_spent_leaves_things_undecided() -> None:
    (finding,) = check(ruleset(), today=TODAY, only=["consistent"], budget_s=0.0)

    assert finding.outcome is Outcome.UNDECIDED
    assert finding.open
    assert overall([finding]) is Outcome.UNDECIDED


# -- waivers -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def inconsistent() -> Finding:
    (finding,) = check(ruleset(broken("consistent")), today=TODAY, only=["consistent"])
    return finding


def with_waiver(finding: Finding, text: str, today: date = TODAY) -> Finding:
    return waived(finding, ruleset(text).text.waivers, today)


def test_waiver_covers_a_fault_until_its_day(inconsistent: Finding) -> None:
    text = with_waiver_text(SOUND, "consistent", "2026-12-31")
    before, last = (with_waiver(inconsistent, text, day) for day in (date(2026, 6, 1), date(2026, 12, 31)))
    after = with_waiver(inconsistent, text, date(2027, 1, 1))

    assert before.waived
    assert last.waived
    assert overall([before]) is Outcome.PROVED
    assert not after.waived
    assert after.faults[0].expired
    assert overall([after]) is Outcome.REFUTED


def test_waiver_for_some_rules_covers_these_only(inconsistent: Finding) -> None:
    for rules, covered in (("crossing", True), ("overtaking", False), ("overtaking, crossing", True)):
        text = with_waiver_text(SOUND, "consistent", rules=rules)

        assert with_waiver(inconsistent, text).waived is covered


def test_of_two_waivers_the_one_that_lasts_longer_counts(inconsistent: Finding) -> None:
    found = ruleset(with_waiver_text(SOUND, "consistent", "2020-01-01")).text.waivers
    found += ruleset(with_waiver_text(SOUND, "consistent")).text.waivers

    assert waived(inconsistent, found, TODAY).waived


def test_name_of_a_waived_check_may_be_written_with_hyphens() -> None:
    text = with_waiver_text(broken("tie_break_total"), "tie-break-total")
    (finding,) = check(ruleset(text), today=TODAY, only=["tie_break_total"])

    assert finding.waived


def test_waiver_of_another_check_covers_nothing(inconsistent: Finding) -> None:
    assert not with_waiver(inconsistent, with_waiver_text(SOUND, "complete")).waived


def test_waiver_that_is_not_needed_is_told() -> None:
    text = with_waiver_text(SOUND, "tie_break_total")
    (finding,) = check(ruleset(text), today=TODAY, only=["tie_break_total"])

    assert finding.outcome is Outcome.PROVED
    assert any("covers nothing" in note for note in finding.notes)


# -- assumptions, borders, versions --------------------------------------------------------------


def test_assumption_leaves_out_ships_for_which_a_property_fails() -> None:
    gap = broken("complete")
    (finding,) = check(narrowed(ruleset(gap), "own.ferry and other.ferry"), today=TODAY, only=["complete"])

    assert finding.outcome is Outcome.PROVED


def test_ships_that_are_found_keep_to_what_is_assumed() -> None:
    narrow = narrowed(ruleset(broken("consistent")), "own.speed >= 2 m/s")
    (finding,) = check(narrow, today=TODAY, only=["consistent"])

    speeds = [ship.speed or 0.0 for fault in finding.faults if fault.ships for ship in fault.ships.case.ships]
    assert speeds
    assert min(speeds) >= 2.0


def test_assumption_that_is_no_condition_is_told_with_its_place() -> None:
    with pytest.raises(RulesetError, match=r"--assume:1:1: unknown fact 'own.lenght'"):
        narrowed(ruleset(), "own.lenght > 5 m")


def test_ruleset_does_not_differ_from_itself_and_does_from_another_version() -> None:
    other = ruleset(SOUND.replace("has_starboard(own)", "has_starboard(other)"))
    same = check_against(ruleset(), ruleset(), today=TODAY)
    changed = check_against(ruleset(), other, today=TODAY)

    assert same.outcome is Outcome.PROVED
    assert changed.outcome is Outcome.REFUTED


def test_border_to_a_ruleset_with_the_hands_swapped_lets_both_stand_on() -> None:
    text = SOUND.replace("id: mini", "id: swapped").replace("has_starboard(own)", "has_starboard(other)")
    finding = check_border(ruleset(), ruleset(text), today=TODAY)

    assert finding.outcome is Outcome.REFUTED
    assert {fault.kind for fault in finding.faults} == {"border"}


def test_every_property_is_told_before_and_after() -> None:
    told: list[str] = []

    class Listener:
        def begun(self, ruleset: str, name: str) -> None:
            told.append(f"{ruleset} {name}?")

        def done(self, ruleset: str, finding: Finding) -> None:
            told.append(f"{ruleset} {finding.property}!")

    check(ruleset(), today=TODAY, only=["consistent", "tie_break_total"], progress=Listener())

    assert told == ["mini consistent?", "mini consistent!", "mini tie_break_total?", "mini tie_break_total!"]


def test_shipped_example_of_an_inconsistent_ruleset_is_refuted() -> None:
    printed = library()["tran2026_printed"]
    found = by_name(check(printed, today=TODAY, only=["consistent", "complete"]))  # type: ignore[arg-type]

    assert {each.outcome for each in found.values()} == {Outcome.REFUTED}
