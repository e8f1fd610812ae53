"""Ships that negotiate, ships that a controller steers, and ships that AIS alone tells of, in one voyage."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import islice
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from ccas_core import plugins
from ccas_core.controllers import AbstractController, Option, Outlook, Steering
from ccas_core.dmpc.solvers import make_solver
from ccas_core.errors import ScenarioError
from ccas_core.frames import NedTrajectory
from ccas_core.quantities import SPEED
from ccas_core.roles import Geometry, Role
from ccas_core.ships import ShipId
from ccas_core.sim.frame import Frame
from ccas_core.sim.given_track import MADE_GOOD, GivenTrack, recorded
from ccas_core.sim.metrics import summary
from ccas_core.sim.scenario import Scenario
from ccas_core.sim.scenario_dump import dump_scenario
from ccas_core.sim.scenario_file import load_scenario, parse_scenario
from ccas_core.sim.voyage import voyage
from ccas_core.surge_yaw import Motion

A, B = ShipId("a"), ShipId("b")
RULESETS = plugins.load().rulesets
SOLVER = make_solver("riccati")
SHIP = "length: 60 m, beam: 8 m, weight: 800 t, facts: {propulsion: motor}"
TEXT = """\
schema: ccas/scenario@1
name: mixed
time: {{step: 20 s}}
waters:
  ruleset: bpr
  current: {{speed: 0.4 m/s, towards: 20 deg}}
  waterways: [{{id: canal, centreline: [[-3000, 0], [3000, 0]], width: 300 m}}]
ships:
  - {{id: a, {ship}, route: [{{waterway: canal, towards: end}}], start: [-1200, 0], speed: 3 m/s{one}}}
  - {{id: b, {ship}, route: [{{waterway: canal, towards: start}}], start: [1200, 0], speed: 3 m/s{other}}}
