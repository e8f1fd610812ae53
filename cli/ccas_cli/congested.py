"""The five simulations of the second paper, sailed anew: what it reports, and what must be true of ours.

An improved collision avoidance algorithm based on model predictive control for ASVs in congested inland
waters, Sec. 4.  Its text has no positions and no tables; `docs/bumper-mpc.md` says how it is read.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

from .congested_measures import (
    OWN,
    cross_track_error,
    domains_met,
    is_astern,
    offset_abeam,
    offset_beside_obstacle,
    own_states,
    room_on_track,
    slowest,
    swings,
    turn_from_path,
    usual_surge,
)
from .paper import Claim

if TYPE_CHECKING:
    from ccas_core.sim.scenario import Scenario

    from .reproduction import Case, Reproduction

SET: Final = "zhenjiang"
MEAN_S: Final = {"sim_2": 0.0181, "sim_3": 0.0172, "sim_4": 0.0192, "sim_5": 0.0235}  # of the paper, Sec. 4.7
ON_PATH: Final = 0.5  # distance from the path of a ship that is back on it [m]
ASIDE: Final = 2.0  # offset of a ship that has gone to one side [m]
SLOWER: Final = 0.3  # loss of speed that shows [m/s]
SHOWN: Final = {
    "sim_2": (5.0, 17.0, 24.0, 35.0),
    "sim_3": (0.0, 8.0, 20.0, 32.0),
    "sim_4": (2.0, 14.0, 20.0, 28.0),
    "sim_5": (4.0, 12.0, 28.0, 40.0, 52.0, 66.0, 74.0, 84.0, 92.0, 106.0),
}


def simulation_1(made: Reproduction) -> None:
    """Simulation 1: only domains that stay apart, standard ellipses against dynamic bumpers."""
    from ccas_core.sim.domain_plotting import steered
    from ccas_core.sim.scenario_steering import Shape

    made.title("Simulation 1: standard ellipses and dynamic bumpers, without rules and safe distances")
    rows, found = [], {}
    for way in ("astern", "ahead"):
        for shape in (Shape.ELLIPSE, Shape.DYNAMIC_BUMPER):
            case = made.sail(f"{SET}/sim_1_{way}", partial(_shaped, shape=shape.value), shape.value)
            room, time = room_on_track(case)
            overlap = case.summary["domains"][0]["overlap"]
            found[way, shape] = room, overlap
            rows.append(
                (
                    way,
                    shape.value,
                    f"{room:.1f}",
                    f"{overlap:.1%}",
                    f"{slowest(case):.1f}",
                    str(swings(case)),
                )
            )
            times = [max(time + each, 0.0) for each in (-6.0, -3.0, 0.0, 3.0)]
            made.save(f"sim_1_{way}_{shape.value}", steered(case.scenario, case.frames, times))
    made.table(
        (
            "passing",
            "domains",
            ">distance on the other's track [m]",
            ">overlap",
            ">least speed [m/s]",
            ">swings",
        ),
        rows,
    )
    ellipse, bumper = Shape.ELLIPSE, Shape.DYNAMIC_BUMPER
    made.check(
        "sim_1",
        [
            Claim("with ellipses the domains overlap", found["astern", ellipse][1] > 0.0),
            Claim("with bumpers they overlap less", found["astern", bumper][1] < found["astern", ellipse][1]),
            Claim(
                "the bumper leaves less room astern of the other ship",
                found["astern", bumper][0] < found["astern", ellipse][0],
            ),
            Claim("and more ahead of it", found["ahead", bumper][0] > found["ahead", ellipse][0]),
        ],
    )


def simulation(name: str, made: Reproduction) -> None:
    """Simulations 2 to 5: with rules and safe distances, and with a current that is known or not."""
    from ccas_core.sim.domain_plotting import steered

    case = made.sail(f"{SET}/{name}")
    blind = made.sail(f"{SET}/{name}", _blind, "current not known")
    made.title(f"{case.scenario.title}: simulation {name[-1]}")
    times = [ms / 1000.0 for now in own_states(case.frames) for ms in now.update_ms]
    error, without = (cross_track_error(each) for each in (case, blind))
    made.table(
        (
            ">mean computation [s]",
            ">paper",
            ">median [s]",
            ">cross-track error [m]",
            ">current not known [m]",
            ">least domain distance [m]",
            ">least speed [m/s]",
            ">swings",
        ),
        [
            (
                f"{sum(times) / len(times):.4f}",
                f"{MEAN_S[name]:.4f}",
                f"{sorted(times)[len(times) // 2]:.4f}",
                f"{error:.3f}",
                f"{without:.3f}",
                f"{min(each['min_distance_m'] for each in domains_met(case)):.2f}",
                f"{slowest(case):.1f}",
                str(swings(case)),
            )
        ],
    )
    made.data[name] = {
        "mean_s": sum(times) / len(times),
        "paper_mean_s": MEAN_S[name],
        "cross_track_m": error,
        "cross_track_current_not_known_m": without,
    }
    made.save(name, steered(case.scenario, case.frames, SHOWN[name]))
    made.check(name, [*_always(case), *_manoeuvres(name, case)])
    made.check(name + ", current", [Claim("the current is made up for", error < 0.1 < without)])


def _always(case: Case) -> list[Claim]:
    """What must be true of simulations 2 to 5."""
    last = own_states(case.frames)[-1]
    others = len(case.scenario.ships) - 1 + len(case.scenario.waters.obstacles)
    turned = max(abs(turn_from_path(case, now)) for now in own_states(case.frames))
    return [
        Claim("no domains overlap", all(each["overlap"] == 0.0 for each in domains_met(case))),
        Claim("no hulls touch, nothing is struck", not any(case.summary[key] for key in _DAMAGE)),
        Claim("the ship returns to its path", abs(last.path_y) < ON_PATH),
        Claim(
            "the speed does not oscillate: it swings twice an encounter at most", swings(case) <= 2 * others
        ),
        Claim("no turn is greater than 40 deg", turned < 40.5),
        Claim("every plan keeps the domains apart", not any(now.outcome for now in own_states(case.frames))),
    ]


def _manoeuvres(name: str, case: Case) -> list[Claim]:
    """What the text says of each simulation."""
    if name == "sim_2":
        return [
            Claim("it turns to starboard", offset_abeam(case, "obstacle") > ASIDE),
            Claim("they pass port to port", offset_abeam(case, "obstacle") > 0.0),
            Claim("it slows down", slowest(case) < usual_surge(case) - SLOWER),
        ]
    if name == "sim_3":
        return [
            Claim("it overtakes on the port side of the other", offset_abeam(case, "obstacle") < -ASIDE),
            Claim("it slows down, and then overtakes", slowest(case) < usual_surge(case) - SLOWER),
        ]
    if name == "sim_4":
        return [
            Claim("it turns to port", min(now.path_y for now in own_states(case.frames)) < -ASIDE),
            Claim("it passes astern of the ship that crosses", is_astern(case, "obstacle")),
            Claim("it slows down", slowest(case) < usual_surge(case) - SLOWER),
        ]
    return [
        Claim("ship 1 is passed port to port", offset_abeam(case, "ship_1") > ASIDE),
        Claim("ship 2 is overtaken on its port side", offset_abeam(case, "ship_2") < -ASIDE),
        Claim("ship 3 is passed astern", is_astern(case, "ship_3")),
        Claim("the obstacle is gone round to starboard", offset_beside_obstacle(case) > ASIDE),
    ]


_DAMAGE: Final = ("collisions", "groundings", "allisions")


def _shaped(scenario: Scenario, shape: str) -> Scenario:
    from ccas_core.sim.scenario_steering import Shape, domain_of

    ships = tuple(
        replace(
            plan,
            ship=replace(
                plan.ship,
                stated_domain=domain_of(
                    Shape(shape), plan.ship.hull, plan.limits.max_speed if plan.limits else plan.speed
                ),
            ),
        )
        for plan in scenario.ships
    )
    return replace(scenario, ships=ships)


def _blind(scenario: Scenario) -> Scenario:
    """The same, but the controller knows nothing of the current."""
    ships = tuple(
        replace(plan, control=replace(plan.control, options={**plan.control.options, "knows_current": "no"}))
        if plan.ship.id == OWN
        else plan
        for plan in scenario.ships
    )
    return replace(scenario, ships=ships)
