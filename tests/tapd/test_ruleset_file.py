"""Ruleset files: every key, every refusal with its place, bases and overlays."""

from __future__ import annotations

from datetime import date
from fractions import Fraction
from itertools import product
from pathlib import Path

import pytest

from ccas_core.errors import Diagnostic, RulesetError
from ccas_core.roles import PassingSide
from ccas_core.tapd.language.formula import facts_of
from ccas_core.tapd.python_rules import PythonRule
from ccas_core.tapd.ranking import RankingCriterion
from ccas_core.tapd.rules import (
    DEFAULT_ORDER,
    Diagnosis,
    Domain,
    Mirror,
    Order,
    Outcome,
    Policy,
    Side,
    Strength,
)
from ccas_core.tapd.ruleset_file import MAX_BASES, load_ruleset, parse_ruleset
from ccas_core.verdict import Confidence, Kind

from . import stated
from .language import decided
from .rulesets import (
    ENCOUNTER,
    HEAD,
    OTHERWISE,
    RULES,
    SMALL,
    ids,
    library,
    one_finding,
    overlay,
    read,
    refused,
    with_rule,
)

# --- what a file says -------------------------------------------------------------------------------


def test_smallest_ruleset_has_these_values() -> None:
    found = read(SMALL).text

    assert (found.id, found.version, found.title) == ("small", "1.0.0", "A small ruleset")
    assert (found.regulation, found.edition) == ("RULES", "2026")
    assert (found.description, found.abstract, found.lineage) == ("", False, ())
    assert (found.policy, found.mirror) == (Policy.FIRST, Mirror.AUTO)
    assert found.resolve_by == DEFAULT_ORDER
    assert found.domain == Domain()
    assert (found.gates, found.waivers, found.tests) == ((), (), ())
    assert found.source == "small.yaml"
    assert [rule.id for rule in found.rules] == ["ferry", "sail.over-motor", "sail.wind"]
    assert found.rule("ferry") is found.rules[0]
    with pytest.raises(KeyError):
        found.rule("fery")


def test_rule_says_where_it_comes_from() -> None:
    rule = read(SMALL).text.rule("ferry")

    assert str(rule.citation) == "RULES 1"
    assert (rule.citation.version, rule.citation.confidence) == ("2026", Confidence.UNVERIFIED)
    assert (rule.source.file, rule.source.line, rule.source.column) == ("small.yaml", 13, 9)
    assert rule.source.excerpt == "  - id: ferry"
    assert (rule.origin, rule.python, rule.note, rule.because) == ("small", "", "", "")
    assert rule.outcome == Outcome(kind=Kind.STAND_ON)
    assert [part.label for part in rule.parts] == ["when"]


def test_rule_with_every_key() -> None:
    rule = read(
        with_rule("""\
id: all
cite: {article: "4", regulation: OTHER, version: "3", confidence: text_seen, text: In our words}
where: waterway.sign_a2
when:
  - own.ferry
  - own.length < 20 m
unless: own.nuc
then: give_way
strength: wait
pass: port_to_port
passing: preferred
side_chosen_by: other
must_follow: own
facilitates: other
signal: blue
manoeuvre: slow down
reason: because of this
because: "{own} waits for {other}"
note: seen in a book
""")
    ).text.rule("all")

    assert rule.outcome == Outcome(
        kind=Kind.GIVE_WAY,
        strength=Strength.WAIT,
        passing_side=PassingSide.PORT_TO_PORT,
        passing_required=False,
        side_chosen_by=Side.OTHER,
        must_follow=Side.OWN,
        facilitates=Side.OTHER,
        signal="blue",
        manoeuvre="slow down",
        reason="because of this",
    )
    assert (str(rule.citation), rule.citation.version, rule.citation.text) == ("OTHER 4", "3", "In our words")
    assert rule.citation.confidence is Confidence.TEXT_SEEN
    assert (rule.because, rule.note) == ("{own} waits for {other}", "seen in a book")
    assert [part.label for part in rule.parts] == ["where", "when", "when", "unless"]


@pytest.mark.parametrize("diagnosis", list(Diagnosis))
@pytest.mark.parametrize("then", ["conflict", "gap"])
def test_rule_may_say_what_is_wrong_with_the_regulation(then: str, diagnosis: Diagnosis) -> None:
    rules = read(
        with_rule(f'id: odd\ncite: {{article: "4"}}\nwhen: true\nthen: {then}\ndiagnosis: {diagnosis}')
    )

    assert rules.text.rule("odd").outcome == Outcome(kind=Kind(then), diagnosis=diagnosis)


