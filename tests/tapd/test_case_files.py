"""Cases from files: encounter files with units in their keys, tests of rulesets with units beside numbers."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from ccas_core.errors import Diagnostic, RulesetError
from ccas_core.ships import UNKNOWN
from ccas_core.strict_yaml import Reader
from ccas_core.tapd.case_file import CaseFile, is_case_file, load_cases, parse_cases
from ccas_core.tapd.case_run import case_of, run_case
from ccas_core.tapd.cases import Case, Expected
from ccas_core.units import DEGREE
from ccas_core.verdict import Confidence

from . import A, B, C
from .rulesets import SMALL, read, refused

CASE = """\
cases:
  - id: one
    title: A ferry and another
    note: as seen
    tags: [ferry, sail]
    waterway: {type: canal, width_m: 80, current: none}
    ships:
      a: {length_m: 12.5, ferry: true, wind_side: unknown}
      b: {propulsion: sail, weight_t: 3}
    encounter: {geometry: crossing, has_other_on_starboard: a}
    expected:
      small: {kind: give_way, give_way: b, stand_on: [a], article: "RULES 1", confidence: text_seen}
"""
PLACED = """\
cases:
  - id: placed
    ships:
      a: {kinematics: {north_m: 1, east_m: -2.5, course_deg: 90, speed_mps: 3, heading_deg: 80}}
      b: {kinematics: {north_m: 100, east_m: 0, course_deg: 180, speed_mps: 0}}
    expected: {small: {kind: none, reason: no_risk}}
"""
DEFAULTS = """\
schema_version: 1
about: x
conventions: {}
rulesets: {}
defaults: {ship: {length_m: 7, propulsion: sail}, waterway: {current: downstream}}
golden_cases:
  - {id: one, ships: {a: {propulsion: motor}, b: {}}, expected: {small: {kind: none}}}
hard_cases:
  - id: two
    ships: {a: {}, b: {}, c: {}}
    resolution: {order: [a, b, c], note: x}
    expected: {small: {diagnosis: cycle, gives_way_to: [[a, b], [b, c]], mutual: [[c, a]], cycle: [a, b, c]}}
  - {id: three, expected: {small: {diagnosis: gap, and: so on}}}
