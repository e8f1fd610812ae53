"""From text to formula: names, types, units, definitions, parameters, and what is refused."""

from __future__ import annotations

import math

import pytest

from ccas_core.tapd.language.compiler import (
    MAX_DEFINITIONS_OPEN,
    MAX_FACTORS,
    MAX_PARTS,
    UNITS,
    Compiler,
    Definition,
)
from ccas_core.tapd.language.formula import (
    FALSE,
    TRUE,
    Before,
    Constant,
    Formula,
    Known,
    Named,
    Not,
    Same,
    Sign,
    walk,
)
from ccas_core.tapd.language.formula import Test as HasValue
from ccas_core.tapd.language.syntax import Fault, Span, parse
from ccas_core.tapd.vocabulary import MOTIONS, VOCABULARY, Kind, Scope

from .. import stated
from . import PLAIN, Language, unnamed

SMALL = Language(
    definitions={
        "small": (("ship",), "ship.length < 20 m and not ship.ferry"),
        "both_small": ((), "small(own) and small(other)"),
        "before": (("one", "two"), "one.length < two.length and bearing(one, two) > 0 deg"),
        "overtakes": (("ship",), "geometry == overtaking and overtaker == ship"),
        "motor": (("ship",), "ship.propulsion == motor"),
    },
    parameters={"T_risk": ("900", "s"), "wide": ("112.5", "deg"), "size": ("20", "m"), "share": ("1.5", "")},
    regimes=("tidal",),
)


def meant(fault: Fault, text: str) -> str:
    return text[fault.span.begin : fault.span.end]


# --- names ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("fact", VOCABULARY.by_scope[Scope.SHIP], ids=lambda fact: str(fact.name))
@pytest.mark.parametrize("ship", ["own", "other"])
def test_every_fact_of_a_ship_can_be_asked_for(fact: object, ship: str) -> None:
    name = f"{ship}.{fact.name}"  # type: ignore[attr-defined]
    kind: Kind = fact.kind  # type: ignore[attr-defined]
    if kind is Kind.FLAG:
        assert PLAIN.formula(name) == HasValue(name, value=True)
    elif kind is Kind.CHOICE:
        word = fact.choices[0]  # type: ignore[attr-defined]
        assert PLAIN.formula(f"{name} == {word}") == HasValue(name, word)
    else:
        unit = next(u for u, (_, dims) in UNITS.items() if dims == _dimensions(fact))
        (part,) = (part for part in walk(PLAIN.formula(f"{name} < 3 {unit}")) if isinstance(part, Sign))
        assert part.polynomial.variables == {name}
    assert PLAIN.formula(f"known({name})") == Known(name)


def _dimensions(fact: object) -> object:
    from ccas_core.tapd.language.dimensions import DIMENSIONS

    return DIMENSIONS[fact.quantity.name]  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("true", TRUE),
        ("not true", FALSE),
        ("true and own.ferry", HasValue("own.ferry", value=True)),
        ("false or own.ferry", HasValue("own.ferry", value=True)),
        ("false and own.ferry", FALSE),
        ("true or own.ferry", TRUE),
        ("not not own.ferry", HasValue("own.ferry", value=True)),
        ("waterway.sign_a2", HasValue("waterway.sign_a2", value=True)),
        ("waterway.current != none", Not(HasValue("waterway.current", "none"))),
        ("waterway.name == Rhine", HasValue("waterway.name", "Rhine")),
        ("regime.tidal", HasValue("waterway.regime", "tidal")),
        ("geometry == head_on", HasValue("geometry", "head_on")),
        ("head_on == geometry", HasValue("geometry", "head_on")),
        ("overtaker == own", HasValue("overtaker", "own")),
        ("overtaker in (own)", HasValue("overtaker", "own")),
        ("overtaker == none", HasValue("overtaker", "none")),
        ("own.wind_side == other.wind_side", Same("own.wind_side", "other.wind_side")),
        ("own.wind_side != other.wind_side", Not(Same("own.wind_side", "other.wind_side"))),
        ("same_waterway", HasValue("same_waterway", value=True)),
        ("3 m < 4 m", TRUE),
        ("own.time_to_intersection < other.time_to_intersection",
         Before("own.time_to_intersection", "other.time_to_intersection", strict=True)),
        ("own.time_to_intersection > other.time_to_intersection",
         Not(Before("own.time_to_intersection", "other.time_to_intersection", strict=False))),
    ],
)  # fmt: skip
def test_condition_has_this_formula(text: str, formula: Formula) -> None:
    assert unnamed(SMALL.formula(text)) == formula


