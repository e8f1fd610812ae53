"""Explanations: conditions with values and margins, from either side, and what would have had to differ."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
import pytest

from ccas_core import plugins
from ccas_core.ships import ShipId
from ccas_core.tapd.case_file import parse_cases
from ccas_core.tapd.case_run import pair_facts
from ccas_core.tapd.cases import Case
from ccas_core.tapd.explanation import Row, explain, why_not
from ccas_core.tapd.facts import PairFacts
from ccas_core.tapd.written import WrittenRuleset
from ccas_core.verdict import Kind

RULESETS = plugins.load().rulesets
A, B = ShipId("A"), ShipId("B")
STATED = "encounter: {geometry: crossing, has_other_on_starboard: A}"
CASE = """\
cases:
  - id: crossing
    waterway: {{regime: {regime}}}
    {encounter}
    ships:
      A:
        kinematics: {{east_m: 0.0, north_m: -500.0, course_deg: 0.0, speed_mps: 4.0}}
        length_m: 85.0
        {a}
      B:
        kinematics: {{east_m: 530.0, north_m: 0.0, course_deg: 270.0, speed_mps: 4.0}}
        length_m: 12.0
        {b}
    expected: {{bpr: {{kind: none}}}}
"""


def ruleset(name: str = "bpr") -> WrittenRuleset:
    found = RULESETS[name]
    assert isinstance(found, WrittenRuleset)
    return found


def crossing(*, encounter: str = "", a: str = "", b: str = "", regime: str = "[]") -> Case:
    (case,) = parse_cases(CASE.format(encounter=encounter, a=a, b=b, regime=regime)).cases
    return case


def seen(case: Case, own: ShipId = A, other: ShipId = B, by: str = "bpr") -> PairFacts:
    return pair_facts(case, own, other, ruleset(by).vocabulary)


def walked(rows: Iterable[Row]) -> Iterator[Row]:
    for row in rows:
        yield row
        yield from walked(row.parts)


def rows_of(case: Case, own: ShipId = A, other: ShipId = B) -> dict[str, Row]:
    found = explain(ruleset(), seen(case, own, other))
    return {row.text: row for rule in found.rules for row in walked(rule.rows)}


def test_quantity_has_value_limit_and_margin() -> None:
    row = rows_of(crossing())["tcpa <= 900 s"]

    assert row.value is True
    assert row.reading is not None
    assert row.reading.value == pytest.approx(128.75)
    assert (row.reading.limit, row.reading.unit) == (900.0, "s")
    assert row.margin == "771.2 s inside"


def test_limit_that_is_not_met_is_told_as_outside() -> None:
    row = rows_of(crossing())["A.length < 20 m"]

    assert (row.value, row.reading and row.reading.found, row.margin) == (False, "85.0 m", "65.0 m outside")


def test_rule_reads_the_same_from_both_sides() -> None:
    case = crossing()
    mine, theirs = (explain(ruleset(), seen(case, *pair)) for pair in ((A, B), (B, A)))

    assert (mine.verdict.kind, theirs.verdict.kind) == (Kind.STAND_ON, Kind.GIVE_WAY)
    assert mine.rules[0].rule.id == theirs.rules[0].rule.id == "crossing.small-large"
    assert (mine.rules[0].own, theirs.rules[0].own) == (B, B)
    assert mine.rules[0].rows == theirs.rules[0].rows


def test_definitions_are_nested_and_negated_ones_say_not_all_of() -> None:
    large = rows_of(crossing())["large(A)"]

    (negated,) = large.parts
    assert (negated.text, negated.joined, negated.value) == ("not small(A)", "not all of", True)
    assert any(row.text == "A.length < 20 m" for row in walked(negated.parts))


def test_recognised_encounter_has_the_conditions_of_its_recognition() -> None:
    recognised, stated = rows_of(crossing()), rows_of(crossing(encounter=STATED))

    assert "dcpa <= 200 m" in recognised
    assert recognised["not from_starboard(A, B)"].found == "from starboard, courses 90.0 deg apart"
    assert "dcpa <= 200 m" not in stated
    assert stated["geometry == crossing"].parts == ()


def test_what_was_told_once_is_not_told_again() -> None:
    found = explain(ruleset(), seen(crossing()))
    approaching = [row for row in walked(found.rules[0].rows) if row.text == "approaching"]

    assert [bool(row.parts) for row in approaching] == [True, False]
    assert approaching[1].found == "as above"


def test_fact_that_is_not_known_is_marked() -> None:
    encounter = "encounter: {geometry: crossing, has_other_on_starboard: unknown}"
    case = crossing(encounter=encounter, b="tows_large: true")
    found = explain(ruleset(), seen(case))

    assert found.verdict.kind is Kind.UNKNOWN_FACT
    assert found.rules[0].value is None
    assert any(row.value is None for row in walked(found.rules[0].rows))


def test_no_rule_is_explained_by_what_was_not_recognised() -> None:
    away = CASE.replace("course_deg: 270.0", "course_deg: 90.0")
    (case,) = parse_cases(away.format(encounter="", a="", b="", regime="[]")).cases
    found = explain(ruleset(), seen(case))

    assert (found.verdict.kind, found.verdict.reason, found.rules) == (Kind.NONE, "no_risk", ())
    risk = found.recognition[0]
    assert (risk.text, risk.value) == ("risk(A, B)", False)
    assert [row.value for row in walked([risk]) if row.text == "closing"] == [False]


def test_condition_on_the_waterway_is_labelled() -> None:
    case = crossing(regime="[bpr_annex11]", b="oversize_seagoing: true")
    found = explain(ruleset(), seen(case)).rules[0]

    assert found.rule.id == "oversize-seagoing"
    first = found.rows[0]
    assert (first.label, first.text, first.value) == ("where", "regime.bpr_annex11", True)


def test_why_not_names_what_fails_and_the_rule_that_came_before() -> None:
    found = why_not(ruleset(), seen(crossing()), Kind.GIVE_WAY)
    by_rule = {miss.rule.id: miss for miss in found}

    assert [len(miss.failed) for miss in found] == sorted(len(miss.failed) for miss in found)
    nearest = by_rule["crossing.starboard-side"]
    assert [row.text for row in nearest.failed] == ["B.follows_starboard_side"]
    assert nearest.prevented_by == ""  # it stands before the rule that decided
    assert by_rule["crossing.large"].prevented_by == "crossing.small-large"
    assert all(row.value is not True for miss in found for row in miss.failed)


def test_what_why_not_asks_for_makes_the_rule_apply() -> None:
    changed = seen(crossing(b="follows_starboard_side: true"))

    verdict = ruleset().judge(changed)

    assert (verdict.kind, verdict.rule) == (Kind.GIVE_WAY, "crossing.starboard-side")


def test_rule_that_decided_holds_in_every_random_encounter() -> None:
    random = np.random.default_rng(7)
    for _ in range(25):
        east, north, course, speed = random.uniform((-800, -800, 0, 1), (800, 800, 360, 8))
        place = f"east_m: {east:.1f}, north_m: {north:.1f}, course_deg: {course:.1f}, speed_mps: {speed:.2f}"
        text = CASE.replace("east_m: 530.0, north_m: 0.0, course_deg: 270.0, speed_mps: 4.0", place)
        (case,) = parse_cases(text.format(encounter="", a="", b="", regime="[]")).cases
        for name in ("bpr", "tran2026"):
            for pair in ((A, B), (B, A)):
                found = explain(ruleset(name), seen(case, *pair, by=name))
                assert [rule.value for rule in found.rules] == ([True] if found.verdict.rule else [])
                if found.rules:
                    assert found.rules[0].rule.id == found.verdict.rule
                    assert all(row.value for row in found.rules[0].rows)
