"""Compiled conditions: always the sign of the exact value, and the same for both ships."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from ccas_core.ships import UNKNOWN
from ccas_core.tapd.facts import GRID, PairFacts, motion
from ccas_core.tapd.language import code
from ccas_core.tapd.language.code import (
    MOTION,
    Missing,
    UnknownFact,
    Values,
    exact_sign,
    program,
    rounding_bound,
)
from ccas_core.tapd.language.formula import Before, Formula, all_of, any_of, mirrored, sign
from ccas_core.tapd.language.polynomial import Polynomial, number, variable
from ccas_core.tapd.vocabulary import VOCABULARY, Scope

from .. import A, B, stated
from . import PLAIN, Language, decided, random_facts, values_of

FACTS = ("own.length", "own.beam", "own.draught", "other.length", "other.beam", "other.draught")
RAW = ("rx", "ry", "wx", "wy", "ovx", "ovy", "tvx", "tvy")
SIGNS = ((-1,), (0,), (1,), (-1, 0), (0, 1), (-1, 1))


def exact(name: str, facts: PairFacts) -> Fraction:
    """Value of a variable, without any rounding."""
    differences = {"rx": ("tx", "ox"), "ry": ("ty", "oy"), "wx": ("tvx", "ovx"), "wy": ("tvy", "ovy")}
    if name in differences:
        one, other = (Fraction(facts.motion[MOTION.index(each)]) for each in differences[name])
        return one - other
    return Fraction(facts[name])


def exact_value(polynomial: Polynomial, facts: PairFacts) -> Fraction:
    return polynomial.evaluated(
        {name: exact(name, facts) for name in polynomial.variables}, lambda each: each
    )


def random_polynomial(generator: np.random.Generator, names: tuple[str, ...]) -> Polynomial:
    found = Polynomial(())
    for _ in range(int(generator.integers(1, 6))):
        factor = Fraction(int(generator.integers(-50, 51)), int(generator.integers(1, 12)))
        term = number(factor)
        for name in generator.choice(names, int(generator.integers(0, 4))):
            term = term * variable(str(name))
        found = found + term
    return found


def measured(generator: np.random.Generator) -> PairFacts:
    """Ships with any floats for lengths, and positions and velocities on the grid."""
    sizes = [
        {name: float(generator.lognormal(3.0, 2.0)) for name in ("length", "beam", "draught")} for _ in (A, B)
    ]
    facts = stated(sizes[0], sizes[1])
    one, two = (
        (float(generator.normal(0, 900)), float(generator.normal(0, 900)), float(generator.uniform(-4, 4)))
        for _ in (A, B)
    )
    return replace(
        facts, motion=motion(one, float(generator.uniform(0, 8)), two, float(generator.uniform(0, 8)))
    )


def check(polynomial: Polynomial, facts: PairFacts) -> int:
    """Compare all tests of a sign with the exact value; return the sign."""
    value = exact_value(polynomial, facts)
    found = (value > 0) - (value < 0)
    for signs in SIGNS:
        assert decided(sign(polynomial, *signs), facts) is (found in signs), (polynomial, signs, value)
    return found


# --- exactness ------------------------------------------------------------------------------------


@pytest.mark.parametrize("names", [FACTS, RAW, (*FACTS, *RAW)], ids=["facts", "motion", "both"])
def test_compiled_sign_is_that_of_the_exact_value_on_random_input(names: tuple[str, ...]) -> None:
    generator = np.random.default_rng(1)
    for _ in range(120):
        check(random_polynomial(generator, names), measured(generator))


def test_compiled_sign_is_that_of_the_exact_value_where_it_is_nearly_zero() -> None:
    """One length is put as near to a root as floats go: then the rounding is greater than the value."""
    generator = np.random.default_rng(2)
    seen = {-1: 0, 0: 0, 1: 0}
    for _ in range(250):
        facts = measured(generator)
        rest = random_polynomial(generator, (*FACTS[1:], *RAW))
        slope = random_polynomial(generator, FACTS[1:3])
        at, by = exact_value(rest, facts), exact_value(slope, facts)
        if by == 0:
            continue
        root = float(-at / by)
        for near in (root, math.nextafter(root, math.inf), math.nextafter(root, -math.inf)):
            placed = replace(facts, own_values=_with(facts.own_values, "length", near))
            seen[check(slope * variable("own.length") + rest, placed)] += 1
    assert seen[-1] > 50 < seen[1]


def test_compiled_sign_is_zero_on_exact_roots() -> None:
    generator = np.random.default_rng(3)
    for _ in range(100):
        facts = measured(generator)
        names = [str(name) for name in generator.choice(FACTS, 2)]
        a, b = (variable(name) for name in names)
        root = number(Fraction(facts[names[0]])) * b - a * number(Fraction(facts[names[1]]))
        assert check(root, facts) == 0
        assert check(root + number(Fraction(1, 10**30)), facts) == 1
        assert check(root - number(Fraction(1, 10**30)), facts) == -1


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1e-160, 1e160, 1e200, 1e308])
def test_products_too_small_or_too_large_for_floats_are_decided_all_the_same(size: float) -> None:
    facts = stated({"length": size, "beam": size, "draught": math.nextafter(size, math.inf)})
    length, beam, draught = (variable(f"own.{name}") for name in ("length", "beam", "draught"))

    assert check(length * beam, facts) == 1
    assert check(length * beam - draught * draught, facts) == -1
    assert check(length * length - beam * beam, facts) == 0
    assert check(length * number(Fraction(1, 3)) - beam * number(Fraction(1, 3)), facts) == 0


def test_difference_of_positions_is_taken_exactly() -> None:
    """The rounded difference is 10^16, the exact one is 1 less."""
    facts = stated(at=((0, 0, 0, 3), (0, 0, 90, 3)))
    values = list(facts.motion)
    values[MOTION.index("ox")], values[MOTION.index("tx")] = 1.0, 1e16
    values[MOTION.index("rx")] = 1e16 - 1.0
    far = replace(facts, motion=tuple(values))

    assert values[MOTION.index("rx")] == 1e16 - 1.0
    assert check(variable("rx") - number(10**16 - 1), far) == 0


def test_limit_that_no_float_is_decides_between_floats() -> None:
    """0.1 m is no float: the float 0.1 is greater."""
    assert not PLAIN.decide("own.length <= 0.1 m")(stated({"length": 0.1}))
    assert PLAIN.decide("own.length > 0.1 m")(stated({"length": 0.1}))
    assert PLAIN.decide("own.length < 0.1 m")(stated({"length": math.nextafter(0.1, 0.0)}))


def test_limit_that_is_a_float_is_compared_at_once() -> None:
    decide = program([PLAIN.formula("own.length < 20 m")], VOCABULARY, {})

    assert decide.memory == 0
    for length, expected in ((math.nextafter(20.0, 0.0), True), (20.0, False), (20.5, False)):
        assert decide.decisions[0](*values_of(stated({"length": length})), []) is expected


def test_bound_grows_with_the_degree_and_the_number_of_terms() -> None:
    x, y = variable("own.length"), variable("own.beam")

    assert rounding_bound(x) < rounding_bound(x * x) < rounding_bound(x * x + x * y + y * y)
    assert rounding_bound(x * x * x * x + y) < 1e-14


def test_exact_sign_is_asked_only_where_floats_do_not_decide(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def counted(polynomial: Polynomial, values: object) -> int:
        asked.append(polynomial)
        return exact_sign(polynomial, values)  # type: ignore[arg-type]

    monkeypatch.setattr(code, "exact_sign", counted)
    decide = PLAIN.decide("own.length * 3 < other.length")

    assert decide(stated({"length": 0.1}, {"length": 0.31}))
    assert not asked
    assert not decide(stated({"length": 0.1}, {"length": 0.3}))
    assert len(asked) == 1


# --- the same for both ships ----------------------------------------------------------------------


def test_both_ships_get_the_same_sign() -> None:
    generator = np.random.default_rng(4)
    for n in range(150):
        polynomial = random_polynomial(generator, (*FACTS, *RAW))
        facts = measured(generator) if n % 2 else random_facts(generator)
        if n % 2 == 0:
            polynomial = random_polynomial(generator, (*RAW, "own.length", "other.length"))
        for signs in SIGNS:
            formula = sign(polynomial, *signs)
            assert decided(mirrored(formula), facts.mirrored()) is decided(formula, facts)


def test_motion_is_on_a_grid_so_that_both_ships_compute_with_the_same_numbers() -> None:
    generator = np.random.default_rng(5)
    for _ in range(200):
        facts = measured(generator)
        for name in RAW:
            value = facts.motion[MOTION.index(name)]
            assert value == round(value / GRID) * GRID
            assert Fraction(value) == exact(name, facts)  # differences on the grid are exact


# --- what is evaluated, and how often ---------------------------------------------------------------


def test_conditions_that_share_a_comparison_evaluate_it_once() -> None:
    language = Language(definitions={"near": ((), "tcpa < 60 s and distance < 300 m")})
    formulas = [language.formula(text) for text in ("near and own.ferry", "near or tcpa < 60 s", "not near")]

    assert program(formulas, VOCABULARY, {}).memory == program(formulas[:1], VOCABULARY, {}).memory


def test_memory_of_one_call_does_not_reach_the_next() -> None:
    decide = PLAIN.decide("own.length * 3 < other.length")

    assert [decide(stated({"length": 1.0}, {"length": size})) for size in (2.0, 4.0, 2.0)] == [
        False,
        True,
        False,
    ]


def test_before_is_refused_with_a_limit_that_depends_on_facts() -> None:
    formula = Before("own.time_to_intersection", variable("own.length"), strict=True)

    with pytest.raises(ValueError, match="a limit that depends on facts"):
        program([formula], VOCABULARY, {})


def test_set_of_flags_is_asked_for_one_of_them() -> None:
    decide = Language(regimes=("tidal", "canal")).decide("regime.tidal and not regime.canal")

    assert decide(stated(waterway={"regime": "tidal other"}))
    assert not decide(stated(waterway={"regime": "tidal canal"}))
    assert not decide(stated(waterway={"regime": ""}))


# --- what is not known ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        "own.wind_side == port",
        "own.wind_side != port",
        "own.wind_side == other.wind_side",
        "own.draught < 3 m",
        "own.draught * 2 > other.length",
        "own.draught < other.draught",
        "own.ferry",
        "not own.ferry",
    ],
)
def test_fact_that_is_not_known_is_told_when_it_is_looked_at(text: str) -> None:
    unknown = {"wind_side": UNKNOWN, "draught": UNKNOWN, "ferry": UNKNOWN}

    with pytest.raises(UnknownFact) as caught:
        PLAIN.decide(text)(stated(unknown, {"length": 20.0, "draught": 1.0, "wind_side": "port"}))
    assert caught.value.missing.owner == A
    assert caught.value.missing.name in text


def test_motion_that_is_not_known_is_told() -> None:
    with pytest.raises(UnknownFact) as caught:
        PLAIN.decide("tcpa < 60 s")(stated())
    assert caught.value.missing.owner == "pair"


@pytest.mark.parametrize(
    "text", ["false and own.ferry", "other.ferry and own.ferry", "not other.ferry or own.ferry"]
)
def test_fact_that_is_not_looked_at_need_not_be_known(text: str) -> None:
    PLAIN.decide(text)(stated({"ferry": UNKNOWN}, {"ferry": False}))


def test_known_asks_whether_a_fact_is_known_and_never_fails() -> None:
    decide = PLAIN.decide("known(own.ferry)")

    assert decide(stated({"ferry": False}))
    assert not decide(stated({"ferry": UNKNOWN}))


def test_what_is_missing_cannot_be_used_for_anything() -> None:
    missing = Missing("a", "draught")

    assert repr(missing) == "unknown"
    for use in (
        lambda: missing + 1, lambda: 1 - missing, lambda: missing * 2, lambda: missing < 3,
        lambda: missing >= 3,
        lambda: missing == 3, lambda: missing != 3, lambda: bool(missing), lambda: float(missing),
        lambda: 3 in missing, lambda: abs(missing), lambda: -missing, lambda: {missing},
    ):  # fmt: skip
        with pytest.raises(UnknownFact, match="draught"):
            use()


def test_empty_junctions_are_compiled() -> None:
    empty: list[Formula] = []

    assert decided(all_of(empty), stated())
    assert not decided(any_of(empty), stated())


def _with(values: Values, name: str, value: float) -> Values:
    place = VOCABULARY.places[Scope.SHIP][name]
    return (*values[:place], value, *values[place + 1 :])