def test_file_with_every_block() -> None:
    found = parse_ruleset(
        HEAD.replace('regulation: {name: RULES, version: "2026"}',
                     'regulation: {name: RULES, version: "2026", title: The rules, url: there, language: nl}')
        + """\
description: All of it
abstract: false
policy: unique
mirror: none
params:
  T: 300 s
  D: {value: 0.1 km, range: [50 m, 200 m], meaning: how near}
regimes: {tidal: where the tide runs}
let:
  near: dcpa < D and tcpa < T
  small(ship): ship.length < 20 m
gates:
  - id: tide
    when: regime.tidal
    off: [sail.*, ferry]
    cite: {article: "8"}
    note: as seen
deadlock: {resolve_by: [length descending, weight ascending, id]}
domain: {speed: [1 m/s, 10 m/s], length: [5 m, 0.2 km], separation: 100 m, assume: "own.length > 3 m"}
waivers:
  - {check: both-obliged, reason: the law itself, expires: 2027-06-30, rules: [ferry]}
tests:
  - name: a ferry stands on
    ships: {A: {ferry: true}, B: {}}
    expect: {give_way: B}
"""
        + ENCOUNTER
        + RULES
        + OTHERWISE,
        "small.yaml",
    ).text  # fmt: skip

    assert (found.description, found.policy, found.mirror) == ("All of it", Policy.UNIQUE, Mirror.NONE)
    time, near = found.parameters["T"], found.parameters["D"]
    assert (time.value, time.low, time.high, time.dimensions) == (*[Fraction(300)] * 3, (0, 1, 0, 0))
    assert [near.value, near.low, near.high] == [100, 50, 200]
    assert near.meaning == "how near"
    assert found.regimes == {"tidal": "where the tide runs"}
    assert found.definitions.keys() == {"near", "small"}
    (gate,) = found.gates
    assert (gate.id, gate.off, str(gate.citation)) == (
        "tide",
        ("sail.over-motor", "sail.wind", "ferry"),
        "RULES 8",
    )
    orders = [("length", True), ("weight", False), ("id", False)]
    assert found.resolve_by == tuple(Order(criterion=name, descending=down) for name, down in orders)
    assert [*found.domain.speed, *found.domain.length] == [1, 10, 5, 200]
    assert found.domain.separation == 100
    assert len(found.domain.assume) == 1
    (waiver,) = found.waivers
    assert (waiver.check, waiver.reason, waiver.rules) == ("both_obliged", "the law itself", ("ferry",))
    assert waiver.expires == date(2027, 6, 30)
    (case,) = found.tests
    assert (case.id, case.line) == ("a ferry stands on", 28)


# --- refusals ---------------------------------------------------------------------------------------


def edited(old: str, new: str) -> str:
    assert old in SMALL
    return SMALL.replace(old, new, 1)


