"""Rings of ships that give way to one another: none for any number of ships, or ships that form one.

Proof: a ranking.  Features of single ships, such as being small or upbound, are put in an order in which no
ship ever gives way to one that comes later; where all features are equal, a number must decide: a fact, the
speed, or, on a reach, the place along it.  A strict ranking leaves no ring, however many ships there are.

Search: ships that meet near one point, by the shape of the junction (an open water, a reach, a T, four
arms, three arms at 120 degrees), with facts alike and at random, judged by the rules as they run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, Final

import networkx as nx
import numpy as np
import z3

from ..priority import settle
from ..ships import ShipId
from ..tapd.case_run import pair_facts
from ..tapd.cases import Case
from ..tapd.language.formula import Test, facts_of, walk
from ..tapd.language.motion import dot
from ..tapd.language.polynomial import Polynomial, number, variable
from ..tapd.rules import Rule, RulesetText
from ..tapd.vocabulary import Kind as FactKind
from ..tapd.vocabulary import Scope
from ..tapd.written import WrittenRuleset
from ..verdict import Kind, Verdict
from .findings import Fault, Finding
from .ladder import Ladder
from .pairs import Tally
from .plain import plainer
from .questions import bounds_of
from .search import A, B, Facts, Ships, case_of
from .solver import NONLINEAR_LIMIT, Budget, ask_linear, ask_nonlinear
from .symbols import Symbols, Term, View, constants_of

TRIES: Final = 260  # groups of ships that are tried for each shape and number of ships
_LENGTHS: Final = (12.0, 60.0, 110.0)


@dataclass(frozen=True, slots=True)
class Shape:
    """A water: the courses of ships that come to its middle [deg]; none: any course."""

    name: str
    courses: tuple[float, ...]
    spread: float  # by which a course may differ [deg]


SHAPES: Final = (
    Shape("open water", (), 0.0),
    Shape("a reach", (0.0, 180.0), 10.0),
    Shape("a T junction", (0.0, 180.0, 270.0), 0.0),
    Shape("a crossing of four arms", (0.0, 90.0, 180.0, 270.0), 0.0),
    Shape("three arms at 120 deg", (0.0, 120.0, 240.0), 0.0),
)


def acyclic(
    ruleset: WrittenRuleset, budget: Budget, max_ships: int = 4, *, reach_only: bool = False
) -> Finding:
    """Ships never give way to one another in a ring, however many they are.

    `reach_only` asks for ships that follow one reach of a river: courses along its axis, upbound ships one
    way and downbound ships the other.
    """
    tally = Tally()
    shapes: Sequence[Shape] = SHAPES
    if reach_only:
        shapes = [replace(shape, spread=0.0) for shape in SHAPES if shape.name == "a reach"]
    for shape in shapes:
        _search(tally, ruleset, shape, budget, max_ships)
    if tally.faults:
        return tally.finding("acyclic")
    for reach in (True,) if reach_only else (False, True):
        ranking = _ranking(ruleset, budget, reach=reach)
        if ranking is None:
            tally.notes.append(f"no ranking was found for {'a reach' if reach else 'any water'}")
            continue
        words = ", then ".join(ranking)
        if reach_only or not reach:
            return tally.finding("acyclic", f"ranking for any number of ships: {words}")
        tally.notes.append(f"on a reach, for any number of ships: {words}")
    most = max_ships if not reach_only else max(2, max_ships)
    tally.open.append(f"no ring of up to {most} ships was found, and no ranking that excludes it")
    return tally.finding("acyclic")


# --- proof ----------------------------------------------------------------------------------------


def _ranking(ruleset: WrittenRuleset, budget: Budget, *, reach: bool) -> list[str] | None:
    """Names of features and the number that decides at last; None where no ranking is found."""
    fixed: dict[str, Polynomial] = {"A.x": number(0), "A.y": number(0)}
    if reach:
        fixed |= {"A.vy": number(0), "B.vy": number(0)}
    symbols = Symbols(fixed=fixed)
    text = ruleset.text
    view = View(symbols, text, A, B, constants_of(text, free=False))
    ladder = Ladder(view)
    gives_way = ladder.says(Kind.GIVE_WAY)
    given = [gives_way, *(v.term(f) for v in (view, view.swapped) for f in text.domain.assume)]
    given += _on_a_reach(symbols) if reach else []

    def never(*terms: Term) -> bool:
        return ask_linear(symbols, [*given, *terms, *bounds_of(text, symbols)], budget).impossible

    def never_at_all(*terms: Term) -> bool:
        asked = [*given, *terms, *bounds_of(text, symbols)]
        limit = NONLINEAR_LIMIT if reach else NONLINEAR_LIMIT / 4.0
        return never(*terms) or ask_nonlinear(symbols, asked, budget, limit).impossible

    if never():
        return ["no ship ever gives way"]
    found: list[str] = []
    features = dict(_features(text, view))
    progress = True
    while progress:
        progress = False
        for name, (here, there) in list(features.items()):
            for word, first, second in ((name, here, there), (f"not {name}", z3.Not(here), z3.Not(there))):
                decide = never_at_all if "direction" in name else never
                if decide(z3.Not(first), second):  # who gives way never lacks what the other has
                    strict = not never(first, z3.Not(second))
                    del features[name]
                    given.append(here == there)
                    found += [word] if strict else []
                    progress = progress or strict
                    break
            if never():
                return found
    if never_at_all():
        return found
    last = _deciding_number(text, symbols, never_at_all, reach=reach)
    return None if last is None else [*found, last]


def _on_a_reach(symbols: Symbols) -> list[Term]:
    """Both ships sail along the axis, towards +x or towards -x, upbound and downbound apart."""
    found = []
    for ship in (A, B):
        up = symbols.sign(variable(f"{ship}.vx"), frozenset({1}))
        words = ("upbound", "downbound", "none")
        found.append(z3.Implies(symbols.choice(f"{ship}.direction", "upbound", words), up))
        found.append(z3.Implies(symbols.choice(f"{ship}.direction", "downbound", words), z3.Not(up)))
    return found


def _features(text: RulesetText, view: View) -> Iterator[tuple[str, tuple[Term, Term]]]:
    """What may rank single ships: definitions for one ship, and facts that conditions look at."""
    from ..tapd.language.compiler import Compiler

    compiler = Compiler(text.vocabulary, text.parameters, text.definitions, text.regimes, dict(text.tangents))
    for name, definition in text.definitions.items():
        if len(definition.ships) == 1:
            formula = compiler.condition(f"{name}(own)")
            if not facts_of(formula) & _OF_PAIRS:
                yield name, (view.term(formula), view.swapped.term(formula))
    seen: set[tuple[str, bool | str]] = set()
    for rule in text.rules:
        for part in walk(rule.condition):
            if isinstance(part, Test) and part.fact.startswith(("own.", "other.")):
                fact = part.fact.partition(".")[2]
                if (fact, part.value) not in seen:
                    seen.add((fact, part.value))
                    here = Test(f"own.{fact}", part.value)
                    label = fact if part.value is True else f"{fact} == {part.value}"
                    yield label, (view.term(here), view.swapped.term(here))


_OF_PAIRS: Final = frozenset(
    {"geometry", "overtaker", "has_other_on_starboard", "risk_of_collision", "rx", "ry"}
)


def _deciding_number(text: RulesetText, symbols: Symbols, never: Any, *, reach: bool) -> str | None:
    """A number that the ship that gives way has greater, or less, than the other, strictly."""
    amounts: dict[str, tuple[Polynomial, Polynomial]] = {}
    asked = {name for atom in symbols.atoms for name in atom.variables}
    for fact in text.vocabulary.by_scope[Scope.SHIP]:
        if fact.kind is FactKind.NUMBER and f"{A}.{fact.name}" in asked:
            amounts[fact.name] = (variable(f"{A}.{fact.name}"), variable(f"{B}.{fact.name}"))
    velocities = {ship: (variable(f"{ship}.vx"), variable(f"{ship}.vy")) for ship in (A, B)}
    amounts["speed"] = (dot(velocities[A], velocities[A]), dot(velocities[B], velocities[B]))
    for name, (here, there) in amounts.items():
        if never(symbols.sign(here - there, frozenset({-1, 0}))):
            return f"greater {name}"
        if never(symbols.sign(here - there, frozenset({0, 1}))):
            return f"less {name}"
    if reach and _behind(symbols, never):
        return "place along the reach, the ship behind gives way"
    return None


def _behind(symbols: Symbols, never: Callable[..., bool]) -> bool:
    """Whether the ship that gives way sails the same way as the other, and is behind it."""
    way = {ship: symbols.sign(variable(f"{ship}.vx"), frozenset({1})) for ship in (A, B)}
    ahead = symbols.sign(variable(f"{B}.x"), frozenset({1}))
    astern = symbols.sign(variable(f"{B}.x"), frozenset({-1}))
    return (
        never(way[A] != way[B])
        and never(way[A], way[B], z3.Not(ahead))
        and never(z3.Not(way[A]), z3.Not(way[B]), z3.Not(astern))
    )


# --- search ---------------------------------------------------------------------------------------


def _search(tally: Tally, ruleset: WrittenRuleset, shape: Shape, budget: Budget, max_ships: int) -> None:
    """Look for the smallest ring on waters of a shape."""
    most = max_ships if not shape.courses or shape.name == "a reach" else min(max_ships, len(shape.courses))
    for count in range(3, most + 1):
        rng = np.random.default_rng(count)
        for n in range(TRIES):
            if budget.spent:
                return
            case = _group(rng, ruleset.text, shape, count, alike=n % 3 == 0)
            if case is None or not _within(ruleset, case):
                continue
            found = ring(ruleset, case)
            if found is not None and len(found[0]) == count:
                _told(tally, ruleset, shape, case, found)
                return


def _told(
    tally: Tally, ruleset: WrittenRuleset, shape: Shape, case: Case, found: tuple[list[ShipId], list[Verdict]]
) -> None:
    case = plainer(case, lambda plain: _alike(ring(ruleset, plain), found) and _within(ruleset, plain))
    order, views = ring(ruleset, case) or found
    rules: tuple[Rule, ...] = tuple(ruleset.text.rule(id_) for id_ in dict.fromkeys(v.rule for v in views))
    names = " -> ".join([*order, order[0]])
    by = ", ".join(str(rule.citation) for rule in rules)
    title = f"{len(order)} ships give way in a ring on {shape.name}: {names}, by {by}"
    ships = Ships(case=replace(case, id=f"ring of {len(order)}"), verdicts=tuple(views), margin=0.0)
    tally.faults.append(Fault(title=title, rules=rules, ships=ships, kind="cycle"))


def _alike(one: tuple[list[ShipId], list[Verdict]] | None, other: tuple[list[ShipId], list[Verdict]]) -> bool:
    """Whether two rings are of the same ships by the same rules."""
    return one is not None and (one[0], [v.rule for v in one[1]]) == (other[0], [v.rule for v in other[1]])


def ring(ruleset: WrittenRuleset, case: Case) -> tuple[list[ShipId], list[Verdict]] | None:
    """The shortest ring of ships that give way to one another, and their verdicts; None without one."""
    graph: nx.DiGraph[ShipId] = nx.DiGraph()
    views: dict[tuple[ShipId, ShipId], Verdict] = {}
    masses = {ship.id: float(ship.facts.get("weight", 1.0)) for ship in case.ships}
    for one, other in combinations([ship.id for ship in case.ships], 2):
        facts = pair_facts(case, one, other, ruleset.vocabulary)
        settled = settle(ruleset.judge(facts), ruleset.judge(facts.mirrored()), masses)
        if settled.fallback or settled.one.kind not in (Kind.GIVE_WAY, Kind.STAND_ON):
            continue
        (first,), (then,) = settled.one.give_way, settled.one.stand_on
        graph.add_edge(first, then)
        views[first, then] = settled.one if settled.one.own == first else settled.other
    try:
        edges = nx.find_cycle(graph)
    except nx.NetworkXNoCycle:
        return None
    order = [edge[0] for edge in edges]
    shortest = min(nx.simple_cycles(graph, length_bound=len(order)), key=len, default=order)
    pairs = zip(shortest, [*shortest[1:], shortest[0]], strict=True)
    return list(shortest), [views[pair] for pair in pairs]


def _within(ruleset: WrittenRuleset, case: Case) -> bool:
    """Whether every two ships of a group keep to what the ruleset assumes."""
    assume = ruleset.text.domain.assume
    if not assume:
        return True
    decide = ruleset.assumptions
    for one, other in combinations([ship.id for ship in case.ships], 2):
        facts = pair_facts(case, one, other, ruleset.vocabulary)
        if not (decide(facts) and decide(facts.mirrored())):
            return False
    return True


def _group(
    rng: np.random.Generator, text: RulesetText, shape: Shape, count: int, *, alike: bool
) -> Case | None:
    """Ships that come near the middle of a water at about the same time."""
    low, high = (float(each) for each in text.domain.speed)
    courses: Sequence[float]
    if shape.courses and shape.name != "a reach":
        courses = [float(each) for each in rng.permutation(shape.courses)[:count]]
    elif shape.courses:
        courses = [float(rng.choice(shape.courses) + rng.uniform(-1, 1) * shape.spread) for _ in range(count)]
    else:
        courses = [float(rng.integers(0, 360)) for _ in range(count)]
    until = float(rng.uniform(80.0, 300.0))
    places = {}
    for n, course in enumerate(courses):
        speed = min(high, max(low, float(rng.integers(4, 13)) / 2.0))
        way = speed * until * (1.0 + 0.1 * rng.normal())
        aside = 15.0 * rng.normal()
        cos, sin = math.cos(math.radians(course)), math.sin(math.radians(course))
        places[f"S{n + 1}"] = (
            float(round(-way * cos - aside * sin)),
            float(round(-way * sin + aside * cos)),
            round(course, 1),
            speed,
        )
    apart = float(text.domain.separation)
    for one, other in combinations(places.values(), 2):
        if math.hypot(one[0] - other[0], one[1] - other[1]) < apart:
            return None
    return case_of(_facts(rng, text, list(places), alike=alike), places)


def _facts(rng: np.random.Generator, text: RulesetText, ships: Iterable[str], *, alike: bool) -> Facts:
    """Facts of a group: large motor ships that are all alike, or what the conditions look at, at random."""
    asked = {
        name.partition(".")[2]
        for rule in text.rules
        for name in facts_of(rule.condition)
        if name[:4] in ("own.", "othe")
    }
    waterway: dict[str, Any] = {}
    if rng.random() < 0.5:
        waterway |= {"type": "lake", "upstream_defined": False}
    if text.regimes and rng.random() < 0.3:
        waterway["regime"] = str(rng.choice(sorted(text.regimes)))
    base = {"length": 85.0 if rng.random() < 0.7 else 12.0, "beam": 9.0}
    by_ship: dict[str, dict[str, Any]] = {}
    for n, ship in enumerate(ships):
        facts: dict[str, Any] = {**base, "weight": 1e5 * (n + 1)}
        if not alike:
            facts["length"] = float(rng.choice(_LENGTHS))
            for fact in text.vocabulary.by_scope[Scope.SHIP]:
                if fact.name not in asked or rng.random() < 0.6:
                    continue
                if fact.kind is FactKind.FLAG:
                    facts[fact.name] = bool(rng.random() < 0.5)
                elif fact.kind is FactKind.CHOICE:
                    facts[fact.name] = str(rng.choice(fact.choices))
        by_ship[ship] = facts
    return Facts(by_ship, waterway, {})
