"""Deadlocks opened by the ships among themselves, and by the priority graph: both must agree (Sec. 3.2)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

import networkx as nx
import numpy as np
import pytest

from ccas_core.priority import Edge, EdgeKind, Opening, open_cycles
from ccas_core.ships import ShipId
from ccas_core.tapd.deadlock import Waiting, opened_orders, released

from . import A, B, C, D

if TYPE_CHECKING:
    from ccas_core.priority import Digraph

DUTY, ORDER = EdgeKind.DUTY, EdgeKind.ORDER
NOBODY: frozenset[ShipId] = frozenset()
GRAPHS = 1500


@dataclass(frozen=True)
class Fleet:
    """Ships, and who waits for whom."""

    graph: Digraph
    masses: Mapping[ShipId, float]

    @cached_property
    def ranks(self) -> dict[ShipId, tuple[float, ...]]:
        """Place of each ship among those that wait for one another: by mass."""
        return {ship: (mass,) for ship, mass in self.masses.items()}

    @cached_property
    def gossip(self) -> dict[ShipId, Waiting]:
        """What all ships tell, once everybody has heard it."""
        return {
            ship: Waiting(self.ranks[ship], {b: self.graph.edges[b, ship]["kind"] for b in before})
            for ship, before in self.graph.pred.items()
        }

    @cached_property
    def orders(self) -> dict[ShipId, tuple[Opening, ...]]:
        """Order edges on a cycle, by the ship that need not wait for them."""
        return {ship: opened_orders(ship, self.gossip, NOBODY) for ship in self.graph}

    def free(self, decided: set[ShipId]) -> list[ShipId]:
        """Ships that wait for nobody who has not decided, order edges on a cycle left out."""
        return [
            ship
            for ship, before in self.graph.pred.items()
            if ship not in decided
            and before.keys() - {opening.edge.first for opening in self.orders[ship]} <= decided
        ]

    def jumpers(self, decided: set[ShipId]) -> dict[ShipId, tuple[Opening, ...]]:
        """Ships that the distributed rule lets decide, and the edges that they open."""
        heard, told = self.gossip, frozenset(decided)
        asked = {ship: released(ship, heard, told) for ship in self.graph if ship not in decided}
        return {ship: openings for ship, openings in asked.items() if openings is not None}


@dataclass(frozen=True)
class Sailed:
    """What came of a period: who decided in which round, and what was opened."""

    rounds: tuple[tuple[ShipId, ...], ...]
    openings: tuple[Opening, ...]


def fleet(*edges: tuple[ShipId, ShipId, EdgeKind], masses: Mapping[ShipId, float] | None = None) -> Fleet:
    graph: Digraph = nx.DiGraph()
    graph.add_edges_from((first, then, {"kind": kind}) for first, then, kind in edges)
    return Fleet(graph, masses or {A: 2.0, B: 1.0, C: 3.0, D: 0.5})


def random_fleet(seed: int) -> Fleet:
    """Draw two to nine ships with duty and order edges; masses are often equal."""
    generator = np.random.default_rng(seed)
    ships = [ShipId(f"s{n}") for n in range(int(generator.integers(2, 10)))]
    graph: Digraph = nx.DiGraph()
    graph.add_nodes_from(ships)
    density, orders = generator.choice([0.2, 0.4, 0.7]), generator.choice([0.0, 0.3, 0.6])
    for one, other in combinations(ships, 2):
        if generator.random() < density:
            first, then = (one, other) if generator.random() < 0.5 else (other, one)
            graph.add_edge(first, then, kind=ORDER if generator.random() < orders else DUTY)
    return Fleet(graph, {ship: float(generator.integers(1, 4)) for ship in ships})


def by_timer(of: Fleet, generator: np.random.Generator | None = None) -> Sailed:
    """Simulate T_DL: ships that wait for nobody decide; when none does, those that are released.

    With a generator, only some of those that may decide do so in a round.
    """
    decided: set[ShipId] = set()
    rounds: list[tuple[ShipId, ...]] = []
    openings: list[Opening] = []
    while len(decided) < len(of.graph):
        free = of.free(decided)
        jumpers = {} if free else of.jumpers(decided)
        now = sorted(free or jumpers)
        assert now, "nobody decides any more"
        if generator is not None:
            now = sorted(generator.choice(now, int(generator.integers(1, len(now) + 1)), replace=False))
        openings += [opening for ship in now for opening in jumpers.get(ship, of.orders[ship])]
        rounds.append(tuple(now))
        decided.update(now)
    return Sailed(tuple(rounds), tuple(openings))


def at_once(of: Fleet) -> Sailed:
    """Let every ship ask the distributed rule in every round, without waiting for a timer."""
    decided: set[ShipId] = set()
    rounds: list[tuple[ShipId, ...]] = []
    openings: list[Opening] = []
    while len(decided) < len(of.graph):
        jumpers = of.jumpers(decided)
        assert jumpers, "nobody decides any more"
        openings += [opening for ship in sorted(jumpers) for opening in jumpers[ship]]
        rounds.append(tuple(sorted(jumpers)))
        decided.update(jumpers)
    return Sailed(tuple(rounds), tuple(openings))


def turns(rounds: Iterable[Iterable[ShipId]]) -> dict[ShipId, int]:
    return {ship: turn for turn, ships in enumerate(rounds) for ship in ships}


def by_weight(openings: Iterable[Opening]) -> set[Opening]:
    return {opening for opening in openings if opening.criterion == "lightest first"}


# --- the same as the priority graph ---------------------------------------------------------------


def test_asked_in_every_round_the_ships_give_the_generations_and_openings_of_the_graph() -> None:
    for seed in range(GRAPHS):
        of = random_fleet(seed)
        generations, openings = open_cycles(of.graph, of.ranks)

        sailed = at_once(of)

        assert sailed.rounds == generations
        assert sorted(map(str, sailed.openings)) == sorted(map(str, openings))


def test_after_the_timer_the_ships_open_the_same_duties_and_keep_the_same_order_along_edges() -> None:
    for seed in range(GRAPHS, 2 * GRAPHS):
        of = random_fleet(seed)
        generations, openings = open_cycles(of.graph, of.ranks)
        no_duty = {(each.edge.first, each.edge.then) for each in openings if each.criterion == "no duty"}

        sailed = by_timer(of)

        assert by_weight(sailed.openings) == by_weight(openings)
        assert set(sailed.openings) == set(openings)
        centrally, here = turns(generations), turns(sailed.rounds)
        for first, then in of.graph.edges - no_duty:
            assert (here[first] < here[then]) is (centrally[first] < centrally[then])


def test_the_duties_that_are_opened_do_not_depend_on_who_is_quickest() -> None:
    generator = np.random.default_rng(3)
    for seed in range(GRAPHS // 3):
        of = random_fleet(seed)
        _, openings = open_cycles(of.graph, of.ranks)

        assert by_weight(by_timer(of, generator).openings) == by_weight(openings)


def test_after_the_timer_the_ships_log_every_opening_of_the_graph() -> None:
    for seed in range(GRAPHS // 10):
        of = random_fleet(seed)
        assert set(by_timer(of).openings) == set(open_cycles(of.graph, of.ranks)[1])


# --- one ship -------------------------------------------------------------------------------------

RING = ((A, B, DUTY), (B, C, DUTY), (C, A, DUTY))


def test_lightest_of_a_ring_is_released_and_says_which_duty_it_opens() -> None:
    assert fleet(*RING).jumpers(set()) == {B: (Opening(Edge(A, B, DUTY), "lightest first"),)}


def test_among_ships_of_equal_mass_the_smallest_id_is_released() -> None:
    assert fleet(*RING, masses={A: 1.0, B: 1.0, C: 1.0}).jumpers(set()).keys() == {A}


def test_ship_that_merely_waits_for_a_ring_does_not_jump_the_queue() -> None:
    of = fleet(*RING, (A, D, DUTY))  # d is the lightest of all

    assert released(D, of.gossip, NOBODY) is None


def test_no_ship_ever_jumps_the_queue_of_another_ring() -> None:
    for seed in range(GRAPHS // 5):
        of = random_fleet(seed)
        opened = [(each.edge.first, each.edge.then) for each in open_cycles(of.graph, of.ranks)[1]]
        duties: Digraph = nx.DiGraph(of.graph)
        duties.remove_edges_from(edge for edge in opened if of.graph.edges[edge]["kind"] is ORDER)
        rings = {ship: ring for ring in nx.strongly_connected_components(duties) for ship in ring}
        for ship in of.jumpers(set()):
            assert nx.ancestors(duties, ship) <= rings[ship]


def test_order_edge_on_a_cycle_releases_the_ship_behind_it_whatever_it_weighs() -> None:
    of = fleet((A, B, DUTY), (B, C, DUTY), (C, A, ORDER))

    assert of.jumpers(set()) == {A: (Opening(Edge(C, A, ORDER), "no duty"),)}


def test_order_edge_on_no_cycle_holds_a_ship_back() -> None:
    assert released(B, fleet((A, B, ORDER)).gossip, NOBODY) is None


def test_ships_that_have_decided_no_longer_count() -> None:
    of = fleet(*RING, (D, A, DUTY))

    assert released(B, of.gossip, NOBODY) is None
    assert released(B, of.gossip, frozenset({D})) == (Opening(Edge(A, B, DUTY), "lightest first"),)


def test_ring_goes_on_where_it_was_opened() -> None:
    of = fleet(*RING)

    assert of.jumpers({B}).keys() == {C}
    assert of.jumpers({B, C}).keys() == {A}


@pytest.mark.parametrize("unheard", [A, B, C, D])
def test_ship_that_has_not_heard_of_all_it_waits_for_is_not_released(unheard: ShipId) -> None:
    of = fleet((D, A, DUTY), *RING)
    heard = {ship: waiting for ship, waiting in of.gossip.items() if ship != unheard}

    assert released(B, heard, NOBODY) is None


def test_ship_need_not_have_heard_of_those_behind_it() -> None:
    of = fleet(*RING, (A, D, DUTY))
    heard = {ship: waiting for ship, waiting in of.gossip.items() if ship != D}

    assert released(B, heard, NOBODY) is not None


def test_ship_that_has_decided_need_not_have_been_heard_of() -> None:
    of = fleet((D, A, DUTY), *RING)
    heard = {ship: waiting for ship, waiting in of.gossip.items() if ship != D}

    assert released(B, heard, frozenset({D})) is not None


def test_gossip_cannot_be_changed() -> None:
    waiting = Waiting((1.0,), {A: DUTY})

    with pytest.raises(TypeError):
        waiting.waits_for[B] = DUTY  # type: ignore[index]


# --- other criteria than weight -------------------------------------------------------------------


def test_ring_is_opened_by_the_ranks_that_the_ships_tell_and_says_by_which_criterion() -> None:
    ranks = {A: (2.0, 1.0), B: (1.0, 5.0), C: (1.0, 4.0)}  # the second number decides between b and c
    heard = {
        ship: Waiting(ranks[ship], waiting.waits_for, "by length, weight")
        for ship, waiting in fleet(*RING).gossip.items()
    }

    assert released(B, heard, NOBODY) is None
    assert released(C, heard, NOBODY) == (Opening(Edge(B, C, DUTY), "by length, weight"),)
