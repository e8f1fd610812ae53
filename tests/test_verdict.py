"""Verdicts of two views, and whether they fit together (the consistency condition of Sec. 3.1)."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ccas_core.roles import PassingSide
from ccas_core.ships import ShipId
from ccas_core.verdict import OPPOSITE, Citation, Kind, Verdict, agree

from .tapd import A, B, C, verdict

SYMMETRICAL = [kind for kind in Kind if kind not in OPPOSITE]
SIDES = [None, PassingSide.PORT_TO_PORT, PassingSide.STARBOARD_TO_STARBOARD]


def views(one: Kind, other: Kind) -> tuple[Verdict, Verdict]:
    return verdict(A, B, one), verdict(B, A, other)


@st.composite
def verdicts(draw: st.DrawFn) -> tuple[Verdict, Verdict]:
    """Draw two views of one pair that may differ in everything that matters."""

    def view(own: ShipId, other: ShipId) -> Verdict:
        seen = verdict(
            own,
            other,
            draw(st.sampled_from(list(Kind))),
            version=draw(st.sampled_from(["1", "2"])),
            initiator=draw(st.sampled_from([None, A, B])),
        )
        return replace(seen, passing_side=draw(st.sampled_from(SIDES)))

    return view(A, B), view(B, A)


# --- agreement ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("one", "other"), [(Kind.GIVE_WAY, Kind.STAND_ON), (Kind.STAND_ON, Kind.GIVE_WAY)])
def test_give_way_and_stand_on_agree(one: Kind, other: Kind) -> None:
    assert not agree(*views(one, other))


@pytest.mark.parametrize("kind", SYMMETRICAL)
def test_every_other_kind_agrees_with_itself(kind: Kind) -> None:
    assert not agree(*views(kind, kind))


@pytest.mark.parametrize(
    ("one", "other"), [(o, t) for o, t in product(Kind, Kind) if OPPOSITE.get(o, o) is not t]
)
def test_kinds_that_are_not_opposite_disagree_and_the_reason_names_both(one: Kind, other: Kind) -> None:
    reason = agree(*views(one, other))

    assert f"a sees {one}" in reason
    assert f"b sees {other}" in reason


def test_opposite_of_the_opposite_is_the_kind_itself() -> None:
    assert {OPPOSITE[OPPOSITE[kind]] for kind in OPPOSITE} == set(OPPOSITE)


@pytest.mark.parametrize("change", [{"version": "2"}, {"ruleset": "other"}])
def test_views_by_different_rulesets_or_versions_disagree(change: dict[str, str]) -> None:
    one, other = views(Kind.GIVE_WAY, Kind.STAND_ON)

    assert "judges by" in agree(one, replace(other, **change))  # type: ignore[arg-type]


def test_views_that_name_different_initiators_disagree() -> None:
    one, other = verdict(A, B, Kind.COOPERATE, initiator=A), verdict(B, A, Kind.COOPERATE, initiator=B)

    assert "initiator" in agree(one, other)


def test_views_that_would_pass_on_different_sides_disagree() -> None:
    one, other = views(Kind.MUTUAL, Kind.MUTUAL)

    assert "would pass" in agree(replace(one, passing_side=PassingSide.PORT_TO_PORT), other)


def test_views_that_leave_the_side_to_different_ships_disagree() -> None:
    one, other = views(Kind.MUTUAL, Kind.MUTUAL)

    assert agree(replace(one, side_chosen_by=A), replace(other, side_chosen_by=B))


@given(verdicts())
@settings(derandomize=True, max_examples=200)
def test_agreement_is_the_same_whichever_view_comes_first(pair: tuple[Verdict, Verdict]) -> None:
    one, other = pair

    assert bool(agree(one, other)) is bool(agree(other, one))


# --- one verdict ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "give_way", "stand_on"),
    [
        (Kind.GIVE_WAY, (B,), (A,)),
        (Kind.STAND_ON, (A,), (B,)),
        (Kind.MUTUAL, (A, B), ()),
        *((kind, (), ()) for kind in SYMMETRICAL if kind is not Kind.MUTUAL),
    ],
)
def test_verdict_names_the_obliged_and_the_privileged(
    kind: Kind, give_way: tuple[str, ...], stand_on: tuple[str, ...]
) -> None:
    seen = verdict(B, A, kind)

    assert (seen.give_way, seen.stand_on) == (give_way, stand_on)


@pytest.mark.parametrize(("one", "other"), [(kind, OPPOSITE.get(kind, kind)) for kind in Kind])
def test_views_that_agree_name_the_same_ships(one: Kind, other: Kind) -> None:
    mine, theirs = views(one, other)

    assert (mine.give_way, mine.stand_on, mine.pair) == (theirs.give_way, theirs.stand_on, theirs.pair)


def test_facts_of_a_verdict_are_a_copy_that_nobody_can_write_to() -> None:
    facts = {"tcpa_s": 10.0}
    seen = Verdict(own=A, other=B, kind=Kind.NONE, ruleset="r", version="1", facts=facts)

    facts["tcpa_s"] = 0.0

    assert dict(seen.facts) == {"tcpa_s": 10.0}
    with pytest.raises(TypeError):
        seen.facts["tcpa_s"] = 1.0  # type: ignore[index]


@pytest.mark.parametrize(
    ("citation", "article"), [(None, ""), (Citation(regulation="BPR", article="6.04"), "BPR 6.04")]
)
def test_article_is_that_of_the_citation_or_nothing(citation: Citation | None, article: str) -> None:
    assert replace(verdict(A, B, Kind.NONE), citation=citation).article == article


@pytest.mark.parametrize("initiator", [C, None])
@pytest.mark.parametrize("kind", [Kind.COOPERATE, Kind.PROHIBITED])
def test_initiator_must_be_one_of_the_two_ships(kind: Kind, initiator: ShipId | None) -> None:
    with pytest.raises(ValueError, match="initiator"):
        Verdict(own=A, other=B, kind=kind, ruleset="r", version="1", initiator=initiator)