END = SMALL.count("\n") + 1
REFUSALS = {
    "no schema": ("id: small\n", 1, 1, "the file does not say of which kind it is"),
    "another schema": (
        edited("ruleset@1", "ruleset@2"),
        1,
        9,
        "'ccas/ruleset@2' is not the kind that is read here",
    ),
    "not keys": ("- a\n", 1, 1, "the file holds a list"),
    "missing title": (edited("title: A small ruleset\n", ""), 1, 1, "the key 'title' is missing here"),
    "unknown key": (edited("title:", "colour: red\ntitle:"), 4, 1, "unknown key 'colour'"),
    "id": (edited("id: small", "id: Small ones"), 2, 5, "got 'Small ones'"),
    "version": (edited("1.0.0", "one"), 3, 10, "got 'one'"),
    "abstract": (SMALL + "abstract: yes\n", END, 11, "got 'yes'"),
    "policy": (SMALL + "policy: last\n", END, 9, "got 'last'"),
    "mirror": (SMALL + "mirror: both\n", END, 9, "got 'both'"),
    "regulation without version": (
        edited(', version: "2026"', ""),
        5,
        13,
        "the key 'version' is missing here",
    ),
    "citation without regulation": (
        edited('regulation: {name: RULES, version: "2026"}\n', ""),
        13,
        11,
        "a citation without regulation",
    ),
    "citation without article": (edited('{article: "1"}', "{}"), 14, 11, "the key 'article' is missing here"),
    "confidence": (edited('{article: "1"}', '{article: "1", confidence: sure}'), 14, 38, "got 'sure'"),
    "rule without cite": (edited('    cite: {article: "1"}\n', ""), 13, 5, "the key 'cite' is missing here"),
    "rule without when": (
        edited("    when: own.ferry and not other.ferry\n", ""),
        13,
        5,
        "the key 'when' is missing",
    ),
    "rule without then": (edited("    then: stand_on\n", ""), 13, 5, "the key 'then' is missing here"),
    "then": (edited("then: stand_on", "then: yield"), 16, 11, "got 'yield'"),
    "unknown_fact": (edited("then: stand_on", "then: unknown_fact"), 16, 11, "got 'unknown_fact'"),
    "strength": (edited("then: stand_on", "then: stand_on\n    strength: much"), 17, 15, "got 'much'"),
    "pass": (edited("then: stand_on", "then: stand_on\n    pass: left"), 17, 11, "got 'left'"),
    "passing": (
        edited("then: stand_on", "then: stand_on\n    passing: required"),
        17,
        14,
        "'passing' without 'pass'",
    ),
    "diagnosis": (
        edited("then: stand_on", "then: stand_on\n    diagnosis: gap"),
        17,
        16,
        "a diagnosis with 'stand_on'",
    ),
    "two places": (
        edited("then: stand_on", "then: stand_on\n    before: a\n    after: b"),
        13,
        9,
        "two places for one rule",
    ),
    "rule id": (edited("id: ferry", "id: Ferry boats"), 13, 9, "got 'Ferry boats'"),
    "second rule": (edited("id: sail.wind", "id: ferry"), 21, 9, "a second rule 'ferry'"),
    "empty list": (edited("when: own.ferry and not other.ferry", "when: []"), 15, 11, "an empty list"),
    "condition": (edited("not other.ferry", "not other.fery"), 15, 29, "unknown fact 'other.fery'"),
    "syntax": (edited("not other.ferry", "not other.ferry )"), 15, 41, "')' is not expected here"),
    "encounter key": (edited("  risk: closing", "  danger: closing"), 7, 3, "unknown key 'danger'"),
    "no risk": (edited("  risk: closing\n", ""), 7, 15, "encounters are recognised, and no risk with them"),
    "otherwise": (edited(OTHERWISE, ""), 1, 1, "nothing is said of what holds where no rule applies"),
    "no rules": (edited(RULES, ""), 1, 1, "a ruleset without rules"),
    "unknown base": (edited("title:", "extends: smal\ntitle:"), 4, 10, "unknown base 'smal'"),
    "base of itself": (edited("title:", "extends: small\ntitle:"), 4, 10, "'small' is a base of itself"),
    "removed": (SMALL + "remove: [fery]\n", END, 10, "there is no rule 'fery' to be removed"),
    "replaced": (
        edited("then: stand_on", "then: stand_on\n    replaces: fery"),
        17,
        15,
        "there is no rule 'fery' to be",
    ),
    "before": (
        edited("then: stand_on", "then: stand_on\n    before: fery"),
        17,
        13,
        "there is no rule 'fery' to be",
    ),
    "cited anew": (
        SMALL + 'citations: {fery: {article: "1"}}\n',
        END,
        13,
        "there is no rule 'fery' to be cited anew",
    ),
    "parameter unit": (SMALL + "params: {T: 300 ft}\n", END, 13, "got '300 ft'"),
    "parameter in rad": (SMALL + "params: {T: 3 rad}\n", END, 13, "got '3 rad'"),
    "parameter name": (SMALL + "params: {own: 3 m}\n", END, 10, "'own' cannot be the name of a parameter"),
    "parameter range": (
        SMALL + "params: {T: {value: 3 s, range: [4 s, 5 s]}}\n",
        END,
        21,
        "lies outside of its range",
    ),
    "parameter ranges": (
        SMALL + "params: {T: {value: 3 s, range: [5 s, 4 s]}}\n",
        END,
        33,
        "the range is empty",
    ),
    "parameter units": (
        SMALL + "params: {T: {value: 3 s, range: [1 m, 4 m]}}\n",
        END,
        33,
        "the range has another unit",
    ),
    "parameter ends": (SMALL + "params: {T: {value: 3 s, range: [1 s]}}\n", END, 33, "a list of 1"),
    "parameter digits": (SMALL + f"params: {{T: {'9' * 5000} s}}\n", END, 13, "a number beyond all measure"),
    "parameter size": (SMALL + "params: {T: 1e40 s}\n", END, 13, "a number beyond all measure"),
    "parameter smallness": (SMALL + "params: {T: 1e-40 s}\n", END, 13, "a number beyond all measure"),
    "built in": (SMALL + "params: {tcpa: 3 s}\n", END, 10, "'tcpa' cannot be defined"),
    "fact of the pair": (SMALL + "let: {geometry: own.ferry}\n", END, 17, "'geometry' cannot be defined"),
    "parameter and definition": (
        SMALL + "params: {T: 3 s}\nlet: {T: own.ferry}\n",
        END + 1,
        10,
        "'T' is a parameter and a definition",
    ),
    "definition name": (SMALL + 'let: {"a b": own.ferry}\n', END, 7, "'a b' cannot be defined"),
    "definition word": (SMALL + "let: {and: own.ferry}\n", END, 7, "'and' cannot be defined"),
    "definition ships": (
        SMALL + 'let: {"a(s, t, u)": own.ferry}\n',
        END,
        7,
        "'a(s, t, u)' cannot be defined",
    ),
    "definition twice": (
        SMALL + 'let: {"a(s)": s.ferry, a: own.ferry}\n',
        END,
        24,
        "a second definition 'a'",
    ),
    "definition of one ship twice": (
        SMALL + 'let: {"a(s, s)": s.ferry}\n',
        END,
        7,
        "'a(s, s)' cannot be defined",
    ),
    "definition no ship": (SMALL + 'let: {"a()": own.ferry}\n', END, 7, "'a()' cannot be defined"),
    "definition syntax": (SMALL + "let: {a: own.ferry or}\n", END, 22, "the end is not expected here"),
    "definition fault": (SMALL + "let: {a: own.fery}\n", END, 10, "unknown fact 'own.fery'"),
    "ring": (SMALL + "let: {a: b, b: a}\n", END, 10, "'b' is defined by itself: b -> a -> b"),
    "regime": (edited("own.ferry and", "regime.tidal and"), 15, 11, "unknown regime 'tidal'"),
    "regime name": (SMALL + 'regimes: {"a b": x}\n', END, 11, "'a b' cannot be the name of a regime"),
    "gate": (
        SMALL + 'gates: [{id: g, when: own.ferry, off: fery, cite: {article: "1"}}]\n',
        END,
        39,
        "no rule 'fery' to switch off",
    ),
    "gate stem": (
        SMALL + 'gates: [{id: g, when: own.ferry, off: fer.*, cite: {article: "1"}}]\n',
        END,
        39,
        "no rule 'fer.*'",
    ),
    "gate without off": (
        SMALL + 'gates: [{id: g, when: own.ferry, cite: {article: "1"}}]\n',
        END,
        9,
        "the key 'off' is missing",
    ),
    "where": (
        edited("when: own.ferry", "where: own.nuc\n    when: own.ferry"),
        15,
        12,
        "'where' is about waters only",
    ),
    "unless": (
        edited("then: stand_on", "unless: {unless: own.nuc}\n    then: stand_on"),
        16,
        13,
        "the key 'when' is missing",
    ),
    "python": (edited("then: stand_on", "python: mine"), 16, 13, "unknown Python rule 'mine'"),
    "python and then": (
        edited("then: stand_on", "then: stand_on\n    python: mine"),
        16,
        5,
        "unknown key 'then'",
    ),
    "criterion": (SMALL + "deadlock: {resolve_by: [colour]}\n", END, 25, "unknown criterion 'colour'"),
    "criterion words": (SMALL + "deadlock: {resolve_by: [length down]}\n", END, 25, "this is no criterion"),
    "no criteria": (SMALL + "deadlock: {resolve_by: []}\n", END, 24, "a list of 0"),
    "domain": (SMALL + "domain: {speed: [1 m, 2 m]}\n", END, 17, "the range has another unit"),
    "separation": (SMALL + "domain: {separation: 3 s}\n", END, 22, "this is no length"),
    "waiver rule": (
        SMALL + "waivers: [{check: gap, reason: x, expires: 2027-01-01, rules: [fery]}]\n",
        END,
        64,
        "no rule 'fery' here",
    ),
    "waiver day": (SMALL + "waivers: [{check: gap, reason: x, expires: soon}]\n", END, 44, "got 'soon'"),
    "waiver without reason": (
        SMALL + "waivers: [{check: gap, expires: 2027-01-01}]\n",
        END,
        11,
        "the key 'reason' is missing",
    ),
    "test without ships": (
        SMALL + "tests: [{name: a, expect: {kind: none}}]\n",
        END,
        9,
        "the key 'ships' is missing here",
    ),
    "yaml": (SMALL + "a: [\n", END + 1, 1, "not YAML"),
    "tab": (SMALL + "\tx: 3\n", END, 1, "a tab in the indentation"),
}