"""
HOSTILE = """
time_s,east_m,north_m,course_rad,speed_mps
0,1200,0,-1.5708,3
60,1020,0,-1.5708,3
80,,,-1.5708,3
120,nan,0,-1.5708,3
140,780,0,-1.5708,
180,660,0,,3
200,600,900,-1.5708,3
201,597,0,-1.5708,3
300,300,0,-1.5708,3
"""


class Straight(AbstractController):
    """A controller that goes on, and writes down what it is told."""

    name = "straight"
    options = MappingProxyType({"surge": Option(meaning="speed", default=3.0, quantity=SPEED)})

    def __init__(self) -> None:
        self.seen: list[Outlook] = []

    def steer(self, outlook: Outlook, memory: Any) -> Steering:  # noqa: ANN401
        """Go on."""
        self.seen.append(outlook)
        pose = outlook.pose
        plan = NedTrajectory(np.array([[pose.x, pose.y, pose.course]] * 2))
        count = (memory or 0) + 1
        return Steering(motion=Motion(float(outlook.options.get("surge", 3.0)), 0.0), plan=plan, memory=count)


class Broken(Straight):
    """A controller that raises, or gives what is no number."""

    def __init__(self, answer: object) -> None:
        super().__init__()
        self._answer: Any = answer

    def steer(self, outlook: Outlook, memory: Any) -> Steering:  # noqa: ANN401
        """Fail."""
        if isinstance(self._answer, Exception):
            raise self._answer
        if isinstance(self._answer, float):
            good = super().steer(outlook, memory)
            return Steering(motion=Motion(self._answer, 0.0), plan=good.plan)
        return self._answer  # type: ignore[no-any-return]


def scenario(one: str, other: str, controllers: Mapping[str, AbstractController] | None = None) -> Scenario:
    text = TEXT.format(ship=SHIP, one=one, other=other)
    return parse_scenario(text, controllers=controllers or {"straight": Straight()})


def sail(of: Scenario, periods: int = 200, **controllers: AbstractController) -> list[Frame]:
    return list(islice(voyage(of, RULESETS, SOLVER, controllers), periods))


# --- who moves how -------------------------------------------------------------------------------


def test_cooperative_ship_keeps_clear_of_a_tracked_one() -> None:
    of = scenario("", ", control: tracked")
    frames = sail(of)
    found: dict[str, Any] = summary(of, frames, "riccati")

    assert found["collisions"] == found["entries"] == found["frozen"] == 0
    assert found["ships"]["b"]["max_offset_change_m"] == 0.0
    assert found["ships"]["a"]["max_offset_change_m"] > 10.0
    assert all(frame.ships[B].pose.x == pytest.approx(0.0, abs=1e-9) for frame in frames if B in frame.ships)


def test_ships_that_cooperate_need_not_wait_for_a_tracked_one() -> None:
    frames = sail(scenario("", ", control: tracked"), 5)

    assert all(not frame.ships[A].fallback for frame in frames)
    assert [frame.settlements[0].fallback for frame in frames] == [""] * 5  # judged for it, under its ruleset


def test_controller_is_told_the_bearing_of_the_priority_graph_and_no_rule() -> None:
    straight = Straight()
    sail(scenario(", control: straight", ", control: tracked"), 3, straight=straight)
    (target,) = straight.seen[-1].targets

    assert (target.bearing.geometry, target.bearing.role) == (Geometry.HEAD_ON, Role.BOTH)
    assert not hasattr(target, "report")
    assert target.speed == 3.0


def test_same_controller_gets_another_bearing_under_another_ruleset() -> None:
    text = TEXT.format(ship=SHIP, one=", control: straight", other=", control: tracked")
    roles = {}
    for ruleset in ("bpr", "ccnr"):
        straight = Straight()
        changed = text.replace("bpr", ruleset).replace("width: 300 m", "width: 300 m, upstream: start")
        sail(parse_scenario(changed, controllers={"straight": straight}), 2, straight=straight)
        roles[ruleset] = straight.seen[-1].targets[0].bearing.role

    assert roles == {"bpr": Role.BOTH, "ccnr": Role.STAND_ON}


def test_ship_under_a_controller_drifts_with_the_current() -> None:
    frames = sail(scenario(", control: straight", ", control: tracked"), 3, straight=Straight())
    here, there = frames[0].ships[A].pose, frames[1].ships[A].pose

    assert there.x - here.x == pytest.approx(20.0 * 0.4 * math.cos(math.radians(20.0)))
    assert there.y - here.y == pytest.approx(20.0 * (3.0 + 0.4 * math.sin(math.radians(20.0))))


def test_controller_gets_its_memory_and_its_options() -> None:
    straight = Straight()
    frames = sail(
        scenario(", control: {by: straight, surge: 2.9 m/s}", ", control: tracked"), 4, straight=straight
    )

    assert straight.seen[0].options == {"surge": 2.9}
    assert frames[-1].ships[A].motion == Motion(2.9, 0.0)


@pytest.mark.parametrize("answer", [ValueError("no idea"), math.nan, None])
def test_controller_that_fails_leaves_a_safe_command(answer: object) -> None:
    of = scenario(", control: straight", ", control: tracked")
    frames = sail(of, 12, straight=Broken(answer))
    surges = [frame.ships[A].motion.surge for frame in frames]  # type: ignore[union-attr]

    assert all(
        "straight" in frame.ships[A].fallback and "slows down" in frame.ships[A].fallback for frame in frames
    )
    assert surges == sorted(surges, reverse=True)
    assert np.isfinite([[s.pose.x, s.pose.y] for frame in frames for s in frame.ships.values()]).all()


def test_controller_cannot_ask_for_more_than_the_ship_can() -> None:
    of = scenario(", control: {by: straight, surge: 9 m/s}", ", control: tracked")
    frames = sail(of, 5, straight=Straight())

    assert max(frame.ships[A].motion.surge for frame in frames) == 3.0  # type: ignore[union-attr]


def test_controller_that_nobody_offers_is_refused() -> None:
    of = scenario(", control: straight", "")

    with pytest.raises(ScenarioError, match="'straight', which no plugin offers"):
        sail(of, 1)


# --- hostile traffic -----------------------------------------------------------------------------


def hostile(tmp_path: Path, one: str) -> Scenario:
    (tmp_path / "ais.csv").write_text(HOSTILE.lstrip(), encoding="utf-8")
    text = TEXT.format(ship=SHIP, one=one, other=", control: tracked, track: {csv: ais.csv}")
    (tmp_path / "mixed.yaml").write_text(text, encoding="utf-8")
    return load_scenario(tmp_path / "mixed.yaml", controllers={"straight": Straight()})


@pytest.mark.parametrize("one", ["", ", control: straight"])
def test_hostile_traffic_leaves_a_command_and_is_told(tmp_path: Path, one: str) -> None:
    frames = sail(hostile(tmp_path, one), straight=Straight())
    said = " / ".join(each for frame in frames for each in frame.ships[A].saw if A in frame.ships)
    commands = [(s.offset, s.speed_factor) for frame in frames for s in frame.ships.values()]

    for what in (
        "reports no position",
        "reports no speed",
        "reports no course",
        "has jumped by",
        "has been silent for",
    ):
        assert f"b {what}" in said
    assert np.isfinite(commands).all()
    assert A in frames[-1].arrived
    assert B not in frames[-1].ships


def test_track_of_a_scenario_is_written_and_read_as_the_same(tmp_path: Path) -> None:
    controllers = {"straight": Straight()}
    of = hostile(tmp_path, ", control: {by: straight, surge: 2.5 m/s}, domain: dynamic_bumper")
    again = parse_scenario(dump_scenario(of, controllers=controllers), controllers=controllers)
    one, other = of.ships[1].track, again.ships[1].track

    assert one is not None
    assert other is not None
    assert np.array_equal(np.isnan(one.rows), np.isnan(other.rows))
    assert np.allclose(np.nan_to_num(one.rows), np.nan_to_num(other.rows))
    assert again.ships[0] == of.ships[0]
    assert again.waters.current.north == pytest.approx(of.waters.current.north)


def test_track_sails_straight_between_its_rows() -> None:
    track = GivenTrack(np.array([[0.0, 0.0, 0.0, MADE_GOOD, 9.0], [10.0, 0.0, 50.0, MADE_GOOD, math.nan]]))
    pose, speed = track.sailed(4.0)

    assert (pose.x, pose.y, pose.course, speed) == pytest.approx((0.0, 20.0, math.pi / 2.0, 5.0))
    assert track.reported(4.0) == (pose, 9.0)
    assert math.isnan(track.reported(10.0)[1])


@pytest.mark.parametrize(
    ("table", "why"),
    [
        ("a,b\n1,2\n", "the column 'time_s' is missing"),
        ("time_s,east_m,north_m\n", "no rows"),
        ("time_s,east_m,north_m\n0,1,2\n", "two rows with a position"),
        ("time_s,east_m,north_m\n0,1,2\n0,1,2\n", "times that rise"),
        ("time_s,east_m,north_m\nx,1,2\n1,1,2\n", "a row has no time"),
    ],
)
def test_table_that_is_no_track_is_refused(table: str, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        recorded(table.splitlines())


def test_recorded_run_is_a_track_of_one_of_its_ships() -> None:
    lines = ["time_s,ship,east_m,north_m", "0,a,0,0", "0,b,5,5", "20,a,60,0", "20,b,5,65"]

    assert recorded(lines, "b").sailed(10.0)[0].x == 35.0


# --- files ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("one", "said"),
    [
        (", control: bumpr", "unknown controller 'bumpr'"),
        (", control: {by: straight, surge: 3}", "has no unit"),
        (", control: {by: straight, surg: 3 m/s}", "did you mean 'surge'"),
        (", control: tracked, track: []", "a list of 0"),
        (", control: tracked, track: {csv: nowhere.csv}", "cannot be read"),
        (", track: [{time: 0 s, at: [0, 0]}, {time: 9 s, at: [9, 0]}]", "only a tracked ship has a track"),
        (", control: tracked, conduct: silent", "only a cooperative ship has a conduct"),
        (", control: tracked, track: [{time: 0 s, at: [0, 0]}, {time: 0 s, at: [9, 0]}]", "times that rise"),
        (", control: tracked, track: [{time: 0 s, at: unknown}, {time: 9 s, at: [9, 0]}]", "two rows"),
        (", domain: circle", "one of rectangle, ellipse, dynamic_bumper"),
        (", manoeuvring: {max_speed: 0 m/s}", "out of range"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(one: str, said: str) -> None:
    with pytest.raises(ScenarioError, match="scenario:9:") as refused:
        scenario(one, "")
    assert said in str(refused.value)
