"""The priority graph: from verdicts to edges, from edges to an order (Sec. 3.1, TAPD steps 2 to 5)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ccas_core.priority import (
    NO_BEARING,
    Bearing,
    Edge,
    EdgeKind,
    Opening,
    PriorityGraph,
    Settlement,
    settle,
)
from ccas_core.roles import Geometry, PassingSide, Role
from ccas_core.ships import ShipId
from ccas_core.verdict import OPPOSITE, Kind, Verdict

from .tapd import A, B, C, D, verdict

MASSES = {A: 2.0, B: 1.0, C: 3.0, D: 4.0}  # b is the lightest
Z = ShipId("z")


def settled(
    kind: Kind,
    pair: tuple[ShipId, ShipId] = (A, B),
    *,
    initiator: ShipId | None = None,
    side: PassingSide | None = None,
    masses: Mapping[ShipId, float] = MASSES,
) -> Settlement:
    """Settle two views that agree; the kind is that of the first ship."""
    own, other = pair
    one = verdict(own, other, kind, initiator=initiator, reason="why")
    two = verdict(other, own, OPPOSITE.get(kind, kind), initiator=initiator, reason="why")
    mine, theirs = (replace(each, passing_side=side, geometry=Geometry.HEAD_ON) for each in (one, two))
    return settle(mine, theirs, masses)


def duty(first: ShipId, then: ShipId) -> Settlement:
    return settled(Kind.GIVE_WAY, (first, then))


def order(first: ShipId, then: ShipId) -> Settlement:
    return settled(Kind.COOPERATE, (first, then), initiator=first)


def graph(*settlements: Settlement, masses: Mapping[ShipId, float] = MASSES) -> PriorityGraph:
    return PriorityGraph(masses=masses, settlements=settlements)


def random_graph(generator: np.random.Generator) -> PriorityGraph:
    """Draw up to nine ships with duty and order edges; masses are often equal."""
    ships = [ShipId(f"s{n}") for n in range(int(generator.integers(2, 10)))]
    masses = {ship: float(generator.integers(1, 4)) for ship in ships}
    density = generator.choice([0.2, 0.4, 0.7])
    settlements = []
    for pair in combinations(ships, 2):
        if generator.random() < density:
            first, then = pair if generator.random() < 0.5 else (pair[1], pair[0])
            settlements.append(order(first, then) if generator.random() < 0.3 else duty(first, then))
    return PriorityGraph(masses=masses, settlements=tuple(settlements))


RANDOM = [random_graph(np.random.default_rng(seed)) for seed in range(500)]


# --- from verdicts to the graph: every row of the table -------------------------------------------


@pytest.mark.parametrize(
    ("kind", "initiator", "edge", "mutual"),
    [
        (Kind.GIVE_WAY, None, Edge(A, B, EdgeKind.DUTY), False),
        (Kind.STAND_ON, None, Edge(B, A, EdgeKind.DUTY), False),
        (Kind.PROHIBITED, A, Edge(A, B, EdgeKind.DUTY), False),
        (Kind.PROHIBITED, B, Edge(B, A, EdgeKind.DUTY), False),
        (Kind.MUTUAL, None, None, True),
        (Kind.NONE, None, None, False),
        (Kind.COOPERATE, A, Edge(A, B, EdgeKind.ORDER), False),
        (Kind.COOPERATE, B, Edge(B, A, EdgeKind.ORDER), False),
    ],
)
def test_verdicts_that_agree_become_the_edge_of_their_row(
    kind: Kind, initiator: ShipId | None, edge: Edge | None, mutual: bool
) -> None:
    agreed = settled(kind, initiator=initiator)

    assert (agreed.edge, agreed.mutual, agreed.fallback) == (edge, mutual, "")


@pytest.mark.parametrize("kind", [Kind.NEGOTIATE, Kind.CONFLICT, Kind.GAP, Kind.UNKNOWN_FACT])
def test_verdict_that_decides_nothing_becomes_the_safe_mutual_rule(kind: Kind) -> None:
    fallback = settled(kind)

    assert fallback.mutual
    assert fallback.edge == Edge(B, A, EdgeKind.ORDER)  # from the lighter
    assert fallback.fallback == f"{kind}: why"


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (verdict(A, B, Kind.GIVE_WAY), verdict(B, A, Kind.GIVE_WAY)),
        (verdict(A, B, Kind.STAND_ON), verdict(B, A, Kind.STAND_ON)),
        (verdict(A, B, Kind.NONE), verdict(B, A, Kind.GIVE_WAY)),
        (verdict(A, B, Kind.GIVE_WAY), verdict(B, A, Kind.STAND_ON, version="2")),
        (verdict(A, B, Kind.MUTUAL), verdict(B, A, Kind.MUTUAL, version="2")),
        (verdict(A, B, Kind.COOPERATE, initiator=A), verdict(B, A, Kind.COOPERATE, initiator=B)),
    ],
)
def test_views_that_disagree_become_the_safe_mutual_rule(one: Verdict, other: Verdict) -> None:
    fallback = settle(one, other, MASSES)

    assert fallback.mutual
    assert fallback.edge == Edge(B, A, EdgeKind.ORDER)
    assert fallback.fallback


def test_among_ships_of_equal_mass_the_safe_mutual_rule_begins_with_the_smaller_id() -> None:
    assert settled(Kind.GAP, (B, A), masses={A: 1.0, B: 1.0}).edge == Edge(A, B, EdgeKind.ORDER)


@given(
    st.sampled_from(list(Kind)),
    st.sampled_from(list(Kind)),
    st.sampled_from(["1", "2"]),
    st.sampled_from([None, A, B]),
    st.sampled_from([1.0, 2.0, 3.0]),
)
@settings(derandomize=True, max_examples=200)
def test_both_ships_come_to_the_same_settlement(
    one: Kind, other: Kind, version: str, initiator: ShipId | None, mass: float
) -> None:
    mine = verdict(A, B, one, initiator=initiator)
    theirs = verdict(B, A, other, version=version, initiator=initiator)
    masses = {A: mass, B: 2.0}

    assert settle(mine, theirs, masses) == settle(theirs, mine, masses)


def test_verdicts_of_different_pairs_are_not_settled() -> None:
    with pytest.raises(ValueError, match="belong together"):
        settle(verdict(A, B, Kind.GIVE_WAY), verdict(C, A, Kind.STAND_ON), MASSES)


# --- what layer 2 may read ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "initiator", "roles"),
    [
        (Kind.GIVE_WAY, None, (Role.GIVE_WAY, Role.STAND_ON)),
        (Kind.STAND_ON, None, (Role.STAND_ON, Role.GIVE_WAY)),
        (Kind.PROHIBITED, A, (Role.GIVE_WAY, Role.STAND_ON)),
        (Kind.PROHIBITED, B, (Role.STAND_ON, Role.GIVE_WAY)),
        (Kind.COOPERATE, A, (Role.NONE, Role.NONE)),
        (Kind.NONE, None, (Role.NONE, Role.NONE)),
        (Kind.MUTUAL, None, (Role.BOTH, Role.BOTH)),
        (Kind.GAP, None, (Role.BOTH, Role.BOTH)),
    ],
)
def test_role_of_both_ships_follows_from_the_verdict(
    kind: Kind, initiator: ShipId | None, roles: tuple[Role, Role]
) -> None:
    of = graph(settled(kind, initiator=initiator))

    assert (of.bearing(A, B).role, of.bearing(B, A).role) == roles


def test_both_ships_read_the_passing_side_and_the_geometry() -> None:
    of = graph(settled(Kind.MUTUAL, side=PassingSide.PORT_TO_PORT))
    expected = Bearing(role=Role.BOTH, passing_side=PassingSide.PORT_TO_PORT, geometry=Geometry.HEAD_ON)

    assert of.bearing(A, B) == of.bearing(B, A) == expected


def test_safe_mutual_rule_has_no_passing_side() -> None:
    of = graph(settled(Kind.CONFLICT, side=PassingSide.PORT_TO_PORT))

    assert of.bearing(A, B).passing_side is None


def test_ships_that_did_not_meet_owe_each_other_nothing() -> None:
    assert graph(duty(A, B)).bearing(A, C) == NO_BEARING


# --- the order ------------------------------------------------------------------------------------


def test_give_way_ship_decides_before_the_stand_on_ship() -> None:
    assert graph(duty(A, B), duty(B, C)).generations() == ((A, D), (B,), (C,))


def test_ships_that_give_way_to_each_other_decide_at_the_same_time() -> None:
    assert graph(settled(Kind.MUTUAL), masses={A: 1.0, B: 2.0}).generations() == ((A, B),)


def test_ship_that_stands_on_to_one_and_gives_way_to_another_decides_in_between() -> None:
    of = graph(duty(C, B), duty(B, A), masses={A: 1.0, B: 1.0, C: 1.0})

    assert of.generations() == ((C,), (B,), (A,))
    assert (of.bearing(B, A).role, of.bearing(B, C).role) == (Role.GIVE_WAY, Role.STAND_ON)


def test_four_ships_at_a_crossroads_begin_with_the_lightest() -> None:
    """Fig. 3: each gives way to the one on its starboard side."""
    of = graph(duty(A, B), duty(B, C), duty(C, D), duty(D, A))

    assert of.generations() == ((B,), (C,), (D,), (A,))
    assert of.cycles() == ((A, B, C, D),)
    assert of.openings == (Opening(Edge(A, B, EdgeKind.DUTY), "lightest first"),)


def test_among_ships_of_equal_mass_a_ring_is_opened_at_the_smallest_id() -> None:
    of = graph(duty(C, B), duty(B, A), duty(A, C), masses={A: 1.0, B: 1.0, C: 1.0})

    assert of.generations()[0] == (A,)
    assert of.openings == (Opening(Edge(B, A, EdgeKind.DUTY), "lightest first"),)


def test_order_edge_on_a_cycle_goes_before_any_duty() -> None:
    of = graph(duty(A, B), duty(B, C), order(C, A))

    assert of.generations() == ((A, D), (B,), (C,))
    assert of.openings == (Opening(Edge(C, A, EdgeKind.ORDER), "no duty"),)


def test_order_edge_on_no_cycle_is_kept() -> None:
    of = graph(duty(B, C), order(C, A))

    assert of.generations() == ((B, D), (C,), (A,))
    assert of.openings == ()


def test_ship_that_waits_for_a_ring_comes_after_it_though_it_is_lighter() -> None:
    of = graph(duty(A, C), duty(C, D), duty(D, A), duty(C, B))

    assert of.generations() == ((A,), (C,), (B, D))


def test_two_rings_are_opened_at_the_same_time() -> None:
    ships = [ShipId(name) for name in "abcdef"]
    one, other = ships[:3], ships[3:]
    rings = [duty_of(ring, n) for ring in (one, other) for n in range(3)]
    of = PriorityGraph(masses=dict.fromkeys(ships, 1.0), settlements=tuple(rings))

    assert of.generations()[0] == (one[0], other[0])
    assert len(of.openings) == 2


def duty_of(ring: list[ShipId], n: int) -> Settlement:
    first, then = ring[n], ring[(n + 1) % 3]
    return settled(Kind.GIVE_WAY, (first, then), masses=dict.fromkeys(ring, 1.0))


@pytest.mark.parametrize("part", range(5))
def test_every_ship_decides_once(part: int) -> None:
    for of in RANDOM[part::5]:
        assert sorted(ship for generation in of.generations() for ship in generation) == sorted(of.masses)


def test_nobody_decides_before_those_that_give_way_to_it_except_through_a_logged_opening() -> None:
    for of in RANDOM:
        turn = _turns(of)
        opened = {opening.edge for opening in of.openings}
        for settlement in of.settlements:
            edge = settlement.edge
            assert edge is not None
            assert edge in opened or turn[edge.first] < turn[edge.then]


def test_an_opened_duty_is_really_turned_round_and_really_lay_on_a_cycle() -> None:
    for of in RANDOM:
        turn, ring = _turns(of), {ship: cycle for cycle in of.cycles() for ship in cycle}
        for opening in of.openings:
            edge = opening.edge
            assert edge.then in ring[edge.first]
            assert opening.criterion == "no duty" or turn[edge.first] > turn[edge.then]
            assert (opening.criterion == "no duty") <= (edge.kind is EdgeKind.ORDER)


def test_every_edge_is_opened_once_at_most() -> None:
    for of in RANDOM:
        edges = [opening.edge for opening in of.openings]
        assert len(set(edges)) == len(edges)


def test_without_cycles_nothing_is_opened_and_everybody_decides_as_soon_as_it_may() -> None:
    acyclic = [of for of in RANDOM if not of.cycles()]

    assert len(acyclic) > 50
    for of in acyclic:
        layers = tuple(tuple(sorted(layer)) for layer in nx.topological_generations(of.digraph))
        assert (of.generations(), of.openings) == (layers, ())


def test_order_does_not_depend_on_the_order_of_the_settlements() -> None:
    for of in RANDOM[:100]:
        turned = PriorityGraph(masses=of.masses, settlements=of.settlements[::-1])
        assert turned.generations() == of.generations()
        assert set(turned.openings) == set(of.openings)


def test_order_does_not_depend_on_the_unit_of_mass() -> None:
    for of in RANDOM[:100]:
        in_tonnes = {ship: mass / 1024.0 for ship, mass in of.masses.items()}
        assert PriorityGraph(masses=in_tonnes, settlements=of.settlements).generations() == of.generations()


def _turns(of: PriorityGraph) -> dict[ShipId, int]:
    return {ship: turn for turn, generation in enumerate(of.generations()) for ship in generation}


# --- a frozen value -------------------------------------------------------------------------------


def test_digraph_and_masses_cannot_be_changed() -> None:
    of = graph(duty(A, B))

    with pytest.raises(nx.NetworkXError, match="Frozen"):
        of.digraph.add_edge(B, C)
    with pytest.raises(TypeError):
        of.masses[A] = 5.0  # type: ignore[index]


def test_ship_without_an_encounter_stands_in_the_graph() -> None:
    assert set(graph(duty(A, B)).digraph) == set(MASSES)


def test_ship_waits_for_those_that_give_way_to_it() -> None:
    of = graph(duty(A, B), duty(C, B))

    assert (of.waits_for(B), of.waits_for(A)) == (frozenset({A, C}), frozenset[ShipId]())


def test_unknown_ship_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="unknown ships in the priority graph: z"):
        graph(settled(Kind.GIVE_WAY, (A, Z)))


def test_pair_that_is_settled_twice_is_refused() -> None:
    with pytest.raises(ValueError, match="settled twice"):
        graph(duty(A, B), duty(B, A))


def test_unknown_initiator_is_refused_as_an_unknown_ship() -> None:
    with pytest.raises(ValueError, match="z"):
        graph(settled(Kind.COOPERATE, initiator=Z))


# --- other criteria than weight -------------------------------------------------------------------


def test_ring_is_opened_by_the_ranks_of_the_ruleset_and_logged_by_their_criterion() -> None:
    ring = PriorityGraph(
        masses=MASSES,
        settlements=(duty(A, B), duty(B, C), duty(C, A)),
        ranks={A: (2.0,), B: (1.0, 5.0), C: (1.0, 4.0), D: (0.0,)},
        criterion="by length, weight",
    )

    assert ring.generations() == ((C, D), (A,), (B,))
    assert ring.openings == (Opening(Edge(B, C, EdgeKind.DUTY), "by length, weight"),)


def test_without_ranks_a_ring_is_opened_by_weight() -> None:
    ring = PriorityGraph(masses=MASSES, settlements=(duty(A, B), duty(B, C), duty(C, A)))

    assert [each.criterion for each in ring.openings] == ["lightest first"]
    assert ring.generations()[0] == (B, D)
