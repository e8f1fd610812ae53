"""The cases of the two papers: sailed anew, their tables and figures made, their claims checked."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol

from . import congested, paper, talk
from .paper import Claim

if TYPE_CHECKING:
    from ccas_core.controllers import AbstractController
    from ccas_core.dmpc.parameters import Wait
    from ccas_core.dmpc.solvers import AbstractLocalSolver
    from ccas_core.sim.frame import Frame
    from ccas_core.sim.scenario import Scenario
    from ccas_core.tapd.ruleset import AbstractRuleset

_SET: Final = "tran2026"
_SEVEN: Final = tuple(f"fig_07{letter}" for letter in "abcdefghi")
_ITERATIONS: Final = (1, 3, 6, 11)
_HEAD_ON_TIMES: Final = (0.0, 140.0, 300.0, 500.0)  # start, early action, midway, abeam [s]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Case:
    """A scenario that was sailed."""

    scenario: Scenario
    frames: tuple[Frame, ...]
    summary: Mapping[str, Any]


class Picture(Protocol):
    """A figure, for this module need not know who draws it."""

    def savefig(self, fname: Path, *, dpi: float, metadata: dict[str, None]) -> None:
        """Write the figure."""


@dataclass(slots=True, eq=False)
class Reproduction:
    """Sails scenarios of the papers, each at most once in a command."""

    rulesets: Mapping[str, AbstractRuleset]
    solver_name: str
    solver: AbstractLocalSolver
    out: Path
    json: bool
    controllers: Mapping[str, AbstractController] = field(default_factory=dict)
    cases: dict[str, Case] = field(default_factory=dict)
    findings: dict[str, list[Claim]] = field(default_factory=dict)
    data: dict[str, Any] = field(default_factory=dict)

    def sail(self, name: str, change: Callable[[Scenario], Scenario] | None = None, label: str = "") -> Case:
        """Sail a shipped scenario, changed if asked; `label` tells variants apart."""
        from ccas_core.sim.metrics import summary
        from ccas_core.sim.scenario_file import load_scenario
        from ccas_core.sim.voyage import voyage
        from ccas_scenarios import path

        key = f"{name} {label}".strip()
        if key not in self.cases:
            talk.note(f"sailing {key} with {self.solver_name}")
            shipped = path(name if "/" in name else f"{_SET}/{name}")
            scenario = load_scenario(shipped, self.rulesets, controllers=self.controllers)
            scenario = change(scenario) if change else scenario
            frames = tuple(voyage(scenario, self.rulesets, self.solver, self.controllers))
            self.cases[key] = Case(
                scenario=scenario, frames=frames, summary=summary(scenario, frames, self.solver_name)
            )
        return self.cases[key]

    def check(self, name: str, claims: Sequence[Claim]) -> None:
        """Take note of claims, and print them."""
        self.findings[name] = list(claims)
        if self.json:
            return
        for claim in claims:
            talk.show(f"  {'ok    ' if claim.holds else 'FAILED'}  {name}: {claim.text}")

    def table(self, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """Print a table, unless JSON is asked for."""
        if not self.json:
            talk.show_table(headings, rows)
            talk.show("")

    def title(self, text: str) -> None:
        """Print a heading, unless JSON is asked for."""
        if not self.json:
            talk.show(f"\n{text}\n")

    def talk(self, text: str) -> None:
        """Print a line above a table, unless JSON is asked for."""
        if not self.json:
            talk.show(text)

    def save(self, name: str, picture: Picture) -> None:
        """Write a figure, and say where."""
        self.out.mkdir(parents=True, exist_ok=True)
        file = self.out / f"{name}.png"
        picture.savefig(file, dpi=150, metadata={"Software": None})
        talk.note(f"drawn: {file}")


def table_2(made: Reproduction) -> None:
    """All rows of Table 2: update times and safety indices beside the paper's, and who gave way."""
    made.title(f"Table 2, ours (solver {made.solver_name}) beside the paper's")
    rows, data = [], []
    for row in paper.TABLE_2:
        case = made.sail(row.scenario)
        for n, (id_, ship) in enumerate(case.summary["ships"].items()):
            times = [
                ms / 1000.0
                for frame in case.frames
                if id_ in frame.ships
                for ms in frame.ships[id_].update_ms
            ]
            entry = {
                "scenario": row.scenario,
                "ship": id_,
                "max_s": max(times),
                "mean_s": sum(times) / len(times),
                "min_safety_index_m": ship["min_safety_index_m"],
                "paper": {
                    "max_s": row.max_s[n],
                    "mean_s": row.mean_s[n],
                    "min_safety_index_m": row.safety_index[n],
                },
                "min_clearance_m": ship["min_clearance_m"],
                "gave_way_to": _gave_way_to(case.summary, id_),
                "acted": paper.acts(ship),
                "delay_s": ship["delay_s"],
            }
            data.append(entry)
            rows.append(
                (
                    row.title if n == 0 else "",
                    id_,
                    f"{entry['max_s']:.3f}",
                    f"{row.max_s[n]:.3f}",
                    f"{entry['mean_s']:.4f}",
                    f"{row.mean_s[n]:.3f}",
                    f"{ship['min_safety_index_m']:.1f}",
                    f"{row.safety_index[n]:.1f}",
                    "small" if ship["min_safety_index_m"] * paper.ALLOWANCE < row.safety_index[n] else "",
                    f"{ship['min_clearance_m']:.1f}",
                    "-" if ship["delay_s"] is None else f"{ship['delay_s']:.0f}",
                    ", ".join(_gave_way_to(case.summary, id_)) or "-",
                    "yes" if entry["acted"] else "no",
                )
            )
    made.data["table-2"] = data
    made.table(
        (
            "case", "ship", ">max [s]", ">paper", ">mean [s]", ">paper", ">min index [m]", ">paper", "",
            ">min clearance [m]", ">delay [s]", "gives way to", "acted",
        ),
        rows,
    )  # fmt: skip
    for row in paper.TABLE_2:
        case = made.sail(row.scenario)
        made.check(row.scenario, paper.claims_of(row, case.scenario, case.summary))


