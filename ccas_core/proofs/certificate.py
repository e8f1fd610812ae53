"""Certificates made: why statements about a ruleset are impossible, for anybody to verify by arithmetic.

The solver proposes facts and signs that would fulfil a statement.  Linear arithmetic over monomials refutes
the signs, or nonlinear arithmetic does; the least part of them that it takes becomes a lemma, whose factors
come from a small linear system (`certificate_check` says what they mean).  When no more is proposed, the
statement is impossible.  What takes products of more than two signs has no certificate.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any, Final

import z3

from ..tapd.language.polynomial import Monomial, Polynomial
from ..tapd.written import WrittenRuleset
from .certificate_check import RELATIONS, SCHEMA, Covered, Lemma, Part, clause_of, digest, verify
from .clauses import Coding
from .solver import Budget
from .statements import TRUE_NODE, Statement, Statements

MOST_ROUNDS: Final = 400  # of proposals for one statement
BUDGET: Final = 60.0  # for a certificate [s]
# Effort for one question to the solver, in its own measure, so that the same is found on every machine.
_EFFORT: Final = 20_000_000
_NONLINEAR: Final = 300_000  # likewise, for a question in nonlinear arithmetic


def write_certificate(
    ruleset: WrittenRuleset, path: str | Path, budget: float = BUDGET
) -> tuple[Covered, ...]:
    """Write the certificate of a ruleset, and verify it; what it covers of each property, and what not."""
    text = certificate(ruleset, budget)
    covered = verify(text, ruleset)
    Path(path).write_text(text, encoding="utf-8")
    return covered


def certificate(ruleset: WrittenRuleset, budget: float = BUDGET) -> str:
    """The certificate of a ruleset, as JSON."""
    text = ruleset.text
    statements = Statements(text)
    maker = _Maker(statements, Budget(budget))
    told = [found for each in statements.all if (found := maker.proof(each)) is not None]
    used = sorted({n for each in told for n in each["lemmas"]})
    places = {n: place for place, n in enumerate(used)}
    for each in told:
        each["lemmas"] = [places[n] for n in each["lemmas"]]
    document = {
        "schema": SCHEMA,
        "ruleset": text.id,
        "version": text.version,
        "digest": digest(text),
        "lemmas": [_written(maker.lemmas[n]) for n in used],
        "statements": told,
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def _written(lemma: Lemma) -> dict[str, Any]:
    return {
        "signs": [
            {
                "polynomial": [[str(factor), list(monomial)] for monomial, factor in polynomial.terms],
                "relation": relation,
            }
            for polynomial, relation in lemma.signs
        ],
        "parts": [
            {"times": str(part.times), "of": list(part.of), "monomial": list(part.monomial)}
            for part in lemma.parts
        ],
    }


Signed = tuple[int, str]  # a polynomial of the table, and its relation to zero


@dataclass(slots=True)
class _Maker:
    """Makes proofs of statements; lemmas are shared."""

    statements: Statements
    budget: Budget
    lemmas: list[Lemma] = field(default_factory=list)
    _coding: Coding = field(init=False)
    _context: Any = field(default_factory=z3.Context)  # of its own: what was asked before changes nothing
    _linear: Any = field(init=False)
    _asserted: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        self._coding = Coding(self.statements.table)
        self._linear = z3.SimpleSolver(ctx=self._context)
        self._linear.set("rlimit", _EFFORT)

    def proof(self, statement: Statement) -> dict[str, Any] | None:
        """Parts and lemmas by which a statement is impossible; None if linear arithmetic does not show it."""
        solver = z3.SimpleSolver(ctx=self._context)
        solver.set("rlimit", _EFFORT)
        solver.set("random_seed", 0)
        meaning, literals = self._coding.meaning(statement.parts)
        solver.add(*map(self._clause, meaning))
        for n, literal in enumerate(literals):
            solver.add(z3.Implies(self._bool(f"part {n}"), self._term(literal)))
        solver.add(*(self._lemma_term(n, lemma) for n, lemma in enumerate(self.lemmas)))
        for _ in range(MOST_ROUNDS):
            if self.budget.spent:
                return None
            lemmas = [self._bool(f"lemma {n}") for n in range(len(self.lemmas))]
            parts = [self._bool(f"part {n}") for n in range(len(statement.parts))]
            outcome = solver.check(*parts, *lemmas)
            if outcome == z3.unsat:
                return _told(statement, self._needed(solver))
            if outcome != z3.sat:
                return None
            lemma = self._refuted(self._supporting(solver.model(), statement.parts))
            if lemma is None:
                return None
            self.lemmas.append(lemma)
            solver.add(self._lemma_term(len(self.lemmas) - 1, lemma))
        return None

    def _needed(self, solver: Any) -> list[str]:
        """Names of parts and lemmas of which none can be left out."""
        core = sorted(str(each) for each in solver.unsat_core())
        found = _least(lambda some: solver.check(*map(self._bool, some)) == z3.unsat, core)
        return found or core

    def _literal(self, part: int) -> int:
        kind, *rest = node = self.statements.table.nodes[part]
        if kind == "not":
            return -self._literal(int(str(rest[0])))
        return self._coding.literal(node if kind == "flag" else ("node", part))

    def _lemma_term(self, n: int, lemma: Lemma) -> Any:
        clause = clause_of(self._coding, self.statements, lemma)
        return z3.Implies(self._bool(f"lemma {n}"), self._clause(clause))

    def _supporting(self, model: Any, parts: Iterable[int]) -> list[Signed]:
        """Signs that a model needs for the parts to hold."""
        coding, nodes = self._coding, self.statements.table.nodes
        found: dict[Signed, None] = {}

        def true(literal: int) -> bool:
            value = z3.is_true(model.eval(self._bool(f"v{abs(literal)}"), model_completion=True))
            return value is (literal > 0)

        def support(number: int, *, holds: bool) -> None:
            kind, *rest = nodes[number]
            if kind == "not":
                support(int(str(rest[0])), holds=not holds)
            elif kind == "and":
                children = [int(str(each)) for each in rest]
                if holds:
                    for child in children:
                        support(child, holds=True)
                else:
                    support(next(c for c in children if not true(self._literal(c))), holds=False)
            elif kind == "sign":
                place, *signs = (int(str(each)) for each in rest)
                wanted = frozenset(signs) if holds else frozenset({-1, 0, 1}) - frozenset(signs)
                sign = 1 if true(coding.positive(place)) else -1 if true(coding.negative(place)) else 0
                found.update(dict.fromkeys((place, relation) for relation in _relations(wanted, sign)))

        for part in parts:
            if nodes[part] != TRUE_NODE:
                support(part, holds=True)
        return list(found)

    def _refuted(self, signs: Sequence[Signed]) -> Lemma | None:
        """The least part of some signs that arithmetic refutes, as a lemma."""
        for place in {place for place, _ in signs} - self._asserted:
            self._assert(place)
        # What has few variables is kept: its factors are found more easily.
        names = {
            f"{place} {relation}": (place, relation)
            for place, relation in sorted(signs, key=lambda each: (-self._size(each[0]), each))
        }
        for refuted, products in ((self._linearly, False), (self._nonlinearly, True)):
            core = _least(lambda some: refuted([names[each] for each in some]), list(names))  # noqa: B023
            if core is not None:
                return multiplied(self._joined([names[each] for each in core]), products=products)
        return None

    def _size(self, place: int) -> int:
        return len(self.statements.table.polynomials[place].variables)

    def _linearly(self, signs: Sequence[Signed]) -> bool:
        """Whether linear arithmetic refutes some signs."""
        wanted = (self._bool(f"{place} {relation}") for place, relation in signs)
        return bool(self._linear.check(*wanted) == z3.unsat)

    def _nonlinearly(self, signs: Sequence[Signed]) -> bool:
        """Whether nonlinear arithmetic does, of which every question is asked afresh."""
        solver = z3.SimpleSolver(ctx=self._context)
        solver.set("rlimit", _NONLINEAR)
        for place, relation in signs:
            polynomial = self.statements.table.polynomials[place]
            solver.add(_said(_value_of(polynomial, self._context, products=True), relation))
        return bool(solver.check() == z3.unsat)

    def _joined(self, signs: Sequence[Signed]) -> list[tuple[Polynomial, str]]:
        """Signs with their polynomials; at least zero and at most zero is zero."""
        polynomials = self.statements.table.polynomials
        zero = {place for place, relation in signs if relation == ">=" and (place, "<=") in signs}
        joined = dict.fromkeys((place, "=" if place in zero else relation) for place, relation in signs)
        return [(polynomials[place], relation) for place, relation in joined]

    def _assert(self, place: int) -> None:
        self._asserted.add(place)
        polynomial = self.statements.table.polynomials[place]
        value = _value_of(polynomial, self._context, products=False)
        for relation in (">", "<", ">=", "<="):
            self._linear.add(z3.Implies(self._bool(f"{place} {relation}"), _said(value, relation)))
        for monomial in _squares([polynomial]):
            self._linear.add(z3.Real("*".join(monomial), self._context) >= 0)

    def _bool(self, name: str) -> Any:
        return z3.Bool(name, self._context)

    def _term(self, literal: int) -> Any:
        flag = self._bool(f"v{abs(literal)}")
        return flag if literal > 0 else z3.Not(flag)

    def _clause(self, clause: Sequence[int]) -> Any:
        return z3.Or(*(self._term(literal) for literal in clause), z3.BoolVal(False, self._context))  # noqa: FBT003


def _told(statement: Statement, needed: Sequence[str]) -> dict[str, Any]:
    def numbers(kind: str) -> list[int]:
        return sorted(int(name.split()[1]) for name in needed if name.startswith(kind))

    return {
        "property": statement.property,
        "title": statement.title,
        "parts": numbers("part"),
        "lemmas": numbers("lemma"),
    }


def _said(value: Any, relation: str) -> Any:
    return {">": value > 0, "<": value < 0, ">=": value >= 0, "<=": value <= 0}[relation]


def _least(refuted: Callable[[Sequence[str]], bool], names: Sequence[str]) -> list[str] | None:
    """Names of which none can be left out, if they are to be refuted; None if they are not.

    They are tried in this order, so that what stands last is kept.
    """
    if not refuted(names):
        return None
    core = list(names)
    for name in names:
        fewer = [each for each in core if each != name]
        if refuted(fewer):
            core = fewer
    return core


def _relations(wanted: frozenset[int], sign: int) -> tuple[str, ...]:
    """What must be said of a polynomial of a sign, so that it has one of some signs."""
    by_signs = {
        frozenset({1}): (">",),
        frozenset({-1}): ("<",),
        frozenset({0}): (">=", "<="),
        frozenset({0, 1}): (">=",),
        frozenset({-1, 0}): ("<=",),
        frozenset({-1, 1}): (">",) if sign > 0 else ("<",),
    }
    return by_signs[wanted]


def multiplied(signs: Sequence[tuple[Polynomial, str]], *, products: bool) -> Lemma | None:
    """Find the factors with which some signs contradict one another; None if there are none.

    With `products`, signs are also multiplied by one another and by squares.
    """
    parts = list(dict.fromkeys(_parts(signs, products=products)))
    bare = Lemma(signs=tuple(signs), parts=())
    context = z3.Context()
    solver = z3.SimpleSolver(ctx=context)
    solver.set("rlimit", _EFFORT)
    sums: dict[Monomial, list[Any]] = {}
    strict = []
    for n, part in enumerate(parts):
        factor = z3.Real(f"a{n}", context)
        relations = [signs[each][1] for each in part.of]
        if "=" not in relations:
            solver.add(factor >= 0)
        if not part.monomial and all(RELATIONS[relation][1] for relation in relations):
            strict.append(factor)
        for monomial, coefficient in bare.product(part).terms:
            term = _rational(coefficient, context) * factor
            sums.setdefault(monomial, []).append(term)
    if not strict:
        return None
    solver.add(*(z3.Sum(each) == 0 for each in sums.values()), z3.Sum(strict) == 1)
    if solver.check() != z3.sat:
        return None
    model = solver.model()
    found = [replace(part, times=_value(model, z3.Real(f"a{n}", context))) for n, part in enumerate(parts)]
    return Lemma(signs=tuple(signs), parts=tuple(part for part in found if part.times))


def _parts(signs: Sequence[tuple[Polynomial, str]], *, products: bool) -> Iterator[Part]:
    """Terms that may be in a lemma."""
    one = Fraction(1)
    yield Part(times=one)
    for square in _squares(polynomial for polynomial, _ in signs):
        yield Part(times=one, monomial=square)
    for n in range(len(signs)):
        yield Part(times=one, of=(n,))
    if not products:
        return
    names = sorted({name for polynomial, _ in signs for name in polynomial.variables})
    small = [(name,) for name in names] + list(combinations_with_replacement(names, 2))
    for monomial in small:
        yield Part(times=one, monomial=tuple(sorted(monomial + monomial)))
    for n, (_, relation) in enumerate(signs):
        for monomial in small:
            yield Part(
                times=one, of=(n,), monomial=monomial if relation == "=" else tuple(sorted(monomial * 2))
            )
    for pair in combinations_with_replacement(range(len(signs)), 2):
        yield Part(times=one, of=pair)
        if "=" not in (signs[pair[0]][1], signs[pair[1]][1]):
            for name in names:
                yield Part(times=one, of=pair, monomial=(name, name))


def _value(model: Any, term: Any) -> Fraction:
    found = model.eval(term, model_completion=True)
    return Fraction(found.numerator_as_long(), found.denominator_as_long())


def _squares(polynomials: Iterable[Polynomial]) -> list[Monomial]:
    monomials = {monomial for polynomial in polynomials for monomial, _ in polynomial.terms if monomial}
    return sorted(each for each in monomials if all(each.count(name) % 2 == 0 for name in each))


def _value_of(polynomial: Polynomial, context: Any, *, products: bool) -> Any:
    """A polynomial as a term: with products, or with a variable for each monomial."""
    total = z3.RealVal(0, context)
    for monomial, factor in polynomial.terms:
        term = _rational(factor, context)
        for name in monomial if products else ("*".join(monomial),) if monomial else ():
            term = term * z3.Real(name, context)
        total = total + term
    return total


def _rational(value: Fraction, context: Any) -> Any:
    return z3.Q(value.numerator, value.denominator, ctx=context)
