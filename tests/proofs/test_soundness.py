"""What is proved holds at sea: random encounters contradict nothing, and a condition has one meaning."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import z3

from ccas_core.proofs.findings import Outcome
from ccas_core.proofs.questions import FRAME
from ccas_core.proofs.search import A, B, Facts, case_of, judged
from ccas_core.proofs.symbols import Symbols, Term, View, constants_of, real_term
from ccas_core.proofs.trials import Trial, contradictions, trials
from ccas_core.ships import UNKNOWN
from ccas_core.tapd.facts import PairFacts
from ccas_core.tapd.language.code import MOTION, Missing, program
from ccas_core.tapd.language.formula import Sign, walk
from ccas_core.tapd.rules import RulesetText
from ccas_core.tapd.vocabulary import Scope
from ccas_core.tapd.written import WrittenRuleset
from ccas_core.verdict import Kind, agree

from .rulesets import BROKEN, broken, finding, installed, shipped

SHIPPED = (
    "bpr", "ccnr", "cevni", "cn_inland", "colregs", "de_binsch", "de_danube", "de_seesch", "tran2026",
    "tran2026_printed", "us_inland",
)  # fmt: skip
REPAIRED = sorted(path.stem for path in BROKEN.glob("*.repaired.yaml"))
SHARE = 500  # encounters of each shipped ruleset; `studies/soundness.py` tries the million


@pytest.mark.parametrize("name", SHIPPED)
def test_no_random_encounter_contradicts_what_is_proved_of_a_shipped_ruleset(name: str) -> None:
    waived = {waiver.check for waiver in shipped(name).text.waivers}  # faults of the law, told as such

    for property_, trial in contradictions(shipped(name), SHARE, seed=1).items():
        assert property_ in waived or finding(shipped(name), property_).outcome is not Outcome.PROVED, (
            property_,
            trial,
        )


@pytest.mark.parametrize("name", REPAIRED)
def test_no_random_encounter_contradicts_what_is_proved_of_a_repaired_ruleset(name: str) -> None:
    for property_, trial in contradictions(broken(name), 60, seed=2).items():
        assert finding(broken(name), property_).outcome is not Outcome.PROVED, (property_, trial)


@pytest.mark.parametrize(
    ("name", "property_"),
    [
        ("both_privileged", "consistent"),
        ("equal_ships", "consistent"),
        ("class_forgotten", "complete"),
        ("head_on_seen_by_one", "mirror_sound"),
        ("not_exclusive", "exclusive"),
        ("starboard_for_both", "mirror_sound"),
    ],
)
def test_random_encounters_would_notice_a_fault(name: str, property_: str) -> None:
    assert property_ in contradictions(broken(name), 2000, seed=6)


@pytest.mark.parametrize(
    ("name", "rule"),
    [("dead_rule", "fishing"), ("dead_by_union", "convoy"), ("exception_swallows", "ferry")],
)
def test_no_random_encounter_is_decided_by_a_rule_that_is_told_to_be_dead(name: str, rule: str) -> None:
    decided = Counter(trial.verdicts[0].rule for trial in trials(broken(name), 400, seed=3))

    assert rule not in decided
    assert len(decided) > 3


def test_random_encounters_reach_most_rules_of_a_large_ruleset() -> None:
    decided = Counter(trial.verdicts[0].rule for trial in trials(shipped("bpr"), 1000, seed=4))

    assert len(decided) > 25, decided


@pytest.mark.parametrize("name", ["bpr", "tran2026", "equal_ships", "limit_shifted", "passengers_overlap"])
def test_a_condition_means_the_same_to_the_solver_at_sea_and_in_fractions(name: str) -> None:
    ruleset = broken(name) if (BROKEN / f"{name}.yaml").exists() else shipped(name)
    text = ruleset.text
    view = View(Symbols(), text, A, B, constants_of(text, free=False))
    compiled = program([rule.condition for rule in text.rules], text.vocabulary, text.constants)

    for trial in trials(ruleset, 25, seed=5):
        _, own, _ = ruleset.recognised(trial.facts)
        terms = [view.term(rule.condition) for rule in text.rules]
        meant = Meaning(view.symbols, trial.facts)
        for rule, term, decide in zip(text.rules, terms, compiled.decisions, strict=True):
            at_sea = decide(*own[:5], [None] * compiled.memory)

            assert meant.says(term) == at_sea, (rule.id, trial)
        assert_signs_are_exact(text, trial)


def test_the_frame_of_the_proofs_changes_no_sign() -> None:
    """Polynomials are the same wherever the ships are and whichever way they look."""
    text = shipped("bpr").text
    free, framed = Symbols(), Symbols(fixed=dict(FRAME))
    for symbols in (free, framed):
        view = View(symbols, text, A, B, constants_of(text, free=False))
        for rule in text.rules:
            view.term(rule.condition)

    assert len(framed.atoms) <= len(free.atoms)


DRAUGHT = """
  - id: shallow
    cite: {article: "§ 2", text: A ferry of little draught waits for ships that are none}
    when: own.draught < 3 m and risk and crossing and own.ferry and not other.ferry
    then: give_way
    replaces: ferry
