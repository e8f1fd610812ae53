"""Pictures of ships that show a fault."""

from __future__ import annotations

from pathlib import Path

import pytest

from ccas_core.proofs.picture import draw_ships, picture
from ccas_core.proofs.search import Facts, Ships, case_of, judged

from . import ruleset


def ships(apart: float) -> Ships:
    places = {"A": (0.0, 0.0, 0.0, 3.0), "B": (apart, apart, 270.0, 3.0)}
    stated = {ship: {"length": 80.0, "beam": 10.0} for ship in places}
    case = case_of(Facts(stated, {}, {}), places)
    mini = ruleset()
    return Ships(case=case, verdicts=judged((mini, mini), case), margin=0.0)


@pytest.mark.parametrize("apart", [60.0, 600.0, 6000.0])
def test_picture_shows_hulls_names_and_duties(apart: float) -> None:
    figure = picture(
        ships(apart), "a title that is so long that it goes over more than one line of the picture"
    )
    (axes,) = figure.axes
    texts = " ".join(text.get_text() for text in axes.texts)

    assert len(axes.patches) == 2
    assert "A, 80 m, 3 m/s" in texts
    assert "B, 80 m, 3 m/s" in texts
    west, east = axes.get_xlim()
    for outline in axes.patches:
        box = outline.get_path().get_extents()
        assert west <= box.x0 < box.x1 <= east


def test_same_ships_give_the_same_file(tmp_path: Path) -> None:
    for name in ("one.png", "two.png"):
        draw_ships(ships(300.0), tmp_path / name, "ships")

    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()
