"""Where the cases of a sweep are sailed: processes of this machine, or Dask by one line; the same results.

`local` takes all cores, `local:2` two processes; `tcp://host:port` is the address of a Dask scheduler, which
needs the extra `dask` here and CCAS on its workers.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from ..errors import Diagnostic, InputError
from . import workers
from .workers import Done, Status

_T = TypeVar("_T")


def execute(
    executor: str, do: Callable[[_T], Any], tasks: Sequence[_T], deadline: float
) -> Iterator[Done[_T]]:
    """Do all tasks where `executor` says, and yield each as it is done."""
    kind, _, rest = executor.partition(":")
    if kind == "local" and (not rest or (rest.isdecimal() and int(rest) > 0)):
        count = int(rest) if rest else os.cpu_count() or 1
        return workers.run(do, tasks, workers=min(count, max(1, len(tasks))), deadline=deadline)
    if kind in ("tcp", "tls") and rest.startswith("//"):
        return _dask(executor, do, tasks)
    raise InputError(
        Diagnostic(
            source="executor",
            message=f"cannot use {executor!r}",
            expected="local, local:N with N at least 1, or tcp://host:port of a Dask scheduler",
        )
    )


def _dask(address: str, do: Callable[[_T], Any], tasks: Sequence[_T]) -> Iterator[Done[_T]]:
    try:
        distributed = importlib.import_module("distributed")
    except ImportError as error:
        hint = "install it with `pip install 'ccas[dask]'`, or use executor 'local'"
        raise InputError(
            Diagnostic(source="executor", message=f"Dask cannot be used: {error}", hint=hint)
        ) from error
    with distributed.Client(address) as client:
        futures = {client.submit(do, task, pure=False): task for task in tasks}
        for future in distributed.as_completed(futures):
            task = futures[future]
            if future.status == "finished":
                yield Done(task, Status.DONE, future.result())
            else:
                raised = future.exception()
                died = type(raised).__name__ == "KilledWorker"
                status = Status.DIED if died else Status.FAILED
                yield Done(task, status, f"{type(raised).__name__}: {raised}")