@pytest.mark.parametrize("name", REFUSALS)
def test_fault_is_told_with_its_place(name: str) -> None:
    text, line, column, message = REFUSALS[name]

    found = refused(text)

    (told, *_) = [each for each in found if (each.line, each.column) == (line, column)] or found
    assert (told.source, told.line, told.column) == ("small.yaml", line, column), str(told)
    assert message in told.message
    if told.line <= len(text.split("\n")) and "not YAML" not in message:
        assert told.excerpt.startswith(text.split("\n")[told.line - 1].rstrip()[:40].replace("\t", " "))


def test_number_without_unit_is_a_parameter_without_unit() -> None:
    found = read(SMALL + "params: {T: 300, S: {value: -1.5e2, range: [-200, 0]}}\n").text.parameters

    assert found["T"].dimensions == (0, 0, 0, 0)
    assert found["S"].value == Fraction(-150)


def test_fault_in_a_condition_is_underlined() -> None:
    finding = one_finding(edited("not other.ferry", "not other.fery"))

    assert str(finding).split("\n")[:3] == [
        "small.yaml:15:29: unknown fact 'other.fery'",
        " 15 |     when: own.ferry and not other.fery",
        "    |                             ^^^^^^^^^^",
    ]
    assert finding.hint == "did you mean 'other.ferry'?"


