"""Formulas and polynomials: swapped twice they are as before, swapped once they say it of the other."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ccas_core.tapd.language.formula import (
    FALSE,
    TRUE,
    And,
    Formula,
    Known,
    Not,
    Or,
    Same,
    alike,
    all_of,
    any_of,
    facts_of,
    is_too_large,
    mirrored,
    negated,
    sign,
    walk,
)
from ccas_core.tapd.language.formula import Test as HasValue
from ccas_core.tapd.language.polynomial import Polynomial, canonical, mirrored_name, number, variable

from .. import ruleset
from . import Language, decided, random_facts

NAMES = (
    "rx",
    "ry",
    "wx",
    "wy",
    "ovx",
    "ovy",
    "tvx",
    "tvy",
    "own.length",
    "other.length",
    "own.passengers_max",
)
TEXTS = (
    "own.ferry and not other.ferry",
    "own.length < 20 m",
    "own.length < other.length",
    "own.length * 2 + 3 m >= other.length",
    "own.propulsion == sail",
    "own.propulsion == other.propulsion",
    "own.wind_side != other.wind_side",
    "overtaker == own",
    "overtaker == none",
    "has_other_on_starboard in (own, none)",
    "geometry == crossing",
    "waterway.current == none",
    "closing",
    "tcpa < 60 s",
    "dcpa <= 100 m",
    "distance > 300 m",
    "own.speed > other.speed",
    "other.speed <= 3 m/s",
    "course_difference > 22.5 deg",
    "bearing(own, other) > 22.5 deg",
    "bearing(own, other) <= -112.5 deg",
    "abs(bearing(other, own)) > 112.5 deg",
    "from_starboard(own, other)",
    "known(own.wind_side)",
    "own.time_to_intersection < other.time_to_intersection",
)
FACTS = [random_facts(np.random.default_rng(seed)) for seed in range(60)]
FORMULAS = [Language().formula(text) for text in TEXTS]

leaves = st.sampled_from(FORMULAS)
formulas = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.builds(negated, inner),
        st.lists(inner, min_size=1, max_size=3).map(all_of),
        st.lists(inner, min_size=1, max_size=3).map(any_of),
    ),
    max_leaves=6,
)
coefficients = st.fractions(-5, 5, max_denominator=7)
polynomials = st.lists(st.tuples(st.lists(st.sampled_from(NAMES), max_size=3), coefficients), max_size=4).map(
    lambda terms: sum(
        (number(factor) * product([variable(name) for name in names]) for names, factor in terms),
        start=Polynomial(()),
    )
)


def product(factors: list[Polynomial]) -> Polynomial:
    found = number(1)
    for factor in factors:
        found = found * factor
    return found


# --- swapped --------------------------------------------------------------------------------------


@pytest.mark.parametrize("formula", FORMULAS, ids=TEXTS)
def test_condition_swapped_twice_is_itself(formula: Formula) -> None:
    assert mirrored(mirrored(formula)) == formula


@given(formulas)
@settings(derandomize=True, max_examples=150, deadline=None)
def test_any_formula_swapped_twice_is_itself(formula: Formula) -> None:
    assert mirrored(mirrored(formula)) == formula


@given(formulas, st.sampled_from(FACTS))
@settings(derandomize=True, max_examples=250, deadline=None)
def test_swapped_formula_says_of_the_swapped_ships_what_the_formula_says_of_them(
    formula: Formula, facts: object
) -> None:
    assert decided(mirrored(formula), facts.mirrored()) is decided(formula, facts)  # type: ignore[attr-defined,arg-type]


@pytest.mark.parametrize("name", ["tran2026", "tran2026_printed", "bpr"])
def test_every_rule_says_of_the_swapped_ships_what_its_mirror_says(name: str) -> None:
    for rule in ruleset(name).text.rules:
        assert mirrored(mirrored(rule.condition)) == rule.condition


def test_fact_of_the_pair_that_names_a_ship_names_the_other_when_swapped() -> None:
    assert mirrored(HasValue("overtaker", "own")) == HasValue("overtaker", "other")
    assert mirrored(HasValue("overtaker", "none")) == HasValue("overtaker", "none")
    assert mirrored(HasValue("another_ship", "own")) == HasValue("another_ship", "other")  # of a plugin


# --- joined ---------------------------------------------------------------------------------------

A, B, C = (HasValue(f"own.{name}", value=True) for name in ("ferry", "convoy", "nuc"))


def test_what_is_always_or_never_so_is_left_out() -> None:
    assert all_of([]) == all_of([TRUE]) == TRUE
    assert any_of([]) == any_of([FALSE]) == FALSE
    assert all_of([A, TRUE]) == any_of([A, FALSE]) == A
    assert all_of([A, FALSE]) == FALSE
    assert any_of([A, TRUE]) == TRUE
    assert negated(negated(A)) == A
    assert negated(TRUE) == FALSE
    assert sign(number(-2), -1) == TRUE
    assert sign(number(0), -1, 1) == FALSE


def test_formulas_are_alike_but_for_order_and_names() -> None:
    assert alike(And((A, B)), And((B, A)))
    assert alike(Or((A, And((B, C)))), Or((And((C, B)), A)))
    assert alike(Same("own.a", "other.a"), Same("other.a", "own.a"))
    assert alike(Not(And((A, B))), Not(And((B, A))))
    assert not alike(And((A, B)), Or((A, B)))
    assert not alike(A, B)
    named = Language(definitions={"d": ((), "own.ferry")}).formula("d")
    assert alike(named, A)


def test_all_parts_and_facts_are_found() -> None:
    formula = Not(Or((A, And((Known("other.beam"), Same("own.wind_side", "other.wind_side"))))))

    assert sum(1 for _ in walk(formula)) == 6
    assert facts_of(formula) == {"own.ferry", "other.beam", "own.wind_side", "other.wind_side"}
    language = Language(parameters={"limit": ("3", "s")})
    assert facts_of(language.formula("tcpa < limit")) == {"rx", "ry", "wx", "wy", "parameter.limit"}
    assert facts_of(language.formula("own.time_to_intersection < limit")) == {
        "own.time_to_intersection",
        "parameter.limit",
    }


def test_size_of_a_formula_is_bounded_by_parts_and_by_depth() -> None:
    flat = And((A, B, C))
    deep = Not(And((A, Or((B, Not(C))))))

    assert not is_too_large(flat, 4, 2)
    assert is_too_large(flat, 3, 2)
    assert is_too_large(flat, 4, 1)
    assert not is_too_large(deep, 7, 5)
    assert is_too_large(deep, 7, 4)


# --- polynomials ----------------------------------------------------------------------------------


@given(polynomials, polynomials, polynomials)
@settings(derandomize=True, max_examples=100, deadline=None)
def test_polynomials_are_a_ring(a: Polynomial, b: Polynomial, c: Polynomial) -> None:
    assert a + b == b + a
    assert a * b == b * a
    assert (a + b) + c == a + (b + c)
    assert a * (b + c) == a * b + a * c
    assert a - a == Polynomial(())
    assert (a - a).constant == 0


@given(polynomials)
@settings(derandomize=True, max_examples=100, deadline=None)
def test_polynomial_swapped_twice_is_itself(polynomial: Polynomial) -> None:
    assert polynomial.mirrored().mirrored() == polynomial


@given(polynomials, polynomials)
@settings(derandomize=True, max_examples=100, deadline=None)
def test_swapping_goes_through_sums_and_products(a: Polynomial, b: Polynomial) -> None:
    assert (a + b).mirrored() == a.mirrored() + b.mirrored()
    assert (a * b).mirrored() == a.mirrored() * b.mirrored()


@given(polynomials, st.lists(coefficients, min_size=len(NAMES), max_size=len(NAMES)))
@settings(derandomize=True, max_examples=100, deadline=None)
def test_value_is_that_of_the_terms_and_of_the_mirror_where_ships_are_swapped(
    polynomial: Polynomial, numbers: list[Fraction]
) -> None:
    values = {**dict(zip(NAMES, numbers, strict=True)), "other.heading": Fraction(2)}
    swapped = {
        mirrored_name(name): -value if name in ("rx", "ry", "wx", "wy") else value
        for name, value in values.items()
    }

    found = polynomial.evaluated(values, lambda each: each)

    assert polynomial.mirrored().evaluated(swapped, lambda each: each) == found
    put = polynomial.with_values({name: number(value) for name, value in values.items()})
    assert put.constant == found


@given(polynomials)
@settings(derandomize=True, max_examples=100, deadline=None)
def test_canonical_form_begins_with_1_and_keeps_the_sign(polynomial: Polynomial) -> None:
    scaled, turned = canonical(polynomial)

    if polynomial.terms:
        assert scaled.terms[0][1] == 1
        assert scaled * number(polynomial.terms[0][1]) == polynomial
        assert turned == (1 if polynomial.terms[0][1] > 0 else -1)
    else:
        assert scaled == polynomial


def test_degree_is_the_greatest_number_of_factors() -> None:
    assert number(3).degree == Polynomial(()).degree == 0
    assert (variable("rx") * variable("rx") * variable("wx") + variable("ry")).degree == 3
