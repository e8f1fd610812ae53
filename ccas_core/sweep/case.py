"""One case of a sweep: which encounter it is, how it is sailed, and what is kept of it."""

from __future__ import annotations

import hashlib
import json
import time
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from ..agent.events import Conduct
from ..dmpc.solvers import AbstractLocalSolver
from ..sim.conduct import CALM_BEYOND, has_acted
from ..sim.frame import Frame
from ..sim.law_log import law_log
from ..sim.metrics import summary
from ..sim.scenario import Scenario
from ..sim.scenario_dump import dump_scenario
from ..sim.scenario_file import load_scenario, parse_scenario
from ..sim.start import graph_at_start
from ..sim.voyage import undisturbed_times, voyage
from ..tapd.ruleset import AbstractRuleset
from .alone import could_avoid
from .borders import with_border
from .changes import actions, changes_of_mind, restless
from .draw import Kind, Risk, draw_encounter, undisturbed_meeting
from .groups import draw_junction, draw_reach
from .mixed import controllers_of, outcome, with_control
from .spec import TWO_SHIPS, Cell, Draw, Sweep, Variant

KEPT: Final = ("collisions", "entries", "groundings", "frozen", "min_clearance_m", "min_safety_index_m")


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One encounter of a sweep under one ruleset; all that is needed to sail it, small enough to be sent."""

    cell: Cell
    ruleset: str
    variant: Variant
    seed: int
    index: int  # within its cell
    solver: str

    @property
    def name(self) -> str:
        """Name of the case, which serves as a file's."""
        variant = f"-{self.variant.name}" if self.variant.name else ""
        return f"{self.cell.name}-{self.ruleset}{variant}-{self.index:05d}"

    @property
    def under(self) -> str:
        """Ruleset by which it is sailed; of a border, both."""
        return "|".join(self.cell.border) if self.cell.border else self.ruleset

    def key(self, code: str) -> str:
        """Digest of all that decides about the result; `code` is that of the program."""
        drawn = replace(self, cell=replace(self.cell, count=0))  # the same in a cell of any size
        text = json.dumps([asdict(drawn), code], sort_keys=True, default=str)
        return hashlib.sha256(text.encode()).hexdigest()[:20]


def cases(sweep: Sweep) -> Iterator[Case]:
    """All cases of a sweep; those of different cells take turns, so that all fill up together."""
    at_borders = [cell.border[0] for cell in sweep.cells if cell.border]
    kinds = [
        (variant, ruleset, cell)
        for variant in sweep.variants
        for ruleset in dict.fromkeys([*sweep.rulesets, *at_borders])
        for cell in sweep.cells
        if ruleset in ([cell.border[0]] if cell.border else sweep.rulesets)
    ]
    for index in range(max(cell.count for cell in sweep.cells)):
        for variant, ruleset, cell in kinds:
            if index < cell.count:
                yield Case(
                    cell=cell,
                    ruleset=ruleset,
                    variant=variant,
                    seed=sweep.seed,
                    index=index,
                    solver=sweep.solver,
                )


def scenario(case: Case, rulesets: Mapping[str, AbstractRuleset]) -> Scenario:
    """Make the scenario of a case: drawn, or read, then dumped and read back, so that its file replays it."""
    drawn = _drawn(case)
    drawn = replace(
        drawn,
        name=case.name,
        control=replace(
            drawn.control, parameters={**drawn.control.parameters, **dict(case.variant.parameters)}
        ),
    )
    if case.cell.breach is not Conduct.DUTIFUL:
        drawn = _with_breach(drawn, rulesets, case.cell.breach)
    return parse_scenario(dump_scenario(drawn))


def _drawn(case: Case) -> Scenario:
    cell = case.cell
    if cell.draw is None:
        found = load_scenario(Path(cell.scenario))
        return replace(found, waters=replace(found.waters, ruleset=case.ruleset))
    name = cell.draw.value if cell.control else cell.name  # all pairings sail the same encounters
    rng = np.random.default_rng([case.seed, zlib.crc32(name.encode()), case.index])
    if cell.draw is Draw.JUNCTION:
        return draw_junction(rng, cell.ships, case.ruleset)
    if cell.draw is Draw.REACH:
        return draw_reach(rng, cell.ships, case.ruleset)
    drawn = draw_encounter(rng, Kind(cell.draw.value), cell.risk, case.ruleset)
    drawn = with_control(drawn, cell.control) if cell.control else drawn
    return with_border(rng, drawn, cell.border[1], lacking=cell.lacking) if cell.border else drawn


def _with_breach(drawn: Scenario, rulesets: Mapping[str, AbstractRuleset], conduct: Conduct) -> Scenario:
    """Let one of the ships that are to give way at first break its duty: the first by its id."""
    obliged = {
        ship
        for settlement in graph_at_start(drawn, rulesets).settlements
        for ship in (settlement.pair if settlement.fallback else settlement.one.give_way)
    }
    chosen = min(obliged, default=None)
    ships = tuple(replace(plan, conduct=conduct) if plan.ship.id == chosen else plan for plan in drawn.ships)
    return replace(drawn, ships=ships)


def sail(
    sailed: Scenario, rulesets: Mapping[str, AbstractRuleset], solver: AbstractLocalSolver
) -> tuple[tuple[Frame, ...], dict[str, Any]]:
    """Sail a case, and keep what counts of it."""
    began = time.perf_counter()
    frames = tuple(voyage(sailed, rulesets, solver, controllers_of(sailed)))
    found: dict[str, Any] = summary(sailed, frames, solver.name)
    return frames, {
        **{key: found[key] for key in KEPT},
        **_two_ships(sailed, frames),
        "laws": _laws(sailed, frames),
        "avoidable": could_avoid(sailed, frames),
        "mixed": outcome(sailed, frames, found),
        "count": len(sailed.ships),
        "ships": found["ships"],
        "undisturbed_s": {str(id_): time for id_, time in undisturbed_times(sailed).items()},
        "encounters": _judged(sailed, found["encounters"]),
        "changes_of_mind": (changes := changes_of_mind(frames)),
        "restless": restless(changes, [met["ships"] for met in found["encounters"]]),
        "actions": actions(frames),
        "periods": len(frames),
        "seconds": time.perf_counter() - began,
    }


def _judged(sailed: Scenario, met: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Encounters; where a ship is made to break its duty, nobody's faithfulness is judged."""
    if all(plan.conduct is Conduct.DUTIFUL for plan in sailed.ships):
        return met
    return [{**each, "faithful": None} for each in met]


def _two_ships(sailed: Scenario, frames: Sequence[Frame]) -> dict[str, Any]:
    """Whether two ships were to stay well clear, and whether one of them acted all the same."""
    if len(sailed.ships) != 2:
        return {"calm": None, "acted": None}
    calm = undisturbed_meeting(sailed).clearance > CALM_BEYOND
    return {"calm": calm, "acted": any(has_acted(frames, plan.ship.id) for plan in sailed.ships)}


def _laws(sailed: Scenario, frames: Sequence[Frame]) -> dict[str, int] | None:
    """What the log says of laws, where there is a border."""
    if not sailed.waters.regions:
        return None
    log = law_log(sailed, frames)
    return {**asdict(log), "faults": log.faults}


def geometry(cell: Cell) -> str:
    """What a cell draws, in a word."""
    return cell.draw.value if cell.draw else "scenario"


def is_two_ships(cell: Cell) -> bool:
    """Whether a cell draws two ships."""
    return cell.draw in TWO_SHIPS


__all__ = ["Case", "Risk", "cases", "geometry", "is_two_ships", "sail", "scenario"]
