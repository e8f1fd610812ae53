"""`ccas bench`: how fast this machine solves what ships ask, all solvers side by side in one run."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from . import inputs, talk
from .exits import answered

if TYPE_CHECKING:
    from ccas_core.dmpc.local_problem import LocalProblem, Solution
    from ccas_core.dmpc.solvers import AbstractLocalSolver
    from ccas_core.frames import FloatArray
    from ccas_core.sim.scenario import Scenario
    from ccas_core.tapd.ruleset import AbstractRuleset

_VOYAGE: Final = "tran2026/fig_12"
_UPDATES: Final = "tran2026/six_ships"
_REFERENCE: Final = "ipopt"
_NOT_WORSE: Final = 1e-6  # difference of objectives that does not count


@answered
def bench(
    context: typer.Context,
    problems: Annotated[int, typer.Option(help="Local problems to solve with each solver.", min=10)] = 200,
    as_json: talk.AsJson = False,
) -> None:
    """Measure update times, voyages and start-up on this machine, solvers side by side.

    The local problems are recorded from the six-ship voyage of Table 2 (N = 45); each is solved by every
    solver from the same start, one after the other. Only the solver call is timed. The voyage is
    that of Fig. 12.

    Example:
        ccas bench
        ccas bench --problems 50 --json
    """
    from ccas_core.dmpc.solvers import SOLVERS, make_solver
    from ccas_core.sim.scenario_file import load_scenario
    from ccas_scenarios import path

    rulesets = inputs.load_plugins(context).rulesets
    solvers = {name: make_solver(name) for name in sorted(SOLVERS)}
    result: dict[str, Any] = {"machine": _machine(), "start_up": _start_up()}
    talk.note(f"recording local problems of {_UPDATES}")
    starts = _recorded(load_scenario(path(_UPDATES)), rulesets, solvers["fatrop"], problems)
    result["update"] = _updates(starts, solvers)
    voyage = load_scenario(path(_VOYAGE))
    result["voyage"] = {"scenario": voyage.name}
    for name, solver in solvers.items():
        talk.note(f"sailing {_VOYAGE} with {name}")
        result["voyage"][name] = {"seconds": _sailed(voyage, rulesets, solver)}
    if as_json:
        talk.show_json(result)
    else:
        _show(result)


def _machine() -> dict[str, Any]:
    from importlib.metadata import version

    packages = ("casadi", "numpy", "networkx", "numba")
    return {
        "python": platform.python_version(),
        "system": platform.platform(terse=True),
        "processor": platform.machine(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        **{package: version(package) for package in packages},
    }


def _start_up() -> dict[str, float]:
    """Wall time of `ccas --help`, least of five [s]."""
    command = [sys.executable, "-c", "from ccas_cli.main import main; main()", "--help"]
    times = []
    for _ in range(5):
        began = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)  # noqa: S603 - our own program
        times.append(time.perf_counter() - began)
    return {"help_seconds": min(times)}


def _recorded(
    scenario: Scenario, rulesets: Mapping[str, AbstractRuleset], solver: AbstractLocalSolver, count: int
) -> list[tuple[LocalProblem, FloatArray]]:
    """Local problems and starts of a voyage, `count` of them evenly spread."""
    from ccas_core.dmpc.solvers import Recorder
    from ccas_core.sim.voyage import voyage

    recorder = Recorder(solver)
    for _ in voyage(scenario, rulesets, recorder):
        pass
    step = max(1, len(recorder.starts) // count)
    return recorder.starts[::step][:count]


def _updates(
    starts: list[tuple[LocalProblem, FloatArray]], solvers: Mapping[str, AbstractLocalSolver]
) -> dict[str, Any]:
    import numpy as np

    talk.note(f"solving {len(starts)} starts with each of {', '.join(solvers)}")
    for solver in solvers.values():  # programmes are built, and code compiled, before the clock runs
        solver.solve(*starts[0])
    answers: dict[str, list[Solution]] = {name: [] for name in solvers}
    for problem, guess in starts:
        for name, solver in solvers.items():
            answers[name].append(solver.solve(problem, guess))
    milliseconds = {
        name: np.array([1000.0 * each.seconds for each in found]) for name, found in answers.items()
    }
    reference = answers[_REFERENCE]
    found: dict[str, Any] = {"starts": len(starts), "reference": _REFERENCE}
    for name, times in milliseconds.items():
        pairs = [
            (mine.objective - theirs.objective) / max(1.0, abs(theirs.objective))
            for mine, theirs in zip(answers[name], reference, strict=True)
            if theirs.outcome.usable
        ]
        gaps = np.array(pairs)
        found[name] = {
            "median_ms": float(np.median(times)),
            "p99_ms": float(np.percentile(times, 99)),
            "max_ms": float(np.max(times)),
            "speed_up_median": float(np.median(milliseconds[_REFERENCE] / times)),
            "usable_share": float(np.mean([each.outcome.usable for each in answers[name]])),
            "same_share": float(np.mean(np.abs(gaps) <= _NOT_WORSE)),
            "better": int(np.sum(gaps < -_NOT_WORSE)),
            "worse": int(np.sum(gaps > _NOT_WORSE)),
            "not_worse_share": float(np.mean(gaps <= _NOT_WORSE)),
        }
    return found


def _sailed(
    scenario: Scenario, rulesets: Mapping[str, AbstractRuleset], solver: AbstractLocalSolver
) -> float:
    """Wall time of a voyage [s]."""
    from ccas_core.sim.voyage import voyage

    began = time.perf_counter()
    for _ in voyage(scenario, rulesets, solver):
        pass
    return time.perf_counter() - began


def _show(result: Mapping[str, Any]) -> None:
    talk.show("machine: " + ", ".join(f"{key} {value}" for key, value in result["machine"].items()))
    talk.show(f"start-up: ccas --help {result['start_up']['help_seconds']:.2f} s (least of 5)\n")
    update, voyage = result["update"], result["voyage"]
    rows = []
    for name, figures in update.items():
        if not isinstance(figures, dict):
            continue
        rows.append(
            (
                name,
                f"{figures['median_ms']:.2f}",
                f"{figures['p99_ms']:.2f}",
                f"{figures['max_ms']:.2f}",
                f"{figures['speed_up_median']:.1f}",
                f"{100.0 * figures['usable_share']:.1f} %",
                f"{100.0 * figures['same_share']:.1f} %",
                str(figures["better"]),
                str(figures["worse"]),
                f"{voyage[name]['seconds']:.1f}",
            )
        )
    talk.show(
        f"{update['starts']} starts of {_UPDATES}, N = 45, against {update['reference']}; voyage {_VOYAGE}"
    )
    talk.show_table(
        ("solver", ">median [ms]", ">p99 [ms]", ">max [ms]", ">times faster", ">converged", ">same optimum",
         ">better", ">worse", ">voyage [s]"),
        rows,
    )  # fmt: skip
