"""Random encounters against proofs: what is proved must hold for every one of them.

Facts are drawn of those that a ruleset asks for, with numbers at and beside the limits that it compares them
with; ships come near one another in all ways, exactly parallel and exactly alike among them.  Times to a
junction are drawn freely, as a chart would have them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from ..tapd.case_run import pair_facts
from ..tapd.cases import Case
from ..tapd.facts import PairFacts
from ..tapd.language.code import MOTION, program
from ..tapd.language.formula import Formula, Sign, facts_of, walk
from ..tapd.rules import Policy, RulesetText
from ..tapd.vocabulary import Fact, Kind, Scope
from ..tapd.written import WrittenRuleset
from ..verdict import Kind as Says
from ..verdict import Verdict, agree
from .search import A, B, Facts, case_of, meetings

_DENSITIES: Final = (0.02, 0.1, 0.5)  # of flags that are set
_TIMES: Final = (math.inf, math.inf, -5.0, 0.0, 10.0, 10.0, 120.0, 300.0, 900.0)  # [s]
_OWN_TIME, _OTHER_TIME = (MOTION.index(f"{ship}.time_to_intersection") for ship in ("own", "other"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """An encounter, what both ships recognise, and what they say of it."""

    case: Case
    facts: PairFacts
    seen: tuple[PairFacts, PairFacts]
    verdicts: tuple[Verdict, Verdict]


@dataclass(frozen=True, slots=True, kw_only=True)
class Asked:
    """What a ruleset asks for: facts by scope, regimes, and limits of numbers by the name of the fact."""

    ship: tuple[Fact, ...]
    waterway: tuple[Fact, ...]
    pair: tuple[Fact, ...]
    regimes: tuple[str, ...]
    limits: Mapping[str, tuple[float, ...]] = field(default_factory=dict)


def asked_by(text: RulesetText) -> Asked:
    """What the conditions of a ruleset look at."""
    formulas = [rule.condition for rule in text.rules]
    if text.recognition is not None:
        found = text.recognition
        formulas += [found.risk, found.overtaking, found.head_on, found.crossing, found.from_starboard]
    names = {name for formula in formulas for name in facts_of(formula)}
    names |= {name for formula in text.domain.assume for name in facts_of(formula)}
    tails = {name.partition(".")[2] for name in names if name.startswith(("own.", "other."))}
    by_scope = text.vocabulary.by_scope
    return Asked(
        ship=tuple(fact for fact in by_scope[Scope.SHIP] if fact.name in tails | {"length"}),
        waterway=tuple(
            fact
            for fact in by_scope[Scope.WATERWAY]
            if f"waterway.{fact.name}" in names and fact.name != "regime"
        ),
        pair=tuple(
            fact for fact in by_scope[Scope.PAIR] if fact.name in names and fact.name not in _RECOGNISED
        ),
        regimes=tuple(text.regimes),
        limits=_limits(text, formulas),
    )


_RECOGNISED: Final = ("risk_of_collision", "geometry", "overtaker", "has_other_on_starboard")


def _limits(text: RulesetText, formulas: Sequence[Formula]) -> dict[str, tuple[float, ...]]:
    """Numbers that single facts are compared with."""
    found: dict[str, set[float]] = {}
    for part in (part for formula in formulas for part in walk(formula)):
        if not isinstance(part, Sign):
            continue
        terms = dict(part.polynomial.with_values(text.constants).terms)
        offset = terms.pop((), None)
        if len(terms) == 1:
            ((monomial, factor),) = terms.items()
            if len(monomial) == 1 and "." in monomial[0]:
                name = monomial[0].partition(".")[2]
                found.setdefault(name, set()).add(float(-(offset or 0) / factor))
    return {name: tuple(sorted(values)) for name, values in found.items()}


def trials(ruleset: WrittenRuleset, count: int, seed: int, *, plain: bool = False) -> Iterator[Trial]:
    """Random encounters within the domain of a ruleset, judged from both sides.

    `plain` ones are as they come: nothing in them is set to a limit, or alike on purpose.
    """
    rng = np.random.default_rng(seed)
    text = ruleset.text
    asked = asked_by(text)
    if plain:
        asked = replace(asked, limits={})
    assumed = program(text.domain.assume, text.vocabulary, text.constants)
    speeds = (float(text.domain.speed[0]), float(text.domain.speed[1]))
    left = count
    while left > 0:
        for places in meetings(rng, speeds, float(text.domain.separation), 4 * left):
            varied = _plain(rng, places, speeds) if plain else _varied(rng, places)
            case = case_of(_facts(rng, asked, text), varied)
            facts = pair_facts(case, A, B, text.vocabulary)
            facts = facts if plain else _timed(rng, facts)
            turned = facts.mirrored()
            seen, own, swapped = ruleset.recognised(facts)
            if not all(
                d(*each[:5], [None] * assumed.memory) for d in assumed.decisions for each in (own, swapped)
            ):
                continue
            views = seen, ruleset.recognised(turned)[0]
            yield Trial(
                case=case, facts=facts, seen=views, verdicts=(ruleset.judge(facts), ruleset.judge(turned))
            )
            left -= 1
            if left == 0:
                return


def broken_by(trial: Trial, policy: Policy) -> Iterator[str]:
    """Properties that an encounter contradicts."""
    one, two = trial.verdicts
    here, there = trial.seen
    unique = policy is Policy.UNIQUE
    if agree(one, two) or (one.kind is Says.CONFLICT and not unique):
        yield "consistent"
    if one.kind is Says.CONFLICT and unique:
        yield "exclusive"
    silent = one.kind in (Says.NONE, Says.GAP) or one.kind is two.kind is Says.STAND_ON
    if here["risk_of_collision"] and silent:
        yield "complete"
    alike = (here["risk_of_collision"], here["geometry"]) == (there["risk_of_collision"], there["geometry"])
    overtake = here["overtaker"] == there["overtaker"] == "own"
    starboard = here["has_other_on_starboard"] == there["has_other_on_starboard"] == "own"
    if not alike or overtake or (starboard and here["geometry"] != "none"):
        yield "mirror_sound"


def contradictions(ruleset: WrittenRuleset, count: int, seed: int) -> dict[str, Trial]:
    """Properties that random encounters contradict, each with the first that does."""
    found: dict[str, Trial] = {}
    for trial in trials(ruleset, count, seed):
        for name in broken_by(trial, ruleset.text.policy):
            found.setdefault(name, trial)
    return found


# -- drawing --------------------------------------------------------------------------------------


def _facts(rng: np.random.Generator, asked: Asked, text: RulesetText) -> Facts:
    density = float(rng.choice(_DENSITIES))
    ships: dict[str, dict[str, Any]] = {A: {}, B: {}}
    for values in ships.values():
        values |= {fact.name: _value(rng, fact, density, asked, text) for fact in asked.ship}
        values.setdefault("beam", 10.0)
    for name in ships[A]:
        if rng.random() < 0.3:  # ships that are alike
            ships[B][name] = ships[A][name]
    waterway = {fact.name: _value(rng, fact, 0.2, asked, text) for fact in asked.waterway}
    waterway["regime"] = " ".join(name for name in asked.regimes if rng.random() < 0.2)
    pair = {fact.name: _value(rng, fact, 0.5, asked, text) for fact in asked.pair}
    return Facts(ships, waterway, pair)


def _value(
    rng: np.random.Generator, fact: Fact, density: float, asked: Asked, text: RulesetText
) -> bool | str | float:
    if fact.kind is Kind.FLAG:
        return bool(rng.random() < density)
    if fact.kind is Kind.CHOICE:
        if isinstance(fact.default, str) and rng.random() < 0.4:
            return fact.default
        return str(rng.choice(fact.choices))
    if fact.kind is Kind.NUMBER:
        low, high = text.domain.length if fact.name == "length" else (0, 200)
        limits = asked.limits.get(fact.name, ())
        if limits and rng.random() < 0.7:
            limit = float(rng.choice(limits))
            beside = (math.nextafter(limit, -math.inf), limit, math.nextafter(limit, math.inf))
            number = float(rng.choice([*beside, limit - 1.0, limit + 1.0]))
            return min(max(number, float(low)), float(high)) if fact.name == "length" else max(number, 0.0)
        return float(rng.integers(int(low), int(high) + 1))
    return ""


def _varied(
    rng: np.random.Generator, places: Mapping[str, tuple[float, float, float, float]]
) -> dict[str, tuple[float, float, float, float]]:
    """Places as they are, off the grid, or with ships of one speed."""
    varied = dict(places)
    north, east, course, speed = varied[B]
    draw = rng.random()
    if draw < 0.3:
        varied[B] = (north + rng.normal(), east + rng.normal(), course + rng.normal(), speed)
    elif draw < 0.45:
        varied[B] = (north, east, course, varied[A][3])
    return varied


def _plain(
    rng: np.random.Generator,
    places: Mapping[str, tuple[float, float, float, float]],
    speeds: tuple[float, float],
) -> dict[str, tuple[float, float, float, float]]:
    """Places, courses and speeds off the grid."""
    moved = {}
    for ship, (north, east, course, speed) in places.items():
        n, e, c, s = (float(each) for each in rng.uniform(-1.0, 1.0, 4))
        near = min(max(speed + 0.25 * s, speeds[0]), speeds[1])
        moved[ship] = (north + 10.0 * n, east + 10.0 * e, course + 10.0 * c, near)
    return moved


def _timed(rng: np.random.Generator, facts: PairFacts) -> PairFacts:
    """Times to a junction as a chart may have them."""
    if rng.random() < 0.5:
        return facts
    motion = list(facts.motion)
    motion[_OWN_TIME], motion[_OTHER_TIME] = (float(each) for each in rng.choice(_TIMES, 2))
    return replace(facts, motion=tuple(motion))