def test_fault_in_a_quoted_condition_is_underlined() -> None:
    finding = one_finding(edited("own.ferry and not other.ferry", '"own.ferry and not other.fery"'))

    assert (finding.line, finding.column, finding.width) == (15, 30, len("other.fery"))


def test_fault_in_a_condition_of_several_lines_is_found_where_it_stands() -> None:
    finding = one_finding(
        edited("own.ferry and not other.ferry", ">-\n      own.ferry\n      and not other.fery")
    )

    assert (finding.line, finding.column, finding.width) == (17, 15, len("other.fery"))


def test_all_faults_are_told_at_once_in_the_order_of_the_file() -> None:
    text = (
        edited("then: stand_on", "then: yield")
        .replace("other.wind_side == starboard", "other.wind_sid == starboard")
        .replace("risk: closing", "risk: closin")
        .replace("title: A small ruleset", "titel: A small ruleset")
    )

    found = refused(text)

    assert [each.line for each in found] == sorted(each.line for each in found)
    assert [each.message for each in found if each.line in (4, 16)] == ["unknown key 'titel'", "got 'yield'"]


def test_all_faults_of_conditions_are_told_at_once() -> None:
    text = (
        edited("not other.ferry", "not other.fery")
        .replace("other.wind_side == starboard", "other.wind_sid == starboard")
        .replace("risk: closing", "risk: closin")
        + "let: {a: own.lenght < 3 m, b: a}\nremove: [x]\n"
    )

    assert [each.line for each in refused(text)] == [7, 15, 23, END, END + 1]


def test_definition_that_is_wrong_is_told_once_however_often_it_is_asked_for() -> None:
    text = (
        edited("own.ferry and not other.ferry", "a and b") + "let: {a: own.lenght < 3 m, b: a or c, c: a}\n"
    )

    assert one_finding(text).message == "unknown fact 'own.lenght'"


def test_broken_rule_makes_the_whole_ruleset_unavailable(tmp_path: Path) -> None:
    path = tmp_path / "small.yaml"
    path.write_text(edited("not other.ferry", "not other.fery"))

    with pytest.raises(RulesetError) as caught:
        load_ruleset(path)
    assert caught.value.diagnostics[0].source == str(path)
    path.write_text(SMALL)
    assert load_ruleset(path).id == "small"


