"""What ships say on a voyage is told once, with the first and the last time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from ccas_core.sim.frame import Frame
from ccas_core.sim.remarks import remark_entry, remarks
from ccas_core.surge_yaw import Motion

from . import EAST, A, plan, scenario, voyage


def saying(words: Mapping[int, tuple[str, ...]], **more: Any) -> list[Frame]:  # noqa: ANN401
    """A voyage of one ship that sees something in some frames."""
    frames = voyage(scenario(plan(A, EAST, 600.0)), {A: [(0.0, 1.0)]}, lambda _: (), periods=5)
    return [
        replace(
            frame,
            ships=MappingProxyType({A: replace(frame.ships[A], saw=words.get(frame.index, ()), **more)}),
        )
        for frame in frames
    ]


def test_word_that_is_said_again_with_other_numbers_is_told_once() -> None:
    (found,) = remarks(saying({1: ("b has been silent for 20 s",), 3: ("b has been silent for 60 s",)}))

    assert remark_entry(found) == {
        "ship": A,
        "text": "b has been silent for 20 s",
        "first_s": 20.0,
        "last_s": 60.0,
        "count": 2,
    }


def test_plans_of_steered_ships_that_do_not_do_are_told_and_those_of_others_are_not() -> None:
    said = [each.text for each in remarks(saying({}, outcome="no plan", motion=Motion(1.0, 0.0)))]

    assert said == ["no plan"]
    assert remarks(saying({}, outcome="no plan")) == ()
