"""Values of parts where facts may be unknown: Kleene's three-valued logic, and what the parts are."""

from __future__ import annotations

from itertools import product

import pytest

from ccas_core.tapd.language.formula import And, Constant, Formula, Named, Not, Or
from ccas_core.tapd.language.formula import Test as HasValue
from ccas_core.tapd.language.threefold import Finding, Truth, examine

from . import Language

P, Q, R = (HasValue(f"own.{name}", value=True) for name in "pqr")
VALUES: tuple[Truth, ...] = (True, False, None)


def examined(formula: Formula, values: dict[Formula, Truth]) -> Finding:
    return examine(formula, lambda part: values[part], str)


@pytest.mark.parametrize(("p", "q"), list(product(VALUES, repeat=2)))
def test_and_or_not_are_kleenes(p: Truth, q: Truth) -> None:
    values: dict[Formula, Truth] = {P: p, Q: q}
    least = False if False in (p, q) else None if None in (p, q) else True
    greatest = True if True in (p, q) else None if None in (p, q) else False

    assert examined(And((P, Q)), values).value is least
    assert examined(Or((P, Q)), values).value is greatest
    assert examined(Not(P), values).value is (None if p is None else not p)


@pytest.mark.parametrize(("p", "q", "r"), list(product(VALUES, repeat=3)))
def test_value_is_what_all_values_of_the_unknown_agree_on_where_each_fact_stands_once(
    p: Truth, q: Truth, r: Truth
) -> None:
    formula = Or((And((P, Not(Q))), R))
    found = examined(formula, {P: p, Q: q, R: r}).value
    tried = {
        (a and not b) or c
        for a, b, c in product(*((True, False) if each is None else (each,) for each in (p, q, r)))
    }

    assert found is (tried.pop() if len(tried) == 1 else None)


def test_constants_have_their_value() -> None:
    assert examined(Constant(value=True), {}).value is True
    assert examined(Constant(value=False), {}).value is False


def test_leaves_are_the_parts_that_are_not_made_of_others() -> None:
    formula = Or((And((P, Not(Q))), R))

    assert [leaf.value for leaf in examined(formula, {P: True, Q: None, R: False}).leaves()] == [
        True,
        None,
        False,
    ]


def test_definition_and_comparison_are_called_as_they_are_written() -> None:
    language = Language(definitions={"small": (("ship",), "ship.length < 20 m and not ship.ferry")})
    formula = language.formula("small(other) or tcpa < 60 s")

    found = examine(formula, lambda _: True, str)

    assert [part.text for part in found.parts] == ["small(other)", "tcpa < 60 s"]
    assert found.parts[0].parts[0].text == "other.length < 20 m"
    measure = found.parts[1].measure
    assert measure is not None
    assert (measure.quantity, measure.relation) == (("tcpa",), "<")


def test_name_of_a_part_without_a_measure_has_the_value_of_the_part() -> None:
    assert examined(Named("p", P), {P: None}).value is None
    assert examined(Named("p", Not(P)), {P: False}).value is True