# --- exceptions and gates ---------------------------------------------------------------------------


def test_exceptions_have_exceptions() -> None:
    text = with_rule("""\
id: x
cite: {article: "4"}
when: own.ferry
unless:
  - own.nuc
  - when: own.ram
    cite: {article: "5"}
    unless:
      - {when: own.convoy, unless: other.nuc}
then: give_way
""")
    rule = read(text).text.rule("x")

    assert [part.label for part in rule.parts] == ["when", "unless", "unless"]
    assert facts_of(rule.condition) == {"own.ferry", "own.nuc", "own.ram", "own.convoy", "other.nuc"}
    for ferry, nuc, ram, convoy, other_nuc in product((True, False), repeat=5):
        facts = stated({"ferry": ferry, "nuc": nuc, "ram": ram, "convoy": convoy}, {"nuc": other_nuc})
        excepted = nuc or (ram and not (convoy and not other_nuc))
        assert decided(rule.condition, facts) is (ferry and not excepted)


def test_gate_switches_rules_off_by_name_and_by_the_beginning_of_a_name() -> None:
    text = (
        SMALL
        + """\
gates:
  - {id: calm, when: own.nuc, off: sail.*, cite: {article: "8"}}
  - {id: quiet, when: waterway.sign_a2, off: [ferry, sail.wind], cite: {article: "8"}}
"""
    )
    rules = read(text).text

    labels = {rule.id: [part.label for part in rule.parts] for rule in rules.rules}
    assert labels == {
        "ferry": ["when", "gate quiet"],
        "sail.over-motor": ["when", "gate calm"],
        "sail.wind": ["when", "gate calm", "gate quiet"],
    }
    assert "own.nuc" in facts_of(rules.rule("sail.wind").condition)


# --- bases ------------------------------------------------------------------------------------------


def test_overlay_takes_all_that_it_does_not_say_from_its_base() -> None:
    base = (
        SMALL + "params: {T: 3 s}\nlet: {a: own.ferry}\nregimes: {tidal: x}\npolicy: unique\nmirror: none\n"
    )
    base += "deadlock: {resolve_by: [length]}\ndomain: {speed: [1 m/s, 2 m/s], assume: own.length > 3 m}\n"

    found = read(overlay(), small=base).text

    assert (found.id, found.lineage, found.regulation, found.edition) == ("over", ("small",), "OVER", "7")
    assert [rule.id for rule in found.rules] == ["ferry", "sail.over-motor", "sail.wind"]
    assert all(rule.origin == "small" for rule in found.rules)
    assert (found.policy, found.mirror) == (Policy.UNIQUE, Mirror.NONE)
    assert found.parameters["T"].value == 3
    assert found.definitions.keys() == {"a"}
    assert found.regimes.keys() == {"tidal"}
    assert found.resolve_by == (Order(criterion="length"),)
    assert list(found.domain.speed) == [1, 2]
    assert len(found.domain.assume) == 1
    assert str(found.otherwise) == "RULES 9"
    assert found.recognition is not None


RULE = '{{id: new, cite: {{article: "5"}}, when: own.nuc, then: give_way{}}}'


@pytest.mark.parametrize(
    ("place", "order"),
    [
        (", before: ferry", ["new", "ferry", "sail.over-motor", "sail.wind"]),
        (", after: ferry", ["ferry", "new", "sail.over-motor", "sail.wind"]),
        (", before: sail.wind", ["ferry", "sail.over-motor", "new", "sail.wind"]),
        (", after: sail.wind", ["ferry", "sail.over-motor", "sail.wind", "new"]),
        (", replaces: sail.over-motor", ["ferry", "new", "sail.wind"]),
    ],
)
def test_overlay_puts_rules_between_those_of_its_base(place: str, order: list[str]) -> None:
    rules = read(overlay(f"rules: [{RULE.format(place)}]\n"), small=SMALL)

    assert ids(rules) == order
    assert rules.text.rule("new").origin == "over"
    assert str(rules.text.rule("new").citation) == "OVER 5"


def test_rules_that_name_no_place_follow_the_one_before_them() -> None:
    second = RULE.format("").replace("id: new", "id: newer")

    rules = read(overlay(f"rules: [{RULE.format(', after: ferry')}, {second}]\n"), small=SMALL)

    assert ids(rules) == ["ferry", "new", "newer", "sail.over-motor", "sail.wind"]


