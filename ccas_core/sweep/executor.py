"""Where the cases of a sweep are sailed: processes of this machine, or Dask by one line; the same results.

`local` takes all cores, `local:2` two processes; `tcp://host:port` is the address of a Dask scheduler, which
needs the extra `dask` here and CCAS on its workers.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from ..errors import Diagnostic, InputError
from . import dask_cluster, workers
from .workers import Done

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
        return dask_cluster.run(do, tasks, address=executor, deadline=deadline)
    raise InputError(
        Diagnostic(
            source="executor",
            message=f"cannot use {executor!r}",
            expected="local, local:N with N at least 1, or tcp://host:port of a Dask scheduler",
        )
    )
