"""What must be impossible if a ruleset is sound, as formulas without a solver.

Each statement is a conjunction that no two ships can fulfil.  The formulas are kept in one table, in which
equal parts are one: signs of polynomials and facts at the bottom, `and`, `or`, `not` above.  Polynomials are
in the frame of own ship: it sails along the first axis (`ovx` >= 0, `ovy` = 0), and the other's velocity is
own plus `w`.  That loses nothing, for all of them are the same whichever way the ships are turned, which is
checked for each (`unturned`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Final, TypeAlias

from ..quantities import ANGLE
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
from ..tapd.language.polynomial import Polynomial, canonical, mirrored_name, number, variable
from ..tapd.rules import Mirror, Policy, RulesetText
from ..tapd.vocabulary import VOCABULARY, Fact, Kind, Scope
from ..verdict import Kind as Says
from .duties import Place, duty, turned

Node: TypeAlias = tuple[
    object, ...
]  # ("sign", polynomial, signs), ("flag", name), ("and", …), ("or", …), ("not", n)

TRUE_NODE: Final = ("true",)
_SHARED_VELOCITY: Final[Mapping[str, Polynomial]] = {
    "tvx": variable("ovx") + variable("wx"),
    "tvy": variable("ovy") + variable("wy"),
}
_FRAME: Final[Mapping[str, Polynomial]] = {"ovy": number(0)}
_TURNED: Final = {
    "rx": ("ry", -1),
    "ry": ("rx", 1),
    "wx": ("wy", -1),
    "wy": ("wx", 1),
    "ovx": ("ovy", -1),
    "ovy": ("ovx", 1),
}
_DERIVED: Final = frozenset({"geometry", "overtaker", "has_other_on_starboard", "risk_of_collision"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Statement:
    """Something that must be impossible: for which property, in words, and parts that cannot all hold."""

    property: str
    title: str
    parts: tuple[int, ...]  # nodes


@dataclass(slots=True)
class Table:
    """Formulas and polynomials by number; facts with words; facts of which it is asked if they are known."""

    nodes: list[Node] = field(default_factory=list)
    polynomials: list[Polynomial] = field(default_factory=list)
    choices: dict[str, tuple[str, ...]] = field(default_factory=dict)
    known: set[str] = field(default_factory=set)
    _numbers: dict[Node, int] = field(default_factory=dict)
    _polynomials: dict[Polynomial, int] = field(default_factory=dict)

    def number(self, node: Node) -> int:
        """Number of a node, which is put into the table if it is new."""
        if node not in self._numbers:
            self._numbers[node] = len(self.nodes)
            self.nodes.append(node)
        return self._numbers[node]

    def place(self, polynomial: Polynomial) -> int | None:
        """Number of a polynomial; None if it does not occur."""
        return self._polynomials.get(polynomial)

    def true(self) -> int:
        """What always holds."""
        return self.number(TRUE_NODE)

    def flag(self, name: str) -> int:
        """A fact that is true or false."""
        return self.number(("flag", name))

    def choice(self, fact: str, value: str, words: tuple[str, ...]) -> int:
        """That a fact has a value."""
        self.choices[fact] = words
        return self.flag(f"{fact}={value}")

    def opposite(self, part: int) -> int:
        """Negate."""
        kind, *rest = self.nodes[part]
        return int(str(rest[0])) if kind == "not" else self.number(("not", part))

    def all_of(self, parts: list[int]) -> int:
        """Join by `and`."""
        kept = [part for part in dict.fromkeys(parts) if self.nodes[part] != TRUE_NODE]
        return kept[0] if len(kept) == 1 else self.number(("and", *kept)) if kept else self.true()

    def any_of(self, parts: list[int]) -> int:
        """Join by `or`."""
        return self.opposite(self.all_of([self.opposite(part) for part in parts]))

    def sign(self, polynomial: Polynomial, signs: frozenset[int]) -> int:
        """That a polynomial has one of some signs.

        Raises
        ------
        ValueError
            If it is not the same whichever way the ships are turned.
        """
        shared = polynomial.with_values(_SHARED_VELOCITY)
        if not unturned(shared):
            raise ValueError("a condition depends on where north is")
        return self.framed(shared.with_values(_FRAME), signs)

    def framed(self, polynomial: Polynomial, signs: frozenset[int]) -> int:
        """That a polynomial in the frame of own ship has one of some signs."""
        value = polynomial.constant
        if value is not None:
            found = self.true()
            return found if (value > 0) - (value < 0) in signs else self.opposite(found)
        scaled, sense = canonical(polynomial)
        if scaled not in self._polynomials:
            self._polynomials[scaled] = len(self.polynomials)
            self.polynomials.append(scaled)
        return self.number(("sign", self._polynomials[scaled], *sorted(sense * each for each in signs)))


def unturned(polynomial: Polynomial) -> bool:
    """Whether a polynomial of a pair stays the same when both ships and their sight are turned.

    Its derivative along the turn, x to -y and y to x in each vector, is zero.
    """
    derivative = Polynomial(())
    for monomial, factor in polynomial.terms:
        for place, name in enumerate(monomial):
            if name in _TURNED:
                other, sense = _TURNED[name]
                product = number(factor * sense) * variable(other)
                for each in (*monomial[:place], *monomial[place + 1 :]):
                    product = product * variable(each)
                derivative = derivative + product
    return not derivative.terms


def bounded_below(fact: Fact) -> bool:
    """Whether a numeric fact is never negative: all that we define are so, but for angles."""
    return fact.kind is Kind.NUMBER and fact.quantity is not ANGLE and fact in VOCABULARY.by_scope[fact.scope]


@dataclass(slots=True)
class _View:
    """Conditions as one of the two ships asks them."""

    table: Table
    text: RulesetText
    swapped: bool
    there: _View | None = None
    _made: dict[int, tuple[Formula, int]] = field(default_factory=dict)

    def node(self, formula: Formula) -> int:
        """A condition."""
        key = id(formula)
        if key not in self._made:
            self._made[key] = formula, self._node(formula)
        return self._made[key][1]

    def _node(self, formula: Formula) -> int:
        table = self.table
        match formula:
            case Constant():
                return table.true() if formula.value else table.opposite(table.true())
            case Not():
                return table.opposite(self.node(formula.part))
            case And():
                return table.all_of([self.node(part) for part in formula.parts])
            case Or():
                return table.any_of([self.node(part) for part in formula.parts])
            case Named():
                return self.node(formula.part)
            case Sign():
                return self._sign(formula.polynomial, formula.signs)
            case Before():
                limit = variable(formula.other) if isinstance(formula.other, str) else formula.other
                signs = {NEGATIVE} if formula.strict else {NEGATIVE, ZERO}
                return self._sign(variable(formula.one) - limit, frozenset(signs))
            case Same():
                both = [
                    table.all_of([self._test(formula.one, word), self._test(formula.other, word)])
                    for word in self._words(formula.one)
                ]
                return table.any_of(both)
            case Known():
                return self._known(self._name(formula.fact), formula.fact)
            case Test():
                if formula.fact in _DERIVED:
                    return self._recognised(formula.fact, str(formula.value))
                return self._test(formula.fact, formula.value)

    def _sign(self, polynomial: Polynomial, signs: frozenset[int]) -> int:
        seen = polynomial.mirrored() if self.swapped else polynomial
        return self.table.sign(seen.with_values(self.text.constants), signs)

    def _name(self, fact: str) -> str:
        return mirrored_name(fact) if self.swapped else fact

    def _words(self, fact: str) -> tuple[str, ...]:
        head, dot, tail = fact.partition(".")
        scope = Scope.WATERWAY if head == "waterway" else Scope.SHIP if dot else Scope.PAIR
        found = self.text.vocabulary.find(scope, tail or fact)
        return found.choices if found else ()

    def _test(self, fact: str, value: bool | str) -> int:
        name = self._name(fact)
        if isinstance(value, bool):
            return self.table.flag(name)
        words = self._words(fact)
        return self.table.choice(name, value, words) if words else self.table.flag(f"{name}={value}")

    def _known(self, name: str, fact: str) -> int:
        self.table.known.add(name)
        if words := self._words(fact):
            self.table.choices[name] = words
        return self.table.flag(f"known({name})")

    # -- recognition -----------------------------------------------------------------------------

    def _recognised(self, name: str, value: str) -> int:
        table, found = self.table, self.text.recognition
        if found is None:
            return table.true() if value == "none" else table.opposite(table.true())
        if name == "risk_of_collision":
            return self.node(found.risk)
        if name == "geometry":
            return self.geometry(value)
        asked = found.overtaking if name == "overtaker" else found.from_starboard
        here, there = self.node(asked), self.other.node(asked)
        by_value = {
            "own": here,
            "other": table.all_of([table.opposite(here), there]),
            "none": table.opposite(table.any_of([here, there])),
        }
        return by_value[value]

    def geometry(self, value: str) -> int:
        """That the encounter is of a kind, as this ship sees it."""
        table, found = self.table, self.text.recognition
        assert found is not None  # noqa: S101
        overtaking = table.any_of([self.node(found.overtaking), self.other.node(found.overtaking)])
        head_on, crossing = self.node(found.head_on), self.node(found.crossing)
        rest = table.opposite(overtaking)
        by_value = {
            "overtaking": overtaking,
            "head_on": table.all_of([rest, head_on]),
            "crossing": table.all_of([rest, table.opposite(head_on), crossing]),
            "none": table.all_of([rest, table.opposite(head_on), table.opposite(crossing)]),
        }
        return by_value[value]

    @property
    def other(self) -> _View:
        """The view of the other ship."""
        assert self.there is not None  # noqa: S101
        return self.there


@dataclass(eq=False)
class Statements:
    """All statements about a ruleset, and the table of their formulas."""

    text: RulesetText
    table: Table = field(default_factory=Table)

    @cached_property
    def all(self) -> tuple[Statement, ...]:
        """Every statement, each with what holds of the ships of the domain among its parts."""
        found = [*self._consistent(), *self._mirror_sound(), *self._complete(), *self._exclusive()]
        given = self._domain()
        return tuple(Statement(property=c.property, title=c.title, parts=(*c.parts, *given)) for c in found)

    @cached_property
    def _views(self) -> tuple[_View, _View]:
        own, other = _View(self.table, self.text, swapped=False), _View(self.table, self.text, swapped=True)
        own.there, other.there = other, own
        return own, other

    def _domain(self) -> tuple[int, ...]:
        """What holds of all ships for which the ruleset is meant."""
        own, other = self._views
        table = self.table
        found = [view.node(f) for view in (own, other) for f in self.text.domain.assume]
        found.append(table.framed(variable("ovx"), frozenset({ZERO, POSITIVE})))  # by the choice of the frame
        names = sorted({name for polynomial in table.polynomials for name in polynomial.variables})
        for name in names:
            head, _, tail = name.partition(".")
            fact = self.text.vocabulary.find(Scope.SHIP, tail) if head in ("own", "other") else None
            if fact is None or not bounded_below(fact):
                continue
            low, high = self.text.domain.length if tail == "length" else (Fraction(0), None)
            found.append(table.sign(variable(name) - number(low), frozenset({ZERO, POSITIVE})))
            if high is not None:
                found.append(table.sign(variable(name) - number(high), frozenset({NEGATIVE, ZERO})))
        return tuple(found)

    # -- the ladder ------------------------------------------------------------------------------

    @cached_property
    def _places(self) -> tuple[Place, ...]:
        both = (False, True) if self.text.mirror is Mirror.AUTO else (False,)
        return tuple(Place(n, rule, swapped) for n, rule in enumerate(self.text.rules) for swapped in both)

    def _applies(self, place: Place, view: int = 0) -> int:
        return self._views[place.swapped != bool(view)].node(place.rule.condition)

    def _decides(self, place: Place, view: int = 0) -> list[int]:
        before = self._places[: self._places.index(place)]
        return [
            self._applies(place, view),
            *(self.table.opposite(self._applies(each, view)) for each in before),
        ]

    def _says(self, kind: Says, view: int) -> int:
        places = [place for place in self._places if place.kind is kind]
        return self.table.any_of([self.table.all_of(self._decides(place, view)) for place in places])

    # -- properties ------------------------------------------------------------------------------

    def _consistent(self) -> Iterator[Statement]:
        mirrored = self.text.mirror is Mirror.AUTO
        for place in self._places:
            rule = place.rule
            if place.swapped or rule.python:
                continue
            if rule.outcome.kind is Says.CONFLICT:
                title = f"rule '{rule.id}' finds the regulation at odds with itself"
                yield Statement(property="consistent", title=title, parts=tuple(self._decides(place)))
            elif mirrored:
                yield from self._both_ways(place)
        if not mirrored:
            yield from self._unmirrored()

    def _both_ways(self, place: Place) -> Iterator[Statement]:
        """That a rule, or two branches of one, apply both ways round, and do not fit."""
        said = duty(place.rule.outcome, swapped=False)
        for again in self._places:
            fits = turned(duty(again.rule.outcome, swapped=False)) == said
            if again.swapped and again.rule.id == place.rule.id and not fits:
                title = f"rule '{place.rule.id}' applies both ways round"
                parts = (self._applies(again), *self._decides(place))
                yield Statement(property="consistent", title=title, parts=parts)

    def _unmirrored(self) -> Iterator[Statement]:
        for one in self._places:
            for two in self._places:
                if turned(duty(one.rule.outcome, swapped=False)) == duty(two.rule.outcome, swapped=False):
                    continue
                title = f"one ship judges by rule '{one.rule.id}', the other by '{two.rule.id}'"
                parts = (*self._decides(one), *self._decides(two, view=1))
                yield Statement(property="consistent", title=title, parts=parts)

    def _mirror_sound(self) -> Iterator[Statement]:
        found = self.text.recognition
        if found is None:
            return
        table, (own, other) = self.table, self._views
        overtaking = table.any_of([own.node(found.overtaking), other.node(found.overtaking)])
        head_on = table.any_of([own.node(found.head_on), other.node(found.head_on)])
        rest = table.opposite(overtaking)

        def one_sided(formula: Formula) -> int:
            here, there = own.node(formula), other.node(formula)
            return table.all_of([table.any_of([here, there]), table.opposite(table.all_of([here, there]))])

        asked = {
            "only one of the ships sees a risk of collision": [one_sided(found.risk)],
            "only one of the ships sees a head-on encounter": [rest, one_sided(found.head_on)],
            "only one of the ships sees a crossing": [
                rest,
                table.opposite(head_on),
                one_sided(found.crossing),
            ],
            "each ship overtakes the other": [view.node(found.overtaking) for view in (own, other)],
            "each ship has the other on its starboard side": [
                *(view.node(found.from_starboard) for view in (own, other)),
                table.opposite(own.geometry("none")),
            ],
        }
        for title, parts in asked.items():
            yield Statement(property="mirror_sound", title=title, parts=tuple(parts))

    def _complete(self) -> Iterator[Statement]:
        own, _ = self._views
        risk = own.node(Test("risk_of_collision", value=True))
        for place in self._places:
            rule = place.rule
            if rule.outcome.kind in (Says.NONE, Says.GAP) and not place.swapped and not rule.python:
                title = f"rule '{rule.id}' decides nothing"
                yield Statement(property="complete", title=title, parts=(risk, *self._decides(place)))
        silent = tuple(self.table.opposite(self._applies(place)) for place in self._places)
        yield Statement(
            property="complete", title="no rule applies to ships at risk of collision", parts=(risk, *silent)
        )
        both = tuple(self._says(Says.STAND_ON, view) for view in (0, 1))
        yield Statement(property="complete", title="both ships stand on", parts=(risk, *both))

    def _exclusive(self) -> Iterator[Statement]:
        if self.text.policy is not Policy.UNIQUE:
            return
        for first, one in enumerate(self._places):
            for two in self._places[first + 1 :]:
                same = duty(one.rule.outcome, swapped=one.swapped) == duty(
                    two.rule.outcome, swapped=two.swapped
                )
                if one.swapped or same or one.rule is two.rule:
                    continue
                title = f"rules '{one.rule.id}' and '{two.rule.id}' apply together"
                parts = (self._applies(one), self._applies(two))
                yield Statement(property="exclusive", title=title, parts=parts)
