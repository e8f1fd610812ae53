"""Two ships of one ruleset, or of two, and what may be asked about them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Final

import numpy as np
import z3

from ..tapd.case_run import PARALLEL
from ..tapd.facts import velocity as velocity_of
from ..tapd.language.motion import dot
from ..tapd.language.polynomial import Polynomial, number, variable
from ..tapd.rules import Domain, RulesetText
from ..tapd.vocabulary import Scope
from ..tapd.written import WrittenRuleset
from ..units import DEGREE
from .claims import bounded_below
from .ladder import Ladder
from .search import (
    ENOUGH,
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
from .solver import NONLINEAR_LIMIT, Answer, Budget, Found, ask_linear, ask_nonlinear
from .symbols import Symbols, Term, View, constants_of

ATTEMPTS: Final = 3  # models whose facts are tried
VELOCITIES: Final = 18  # pairs of velocities for which places are asked for
PLACING_LIMIT: Final = 0.5  # for one of them [s]
NEVER: Final = 10**9  # stands for a time that does not come [s]
# Own ship at the origin, on course north; the other's velocity by its difference.  Nothing is lost: all quantities of
# motion are the same wherever the two are, and whichever way they look.
FRAME: Final[Mapping[str, Polynomial]] = {
    "A.x": number(0),
    "A.y": number(0),
    "A.vy": number(0),
    "B.vx": variable("A.vx") + variable("w.x"),
    "B.vy": variable("w.y"),
}


@dataclass(eq=False)
class Questions:
    """Two ships A and B, each with its ruleset.

    `free` leaves parameters with a range open within it; `assume` are further conditions on (A, B) and (B, A).
    """

    rulesets: tuple[WrittenRuleset, WrittenRuleset]
    budget: Budget
    free: bool = False
    symbols: Symbols = field(default_factory=lambda: Symbols(fixed=dict(FRAME)))

    @cached_property
    def own(self) -> Ladder:
        """The ladder of A's ruleset, as A sees it."""
        return Ladder(self._view(0))

    @cached_property
    def other(self) -> Ladder:
        """The ladder of B's ruleset, as B sees it."""
        if self.rulesets[0] is self.rulesets[1]:
            return Ladder(self.own.view.swapped)
        return Ladder(self._view(1).swapped)

    def _view(self, which: int) -> View:
        text = self.rulesets[which].text
        return View(self.symbols, text, A, B, constants_of(text, free=self.free))

    def domain(self) -> list[Term]:
        """What holds of the ships for which the rulesets are meant."""
        found = [self.symbols.sign(variable("A.vx"), frozenset({0, 1}))]
        for ladder, ruleset in ((self.own, self.rulesets[0]), (self.other, self.rulesets[1])):
            domain = ruleset.text.domain
            found += [view.term(f) for view in (ladder.view, ladder.view.swapped) for f in domain.assume]
        found += self._numbers(self.rulesets[0].text)
        if self.free:
            found += _ranges(self.symbols, self.rulesets[0].text)
        return found

    def _numbers(self, text: RulesetText) -> list[Term]:
        """Bounds of numeric facts that some condition looks at."""
        asked = {name for atom in self.symbols.atoms for name in atom.variables}
        found = []
        for name in sorted(asked):
            owner, _, fact = name.partition(".")
            known = text.vocabulary.find(Scope.SHIP, fact)
            if owner not in (A, B) or known is None or not bounded_below(known):
                continue
            low, high = text.domain.length if fact == "length" else (0, None)
            found.append(self.symbols.sign(variable(name) - number(low), frozenset({0, 1})))
            if high is not None:
                found.append(self.symbols.sign(number(high) - variable(name), frozenset({0, 1})))
        return found

    def motion_domain(self, domain: Domain) -> list[Term]:
        """Bounds of speed and distance: for a question that is possible only outside of them."""
        low, high = (number(each * each) for each in domain.speed)
        velocities = [
            (variable("A.vx"), number(0)),
            (variable("A.vx") + variable("w.x"), variable("w.y")),
        ]
        found = []
        for velocity in velocities:
            square = dot(velocity, velocity)
            found.append(self.symbols.sign(square - low, frozenset({0, 1})))
            found.append(self.symbols.sign(high - square, frozenset({0, 1})))
        place = (variable("B.x"), variable("B.y"))
        apart = dot(place, place) - number(domain.separation * domain.separation)
        return [*found, self.symbols.sign(apart, frozenset({0, 1}))]

    def settled(
        self,
        terms: Sequence[Term],
        goal: Goal,
        rulesets: tuple[WrittenRuleset, WrittenRuleset] | None = None,
        enough: int = ENOUGH,
    ) -> tuple[Found, str, Ships | None]:
        """Decide whether terms can hold together: proved that they cannot, or ships that show that they can.

        The cheap questions come first, and ships are looked for as soon as there are facts to try.  They are judged by
        `rulesets`, if these are not those of the question; `enough` as in `search.find`.
        """
        asked = [*terms, *self.domain()]
        search = _Search(self, goal, rulesets or self.rulesets, enough)
        other: list[Term] = []
        for _ in range(ATTEMPTS):
            answer = ask_linear(self.symbols, [*asked, *other], self.budget)
            if answer.impossible and not other:
                return Found.IMPOSSIBLE, answer.method, None
            if (found := search.ships(answer)) is not None:
                return Found.POSSIBLE, answer.method, found
            if not answer.flags:
                break
            other.append(_other_facts(answer))
            if len(other) == 1:
                answer = ask_nonlinear(self.symbols, asked, self.budget, NONLINEAR_LIMIT)
                if answer.impossible:
                    return Found.IMPOSSIBLE, answer.method, None
                if (found := search.ships(answer)) is not None:
                    return Found.POSSIBLE, answer.method, found
        inside = [*asked, *self.motion_domain(self.rulesets[0].text.domain)]
        answer = ask_nonlinear(self.symbols, inside, self.budget, NONLINEAR_LIMIT)
        if answer.impossible:
            return Found.IMPOSSIBLE, answer.method, None
        found = search.ships(answer) or search.with_velocities(inside) or search.of_tests()
        if found is not None:
            return Found.POSSIBLE, answer.method, found
        why = "no time is left" if self.budget.spent else "possible for the solver, and no ships were found"
        return Found.UNDECIDED, why, None


