"""A run folder: what a voyage leaves on the disk, written as it sails.

Five files: `scenario.yaml`, `frames.csv`, `decisions.jsonl`, `plans.jsonl`, and `summary.json`, which comes
last and whole.
"""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import TracebackType
from typing import Final, Self, TextIO

from ..errors import Diagnostic, InputError
from ..priority import Edge, Settlement
from ..ships import ShipId
from ..verdict import Verdict
from .conduct import is_met
from .frame import Frame
from .hulls import under_way
from .metrics import guiding_frames, plain, safety_indices
from .plan_log import plans
from .scenario import Scenario

SCENARIO: Final = "scenario.yaml"
FRAMES: Final = "frames.csv"
DECISIONS: Final = "decisions.jsonl"
PLANS: Final = "plans.jsonl"
REPLAY: Final = "replay.html"  # `ccas replay` puts it there
SUMMARY: Final = "summary.json"
COLUMNS: Final = (
    "time_s",
    "ship",
    "east_m",
    "north_m",
    "course_rad",
    "speed_mps",
    "u_y_m",
    "u_s",
    "safety_index_m",
    "ruleset",
)
_OURS: Final = (  # the summary goes first
    SUMMARY,
    FRAMES,
    DECISIONS,
    PLANS,
    SCENARIO,
    REPLAY,
    "frames.parquet",
    "*.png",
)


