"""How proving goes, told on stderr: a bar on a terminal, a line for each property elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from . import talk

if TYPE_CHECKING:
    from ccas_core.proofs.findings import Finding


class Watch:
    """Keeps what is known so far of the ruleset at hand, and tells of it."""

    def __init__(self, tell: Callable[[str], object], *, ends_lines: bool) -> None:
        self.findings: list[Finding] = []
        self._tell, self._ends_lines = tell, ends_lines
        self._open = ""
        self._since = 0.0

    def begin(self) -> None:
        """Begin with another ruleset."""
        self.findings = []

    def begun(self, ruleset: str, name: str) -> None:
        """Take note that a property is looked at."""
        self._open, self._since = name, time.perf_counter()
        if not self._ends_lines:
            self._tell(f"{ruleset}: {name}")

    def done(self, ruleset: str, finding: Finding) -> None:
        """Take note of what came of it."""
        self._open = ""
        self.findings.append(finding)
        if self._ends_lines:
            self._tell(f"{ruleset}: {finding.property} {finding.outcome}, {finding.seconds:.1f} s")

    def give_up(self) -> None:
        """Say of the property at hand that it was not decided."""
        from ccas_core.proofs.findings import Finding, Outcome

        if self._open:
            seconds = time.perf_counter() - self._since
            why = "interrupted"
            self.findings.append(
                Finding(
                    property=self._open, outcome=Outcome.UNDECIDED, method=why, seconds=seconds, open=(why,)
                )
            )
            self._open = ""


@contextmanager
def watched(*, quiet: bool = False) -> Iterator[Watch]:
    """Tell of progress on stderr; nothing if quiet."""
    if quiet:
        yield Watch(lambda _: None, ends_lines=True)
    elif not sys.stderr.isatty():
        yield Watch(talk.note, ends_lines=True)
    else:
        from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
        with Progress(*columns, console=talk.console(stderr=True), transient=True) as progress:
            task = progress.add_task("reading")
            yield Watch(lambda text: progress.update(task, description=text), ends_lines=False)
