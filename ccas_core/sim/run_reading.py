"""A run folder, read again."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from ..errors import Diagnostic, InputError
from ..ships import ShipId
from .run_folder import COLUMNS, DECISIONS, FRAMES, PLANS, SCENARIO, SUMMARY, explained, is_run


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One ship at one instant, as `frames.csv` has it."""

    time: float  # [s]
    ship: ShipId
    east: float  # [m]
    north: float  # [m]
    course: float  # [rad]
    speed: float  # [m/s]
    offset: float  # u^y [m]
    speed_factor: float  # u^s
    safety_index: float | None  # [m]; None for a ship alone
    ruleset: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """What a run folder holds; `summary` is None where the run was cut short."""

    scenario: str  # text of scenario.yaml
    rows: tuple[Row, ...]
    decisions: tuple[Mapping[str, object], ...]
    summary: Mapping[str, object] | None
    plans: tuple[Mapping[str, object], ...] = ()  # none in a run of a version that kept none


def read_run(folder: Path) -> Run:
    """Read a run folder, also one whose run was broken off.

    Raises
    ------
    InputError
        If the folder holds no run, or a file in it cannot be read.
    """
    with explained(folder, "cannot be read", "is the run complete, and are you allowed to read it?"):
        if not is_run(folder):
            raise InputError(
                Diagnostic(
                    source=str(folder),
                    message="no run is here",
                    expected=f"a folder with {FRAMES}",
                    hint="`ccas simulate SCENARIO --out FOLDER` makes one",
                )
            )
        summary = folder / SUMMARY
        return Run(
            scenario=_text(folder / SCENARIO),
            rows=tuple(_read_rows(folder / FRAMES)),
            decisions=tuple(_read_objects(folder / DECISIONS)),
            plans=tuple(_read_objects(folder / PLANS)) if (folder / PLANS).exists() else (),
            summary=_read_object(summary, _text(summary)) if summary.exists() else None,
        )


def _read_rows(file: Path) -> Iterator[Row]:
    for number, row in enumerate(csv.DictReader(_whole_lines(file)), start=2):
        try:
            yield Row(
                time=float(row["time_s"]),
                ship=ShipId(row["ship"]),
                east=float(row["east_m"]),
                north=float(row["north_m"]),
                course=float(row["course_rad"]),
                speed=float(row["speed_mps"]),
                offset=float(row["u_y_m"]),
                speed_factor=float(row["u_s"]),
                safety_index=float(row["safety_index_m"]) if row["safety_index_m"] else None,
                ruleset=row["ruleset"],
            )
        except (KeyError, TypeError, ValueError) as error:
            raise _damaged(file, number, f"columns {', '.join(COLUMNS)}") from error


def _read_objects(file: Path) -> Iterator[Mapping[str, object]]:
    for number, line in enumerate(_whole_lines(file), start=1):
        yield _read_object(file, line, number)


def _read_object(file: Path, text: str, number: int = 1) -> Mapping[str, object]:
    try:
        found = json.loads(text)
    except ValueError as error:
        raise _damaged(file, number, "JSON") from error
    if not isinstance(found, dict):
        raise _damaged(file, number, "a JSON object")
    return cast("dict[str, object]", found)


def _damaged(file: Path, line: int, expected: str) -> InputError:
    return InputError(
        Diagnostic(source=str(file), line=line, column=1, message="cannot be understood", expected=expected)
    )


def _whole_lines(file: Path) -> list[str]:
    """Lines of a file; the last one only if it was written to its end."""
    return _text(file).split("\n")[:-1]


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise _damaged(file, 1, "UTF-8 text") from error
