"""The register of faults: what the page lists, and when it is stale."""

from __future__ import annotations

from datetime import date
from pathlib import Path

import pytest

from ccas_core.plugins import load
from ccas_core.proofs.check import check
from ccas_core.proofs.evidence import Entry, clear, shown
from ccas_core.proofs.register import PAGE, digest_of, sources_of, stale, write_register

from . import broken, ruleset, with_waiver_text, written

TODAY = date(2026, 6, 1)
SHIPPED = Path(__file__).parents[2] / "docs" / "findings" / PAGE


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Register of a ruleset that is not consistent, and of one with a waived tie."""
    folder = tmp_path_factory.mktemp("register")
    texts = {
        "one": broken("consistent").replace("id: mini", "id: one"),
        "two": with_waiver_text(broken("tie_break_total"), "tie_break_total").replace("id: mini", "id: two"),
    }
    told = []
    for name, text in texts.items():
        found = ruleset(text, str(written(folder, text, f"{name}.yaml")))
        findings = check(found, today=TODAY, only=["consistent", "tie_break_total"])
        entry = Entry(name=name, rulesets=(found,), findings=findings)
        told.append((entry, shown(entry, folder / "page")))
    return write_register(told, folder / "page")


def sources(page: Path, id_: str) -> tuple[str, ...]:
    return sources_of(id_, str(page.parents[1] / f"{id_}.yaml"))


def test_page_lists_faults_with_articles_ships_files_and_what_is_done(page: Path) -> None:
    text = page.read_text(encoding="utf-8")

    for part in (
        "| ruleset | consistent | tie_break_total |",
        "| [one](#one) | refuted, not waived | proved |",
        "#### both ships give way by rule 'crossing'",
        "Mini 3",
        "neither waived nor repaired",
        "waived until 2999-12-31: the law says so",
    ):
        assert part in text


def test_all_files_that_the_page_names_lie_beside_it(page: Path) -> None:
    names = [part.partition(")")[0] for part in page.read_text(encoding="utf-8").split("](")[1:]]
    files = [page.parent / name for name in names if name.endswith((".yaml", ".png"))]

    assert {file.suffix for file in files} == {".yaml", ".png"}
    assert all(file.is_file() for file in files)


def test_page_is_fresh_as_long_as_rulesets_and_list_are_those_that_were_found(page: Path) -> None:
    text = page.read_text(encoding="utf-8")

    assert stale(text, lambda id_: sources(page, id_), ["one", "two"]) == {}


def test_page_is_stale_when_a_rule_changes_and_not_when_a_test_does(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    (now,) = sources(page, "one")[:1]
    base = sources(page, "one")[1:]
    tested = now.replace("tests:\n", "tests:\n  # one more\n")
    changed = now.replace("then: mutual", "then: give_way")

    assert stale(text, lambda id_: (tested, *base) if id_ == "one" else sources(page, id_), ["one"]) == {}
    assert stale(text, lambda id_: (changed, *base) if id_ == "one" else sources(page, id_), ["one"]) == {
        "one": "the ruleset has changed"
    }


def test_page_is_stale_when_a_ruleset_is_missing_or_its_list_was_edited(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    edited = text.replace("#### both ships give way", "#### both ships stand on")

    assert stale(text, lambda id_: sources(page, id_), ["one", "two", "three"]) == {"three": "it is missing"}
    assert "page" in stale(edited, lambda id_: sources(page, id_), ["one", "two"])


def test_digest_is_of_the_base_too(page: Path) -> None:
    one = sources(page, "one")

    assert digest_of(one) != digest_of((*one, "more"))


def test_earlier_files_of_a_property_give_way_and_others_stay(tmp_path: Path) -> None:
    for name in ("consistent-7.yaml", "consistent-7.encounter.yaml", "complete-1.png", "my-notes.yaml"):
        (tmp_path / name).touch()
    clear(tmp_path, ["consistent"])

    assert sorted(file.name for file in tmp_path.iterdir()) == ["complete-1.png", "my-notes.yaml"]


def test_register_of_the_shipped_rulesets_is_not_stale() -> None:
    """If it is: `ccas check-consistency --register docs/findings --border bpr ccnr`."""
    plugins = load()
    shipped = [id_ for id_, owner in plugins.owners.items() if owner == "rulesets"]
    text = SHIPPED.read_text(encoding="utf-8")

    assert stale(text, lambda id_: sources_of(id_, str(plugins.rulesets.path(id_))), shipped) == {}
