"""What the paper reports of its cases, as data, and what must be true of ours.

Tran, Johansen, Negenborn, Ocean Engineering 353 (2026) 124802, Sec. 5 and Table 2.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ccas_core.sim.scenario import Scenario

ACTS_OFFSET = 10.0  # a ship acts if its offset changes by more than this [m] ...
ACTS_SPEED = 0.9  # ... or its speed factor falls below this
HOLDS_OFFSET = 5.0  # a ship holds if its offset changes by no more than this [m] ...
HOLDS_SPEED = 0.95  # ... and its speed factor stays at this or more
ALLOWANCE = 1.5  # a safety index smaller than the paper's by more than this factor needs a reason

Summary = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Claim:
    """Something that must be true of a run, and whether it is."""

    text: str
    holds: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One row of Table 2: a time and an index for each ship."""

    title: str
    scenario: str
    max_s: tuple[float, ...]
    mean_s: tuple[float, ...]
    safety_index: tuple[float, ...]  # min(epsilon) [m]
    duties: tuple[tuple[str, str], ...] = ()  # (gives way, stands on), as the text of Sec. 5 has them
    acts: tuple[str, ...] = ()
    holds: tuple[str, ...] = ()  # course and speed
    holds_speed: tuple[str, ...] = ()
    passes_first: tuple[tuple[str, str], ...] = ()  # (before, after)


TABLE_2 = (
    Row(
        title="2 ships, N = 45 (Fig. 10)",
        scenario="fig_10",
        max_s=(0.633, 0.615),
        mean_s=(0.091, 0.093),
        safety_index=(128.787, 129.206),
        duties=(("ship_1", "ship_2"),),
        acts=("ship_1",),
        holds=("ship_2",),
    ),
    Row(
        title="2 ships, N = 45 (Fig. 11)",
        scenario="fig_11",
        max_s=(0.245, 0.119),
        mean_s=(0.047, 0.045),
        safety_index=(125.15, 124.57),
        duties=(("ship_2", "ship_1"),),
        acts=("ship_2",),
        holds=("ship_1",),
    ),
    Row(
        title="3 ships, N = 45 (Fig. 12)",
        scenario="fig_12",
        max_s=(0.986, 0.457, 0.228),
        mean_s=(0.075, 0.064, 0.057),
        safety_index=(72.569, 96.036, 69.281),
        duties=(("ship_3", "ship_1"), ("ship_2", "ship_1"), ("ship_2", "ship_3")),
        acts=("ship_2", "ship_3"),
        holds_speed=("ship_1",),
        passes_first=(("ship_1", "ship_3"), ("ship_3", "ship_2")),
    ),
    Row(
        title="4 ships, N = 45 (Fig. 13)",
        scenario="fig_13",
        max_s=(0.448, 0.454, 0.187, 0.106),
        mean_s=(0.123, 0.069, 0.057, 0.062),
        safety_index=(17.012, 40.977, 17.013, 40.976),
    ),
    Row(
        title="4 ships, N = 30",
        scenario="fig_13_n30",
        max_s=(0.141, 0.260, 0.233, 0.138),
        mean_s=(0.043, 0.091, 0.100, 0.051),
        safety_index=(22.021, 27.910, 22.019, 27.903),
    ),
    Row(
        title="4 ships, N = 60",
        scenario="fig_13_n60",
        max_s=(2.275, 0.895, 0.885, 1.158),
        mean_s=(0.224, 0.120, 0.091, 0.118),
        safety_index=(17.349, 40.842, 17.342, 40.841),
    ),
    Row(
        title="4 ships, N = 45 (Fig. 14(c))",
        scenario="fig_14",
        max_s=(0.277, 0.135, 0.117, 0.610),
        mean_s=(0.069, 0.075, 0.061, 0.079),
        safety_index=(41.648, 41.806, 41.647, 41.806),
        duties=(("ship_1", "ship_2"), ("ship_2", "ship_3"), ("ship_3", "ship_4"), ("ship_4", "ship_1")),
    ),
    Row(
        title="5 ships, N = 45",
        scenario="five_ships",
        max_s=(0.880, 0.519, 0.833, 0.863, 0.210),
        mean_s=(0.273, 0.180, 0.273, 0.222, 0.063),
        safety_index=(5.973, 25.760, 5.990, 25.760, 93.074),
    ),
    Row(
        title="6 ships, N = 45",
        scenario="six_ships",
        max_s=(0.953, 0.448, 0.565, 0.897, 1.373, 1.153),
        mean_s=(0.229, 0.146, 0.179, 0.276, 0.299, 0.389),
        safety_index=(18.118, 19.466, 18.124, 23.324, 50.161, 50.157),
    ),
)


