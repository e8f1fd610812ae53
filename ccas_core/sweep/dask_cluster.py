"""Workers of a Dask scheduler that do tasks as those of `workers` do: nothing is lost, what hangs is named.

Dask itself tries a task again whose worker dies.  What it lacks is a deadline: the client looks which tasks
are being done, and restarts the worker of one that takes too long.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final, TypeVar

from ..errors import Diagnostic, InputError
from .workers import Done, Status

CONNECT: Final = 10.0  # allowed to the scheduler to answer [s]
_LOOK: Final = 0.5  # between two looks at what is done [s]
_LATE: Final = 2.0  # between two looks at what takes too long [s]
_ENDED: Final = ("finished", "error")  # states of a task that has ended by itself
_STOP: Final = 10.0  # allowed to a worker to be restarted [s]

_T = TypeVar("_T")


def run(do: Callable[[_T], Any], tasks: Sequence[_T], *, address: str, deadline: float) -> Iterator[Done[_T]]:
    """Do all tasks, in any order, and yield each as it is done; arguments as of `workers.run`."""
    distributed = _distributed()
    with _client(distributed, address) as client:
        suspects = []
        for done in _watched(distributed, client, do, tasks, deadline):
            if done.status is Status.DIED:
                suspects.append(done.task)  # or the task that was beside it has killed the workers
            else:
                yield done
        for task in suspects:
            yield from _watched(distributed, client, do, [task], deadline)


def _watched(
    distributed: Any,  # noqa: ANN401 - the package need not be there
    client: Any,  # noqa: ANN401 - a client of it
    do: Callable[[_T], Any],
    tasks: Sequence[_T],
    deadline: float,
) -> Iterator[Done[_T]]:
    """Do tasks at the same time; one that takes longer than the deadline costs its worker a restart."""
    futures = {client.submit(do, task, pure=False): task for task in tasks}
    since: dict[str, float] = {}  # when a task was first seen being done
    look = time.monotonic() + _LATE
    while futures:
        try:
            ready = distributed.wait(list(futures), timeout=_LOOK, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            ready = set()
        for future in ready:
            task = futures.pop(future)
            if future.status in _ENDED:
                yield _outcome(task, future)
            else:  # lost with a worker that was restarted for another task's sake
                futures[client.submit(do, task, pure=False)] = task
        if time.monotonic() < look:
            continue
        late = _late(client, since, deadline)
        look = time.monotonic() + _LATE
        for future in [each for each in futures if each.key in late]:
            yield Done(futures.pop(future), Status.TIMEOUT, f"took more than {deadline:g} s")
            future.cancel(force=True)
        if late:
            client.restart_workers(sorted(set(late.values())), timeout=_STOP, raise_for_error=False)


def _distributed() -> Any:  # noqa: ANN401 - the package need not be there
    try:
        return importlib.import_module("distributed")
    except ImportError as error:
        hint = "install it with `pip install 'ccas[dask]'`, or use executor 'local'"
        raise InputError(
            Diagnostic(source="executor", message=f"Dask cannot be used: {error}", hint=hint)
        ) from error


def _client(distributed: Any, address: str) -> Any:  # noqa: ANN401 - a client of Dask
    try:
        return distributed.Client(address, timeout=CONNECT)
    except (OSError, ValueError) as error:
        hint = "start one with `dask scheduler`, and workers with `dask worker` and its address"
        raise InputError(
            Diagnostic(
                source="executor", message=f"no Dask scheduler answers at {address}: {error}", hint=hint
            )
        ) from error


def _outcome(task: _T, future: Any) -> Done[_T]:  # noqa: ANN401 - a future of Dask
    if future.status == "finished":
        return Done(task, Status.DONE, future.result())
    raised = future.exception()
    if type(raised).__name__ == "KilledWorker":
        return Done(task, Status.DIED, str(raised))
    return Done(task, Status.FAILED, f"{type(raised).__name__}: {raised}")


def _late(client: Any, since: dict[str, float], deadline: float) -> dict[str, str]:  # noqa: ANN401 - as above
    """Tasks that have taken longer than the deadline, and their workers; `since` is brought up to date."""
    now = time.monotonic()
    found: dict[str, list[str]] = client.run(_doing, on_error="ignore")
    doing = {key: worker for worker, keys in found.items() for key in keys}
    for key in since.keys() - doing.keys():
        del since[key]
    for key in doing:
        since.setdefault(key, now)
    return {key: worker for key, worker in doing.items() if now - since[key] > deadline}


def _doing(dask_worker: Any) -> list[str]:  # noqa: ANN401 - called on each worker, which Dask hands in
    """Keys of the tasks that a worker is doing."""
    return [each.key for each in dask_worker.state.executing]
