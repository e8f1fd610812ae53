"""Encounters in which not both ships negotiate: who steers them, room for domains, and what came of them.

Cells with a `control` of both ships sail the same encounters, whatever their names, so that what cooperation
is worth can be read from one table.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final

from .. import plugins
from ..controllers import RESERVED, AbstractController, Control
from ..domains import DynamicBumper
from ..sim.frame import Frame
from ..sim.scenario import Scenario
from .alone import could_keep_clear

Pairing = tuple[str, str]  # who steers ship 1, which is the own ship, and ship 2

_BREADTHS: Final = 2.0  # of both domains: room on either side of each ship


def with_control(drawn: Scenario, pairing: Pairing) -> Scenario:
    """Say who steers two ships; the waterways become so wide that domains pass one another.

    All ships have the dynamic bumper, whoever steers them, so that all pairings sail the same waters.
    """
    bumpers = [DynamicBumper(length=plan.ship.hull.length, full_speed=plan.speed) for plan in drawn.ships]
    room = _BREADTHS * sum(2.0 * each.at_rest * each.length for each in bumpers)
    ships = tuple(
        replace(plan, ship=replace(plan.ship, stated_domain=bumper), control=Control(by=by))
        for plan, bumper, by in zip(drawn.ships, bumpers, pairing, strict=True)
    )
    reaches = tuple(replace(each, width=each.width + room) for each in drawn.waters.waterways)
    return replace(drawn, ships=ships, waters=replace(drawn.waters, waterways=reaches))


def controllers_of(sailed: Scenario) -> Mapping[str, AbstractController]:
    """Controllers of plugins that a scenario asks for; none are loaded where all ships are the core's."""
    return {} if all(plan.control.by in RESERVED for plan in sailed.ships) else _installed()


@lru_cache(maxsize=1)
def _installed() -> Mapping[str, AbstractController]:
    return plugins.load().controllers


def pairing_of(sailed: Scenario) -> Pairing | None:
    """Who steers two ships; None where both negotiate on waters of the usual width."""
    if len(sailed.ships) != 2 or all(plan.ship.stated_domain is None for plan in sailed.ships):
        return None
    one, other = (plan.control.by for plan in sailed.ships)
    return one, other


def outcome(sailed: Scenario, frames: Sequence[Frame], found: Mapping[str, Any]) -> dict[str, Any] | None:
    """What is kept of a mixed encounter; None of others.

    `collision_avoidable` and `entry_avoidable` say whether the own ship alone, acting from the start by a
    manoeuvre at hand while the other goes on, could have kept clear of hull and safety area.
    """
    pairing = pairing_of(sailed)
    if pairing is None:
        return None
    own, other = sailed.ships
    clear = [could_keep_clear(sailed, frames, own, other, 0, areas=areas) for areas in (False, True)]
    return {
        "pairing": list(pairing),
        "collision_avoidable": clear[0],
        "entry_avoidable": clear[1],
        "overlaps": sum(each["overlap"] > 0.0 for each in found["domains"]),
        "remarks": sum(each["count"] for each in found["remarks"]),
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """What a pairing came to, over all its encounters under one ruleset."""

    pairing: str
    ruleset: str
    n: int
    collisions: int
    avoidable_collisions: int  # that the own ship alone could have avoided
    entries: int
    avoidable_entries: int
    min_clearance: float | None  # [m]
    delay: float | None  # of both ships together, mean [s]
    aside: float | None  # greatest distance of both ships from their lines, mean of the sums [m]
    frozen: int


def rows(results: Iterable[tuple[str, Mapping[str, Any]]]) -> list[Row]:
    """Compare pairings; each result is the ruleset and what was kept of a case."""
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for ruleset, kept in results:
        if kept.get("mixed"):
            groups.setdefault((" / ".join(kept["mixed"]["pairing"]), ruleset), []).append(kept)
    return [_row(*key, group) for key, group in groups.items()]


def _row(pairing: str, ruleset: str, group: Sequence[Mapping[str, Any]]) -> Row:
    delays = [
        sum(ship["delay_s"] for ship in kept["ships"].values())
        for kept in group
        if all(ship["delay_s"] is not None for ship in kept["ships"].values())
    ]
    aside = [sum(ship["max_offset_change_m"] for ship in kept["ships"].values()) for kept in group]
    clearances = [kept["min_clearance_m"] for kept in group if kept["min_clearance_m"] is not None]
    return Row(
        pairing=pairing,
        ruleset=ruleset,
        n=len(group),
        collisions=sum(kept["collisions"] for kept in group),
        avoidable_collisions=sum(
            kept["collisions"] for kept in group if kept["mixed"]["collision_avoidable"]
        ),
        entries=sum(kept["entries"] for kept in group),
        avoidable_entries=sum(kept["entries"] for kept in group if kept["mixed"]["entry_avoidable"]),
        min_clearance=min(clearances, default=None),
        delay=sum(delays) / len(delays) if delays else None,
        aside=sum(aside) / len(aside) if aside else None,
        frozen=sum(kept["frozen"] for kept in group),
    )