@pytest.mark.parametrize(
    ("text", "word", "message", "hint"),
    [
        ("own.lenght < 20 m", "own.lenght", "unknown fact 'own.lenght'", "did you mean 'own.length'?"),
        ("waterway.sign_a22", "waterway.sign_a22", "unknown fact", "did you mean 'waterway.sign_a2'?"),
        ("smal(own)", "smal(own)", "unknown definition 'smal'", "did you mean 'small'?"),
        ("geometri == head_on", "geometri", "unknown name 'geometri'", "did you mean 'geometry'?"),
        ("xyzzy", "xyzzy", "unknown name 'xyzzy'", "all names are listed by `ccas facts`"),
        ("T_rsk > 3 s", "T_rsk", "unknown name 'T_rsk'", "did you mean 'T_risk'?"),
        ("regime.tidl", "regime.tidl", "unknown regime 'tidl'", "did you mean 'tidal'?"),
        ("ship.ferry", "ship.ferry", "unknown fact 'ship.ferry'", ""),
        ("own.ferry.name", "own.ferry.name", "unknown fact", ""),
        (
            "geometry == headon",
            "geometry == headon",
            "'geometry' is never 'headon'",
            "did you mean 'head_on'?",
        ),
        ("own.propulsion in (sail, moter)", "moter", "is never 'moter'", "did you mean 'motor'?"),
        ("own.length < 20 ft", "20 ft", "unknown unit 'ft'", ""),
        (
            "course_difference > 2 rad",
            "2 rad",
            "unknown unit 'rad'",
            "angles are written in degrees: 22.5 deg",
        ),
        ("tcpa < own.ferri", "own.ferri", "unknown fact", "did you mean 'own.ferry'?"),
        ("known(own.wnd_side)", "own.wnd_side", "unknown fact", "did you mean 'own.wind_side'?"),
        ("known(xyzzy)", "xyzzy", "unknown name", ""),
        ("xyzzy in (a, b)", "xyzzy", "unknown name", ""),
        ("3 + xyzzy < 4", "xyzzy", "unknown name", ""),
    ],
)
def test_unknown_name_is_told_with_what_was_probably_meant(
    text: str, word: str, message: str, hint: str
) -> None:
    fault = SMALL.fault(text)

    assert message in fault.message
    assert meant(fault, text) == word
    assert hint in fault.hint


def test_names_that_a_condition_may_use_are_all_known() -> None:
    names = list(SMALL.compiler().names())

    assert len(names) == len(set(names))
    for name in ("small", "T_risk", "abs", "tcpa", "closing", "own.length", "other.speed", "waterway.current",
                 "geometry", "own.time_to_intersection", "regime.tidal"):  # fmt: skip
        assert name in names


