"""Processes that do tasks: nothing is lost, what hangs or dies is named, the rest goes on."""

from __future__ import annotations

import os
import time

import pytest

from ccas_core.errors import InputError
from ccas_core.sweep import workers
from ccas_core.sweep.executor import execute
from ccas_core.sweep.workers import Done, Status


def work(task: str) -> str:
    """Do what the task says."""
    if task == "die":
        os._exit(7)
    if task == "hang":
        time.sleep(60.0)
    if task == "raise":
        raise ValueError("this one is ill")
    return task.upper()


def outcomes(done: list[Done[str]]) -> dict[str, tuple[Status, object]]:
    return {each.task: (each.status, each.result) for each in done}


@pytest.fixture
def quick_start(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "_START", 8.0)


@pytest.mark.usefixtures("quick_start")
def test_a_task_that_dies_hangs_or_raises_is_named_and_all_others_are_done() -> None:
    tasks = ["a", "die", "b", "hang", "raise", "c"]

    found = outcomes(list(workers.run(work, tasks, workers=2, deadline=1.0)))

    assert {task: found[task] for task in "abc"} == {task: (Status.DONE, task.upper()) for task in "abc"}
    assert found["die"] == (Status.DIED, "killed its process 3 times")
    assert found["hang"][0] is Status.TIMEOUT
    assert found["raise"][0] is Status.FAILED
    assert "ValueError: this one is ill" in str(found["raise"][1])


def test_results_do_not_depend_on_the_number_of_processes() -> None:
    tasks = [chr(ord("a") + n) for n in range(9)]

    one, two = (outcomes(list(execute(f"local:{n}", work, tasks, 10.0))) for n in (1, 2))

    assert one == two


@pytest.mark.parametrize("executor", ["local:0", "local:two", "cloud", "tcp:nowhere"])
def test_an_executor_that_does_not_exist_is_refused(executor: str) -> None:
    with pytest.raises(InputError, match="executor: cannot use"):
        list(execute(executor, work, ["a"], 1.0))
