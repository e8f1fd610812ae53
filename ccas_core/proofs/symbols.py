"""Formulas as terms of the solver, for any two ships of a group.

A numeric condition is the sign of a polynomial.  It enters as two proxies, `positive` and `negative`,
shared by all conditions that ask for the sign of the same polynomial, whichever ship asks.  What the
proxies mean is added when a question is asked, in one of two ways: with a variable for each monomial, so
that the solver has linear arithmetic only; or as it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from fractions import Fraction
from functools import reduce
from typing import Any, Final, TypeAlias

import z3

from ..tapd.language.code import MOTION
from ..tapd.language.formula import (
    NEGATIVE,
    POSITIVE,
    ZERO,
    And,
    Before,
    Constant,
    Formula,
    Known,
    Named,
    Not,
    Or,
    Same,
    Sign,
    Test,
)
from ..tapd.language.polynomial import Monomial, Polynomial, canonical, number, variable
from ..tapd.rules import Recognition, RulesetText
from ..tapd.vocabulary import Kind, Scope

Term: TypeAlias = Any  # of the solver; its package has no types
_DERIVED: Final = frozenset({"geometry", "overtaker", "has_other_on_starboard", "risk_of_collision"})


@dataclass(frozen=True, slots=True)
class Atom:
    """A polynomial whose sign is asked for, in the variables of a group of ships, and its two proxies."""

    polynomial: Polynomial
    positive: Term
    negative: Term


@dataclass(slots=True)
class Symbols:
    """All variables of a question: facts of ships by name, of their waters, and motion.

    Variables of polynomials: `A.x`, `A.y`, `A.vx`, `A.vy`, numeric facts such as `A.length`, and parameters.
    """

    atoms: dict[Polynomial, Atom] = field(default_factory=dict)
    flags: dict[str, Term] = field(
        default_factory=dict
    )  # "A.ferry", "A.propulsion=sail", "waterway.regime=x"
    choices: dict[str, tuple[str, ...]] = field(default_factory=dict)  # facts with words, and their words
    known: dict[str, Term] = field(
        default_factory=dict
    )  # facts of which a condition asks whether they are known
    fixed: dict[str, Polynomial] = field(default_factory=dict)  # values put in the place of variables
    _names: dict[int, tuple[Term, frozenset[str]]] = field(default_factory=dict)  # of terms, kept with them
    _linear: dict[Polynomial, tuple[Term, Term]] = field(default_factory=dict)

    def flag(self, name: str) -> Term:
        """A fact that is true or false."""
        if name not in self.flags:
            self.flags[name] = z3.Bool(name)
        return self.flags[name]

    def choice(self, fact: str, value: str, words: tuple[str, ...]) -> Term:
        """That a fact has a value."""
        self.choices[fact] = words
        for word in words:
            self.flag(f"{fact}={word}")
        return self.flag(f"{fact}={value}")

    def sign(self, polynomial: Polynomial, signs: frozenset[int]) -> Term:
        """That a polynomial has one of some signs."""
        polynomial = polynomial.with_values(self.fixed)
        value = polynomial.constant
        if value is not None:
            return z3.BoolVal((value > 0) - (value < 0) in signs)
        scaled, turned = canonical(polynomial)
        if scaled not in self.atoms:
            name = f"p{len(self.atoms)}"
            self.atoms[scaled] = Atom(scaled, z3.Bool(f"{name}>0"), z3.Bool(f"{name}<0"))
        atom = self.atoms[scaled]
        if turned < 0:
            signs = frozenset(-each for each in signs)
        terms = {POSITIVE: atom.positive, NEGATIVE: atom.negative}
        if signs == {ZERO}:
            return z3.And(z3.Not(atom.positive), z3.Not(atom.negative))
        if signs == {POSITIVE, NEGATIVE}:
            return z3.Or(atom.positive, atom.negative)
        if ZERO in signs:
            (other,) = {POSITIVE, NEGATIVE} - signs
            return z3.Not(terms[other])
        (only,) = signs
        return terms[only]

    def axioms(self, terms: Iterable[Term]) -> list[Term]:
        """What holds of the facts in some terms: one value each, where known; no polynomial has two signs."""
        names = self.names(terms)
        found = [z3.Not(z3.And(atom.positive, atom.negative)) for atom in self.atoms_of(names)]
        for fact, words in self.choices.items():
            if not any(f"{fact}={word}" in names for word in words) and f"known({fact})" not in names:
                continue
            values = [self.flag(f"{fact}={word}") for word in words]
            one = z3.PbEq([(value, 1) for value in values], 1)
            if fact in self.known:
                found += [
                    z3.Implies(self.known[fact], one),
                    z3.Implies(z3.Not(self.known[fact]), z3.Not(z3.Or(values))),
                ]
            else:
                found.append(one)
        return found

    def names(self, terms: Iterable[Term]) -> set[str]:
        """Names of all variables in some terms."""
        return {name for term in terms for name in self._names_in(term)}

    def _names_in(self, term: Term) -> frozenset[str]:
        key = term.get_id()
        if key not in self._names:
            children = term.children()
            found = {name for child in children for name in self._names_in(child)}
            self._names[key] = term, frozenset(found or {term.decl().name()})
        return self._names[key][1]

    def atoms_of(self, names: AbstractSet[str]) -> list[Atom]:
        """Atoms of which a proxy is among some names."""
        return [
            each
            for each in self.atoms.values()
            if each.positive.decl().name() in names or each.negative.decl().name() in names
        ]

    def linear(self, atoms: Iterable[Atom]) -> list[Term]:
        """What the proxies mean, with a variable for each monomial: true of all ships, and of more."""
        found: list[Term] = []
        for atom in atoms:
            if atom.polynomial not in self._linear:
                self._linear[atom.polynomial] = _meaning(atom, _linear_term(atom.polynomial))
            found += self._linear[atom.polynomial]
        return found

    def nonlinear(self, atoms: Iterable[Atom]) -> list[Term]:
        """What the proxies mean, as it is."""
        return [part for atom in atoms for part in _meaning(atom, real_term(atom.polynomial))]


def _meaning(atom: Atom, value: Term) -> tuple[Term, Term]:
    return atom.positive == (value > 0), atom.negative == (value < 0)


def _rational(value: Fraction) -> Term:
    return z3.RatVal(value.numerator, value.denominator)


def _linear_term(polynomial: Polynomial) -> Term:
    return z3.Sum([_rational(f) * _monomial(m) if m else _rational(f) for m, f in polynomial.terms])


def _monomial(monomial: Monomial) -> Term:
    return z3.Real("*".join(monomial))


def real_term(polynomial: Polynomial) -> Term:
    """A polynomial as a term."""
    products = [
        reduce(lambda a, b: a * b, (z3.Real(name) for name in monomial), _rational(factor))
        for monomial, factor in polynomial.terms
    ]
    return z3.Sum(products)


@dataclass(slots=True)
class View:
    """Conditions of a ruleset as `own` asks them about `other`."""

    symbols: Symbols
    text: RulesetText
    own: str
    other: str
    constants: Mapping[str, Polynomial]  # of parameters that have their values; others are variables
    remembered: bool = False  # what is recognised of the encounter is that of its beginning, whatever it was
    later: Polynomial | None = None  # time that has passed, at constant velocities [s]
    _terms: dict[int, tuple[Formula, Term]] = field(default_factory=dict)
    _derived: dict[tuple[str, str | bool], Term] = field(default_factory=dict)
    _swapped: View | None = None
    _variables: dict[str, Polynomial] = field(default_factory=dict)

    @property
    def swapped(self) -> View:
        """The same as `other` asks about `own`."""
        if self._swapped is None:
            self._swapped = View(
                self.symbols, self.text, self.other, self.own, self.constants, self.remembered, self.later
            )
            self._swapped._swapped = self  # noqa: SLF001 - it is another of this class
        return self._swapped

    def term(self, formula: Formula) -> Term:
        """A condition."""
        key = id(formula)
        if key not in self._terms:
            self._terms[key] = formula, self._made(formula)
        return self._terms[key][1]

    def _made(self, formula: Formula) -> Term:
        match formula:
            case Constant():
                return z3.BoolVal(formula.value)
            case Not():
                return z3.Not(self.term(formula.part))
            case And():
                return z3.And([self.term(part) for part in formula.parts])
            case Or():
                return z3.Or([self.term(part) for part in formula.parts])
            case Named():
                return self.term(formula.part)
            case Sign():
                return self.symbols.sign(self._polynomial(formula.polynomial), formula.signs)
            case Before():
                return self._before(formula)
            case Same():
                words = self._words(formula.one)
                return z3.Or(
                    [z3.And(self._test(formula.one, w), self._test(formula.other, w)) for w in words]
                )
            case Known():
                return self._known(formula.fact)
            case Test():
                if formula.fact in _DERIVED:
                    return self.derived(formula.fact, formula.value)
                return self._test(formula.fact, formula.value)

    def _name(self, fact: str) -> str:
        head, dot, tail = fact.partition(".")
        if dot and head in ("own", "other"):
            return f"{self.own if head == 'own' else self.other}.{tail}"
        if head == "waterway":
            return fact
        first, second = sorted((self.own, self.other))
        return f"{first}-{second}.{fact}"

    def _words(self, fact: str) -> tuple[str, ...]:
        head, dot, tail = fact.partition(".")
        scope = Scope.WATERWAY if head == "waterway" else Scope.SHIP if dot else Scope.PAIR
        found = self.text.vocabulary.find(scope, tail or fact)
        return found.choices if found else ()

    def _test(self, fact: str, value: bool | str) -> Term:
        name = self._name(fact)
        if isinstance(value, bool):
            return self.symbols.flag(name)
        words = self._words(fact)
        return self.symbols.choice(name, value, words) if words else self.symbols.flag(f"{name}={value}")

    def _known(self, fact: str) -> Term:
        name = self._name(fact)
        if name not in self.symbols.known:
            self.symbols.known[name] = z3.Bool(f"known({name})")
            if words := self._words(fact):
                self.symbols.choice(name, words[0], words)
        return self.symbols.known[name]

    def _before(self, before: Before) -> Term:
        one = variable(self._name(before.one))
        other = before.other
        limit = variable(self._name(other)) if isinstance(other, str) else self._polynomial(other)
        signs = frozenset({NEGATIVE}) if before.strict else frozenset({NEGATIVE, ZERO})
        return self.symbols.sign(one - limit, signs)

    def _polynomial(self, polynomial: Polynomial) -> Polynomial:
        """A polynomial of a pair, in the variables of the group."""
        if not self._variables:
            a, b = self.own, self.other
            place = {
                name: variable(name) for s in (a, b) for name in (f"{s}.x", f"{s}.y", f"{s}.vx", f"{s}.vy")
            }
            self._variables.update(
                {
                    "rx": place[f"{b}.x"] - place[f"{a}.x"],
                    "ry": place[f"{b}.y"] - place[f"{a}.y"],
                    "wx": place[f"{b}.vx"] - place[f"{a}.vx"],
                    "wy": place[f"{b}.vy"] - place[f"{a}.vy"],
                    "ovx": place[f"{a}.vx"],
                    "ovy": place[f"{a}.vy"],
                    "tvx": place[f"{b}.vx"],
                    "tvy": place[f"{b}.vy"],
                }
            )
            if self.later is not None:
                self._variables["rx"] += self.later * self._variables["wx"]
                self._variables["ry"] += self.later * self._variables["wy"]
        for name in polynomial.variables - self._variables.keys() - self.constants.keys():
            if name not in MOTION[:8] and not name.startswith(("parameter.", "tangent(")):
                self._variables[name] = variable(self._name(name))
        return polynomial.with_values({**self._variables, **self.constants})

    # -- recognition -----------------------------------------------------------------------------

    def derived(self, name: str, value: bool | str) -> Term:
        """A fact of the pair that the ruleset recognises."""
        key = name, value
        if key not in self._derived:
            self._derived[key] = self._recognised(name, value)
        return self._derived[key]

    def _recognised(self, name: str, value: bool | str) -> Term:
        if self.remembered:
            return self._held(name, value)
        found = self.text.recognition
        if found is None:
            return z3.BoolVal(value == "none")
        if name == "risk_of_collision":
            return self.term(found.risk)
        if name == "geometry":
            return self._geometry(found, str(value))
        here, there = (
            (self.term(found.overtaking), self.swapped.term(found.overtaking))
            if name == "overtaker"
            else (self.term(found.from_starboard), self.swapped.term(found.from_starboard))
        )
        by_value = {"own": here, "other": z3.And(z3.Not(here), there), "none": z3.Not(z3.Or(here, there))}
        return by_value[str(value)]

    def _held(self, name: str, value: bool | str) -> Term:
        """A fact of the pair as it is remembered: the same for both ships."""
        fact = self._name(name)
        if isinstance(value, bool):
            return self.symbols.flag(fact)
        words = self._words(name)
        named = {"own": self.own, "other": self.other}
        return self.symbols.choice(
            fact, named.get(value, value), tuple(named.get(word, word) for word in words)
        )

    def _geometry(self, found: Recognition, value: str) -> Term:
        overtaking = z3.Or(self.term(found.overtaking), self.swapped.term(found.overtaking))
        head_on, crossing = self.term(found.head_on), self.term(found.crossing)
        rest = z3.Not(overtaking)
        by_value = {
            "overtaking": overtaking,
            "head_on": z3.And(rest, head_on),
            "crossing": z3.And(rest, z3.Not(head_on), crossing),
            "none": z3.And(rest, z3.Not(head_on), z3.Not(crossing)),
        }
        return by_value[value]


def constants_of(text: RulesetText, *, free: bool) -> Mapping[str, Polynomial]:
    """Values of parameters; with `free`, only of those that have no range."""
    values = text.constants
    if not free:
        return values
    ranged = {f"parameter.{name}" for name, each in text.parameters.items() if each.low < each.high}
    bound = {
        name
        for name, degrees in text.tangents.items()
        if any(variable_ in ranged for variable_ in degrees.variables)
    }
    return {name: value for name, value in values.items() if name not in ranged | bound}


def kinds(text: RulesetText) -> Mapping[str, Kind]:
    """Kinds of all facts of ships, by name."""
    return {fact.name: fact.kind for fact in text.vocabulary.by_scope[Scope.SHIP]}


def atoms_in(symbols: Symbols, terms: Iterable[Term]) -> list[Atom]:
    """Atoms whose proxies occur in some terms."""
    return symbols.atoms_of(symbols.names(terms))


def at(value: Fraction | int) -> Polynomial:
    """A constant."""
    return number(value)