def _gave_way_to(summary: Mapping[str, Any], ship: str) -> list[str]:
    """Ships to which this one owed way by the rules."""
    return sorted(
        other
        for each in summary["encounters"]
        if ship in each["give_way"]
        for other in each["ships"]
        if other != ship
    )


def figure_5(made: Reproduction) -> None:
    """Fig. 5: how the two ships of the head-on cases meet."""
    from ccas_core.sim.plotting import paths

    case = made.sail("fig_07a")
    made.save("fig_05", paths(case.scenario, case.frames, times=[0.0], title="Fig. 5: head-on situation"))
    made.check("fig_05", paper.collides_if_nobody_acts(case.scenario))


def figure_6(made: Reproduction) -> None:
    """Fig. 6: head-on alone, with an obstacle, and with overtaking and an obstacle."""
    from ccas_core.sim.plotting import compare

    names = {"fig_06a": "head-on", "fig_06b": "an obstacle", "fig_06c": "overtaking, an obstacle"}
    cases = {name: made.sail(name) for name in names}
    made.save(
        "fig_06",
        compare([(names[name], case.scenario, case.frames) for name, case in cases.items()], _HEAD_ON_TIMES),
    )
    for name, case in cases.items():
        made.check(name, paper.head_on_claims(name, case.summary))


