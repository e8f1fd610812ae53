"""The voyage: the same in every run, its beginning and its ends, the plant, bends, regions."""

from __future__ import annotations

import ast
import itertools
import math
import re
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ccas_core.dmpc
from ccas_core import plugins
from ccas_core.dmpc.local_problem import LocalProblem, Solution
from ccas_core.dmpc.outcome import Outcome
from ccas_core.dmpc.solvers import AbstractLocalSolver, make_solver
from ccas_core.frames import FloatArray, NedPose, PathPose
from ccas_core.regions import Region
from ccas_core.sim.frame import Frame
from ccas_core.sim.metrics import summary
from ccas_core.sim.run_folder import RunWriter
from ccas_core.sim.scenario import ControlChoice, Plan, Scenario
from ccas_core.sim.voyage import PERIODS_ALLOWED, periods_limit, undisturbed_times, voyage
from ccas_core.waterway import Leg, Towards, Waters, Waterway, guiding_line

from . import EAST, NORTH, SPEED, STEP, WEST, A, B, plan, scenario, ship, waters

RULESETS = plugins.load().rulesets
ROOT = Path(__file__).parents[2]
CONTROL = ControlChoice(horizon=20, iterations=2)
ON = replace(waters(), ruleset="tran2026")


class Stopped(AbstractLocalSolver):
    """A solver that never has an answer."""

    name = "stopped"

    def __init__(self) -> None:
        self._inner = make_solver("riccati")

    def solve(self, problem: LocalProblem, guess: FloatArray) -> Solution:
        """Fail."""
        return replace(self._inner.solve(problem, guess), outcome=Outcome.FAILED)

    def best(self, problem: LocalProblem, guesses: Iterable[FloatArray]) -> Solution:
        """Fail."""
        return self.solve(problem, next(iter(guesses)))


@pytest.fixture(scope="module")
def solver() -> AbstractLocalSolver:
    return make_solver("riccati")


def crossing(on: Waters = ON) -> Scenario:
    """Two ships that would meet in the middle."""
    made = scenario(plan(A, EAST, before=600.0), plan(B, NORTH, before=600.0), on=on)
    return replace(made, control=CONTROL)


def sail(of: Scenario, solver: AbstractLocalSolver, periods: int | None = None) -> list[Frame]:
    return list(itertools.islice(voyage(of, RULESETS, solver), periods))


def written(folder: Path, of: Scenario, frames: Iterable[Frame]) -> bytes:
    with RunWriter(folder, of, "schema: ccas/scenario@1\n") as writer:
        for frame in frames:
            writer.write(frame)
    return (folder / "frames.csv").read_bytes()


def test_same_scenario_gives_the_same_bytes_in_this_process_and_in_another(
    tmp_path: Path, solver: AbstractLocalSolver
) -> None:
    script = """
import sys
from pathlib import Path
from ccas_core.dmpc.solvers import make_solver
from tests.sim import test_voyage as here
here.written(Path(sys.argv[1]), here.crossing(), here.sail(here.crossing(), make_solver("riccati"), 25))
"""
    command = (sys.executable, "-c", script, str(tmp_path / "other"))

    one = written(tmp_path / "one", crossing(), sail(crossing(), solver, 25))
    same = written(tmp_path / "same", crossing(), sail(crossing(), make_solver("riccati"), 25))
    subprocess.run(command, cwd=ROOT, check=True, timeout=100)

    assert one.count(b"\n") == 1 + 2 * 25
    assert one == same == (tmp_path / "other" / "frames.csv").read_bytes()


def test_first_frame_stands_at_time_zero_where_the_ships_start(solver: AbstractLocalSolver) -> None:
    (first,) = sail(crossing(), solver, 1)

    assert (first.index, first.time, dict(first.arrived)) == (0, 0.0, {})
    for each in crossing().ships:
        here = first.ships[each.ship.id].pose
        assert (here.x, here.y) == pytest.approx((each.start.x, each.start.y), abs=1e-9)