# --- types ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "word", "message"),
    [
        ("own.length", "own.length", "a length is no condition"),
        ("tcpa", "tcpa", "a time is no condition"),
        ("own.propulsion", "own.propulsion", "'own.propulsion', which has words for values, is no condition"),
        ("own", "own", "a ship is no condition"),
        ("not own.length", "own.length", "a length is no condition"),
        ("own.ferry and 3 m", "3 m", "a length is no condition"),
        ("own.ferry < other.ferry", "own.ferry < other.ferry", "conditions are not ordered"),
        ("own.propulsion < other.propulsion", "own.propulsion < other.propulsion", "words are not ordered"),
        ("own.propulsion == own.ferry", "own.propulsion == own.ferry", "is compared with a condition"),
        ("own.propulsion == 3", "own.propulsion == 3", "is compared with a number without unit"),
        ("own.propulsion == own.wind_side", "own.propulsion == own.wind_side", "have different values"),
        ("own.length == own.ferry", "own.length == own.ferry", "a length is compared with a condition"),
        ("own.length == own", "own.length == own", "a length is compared with a ship"),
        ("own == other", "own == other", "a ship is compared with a ship"),
        ("own.length + own.ferry > 3 m", "own.ferry", "a condition is no number"),
        ("-own.ferry", "own.ferry", "a condition is no number"),
        ("own.length in (a)", "own.length", "a length is not among words"),
        ("own.ferry in (a)", "own.ferry", "a condition is not among words"),
        ("waterway.regime == tidal", "waterway.regime == tidal", "'waterway.regime' has flags"),
        ("waterway.regime == waterway.regime", "waterway.regime == waterway.regime", "has flags"),
        ("waterway.regime in (tidal)", "tidal", "'waterway.regime' has flags"),
        ("tcpa + 3 s > 4 s", "tcpa", "'tcpa' is a quantity of motion"),
        ("own.speed * 2 > 4 m/s", "own.speed", "'own.speed' is a quantity of motion"),
        ("tcpa == 3 s", "tcpa == 3 s", "'tcpa' is hardly ever equal"),
        ("tcpa < own.ferry", "tcpa < own.ferry", "'tcpa' is compared with a condition"),
        ("own.ferry < tcpa", "own.ferry < tcpa", "'tcpa' is compared with a condition"),
        ("dcpa < distance", "dcpa < distance", "'dcpa' is compared with 'distance'"),
        ("tcpa <= tcpa + 1 s", "tcpa", "'tcpa' is a quantity of motion"),
        ("dcpa > own.heading * own.beam * 0", "dcpa > own.heading * own.beam * 0", "is compared with"),
        ("abs(own.length) > 3 m", "abs(own.length)", "'abs' takes a bearing"),
        ("abs(bearing(own, other), own) > 3 deg", "abs(bearing(own, other), own)", "'abs' takes a bearing"),
        ("bearing(own) > 3 deg", "bearing(own)", "'bearing' is asked for 1 ship(s)"),
        ("bearing(own, own) > 3 deg", "bearing(own, own)", "'bearing' of a ship with itself"),
        ("bearing(own, own.length) > 3 deg", "own.length", "this is no ship"),
        ("from_starboard(other, other)", "from_starboard(other, other)", "of a ship with itself"),
        ("known(own)", "known(own)", "'known' takes one fact"),
        ("known(T_risk)", "known(T_risk)", "'known' takes one fact"),
        ("known(own.length * 2)", "known(own.length * 2)", "'known' takes one fact"),
        ("known(own.length, own.beam)", "known(own.length, own.beam)", "'known' takes one fact"),
        ("known(own.speed)", "known(own.speed)", "'known' takes one fact"),
        ("abs", "abs", "'abs' is asked for something"),
        ("small", "small", "'small' is asked for ships"),
        ("small(own, other)", "small(own, other)", "'small' is asked for 2 ship(s)"),
        ("both_small(own)", "both_small(own)", "'both_small' is asked for 1 ship(s)"),
        ("small(3)", "3", "this is no ship"),
    ],
)  # fmt: skip
def test_what_has_no_meaning_is_refused(text: str, word: str, message: str) -> None:
    fault = SMALL.fault(text)

    assert message in fault.message
    assert meant(fault, text) == word


# --- units ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message", "hint"),
    [
        ("own.length < 20", "a length is compared with a number without unit", "such as 'm'"),
        ("20 < own.length", "a number without unit is compared with a length", "such as 'm'"),
        ("own.length < 20 s", "a length is compared with a time", ""),
        ("own.length + 3 s < 4 m", "a length is added to a time", ""),
        ("own.length * own.beam < 20 m", "a product of quantities is compared with a length", ""),
        ("tcpa < 20 m", "a time is compared with a length", ""),
        ("20 m < tcpa", "a time is compared with a length", ""),
        ("own.speed < 3", "a speed is compared with a number without unit", "such as 'm/s'"),
        ("own.weight > 3 m", "a weight is compared with a length", ""),
        ("course_difference > 3", "an angle is compared with a number without unit", "such as 'deg'"),
    ],
)
def test_units_must_fit(text: str, message: str, hint: str) -> None:
    fault = PLAIN.fault(text)

    assert message in fault.message
    assert hint in fault.hint


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("own.length < 20 m", "own.length < 0.02 km"),
        ("own.length < 1852 m", "own.length < 1 NM"),
        ("own.weight < 1 t", "own.weight < 1000 kg"),
        ("own.length * 2 < 40 m", "own.length < 20 m"),
        ("own.length + 5 m < 25 m", "own.length < 20 m"),
        ("-own.length > -20 m", "own.length < 20 m"),
        ("20 m > own.length", "own.length < 20 m"),
        ("own.length - 20 m < 0 m", "own.length < 20 m"),
        ("tcpa < 1 min", "tcpa < 60 s"),
        ("tcpa < 0.5 h", "1800 s > tcpa"),
        ("own.speed < 36 km/h", "own.speed < 10 m/s"),
        ("own.speed < 9 kn", "own.speed < 4.63 m/s"),
        ("own.length * own.beam < 20 m * 5 m", "own.beam * own.length < 100 m * 1 m"),
        ("0 s <= tcpa <= 60 s", "0 s <= tcpa and tcpa <= 60 s"),
    ],
)
def test_two_ways_of_writing_it_are_one_formula(one: str, other: str) -> None:
    assert unnamed(PLAIN.formula(one)) == unnamed(PLAIN.formula(other))