def test_rule_of_the_same_name_replaces_that_of_the_base() -> None:
    again = RULE.format(", replaces: ferry").replace("id: new", "id: ferry")

    rules = read(overlay(f"rules: [{again}]\n"), small=SMALL)

    assert ids(rules) == ["ferry", "sail.over-motor", "sail.wind"]
    assert (rules.text.rule("ferry").origin, str(rules.text.rule("ferry").citation)) == ("over", "OVER 5")


def test_overlay_removes_rules_and_cites_others_anew() -> None:
    rules = read(
        overlay('remove: sail.wind\ncitations: {ferry: {article: "77", confidence: text_seen}}\n'),
        small=SMALL,
    )

    assert ids(rules) == ["ferry", "sail.over-motor"]
    assert str(rules.text.rule("ferry").citation) == "OVER 77"
    assert str(rules.text.rule("sail.over-motor").citation) == "RULES 2"


def test_rule_that_is_removed_may_be_written_anew() -> None:
    again = RULE.format(", after: sail.wind").replace("id: new", "id: ferry")

    assert ids(read(overlay(f"remove: [ferry]\nrules: [{again}]\n"), small=SMALL))[-1] == "ferry"


@pytest.mark.parametrize(
    ("rest", "message", "line"),
    [
        (f"rules: [{RULE.format('')}]\n", "where in the ladder of the base does 'new' stand?", 7),
        (f"rules: [{RULE.format(', before: fery')}]\n", "there is no rule 'fery' to be found", 7),
        (f"rules: [{RULE.format(', after: fery')}]\n", "there is no rule 'fery' to be found", 7),
        (f"rules: [{RULE.format(', replaces: fery')}]\n", "there is no rule 'fery' to be replaced", 7),
        (
            f"rules: [{RULE.format(', before: ferry').replace('id: new', 'id: ferry')}]\n",
            "the base has a rule 'ferry' already",
            7,
        ),
        (
            f"rules: [{RULE.format(', replaces: sail.wind').replace('id: new', 'id: ferry')}]\n",
            "the base has a rule 'ferry' already",
            7,
        ),
        ("remove: [ferry, fery]\n", "there is no rule 'fery' to be removed", 7),
    ],
)
def test_overlay_that_does_not_fit_its_base_is_refused(rest: str, message: str, line: int) -> None:
    finding = one_finding(overlay(rest), small=SMALL)

    assert message in finding.message
    assert (finding.source, finding.line) == ("small.yaml", line)


def test_definitions_and_parameters_of_the_overlay_hold_in_the_rules_of_the_base() -> None:
    base = edited("own.ferry and not other.ferry", "special(own) and tcpa < T") + (
        "let: {special(ship): ship.ferry}\nparams: {T: 3 s}\n"
    ).replace("{special(ship): ship.ferry}", '{"special(ship)": ship.ferry}')
    over = overlay('let: {"special(ship)": ship.nuc}\nparams: {T: 9 s}\n')

    found = read(over, small=base).text

    assert "own.nuc" in facts_of(found.rule("ferry").condition)
    assert found.parameters["T"].value == 9
    assert "own.ferry" in facts_of(read(base).text.rule("ferry").condition)


def test_overlay_that_breaks_a_rule_of_its_base_is_refused_where_the_rule_stands() -> None:
    base = edited("own.ferry and not other.ferry", "tcpa < T") + "params: {T: 3 s}\n"

    finding = one_finding(overlay("params: {T: 3 m}\n"), small=base)

    assert (finding.source, finding.line) == ("small.yaml", 15)
    assert "a time is compared with a length" in finding.message


def test_overlay_recognises_encounters_in_its_own_way_key_by_key() -> None:
    found = read(overlay("encounter: {risk: tcpa < 60 s}\n"), small=SMALL).text.recognition
    before = read(SMALL).text.recognition

    assert found is not None
    assert before is not None
    assert found.risk != before.risk
    assert (found.overtaking, found.head_on) == (before.overtaking, before.head_on)


def test_base_that_is_only_there_to_be_extended_needs_no_rules() -> None:
    base = HEAD + "abstract: true\n" + ENCOUNTER

    assert read(base).text.abstract
    found = read(overlay(RULES + OTHERWISE), small=base).text
    assert not found.abstract
    assert [rule.id for rule in found.rules] == ["ferry", "sail.over-motor", "sail.wind"]


