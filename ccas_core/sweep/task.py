"""What a worker does: sail one case.  Each process makes its rulesets and its solver once.

A worker that has other sources than the one who sent the case refuses it, wherever it runs: results of two
programs are not mixed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from .. import plugins
from ..dmpc.solvers import AbstractLocalSolver, make_solver
from ..tapd.ruleset import AbstractRuleset
from .case import Case, sail, scenario
from .journal import code_digest


@dataclass(frozen=True, slots=True)
class Program:
    """Which program sails: the plugins it may load (None: all), and a digest of its sources and rules."""

    only: frozenset[str] | None
    code: str


def program(only: frozenset[str] | None = None) -> Program:
    """The program of this process.

    >>> program() == program()
    True
    """
    return Program(only, _code(only))


@lru_cache(maxsize=4)
def _plugins(only: frozenset[str] | None) -> plugins.Plugins:
    return plugins.load(only=only)


@lru_cache(maxsize=4)
def _code(only: frozenset[str] | None) -> str:
    modules = (module.partition(".")[0] for module in _plugins(only).loaded.values())
    return code_digest({"ccas_core", *modules})


def rulesets(sent_by: Program) -> Mapping[str, AbstractRuleset]:
    """Rulesets of the program that sent a case.

    Raises
    ------
    RuntimeError
        If the program of this process is another one.
    """
    if _code(sent_by.only) != sent_by.code:
        raise RuntimeError("this worker has other sources or plugins than the sweep; install the same there")
    return _plugins(sent_by.only).rulesets


@lru_cache(maxsize=4)
def solver(name: str) -> AbstractLocalSolver:
    """Solver by its name."""
    return make_solver(name)


def sail_case(case: Case, sent_by: Program) -> dict[str, Any]:
    """Sail a case, and return what is kept of it."""
    found = rulesets(sent_by)
    _, kept = sail(scenario(case, found), found, solver(case.solver))
    return kept
