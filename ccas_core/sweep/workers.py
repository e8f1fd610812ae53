"""Processes of one machine that do tasks: one private pipe each, a deadline for each task, a second try.

Nothing is lost when a process dies: its task is tried again, by itself in a new process, and named if it
kills that one too.  A task that hangs is stopped at its deadline and named.  The rest goes on.
"""

from __future__ import annotations

import multiprocessing
import os
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, Final, Generic, TypeVar

TRIES: Final = 3  # of a task whose process dies
_START: Final = 120.0  # allowed to a new process besides the deadline of its first task [s]
_LOOK: Final = 0.5  # between two looks at deadlines [s]

_T = TypeVar("_T")


class Status(StrEnum):
    """What became of a task."""

    DONE = "done"
    FAILED = "failed"  # raised an error
    TIMEOUT = "timeout"
    DIED = "died"  # killed its process


@dataclass(frozen=True, slots=True)
class Done(Generic[_T]):
    """A task, what became of it, and its result or what it said."""

    task: _T
    status: Status
    result: Any


@dataclass(slots=True, eq=False)
class _Worker:
    process: BaseProcess
    pipe: Connection
    fresh: bool = True
    due: float = 0.0


@dataclass(slots=True)
class _Queue(Generic[_T]):
    waiting: deque[tuple[_T, int]]  # with the number of tries made
    running: dict[_Worker, tuple[_T, int]] = field(default_factory=dict)


def run(do: Callable[[_T], Any], tasks: Iterable[_T], *, workers: int, deadline: float) -> Iterator[Done[_T]]:
    """Do all tasks, in any order, and yield each as it is done.

    Parameters
    ----------
    do
        A function of a module, called in the processes.
    tasks
        Values that can be pickled.
    workers
        Number of processes.
    deadline
        Of one task [s].
    """
    queue: _Queue[_T] = _Queue(deque((task, 0) for task in tasks))
    idle: list[_Worker] = []
    try:
        while queue.waiting or queue.running:
            while queue.waiting and len(queue.running) < workers:
                _give(queue, idle.pop() if idle else _launch(do), deadline)
            ready = wait([worker.pipe for worker in queue.running], timeout=_LOOK)
            now = time.monotonic()
            for worker in list(queue.running):
                if worker.pipe in ready:
                    yield from _take(queue, worker, idle)
                elif now > worker.due:
                    task, _ = queue.running.pop(worker)
                    _stop(worker)
                    yield Done(task, Status.TIMEOUT, f"took more than {deadline:g} s")
    finally:
        for worker in [*idle, *queue.running]:
            _stop(worker)


def _give(queue: _Queue[_T], worker: _Worker, deadline: float) -> None:
    task, tries = queue.waiting.popleft()
    worker.due = time.monotonic() + deadline + (_START if worker.fresh else 0.0)
    queue.running[worker] = task, tries + 1
    try:
        worker.pipe.send(task)
    except OSError:
        return  # it has died; the pipe says so when it is read


def _take(queue: _Queue[_T], worker: _Worker, idle: list[_Worker]) -> Iterator[Done[_T]]:
    task, tries = queue.running.pop(worker)
    try:
        good, result = worker.pipe.recv()
    except (EOFError, OSError):
        _stop(worker)
        if tries >= TRIES:
            yield Done(task, Status.DIED, f"killed its process {tries} times")
        else:
            queue.waiting.append((task, tries))
        return
    worker.fresh = False
    idle.append(worker)
    yield Done(task, Status.DONE if good else Status.FAILED, result)


def _launch(do: Callable[[Any], Any]) -> _Worker:
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(do, theirs), daemon=True)
    process.start()
    theirs.close()
    return _Worker(process, ours)


def _stop(worker: _Worker) -> None:
    worker.pipe.close()
    worker.process.kill()
    worker.process.join()
    worker.process.close()


def _serve(do: Callable[[Any], Any], pipe: Connection) -> None:
    """Do what comes through the pipe, until it is closed."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # one task, one core
    while True:
        try:
            task = pipe.recv()
        except (EOFError, OSError, KeyboardInterrupt):
            return
        try:
            answer = True, do(task)
        except KeyboardInterrupt:
            return
        except BaseException as error:  # noqa: BLE001 - whatever a case raises is named, and the rest goes on
            text = "".join(traceback.format_exception_only(error)).strip()
            answer = False, f"{text} ({_where(error)})"
        pipe.send(answer)


def _where(error: BaseException) -> str:
    """Name the function that raised."""
    frames = traceback.extract_tb(error.__traceback__)
    return f"{frames[-1].name}, line {frames[-1].lineno}" if frames else "unknown place"
