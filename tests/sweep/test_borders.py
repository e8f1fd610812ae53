"""Encounters drawn on borders: where the border lies, what their logs say of laws, how that is counted."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ccas_core import plugins
from ccas_core.dmpc.solvers import make_solver
from ccas_core.errors import InputError
from ccas_core.frames import PathPose
from ccas_core.sim.scenario import Scenario
from ccas_core.sweep.borders import BEYOND, with_border
from ccas_core.sweep.case import Case, cases, sail, scenario
from ccas_core.sweep.draw import Kind, Risk, draw_encounter, undisturbed_meeting
from ccas_core.sweep.spec import Sweep, load_sweep, parse_sweep
from ccas_core.sweep.tally import Result, cell_entries, faults
from ccas_core.sweep.workers import Status
from ccas_core.waterway import guiding_line
from ccas_scenarios import path

RULESETS = plugins.load().rulesets
SPEC = """
schema: ccas/sweep@1
name: tiny
cells:
  - {name: head_on, draw: head_on, border: [bpr, ccnr], count: 2}
  - {name: lacking, draw: overtaking, border: [cevni, de_danube], lacking: true, count: 1}
"""


def drawn(index: int, *, lacking: bool = False) -> Scenario:
    rng = np.random.default_rng([5, index])
    kind = list(Kind)[index % 3]
    return with_border(rng, draw_encounter(rng, kind, Risk.RISKY, "bpr"), "ccnr", lacking=lacking)


def laws_along(of: Scenario, place: int) -> set[str]:
    """Laws that a ship sails through, undisturbed, until a while after the meeting."""
    plan = of.ships[place]
    frame = guiding_line(of.waters, plan.route).frame
    start, until = frame.to_path(plan.start).x, plan.speed * BEYOND * undisturbed_meeting(of).time
    return {
        of.waters.ruleset_at(frame.to_ned(PathPose(float(x), 0.0, 0.0)))
        for x in np.linspace(start, start + until, 400)
    }


def test_a_border_lies_on_the_way_of_a_ship_and_in_all_directions() -> None:
    angles = []
    for index in range(60):
        of = drawn(index)
        assert any(laws_along(of, place) == {"bpr", "ccnr"} for place in (0, 1))
        (north, east), (further_north, further_east) = of.waters.regions[0].polygon[:2]
        angles.append(np.arctan2(further_east - east, further_north - north))

    assert np.histogram(angles, bins=4, range=(-np.pi, np.pi))[0].min() > 5


def test_a_border_changes_nothing_else_of_an_encounter() -> None:
    rng = np.random.default_rng([5, 0])
    plain, of = draw_encounter(rng, Kind.HEAD_ON, Risk.RISKY, "bpr"), drawn(0)

    assert [(p.ship.id, p.start, p.speed) for p in of.ships] == [
        (p.ship.id, p.start, p.speed) for p in plain.ships
    ]
    assert [p.rulesets for p in drawn(0, lacking=True).ships] == [("bpr",), ()]


def test_cells_with_a_border_are_sailed_once_by_their_own_rulesets() -> None:
    sweep = parse_sweep(SPEC, rulesets=RULESETS)
    both = parse_sweep(
        SPEC.replace("cells:", "rulesets: [tran2026, bpr]\ncells:\n  - {name: x, draw: head_on}")
    )

    assert [(case.cell.name, case.under) for case in cases(sweep)] == [
        ("head_on", "bpr|ccnr"),
        ("lacking", "cevni|de_danube"),
        ("head_on", "bpr|ccnr"),
    ]
    assert sorted((case.cell.name, case.under) for case in cases(both)) == [
        ("head_on", "bpr|ccnr"),
        ("head_on", "bpr|ccnr"),
        ("lacking", "cevni|de_danube"),
        ("x", "bpr"),
        ("x", "tran2026"),
    ]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[bpr, ccnr]", "[bpr]", "a list of 1"),
        ("[bpr, ccnr]", "[bpr, cnr]", "unknown ruleset 'cnr'"),
        ("draw: head_on", "draw: junction", "a border is drawn through an encounter of two ships"),
        (", border: [cevni, de_danube]", "", "a ship lacks the ruleset beyond a border"),
        ("lacking: true", "lacking: maybe", "got 'maybe'"),
    ],
)
def test_a_wrong_border_is_told(old: str, new: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_sweep(SPEC.replace(old, new), rulesets=RULESETS)


def result(case: Case) -> Result:
    _, kept = sail(scenario(case, RULESETS), RULESETS, make_solver())
    return Result(case, Status.DONE, kept)


def tried(sweep: Sweep, seed: int) -> list[Case]:
    """One case of each cell, by another seed than the shipped one."""
    small = replace(sweep, seed=seed, cells=tuple(replace(cell, count=1) for cell in sweep.cells))
    return list(cases(small))


@pytest.mark.parametrize("part", range(4))
def test_on_drawn_borders_ships_name_one_law_or_fall_back_and_nobody_comes_to_harm(part: int) -> None:
    """A small part of `border_long`, from the same draw."""
    for case in tried(load_sweep(path("sweeps/border_long")), 11)[part::4]:
        each = result(case)
        laws: dict[str, Any] = each.kept["laws"]

        assert [each.kept[key] for key in ("collisions", "entries", "groundings", "frozen")] == [0] * 4
        assert (laws["faults"], laws["two_laws"], laws["both_stand_on"], laws["flaps"]) == (0, 0, 0, 0)
        assert case.cell.lacking or laws["fallbacks"] == laws["law_changes"] == 0
        assert faults(each) == () or faults(each) == ("unfaithful",)


def test_a_ship_that_lacks_the_ruleset_falls_back() -> None:
    sweep = load_sweep(path("sweeps/border_long"))
    lacking = replace(next(cell for cell in sweep.cells if cell.lacking), count=4)
    counted = [result(case).kept["laws"]["fallbacks"] for case in cases(replace(sweep, cells=(lacking,)))]

    assert sum(count > 0 for count in counted) >= 2


def test_what_logs_say_of_laws_is_summed_by_cell_and_a_fault_is_a_fault_of_the_case() -> None:
    case = next(cases(parse_sweep(SPEC)))
    kept = result(case).kept
    bad = {**kept, "laws": {**kept["laws"], "two_laws": 2, "faults": 2}}
    results = [Result(case, Status.DONE, kept), Result(case, Status.DONE, bad)]

    (entry,) = cell_entries(results)
    assert (entry["ruleset"], entry["laws"]["two_laws"], entry["laws"]["faults"]) == ("bpr|ccnr", 2, 2)
    assert entry["laws"]["decisions"] == 2 * kept["laws"]["decisions"]
    assert faults(results[1]) == ("laws",)