def safe(summary: Summary) -> list[Claim]:
    """What must be true of every case: nobody touches, enters, grounds or freezes."""
    index = summary["min_safety_index_m"]
    return [
        Claim("no hulls touch", summary["collisions"] == 0),
        Claim("no hull enters a safety area", summary["entries"] == 0),
        Claim(
            "no ship leaves the waterway or strikes an obstacle",
            summary["groundings"] + summary["allisions"] == 0,
        ),
        Claim("every safety index is above zero", index is None or index > 0.0),
        Claim("every ship arrives, none is frozen", summary["frozen"] == 0),
    ]


def claims_of(row: Row, scenario: Scenario, summary: Summary) -> list[Claim]:
    """What must be true of a row of Table 2."""
    ships = summary["ships"]
    claims = [*safe(summary), *collides_if_nobody_acts(scenario)]
    duties = {
        (give, stand)
        for each in summary["encounters"]
        for give in each["give_way"]
        for stand in each["stand_on"]
    }
    for give, stand in row.duties:
        claims.append(Claim(f"{give} is to give way to {stand}", (give, stand) in duties))
    claims += [Claim(f"{ship} acts", acts(ships[ship])) for ship in row.acts]
    claims += [Claim(f"{ship} holds its course and speed", holds(ships[ship])) for ship in row.holds]
    for ship in row.holds_speed:
        claims.append(Claim(f"{ship} holds its speed", ships[ship]["min_speed_factor"] >= HOLDS_SPEED))
    for first, then in row.passes_first:
        claims.append(Claim(f"{first} passes before {then}", _delay(ships[first]) < _delay(ships[then])))
    return claims


def head_on_claims(name: str, summary: Summary) -> list[Claim]:
    """What must be true of the head-on cases; the roles are those of Fig. 7(a)."""
    ships = summary["ships"]
    claims = safe(summary)
    if name == "fig_07a":
        claims.append(Claim("ship_2 acts", acts(ships["ship_2"])))
        claims.append(Claim("ship_1 holds its course and speed", holds(ships["ship_1"])))
    return claims


def acts(ship: Summary) -> bool:
    """Whether a ship visibly did something."""
    return bool(ship["max_offset_change_m"] > ACTS_OFFSET or ship["min_speed_factor"] < ACTS_SPEED)


def holds(ship: Summary) -> bool:
    """Whether a ship kept its course and speed."""
    return bool(ship["max_offset_change_m"] <= HOLDS_OFFSET and ship["min_speed_factor"] >= HOLDS_SPEED)


def collides_if_nobody_acts(scenario: Scenario) -> list[Claim]:
    """The case is worth its name: undisturbed ships collide, and reach the junction within one period."""
    import numpy as np

    from ccas_core.frames import PathPose
    from ccas_core.sim.hulls import Track, meetings
    from ccas_core.waterway import guiding_line

    tracks, times = [], []
    for plan in scenario.ships:
        frame = guiding_line(scenario.waters, plan.route).frame
        start = frame.to_path(plan.start)
        end = frame.to_ned(PathPose(frame.length, start.y, 0.0))
        duration = (frame.length - start.x) / plan.speed
        here = [plan.start.x, plan.start.y, frame.course_at(start.x)]
        poses = np.array([here, [end.x, end.y, frame.course_at(frame.length)]])
        tracks.append(Track(ship=plan.ship, times=np.array([0.0, duration]), poses=poses))
        when = np.arange(0.0, duration, 1.0)
        times.append(float(when[np.argmin(np.hypot(*tracks[-1].at(when)[:, :2].T))]))
    struck = {id_ for each in meetings(tracks) if each.collision for id_ in each.pair}
    return [
        Claim("every ship collides if nobody acts", len(struck) == len(scenario.ships)),
        Claim("undisturbed, all arrive within one period", max(times) - min(times) <= scenario.time_step),
    ]


def _delay(ship: Summary) -> float:
    return float("inf") if ship["delay_s"] is None else float(ship["delay_s"])
