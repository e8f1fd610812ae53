"""`ccas bench`: what it measures has the keys that others rely on; times are not judged here."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ccas_cli import bench, measuring
from ccas_core.dmpc.solvers import AbstractLocalSolver, Task
from ccas_core.plugins import Plugins
from ccas_core.sim.scenario import Scenario

from . import ccas

pytest.importorskip("numba")


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sail the shortest case, and start nothing up: what is measured is the same."""
    monkeypatch.setattr(bench, "VOYAGE", "tran2026/fig_10")
    monkeypatch.setattr(bench, "UPDATES", "tran2026/fig_10")
    monkeypatch.setattr(measuring, "start_up", lambda: {"help_seconds": 0.1})


def test_json_has_the_figures_that_others_read_and_text_shows_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "bench.png"
    done = ccas("bench", "--json", "--problems", "10", "--scale", "12,30", "--picture", picture)
    found = json.loads(done.stdout)
    update = found["update"]

    assert done.exit_code == 0
    assert {"speed_up_median", "speed_up_all_starts_median", "p99_ms", "not_worse_share"} <= update.keys()
    assert 0.0 <= update["not_worse_share"] <= 1.0
    assert update["problems"] >= 10
    assert update["solvers"].keys() == {"ipopt", "fatrop", "riccati"}
    assert [row["ships"] for row in found["scale"]] == [12, 30]
    assert all(
        row["cost_per_ship_ms"] * row["ships"] == pytest.approx(1e3 * row["seconds"])
        for row in found["scale"]
    )
    assert {"machine", "start_up", "voyage", "growth", "peak_memory_mib"} <= found.keys()
    assert picture.stat().st_size > 10_000

    bench._show(found)
    text = capsys.readouterr().out

    assert text.startswith("machine: python ")
    assert "times faster" in text
    assert "networks, one control period of 20 s" in text


def test_agreement_asks_all_shipped_scenarios(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    recorded = measuring.recorded

    def two_are_sailed(
        scenario: Scenario, plugins: Plugins, solver: AbstractLocalSolver, count: int
    ) -> list[Task]:
        asked.append(scenario.name)
        return (
            recorded(scenario, plugins, solver, count) if len(asked) <= 2 else []
        )  # the first is that of the updates

    monkeypatch.setattr(measuring, "HORIZONS", (6,))
    monkeypatch.setattr(measuring, "recorded", two_are_sailed)

    done = ccas("bench", "--json", "--problems", "10", "--scale", "0", "--agreement", "200")
    (row,) = json.loads(done.stdout)["agreement"]

    assert done.exit_code == 0
    assert len(asked) > 20
    assert row["problems"] == row["compared"] == row["all_starts"]["compared"] > 0
    assert row["outside_bounds"] == 0


@pytest.mark.parametrize(
    "arguments",
    ["--scale x", "--scale -5", "--scale 5", "--scale 100,,200", "--scale 1e3", "--problems 3",
     "--problems x", "--agreement -1", "--picture bench.txt", "--picture nowhere/bench.png"],
)  # fmt: skip
def test_nonsense_is_refused_before_anything_is_measured(arguments: str) -> None:
    done = ccas("bench", *arguments.split())

    assert done.exit_code == 2
    assert done.stdout == ""
    assert "Error: " in done.stderr
