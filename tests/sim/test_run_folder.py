"""A run folder: the contract's columns and keys, streaming, and what happens when the disk says no."""

from __future__ import annotations

import errno
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from ccas_core.errors import InputError
from ccas_core.priority import Edge, EdgeKind, Opening
from ccas_core.roles import PassingSide
from ccas_core.sim import run_folder
from ccas_core.sim.frame import Frame
from ccas_core.sim.metrics import summary
from ccas_core.sim.run_folder import RunWriter
from ccas_core.sim.run_reading import read_run
from ccas_core.verdict import Kind

from . import EAST, WEST, A, B, Settled, always, plan, scenario, settlement, voyage

HEAD_ON = scenario(plan(A, EAST, before=600.0), plan(B, WEST, before=600.0))
TEXT = "schema: ccas/scenario@1\nname: by hand, Überfahrt bei 3 m/s\n"
GIVE_WAY = settlement(Kind.GIVE_WAY, Kind.STAND_ON, side=PassingSide.PORT_TO_PORT)
NONE = settlement(Kind.NONE, Kind.NONE)
ALWAYS = always(GIVE_WAY)
HEADER = "time_s,ship,east_m,north_m,course_rad,speed_mps,u_y_m,u_s,safety_index_m,ruleset"


def sailed(settled: Settled = ALWAYS, periods: int = 6) -> list[Frame]:
    return voyage(HEAD_ON, {A: [(0.0, 1.0), (30.0, 1.0)], B: [(-0.0, 1.0)]}, settled, periods)


def written(folder: Path, frames: Sequence[Frame], solver: str = "ddp") -> Path:
    with RunWriter(folder, HEAD_ON, TEXT) as writer:
        for frame in frames:
            writer.write(frame)
        writer.finish(summary(HEAD_ON, frames, solver))
    return folder


def decisions(folder: Path) -> list[dict[str, Any]]:
    text = (folder / "decisions.jsonl").read_text(encoding="utf-8")
    return [json.loads(line) for line in text.splitlines()]


def names(folder: Path) -> set[str]:
    return {file.name for file in folder.iterdir()}


# --- the files


def test_frames_have_the_columns_of_the_contract_and_one_row_a_ship_and_period(tmp_path: Path) -> None:
    lines = (written(tmp_path / "run", sailed()) / "frames.csv").read_text(encoding="utf-8").splitlines()

    assert lines[0] == HEADER
    assert len(lines) == 1 + 2 * 6
    assert lines[1] == "0.000,a,-600.0000,0.0000,1.570796,3.00000,0.0000,1.000000,1148.5000,bpr"
    assert lines[2] == "0.000,b,600.0000,0.0000,-1.570796,3.00000,0.0000,1.000000,1148.5000,bpr"


def test_ship_alone_has_an_empty_safety_index(tmp_path: Path) -> None:
    alone = [replace(frame, ships={A: frame.ships[A]}, settlements=()) for frame in sailed(periods=1)]

    folder = written(tmp_path / "run", alone)

    assert (folder / "frames.csv").read_text(encoding="utf-8").endswith(",1.000000,,bpr\n")
    assert read_run(folder).rows[0].safety_index is None


def test_same_voyage_gives_the_same_bytes(tmp_path: Path) -> None:
    one, other = written(tmp_path / "one", sailed()), written(tmp_path / "other", sailed())

    for name in ("frames.csv", "decisions.jsonl", "plans.jsonl", "scenario.yaml", "summary.json"):
        assert (one / name).read_bytes() == (other / name).read_bytes()


def test_decision_has_the_keys_of_the_contract(tmp_path: Path) -> None:
    first = decisions(written(tmp_path / "run", sailed()))[0]

    assert {key: first[key] for key in first if key != "verdicts"} == {
        "time_s": 0.0,
        "pair": ["a", "b"],
        "applied": "agreed",
        "why": None,
        "geometry": "head_on",
        "edge": {"first": "a", "then": "b", "kind": "duty"},
        "opened": [],
    }
    assert set(first["verdicts"]) == {"a", "b"}
    assert first["verdicts"]["b"] == {
        "kind": "stand_on",
        "give_way": ["a"],
        "stand_on": ["b"],
        "pass": "port_to_port",
        "article": "BPR 6.04",
        "ruleset": "bpr",
        "version": "1",
        "rule": "by_hand",
        "reason": "made by hand",
        "geometry": "head_on",
        "strength": "",
        "pass_required": False,
        "side_chosen_by": None,
        "initiator": None,
        "confidence": "unverified",
        "facts": {"is_near": True, "tcpa_s": None},
    }