def test_every_unit_has_a_size_and_measures_something() -> None:
    for unit, (size, dimensions) in UNITS.items():
        assert size > 0
        assert any(dimensions) is bool(unit)


def test_every_quantity_of_motion_can_be_compared_with_each_of_its_units() -> None:
    for name, (quantity, _) in MOTIONS.items():
        call = {"bearing": "bearing(own, other)", "speed": "own.speed"}.get(name, name)
        call = f"own.{call}" if name == "time_to_intersection" else call
        for unit in set(quantity.units) & UNITS.keys():
            for relation in ("<", "<=", ">", ">="):
                PLAIN.formula(f"{call} {relation} 3 {unit}")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("course_difference < own.heading", "an angle is compared with a fact"),
        ("bearing(own, other) < other.heading", "an angle is compared with a fact"),
        ("own.time_to_intersection < limit * own.passengers_max", "a time to the intersection is compared"),
    ],
)
def test_limit_that_only_floats_could_decide_is_refused(text: str, message: str) -> None:
    fault = Language(parameters={"limit": ("3", "s")}).fault(text)

    assert message in fault.message
    assert meant(fault, text) == text


def test_products_are_bounded() -> None:
    factors = ["own.passengers_max"] * MAX_FACTORS
    PLAIN.formula(f"{' * '.join(factors)} > 3")

    assert (
        "a product of more than" in PLAIN.fault(f"{' * '.join([*factors, 'own.passengers_max'])} > 3").message
    )
    assert "beyond all measure" in PLAIN.fault("1e60 * 1e60 * own.passengers_max > 3").message


# --- definitions ----------------------------------------------------------------------------------


def test_definition_is_compiled_for_the_ships_that_it_is_asked_for() -> None:
    for ship in ("own", "other"):
        found = SMALL.formula(f"small({ship})")
        assert isinstance(found, Named)
        assert found.name == f"small({ship})"
        assert unnamed(found) == unnamed(PLAIN.formula(f"{ship}.length < 20 m and not {ship}.ferry"))


def test_definition_for_two_ships_takes_them_in_order() -> None:
    here = unnamed(SMALL.formula("before(own, other)"))
    there = unnamed(SMALL.formula("before(other, own)"))

    assert here == unnamed(PLAIN.formula("own.length < other.length and bearing(own, other) > 0 deg"))
    assert there == unnamed(PLAIN.formula("other.length < own.length and bearing(other, own) > 0 deg"))


def test_definition_without_ships_speaks_of_own_and_other() -> None:
    assert unnamed(SMALL.formula("both_small")) == unnamed(SMALL.formula("small(own) and small(other)"))


def test_ship_of_a_definition_can_be_compared_with_a_fact_that_names_a_ship() -> None:
    assert unnamed(SMALL.formula("overtakes(other)")) == unnamed(
        PLAIN.formula("geometry == overtaking and overtaker == other")
    )
    language = Language(definitions={"one_of": (("ship",), "overtaker in (ship, none)")})
    assert unnamed(language.formula("one_of(other)")) == unnamed(PLAIN.formula("overtaker in (other, none)"))


def test_word_beside_its_fact_means_the_value_whatever_else_has_its_name() -> None:
    """`motor` is a definition here, and a kind of propulsion."""
    assert SMALL.formula("own.propulsion == motor") == HasValue("own.propulsion", "motor")
    assert isinstance(SMALL.formula("motor(own)"), Named)


def test_comparison_is_written_with_the_ships_that_are_meant() -> None:
    names = {part.name for part in walk(SMALL.formula("before(other, own)")) if isinstance(part, Named)}

    assert names == {"before(other, own)", "other.length < own.length", "bearing(other, own) > 0 deg"}


def test_definition_for_one_ship_knows_no_other() -> None:
    language = Language(
        definitions={
            "wrong": (("ship",), "own.ferry and ship.ferry"),
            "pair": ((), "own.ferry and other.ferry"),
            "wronger": (("ship",), "pair and ship.ferry"),
        }
    )
    compiler = language.compiler()

    with pytest.raises(Fault, match="'own' is not a ship here") as caught:
        compiler.definition("wrong")
    assert caught.value.hint == "this is asked for: ship"
    with pytest.raises(Fault, match="'pair' has no meaning here"):
        compiler.definition("wronger")


