"""The grammar of conditions: every production, every fault with its place, the limits."""

from __future__ import annotations

import pytest

from ccas_core.tapd.language.syntax import (
    MAX_DEPTH,
    MAX_DIGITS,
    MAX_LENGTH,
    RELATIONS,
    Arithmetic,
    Call,
    Comparison,
    Expression,
    Fault,
    Junction,
    Membership,
    Minus,
    Negation,
    Number,
    Span,
    Truth,
    Word,
    is_name,
    parse,
)


def bare(expression: Expression) -> object:  # noqa: PLR0911 - one for each production
    """Shape of an expression, without places."""
    match expression:
        case Number():
            return f"{expression.digits} {expression.unit}".strip()
        case Word():
            return expression.name
        case Truth():
            return expression.value
        case Call():
            return (expression.name, *map(bare, expression.arguments))
        case Negation():
            return ("not", bare(expression.part))
        case Minus():
            return ("-", bare(expression.part))
        case Junction():
            return (expression.word, *map(bare, expression.parts))
        case Comparison():
            return ([*map(bare, expression.values)], expression.relations)
        case Membership():
            words = [word.name for word in expression.words]
            return ("not in" if expression.negated else "in", bare(expression.value), *words)
        case Arithmetic():
            return (expression.sign, bare(expression.left), bare(expression.right))


# --- productions ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ("true", True),
        ("false", False),
        ("closing", "closing"),
        ("own.length", "own.length"),
        ("a or b", ("or", "a", "b")),
        ("a or b or c", ("or", "a", "b", "c")),
        ("a and b and c", ("and", "a", "b", "c")),
        ("a or b and c", ("or", "a", ("and", "b", "c"))),
        ("(a or b) and c", ("and", ("or", "a", "b"), "c")),
        ("not a and b", ("and", ("not", "a"), "b")),
        ("not not a", ("not", ("not", "a"))),
        ("not a == b", ("not", (["a", "b"], ("==",)))),
        ("0 s <= tcpa <= 300 s", (["0 s", "tcpa", "300 s"], ("<=", "<="))),
        ("a < b > c", (["a", "b", "c"], ("<", ">"))),
        ("own.propulsion in (sail, muscle)", ("in", "own.propulsion", "sail", "muscle")),
        ("own.propulsion not in (sail)", ("not in", "own.propulsion", "sail")),
        ("a + b - c", ("-", ("+", "a", "b"), "c")),
        ("a + b * c", ("+", "a", ("*", "b", "c"))),
        ("-a * b", ("*", ("-", "a"), "b")),
        ("--a", ("-", ("-", "a"))),
        ("a - -3 m", ("-", "a", ("-", "3 m"))),
        ("small(own)", ("small", "own")),
        ("bearing(own, other)", ("bearing", "own", "other")),
        ("abs(bearing(other, own))", ("abs", ("bearing", "other", "own"))),
        ("3", "3"),
        ("22.5 deg", "22.5 deg"),
        ("1e3 m", "1e3 m"),
        ("1.5E-2 km", "1.5E-2 km"),
        ("6 m/s < own.speed", (["6 m/s", "own.speed"], ("<",))),
        ("20 km/h", "20 km/h"),
        ("3 and a", ("and", "3", "a")),  # 'and' is no unit
        ("3 in (a)", ("in", "3", "a")),
        ("3 m and a", ("and", "3 m", "a")),
        ("a\n  and\tb", ("and", "a", "b")),
    ],
)
def test_text_has_this_shape(text: str, shape: object) -> None:
    assert bare(parse(text)) == shape


@pytest.mark.parametrize("relation", RELATIONS)
def test_every_relation_is_read(relation: str) -> None:
    assert bare(parse(f"a {relation} b")) == (["a", "b"], (relation,))
    assert bare(parse(f"a{relation}b")) == (["a", "b"], (relation,))


def test_every_part_knows_its_place() -> None:
    text = "small(own) and (own.length + 3 m) < -tcpa or not a in (b, c)"
    found = parse(text)

    assert found.span == Span(0, len(text))
    assert isinstance(found, Junction)
    conjunction, negation = found.parts
    assert isinstance(conjunction, Junction)
    call, comparison = conjunction.parts
    assert text[call.span.begin : call.span.end] == "small(own)"
    assert isinstance(comparison, Comparison)
    assert [text[each.span.begin : each.span.end] for each in comparison.values] == [
        "own.length + 3 m",
        "-tcpa",
    ]
    assert isinstance(negation, Negation)
    assert isinstance(negation.part, Membership)
    assert [word.span for word in negation.part.words] == [Span(text.index("b, c"), text.index("b, c") + 1),
                                                           Span(len(text) - 2, len(text) - 1)]  # fmt: skip


