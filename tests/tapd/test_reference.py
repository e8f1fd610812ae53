"""The pages that are made from the program say what the program knows."""

from __future__ import annotations

from pathlib import Path

import pytest

from ccas_core.tapd.code_pages import code_pages, codes_page
from ccas_core.tapd.facts_page import facts_page, rows
from ccas_core.tapd.vocabulary import VOCABULARY, Fact, Kind, Scope, Source

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.parametrize(
    ("name", "made"), [("facts.md", facts_page(VOCABULARY)), ("codes.md", codes_page(code_pages().values()))]
)
def test_page_is_not_stale(name: str, made: str) -> None:
    written = (DOCS / name).read_text(encoding="utf-8")

    assert written == made, "run docs/make_reference.py"


def test_every_fact_has_a_row_and_a_meaning() -> None:
    listed = list(rows(VOCABULARY))

    assert {fact.name for fact in VOCABULARY.facts} <= {row.name for row in listed}
    assert all(row.meaning and row.values and row.default for row in listed)


def test_fact_of_a_plugin_is_listed_with_the_plugin() -> None:
    ice = Fact(name="ice_class", scope=Scope.SHIP, kind=Kind.FLAG, meaning="has ice class", source=Source.AIS)

    (row,) = [
        row for row in rows(VOCABULARY.extended([ice]), {"ice_class": "winter"}) if row.name == "ice_class"
    ]

    assert (row.plugin, row.scope, row.default, row.key) == ("winter", "ship", "unknown", "ice_class")