@pytest.mark.parametrize(
    ("definitions", "ring"),
    [
        ({"a": ((), "a")}, "a -> a"),
        ({"a": ((), "not b"), "b": ((), "own.ferry or a")}, "a -> b -> a"),
        ({"a": (("s",), "b(s)"), "b": (("s",), "c(s)"), "c": (("s",), "a(s)")}, "a -> b -> c -> a"),
    ],
)
def test_definition_by_itself_is_refused(
    definitions: dict[str, tuple[tuple[str, ...], str]], ring: str
) -> None:
    ships = definitions["a"][0]

    fault = Language(definitions=definitions).fault("a(own)" if ships else "a")

    assert fault.message == f"'a' is defined by itself: {ring}"


def test_definition_that_is_wrong_is_told_where_it_stands_and_not_again() -> None:
    compiler = Language(definitions={"a": ((), "own.lenght < 3 m")}).compiler()

    assert unnamed(compiler.condition("a or own.ferry")) == HasValue("own.ferry", value=True)
    assert compiler.broken == {"a"}
    with pytest.raises(Fault, match=r"unknown fact 'own\.lenght'"):
        compiler.definition("a")


def test_what_is_used_is_known_afterwards() -> None:
    compiler = SMALL.compiler()
    compiler.condition("both_small and tcpa < T_risk and regime.tidal")

    assert compiler.used == {"both_small", "small", "T_risk", "regime.tidal"}


def test_definitions_that_double_are_bounded() -> None:
    doubling = {"d0": ((), "own.ferry"), **{f"d{n}": ((), f"d{n - 1} or d{n - 1}") for n in range(1, 60)}}
    compiler = Language(definitions=doubling).compiler()
    for name in doubling:  # does not hang
        compiler.asked(name, (), Span(0, 1))

    assert compiler.broken
    with pytest.raises(Fault, match="the condition is too large"):
        compiler.definition(min(compiler.broken, key=lambda name: int(name[1:])))
    assert sum(1 for _ in walk(compiler.condition("d3"))) < MAX_PARTS


def test_condition_that_doubles_is_bounded() -> None:
    text = "own.ferry"
    for _ in range(40):
        text = f"({text} == other.ferry)"

    assert "the condition is too large" in PLAIN.fault(text).message


def test_definitions_that_ask_for_one_another_are_bounded() -> None:
    count = MAX_DEFINITIONS_OPEN + 5
    chain = {f"d{n}": ((), f"d{n + 1} and own.ferry") for n in range(count)}
    chain[f"d{count}"] = ((), "other.ferry")

    whole = Language(definitions=chain).compiler()
    whole.condition("d6")
    assert not whole.broken
    with pytest.raises(Fault, match="definitions that ask for one another, more than 30 deep"):
        Language(definitions=chain).formula("d0")
    compiler = Language(definitions=chain).compiler()
    for name in reversed(chain):
        compiler.asked(name, (), Span(0, 1))
    assert not compiler.broken  # those that are asked for stand first


# --- parameters -----------------------------------------------------------------------------------


def test_parameter_has_its_unit_and_its_value() -> None:
    before, after = (stated(at=((0, 0, 0, 3), (north, 0, 180, 3))) for north in (6.0 * 899.0, 6.0 * 901.0))
    decide = SMALL.decide("tcpa <= T_risk")

    assert decide(before)
    assert not decide(after)
    assert "a time is compared with a length" in SMALL.fault("T_risk < 3 m").message
    assert SMALL.decide("own.length < share * size")(stated({"length": 29.0}))
    assert not SMALL.decide("own.length < share * size")(stated({"length": 30.0}))


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("abs(bearing(other, own)) >= wide", "abs(bearing(other, own)) >= 112.5 deg"),
        ("course_difference < 180 deg - wide", "course_difference < 67.5 deg"),
        ("bearing(own, other) > -wide", "bearing(own, other) > -112.5 deg"),
        ("bearing(own, other) > wide - 180 deg", "bearing(own, other) > -67.5 deg"),
    ],
)
def test_limit_of_an_angle_may_depend_on_a_parameter(text: str, plain: str) -> None:
    decide, same = SMALL.decide(text), PLAIN.decide(plain)

    for course in range(0, 360, 7):
        facts = stated(at=((0, 0, 0, 3), (100.0 * math.cos(course), 70.0, course, 4)))
        assert decide(facts) is same(facts)


def test_compiler_is_told_apart_from_what_it_compiles() -> None:
    compiler = Compiler(vocabulary=VOCABULARY, definitions={"a": Definition((), parse("true"), "true")})

    assert compiler.condition("a") == Named("a", Constant(value=True))
