"""Deadlocks, found and opened without a coordinator (Sec. 3.2).

Ships tell one another whom they wait for.  A ship whose timer T_DL has run out looks at what it
has heard: it may decide if it lies in a source component (nobody it waits for, at any remove,
fails to wait for it) and is the first there by rank, as a rule the lightest, then the one with the
smallest id.  A ship that merely waits for a ring must not jump the queue.  `priority.open_cycles` gives the
same order.
"""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from types import MappingProxyType

import networkx as nx

from ..priority import LIGHTEST_FIRST, Edge, EdgeKind, Opening, order_edges_on_cycles
from ..ships import ShipId


@dataclass(frozen=True, slots=True)
class Waiting:
    """Whom a ship waits for in this period, and by which kind of edge.

    `rank` is its place among those that wait for one another (the least decides first), by the criteria that
    `criterion` names; those of its ruleset.
    """

    rank: tuple[float, ...]
    waits_for: Mapping[ShipId, EdgeKind] = field(default_factory=dict)
    criterion: str = LIGHTEST_FIRST

    def __post_init__(self) -> None:
        object.__setattr__(self, "waits_for", MappingProxyType(dict(self.waits_for)))


def opened_orders(
    own: ShipId, heard: Mapping[ShipId, Waiting], decided: AbstractSet[ShipId]
) -> tuple[Opening, ...]:
    """Order edges for which `own` need not wait, because they lie on a cycle: these go first.

    Empty where not all is heard yet.  This needs no timer: nobody owes anything by an order edge.
    """
    if own not in heard or EdgeKind.ORDER not in heard[own].waits_for.values():
        return ()
    graph = _waiting_graph(own, heard, decided)
    orders = () if graph is None else order_edges_on_cycles(graph)
    return tuple(Opening(edge, "no duty") for edge in orders if edge.then == own)


def released(
    own: ShipId, heard: Mapping[ShipId, Waiting], decided: AbstractSet[ShipId]
) -> tuple[Opening, ...] | None:
    """Say whether `own` may decide although it waits, and which edges that opens.

    None where it may not: because others come first, or because not all is heard yet.  Call it
    when T_DL has passed without progress.
    """
    graph = _waiting_graph(own, heard, decided)
    if graph is None:
        return None
    orders = order_edges_on_cycles(graph)
    graph.remove_edges_from([(edge.first, edge.then) for edge in orders])
    graph.remove_nodes_from([ship for ship in graph if ship in decided and ship != own])
    ring = next(ring for ring in nx.strongly_connected_components(graph) if own in ring)
    if any(before not in ring for ship in ring for before in graph.predecessors(ship)):
        return None
    if own != min(ring, key=lambda ship: (heard[ship].rank, ship)):
        return None
    duties = (
        Edge(before, own, graph.edges[before, own]["kind"]) for before in sorted(graph.predecessors(own))
    )
    return (
        *(Opening(edge, "no duty") for edge in orders if edge.then == own),
        *(Opening(edge, heard[own].criterion) for edge in duties),
    )


def _waiting_graph(
    own: ShipId, heard: Mapping[ShipId, Waiting], decided: AbstractSet[ShipId]
) -> nx.DiGraph[ShipId] | None:
    """Who waits for whom among all for which `own` waits at any remove; None if not all is heard."""
    ancestors = _ancestors(own, heard, decided)
    if ancestors is None:
        return None
    graph: nx.DiGraph[ShipId] = nx.DiGraph()
    for ship in ancestors:
        graph.add_node(ship)
        graph.add_edges_from((before, ship, {"kind": kind}) for before, kind in heard[ship].waits_for.items())
    return graph


def _ancestors(
    own: ShipId, heard: Mapping[ShipId, Waiting], decided: AbstractSet[ShipId]
) -> set[ShipId] | None:
    """Ship `own` and all for which it waits at any remove; None if one of them has not been heard."""
    found: set[ShipId] = set()
    frontier = [own]
    while frontier:
        ship = frontier.pop()
        if ship in found:
            continue
        if ship not in heard:
            if ship in decided:
                continue  # it holds nobody up any more
            return None
        found.add(ship)
        frontier.extend(heard[ship].waits_for)
    return found