"""


def only(text: str) -> Case:
    found = parse_cases(text)
    assert found.findings == ()
    (case,) = found.cases
    return case


def finding(text: str) -> Diagnostic:
    (told, *_) = parse_cases(text).findings
    return told


# --- encounter files --------------------------------------------------------------------------------


def test_case_has_what_the_file_says() -> None:
    case = only(CASE)

    assert (case.id, case.title, case.tags, case.hard, case.line) == (
        "one",
        "A ferry and another",
        ("ferry", "sail"),
        False,
        2,
    )
    a, b = case.ships
    assert (a.id, a.facts, a.pose, a.speed) == (
        A,
        {"length": 12.5, "ferry": True, "wind_side": UNKNOWN},
        None,
        None,
    )
    assert (b.id, b.facts) == (B, {"propulsion": "sail", "weight": 3000.0})
    assert case.waterway == {"type": "canal", "width": 80.0, "current": "none"}
    assert case.encounter == {
        "risk_of_collision": True,
        "geometry": "crossing",
        "has_other_on_starboard": A,
        "overtaker": "none",
    }
    assert case.expected == {
        "small": Expected(
            kind="give_way",
            give_way=frozenset({B}),
            stand_on=frozenset({A}),
            article="RULES 1",
            confidence=Confidence.TEXT_SEEN,
        )
    }
    assert case.expected["small"].required


def test_place_of_a_ship_is_read_with_its_heading() -> None:
    a, b = only(PLACED).ships

    assert a.pose == (1.0, -2.5, 90 * DEGREE)
    assert (a.speed, b.speed) == (3.0, 0.0)
    assert a.facts["heading"] == pytest.approx(80 * DEGREE)


def test_defaults_and_kinds_of_cases() -> None:
    found = parse_cases(DEFAULTS)
    one, two, three = found.cases

    assert (found.findings, found.broken) == ((), ())
    assert [ship.facts for ship in one.ships] == [
        {"length": 7.0, "propulsion": "motor"},
        {"length": 7.0, "propulsion": "sail"},
    ]
    assert one.waterway == {"current": "downstream"}
    assert (one.hard, two.hard) == (False, True)
    expected = two.expected["small"]
    assert expected.gives_way_to == frozenset({(A, B), (B, C)})
    assert expected.mutual == frozenset({frozenset((C, A))})
    assert (expected.cycle, expected.order) == (frozenset((A, B, C)), (A, B, C))
    assert (three.ships, three.expected["small"].diagnosis) == ((), "gap")


@pytest.mark.parametrize(
    ("word", "required"),
    [("text_seen", True), ("secondary_seen", True), ("derived", False), ("unverified", False)],
)
def test_expectation_that_rests_on_no_source_is_not_required(word: str, required: bool) -> None:
    assert only(CASE.replace("text_seen", word)).expected["small"].required is required


@pytest.mark.parametrize(
    ("words", "kind"),
    [("give_way: a", "give_way"), ("give_way: [a, b]", "mutual"), ("kind: gap, give_way: []", "gap")],
)
def test_kind_follows_from_who_gives_way(words: str, kind: str) -> None:
    text = PLACED.replace("{kind: none, reason: no_risk}", f"{{{words}}}")

    assert only(text).expected["small"].kind == kind


@pytest.mark.parametrize("geometry", ["head_on", "crossing", "overtaking", "none", "unknown"])
def test_what_a_geometry_excludes_is_none(geometry: str) -> None:
    text = CASE.replace("geometry: crossing, has_other_on_starboard: a", f"geometry: {geometry}")
    found = only(text).encounter

    assert found["geometry"] == (UNKNOWN if geometry == "unknown" else geometry)
    assert ("overtaker" in found) is (geometry in ("head_on", "crossing", "none"))
    assert ("has_other_on_starboard" in found) is (geometry in ("head_on", "overtaking", "none"))


REFUSED = {
    "fact": (CASE, "ferry: true", "fery: true", 8, 27, "unknown fact of a ship 'fery'"),
    "fact of the waterway": (CASE, "current:", "curent:", 6, 42, "unknown fact of a waterway 'curent'"),
    "fact without its unit": (CASE, "length_m:", "length:", 8, 11, "unknown fact of a ship 'length'"),
    "flag": (CASE, "ferry: true", "ferry: yes", 8, 34, "got 'yes'"),
    "choice": (CASE, "propulsion: sail", "propulsion: oars", 9, 23, "unknown value of 'propulsion' 'oars'"),
    "number": (CASE, "12.5", "long", 8, 21, "'length' is a number"),
    "infinite number": (CASE, "12.5", ".inf", 8, 21, "'length' is a number"),
    "number with unit": (CASE, "12.5", "12.5 m", 8, 21, "'length' is a number"),
    "key": (CASE, "title:", "titel:", 3, 5, "unknown key 'titel'"),
    "no id": (CASE, "id: one", "tags: []", 2, 5, "the key 'id' is missing"),
    "no expectation": (CASE, "expected:", "note:", 2, 5, "the key 'expected' is missing"),
    "geometry": (CASE, "geometry: crossing", "geometry: meeting", 10, 27, "got 'meeting'"),
    "ship of the encounter": (CASE, "on_starboard: a", "on_starboard: c", 10, 61, "unknown ship 'c'"),
    "encounter key": (
        CASE,
        "encounter: {geometry",
        "encounter: {shape: x, geometry",
        10,
        17,
        "unknown key 'shape'",
    ),
    "ship expected": (CASE, "give_way: b", "give_way: c", 12, 41, "unknown ship 'c'"),
    "kind": (CASE, "kind: give_way", "kind: yield", 12, 21, "got 'yield'"),
    "expected key": (CASE, "kind: give_way", "sort: give_way", 12, 15, "unknown key 'sort'"),
    "nothing expected": (PLACED, "{kind: none, reason: no_risk}", "{}", 6, 23, "nothing is expected"),
    "diagnosis": (PLACED, "kind: none", "diagnosis: bad", 6, 35, "unknown diagnosis 'bad'"),
    "one ship": (
        PLACED,
        "      b: {kinematics: {north_m: 100, east_m: 0, course_deg: 180, speed_mps: 0}}\n",
        "",
        4,
        7,
        "1 ship(s)",
    ),
    "partly placed": (PLACED, "course_deg: 180, ", "", 5, 23, "the key 'course_deg' is missing here"),
    "placed oddly": (PLACED, "speed_mps: 0", "speed_mps: fast", 5, 77, "this is no finite number"),
    "placed with more": (PLACED, "speed_mps: 0", "speed_mps: 0, wind: 3", 5, 80, "unknown key 'wind'"),
    "list of a pair": (DEFAULTS, "[[a, b], [b, c]]", "[[a], [b, c]]", 12, 57, "a list of 1"),
    "default": (DEFAULTS, "length_m: 7", "length: 7", 5, 19, "unknown fact of a ship 'length'"),
    "top key": (DEFAULTS, "about: x", "abuot: x", 2, 1, "unknown key 'abuot'"),
    "ships": (CASE, "      b: {propulsion: sail, weight_t: 3}\n", "      b: none\n", 9, 10, "got 'none'"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_fault_is_told_with_its_place(name: str) -> None:
    text, old, new, line, column, message = REFUSED[name]
    assert old in text

    found = parse_cases(text.replace(old, new, 1))

    assert [
        each
        for each in found.findings
        if (each.line, each.column) == (line, column) and message in each.message
    ], [str(each) for each in found.findings]


def test_second_case_of_a_name_is_refused() -> None:
    assert "a second case 'one'" in finding(CASE + CASE.removeprefix("cases:\n")).message


def test_case_with_a_fault_does_not_hinder_the_others() -> None:
    text = CASE.replace("ferry: true", "fery: true") + PLACED.removeprefix("cases:\n")
    found = parse_cases(text)

    assert [case.id for case in found.cases] == ["placed"]
    assert found.broken == ("one",)
    assert len(found.findings) == 1


@pytest.mark.parametrize("text", ["- a\n", "3\n", ""])
def test_file_without_keys_is_refused(text: str) -> None:
    with pytest.raises(RulesetError):
        parse_cases(text)


def test_file_without_cases_is_told() -> None:
    assert finding("about: x\n").message == "the file holds no cases"


def test_cases_are_read_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "cases.yaml"
    path.write_text(CASE)

    found = load_cases(path)

    assert isinstance(found, CaseFile)
    assert (found.source, found.cases[0].source) == (str(path), str(path))


@pytest.mark.parametrize(
    ("text", "is_one"),
    [(CASE, True), (DEFAULTS, True), (SMALL, False), ("schema: x\ncases: []\n", False), ("- a\n", False)],
)
def test_encounter_file_is_known_by_its_keys(text: str, is_one: bool) -> None:
    assert is_case_file(Reader(text, "file.yaml", RulesetError)) is is_one


# --- tests of rulesets ------------------------------------------------------------------------------

TESTS = """\
tests:
  - name: placed
    waterway: {type: canal, width: 80 m}
    ships:
      a: {at: [10 m, 0.2 km], course: 90 deg, speed: 7.2 km/h, length: 12 m, weight: 3 t, heading: 80 deg}
      b: {at: [0 m, 0 m], course: 0 deg, speed: 0 m/s, passengers_max: 12}
    expect: {kind: unknown_fact}
  - name: stated
    encounter: {geometry: overtaking, overtaker: b, risk_of_collision: true, windward: a}
    ships: {a: {ferry: true}, b: {}}
    expect: {give_way: b, by: ferry}
