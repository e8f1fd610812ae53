"""Sweeps of ships that do not all negotiate: the same encounters for all, and one table of them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from ccas_core import plugins
from ccas_core.controllers import COOPERATIVE, TRACKED
from ccas_core.dmpc.solvers import make_solver
from ccas_core.domains import DynamicBumper
from ccas_core.errors import InputError
from ccas_core.sweep.case import Case, sail, scenario
from ccas_core.sweep.mixed import Row, rows, with_control
from ccas_core.sweep.spec import Cell, Draw, Variant, load_sweep, parse_sweep
from ccas_core.waterway import Waters
from ccas_scenarios import path

RULESETS = plugins.load().rulesets
SOLVER = make_solver("riccati")
TEXT = """\
schema: ccas/sweep@1
name: mine
rulesets: [bpr]
cells:
  - {name: one, draw: DRAW, control: CONTROL}
"""


def case(one: str, other: str, draw: Draw = Draw.HEAD_ON, index: int = 0) -> Case:
    cell = Cell(name=f"{one}_{other}", count=1, draw=draw, control=(one, other))
    return Case(cell=cell, ruleset="bpr", variant=Variant(), seed=3, index=index, solver="riccati")


def kept(
    pairing: tuple[str, str], *, collisions: int, avoidable: bool, delay: float | None
) -> dict[str, Any]:
    ship = {"delay_s": delay, "max_offset_change_m": 7.0}
    return {
        "mixed": {
            "pairing": list(pairing),
            "collision_avoidable": avoidable,
            "entry_avoidable": avoidable,
        },
        "ships": {"ship_1": ship, "ship_2": ship},
        "collisions": collisions,
        "entries": collisions,
        "frozen": 0,
        "min_clearance_m": 12.0,
    }


@pytest.mark.parametrize("draw", [Draw.HEAD_ON, Draw.CROSSING, Draw.OVERTAKING])
def test_all_pairings_sail_the_same_encounters_on_the_same_waters(draw: Draw) -> None:
    one, other = (scenario(case(*pair, draw), RULESETS) for pair in ((COOPERATIVE,) * 2, ("bumper", TRACKED)))

    def seen(waters: Waters) -> list[object]:
        return [(each.id, each.centreline.tolist(), each.width) for each in waters.waterways]

    assert seen(one.waters) == seen(other.waters)
    for mine, theirs in zip(one.ships, other.ships, strict=True):
        assert (mine.ship, mine.start, mine.speed) == (theirs.ship, theirs.start, theirs.speed)
    assert [plan.control.by for plan in other.ships] == ["bumper", TRACKED]


def test_waters_leave_room_for_domains_to_pass() -> None:
    drawn = scenario(case(COOPERATIVE, COOPERATIVE), RULESETS)
    narrow = replace(
        drawn, waters=replace(drawn.waters, waterways=(replace(drawn.waters.waterways[0], width=1.0),))
    )
    wide = with_control(narrow, (COOPERATIVE, TRACKED))
    domains = [plan.ship.domain for plan in wide.ships]

    assert all(isinstance(each, DynamicBumper) for each in domains)
    assert wide.waters.waterways[0].width >= 2.0 * sum(2.0 * each.extent(0.0, 1.0, 1.0) for each in domains)


@pytest.mark.parametrize("pair", [(COOPERATIVE, TRACKED), ("bumper", TRACKED)])
def test_own_ship_keeps_clear_of_one_that_goes_on(pair: tuple[str, str]) -> None:
    _, found = sail(scenario(case(*pair), RULESETS), RULESETS, SOLVER)

    assert found["mixed"]["pairing"] == list(pair)
    assert found["mixed"]["collision_avoidable"]
    assert found["mixed"]["entry_avoidable"]
    assert found["collisions"] == found["entries"] == 0
    assert all(met["faithful"] is None for met in found["encounters"])


def test_other_encounters_are_not_mixed() -> None:
    usual = replace(case(COOPERATIVE, COOPERATIVE), cell=Cell(name="usual", count=1, draw=Draw.HEAD_ON))
    _, found = sail(scenario(usual, RULESETS), RULESETS, SOLVER)

    assert found["mixed"] is None
    assert rows([("bpr", found)]) == []


def test_pairings_are_counted_by_what_the_own_ship_could_have_avoided() -> None:
    pair = COOPERATIVE, TRACKED
    found = rows(
        [
            ("bpr", kept(pair, collisions=1, avoidable=False, delay=None)),
            ("bpr", kept(pair, collisions=1, avoidable=True, delay=4.0)),
            ("bpr", kept(pair, collisions=0, avoidable=True, delay=6.0)),
        ]
    )

    assert found == [
        Row(
            pairing="cooperative / tracked",
            ruleset="bpr",
            n=3,
            collisions=2,
            avoidable_collisions=1,
            entries=2,
            avoidable_entries=1,
            min_clearance=12.0,
            delay=10.0,
            aside=14.0,
            frozen=0,
        )
    ]


@pytest.mark.parametrize(
    ("draw", "control", "said"),
    [
        ("junction", "[cooperative, tracked]", "'control' is for encounters of two ships"),
        ("head_on", "[cooperative]", "a list of 1"),
        ("head_on", "[cooperative, bumpr]", "unknown controller 'bumpr'"),
    ],
)
def test_control_that_cannot_be_is_refused(draw: str, control: str, said: str) -> None:
    text = TEXT.replace("DRAW", draw).replace("CONTROL", control)

    with pytest.raises(InputError, match=said):
        parse_sweep(text, controllers={"bumper"})


@pytest.mark.parametrize(("name", "count"), [("mixed_short", 45), ("mixed_long", 500)])
def test_shipped_sweeps_have_so_many_encounters_of_each_pairing(name: str, count: int) -> None:
    sweep = load_sweep(path(f"sweeps/{name}"), RULESETS)
    counts: dict[tuple[str, str], int] = {}
    for cell in sweep.cells:
        assert cell.control is not None
        counts[cell.control] = counts.get(cell.control, 0) + cell.count

    assert set(counts.values()) == {count}
    assert set(counts) == {
        (COOPERATIVE, COOPERATIVE),
        (COOPERATIVE, TRACKED),
        ("bumper", TRACKED),
        (COOPERATIVE, "bumper"),
    }