def test_frames_follow_one_another_by_a_control_period(solver: AbstractLocalSolver) -> None:
    frames = sail(crossing(), solver, 10)

    assert [frame.index for frame in frames] == list(range(10))
    assert [frame.time for frame in frames] == [STEP * n for n in range(10)]


def test_ships_leave_after_they_have_arrived(solver: AbstractLocalSolver) -> None:
    of = replace(
        scenario(plan(A, EAST, before=-2690.0), plan(B, NORTH, before=-2500.0), on=ON), control=CONTROL
    )
    frames = sail(of, solver)

    assert frames[-1].arrived == pytest.approx(undisturbed_times(of), abs=1e-6)
    for id_, when in frames[-1].arrived.items():
        seen = [frame.time for frame in frames if id_ in frame.ships]
        assert seen[-1] == STEP * math.ceil(when / STEP - 1e-9)  # one frame more, and then gone
        assert not any(
            id_ in generation for frame in frames if frame.time >= when for generation in frame.generations
        )


def test_voyage_that_does_not_end_is_ended_21_periods_after_the_undisturbed_arrival() -> None:
    of = replace(scenario(plan(A, EAST, before=-2500.0), on=ON), control=CONTROL)
    frames = sail(of, Stopped())

    assert PERIODS_ALLOWED == 21
    assert frames[-1].index == math.ceil(500.0 / SPEED / STEP) + 21 == periods_limit(of)
    assert frames[-1].arrived == {}


def test_duration_lengthens_a_voyage_and_never_shortens_it(solver: AbstractLocalSolver) -> None:
    of = replace(scenario(plan(A, EAST, before=-2500.0), on=ON), control=CONTROL)
    plain, shorter = sail(of, solver), sail(replace(of, duration=40.0), solver)
    longer = sail(replace(of, duration=2000.0), solver)

    assert plain[-1].time < 2000.0
    assert len(shorter) == len(plain)
    assert longer[-1].time == 2000.0
    assert dict(longer[-1].ships) == {}
    assert longer[-1].arrived == plain[-1].arrived


def test_plant_is_the_model_so_that_the_first_step_of_a_plan_is_what_is_sailed(
    solver: AbstractLocalSolver,
) -> None:
    frames = sail(crossing(), solver, 30)

    for now, then in itertools.pairwise(frames):
        for id_, each in now.ships.items():
            after = then.ships[id_].pose
            assert each.plan.poses[1] == pytest.approx([after.x, after.y, after.course], abs=1e-9)


def test_command_of_a_frame_is_that_of_the_plan_within_the_banks(solver: AbstractLocalSolver) -> None:
    for frame in sail(crossing(), solver, 30):
        for now in frame.ships.values():
            assert -60.0 <= now.offset <= 60.0
            assert 0.0 <= now.speed_factor <= 1.0


# --- routes that bend


def bent() -> Scenario:
    """A waterway with a bend of 40 degrees, sailed in both senses, to starboard of its middle."""
    reach = Waterway(
        id="reach", centreline=np.array([[0.0, -1500.0], [0.0, 0.0], [960.0, 1140.0]]), width=160.0
    )
    on = Waters(ruleset="tran2026", waterways=(reach,))
    return _sailed_from_the_beginning(
        on, {A: (Leg("reach", Towards.END, 20.0),), B: (Leg("reach", Towards.START, 20.0),)}
    )


def over_two_legs() -> Scenario:
    """From a canal into a river that it meets."""
    on = Waters(ruleset="tran2026", waterways=waters(width=160.0).waterways)
    return _sailed_from_the_beginning(
        on, {A: (Leg("canal", Towards.END), Leg("river", Towards.END))}, before=1800.0
    )


def _sailed_from_the_beginning(
    on: Waters, routes: dict[str, tuple[Leg, ...]], before: float = 0.0
) -> Scenario:
    plans = []
    for id_, legs in routes.items():
        start = guiding_line(on, legs).frame.to_ned(PathPose(200.0 + before, 0.0, 0.0))
        plans.append(Plan(ship=ship(A if id_ == A else B), route=legs, start=start, speed=SPEED))
    return replace(scenario(*plans, on=on), control=CONTROL)


