"""Certificates verified: with fractions and a small search, and without any solver.

A certificate says which statements about a ruleset are impossible, and why: lemmas, each a few signs of
polynomials that cannot hold together; and for each statement the parts and the lemmas that it takes.  The
statements are made anew from the ruleset; of the certificate only the lemmas are used.

A lemma is verified as an identity.  Its polynomials are turned so that each is claimed to be greater than
zero, at least zero, or zero.  Then a sum of terms, each a factor >= 0 times some of these polynomials times
the square of a monomial, cannot be identically zero if one of the terms is greater than zero.  A term with a
polynomial that is claimed to be zero may have any factor and any monomial.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

from ..errors import Diagnostic, InputError
from ..tapd.language.polynomial import Monomial, Polynomial, number, variable
from ..tapd.rules import RulesetText
from ..tapd.written import WrittenRuleset
from .clauses import Clause, Coding, TooLong, possible
from .statements import Statement, Statements

SCHEMA: Final = "ccas/certificate@1"
# How a polynomial is turned, and whether it then is greater than zero, or only at least zero.
RELATIONS: Final = {">": (1, True), ">=": (1, False), "<": (-1, True), "<=": (-1, False), "=": (1, False)}


class CertificateError(InputError):
    """A certificate does not prove what it says."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Covered:
    """A property, and for how many of its statements there is a certificate."""

    name: str
    proved: tuple[str, ...]  # titles
    open: tuple[str, ...]

    @property
    def whole(self) -> bool:
        """Whether nothing of the property is left open."""
        return not self.open

    def __str__(self) -> str:
        if self.whole:
            return f"{self.name}: certificate for all of {len(self.proved)} statements"
        count = len(self.proved) + len(self.open)
        return f"{self.name}: certificate for {len(self.proved)} of {count} statements"


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A term of a lemma: a factor, some of its signs by number, and a monomial."""

    times: Fraction
    of: tuple[int, ...] = ()
    monomial: Monomial = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Lemma:
    """Signs that cannot hold together, for these terms of theirs add to nothing."""

    signs: tuple[tuple[Polynomial, str], ...]
    parts: tuple[Part, ...]

    @property
    def fault(self) -> str:
        """What is wrong with it; nothing if it holds."""
        total = Polynomial(())
        strict = False
        for part in self.parts:
            relations = [self.signs[n][1] for n in part.of]
            if "=" not in relations:
                if part.times < 0:
                    return "a factor is negative"
                if any(part.monomial.count(name) % 2 for name in part.monomial):
                    return f"{'*'.join(part.monomial)} is no square"
            strict |= part.times > 0 and not part.monomial and all(RELATIONS[r][1] for r in relations)
            total = total + self.product(part) * number(part.times)
        if total.terms:
            return "its terms do not add to nothing"
        return "" if strict else "none of its terms is greater than zero: no contradiction"

    def product(self, part: Part) -> Polynomial:
        """A term without its factor."""
        product = _product(part.monomial)
        for n in part.of:
            polynomial, relation = self.signs[n]
            product = product * polynomial * number(RELATIONS[relation][0])
        return product


def _product(monomial: Monomial) -> Polynomial:
    product = number(1)
    for name in monomial:
        product = product * variable(name)
    return product


def digest(text: RulesetText) -> str:
    """Digest of the text of a ruleset file."""
    return hashlib.sha256(Path(text.source).read_bytes()).hexdigest()


def verify(certificate: str, ruleset: WrittenRuleset) -> tuple[Covered, ...]:
    """Verify a certificate against a ruleset; what is proved of which property, and what is not.

    Raises
    ------
    CertificateError
        If anything in it is wrong, with what.
    """
    document = _read(certificate)
    text = ruleset.text
    here = {"ruleset": text.id, "version": text.version, "digest": digest(text)}
    for key, value in here.items():
        if document[key] != value:
            raise _refused(f"it is about {key} {document[key]}, the ruleset has {value}")
    statements = Statements(text)
    lemmas = [_lemma(each, n) for n, each in enumerate(document["lemmas"])]
    told = {(each["property"], each["title"]): each for each in document["statements"]}
    if len(told) != len(document["statements"]):
        raise _refused("a statement stands in it twice")
    proved: dict[str, list[str]] = {}
    open_: dict[str, list[str]] = {}
    for statement in statements.all:
        named = statement.property, statement.title
        if named in told:
            _verify(statements, statement, told.pop(named), lemmas)
            proved.setdefault(statement.property, []).append(statement.title)
        else:
            open_.setdefault(statement.property, []).append(statement.title)
    if told:
        raise _refused(f"the ruleset makes no statement '{next(iter(told))[1]}'")
    return tuple(_covered(proved, open_))


def _covered(proved: Mapping[str, list[str]], open_: Mapping[str, list[str]]) -> Iterator[Covered]:
    for name in dict.fromkeys((*proved, *open_)):
        yield Covered(name=name, proved=tuple(proved.get(name, ())), open=tuple(open_.get(name, ())))


def _verify(statements: Statements, statement: Statement, told: Any, lemmas: list[Lemma]) -> None:
    parts = told["parts"]
    if not all(isinstance(n, int) and 0 <= n < len(statement.parts) for n in parts):
        raise _refused(f"'{statement.title}' has no such part")
    coding = Coding(statements.table)
    clauses = coding.clauses(statement.parts[n] for n in parts)
    for n in told["lemmas"]:
        if not isinstance(n, int) or not 0 <= n < len(lemmas):
            raise _refused(f"'{statement.title}' rests on a lemma that is not there")
        clauses.append(clause_of(coding, statements, lemmas[n]))
    try:
        held = possible(clauses)
    except TooLong:
        raise _refused(f"'{statement.title}' takes too long to search") from None
    if held:
        raise _refused(f"'{statement.title}' is not impossible by what is given for it")


def clause_of(coding: Coding, statements: Statements, lemma: Lemma) -> Clause:
    """That one of the signs of a lemma does not hold."""
    literals: list[int] = []
    for polynomial, relation in lemma.signs:
        place = statements.table.place(polynomial)
        if place is None:
            raise _refused("a lemma is about a polynomial that the ruleset does not ask for")
        up, down = coding.positive(place), coding.negative(place)
        literals += {">": (-up,), "<": (-down,), ">=": (down,), "<=": (up,), "=": (up, down)}[relation]
    return tuple(literals)


def _read(certificate: str) -> Any:
    try:
        document = json.loads(certificate)
    except ValueError as error:
        raise _refused(f"it is no JSON: {error}") from None
    wanted = {"schema", "ruleset", "version", "digest", "lemmas", "statements"}
    if not isinstance(document, dict) or not wanted <= document.keys():
        raise _refused(f"it lacks one of {', '.join(sorted(wanted))}")
    if document["schema"] != SCHEMA:
        raise _refused(f"its schema is {document['schema']}; known is {SCHEMA}")
    return document


def _lemma(told: Any, place: int) -> Lemma:
    try:
        signs = tuple((_polynomial(each["polynomial"]), str(each["relation"])) for each in told["signs"])
        parts = tuple(
            Part(
                times=Fraction(each["times"]),
                of=tuple(int(n) for n in each["of"]),
                monomial=tuple(str(name) for name in each["monomial"]),
            )
            for each in told["parts"]
        )
        if any(n < 0 for part in parts for n in part.of):
            raise IndexError("a sign that is not there")
        lemma = Lemma(signs=signs, parts=parts)
        fault = lemma.fault
    except (LookupError, TypeError, ValueError, ZeroDivisionError) as error:
        raise _refused(f"lemma {place} cannot be read: {error}") from None
    if fault:
        raise _refused(f"lemma {place} does not hold: {fault}")
    return lemma


def _polynomial(told: Any) -> Polynomial:
    total = Polynomial(())
    for factor, monomial in told:
        total = total + _product(tuple(monomial)) * number(Fraction(factor))
    return total


def _refused(message: str) -> CertificateError:
    return CertificateError(Diagnostic(source="certificate", message=message))
