"""A voyage from the command line: written as it is sailed, watched on a terminal, stopped by Ctrl-C."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any, Protocol

from ccas_core.dmpc.solvers import AbstractLocalSolver
from ccas_core.plugin_failures import Failure
from ccas_core.plugins import Plugins
from ccas_core.sim.events import events_between, failed_rulesets
from ccas_core.sim.frame import Frame
from ccas_core.sim.metrics import summary
from ccas_core.sim.run_folder import RunWriter
from ccas_core.sim.scenario import Scenario
from ccas_core.sim.scenario_dump import dump_scenario
from ccas_core.sim.voyage import undisturbed_times, voyage

from . import talk


class Watcher(Protocol):
    """Whoever is told how a voyage goes."""

    def sailed(self, frame: Frame) -> None:
        """Take note of a frame."""

    def stopping(self) -> None:
        """Take note that the voyage ends after the present period."""

    def failed(self, failure: Failure) -> None:
        """Take note that something of a plugin does not work."""


class Silence:
    """A watcher that says nothing, but what does not work."""

    def sailed(self, frame: Frame) -> None:
        """Say nothing of a frame."""

    def stopping(self) -> None:
        """Say nothing of the end."""

    def failed(self, failure: Failure) -> None:
        """Say what does not work."""
        talk.note(str(failure))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sailed:
    """A voyage that is over, and the folder that holds it."""

    scenario: Scenario
    frames: tuple[Frame, ...]
    folder: Path
    summary: Mapping[str, Any]
    interrupted: bool

    @property
    def until(self) -> float:
        """Time of the last frame [s]."""
        return self.frames[-1].time

    def draw(self) -> tuple[Path, ...]:
        """Draw the pictures of the run into its folder."""
        from ccas_core.sim.plotting import draw_run

        return draw_run(self.scenario, self.frames, self.folder)


def sail(
    scenario: Scenario,
    plugins: Plugins,
    solver_name: str,
    solver: AbstractLocalSolver,
    folder: Path,
    watcher: Watcher | None = None,
) -> Sailed:
    """Sail a scenario into a run folder; plugins that observe are told what happens.

    Ctrl-C ends the voyage after the present period, a second one at once; either way what was sailed
    is kept, and its summary says `interrupted`.

    Raises
    ------
    InputError
        If the folder cannot take a run.
    KeyboardInterrupt
        If nothing was sailed yet.
    """
    watch = watcher or Silence()
    frames: list[Frame] = []
    lookout = _Lookout(plugins)
    text = dump_scenario(scenario, plugins.vocabulary, plugins.controllers)
    with RunWriter(folder, scenario, text) as writer:
        with _ctrl_c(watch) as stop:
            try:
                for frame in voyage(scenario, plugins.rulesets, solver, plugins.controllers):
                    writer.write(frame)
                    for failure in lookout.failures(frames[-1] if frames else None, frame):
                        watch.failed(failure)
                    frames.append(frame)
                    watch.sailed(frame)
                    if stop.is_set():
                        break
            except KeyboardInterrupt:
                if not frames:
                    raise
                stop.set()
        found: Mapping[str, Any] = summary(scenario, frames, solver_name)
        if stop.is_set():
            found = _cut_short(found)
        writer.finish(found)
    return Sailed(
        scenario=scenario, frames=tuple(frames), folder=folder, summary=found, interrupted=stop.is_set()
    )


class _Lookout:
    """Tells observers what happens, and finds what does not work: each fault once."""

    def __init__(self, plugins: Plugins) -> None:
        self._plugins, self._observers = plugins, plugins.observers()
        self._known: set[str] = set()

    def failures(self, before: Frame | None, frame: Frame) -> Iterator[Failure]:
        for event in events_between(before, frame):
            yield from self._observers.tell(event)
        yield from self._plugins.troubles.fresh()
        for ruleset, cause in failed_rulesets(frame):
            if ruleset in self._known:
                continue
            self._known.add(ruleset)
            owner = self._plugins.owners.get(ruleset, "")
            yield Failure(
                plugin=owner,
                target=f"ruleset {ruleset!r}",
                cause=cause,
                effect="both ships give way by the safe mutual rule",
                package=self._plugins.packages.get(owner, ""),
                whole=False,
            )


def _cut_short(found: Mapping[str, Any]) -> dict[str, Any]:
    """Mark the summary of a voyage that was cut short; what only its end would tell is null."""
    return {
        **found,
        "frozen": None,
        "ships": {id_: {**ship, "frozen": None} for id_, ship in found["ships"].items()},
        "encounters": [{**each, "faithful": None} for each in found["encounters"]],
        "interrupted": True,
    }


@contextmanager
def _ctrl_c(watcher: Watcher) -> Iterator[threading.Event]:
    """Turn the first Ctrl-C into an event; solvers in the middle of their work see nothing of it."""
    stop = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stop  # only the main thread may handle signals
        return
    before = signal.getsignal(signal.SIGINT)

    def ask(_signal: int, _frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        stop.set()
        watcher.stopping()

    signal.signal(signal.SIGINT, ask)
    try:
        yield stop
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def watched(scenario: Scenario, *, quiet: bool = False) -> Iterator[Watcher]:
    """Show on stderr how a voyage goes: a bar on a terminal, a line elsewhere, nothing if quiet."""
    if quiet:
        yield Silence()
    elif not sys.stderr.isatty():
        talk.note(f"{scenario.name}: {talk.one_or_more(len(scenario.ships), 'ship')} set sail")
        yield Silence()
    else:
        with _bar(scenario) as bar:
            yield bar


@contextmanager
def _bar(scenario: Scenario) -> Iterator[Watcher]:
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[state]}", markup=False),
        TimeElapsedColumn(),
    )
    total = max(undisturbed_times(scenario).values())
    with Progress(*columns, console=talk.console(stderr=True), transient=True) as progress:
        task = progress.add_task(scenario.name, total=total, state="setting sail")

        class Bar:
            def sailed(self, frame: Frame) -> None:
                count = len(frame.ships.keys() - frame.arrived.keys())
                state = f"{frame.time:.0f} s, {talk.one_or_more(count, 'ship')} under way"
                progress.update(task, completed=min(frame.time, total), state=state)

            def failed(self, failure: Failure) -> None:
                progress.console.print(str(failure))

            def stopping(self) -> None:
                progress.update(task, description="stopping after this period; Ctrl-C again: at once")

        yield Bar()