@pytest.mark.parametrize("name", ["a", "_", "small_craft", "T2"])
def test_name(name: str) -> None:
    assert is_name(name)


@pytest.mark.parametrize("name", ["", "2a", "a.b", "a b", "and", "or", "not", "in", "true", "false", "é"])
def test_no_name(name: str) -> None:
    assert not is_name(name)


# --- faults ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "meant", "message"),
    [
        ("", "", "an empty condition"),
        ("   ", " ", "an empty condition"),
        ("a ? b", "?", "the character '?' means nothing in a condition"),
        ("a & b", "&", "the character '&' means nothing"),
        ("own['x']", "[", "the character '[' means nothing"),
        ("a b", "b", "'b' is not expected here: the condition should end here"),
        ("a)", ")", "')' is not expected here: the condition should end here"),
        ("(a", "", "the end is not expected here: the parenthesis at letter 1 is still open"),
        ("a and (b or c", "", "the parenthesis at letter 7 is still open"),
        ("a and", "", "the end is not expected here: a value is missing"),
        ("and a", "and", "'and' is not expected here: a value is missing"),
        ("a and or b", "or", "'or' is not expected here: a value is missing"),
        ("not", "", "a value is missing"),
        ("a <", "", "a value is missing"),
        ("a not b", "b", "after 'not' between two values comes 'in'"),
        ("a in b", "b", "after 'in' comes a list in parentheses"),
        ("a in ()", ")", "a list holds words"),
        ("a in (b, 3)", "3", "a list holds words"),
        ("a in (b, and)", "and", "a list holds words"),
        ("a in (b c)", "c", "the list ends with ')'"),
        ("f()", ")", "a value is missing"),
        ("f(a b)", "b", "the arguments of 'f' end with ')'"),
        ("f(a", "", "the arguments of 'f' end with ')'"),
        ("12m < a", "12m", "'12m' is not a number"),
        ("3.a", "3.a", "'3.a' is not a number"),
        ("1.2.3 < a", "1.2.3", "'1.2.3' is not a number"),
        ("a = b", "=", "'=' is not expected here"),
        ("a / b", "/", "'/' is not expected here"),
        ("own.", ".", "the character '.' means nothing"),
        ("é", "é", "the character 'é' means nothing"),
        ("1e999999999 m < a", "1e999999999 m", "a number beyond all measure"),
        ("1e-500", "1e-500", "a number beyond all measure"),
        (f"a < {'9' * (MAX_DIGITS + 1)} m", "9" * (MAX_DIGITS + 1), "a number beyond all measure"),
    ],
)
def test_fault_is_told_with_its_place(text: str, meant: str, message: str) -> None:
    with pytest.raises(Fault) as caught:
        parse(text)

    fault = caught.value
    assert message in fault.message
    shown = text[fault.span.begin : fault.span.end]
    assert shown == meant or shown + " m" == meant
    assert 0 <= fault.span.begin < fault.span.end


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("a = b", "a comparison is written '=='"),
        ("a / b", "there is no division: multiply the other side"),
        ("12m < a", "write '12 m'"),
        ("3.a < b", "a number is written like 20 or 22.5"),
    ],
)
def test_fault_has_a_hint(text: str, hint: str) -> None:
    with pytest.raises(Fault) as caught:
        parse(text)
    assert caught.value.hint == hint


# --- limits ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("left", "right"), [("(", ")"), ("not ", ""), ("-", ""), ("f(", ")")])
def test_nesting_is_bounded(left: str, right: str) -> None:
    parse(left * MAX_DEPTH + "a" + right * MAX_DEPTH)

    with pytest.raises(Fault, match=f"nested more than {MAX_DEPTH} deep") as caught:
        parse(left * (MAX_DEPTH + 1) + "a" + right * (MAX_DEPTH + 1))
    assert caught.value.span.begin == MAX_DEPTH * len(left)
    assert "under 'let'" in caught.value.hint


def test_depth_counts_what_is_open_and_not_what_was() -> None:
    parse(" and ".join(["(not (a))"] * (MAX_DEPTH + 1)))


def test_length_is_bounded() -> None:
    parse("a or " * ((MAX_LENGTH - 1) // 5) + "a")

    with pytest.raises(Fault, match=f"a condition of {MAX_LENGTH + 1} letters"):
        parse("a" * (MAX_LENGTH + 1))


def test_longest_conditions_are_read_whatever_they_hold() -> None:
    for piece in ("a or ", "a + ", "1 < ", "not a and ", "(a) and "):
        text = piece * ((MAX_LENGTH - 1) // len(piece)) + "a"
        assert parse(text).span.end >= len(text) - 1