class RunWriter:
    """Writer of one run folder: `write` each frame as it comes, then `finish` with the summary.

    The folder appears with the first frame.  Each frame is on the disk before the next is asked for, so a
    run that is broken off leaves a folder that can be read.  A folder that holds an earlier run is
    replaced: our own files in it go, others stay.

    Raises
    ------
    InputError
        If the folder holds something else than a run, or cannot be written.
    """

    def __init__(self, folder: Path, scenario: Scenario, text: str) -> None:
        self.folder = folder
        self._text = text
        self._ships = {plan.ship.id: plan.ship for plan in scenario.ships}
        self._lines = guiding_frames(scenario)
        self._met: set[tuple[ShipId, ShipId]] = set()
        self._step = scenario.time_step
        self._files: tuple[TextIO, TextIO, TextIO] | None = None
        self._open = ExitStack()
        with explained(folder):
            _refuse_strangers(folder)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def write(self, frame: Frame) -> None:
        """Add one frame."""
        with explained(self.folder):
            rows, decisions, planned = self._files or self._begin()
            rows.write(_csv(self._rows(frame)))
            rows.flush()
            decisions.write("".join(_json_line(each) for each in self._decisions(frame)))
            decisions.flush()
            planned.write(_json_line(plans(frame, self._step), compact=True))
            planned.flush()

    def finish(self, summary: Mapping[str, object]) -> None:
        """Add the summary, and close."""
        if self._files is None:
            raise ValueError("a run without frames has no summary")
        self.close()
        with explained(self.folder):
            text = json.dumps(plain(summary), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
            part = self.folder / f".{SUMMARY}.part"
            with part.open("w", encoding="utf-8", newline="\n") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            part.replace(self.folder / SUMMARY)

    def close(self) -> None:
        """Close the files; what was written stays."""
        with explained(self.folder):
            self._open.close()

    def _begin(self) -> tuple[TextIO, TextIO, TextIO]:
        _refuse_strangers(self.folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        for pattern in _OURS:
            for old in self.folder.glob(pattern):
                old.unlink()
        (self.folder / SCENARIO).write_text(self._text, encoding="utf-8", newline="\n")
        rows, decisions, planned = (
            self._open.enter_context((self.folder / name).open("w", encoding="utf-8", newline=""))
            for name in (FRAMES, DECISIONS, PLANS)
        )
        self._files = rows, decisions, planned
        rows.write(_csv([COLUMNS]))
        return self._files

    def _rows(self, frame: Frame) -> Iterator[tuple[str, ...]]:
        ships = under_way(frame)
        poses = {id_: ship.pose for id_, ship in ships.items()}
        indices = safety_indices(poses, self._ships, self._lines)
        for id_, ship in sorted(ships.items()):
            index = indices[id_]
            yield (
                _fixed(frame.time, 3),
                id_,
                _fixed(ship.pose.y, 4),
                _fixed(ship.pose.x, 4),
                _fixed(ship.pose.course, 6),
                _fixed(ship.speed, 5),
                _fixed(ship.offset, 4),
                _fixed(ship.speed_factor, 6),
                "" if index is None else _fixed(index, 4),
                ship.ruleset,
            )

    def _decisions(self, frame: Frame) -> Iterator[dict[str, object]]:
        for settlement in frame.settlements:
            if is_met(settlement) or settlement.pair in self._met:
                yield decision(settlement, frame)
        settled = {each.pair for each in frame.settlements}
        met = {each.pair for each in frame.settlements if is_met(each)}
        self._met = {pair for pair in self._met - settled if under_way(frame).keys() >= set(pair)} | met


def decision(settlement: Settlement, frame: Frame) -> dict[str, object]:
    """Tell one decision as a line of `decisions.jsonl` (contract)."""
    edge = settlement.edge
    return {
        "time_s": frame.time,
        "pair": settlement.pair,
        "verdicts": {view.own: _verdict(view) for view in (settlement.one, settlement.other)},
        "applied": "fallback" if settlement.fallback else "agreed",
        "why": settlement.fallback or None,
        "geometry": settlement.geometry,
        "edge": edge and {"first": edge.first, "then": edge.then, "kind": edge.kind},
        "opened": [
            (opening.edge.first, opening.edge.then, opening.criterion)
            for opening in dict.fromkeys(frame.openings)
            if _joins(opening.edge, settlement)
        ],
    }


def _verdict(view: Verdict) -> dict[str, object]:
    return {
        "kind": view.kind,
        "give_way": view.give_way,
        "stand_on": view.stand_on,
        "pass": view.passing_side,
        "article": view.article,
        "ruleset": view.ruleset,
        "version": view.version,
        "rule": view.rule,
        "reason": view.reason,
        "geometry": view.geometry,
        "strength": view.strength,
        "pass_required": view.passing_required,
        "side_chosen_by": view.side_chosen_by,
        "initiator": view.initiator,
        "confidence": view.citation and view.citation.confidence,
        "facts": dict(sorted(view.facts.items())),
        **({"lacks": view.lacks} if view.lacks else {}),
    }


def _joins(edge: Edge, settlement: Settlement) -> bool:
    return {edge.first, edge.then} == set(settlement.pair)


def is_run(folder: Path) -> bool:
    """Whether a folder holds a run, whole or broken off."""
    return any((folder / name).is_file() for name in (SUMMARY, FRAMES))


def _refuse_strangers(folder: Path) -> None:
    if folder.exists() and (not folder.is_dir() or (any(folder.iterdir()) and not is_run(folder))):
        raise InputError(
            Diagnostic(
                source=str(folder),
                message="is not empty and not a run" if folder.is_dir() else "is a file",
                expected="a new or empty folder, or an earlier run, which is replaced",
                hint="choose another folder with --out",
            )
        )


@contextmanager
def explained(
    folder: Path,
    what: str = "cannot be written",
    hint: str = "free space, or choose another folder with --out",
) -> Iterator[None]:
    """Tell an error of the disk with its place, its cause and a hint."""
    try:
        yield
    except OSError as error:
        raise InputError(
            Diagnostic(
                source=str(error.filename or folder),
                message=f"{what}: {error.strerror or error}",
                hint=hint,
            )
        ) from error


def _fixed(value: float, digits: int) -> str:
    """Number with so many decimals, and never a negative zero: the same run gives the same bytes."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def _csv(rows: Iterator[tuple[str, ...]] | list[tuple[str, ...]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def _json_line(value: Mapping[str, object], *, compact: bool = False) -> str:
    separators = (",", ":") if compact else None
    return json.dumps(plain(value), ensure_ascii=False, allow_nan=False, separators=separators) + "\n"
