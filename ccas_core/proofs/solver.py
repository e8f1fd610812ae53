"""Questions to the solver: can these conditions hold together?  In stages, the cheap one first.

1. With a variable for each monomial: linear arithmetic, which decides.  What cannot hold here cannot hold
at all. 2. As it is, by `z3.SimpleSolver`: its incremental core is a thousand times faster on such questions
than the strategy that `z3.Solver` would choose.

A model is only a suggestion: a fault is told when ships have been found that show it (`search`).
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from fractions import Fraction
from typing import Final

import z3

from .symbols import Atom, Symbols, Term, atoms_in

LINEAR_LIMIT: Final = 4.0  # for one question [s]
NONLINEAR_LIMIT: Final = 2.0  # likewise
_STOPPED_EARLY: Final = 0.9  # of its time: a solver that gives up before was stopped


class Found(Enum):
    """What came of a question."""

    IMPOSSIBLE = "impossible"
    POSSIBLE = "possible"
    UNDECIDED = "undecided"


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """What came of a question, by which reasoning, and values that would do."""

    found: Found
    method: str
    flags: Mapping[str, bool] = field(default_factory=dict)
    numbers: Mapping[str, Fraction] = field(default_factory=dict)

    @property
    def impossible(self) -> bool:
        """Whether the conditions cannot hold together."""
        return self.found is Found.IMPOSSIBLE


@dataclass(slots=True)
class Budget:
    """Time left for proofs."""

    seconds: float
    _began: float = field(default_factory=time.perf_counter)

    @property
    def left(self) -> float:
        """Time left [s]."""
        return self.seconds - (time.perf_counter() - self._began)

    @property
    def spent(self) -> bool:
        """Whether none is left."""
        return self.left <= 0.0


LINEAR: Final = "linear reasoning"
NONLINEAR: Final = "nonlinear reasoning"
_INTERRUPTED: Final = ("canceled", "interrupted from keyboard")
_RANDOM_PHASES: Final = 5  # the solver's name for them
OUT_OF_TIME: Final = Answer(found=Found.UNDECIDED, method="no time is left")


def ask_linear(symbols: Symbols, terms: Sequence[Term], budget: Budget, variant: int = 0) -> Answer:
    """Ask whether terms can hold together, with a variable for each monomial; "possible" may be wrong.

    Another `variant` may come to another model.
    """
    if budget.spent:
        return OUT_OF_TIME
    atoms = atoms_in(symbols, terms)
    return _asked(
        [*symbols.axioms(terms), *terms, *symbols.linear(atoms), *_squares(atoms)],
        budget,
        LINEAR_LIMIT,
        LINEAR,
        variant,
    )


def ask_nonlinear(symbols: Symbols, terms: Sequence[Term], budget: Budget, limit: float) -> Answer:
    """Ask whether terms can hold together, as they are."""
    if budget.spent:
        return OUT_OF_TIME
    meaning = symbols.nonlinear(atoms_in(symbols, terms))
    return _asked([*symbols.axioms(terms), *terms, *meaning], budget, limit, NONLINEAR)


def _asked(assertions: Sequence[Term], budget: Budget, limit: float, method: str, variant: int = 0) -> Answer:
    solver = _solver(budget, limit)
    if variant:
        solver.set("random_seed", variant)
        solver.set("phase_selection", _RANDOM_PHASES)
    solver.add(*assertions)
    began, most = time.perf_counter(), min(limit, budget.left)
    try:
        outcome = solver.check()
    except z3.Z3Exception as stopped:  # Ctrl-C, if it comes while the question is still made ready
        if any(word in str(stopped) for word in _INTERRUPTED):
            raise KeyboardInterrupt from stopped
        raise
    if outcome == z3.unknown and time.perf_counter() - began < _STOPPED_EARLY * most:
        _raise_if_interrupted(solver)
    if outcome == z3.unsat:
        return Answer(found=Found.IMPOSSIBLE, method=method)
    if outcome == z3.sat:
        flags, numbers = _values(solver.model())
        return Answer(found=Found.POSSIBLE, method=method, flags=flags, numbers=numbers)
    return Answer(found=Found.UNDECIDED, method=f"{method} found no end")


def _raise_if_interrupted(solver: z3.Solver) -> None:
    """The solver takes Ctrl-C for itself, and calls it as it calls the end of its time."""
    if solver.reason_unknown() in _INTERRUPTED:
        raise KeyboardInterrupt


def _solver(budget: Budget, limit: float) -> z3.Solver:
    solver = z3.SimpleSolver()
    solver.set("timeout", max(1, int(1000.0 * min(limit, budget.left))))
    solver.set("random_seed", 0)
    return solver


def _squares(atoms: Sequence[Atom]) -> list[Term]:
    """No square is negative: what the linear stage would not know."""
    found: dict[str, None] = {}
    for atom in atoms:
        for monomial, _ in atom.polynomial.terms:
            if len(monomial) % 2 == 0 and all(
                a == b for a, b in zip(monomial[::2], monomial[1::2], strict=True)
            ):
                found["*".join(monomial)] = None
    return [z3.Real(name) >= 0 for name in found if name]


def _values(model: z3.ModelRef) -> tuple[dict[str, bool], dict[str, Fraction]]:
    flags: dict[str, bool] = {}
    numbers: dict[str, Fraction] = {}
    for declared in model.decls():
        value = model[declared]
        if z3.is_bool(value):
            flags[declared.name()] = z3.is_true(value)
        elif z3.is_rational_value(value):
            numbers[declared.name()] = Fraction(value.numerator_as_long(), value.denominator_as_long())
        elif z3.is_algebraic_value(value):
            near = value.approx(20)
            numbers[declared.name()] = Fraction(near.numerator_as_long(), near.denominator_as_long())
    return flags, numbers