@dataclass(slots=True)
class _Search:
    """Looks for ships that show what the solver takes for possible."""

    questions: Questions
    goal: Goal
    rulesets: tuple[WrittenRuleset, WrittenRuleset]
    enough: int
    tried: list[Facts] = field(default_factory=list)

    def ships(self, answer: Answer) -> Ships | None:
        """Ships with the facts of a model: where it has them, and elsewhere."""
        if self.questions.budget.spent or answer.found is not Found.POSSIBLE:
            return None
        atoms = self.questions.symbols.atoms
        facts = suggested(self.questions.rulesets[0].text, answer, atoms=atoms)
        rulesets = self._with_parameters(answer)
        here = [case_of(facts, places) for places in placed(answer, rulesets[0].text.domain)]
        found = widest(rulesets, here, self.goal, self.enough)
        if found is None and facts not in self.tried:
            self.tried.append(facts)
            speeds = telling_speeds(atoms, rulesets[0].text.domain)
            found = find(rulesets, facts, self.goal, enough=self.enough, wanted=speeds)
        return found

    def with_velocities(self, terms: Sequence[Term]) -> Ships | None:
        """Ships with round velocities, placed by the solver: their motion is then linear, or nearly so."""
        questions = self.questions
        domain = questions.rulesets[0].text.domain
        speeds = (float(domain.speed[0]), float(domain.speed[1]))
        wanted = telling_speeds(questions.symbols.atoms, domain)
        for places in meetings(np.random.default_rng(1), speeds, 1.0, VELOCITIES, wanted):
            (_, _, course, own), (_, _, towards, other) = places[A], places[B]
            fixed = _velocities((towards - course) * DEGREE, own, other)
            answer = ask_nonlinear(questions.symbols, [*terms, *fixed], questions.budget, PLACING_LIMIT)
            if (found := self.ships(answer)) is not None:
                return found
        return None

    def of_tests(self) -> Ships | None:
        """Ships of the ruleset's own tests, whose encounter may be one that only a chart could show."""
        tests = (case for case in self.rulesets[0].text.tests if {ship.id for ship in case.ships} == {A, B})
        return widest(self.rulesets, tests, self.goal, enough=1)

    def _with_parameters(self, answer: Answer) -> tuple[WrittenRuleset, WrittenRuleset]:
        """The rulesets with the values that a model gives to their parameters."""
        if not self.questions.free:
            return self.rulesets
        values = {name.removeprefix("parameter."): v for name, v in answer.numbers.items() if "*" not in name}
        return (_with_values(self.rulesets[0], values), _with_values(self.rulesets[1], values))


