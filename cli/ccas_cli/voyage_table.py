"""The summary of a voyage, for people."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from . import talk

_HEADINGS: Final = (
    "ship",
    "gave way to",
    "stood on for",
    ">clearance",
    ">safety",
    ">offset",
    ">speed",
    ">delay",
    "arrived",
)
_COUNTS: Final = {
    "collisions": "collision",
    "entries": "entry",
    "groundings": "grounding",
    "allisions": "allision",
}


def show_summary(summary: Mapping[str, Any], folder: Path) -> None:
    """Print a table of the ships, then what they met, then where all that is kept."""
    met = summary["encounters"]
    rows = [_ship_row(id_, ship, met) for id_, ship in summary["ships"].items()]
    talk.show_table(_HEADINGS, rows)
    talk.show("(least clearance, safety index and speed, greatest change of offset)\n")
    for line in _lines(summary):
        talk.show(line)
    counted = (talk.one_or_more(summary[key], what) for key, what in _COUNTS.items())
    talk.show(", ".join(counted))
    talk.show(f"run folder: {folder}")


def show_pictures(pictures: Sequence[Path]) -> None:
    """Print where the pictures are."""
    talk.show(f"pictures: {_listed(str(path) for path in pictures)}")


def _ship_row(id_: str, ship: Mapping[str, Any], met: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    def others(role: str) -> str:
        own = (each for each in met if id_ in each[role])
        return _listed(dict.fromkeys(other for each in own for other in each["ships"] if other != id_))

    return (
        id_,
        others("give_way"),
        others("stand_on"),
        _number(ship["min_clearance_m"], ".1f", " m"),
        _number(ship["min_safety_index_m"], ".1f", " m"),
        _number(ship["max_offset_change_m"], ".1f", " m"),
        _number(ship["min_speed_factor"], ".0%"),
        _number(ship["delay_s"], ".0f", " s"),
        "yes" if ship["arrived"] else "no",
    )


def _lines(summary: Mapping[str, Any]) -> Iterable[str]:
    for each in summary["encounters"]:
        duty = f"{_listed(each['give_way'])} to give way" if each["give_way"] else each["kind"]
        source = f" ({each['article']})" if each["article"] else ""
        done = {True: ", faithfully done", False: ", NOT faithfully done", None: ""}[each["faithful"]]
        met = f"{' and '.join(each['ships'])}: {each['geometry']} by {each['ruleset']}"
        yield f"{met}, {duty}{source}{done}"
    for each in summary["ruleset_switches"]:
        yield f"{each['ship']} went from {each['from']} to {each['to']} at {each['time_s']:.0f} s"
    for each in summary["deadlocks"]:
        yield f"{_listed(each['ships'])} waited for one another at {each['time_s']:.0f} s; opened"
    for each in summary["remarks"]:
        times = f"{each['first_s']:.0f} s"
        if each["count"] > 1:
            times += f" to {each['last_s']:.0f} s, {each['count']} times"
        yield f"{each['ship']} says: {each['text']} ({times})"


def _number(value: float | None, digits: str, unit: str = "") -> str:
    return "-" if value is None else f"{value:{digits}}{unit}"


def _listed(words: Iterable[str]) -> str:
    return ", ".join(words) or "-"
