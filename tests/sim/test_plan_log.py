"""`plans.jsonl`: few points, and none of them far from the plan."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ccas_core.frames import FloatArray
from ccas_core.sim.plan_log import TOLERANCE, plans, thinned
from ccas_core.verdict import Kind

from . import EAST, WEST, A, B, always, plan, scenario, settlement, voyage

MET = always(settlement(Kind.GIVE_WAY, Kind.STAND_ON))
STEPS = st.lists(st.tuples(st.floats(0.0, 60.0), st.floats(-3.0, 3.0)), min_size=1, max_size=46)


@given(STEPS.map(lambda steps: np.cumsum(np.array(steps), axis=0)))
def test_thinned_plan_has_the_ship_at_every_step_where_the_plan_has_it(points: FloatArray) -> None:
    kept = thinned(points)

    rows = np.arange(len(points))
    drawn = np.column_stack([np.interp(rows, kept, points[kept, axis]) for axis in (0, 1)])
    assert np.hypot(*(drawn - points).T).max() <= TOLERANCE + 1e-6
    assert (kept[0], kept[-1]) == (0, len(points) - 1)


def test_plans_are_told_in_seconds_and_metres_with_why_a_command_is_not_the_solver_s() -> None:
    head_on = scenario(plan(A, EAST, before=600.0), plan(B, WEST, before=600.0))
    frame = voyage(head_on, {A: [(0.0, 1.0)], B: [(0.0, 1.0)]}, MET, 1)[0]

    told = plans(frame, 20.0)

    assert told["time_s"] == 0.0
    ships = told["ships"]
    assert isinstance(ships, dict)
    assert list(ships) == ["a", "b"]
    assert ships["a"]["east_m"][0] == -600.0
    assert ships["a"]["after_s"][0] == 0.0