def test_fallback_says_why(tmp_path: Path) -> None:
    frames = sailed(always(settlement(Kind.GIVE_WAY, Kind.NONE)))

    first = decisions(written(tmp_path / "run", frames))[0]

    assert (first["applied"], first["why"]) == ("fallback", "a sees give_way, b sees none")


def test_decision_names_the_edges_that_were_opened(tmp_path: Path) -> None:
    opening = Opening(Edge(A, B, EdgeKind.DUTY), "lightest first")

    lines = decisions(written(tmp_path / "run", [replace(frame, openings=(opening,)) for frame in sailed()]))

    assert lines[0]["opened"] == [["a", "b", "lightest first"]]


def test_a_decision_a_period_while_in_an_encounter_and_one_where_it_ends(tmp_path: Path) -> None:
    table = {0: (NONE,), 1: (GIVE_WAY,), 2: (GIVE_WAY,), 3: (), 4: (NONE,), 5: (NONE,)}

    lines = decisions(written(tmp_path / "run", sailed(table.__getitem__)))

    assert [(line["time_s"], line["verdicts"]["a"]["kind"]) for line in lines] == [
        (20.0, "give_way"),
        (40.0, "give_way"),
        (80.0, "none"),
    ]


def test_run_is_read_as_it_was_written(tmp_path: Path) -> None:
    frames = sailed()

    run = read_run(written(tmp_path / "run", frames))

    assert run.scenario == TEXT
    assert run.summary == summary(HEAD_ON, frames, "ddp")
    assert [row.time for row in run.rows] == [frame.time for frame in frames for _ in range(2)]
    for row, (id_, ship) in zip(run.rows, [each for f in frames for each in f.ships.items()], strict=True):
        assert (row.ship, row.ruleset) == (id_, ship.ruleset)
        assert (row.north, row.east) == pytest.approx((ship.pose.x, ship.pose.y), abs=1e-4)
        assert row.course == pytest.approx(ship.pose.course, abs=1e-6)
    assert len(run.decisions) == 6


def test_ship_that_has_arrived_has_no_row(tmp_path: Path) -> None:
    frames = [replace(frame, arrived={B: 30.0} if frame.index >= 2 else {}) for frame in sailed()]

    rows = read_run(written(tmp_path / "run", frames)).rows

    assert [row.time for row in rows if row.ship == B] == [0.0, 20.0]


# --- while it is written


def test_folder_appears_with_the_first_frame(tmp_path: Path) -> None:
    folder = tmp_path / "runs" / "first"
    with RunWriter(folder, HEAD_ON, TEXT) as writer:
        assert not folder.parent.exists()

        writer.write(sailed()[0])

        assert names(folder) == {"scenario.yaml", "frames.csv", "decisions.jsonl", "plans.jsonl"}


def test_run_that_is_broken_off_can_be_read(tmp_path: Path) -> None:
    def break_off(writer: RunWriter) -> None:
        for frame in sailed()[:3]:
            writer.write(frame)
        assert len(read_run(tmp_path / "run").rows) == 6  # on the disk while the voyage goes on
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), RunWriter(tmp_path / "run", HEAD_ON, TEXT) as writer:
        break_off(writer)

    run = read_run(tmp_path / "run")
    assert (len(run.rows), len(run.decisions), run.summary) == (6, 3, None)


def test_half_a_line_at_the_end_is_not_read(tmp_path: Path) -> None:
    folder = written(tmp_path / "run", sailed())
    for name in ("frames.csv", "decisions.jsonl", "plans.jsonl"):
        (folder / name).write_bytes((folder / name).read_bytes()[:-9])

    run = read_run(folder)

    assert (len(run.rows), len(run.decisions), len(run.plans)) == (11, 5, 5)


