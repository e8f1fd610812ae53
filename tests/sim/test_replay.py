"""What a replay shows: the same as the run folder, in whole numbers, and in a page that asks for nothing."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import replace
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ccas_core.errors import InputError
from ccas_core.priority import Edge, EdgeKind, Opening
from ccas_core.regions import Region
from ccas_core.ships import ShipId
from ccas_core.sim import replay_ships
from ccas_core.sim.frame import Frame
from ccas_core.sim.metrics import summary
from ccas_core.sim.replay import replay
from ccas_core.sim.replay_page import page, write_page
from ccas_core.sim.run_folder import RunWriter
from ccas_core.sim.run_reading import read_run
from ccas_core.sim.scenario import Scenario
from ccas_core.verdict import Kind
from ccas_core.waterway import Obstacle

from . import EAST, NORTH, WEST, A, B, Settled, always, plan, scenario, settlement, voyage, waters

RHINE = Region(id="rhine", ruleset="ccnr", polygon=np.array([[-900.0, 0.0], [900.0, 0.0], [0.0, 2000.0]]))
CHART = replace(waters(obstacles=(Obstacle(id="pier", x=50.0, y=100.0, radius=15.0),)), regions=(RHINE,))
HEAD_ON = scenario(plan(A, EAST, before=600.0), plan(B, WEST, before=600.0, aside=20.0), on=CHART)
GIVE_WAY = settlement(Kind.GIVE_WAY, Kind.STAND_ON)
MUTUAL = settlement(Kind.MUTUAL, Kind.MUTUAL)
APART = settlement(Kind.STAND_ON, Kind.STAND_ON)  # views that do not fit
NONE = settlement(Kind.NONE, Kind.NONE)
ALWAYS = always(GIVE_WAY)
MOST_BYTES = 500_000  # of a page with six ships and 120 periods


def sailed(settled: Settled = ALWAYS, periods: int = 40) -> list[Frame]:
    return voyage(HEAD_ON, {A: [(0.0, 1.0)], B: [(20.0, 1.0), (20.0, 0.5)]}, settled, periods)


def written(folder: Path, frames: list[Frame], of: Scenario = HEAD_ON, *, whole: bool = True) -> Path:
    with RunWriter(folder, of, "schema: ccas/scenario@1\n") as writer:
        for frame in frames:
            writer.write(frame)
        if whole:
            writer.finish(summary(of, frames, "by hand"))
    return folder


def shown(folder: Path, of: Scenario = HEAD_ON) -> dict[str, Any]:
    return replay(of, read_run(folder), folder)


def verdicts_at(told: Mapping[str, Any], frame: int) -> list[dict[str, Any]]:
    return [told["verdicts"][n] for first, after, n in told["spans"] if first <= frame < after]


def kinds(told: Mapping[str, Any]) -> list[tuple[float, str]]:
    return [(event["time_s"], event["kind"]) for event in told["events"]]


# --- numbers


def test_ships_are_told_in_the_units_of_the_names(tmp_path: Path) -> None:
    folder = written(tmp_path / "run", sailed())

    told = shown(folder)

    rows = [row for row in read_run(folder).rows if row.ship == B]
    ship = told["ships"][1]
    assert (ship["id"], ship["count"], ship["first"]) == ("b", len(rows), 0)
    assert (ship["length_m"], ship["safety_beam_m"], ship["nominal_mps"]) == (103.0, 17.2, 3.0)
    for key, scale, values in (
        ("east_dm", 10.0, [row.east for row in rows]),
        ("north_dm", 10.0, [row.north for row in rows]),
        ("course_mrad", 1000.0, [row.course for row in rows]),
        ("speed_cmps", 100.0, [row.speed for row in rows]),
        ("offset_dm", 10.0, [row.offset for row in rows]),
        ("speed_percent", 100.0, [row.speed_factor for row in rows]),
    ):
        assert np.array([*accumulate(ship[key])]) / scale == pytest.approx(values, abs=0.51 / scale)
    assert np.array(ship["index_dm"]) / 10.0 == pytest.approx([r.safety_index for r in rows], abs=0.06)


def test_clearance_is_told_four_times_a_period_and_is_that_of_the_hulls(tmp_path: Path) -> None:
    folder = written(tmp_path / "run", sailed())

    told = shown(folder)

    found = [each for each in told["ships"][0]["clearance_dm"] if each is not None]
    least = read_run(folder).summary
    assert least is not None
    assert len(told["ships"][0]["clearance_dm"]) == 4 * 40
    assert found[0] == 10.0 * (1200.0 - 103.0 - 4 * 6.0)  # after four of the five seconds of a part
    assert min(found) / 10.0 == pytest.approx(least["min_clearance_m"], abs=0.06)


def test_nearest_ship_of_many_is_found_as_of_few(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = written(tmp_path / "run", sailed())
    few = shown(folder)["ships"]

    monkeypatch.setattr(replay_ships, "FEW", 1)

    assert shown(folder)["ships"] == few


def test_waters_are_told_east_first_with_rulesets_by_their_place(tmp_path: Path) -> None:
    told = shown(written(tmp_path / "run", sailed()))

    assert told["rulesets"] == ["bpr", "ccnr"]
    chart = told["waters"]
    assert [each["id"] for each in chart["waterways"]] == ["canal", "river"]
    assert chart["waterways"][0]["centreline_dm"] == [-30000, 0, 30000, 0]
    (region,) = chart["regions"]
    assert (region["id"], region["ruleset"]) == ("rhine", 1)
    assert region["polygon_dm"] == [0, -9000, 0, 9000, 20000, 0]
    assert chart["obstacles"] == [{"id": "pier", "at_dm": [1000, 500], "radius_m": 15.0}]
    assert len(chart["banks"]) == 1


def test_plans_are_told_as_the_run_folder_has_them(tmp_path: Path) -> None:
    folder = written(tmp_path / "run", sailed())

    told = shown(folder)

    assert len(told["plans"]) == 40
    assert told["plans"][0]["0"] == [0, -6000, 0]
    (folder / "plans.jsonl").unlink()  # as earlier versions left it
    assert shown(folder)["plans"] == []


# --- who gives way to whom


def test_verdicts_of_every_frame_are_those_of_the_decisions(tmp_path: Path) -> None:
    turns = [GIVE_WAY, GIVE_WAY, MUTUAL, APART, NONE, GIVE_WAY]
    folder = written(tmp_path / "run", sailed(lambda index: (turns[min(index, 5)],)))

    told = shown(folder)

    for decision in read_run(folder).decisions:
        views: Any = decision["verdicts"]
        time: Any = decision["time_s"]
        got = verdicts_at(told, told["times_s"].index(time))
        if decision["applied"] == "fallback":
            assert [(each["gives_way"], each["fallback"], len(each["views"])) for each in got] == [
                (["a", "b"], decision["why"], 2)
            ]
        elif views["a"]["kind"] == "none":
            assert got == []
        else:
            assert [each["gives_way"] for each in got] == [views["a"]["give_way"]]
            assert got[0]["views"][0]["article"] == views["a"]["article"]
    assert [(first, after) for first, after, _ in told["spans"]] == [(0, 2), (2, 3), (3, 4), (5, 40)]


def test_arrow_is_dashed_where_the_edge_is_an_order(tmp_path: Path) -> None:
    of = sailed(always(settlement(Kind.COOPERATE, Kind.COOPERATE)))

    (verdict,) = shown(written(tmp_path / "run", of))["verdicts"]

    assert (verdict["dashed"], verdict["first"], verdict["gives_way"]) == (True, "a", [])
    (duty,) = shown(written(tmp_path / "duty", sailed()))["verdicts"]
    assert (duty["dashed"], duty["first"], duty["gives_way"]) == (False, "a", ["a"])


# --- what happens


def test_events_tell_switches_fall_backs_and_the_closest_approach(tmp_path: Path) -> None:
    frames = sailed(lambda index: (APART if 3 <= index < 6 else GIVE_WAY,))
    for index in range(7, 40):
        ships = {**frames[index].ships, A: replace(frames[index].ships[A], ruleset="ccnr")}
        frames[index] = replace(frames[index], ships=ships)

    told = shown(written(tmp_path / "run", frames))

    assert [each for each in kinds(told) if each[1] in ("fallback", "switch")] == [
        (60.0, "fallback"),
        (140.0, "switch"),
    ]
    assert [each["text"] for each in told["events"] if each["kind"] == "switch"] == [
        "a goes from bpr to ccnr"
    ]
    assert told["ships"][0]["rulesets"] == [(0, 0), (1, 7)]
    assert sum(kind == "closest" for _, kind in kinds(told)) == 1


def test_deadlock_is_told_with_and_without_a_summary(tmp_path: Path) -> None:
    opening = Opening(Edge(A, B, EdgeKind.DUTY), "lightest first")
    frames = [replace(frame, openings=(opening,)) for frame in sailed(periods=5)]

    whole = shown(written(tmp_path / "whole", frames))
    broken = shown(written(tmp_path / "broken", frames, whole=False))

    assert (0.0, "deadlock") in kinds(whole)
    assert (0.0, "deadlock") in kinds(broken)
    assert verdicts_at(whole, 0)[0]["opened"] == ["lightest first"]


def test_hulls_that_touch_are_told_once(tmp_path: Path) -> None:
    of = scenario(plan(A, EAST, before=300.0), plan(B, WEST, before=300.0))
    frames = voyage(of, {A: [(0.0, 1.0)], B: [(0.0, 1.0)]}, ALWAYS, 30)

    told = shown(written(tmp_path / "run", frames, of), of)

    assert [kind for _, kind in kinds(told) if kind in ("collision", "closest")] == ["collision"]


def test_run_that_was_broken_off_is_shown_as_far_as_it_went(tmp_path: Path) -> None:
    told = shown(written(tmp_path / "run", sailed(periods=7), whole=False))

    assert told["complete"] is False
    assert (told["times_s"][-1], "end") in kinds(told)
    assert len(told["times_s"]) == 7


# --- files that do not fit


@pytest.mark.parametrize(
    ("file", "line", "instead", "message"),
    [
        ("frames.csv", 2, "0.000,z,0,0,0,0,0,1,,bpr", "frames.csv:2:1: ship 'z' is not one of scenario.yaml"),
        ("frames.csv", 3, "0.000,b,nan,0,0,0,0,1,,bpr", "frames.csv:3:1: a number is not finite"),
        ("frames.csv", 4, "0.000,a,0,0,0,0,0,1,,bpr", "frames.csv:4:1: ship 'a' was at 0 s and is at 0 s"),
        ("decisions.jsonl", 2, '{"time_s": 20.0}', "decisions.jsonl:2:1: cannot be understood"),
        ("plans.jsonl", 3, '{"time_s": 40.0, "ships": {"a": {}}}', "plans.jsonl:3:1: cannot be understood"),
        ("summary.json", 1, '{"deadlocks": [{}], "x": {', "summary.json:1:1: cannot be understood"),
    ],
)
def test_damaged_line_is_named(file: str, line: int, instead: str, message: str, tmp_path: Path) -> None:
    folder = written(tmp_path / "run", sailed(periods=5))
    lines = (folder / file).read_text(encoding="utf-8").splitlines()
    lines[line - 1] = instead
    (folder / file).write_text("\n".join(lines) + "\n", encoding="utf-8")

    with pytest.raises(InputError, match=re.escape(message)):
        shown(folder)


def test_summary_of_another_make_is_named(tmp_path: Path) -> None:
    folder = written(tmp_path / "run", sailed(periods=5))
    (folder / "summary.json").write_text('{"deadlocks": [{"time_s": null}]}', encoding="utf-8")

    with pytest.raises(InputError, match=r"summary.json:1:1: cannot be understood"):
        shown(folder)


def test_run_without_rows_and_one_that_is_too_large_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = written(tmp_path / "run", sailed(periods=5))
    monkeypatch.setattr(replay_ships, "MOST_ROWS", 9)
    with pytest.raises(InputError, match="10 rows are more than a page can show"):
        shown(folder)

    header = (folder / "frames.csv").read_text(encoding="utf-8").partition("\n")[0]
    (folder / "frames.csv").write_text(header + "\n", encoding="utf-8")

    with pytest.raises(InputError, match="no ship has sailed"):
        shown(folder)


# --- the page


def test_page_asks_for_nothing_and_no_name_breaks_out_of_it(tmp_path: Path) -> None:
    told = shown(written(tmp_path / "run", sailed()))
    told |= {"name": "</script><b>&", "title": "a\u2028b<!--"}

    text = page(told)

    assert not re.search(r"https?:|//\w|@import|url\(|<(img|iframe|object|embed)", text)
    assert re.findall(r"\b(?:src|href)\s*=\s*[\"']?([^\"'\s>]*)", text) == ["data:,"]
    assert text.count("</script>") == 2
    held = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert held is not None
    assert json.loads(held[1]) == json.loads(json.dumps(told))


def test_page_of_six_ships_and_120_periods_is_small(tmp_path: Path) -> None:
    ids = [ShipId(f"ship_{number}") for number in range(6)]
    legs = [EAST, WEST, NORTH]
    of = scenario(
        *(plan(id_, legs[n % 3], before=900.0 + 300.0 * n, aside=20.0 * n) for n, id_ in enumerate(ids))
    )
    weave = [(30.0 * math.sin(period), 0.4) for period in range(120)]
    pairs = [(one, other) for n, one in enumerate(ids) for other in ids[n + 1 :]]
    settled = always(*(_between(*pair) for pair in pairs))
    frames = voyage(of, dict.fromkeys(ids, weave), settled, 120)

    size = write_page(shown(written(tmp_path / "run", frames, of), of), tmp_path / "replay.html")

    assert len(frames) == 120
    assert size == (tmp_path / "replay.html").stat().st_size
    assert 30_000 < size < MOST_BYTES


def _between(one: ShipId, other: ShipId) -> Any:  # noqa: ANN401
    """Settle a pair that `settlement` has no mass for."""
    from ccas_core.priority import settle

    made = settlement(Kind.GIVE_WAY, Kind.STAND_ON)
    first, second = replace(made.one, own=one, other=other), replace(made.other, own=other, other=one)
    return settle(first, second, {one: 1.0, other: 2.0})


def test_page_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    told = shown(written(tmp_path / "run", sailed(periods=2)))

    with pytest.raises(InputError, match="cannot be written: No such file"):
        write_page(told, tmp_path / "nowhere" / "replay.html")
