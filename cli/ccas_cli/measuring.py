"""What `ccas bench` measures: solvers on recorded problems, voyages, networks that grow, start-up.

Times are compared side by side in one run, for machines differ and are shared.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ccas_core.dmpc.negotiate import guess
from ccas_core.dmpc.parameters import Start
from ccas_core.dmpc.solvers import AbstractLocalSolver, Recorder, Task
from ccas_core.sim.network import network
from ccas_core.sim.scenario import Profile
from ccas_core.sim.scenario_dump import dump_scenario
from ccas_core.sim.voyage import voyage

if TYPE_CHECKING:
    from ccas_core.dmpc.local_problem import LocalProblem, Solution
    from ccas_core.frames import FloatArray
    from ccas_core.plugins import Plugins
    from ccas_core.sim.scenario import Scenario

REFERENCE: Final = "ipopt"
FAST: Final = "riccati"
NOT_WORSE: Final = 1e-6  # difference of objectives that does not count; relative, of objectives above one
HORIZONS: Final = (30, 45, 60)  # N of the agreement


def machine() -> dict[str, Any]:
    """What this runs on."""
    from importlib.metadata import PackageNotFoundError, version

    def installed(package: str) -> str:
        try:
            return version(package)
        except PackageNotFoundError:
            return "-"

    packages = ("casadi", "numpy", "networkx", "numba", "shapely")
    return {
        "python": platform.python_version(),
        "system": platform.platform(terse=True),
        "processor": platform.machine(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "ccas": installed("ccas"),
        **{package: installed(package) for package in packages},
    }


def start_up() -> dict[str, float]:
    """Wall time of `ccas --help`, least of five [s]."""
    command = [sys.executable, "-c", "from ccas_cli.main import main; main()", "--help"]
    times = []
    for _ in range(5):
        began = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)  # noqa: S603 - our own program
        times.append(time.perf_counter() - began)
    return {"help_seconds": min(times)}


def peak_memory() -> float | None:
    """Greatest memory of this process so far [MiB]; None where the system does not say."""
    try:
        import resource
    except ImportError:
        return None
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return used / 1024.0 if sys.platform != "darwin" else used / 1024.0**2


def recorded(scenario: Scenario, plugins: Plugins, solver: AbstractLocalSolver, count: int) -> list[Task]:
    """Local problems of a voyage with their starts, up to `count` of them, evenly spread."""
    recorder = Recorder(solver)
    for _ in voyage(scenario, plugins.rulesets, recorder, plugins.controllers):
        pass
    step = max(1, len(recorder.tasks) // count)
    return recorder.tasks[::step][:count]


def updates(tasks: Sequence[Task], solvers: Mapping[str, AbstractLocalSolver]) -> dict[str, Any]:
    """Solve every problem with every solver from the same start, one after the other.

    The fast solver also goes from all starts that there are: that is the dearest update there can be.
    """
    problem, guesses = tasks[0]
    for solver in solvers.values():  # programmes are built, and code compiled, before the clock runs
        solver.solve(problem, guesses[0])
    answers: dict[str, list[Solution]] = {name: [] for name in solvers}
    all_starts, walls = [], []
    for problem, guesses in tasks:
        for name, solver in solvers.items():
            answers[name].append(solver.solve(problem, guesses[0]))
        starts = every_start(problem, guesses[0])
        began = time.perf_counter()
        all_starts.append(solvers[FAST].best(problem, starts))
        walls.append(1000.0 * (time.perf_counter() - began))
    times = {name: np.array([1000.0 * each.seconds for each in found]) for name, found in answers.items()}
    reference, of_all = answers[REFERENCE], np.array([1000.0 * each.seconds for each in all_starts])
    by_solver = {}
    for name, found in answers.items():
        by_solver[name] = {
            "median_ms": float(np.median(times[name])),
            "p99_ms": float(np.percentile(times[name], 99)),
            "max_ms": float(np.max(times[name])),
            "speed_up_median": float(np.median(times[REFERENCE] / times[name])),
            **compared(found, reference),
        }
    return {
        "problems": len(tasks),
        "reference": REFERENCE,
        "solver": FAST,
        "speed_up_median": by_solver[FAST]["speed_up_median"],
        "speed_up_all_starts_median": float(np.median(times[REFERENCE] / of_all)),
        "p99_ms": float(np.percentile(walls, 99)),  # all starts, and all that is around the solver
        "median_ms": float(np.median(walls)),
        "not_worse_share": compared(all_starts, reference)["not_worse_share"],
        "same_start_not_worse_share": by_solver[FAST]["not_worse_share"],
        "solvers": by_solver,
        "times_ms": {**{name: each.tolist() for name, each in times.items()}, "all_starts": of_all.tolist()},
    }


def every_start(problem: LocalProblem, last: FloatArray) -> list[FloatArray]:
    """All starts of a problem, that of the last plan first."""
    return [guess(start, problem.offset_limits, last) for start in Start]


def compared(found: Sequence[Solution], reference: Sequence[Solution]) -> dict[str, Any]:
    """Count where one is better or worse than the other; the reference has to be usable to count."""
    gaps = np.array(
        [
            (mine.objective - theirs.objective) / max(1.0, abs(theirs.objective))
            if mine.outcome.usable
            else np.inf
            for mine, theirs in zip(found, reference, strict=True)
            if theirs.outcome.usable
        ]
    )
    return {
        "usable_share": float(np.mean([each.outcome.usable for each in found])),
        "compared": len(gaps),
        "same": int(np.sum(np.abs(gaps) <= NOT_WORSE)),
        "better": int(np.sum(gaps < -NOT_WORSE)),
        "worse": int(np.sum(gaps > NOT_WORSE)),
        "not_worse_share": float(np.mean(gaps <= NOT_WORSE)) if len(gaps) else 1.0,
        "worst_gap": float(np.max(gaps, initial=0.0, where=np.isfinite(gaps))),
    }


def agreement(
    scenarios: Sequence[Scenario], plugins: Plugins, solvers: Mapping[str, AbstractLocalSolver], count: int
) -> Iterator[dict[str, Any]]:
    """Compare the fast solver with the reference, on problems of some scenarios, a row for each N.

    Both have the same starts: those of the voyage, and once more all that there are.
    """
    fast, reference = solvers[FAST], solvers[REFERENCE]
    for horizon in HORIZONS:
        changed = [replace(each, control=replace(each.control, horizon=horizon)) for each in scenarios]
        # Some differ in their horizon only.
        known = plugins.vocabulary, plugins.controllers
        apart = {
            dump_scenario(replace(each, name="", title="", description=""), *known): each for each in changed
        }
        tasks = []
        for scenario in apart.values():
            tasks += recorded(scenario, plugins, fast, -(-count // (len(HORIZONS) * len(apart))))
        mine = [fast.best(*task) for task in tasks]
        theirs = [reference.best(*task) for task in tasks]
        every = [(problem, every_start(problem, guesses[0])) for problem, guesses in tasks]
        yield {
            "horizon": horizon,
            "problems": len(tasks),
            "neighbours": sorted({len(problem.threats) for problem, _ in tasks}),
            "outside_bounds": sum(not within_bounds(*pair) for pair in zip(tasks, mine, strict=True)),
            **compared(mine, theirs),
            "all_starts": compared(
                [fast.best(*task) for task in every], [reference.best(*task) for task in every]
            ),
        }


def within_bounds(task: Task, answer: Solution) -> bool:
    """Whether the controls of an answer keep their bounds exactly."""
    offset, factor = answer.plan.controls.T
    low, high = task[0].offset_limits.T
    return bool(np.all((low <= offset) & (offset <= high) & (factor >= 0.0) & (factor <= 1.0)))


def sailed(scenario: Scenario, plugins: Plugins, solver: AbstractLocalSolver) -> float:
    """Wall time of a voyage [s]."""
    began = time.perf_counter()
    for _ in voyage(scenario, plugins.rulesets, solver, plugins.controllers):
        pass
    return time.perf_counter() - began


def scale(
    sizes: Sequence[int],
    plugins: Plugins,
    solver: AbstractLocalSolver,
    seed: int = 0,
    profile: Profile = Profile.AUTO,
) -> Iterator[dict[str, Any]]:
    """Sail networks of so many ships at one density: wall time of one control period, from reports to rudder.

    The first period, in which no ship has a plan yet, is reported apart.
    """
    for ships in sizes:
        frames = voyage(network(ships, seed, profile=profile), plugins.rulesets, solver)
        began = time.perf_counter()
        next(frames)
        first, frame = time.perf_counter() - began, None
        seconds, busy = [], []
        for _ in range(max(2, min(10, 3000 // ships))):
            began, busy_before = time.perf_counter(), time.process_time()
            frame = next(frames)
            seconds.append(time.perf_counter() - began)
            busy.append(time.process_time() - busy_before)
        period = float(np.median(seconds))
        yield {
            "ships": ships,
            "profile": profile.value,
            "seconds": period,
            "cost_per_ship_ms": 1000.0 * period / ships,
            "cpu_seconds": float(
                np.median(busy)
            ),  # of all threads: what others do on the machine counts less
            "first_seconds": first,
            "encounters": len(frame.settlements) if frame else 0,
            "generations": len(frame.generations) if frame else 0,
            "fallbacks": sum(bool(ship.fallback) for ship in frame.ships.values()) if frame else 0,
            "peak_memory_mib": peak_memory(),
        }
