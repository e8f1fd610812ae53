"""Two ships of one ruleset, or of two, and what may be asked about them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final

import z3

from ..tapd.language.motion import dot
from ..tapd.language.polynomial import Polynomial, number, variable
from ..tapd.rules import Domain, RulesetText
from ..tapd.vocabulary import Kind, Scope
from ..tapd.written import WrittenRuleset
from .ladder import Ladder
from .search import A, B, Facts, Goal, Ships, find, suggested
from .solver import NONLINEAR_LIMIT, Answer, Budget, Found, ask_linear, ask_nonlinear
from .symbols import Symbols, Term, View, constants_of

ATTEMPTS: Final = 2  # models whose facts are tried
GLANCE: Final = 0.4  # for a nonlinear question, before ships are looked for [s]
# Own ship at the origin, on course north; the other's velocity by its difference.  Nothing is lost: all
# quantities of motion are the same wherever the two are, and whichever way they look.
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

    `free` leaves parameters with a range open within it; `assume` are further conditions on (A, B) and (B,
    A).
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
        found += bounds_of(self.rulesets[0].text, self.symbols)
        if self.free:
            found += _ranges(self.symbols, self.rulesets[0].text)
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

    def never(self, terms: Sequence[Term]) -> str | None:
        """By which reasoning terms can never hold together, if cheap reasoning shows it."""
        answer = ask_linear(self.symbols, [*terms, *self.domain()], self.budget)
        return answer.method if answer.impossible else None

    def settled(
        self,
        terms: Sequence[Term],
        goal: Goal,
        rulesets: tuple[WrittenRuleset, WrittenRuleset] | None = None,
    ) -> tuple[Found, str, Ships | None]:
        """Decide whether terms can hold together: proved that they cannot, or ships that show that they can.

        The cheap questions come first, and ships are looked for as soon as there are facts to try.  They
        are judged by `rulesets`, if these are not those of the question.
        """
        tried: list[Facts] = []

        def ships(answer: Answer) -> Ships | None:
            facts = suggested(self.rulesets[0].text, answer)
            if facts in tried or self.budget.spent or answer.found is not Found.POSSIBLE:
                return None
            tried.append(facts)
            return find(rulesets or self.rulesets, facts, goal)

        asked = [*terms, *self.domain()]
        answer = ask_linear(self.symbols, asked, self.budget)
        if answer.impossible:
            return Found.IMPOSSIBLE, answer.method, None
        answer = ask_nonlinear(self.symbols, asked, self.budget, GLANCE)
        if answer.impossible:
            return Found.IMPOSSIBLE, answer.method, None
        other = list(self.symbols.known.values())  # facts that are known are tried first
        for _ in range(ATTEMPTS):
            answer = ask_linear(self.symbols, [*asked, *other], self.budget)
            if answer.impossible and self.symbols.known:
                other = other[len(self.symbols.known) :]
                answer = ask_linear(self.symbols, [*asked, *other], self.budget)
            if (found := ships(answer)) is not None:
                return Found.POSSIBLE, answer.method, found
            if not answer.flags:
                break
            other.append(_other_facts(answer))
        for inside in ([], self.motion_domain(self.rulesets[0].text.domain)):
            answer = ask_nonlinear(self.symbols, [*asked, *inside], self.budget, NONLINEAR_LIMIT)
            if answer.impossible:
                return Found.IMPOSSIBLE, answer.method, None
            if (found := ships(answer)) is not None:
                return Found.POSSIBLE, answer.method, found
        why = "no time is left" if self.budget.spent else "possible for the solver, and no ships were found"
        return Found.UNDECIDED, why, None


def bounds_of(text: RulesetText, symbols: Symbols) -> list[Term]:
    """Bounds of numeric facts that some condition looks at."""
    asked = {name for atom in symbols.atoms for name in atom.variables}
    found = []
    for name in sorted(asked):
        owner, _, fact = name.partition(".")
        known = text.vocabulary.find(Scope.SHIP, fact)
        if owner not in (A, B) or known is None or known.kind is not Kind.NUMBER:
            continue
        low, high = text.domain.length if fact == "length" else (0, None)
        found.append(symbols.sign(variable(name) - number(low), frozenset({0, 1})))
        if high is not None:
            found.append(symbols.sign(number(high) - variable(name), frozenset({0, 1})))
    return found


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
