"""Try a million random encounters against all that is proved of the shipped rulesets.

    python studies/soundness.py --count 1000000 --processes 2 --budget 60

Each ruleset is proved first.  Then its share of the encounters is drawn, seeded, and judged from both sides;
an encounter that contradicts a property which was proved is printed, and the exit status is 1.
"""

from __future__ import annotations

import argparse
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial

from ccas_core.plugins import load
from ccas_core.proofs import pairs
from ccas_core.proofs.findings import Outcome
from ccas_core.proofs.questions import Questions
from ccas_core.proofs.solver import Budget
from ccas_core.proofs.trials import broken_by, trials
from ccas_core.tapd.written import WrittenRuleset

PROPERTIES = (pairs.consistent, pairs.complete, pairs.mirror_sound, pairs.exclusive)


def proved(ruleset: WrittenRuleset, budget: float) -> frozenset[str]:
    """Names of the properties that are proved."""
    questions = Questions((ruleset, ruleset), Budget(budget))
    findings = [prove(questions) for prove in PROPERTIES]
    return frozenset(
        each.property for each in findings if each is not None and each.outcome is Outcome.PROVED
    )


def tried(name: str, *, count: int, budget: float, seed: int) -> tuple[str, bool]:
    """What came of one ruleset: a line to print, and whether nothing was contradicted."""
    began = time.perf_counter()
    ruleset = load().ruleset(name)
    if not isinstance(ruleset, WrittenRuleset):
        return f"{name}: not written in a file, and left out", True
    certain = proved(ruleset, budget)
    wrong = [
        (property_, trial)
        for trial in trials(ruleset, count, seed)
        for property_ in broken_by(trial, ruleset.text.policy)
        if property_ in certain
    ]
    seconds = time.perf_counter() - began
    line = f"{name}: {count} encounters in {seconds:.0f} s; proved: {', '.join(sorted(certain)) or 'nothing'}"
    return "\n".join(
        [line, *(f"    {each[0]} is contradicted by {each[1]}" for each in wrong[:3])]
    ), not wrong


def main() -> int:
    """Run the study."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=1_000_000, help="encounters of all rulesets together")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--budget", type=float, default=60.0, help="for the proofs of one ruleset [s]")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    names = list(load().rulesets)
    share = -(-given.count // len(names))
    work = partial(tried, count=share, budget=given.budget, seed=given.seed)
    sound = True
    with ProcessPoolExecutor(given.processes) as pool:
        for line, well in pool.map(work, names):
            print(line, flush=True)
            sound = sound and well
    return 0 if sound else 1


if __name__ == "__main__":
    sys.exit(main())