def test_run_without_frames_has_no_summary(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run", HEAD_ON, TEXT)

    with pytest.raises(ValueError, match="without frames"):
        writer.finish({})

    assert names(tmp_path) == set()


# --- a place that is taken


def test_earlier_run_is_replaced_and_what_is_not_ours_stays(tmp_path: Path) -> None:
    folder = written(tmp_path / "run", sailed(), solver="ipopt")
    for name in ("paths.png", "replay.html", "notes.txt"):
        (folder / name).write_text("", encoding="utf-8")

    with RunWriter(folder, HEAD_ON, TEXT) as writer:
        assert "summary.json" in names(folder)  # nothing is lost before there is something new
        writer.write(sailed()[0])

    assert names(folder) == {"scenario.yaml", "frames.csv", "decisions.jsonl", "plans.jsonl", "notes.txt"}
    assert len(read_run(folder).rows) == 2


def test_empty_folder_is_taken(tmp_path: Path) -> None:
    assert "summary.json" in names(written(tmp_path, sailed()))


def test_folder_of_something_else_is_refused_before_the_voyage(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("", encoding="utf-8")

    with pytest.raises(InputError, match="not empty and not a run") as caught:
        RunWriter(tmp_path, HEAD_ON, TEXT)

    assert "--out" in caught.value.diagnostics[0].hint
    assert names(tmp_path) == {"thesis.tex"}


def test_file_in_the_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run").write_text("", encoding="utf-8")

    with pytest.raises(InputError, match="is a file"):
        RunWriter(tmp_path / "run", HEAD_ON, TEXT)


# --- a disk that says no


def test_folder_that_cannot_be_made_is_told_with_its_cause(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")

    with RunWriter(tmp_path / "file" / "run", HEAD_ON, TEXT) as writer, pytest.raises(InputError) as caught:
        writer.write(sailed()[0])

    (told,) = caught.value.diagnostics
    assert told.source.startswith(str(tmp_path / "file"))
    assert told.message == "cannot be written: Not a directory"
    assert "--out" in told.hint


def no_space(*_: object) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")


def test_full_disk_is_told_and_what_was_written_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = sailed()
    with RunWriter(tmp_path / "run", HEAD_ON, TEXT) as writer:
        writer.write(frames[0])
        monkeypatch.setattr(run_folder, "_csv", no_space)

        with pytest.raises(InputError, match="No space left on device"):
            writer.write(frames[1])

    assert len(read_run(tmp_path / "run").rows) == 2


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_frames_on_a_full_device_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened = Path.open

    def on_a_full_device(file: Path, mode: str, **options: Any) -> Any:  # noqa: ANN401
        return opened(Path("/dev/full") if file.name == "frames.csv" else file, mode, **options)

    monkeypatch.setattr(Path, "open", on_a_full_device)
    writer = RunWriter(tmp_path / "run", HEAD_ON, TEXT)

    with pytest.raises(InputError, match="No space left on device"):
        writer.write(sailed()[0])
    with pytest.raises(InputError, match="No space left on device"):
        writer.close()


def test_summary_is_there_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.fsync", no_space)

    with pytest.raises(InputError, match="No space left on device"):
        written(tmp_path / "run", sailed())

    assert "summary.json" not in names(tmp_path / "run")
    assert read_run(tmp_path / "run").summary is None


# --- reading what is not a run


def test_folder_without_a_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no run is here"):
        read_run(tmp_path)


@pytest.mark.parametrize(
    ("name", "content", "place"),
    [
        ("frames.csv", b"time_s,ship\n0,a\n", "frames.csv:2:1"),
        ("frames.csv", HEADER.encode() + b"\nsoon,a,0,0,0,0,0,0,0,bpr\n", "frames.csv:2:1"),
        ("frames.csv", b"\xff\xfe\n", "frames.csv:1:1"),
        ("decisions.jsonl", b"{}\n{\n", "decisions.jsonl:2:1"),
        ("summary.json", b"[]", "summary.json:1:1"),
    ],
)
def test_damaged_file_is_told_with_its_place(tmp_path: Path, name: str, content: bytes, place: str) -> None:
    folder = written(tmp_path / "run", sailed())
    (folder / name).write_bytes(content)

    with pytest.raises(InputError, match=place):
        read_run(folder)


def test_missing_file_of_a_run_is_told(tmp_path: Path) -> None:
    folder = written(tmp_path / "run", sailed())
    (folder / "scenario.yaml").unlink()

    with pytest.raises(InputError, match=r"scenario\.yaml: cannot be read: No such file"):
        read_run(folder)