def test_bases_have_bases() -> None:
    middle = overlay(f"rules: [{RULE.format(', before: ferry')}]\n").replace("id: over", "id: middle")
    found = read(overlay("remove: [ferry]\n", base="middle"), small=SMALL, middle=middle).text

    assert found.lineage == ("middle", "small")
    assert [rule.id for rule in found.rules] == ["new", "sail.over-motor", "sail.wind"]


def test_base_in_the_middle_that_does_not_fit_its_own_base_makes_all_unavailable() -> None:
    """Such a fault shows only when the one is put on the other."""
    middle = overlay(f"rules: [{RULE.format(', before: fery')}]\n").replace("id: over", "id: middle")

    finding = one_finding(overlay(base="middle"), small=SMALL, middle=middle)

    assert (finding.source, finding.line) == ("middle.yaml", 7)
    assert "there is no rule 'fery' to be found" in finding.message


def test_ring_of_bases_is_refused() -> None:
    one = overlay(base="two").replace("id: over", "id: one")
    two = overlay(base="one").replace("id: over", "id: two")

    finding = one_finding(one, one=one, two=two)

    assert finding.message == "'one' is a base of itself"


def test_endless_row_of_bases_is_refused() -> None:
    texts = {
        f"r{n}": overlay(base=f"r{n + 1}").replace("id: over", f"id: r{n}") for n in range(MAX_BASES + 3)
    }

    assert "is a base of itself" in one_finding(texts["r0"], None, **texts).message


def test_base_that_cannot_be_used_is_told_where_it_is_named() -> None:
    finding = one_finding(overlay(), small=edited("then: stand_on", "then: yield"))

    assert (finding.line, finding.column, finding.width) == (5, 10, 5)
    assert (
        "the base 'small' cannot be used: 1 finding(s), first small.yaml:16:11: got 'yield'"
        in finding.message
    )


def test_base_is_found_in_a_file_beside(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text(SMALL)
    (tmp_path / "over.yaml").write_text(overlay(base="base.yaml"))

    assert load_ruleset(tmp_path / "over.yaml").text.lineage == ("small",)


@pytest.mark.parametrize("name", ["other.yaml", f"{'x' * 300}.yaml", "over.yaml"])
def test_base_that_is_no_file_beside_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / "over.yaml"
    path.write_text(overlay(base=name))

    with pytest.raises(RulesetError) as caught:
        load_ruleset(path)
    (finding,) = caught.value.diagnostics
    assert (finding.line, finding.column) == (5, 10)


def test_base_without_a_library_is_refused() -> None:
    with pytest.raises(RulesetError, match="unknown base 'small'"):
        parse_ruleset(overlay(), "over.yaml")


# --- what plugins offer -----------------------------------------------------------------------------


def test_rule_in_python_and_criterion_are_those_of_plugins() -> None:
    text = edited("then: stand_on", "python: mine") + "deadlock: {resolve_by: [draught descending, id]}\n"
    python = {"mine": PythonRule("mine", lambda pair: None)}
    criteria = {"draught": RankingCriterion("draught", lambda ship: 3.0)}

    rules = parse_ruleset(text, "small.yaml", library(), python=python, criteria=criteria)

    assert rules.text.rule("ferry").python == "mine"
    assert rules.text.resolve_by[0] == Order(criterion="draught", descending=True)
    finding = one_finding(text, {"python": python})
    assert finding.message == "unknown criterion 'draught'"
    finding = one_finding(text, {"python": {"min": python["mine"]}, "criteria": criteria})
    assert (finding.message, finding.hint) == ("unknown Python rule 'mine'", "did you mean 'min'?")


def test_rule_in_python_needs_no_condition() -> None:
    text = edited("    when: own.ferry and not other.ferry\n    then: stand_on", "    python: mine")
    python = {"mine": PythonRule("mine", lambda pair: None)}

    assert parse_ruleset(text, "small.yaml", python=python).text.rule("ferry").parts == ()


def test_findings_are_values_with_a_place() -> None:
    for finding in refused(edited("then: stand_on", "then: yield")):
        assert isinstance(finding, Diagnostic)
        assert finding.line > 0 < finding.column
