"""Remarks and codes: every page says what is so, and its examples do what they say."""

from __future__ import annotations

import re
from collections.abc import Iterable
from datetime import date

import pytest

from ccas_core.errors import Diagnostic, RulesetError
from ccas_core.strict_yaml import Reader
from ccas_core.tapd.case_file import parse_cases
from ccas_core.tapd.code_pages import CodePage, code_pages, coded
from ccas_core.tapd.lint import case_remarks, reviewed
from ccas_core.tapd.ruleset_file import parse_ruleset

TODAY = date(2026, 6, 1)
PAGES = code_pages()
EXAMPLE = """\
schema: ccas/ruleset@1
id: example
version: 1.0.0
title: Example
regulation: {name: Example, version: "1"}
let:
  crossing: geometry == crossing
rules:
  - id: a
    cite: {article: "1", confidence: text_seen}
    when: crossing and has_other_on_starboard == own
    then: give_way
otherwise: {cite: {article: "9", confidence: text_seen}}
tests:
  - name: the ship from port gives way
    encounter: {geometry: crossing, has_other_on_starboard: A}
    ships: {A: {length: 50 m}, B: {length: 50 m}}
    expect: {give_way: A, by: a}
"""
BASE = """\
schema: ccas/ruleset@1
id: base
version: 1.0.0
title: Base
abstract: true
regulation: {name: There, version: "1"}
rules:
  - {id: base.one, when: own.ferry, then: give_way, cite: {article: "1", confidence: text_seen}}
  - {id: base.two, when: own.nuc, then: stand_on, cite: {article: "2", confidence: text_seen}}
"""


def library(id_: str) -> tuple[str, str]:
    return {"base": (BASE, "base.yaml")}[id_]


def blocks(text: str) -> dict[str, str]:
    """Pieces of a file by their first keys."""
    pieces = re.split(r"^(?=[a-z_]+:)", text, flags=re.MULTILINE)
    return {piece.partition(":")[0]: piece.rstrip("\n") + "\n" for piece in pieces if piece.strip()}


def with_piece(piece: str) -> str:
    """Put a piece of a ruleset file in the place of what the example says there."""
    changed = blocks(piece)
    rest = {
        key: text
        for key, text in blocks(EXAMPLE).items()
        if "extends" not in changed or key not in ("let", "rules", "tests")
    }
    return "".join((rest | changed).values())


def findings(text: str) -> Iterable[Diagnostic]:
    """All errors and remarks, as `ccas check` gives them."""
    try:
        if text.startswith("cases"):
            return case_remarks(Reader(text, "cases.yaml"), ["tran2026"])
        return reviewed(parse_ruleset(text, "example.yaml", library), text, TODAY)
    except RulesetError as error:
        return [coded(each) for each in error.diagnostics]


def example(piece: str) -> str:
    return piece if piece.startswith("cases") else with_piece(piece)


def test_example_behind_the_pages_has_no_findings() -> None:
    assert list(findings(EXAMPLE)) == []


@pytest.mark.parametrize("page", PAGES.values(), ids=PAGES)
def test_example_to_avoid_has_the_code_of_its_page(page: CodePage) -> None:
    found = list(findings(example(page.avoid)))

    assert page.code in {each.code for each in found}
    assert all(each.source and each.line and each.column for each in found)
    assert all(each.excerpt for each in found)


@pytest.mark.parametrize("page", PAGES.values(), ids=PAGES)
def test_example_to_prefer_does_not_have_it(page: CodePage) -> None:
    found = {each.code for each in findings(example(page.prefer))}

    assert page.code not in found
    assert not any(code.startswith("E") for code in found)


def test_carets_stand_under_all_letters_that_are_meant() -> None:
    (found,) = findings(with_piece("let:\n  crossing: geometry == crossing\n  nearby: distance < 500 m\n"))

    assert str(found).splitlines()[2] == "   |   ^^^^^^"


def test_error_without_a_page_has_no_code() -> None:
    assert coded(Diagnostic(source="x", message="larger than 2 MB")).code == ""


def test_code_that_is_there_already_stays() -> None:
    assert coded(Diagnostic(source="x", message="unknown key 'a'", code="R102")).code == "R102"


def test_rule_of_the_base_is_not_remarked_on_in_an_overlay() -> None:
    found = findings(with_piece("extends: base\n"))

    assert [each.code for each in found] == []


def test_rule_that_repeats_an_earlier_one_by_a_definition_is_never_reached() -> None:
    rule = "  - {{id: {}, when: {}, then: give_way, cite: {{article: '1', confidence: text_seen}}}}\n"
    let = "let:\n  meets(ship): ship.ferry and geometry == crossing\n"
    rules = rule.format("a", "own.ferry") + rule.format("b", "meets(own) and other.nuc")

    found = findings(with_piece(f"{let}rules:\n{rules}tests: []\n"))

    assert [each.message for each in found if each.code == "R102"] == ["rule 'b' is never reached"]


def test_more_remarks_than_are_told_are_no_error() -> None:
    lines = "".join(f"  unused_{n}: own.ferry\n" for n in range(150))
    found = list(findings(with_piece(f"let:\n  crossing: geometry == crossing\n{lines}")))

    assert {each.code for each in found} == {"R103"}


def test_encounter_file_is_remarked_on_once_for_each_unknown_ruleset() -> None:
    case = "  - id: C{}\n    ships: {{A: {{}}, B: {{}}}}\n    expected: {{tran2062: {{kind: none}}}}\n"
    text = "cases:\n" + case.format(1) + case.format(2)

    (found,) = case_remarks(Reader(text, "cases.yaml"), ["tran2026"])

    assert parse_cases(text).findings == ()
    assert (found.line, found.column, found.hint) == (4, 16, "did you mean 'tran2026'?")
