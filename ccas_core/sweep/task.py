"""What a worker does: sail one case.  Each process makes its rulesets and its solver once."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from .. import plugins
from ..dmpc.solvers import AbstractLocalSolver, make_solver
from ..tapd.ruleset import AbstractRuleset
from .case import Case, sail, scenario


@lru_cache(maxsize=1)
def rulesets() -> Mapping[str, AbstractRuleset]:
    """Rulesets of all plugins."""
    return plugins.load().rulesets


@lru_cache(maxsize=4)
def solver(name: str) -> AbstractLocalSolver:
    """Solver by its name."""
    return make_solver(name)


def sail_case(case: Case) -> dict[str, Any]:
    """Sail a case, and return what is kept of it."""
    found = rulesets()
    _, kept = sail(scenario(case, found), found, solver(case.solver))
    return kept
