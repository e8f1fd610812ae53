"""The library of rulesets: read when asked for, each by itself."""

from __future__ import annotations

from pathlib import Path

import pytest

from ccas_core.errors import RulesetError
from ccas_core.tapd.library import RulesetLibrary, id_in
from ccas_core.tapd.written import WrittenRuleset

from .rulesets import SMALL, overlay, read


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "small.yaml").write_text(SMALL)
    (tmp_path / "over.yaml").write_text(overlay("remove: [ferry]\n"))
    (tmp_path / "broken.yaml").write_text(SMALL.replace("id: small", "id: broken").replace("then:", "than:"))
    (tmp_path / "base.yaml").write_text(SMALL.replace("id: small", "id: base\nabstract: true"))
    (tmp_path / "based.yaml").write_text(overlay(base="base").replace("id: over", "id: based"))
    return tmp_path


@pytest.fixture
def library(folder: Path) -> RulesetLibrary:
    return RulesetLibrary(files={id_in(path): path for path in folder.glob("*.yaml")})


def test_rulesets_are_listed_by_id_and_bases_left_out(library: RulesetLibrary) -> None:
    assert list(library) == ["based", "broken", "over", "small"]
    assert len(library) == 4
    assert "small" in library
    assert "base" not in library
    assert library.__contains__(3) is False


def test_ruleset_is_read_once(library: RulesetLibrary) -> None:
    assert library["small"] is library["small"]
    assert library["small"].id == "small"


def test_broken_file_makes_one_ruleset_unavailable_and_no_other(library: RulesetLibrary) -> None:
    with pytest.raises(RulesetError, match="unknown key 'than'"):
        library["broken"]
    assert library["small"].id == "small"
    with pytest.raises(RulesetError):
        library["broken"]


@pytest.mark.parametrize("name", ["none", "base"])
def test_ruleset_that_there_is_not_is_a_key_error(library: RulesetLibrary, name: str) -> None:
    with pytest.raises(KeyError):
        library[name]


def test_overlay_finds_its_base_in_the_library(library: RulesetLibrary) -> None:
    for name, lineage in (("over", ("small",)), ("based", ("base",))):
        found = library[name]
        assert isinstance(found, WrittenRuleset)
        assert found.text.lineage == lineage


def test_file_outside_may_extend_what_is_inside(library: RulesetLibrary, tmp_path: Path) -> None:
    path = tmp_path / "mine.yml"
    path.write_text(overlay("remove: [sail.wind]\n").replace("id: over", "id: mine"))

    assert library.loaded(path).id == "mine"
    assert "mine" in library  # from then on it stands for its id
    with pytest.raises(RulesetError, match="did you mean 'small'"):
        library.parsed(overlay(base="smal"), "mine.yaml")


def test_rulesets_that_are_there_already_stand_beside_those_of_files(folder: Path) -> None:
    made = read(SMALL.replace("id: small", "id: made"))
    library = RulesetLibrary({"made": made}, {"small": folder / "small.yaml"})

    assert list(library) == ["made", "small"]
    assert library["made"] is made
    assert (library.path("made"), library.path("small")) == (None, folder / "small.yaml")
    with pytest.raises(KeyError):
        library.text_of("made")
    assert library.text_of("small") == (SMALL, str(folder / "small.yaml"))


@pytest.mark.parametrize(
    ("text", "id_"),
    [
        ("id: a\n", "a"),
        ("schema: x\nid:   a-b.c  # more\n", "a-b.c"),
        ('id: "a"\n', "a"),
        ("id: 'a'\n", "a"),
        ("title: x\n  id: no\nid: a\n", "a"),
    ],
)
def test_id_of_a_file_is_read_without_the_rest(tmp_path: Path, text: str, id_: str) -> None:
    path = tmp_path / "file.yaml"
    path.write_text(text)

    assert id_in(path) == id_


def test_file_without_id_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "file.yaml"
    path.write_text("title: x\n  id: no\n")

    with pytest.raises(RulesetError, match="the file names no ruleset"):
        id_in(path)
    with pytest.raises(RulesetError, match="cannot be read"):
        id_in(tmp_path / "none.yaml")
