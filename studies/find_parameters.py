"""Find the parameters that the paper does not print, and show what they are worth.

    python studies/find_parameters.py --profile crossing --samples 200 --processes 2
    python studies/find_parameters.py --profile head_on --samples 200 --processes 2

Every sample is one set of the numbers that the paper leaves out; what it prints stays as printed
(K_y = 0.01 head-on and 5 crossing, K_s, K_d, beta, N, iter_max).  A sample sails the head-on cases, or
every row of Table 2.  It fails with the first case in which hulls touch, a safety area is entered, a
ship is frozen, or the roles are not those of Sec. 5; of the samples that pass all, the best has the
least shortfall of safety indices behind the paper's (beyond a factor of 1.5) and the least delay.
Sample 0 is what the profile holds now.

The journal (one JSON line a sample) makes the study resumable: samples are seeded one by one, and
those already in it are not sailed again.
"""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ccas_cli.paper import ALLOWANCE, TABLE_2, Claim, Row, claims_of, head_on_claims
from ccas_core.dmpc.solvers import AbstractLocalSolver, make_solver
from ccas_core.plugins import load
from ccas_core.sim.metrics import summary
from ccas_core.sim.scenario import Scenario
from ccas_core.sim.scenario_file import load_scenario
from ccas_core.sim.voyage import voyage
from ccas_scenarios import path

# name: (least, greatest); drawn evenly on a logarithmic scale
RANGES = {
    "K_ca": (600.0, 3000.0),
    "kappa_along": (0.7, 1.3),
    "kappa_across": (1.1, 2.0),
    "mu_1": (0.01, 1.0),
    "mu_2": (0.05, 5.0),
    "mu_3": (0.001, 0.03),
    "gamma_s": (0.002, 0.1),
    "gamma_y": (0.3, 4.0),
    "K_e": (0.006, 0.03),
    "lambda": (0.7, 1.3),
}
HEAD_ON_CASES = ("fig_07a", "fig_06b", "fig_06c")
_HARDEST_FIRST = ("fig_13_n30", "fig_13", "six_ships", "five_ships", "fig_14", "fig_13_n60")


def main() -> None:
    """Run the study, or go on with it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--profile", choices=("crossing", "head_on"), default="crossing")
    parser.add_argument("--samples", type=int, default=100)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--solver", default="riccati")
    parser.add_argument("--out", type=Path, default=Path("runs/parameters"))
    choice = parser.parse_args()
    choice.out.mkdir(parents=True, exist_ok=True)
    journal = choice.out / f"{choice.profile}_{choice.solver}_{choice.seed}.jsonl"
    done = {}
    if journal.exists():
        done = {entry["sample"]: entry for entry in map(json.loads, journal.read_text().splitlines())}
    todo = [n for n in range(choice.samples) if n not in done]
    with ProcessPoolExecutor(choice.processes) as pool, journal.open("a") as file:
        jobs = [pool.submit(evaluate, choice.profile, choice.seed, n, choice.solver) for n in todo]
        for job in as_completed(jobs):
            entry = job.result()
            done[entry["sample"]] = entry
            file.write(json.dumps(entry) + "\n")
            file.flush()
            print(f"{len(done)}/{choice.samples}  sample {entry['sample']}: {entry['verdict']}", flush=True)
    passed = sorted((entry for entry in done.values() if entry["passed"]), key=lambda entry: entry["cost"])
    print(f"{len(passed)} of {len(done)} samples pass every row; the best:")
    for entry in passed[:5]:
        print(f"  cost {entry['cost']:.3f}  sample {entry['sample']}  {entry['parameters']}")


def drawn(seed: int, sample: int) -> dict[str, float]:
    """Draw one sample; sample 0 is what the profiles hold now."""
    if sample == 0:
        return {}
    rng = np.random.default_rng([seed, sample])
    return {name: float(f"{np.exp(rng.uniform(*np.log(ends))):.3g}") for name, ends in RANGES.items()}


def evaluate(profile: str, seed: int, sample: int, solver: str) -> dict[str, Any]:
    """Sail all cases of a profile with one sample, until one fails."""
    parameters = drawn(seed, sample)
    entry = {"sample": sample, "parameters": parameters, "passed": False, "cost": float("inf")}
    cost = 0.0
    for name, row in _cases(profile):
        scenario, result = _sail(name, parameters, solver)
        claims = claims_of(row, scenario, result) if row else head_on_claims(name, result)
        if failed := _first_failed(claims):
            return entry | {"verdict": f"{name}: {failed}"}
        ships = result["ships"].values()
        cost += max(ship["delay_s"] for ship in ships) / 4000.0
        if row:
            pairs = zip(row.safety_index, (ship["min_safety_index_m"] for ship in ships), strict=True)
            cost += sum(max(0.0, paper / ALLOWANCE - ours) / paper for paper, ours in pairs)
    return entry | {"verdict": f"passes, cost {cost:.3f}", "passed": True, "cost": cost}


def _cases(profile: str) -> list[tuple[str, Row | None]]:
    if profile == "head_on":
        return [(name, None) for name in HEAD_ON_CASES]
    rows = {row.scenario: row for row in TABLE_2}
    order = [*_HARDEST_FIRST, *(name for name in rows if name not in _HARDEST_FIRST)]
    return [(name, rows[name]) for name in order]


def _first_failed(claims: list[Claim]) -> str:
    return next((claim.text for claim in claims if not claim.holds), "")


@cache
def _solver(name: str) -> AbstractLocalSolver:
    return make_solver(name)


def _sail(name: str, parameters: dict[str, float], solver: str) -> tuple[Scenario, dict[str, Any]]:
    scenario = load_scenario(path(f"tran2026/{name}"))
    control = replace(scenario.control, parameters={**parameters, **scenario.control.parameters})
    scenario = replace(scenario, control=control)
    frames = tuple(voyage(scenario, load().rulesets, _solver(solver)))
    return scenario, dict(summary(scenario, frames, solver))


if __name__ == "__main__":
    main()
