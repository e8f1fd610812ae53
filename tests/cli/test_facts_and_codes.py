"""`ccas facts` and `ccas code`: what rules may ask for, and what findings mean."""

from __future__ import annotations

import json

import pytest

from . import ccas


def test_facts_are_listed_with_all_that_a_rule_author_needs() -> None:
    found = json.loads(ccas("facts", "--json").stdout)

    (length,) = [row for row in found if row["name"] == "length"]
    assert (length["scope"], length["unit"], length["key"]) == ("ship", "m", "length_m")
    assert (length["source"], length["plugin"]) == ("ais", "")
    assert {row["scope"] for row in found} == {"ship", "waterway", "pair"}


@pytest.mark.parametrize("scope", ["ship", "waterway", "pair"])
def test_facts_of_one_scope_are_listed(scope: str) -> None:
    found = json.loads(ccas("facts", "--scope", scope, "--json").stdout)

    assert {row["scope"] for row in found} == {scope}
    assert found[0]["name"] in ccas("facts", "--scope", scope).stdout


def test_unknown_scope_is_wrong_use() -> None:
    assert ccas("facts", "--scope", "boat").exit_code == 2


def test_page_of_a_code_has_an_example_to_avoid_and_one_to_prefer() -> None:
    text = ccas("code", "r110").stdout

    assert text.startswith("## R110: rule obliges each of the two alone\n")
    assert text.index("Avoid:") < text.index("then: give_way") < text.index("Prefer:")


def test_codes_are_listed() -> None:
    found = json.loads(ccas("code", "--json").stdout)

    assert {"R101", "E101"} <= {page["code"] for page in found}
    assert all(page["title"] in ccas("code").stdout for page in found[:3])


def test_unknown_code_is_told_with_what_was_probably_meant() -> None:
    done = ccas("code", "E1O3")

    assert (done.exit_code, done.stdout) == (2, "")
    assert "there is no code 'E1O3'" in done.stderr
    assert "did you mean 'E103'?" in done.stderr
