"""Statements as clauses, and a search whether clauses can hold together; no solver and no floats.

A literal is a whole number, negative where it is negated.  Each polynomial has two: that it is positive, and
that it is negative; each fact has one, and each part of a formula that is an `and`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final, TypeAlias

from ..tapd.language.formula import NEGATIVE, POSITIVE, ZERO
from .statements import TRUE_NODE, Table

Clause: TypeAlias = tuple[int, ...]
MOST_STEPS: Final = 200_000  # of the search


class TooLong(Exception):  # noqa: N818 - it is told as what it is
    """The search has found no end."""


@dataclass(slots=True)
class Coding:
    """Literals for what stands in a table."""

    table: Table
    literals: dict[tuple[object, ...], int] = field(default_factory=dict)

    def literal(self, key: tuple[object, ...]) -> int:
        """Literal of a fact, of a sign of a polynomial, or of a part."""
        return self.literals.setdefault(key, len(self.literals) + 1)

    def positive(self, polynomial: int) -> int:
        """Literal of a polynomial being greater than zero."""
        return self.literal(("positive", polynomial))

    def negative(self, polynomial: int) -> int:
        """Literal of a polynomial being less than zero."""
        return self.literal(("negative", polynomial))

    def signs(self, polynomial: int, signs: frozenset[int]) -> tuple[Clause, bool]:
        """Literals of a sign test, and whether all of them must hold, or one."""
        up, down = self.positive(polynomial), self.negative(polynomial)
        by_signs: dict[frozenset[int], tuple[Clause, bool]] = {
            frozenset({POSITIVE}): ((up,), True),
            frozenset({NEGATIVE}): ((down,), True),
            frozenset({ZERO}): ((-up, -down), True),
            frozenset({ZERO, POSITIVE}): ((-down,), True),
            frozenset({ZERO, NEGATIVE}): ((-up,), True),
            frozenset({NEGATIVE, POSITIVE}): ((up, down), False),
        }
        return by_signs[signs]

    def clauses(self, parts: Iterable[int]) -> list[Clause]:
        """Clauses that hold exactly if all parts do, with what holds of the facts and signs in them."""
        meaning, literals = self.meaning(parts)
        return [*meaning, *((literal,) for literal in literals)]

    def meaning(self, parts: Iterable[int]) -> tuple[list[Clause], list[int]]:
        """Clauses that say what parts mean, and what holds of their facts; and the literals of the parts."""
        found: list[Clause] = []
        done: set[int] = set()
        flags: set[str] = set()
        polynomials: set[int] = set()
        literals = [self._coded(part, found, done, flags, polynomials) for part in parts]
        found += [(-self.positive(each), -self.negative(each)) for each in sorted(polynomials)]
        return [*found, *self._facts(flags)], literals

    def _coded(
        self, number: int, found: list[Clause], done: set[int], flags: set[str], polynomials: set[int]
    ) -> int:
        kind, *rest = node = self.table.nodes[number]
        if kind == "not":
            return -self._coded(int(str(rest[0])), found, done, flags, polynomials)
        if kind == "flag":
            flags.add(str(rest[0]))
            return self.literal(node)
        here = self.literal(("node", number))
        if number in done:
            return here
        done.add(number)
        if node == TRUE_NODE:
            found.append((here,))
            return here
        if kind == "sign":
            polynomial, *signs = (int(str(each)) for each in rest)
            polynomials.add(polynomial)
            literals, together = self.signs(polynomial, frozenset(signs))
        else:
            literals = tuple(self._coded(int(str(each)), found, done, flags, polynomials) for each in rest)
            together = True
        sense = 1 if together else -1
        found += [(-sense * here, sense * each) for each in literals]
        found.append((sense * here, *(-sense * each for each in literals)))
        return here

    def _facts(self, flags: set[str]) -> Iterator[Clause]:
        """One value for each fact with words, if it is known."""
        for fact, words in sorted(self.table.choices.items()):
            names = [f"{fact}={word}" for word in words]
            if not flags.intersection(names):
                continue
            values = [self.literal(("flag", name)) for name in names]
            known = self.literal(("flag", f"known({fact})")) if fact in self.table.known else 0
            yield (*((-known,) if known else ()), *values)
            yield from ((-one, -two) for n, one in enumerate(values) for two in values[n + 1 :])
            if known:
                yield from ((known, -value) for value in values)


def possible(clauses: Sequence[Clause]) -> bool:
    """Whether some values of the literals fulfil all clauses.

    By trying, following what each try entails, and learning from each contradiction the clause that it shows.

    >>> possible([(1, 2), (-1,), (-2, 3)]), possible([(1,), (-1,)])
    (True, False)

    Raises
    ------
    TooLong
        If that takes too many steps.
    """
    return _Search(clauses).possible()


class _Search:
    """Two literals of each clause are watched: only when one of these fails is the clause looked at."""

    def __init__(self, clauses: Sequence[Clause]) -> None:
        self._given = [list(dict.fromkeys(clause)) for clause in clauses]
        self._watched: dict[int, list[list[int]]] = {}
        self._level: dict[int, int] = {}  # of each literal that is true
        self._reason: dict[int, list[int] | None] = {}
        self._trail: list[int] = []
        self._weights: dict[int, float] = {}
        self._bump = 1.0
        self._depth = 0
        self._steps = 0

    def possible(self) -> bool:
        """Search."""
        for clause in self._given:
            for literal in clause:
                self._weights[abs(literal)] = self._weights.get(abs(literal), 0.0) + 0.01
            if len(clause) > 1:
                self._watch(clause)
        units = [clause for clause in self._given if len(clause) < 2]
        if not all(units) or any(self._follow(unit[0], None) is not None for unit in units):
            return False
        while (free := self._undecided()) is not None:
            self._depth += 1
            wrong = self._follow(free, None)
            while wrong is not None:
                if self._depth == 0:
                    return False
                learned, back = self._learned(wrong)
                self._undo(back)
                if len(learned) > 1:
                    self._watch(learned)
                wrong = self._follow(learned[0], learned if len(learned) > 1 else None)
        return True

    def _watch(self, clause: list[int]) -> None:
        for literal in clause[:2]:
            self._watched.setdefault(literal, []).append(clause)

    def _undecided(self) -> int | None:
        free = [each for each in self._weights if each not in self._level and -each not in self._level]
        return -max(free, key=self._weights.__getitem__) if free else None

    def _undo(self, depth: int) -> None:
        while self._trail and self._level[self._trail[-1]] > depth:
            literal = self._trail.pop()
            del self._level[literal], self._reason[literal]
        self._depth = depth

    def _follow(self, literal: int, reason: list[int] | None) -> list[int] | None:
        """Take a literal for true, and all that follows; a clause that fails then, if one does."""
        queue: list[tuple[int, list[int] | None]] = [(literal, reason)]
        for one, why in queue:
            if -one in self._level:
                return why if why is not None else [one]
            if one in self._level:
                continue
            self._level[one], self._reason[one] = self._depth, why
            self._trail.append(one)
            self._steps += 1
            if self._steps > MOST_STEPS:
                raise TooLong
            if (wrong := self._passed_on(one, queue)) is not None:
                return wrong
        return None

    def _passed_on(self, one: int, queue: list[tuple[int, list[int] | None]]) -> list[int] | None:
        """Look at the clauses that watch the opposite of a literal."""
        watching = self._watched.get(-one, [])
        kept: list[list[int]] = []
        self._watched[-one] = kept
        for place, clause in enumerate(watching):
            if clause[0] == -one:
                clause[0], clause[1] = clause[1], clause[0]
            if clause[0] in self._level:
                kept.append(clause)
                continue
            for other in range(2, len(clause)):
                if -clause[other] not in self._level:
                    clause[1], clause[other] = clause[other], clause[1]
                    self._watched.setdefault(clause[1], []).append(clause)
                    break
            else:
                kept.append(clause)
                if -clause[0] in self._level:
                    kept += watching[place + 1 :]
                    return clause
                queue.append((clause[0], clause))
        return None

    def _learned(self, wrong: list[int]) -> tuple[list[int], int]:
        """The clause that a contradiction shows, its one literal of this depth first; how far to go back."""
        learned: set[int] = set()
        seen: set[int] = set()
        here = 0
        clause = wrong
        for literal in reversed(self._trail):
            for each in clause:
                if -each in self._level and abs(each) not in seen:
                    seen.add(abs(each))
                    self._weights[abs(each)] += self._bump
                    if self._level[-each] == self._depth:
                        here += 1
                    elif self._level[-each] > 0:
                        learned.add(each)
            clause = []
            if abs(literal) in seen and self._level[literal] == self._depth:
                here -= 1
                if here == 0:
                    first = -literal
                    break
                clause = self._reason[literal] or []
        self._bump *= 1.05
        rest = sorted(learned, key=lambda each: -self._level[-each])
        return [first, *rest], self._level[-rest[0]] if rest else 0