def _with_values(ruleset: WrittenRuleset, values: Mapping[str, Fraction]) -> WrittenRuleset:
    known = ruleset.text.parameters
    changed = {
        name: replace(each, value=values[name])
        for name, each in known.items()
        if name in values and each.low <= values[name] <= each.high
    }
    return ruleset.with_text(replace(ruleset.text, parameters={**known, **changed}))


def _velocities(turn: float, own: float, other: float) -> list[Term]:
    """That A sails north and B on a course [rad], and when they reach the line on which the other sails."""
    north, east = velocity_of(turn, other)
    wx, wy = z3.Real("w.x"), z3.Real("w.y")
    fixed = [z3.Real("A.vx") == _exact(own), wx == _exact(north - own), wy == _exact(east)]
    bx, by = z3.Real("B.x"), z3.Real("B.y")
    times = z3.Real(f"{A}.time_to_intersection"), z3.Real(f"{B}.time_to_intersection")
    across = own * east
    if abs(math.sin(turn)) < PARALLEL:
        return [*fixed, times[0] == NEVER, times[1] == NEVER]
    sight = bx * _exact(east) - by * _exact(north), -_exact(own) * by
    return [*fixed, *(t * _exact(across) == s for t, s in zip(times, sight, strict=True))]


def _exact(value: float) -> Term:
    return z3.RatVal(*value.as_integer_ratio())


def _other_facts(answer: Answer) -> Term:
    """That some fact is not as in an answer."""
    facts = {
        name: value for name, value in answer.flags.items() if "." in name and not name.startswith("known(")
    }
    return z3.Or([z3.Bool(name) != value for name, value in sorted(facts.items())] or [z3.BoolVal(False)])  # noqa: FBT003


def _ranges(symbols: Symbols, text: RulesetText) -> list[Term]:
    """Ranges of parameters, and of the tangents of limits that depend on them."""
    from ..tapd.language.motion import tangent

    found = []
    for name, parameter in text.parameters.items():
        if parameter.low < parameter.high:
            here = variable(f"parameter.{name}")
            found.append(symbols.sign(here - number(parameter.low), frozenset({0, 1})))
            found.append(symbols.sign(number(parameter.high) - here, frozenset({0, 1})))
    for name, degrees in text.tangents.items():
        ends = []
        for end in ("low", "high"):
            values = {f"parameter.{n}": number(getattr(p, end)) for n, p in text.parameters.items()}
            value = degrees.with_values(values).constant
            ends.append(tangent(value) if value is not None and 0 < value < 90 else None)
        if None not in ends:
            low, high = sorted(each for each in ends if each is not None)
            found.append(symbols.sign(variable(name) - number(low), frozenset({0, 1})))
            found.append(symbols.sign(number(high) - variable(name), frozenset({0, 1})))
    return found
