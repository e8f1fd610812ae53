"""Groups that once had a fault, sailed again."""

from __future__ import annotations

import pytest

from ccas_core.sweep.case import Case, sail, scenario
from ccas_core.sweep.spec import Cell, Draw, Variant
from ccas_core.sweep.task import program, rulesets, solver


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "draw", "index"),
    [
        (1002, Draw.REACH, 41),  # a long ship waited between two lines of ships that met it
        (77004, Draw.JUNCTION, 11),  # a long ship stopped, turned back to its line, and touched the bank
        (20261124, Draw.REACH, 219),  # a ship went to and fro between two ways past an overtaken one
        (77004, Draw.REACH, 39),  # a ship between two others slowed down again and again
        (31007, Draw.JUNCTION, 78),  # the same, for so long that it was frozen
        (31007, Draw.REACH, 101),  # a ship stopped and started beside one that it overtook
        (55101, Draw.REACH, 153),  # a ship could pass between two others four metres beside its line only
        (55101, Draw.JUNCTION, 77),  # four ships in a ring of duties all slowed down for one another
    ],
)
def test_a_group_is_sailed_without_a_fault(seed: int, draw: Draw, index: int) -> None:
    cell = Cell(name=draw.value, count=1, draw=draw, ships=(2, 8))
    case = Case(
        cell=cell, ruleset="tran2026", variant=Variant(name=""), seed=seed, index=index, solver="riccati"
    )
    known = rulesets(program())

    _, found = sail(scenario(case, known), known, solver(case.solver))

    faults = [found[key] for key in ("collisions", "entries", "groundings", "frozen")]
    assert faults == [0, 0, 0, 0]
    assert found["restless"] == []
