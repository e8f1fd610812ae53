"""How well tests cover a ruleset; and that those of every ruleset that we ship cover all of it."""

from __future__ import annotations

from typing import Final

import pytest

from ccas_core.tapd.case_file import parse_cases
from ccas_core.tapd.case_run import run_case
from ccas_core.tapd.coverage import Change, covered, own_cases, reached

from . import installed, ruleset
from .rulesets import SMALL, read

TESTS = """\
tests:
  - {name: ferry, ships: {a: {ferry: true}, b: {}}, expect: {give_way: b, by: ferry}}
  - {name: wrong, ships: {a: {ferry: true}, b: {}}, expect: {give_way: a, by: ferry}}
  - {name: sail, ships: {a: {}, b: {propulsion: sail}}, expect: {give_way: a, by: sail.over-motor}}
"""


def test_rules_that_decide_a_case_are_reached_and_the_others_missed() -> None:
    rules = read(SMALL + TESTS)
    found = covered(rules, rules.text.tests)

    assert found.rules == ("ferry", "sail.over-motor", "sail.wind")
    assert reached(rules, rules.text.tests) == found.reached == {"ferry", "sail.over-motor"}
    assert found.missed == ("sail.wind",)


def test_every_rule_has_two_mutants_and_those_that_a_case_notices_are_killed() -> None:
    rules = read(SMALL + TESTS)
    mutants = {(each.rule, each.change): each for each in covered(rules, rules.text.tests).mutants}

    assert set(mutants) == {(rule.id, change) for rule in rules.text.rules for change in Change}
    assert mutants["ferry", Change.DROPPED].killed_by == "ferry"
    assert mutants["sail.over-motor", Change.DROPPED].killed_by == "sail"
    assert mutants["sail.wind", Change.DROPPED].survives


def test_case_that_fails_without_any_mutation_kills_nothing() -> None:
    rules = read(SMALL + TESTS)

    assert all(each.killed_by != "wrong" for each in covered(rules, rules.text.tests).mutants)


def test_without_cases_everything_survives() -> None:
    found = covered(read(SMALL), [])

    assert found.missed == found.rules
    assert len(found.survivors) == len(found.mutants) == 6


def test_cases_of_files_that_expect_something_of_the_ruleset_are_its_own() -> None:
    rules = read(SMALL + TESTS)
    case = "{{id: {0}, ships: {{a: {{}}, b: {{}}}}, expected: {{{0}: {{kind: none}}}}}}"
    cases = parse_cases(f"cases: [{case.format('small')}, {case.format('other')}]\n").cases

    assert [each.id for each in own_cases(rules, cases)] == ["ferry", "wrong", "sail", "small"]


# --- what we ship -----------------------------------------------------------------------------------

# Rulesets whose tests leave rules out, and why.
UNWRITTEN: Final = {"bpr": "the file has tests of the highest rank alone"}
# Rules that no test of the file can reach, and why.
UNREACHED: Final = {
    ("tran2026_printed", "line_22.increment"): "ships in a test of a file have no intersection ahead of them",
}
# Mutants that no test of the file notices, and why.
SURVIVORS: Final = {
    ("tran2026_printed", "line_22.increment", Change.DROPPED): "it is not reached, see above",
}


@pytest.mark.parametrize("name", sorted(installed()))
def test_every_test_of_a_ruleset_that_we_ship_passes(name: str) -> None:
    rules = ruleset(name)

    failed = {
        case.id: result.differences
        for case in rules.text.tests
        if not (result := run_case(rules, case, case.expected[rules.id])).passed
    }
    assert failed == {}


@pytest.mark.parametrize("name", sorted(installed()))
def test_tests_of_a_ruleset_that_we_ship_reach_every_rule_and_kill_nearly_all_mutants(name: str) -> None:
    rules = ruleset(name)
    found = covered(rules, rules.text.tests)
    if found.missed and name in UNWRITTEN:
        pytest.skip(UNWRITTEN[name])

    assert {rule for rule in found.missed if (name, rule) not in UNREACHED} == set()
    survivors = {(name, each.rule, each.change) for each in found.survivors}
    assert survivors <= SURVIVORS.keys()
    unreached = {mutant for mutant in survivors if mutant[:2] in UNREACHED}
    assert len(survivors - unreached) <= 0.05 * len(found.mutants)


def test_what_is_excepted_is_there() -> None:
    shipped = set(installed())
    for name, rule, *_ in [*UNREACHED, *SURVIVORS]:
        assert name in shipped
        assert rule in {each.id for each in ruleset(name).text.rules}
