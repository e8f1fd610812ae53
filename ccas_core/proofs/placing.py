"""Ships for what the solver takes for possible: from its model, from round numbers, and placed by it.

A model of the linear stage gives facts; where the ships are is then tried (`search`).  A model of the
nonlinear stage gives places, too.  Where neither reaches the goal, say in a narrow window between two limits,
round velocities are given, and the solver is asked for places alone: motion is then linear, or nearly so.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Final

import numpy as np
import z3

from ..tapd.case_run import PARALLEL
from ..tapd.facts import velocity
from ..tapd.written import WrittenRuleset
from ..units import DEGREE
from .search import (
    A,
    B,
    Facts,
    Goal,
    Ships,
    case_of,
    find,
    meetings,
    placed,
    suggested,
    telling_speeds,
    widest,
)
from .solver import Answer, Budget, Found, ask_nonlinear
from .symbols import Symbols, Term

AT_LENGTH: Final = 15_000  # tries, where a few have shown nothing and the solver says nothing
VELOCITIES: Final = 18  # pairs of velocities for which places are asked for
PLACING_LIMIT: Final = 0.5  # for one of them [s]
PLACING: Final = 4.0  # for all of them [s]
NEVER: Final = 10**9  # stands for a time that does not come [s]


@dataclass(slots=True)
class Placing:
    """Looks for ships that reach a goal; `free` says that parameters are those of the model."""

    symbols: Symbols
    budget: Budget
    rulesets: tuple[WrittenRuleset, WrittenRuleset]
    goal: Goal
    enough: int
    free: bool
    tried: list[Facts] = field(default_factory=list)

    def ships(self, answer: Answer) -> Ships | None:
        """Ships with the facts of a model: where it has them, and elsewhere."""
        if self.budget.spent or answer.found is not Found.POSSIBLE:
            return None
        text = self.rulesets[0].text
        facts = suggested(text, answer, atoms=self.symbols.atoms)
        rulesets = self._with_parameters(answer)
        wanted = telling_speeds(self.symbols.atoms, text.domain)
        for stated in self._as_seen(facts):
            here = [case_of(stated, places) for places in placed(answer, text.domain)]
            found = widest(rulesets, here, self.goal, self.enough)
            if found is None and stated not in self.tried:
                self.tried.append(stated)
                found = find(rulesets, stated, self.goal, enough=self.enough, wanted=wanted)
            if found is not None:
                return found
        return None

    def _as_seen(self, facts: Facts) -> Iterator[Facts]:
        """Facts as courses alone show them; and on a chart with a junction, if times to one are asked for."""
        yield facts
        if facts.times:
            yield facts.at_a_junction()

    def at_length(self) -> Ships | None:
        """Ships with facts that have been tried before, by many more tries."""
        wanted = telling_speeds(self.symbols.atoms, self.rulesets[0].text.domain)
        for stated in self.tried:
            if self.budget.spent:
                return None
            found = find(
                self.rulesets, stated, self.goal, 1, AT_LENGTH // len(self.tried), self.enough, wanted
            )
            if found is not None:
                return found
        return None

    def with_velocities(self, terms: Sequence[Term]) -> Ships | None:
        """Ships with round velocities, placed by the solver."""
        domain = self.rulesets[0].text.domain
        speeds = (float(domain.speed[0]), float(domain.speed[1]))
        wanted = telling_speeds(self.symbols.atoms, domain)
        budget = Budget(min(PLACING, self.budget.left))
        for places in meetings(np.random.default_rng(1), speeds, 1.0, VELOCITIES, wanted):
            (_, _, course, own), (_, _, towards, other) = places[A], places[B]
            fixed = _velocities((towards - course) * DEGREE, own, other)
            answer = ask_nonlinear(self.symbols, [*terms, *fixed], budget, PLACING_LIMIT)
            if (found := self.ships(answer)) is not None:
                return found
        return None

    def _with_parameters(self, answer: Answer) -> tuple[WrittenRuleset, WrittenRuleset]:
        if not self.free:
            return self.rulesets
        values = {n.removeprefix("parameter."): v for n, v in answer.numbers.items() if "*" not in n}
        return _with_values(self.rulesets[0], values), _with_values(self.rulesets[1], values)


def _with_values(ruleset: WrittenRuleset, values: Mapping[str, Fraction]) -> WrittenRuleset:
    """The same ruleset with other values of parameters, within their ranges."""
    known = ruleset.text.parameters
    changed = {
        name: replace(each, value=values[name])
        for name, each in known.items()
        if name in values and each.low <= values[name] <= each.high
    }
    return ruleset.with_text(replace(ruleset.text, parameters={**known, **changed}))


def _velocities(turn: float, own: float, other: float) -> list[Term]:
    """That A sails north and B on a course [rad], and when each reaches the line on which the other sails."""
    north, east = velocity(turn, other)
    fixed = [
        z3.Real("A.vx") == _exact(own),
        z3.Real("w.x") == _exact(north - own),
        z3.Real("w.y") == _exact(east),
    ]
    times = z3.Real(f"{A}.time_to_intersection"), z3.Real(f"{B}.time_to_intersection")
    if abs(math.sin(turn)) < PARALLEL:
        return [*fixed, times[0] == NEVER, times[1] == NEVER]
    bx, by = z3.Real("B.x"), z3.Real("B.y")
    sight = bx * _exact(east) - by * _exact(north), -_exact(own) * by
    return [*fixed, *(t * _exact(own * east) == s for t, s in zip(times, sight, strict=True))]


def _exact(value: float) -> Term:
    return z3.RatVal(*value.as_integer_ratio())
