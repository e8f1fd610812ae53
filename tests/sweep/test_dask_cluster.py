"""A Dask cluster of this machine: the same results as its own processes, whatever becomes of the workers."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from ccas_core.errors import InputError
from ccas_core.sweep import dask_cluster
from ccas_core.sweep.campaign import Progress, parquet_writer, run
from ccas_core.sweep.executor import execute
from ccas_core.sweep.spec import Sweep, parse_sweep
from ccas_core.sweep.tally import Result
from ccas_core.sweep.task import program
from ccas_core.sweep.workers import Status
from tests.sweep.test_workers import outcomes, work

distributed = pytest.importorskip("distributed")

SPEC = """
schema: ccas/sweep@1
name: tiny
seed: 4
rulesets: [tran2026]
cells:
  - {name: head_on, draw: head_on, count: 3}
  - {name: crossing, draw: crossing, count: 3}
"""

Cluster: TypeAlias = Any  # of Dask, which need not be there

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # Dask leaves sockets of killed workers


@pytest.fixture
def cluster() -> Iterator[Cluster]:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as made:
        yield made


def test_a_task_that_dies_hangs_or_raises_is_named_and_all_others_are_done(cluster: Cluster) -> None:
    tasks = ["a", "die", "b", "hang", "raise", "c"]

    found = outcomes(list(execute(cluster.scheduler_address, work, tasks, 1.0)))

    assert {task: found[task] for task in "abc"} == {task: (Status.DONE, task.upper()) for task in "abc"}
    assert found["die"][0] is Status.DIED
    assert found["hang"] == (Status.TIMEOUT, "took more than 1 s")
    assert found["raise"] == (Status.FAILED, "ValueError: this one is ill")


def test_a_sweep_whose_worker_is_killed_ends_with_the_results_of_local_processes(
    cluster: Cluster, tmp_path: Path
) -> None:
    killed: list[int] = []

    def kill(progress: Progress) -> None:
        if progress.done == 1:
            killed.append(next(iter(cluster.workers.values())).pid)
            os.kill(killed[0], signal.SIGKILL)

    far = run(on(cluster.scheduler_address), tmp_path / "far", program(), kill)
    near = run(on("local:2"), tmp_path / "near", program())
    parquet_writer()(far, tmp_path / "cases.parquet")

    assert killed
    assert [timeless(each) for each in far] == [timeless(each) for each in near]
    table = pytest.importorskip("pyarrow.parquet").read_table(tmp_path / "cases.parquet")
    assert table.column("case").to_pylist() == [each.case.name for each in near]
    assert table.column("faithful").to_pylist() == [True] * 6


def test_a_scheduler_that_does_not_answer_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_cluster, "CONNECT", 0.2)

    with pytest.raises(InputError, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1:9") as error:
        list(execute("tcp://127.0.0.1:9", work, ["a"], 1.0))

    assert "dask scheduler" in str(error.value)


def on(executor: str) -> Sweep:
    return parse_sweep(SPEC + f"executor: {executor}\n")


def timeless(result: Result) -> dict[str, Any]:
    return {**result.kept, "seconds": 0, "case": result.case.name, "status": result.status}