"""


def test_test_of_a_ruleset_has_units_beside_its_numbers() -> None:
    placed, stated = read(SMALL + TESTS).text.tests

    a, b = placed.ships
    assert a.pose is not None
    assert a.pose == pytest.approx((200.0, 10.0, math.pi / 2))
    assert a.speed == pytest.approx(2.0)
    assert a.facts == {"length": 12.0, "weight": 3000.0, "heading": pytest.approx(80 * DEGREE)}
    assert b.facts == {"passengers_max": 12.0}
    assert placed.waterway == {"type": "canal", "width": 80.0}
    assert stated.encounter["overtaker"] == B
    assert stated.encounter["windward"] == A
    assert stated.expected["small"].rule == "ferry"


TEST_FAULTS = {
    "number without unit": ("length: 12 m", "length: 12", 5, "'12' has no unit"),
    "another unit": ("length: 12 m", "length: 12 s", 5, "'12 s' is a time, not a length"),
    "key with unit": ("length: 12 m", "length_m: 12", 5, "unknown fact of a ship 'length_m'"),
    "partly placed": ("course: 0 deg, ", "", 6, "a ship that is only partly placed"),
    "place": ("at: [0 m, 0 m]", "at: [0 m]", 6, "a list of 1"),
    "speed": ("speed: 0 m/s", "speed: 900 m/s", 6, "is out of range"),
    "no name": ("name: placed", "note: placed", 2, "the key 'name' is missing"),
    "second name": ("name: stated", "name: placed", 8, "a second test 'placed'"),
    "no expectation": ("    expect: {kind: unknown_fact}\n", "", 2, "the key 'expect' is missing"),
    "hint of an encounter file": ("windward: a", "tcpa_s: 3", 9, "unknown key 'tcpa_s'"),
}


@pytest.mark.parametrize("name", TEST_FAULTS)
def test_fault_in_a_test_of_a_ruleset_makes_it_unavailable(name: str) -> None:
    old, new, line, message = TEST_FAULTS[name]
    assert old in TESTS

    found = refused(SMALL + TESTS.replace(old, new, 1))

    place = SMALL.count("\n") + line
    assert [each for each in found if each.line == place and message in each.message], [
        str(each) for each in found
    ]


# --- run --------------------------------------------------------------------------------------------


def test_cases_of_both_kinds_are_run_in_the_same_way() -> None:
    rules = read(SMALL + TESTS)
    for case in [*rules.text.tests, only(CASE)]:
        result = run_case(rules, case, case.expected["small"])
        assert result.passed, (case.id, result.differences)


def test_difference_is_told() -> None:
    rules = read(SMALL)
    case = only(CASE.replace("give_way: b, stand_on: [a]", "give_way: a, stand_on: [b]"))

    result = run_case(rules, case, case.expected["small"])

    assert result.differences == ("give_way: expected a, got b", "stand_on: expected b, got a")


def test_case_without_ships_is_skipped() -> None:
    case = parse_cases(DEFAULTS).cases[2]

    assert run_case(read(SMALL), case, case.expected["small"]).judged is None


def test_group_of_ships_is_restricted_to_a_pair() -> None:
    case = parse_cases(DEFAULTS).cases[1]

    assert [ship.id for ship in case_of(case, A, B).ships] == [A, B]