def figure_7(made: Reproduction) -> None:
    """Fig. 7: head-on with nine sets of parameters."""
    from ccas_core.sim.plotting import compare

    cases = {name: made.sail(name) for name in _SEVEN}
    made.title("Fig. 7: head-on with nine sets of parameters")
    rows = []
    for name, case in cases.items():
        one, two = case.summary["ships"]["ship_1"], case.summary["ships"]["ship_2"]
        rows.append(
            (
                f"({name[-1]})",
                case.scenario.title.partition(", ")[2],
                f"{_least_abeam(case):.1f}",
                f"{one['max_offset_change_m']:.1f}",
                f"{two['max_offset_change_m']:.1f}",
                f"{_first_action(case, 'ship_2'):.0f}",
            )
        )
    made.table(
        ("set", "change", ">lateral distance when abeam [m]", ">ship 1 offset [m]", ">ship 2 offset [m]",
         ">ship 2 first acts [s]"),
        rows,
    )  # fmt: skip
    panels = [(case.scenario.title.partition(", ")[2], case.scenario, case.frames) for case in cases.values()]
    made.save("fig_07", compare(panels, _HEAD_ON_TIMES))
    for name, case in cases.items():
        made.check(name, paper.head_on_claims(name, case.summary))


def _least_abeam(case: Case) -> float:
    """Distance between the ships across the waterway when they are abeam [m]."""
    frame = min(
        (frame for frame in case.frames if len(frame.ships) > 1),
        key=lambda frame: abs(frame.ships["ship_1"].pose.y - frame.ships["ship_2"].pose.y),  # type: ignore[index]
    )
    one, two = frame.ships.values()
    return abs(one.pose.x - two.pose.x)


def _first_action(case: Case, ship: str) -> float:
    """Time at which a ship first changes its offset by more than 10 m [s]; not a number if never."""
    times = (frame.time for frame in case.frames for id_, now in frame.ships.items() if id_ == ship
             and abs(now.offset) > paper.ACTS_OFFSET)  # fmt: skip
    return next(times, float("nan"))


def figure_8(made: Reproduction) -> None:
    """Fig. 8: the difference between the local and the broadcast trajectory shrinks with iterations."""
    from ccas_core.sim.plotting import residuals

    cases = {n: made.sail(f"fig_09_iter_{n:02d}") for n in _ITERATIONS}
    ships = ("ship_1", "ship_2")
    made.title("Fig. 8: greatest distance between local and broadcast trajectory [m]")
    last = {n: {ship: _residuals_after(case, ship, n) for ship in ships} for n, case in cases.items()}
    made.talk("voyages with each iter_max, after the last iteration of a period:")
    made.table(
        ("iter_max", *_spread_headings(ships)), [(str(n), *_spread(found)) for n, found in last.items()]
    )
    longest = cases[max(_ITERATIONS)]
    within = {n: {ship: _residuals_after(longest, ship, n) for ship in ships} for n in _ITERATIONS}
    made.talk(f"the voyage with iter_max = {max(_ITERATIONS)}, after iteration s of a period:")
    made.table(("s", *_spread_headings(ships)), [(str(n), *_spread(found)) for n, found in within.items()])
    made.save("fig_08", residuals({n: case.frames for n, case in cases.items()}))
    made.data["fig-8"] = {
        label: {
            n: {ship: {"mean": _mean(v), "max": max(v)} for ship, v in found.items()}
            for n, found in data.items()
        }
        for label, data in (("iter_max", last), ("iteration", within))
    }
    shrinks = [max(_mean(values) for values in found.values()) for found in within.values()]
    falls = all(after < before for before, after in pairwise(shrinks))
    ends = [max(max(values) for values in last[n].values()) for n in (min(_ITERATIONS), max(_ITERATIONS))]
    made.check(
        "fig_08",
        [
            Claim("within a period, the mean difference falls from iteration 1 to 3 to 6 to 11", falls),
            Claim("iter_max = 11 leaves less than a hundredth of iter_max = 1", ends[1] < ends[0] / 100.0),
        ],
    )  # fmt: skip


def _residuals_after(case: Case, ship: str, iteration: int) -> list[float]:
    """Distance between local and broadcast trajectory after an iteration, in every period [m]."""
    rows = (now for frame in case.frames for id_, now in frame.ships.items() if id_ == ship)
    return [now.residuals[iteration - 1] for now in rows if len(now.residuals) >= iteration]