"""


def test_ships_agree_though_a_number_that_one_of_them_looks_at_first_is_not_known(tmp_path: Path) -> None:
    file = tmp_path / "shallow.yaml"
    head = (BROKEN / "exception_swallows.repaired.yaml").read_text(encoding="utf-8").partition("rules:")[0]
    head = head.replace("extends: exception", f"extends: {BROKEN}/exception")
    file.write_text(f"{head}rules:{DRAUGHT}", encoding="utf-8")
    ruleset = installed().rulesets.loaded(file)
    assert isinstance(ruleset, WrittenRuleset)
    places: dict[str, tuple[float, float, float, float]] = {
        A: (0.0, 0.0, 0.0, 3.0),
        B: (300.0, 300.0, 270.0, 3.0),
    }
    ships: dict[str, dict[str, Any]] = {
        A: {"length": 50.0, "ferry": True, "draught": 2.0},
        B: {"length": 50.0},
    }

    one, two = judged((ruleset, ruleset), case_of(Facts(ships, {}, {}), places))

    assert finding(ruleset, "consistent").outcome is Outcome.PROVED
    assert (one.kind, one.rule) == (Kind.GIVE_WAY, "shallow")
    assert agree(one, two) == ""


@pytest.mark.parametrize("name", ["bpr", "colregs", "tran2026"])
def test_ships_agree_though_facts_are_not_known(name: str) -> None:
    draw = np.random.default_rng(11)
    ruleset = shipped(name)

    for trial in trials(ruleset, 200, seed=12):
        ships = tuple(replace(ship, facts=_forgotten(ship.facts, draw)) for ship in trial.case.ships)
        one, two = judged((ruleset, ruleset), replace(trial.case, ships=ships))

        assert agree(one, two) == "", (one, two)


def _forgotten(facts: Mapping[str, Any], draw: np.random.Generator) -> dict[str, Any]:
    return {
        name: UNKNOWN if name != "length" and draw.random() < 0.15 else value for name, value in facts.items()
    }


def assert_signs_are_exact(text: RulesetText, trial: Trial) -> None:
    """Numeric conditions have the sign of the exact value, not of a rounded one."""
    signs = [part for rule in text.rules for part in walk(rule.condition) if isinstance(part, Sign)]
    compiled = program(signs, text.vocabulary, text.constants)
    facts = trial.facts
    values = exact_values(facts)
    arguments = (facts.own_values, facts.other_values, facts.waterway_values, facts.pair_values, facts.motion)
    for part, decide in zip(signs, compiled.decisions, strict=True):
        polynomial = part.polynomial.with_values(text.constants)
        if any(isinstance(values.get(name), Missing) for name in polynomial.variables):
            continue
        value = polynomial.evaluated(values, Fraction)

        assert decide(*arguments, [None] * compiled.memory) == ((value > 0) - (value < 0) in part.signs)


def exact_values(facts: PairFacts) -> dict[str, Any]:
    """Values of the variables of polynomials, exactly."""
    motion = dict(zip(MOTION, facts.motion, strict=True))
    exact = {name: Fraction(value) for name, value in motion.items() if "time" not in name}
    exact["rx"], exact["ry"] = exact["tx"] - exact["ox"], exact["ty"] - exact["oy"]
    exact["wx"], exact["wy"] = exact["tvx"] - exact["ovx"], exact["tvy"] - exact["ovy"]
    named: dict[str, Any] = dict(exact)
    for owner, values in (("own", facts.own_values), ("other", facts.other_values)):
        for name, place in facts.vocabulary.places[Scope.SHIP].items():
            named[f"{owner}.{name}"] = _exact(values[place])
    for name, place in facts.vocabulary.places[Scope.WATERWAY].items():
        named[f"waterway.{name}"] = _exact(facts.waterway_values[place])
    return named


def _exact(value: object) -> object:
    return Fraction(value) if isinstance(value, int | float) else value


class Meaning:
    """Values of everything in some terms, from the facts of an encounter."""

    def __init__(self, symbols: Symbols, facts: PairFacts) -> None:
        self._symbols, self._facts = symbols, facts
        self._numbers = {
            f"{ship}.{tail}": value
            for owner, ship in (("own", A), ("other", B))
            for name, value in exact_values(facts).items()
            for head, _, tail in [name.partition(".")]
            if head == owner
        }
        motion = dict(zip(MOTION, facts.motion, strict=True))
        for ship, at, towards in ((A, ("ox", "oy"), ("ovx", "ovy")), (B, ("tx", "ty"), ("tvx", "tvy"))):
            names = zip(("x", "y", "vx", "vy"), (*at, *towards), strict=True)
            self._numbers |= {f"{ship}.{name}": Fraction(motion[each]) for name, each in names}
        for owner, ship in (("own", A), ("other", B)):
            time = motion[f"{owner}.time_to_intersection"]
            self._numbers[f"{ship}.time_to_intersection"] = Fraction(10**9) if time > 1e9 else Fraction(time)
        self._numbers |= {n: v for n, v in exact_values(facts).items() if n.startswith("waterway.")}
        self._put = self._values()

    def says(self, term: Term) -> bool:
        """Value of a term."""
        return bool(z3.is_true(z3.simplify(z3.substitute(term, *self._put))))

    def _values(self) -> list[tuple[Any, Any]]:
        put = [(z3.Bool(name), z3.BoolVal(self._flag(name))) for name in self._symbols.flags]
        put += [
            (flag, z3.BoolVal(not isinstance(self._value(name), Missing)))
            for name, flag in self._symbols.known.items()
        ]
        for atom in self._symbols.atoms.values():
            names = sorted(atom.polynomial.variables)
            if any(not isinstance(self._numbers[name], Fraction) for name in names):
                continue
            values = [
                (z3.Real(n), z3.RatVal(self._numbers[n].numerator, self._numbers[n].denominator))
                for n in names
            ]
            value = z3.simplify(z3.substitute(real_term(atom.polynomial), *values))
            sign = value.numerator_as_long()
            put += [(atom.positive, z3.BoolVal(sign > 0)), (atom.negative, z3.BoolVal(sign < 0))]
        return put

    def _flag(self, name: str) -> bool:
        fact, is_, word = name.partition("=")
        value = self._value(fact)
        if fact == "waterway.regime":
            return isinstance(value, frozenset) and word in value
        return bool(value == word) if is_ else value is True

    def _value(self, fact: str) -> object:
        owner, _, tail = fact.partition(".")
        facts, places = self._facts, self._facts.vocabulary.places
        if owner == "waterway":
            return facts.waterway_values[places[Scope.WATERWAY][tail]]
        if owner in (A, B):
            return (facts.own_values if owner == A else facts.other_values)[places[Scope.SHIP][tail]]
        return facts.pair_values[places[Scope.PAIR][tail]]
