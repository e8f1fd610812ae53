"""Rules in plain Python: what they may look at, and what they may return."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import pytest

from ccas_core.roles import PassingSide
from ccas_core.ships import UNKNOWN
from ccas_core.tapd.facts import PairFacts
from ccas_core.tapd.language.code import UnknownFact
from ccas_core.tapd.python_rules import Decide, PairView, PythonRule, RoleDecision, ruled
from ccas_core.tapd.rules import Outcome, Strength
from ccas_core.tapd.ruleset_file import parse_ruleset
from ccas_core.tapd.written import WrittenRuleset
from ccas_core.units import DEGREE
from ccas_core.verdict import Kind

from . import A, B, stated
from .rulesets import SMALL

CROSSING = {
    "risk_of_collision": True,
    "geometry": "crossing",
    "overtaker": "none",
    "has_other_on_starboard": A,
}


def with_python(decide: Callable[[PairView], Any], *, condition: str = "") -> WrittenRuleset:
    text = SMALL.replace("    when: own.ferry and not other.ferry\n    then: stand_on\n",
                         f"{condition}    python: mine\n    because: as it is written\n")  # fmt: skip
    return parse_ruleset(text, "small.yaml", python={"mine": PythonRule("mine", decide, "ours")})


def pair(own: dict[str, Any] | None = None, other: dict[str, Any] | None = None) -> PairFacts:
    return stated(own, other, encounter=CROSSING, at=((0, 0, 0, 3), (300, 300, 270, 3)))


# --- what a rule may look at ------------------------------------------------------------------------


def test_facts_are_there_by_their_names() -> None:
    view = PairView(pair({"length": 12.0, "ferry": True}, {"propulsion": "sail"}))

    assert (view.own.length, view.own.ferry, view.other.propulsion) == (12.0, True, "sail")
    assert view.waterway.current == "none"
    assert (view.geometry, view.has_other_on_starboard) == ("crossing", "own")
    assert view.own.speed == 3.0
    assert view.tcpa == pytest.approx(100.0)
    assert view.bearing("own", "other") == pytest.approx(45.0 * DEGREE)


@pytest.mark.parametrize(
    "ask",
    [
        lambda view: view.own.lenght,
        lambda view: view.other.geometri,
        lambda view: view.waterway.colour,
        lambda view: view.colour,
    ],
)
def test_fact_that_there_is_not_is_an_attribute_error(ask: Callable[[PairView], Any]) -> None:
    with pytest.raises(AttributeError, match="there is no fact"):
        ask(PairView(pair()))


@pytest.mark.parametrize(
    ("ask", "owner", "name"),
    [
        (lambda view: view.own.wind_side, A, "wind_side"),
        (lambda view: view.other.draught, B, "draught"),
        (lambda view: view.waterway.width, "waterway", "width"),
    ],
)
def test_fact_that_is_not_known_ends_the_rule(ask: Callable[[PairView], Any], owner: str, name: str) -> None:
    with pytest.raises(UnknownFact) as caught:
        ask(PairView(pair({"wind_side": UNKNOWN}, {"draught": UNKNOWN})))

    assert (caught.value.missing.owner, caught.value.missing.name) == (owner, name)


# --- what a rule may return -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("decision", "outcome"),
    [
        (None, None),
        ("give_way", Outcome(kind=Kind.GIVE_WAY)),
        (RoleDecision("mutual"), Outcome(kind=Kind.MUTUAL)),
        (
            RoleDecision("stand_on", "it is so", "wait", "port_to_port"),
            Outcome(
                kind=Kind.STAND_ON,
                strength=Strength.WAIT,
                passing_side=PassingSide.PORT_TO_PORT,
                reason="it is so",
            ),
        ),
    ],
)
def test_decision_becomes_an_outcome(decision: object, outcome: Outcome | None) -> None:
    assert ruled(PythonRule("mine", cast("Decide", lambda _: decision)), PairView(pair())) == outcome


@pytest.mark.parametrize(
    ("decision", "error", "message"),
    [
        (3, TypeError, "rule 'mine' must return a RoleDecision, got int"),
        (True, TypeError, "got bool"),
        ("yield", ValueError, "yield"),
        (RoleDecision("give_way", strength="much"), ValueError, "much"),
        (RoleDecision("give_way", passing_side="left"), ValueError, "left"),
    ],
)
def test_anything_else_is_refused(decision: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        ruled(PythonRule("mine", cast("Decide", lambda _: decision)), PairView(pair()))


# --- in a ladder ------------------------------------------------------------------------------------


def longer(view: PairView) -> str | None:
    return "give_way" if view.own.length > view.other.length else None


def test_rule_decides_from_both_sides_and_is_turned_round_for_the_other() -> None:
    rules = with_python(longer)
    for facts, kinds in (
        (pair({"length": 30.0}, {"length": 20.0}), (Kind.GIVE_WAY, Kind.STAND_ON)),
        (pair({"length": 20.0}, {"length": 30.0}), (Kind.STAND_ON, Kind.GIVE_WAY)),
    ):
        views = (rules.judge(facts), rules.judge(facts.mirrored()))
        assert tuple(view.kind for view in views) == kinds
        assert {view.rule for view in views} == {"ferry"}
        assert {view.article for view in views} == {"RULES 1"}
        assert {view.reason for view in views} == {"as it is written"}


def test_rule_that_has_nothing_to_say_leaves_it_to_the_next() -> None:
    facts = pair({"length": 20.0, "wind_side": "port"}, {"length": 20.0, "wind_side": "starboard"})

    assert with_python(longer).judge(facts).rule == "sail.wind"


def test_rule_is_asked_only_where_its_condition_holds() -> None:
    asked = []

    def decide(view: PairView) -> str:
        asked.append(view.own.length)
        return "give_way"

    rules = with_python(decide, condition="    when: own.ferry\n")

    rules.judge(pair({"length": 20.0, "propulsion": "none"}, {"length": 30.0, "wind_side": "port"}))
    assert not asked
    rules.judge(pair({"length": 20.0}, {"length": 30.0, "ferry": True}))
    assert asked == [30.0]


def test_reason_that_a_rule_gives_comes_first() -> None:
    rules = with_python(lambda _: RoleDecision("mutual", because="we say so"))

    assert rules.judge(pair()).reason == "we say so"


def test_rule_that_asks_for_a_fact_that_is_not_known_gives_unknown_fact() -> None:
    def decide(view: PairView) -> str | None:
        return "give_way" if view.own.wind_side == "port" else None

    view = with_python(decide).judge(pair({"wind_side": UNKNOWN}, {"wind_side": "starboard"}))

    assert view.kind is Kind.UNKNOWN_FACT
    assert "a.wind_side" in view.reason