@pytest.mark.parametrize("of", [bent(), over_two_legs()], ids=["bend", "two legs"])
def test_route_with_a_corner_is_sailed_to_its_end_without_leaving_the_banks(
    of: Scenario, solver: AbstractLocalSolver
) -> None:
    frames = sail(of, solver)
    found = summary(of, frames, "riccati")

    assert found["groundings"] == 0
    assert found["collisions"] == 0
    assert frames[-1].arrived.keys() == {each.ship.id for each in of.ships}


def test_ship_on_two_legs_says_on_which_it_is(solver: AbstractLocalSolver) -> None:
    of = over_two_legs()
    last = sail(of, solver)[-1].ships[A].pose

    assert of.waters.waterway("river").holds(NedPose(last.x - 100.0, last.y, last.course))
    assert last.course == pytest.approx(0.0, abs=0.05)  # north


# --- rules by place


def border() -> Waters:
    east = Region(
        id="east",
        ruleset="tran2026_printed",
        polygon=np.array([[-4e3, 0], [-4e3, 4e3], [4e3, 4e3], [4e3, 0.0]]),
    )
    return replace(ON, regions=(east,))


def test_ships_under_different_rulesets_fall_back_to_the_safe_mutual_rule(
    solver: AbstractLocalSolver,
) -> None:
    """A ship that has not the law of the pair judges by what it has."""
    lacking = replace(plan(A, EAST, before=600.0), rulesets=("tran2026",))
    of = scenario(lacking, plan(B, WEST, before=600.0), on=border())
    (first,) = sail(replace(of, control=CONTROL), solver, 1)

    assert {id_: now.ruleset for id_, now in first.ships.items()} == {A: "tran2026", B: "tran2026_printed"}
    (settlement,) = first.settlements
    assert re.search(r"a judges by tran2026 .* for want of .*, b by tran2026_printed", settlement.fallback)
    assert settlement.mutual
    assert first.generations == ((A,), (B,))  # equal mass: the smaller id first


def test_ruleset_changes_with_the_place_of_the_ship(solver: AbstractLocalSolver) -> None:
    of = scenario(plan(A, EAST, before=100.0), on=border())
    frames = sail(replace(of, control=CONTROL), solver, 4)

    assert [frame.ships[A].ruleset for frame in frames] == ["tran2026"] * 2 + ["tran2026_printed"] * 2


def identifiers(file: Path) -> set[str]:
    """All names that a module makes or uses, and the words of its strings that are no docstrings."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    found: set[str] = set()
    for node in ast.walk(tree):
        for attribute in ("id", "attr", "arg", "name", "module"):
            value = getattr(node, attribute, None)
            if isinstance(value, str):
                found.add(value)
    return {word for name in found for word in re.split(r"[_.]|(?<=[a-z])(?=[A-Z])", name.lower())} | found


def test_layer_2_names_no_rule_no_article_and_no_region() -> None:
    words = {"rule", "ruleset", "article", "regulation", "citation", "region", "verdict"}
    forbidden = words | {f"{word}s" for word in words} | {*RULESETS, "bpr", "ccnr", "cevni", "colregs"}
    modules = sorted(Path(ccas_core.dmpc.__file__).parent.glob("*.py"))

    assert len(modules) > 10
    assert {file.name: found for file in modules if (found := identifiers(file) & forbidden)} == {}


def test_layer_2_sails_under_another_ruleset_with_the_same_code(solver: AbstractLocalSolver) -> None:
    modules = {name: module for name, module in sys.modules.items() if name.startswith("ccas_core.dmpc")}
    contents = {name: dict(vars(module)) for name, module in modules.items()}
    for id_ in ("tran2026", "tran2026_printed"):
        frames = sail(crossing(replace(ON, ruleset=id_)), solver, 5)

        assert {now.ruleset for frame in frames for now in frame.ships.values()} == {id_}
    for name, module in modules.items():
        assert all(vars(module).get(key) is value for key, value in contents[name].items())