def _spread_headings(ships: Sequence[str]) -> list[str]:
    return [f">{ship}, {what}" for ship in ships for what in ("mean", "max")]


def _spread(found: Mapping[str, list[float]]) -> list[str]:
    return [f"{figure:.4f}" for values in found.values() for figure in (_mean(values), max(values))]


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


def figure_9(made: Reproduction) -> None:
    """Fig. 9: the solution with 1, 3, 6 and 11 iterations."""
    from ccas_core.sim.plotting import compare

    cases = {n: made.sail(f"fig_09_iter_{n:02d}") for n in _ITERATIONS}
    made.save(
        "fig_09",
        compare(
            [(f"iter_max = {n}", case.scenario, case.frames) for n, case in cases.items()], _HEAD_ON_TIMES
        ),
    )
    for n, case in cases.items():
        made.check(f"fig_09, iter_max = {n}", paper.head_on_claims("fig_09", case.summary))


def _crossing(name: str) -> Callable[[Reproduction], None]:
    def figure(made: Reproduction) -> None:
        from ccas_core.sim.plotting import fleet

        case = made.sail(name)
        made.save(name, fleet(case.scenario, case.frames))
        row = next(row for row in paper.TABLE_2 if row.scenario == name)
        made.check(name, paper.claims_of(row, case.scenario, case.summary))

    return figure


def figure_14(made: Reproduction) -> None:
    """Fig. 14: four ships in a ring, without and with detection of the deadlock."""
    from ccas_core.sim.plotting import fleet

    _crossing("fig_14")(made)
    without = made.sail("fig_14_undetected")
    made.save("fig_14_undetected", fleet(without.scenario, without.frames))
    result = without.summary
    troubled = result["collisions"] > 0 or result["frozen"] > 0
    words = f"{result['collisions']} collisions, {result['frozen']} ships frozen"
    with_it = made.sail("fig_14").summary
    made.check(
        "fig_14_undetected",
        [
            Claim(f"without detection there is trouble ({words})", troubled),
            Claim("with detection a deadlock is found and opened", bool(with_it["deadlocks"])),
        ],
    )


def _reading(scenario: Scenario, reading: Wait) -> Scenario:
    return replace(scenario, control=replace(scenario.control, wait=reading))


def wait(made: Reproduction) -> None:
    """Both readings of wait(i) in Algorithm 2, side by side."""
    from ccas_core.dmpc.parameters import Wait

    made.title("wait(i): interleaved and sequential")
    rows = []
    for name in ("fig_07a", *(row.scenario for row in paper.TABLE_2)):
        for reading in Wait:
            case = made.sail(name, partial(_reading, reading=reading), label=reading.value)
            result = case.summary
            delays = [ship["delay_s"] for ship in result["ships"].values()]
            rows.append(
                (
                    name,
                    reading.value,
                    str(result["collisions"]),
                    str(result["entries"]),
                    str(result["frozen"]),
                    f"{result['min_safety_index_m']:.1f}",
                    "-" if None in delays else f"{max(delays):.0f}",
                    ", ".join(id_ for id_, ship in result["ships"].items() if paper.acts(ship)),
                )
            )
    made.table(
        (
            "case",
            "wait",
            ">collisions",
            ">entries",
            ">frozen",
            ">min index [m]",
            ">greatest delay [s]",
            "acted",
        ),
        rows,
    )


CASES: Final[dict[str, Callable[[Reproduction], None]]] = {
    "table-2": table_2,
    "fig-5": figure_5,
    "fig-6": figure_6,
    "fig-7": figure_7,
    "fig-8": figure_8,
    "fig-9": figure_9,
    "fig-10": _crossing("fig_10"),
    "fig-11": _crossing("fig_11"),
    "fig-12": _crossing("fig_12"),
    "fig-13": _crossing("fig_13"),
    "fig-14": figure_14,
    "wait": wait,
    "sim-1": congested.simulation_1,
    **{f"sim-{n}": partial(congested.simulation, f"sim_{n}") for n in (2, 3, 4, 5)},
}
