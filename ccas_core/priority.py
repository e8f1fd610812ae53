"""The priority graph: all that passes from layer 1 to layer 2 (Sec. 3.1, TAPD steps 2 to 5).

An edge u -> v says that *u decides before v*.  A duty edge says why: u gives way to v.  An order
edge carries no duty.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import networkx as nx

from .roles import Geometry, PassingSide, Role
from .ships import ShipId
from .verdict import Kind, Verdict, agree

if TYPE_CHECKING:
    from typing import TypeAlias

    Digraph: TypeAlias = "nx.DiGraph[ShipId]"


LIGHTEST_FIRST: Final = "lightest first"  # the criterion of Sec. 3.2, by which a ring of ships is opened


class EdgeKind(StrEnum):
    """Why one ship decides before another."""

    DUTY = "duty"
    ORDER = "order"


@dataclass(frozen=True, slots=True)
class Edge:
    """`first` decides before `then`."""

    first: ShipId
    then: ShipId
    kind: EdgeKind


@dataclass(frozen=True, slots=True)
class Opening:
    """An edge left out of the order, and by which criterion: the order there is not the legal one."""

    edge: Edge
    criterion: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Settlement:
    """What two ships make of their two views: the verdict that both apply.

    `fallback` says why the safe mutual rule stands in for the verdicts; it is empty where they agree.
    """

    one: Verdict  # view of the ship with the smaller id
    other: Verdict
    fallback: str
    edge: Edge | None

    @property
    def pair(self) -> tuple[ShipId, ShipId]:
        """The two ships, sorted."""
        return self.one.own, self.one.other

    @property
    def geometry(self) -> Geometry:
        """How the ships meet, as the first view has it."""
        return self.one.geometry

    @property
    def mutual(self) -> bool:
        """Whether both ships are to act."""
        return bool(self.fallback) or self.one.kind is Kind.MUTUAL


@dataclass(frozen=True, slots=True, kw_only=True)
class Bearing:
    """What layer 2 may read about a neighbour: nothing else of a rule reaches it."""

    role: Role
    passing_side: PassingSide | None
    geometry: Geometry


NO_BEARING = Bearing(role=Role.NONE, passing_side=None, geometry=Geometry.NONE)
_FALL_BACK = (Kind.NEGOTIATE, Kind.CONFLICT, Kind.GAP, Kind.UNKNOWN_FACT)


def settle(one: Verdict, other: Verdict, masses: Mapping[ShipId, float]) -> Settlement:
    """Settle the two views of a pair into an edge, a mutual mark, or nothing.

    Views that do not fit, and verdicts that decide nothing, become the safe mutual rule: both give
    way, and the lighter ship (then the smaller id) decides first.  Both ships compute this from the
    same two messages, so both come to the same settlement.
    """
    if one.own > other.own:
        one, other = other, one
    own, target = one.own, one.other
    if (other.own, other.other) != (target, own):
        raise ValueError(f"verdicts of one pair belong together, got {one.pair} and {other.pair}")
    reason = agree(one, other)
    if not reason and one.kind in _FALL_BACK:
        reason = f"{one.kind}: {one.reason}" if one.reason else str(one.kind)
    if reason:
        first = min((own, target), key=lambda ship: (masses[ship], ship))
        then = target if first == own else own
        return Settlement(one=one, other=other, fallback=reason, edge=Edge(first, then, EdgeKind.ORDER))
    return Settlement(one=one, other=other, fallback="", edge=_edge(one))


def _edge(verdict: Verdict) -> Edge | None:
    own, target = verdict.own, verdict.other
    if verdict.kind is Kind.GIVE_WAY:
        return Edge(own, target, EdgeKind.DUTY)
    if verdict.kind is Kind.STAND_ON:
        return Edge(target, own, EdgeKind.DUTY)
    if verdict.kind in (Kind.COOPERATE, Kind.PROHIBITED) and verdict.initiator is not None:
        initiator = verdict.initiator
        kind = EdgeKind.DUTY if verdict.kind is Kind.PROHIBITED else EdgeKind.ORDER
        return Edge(initiator, target if initiator == own else own, kind)
    return None


@dataclass(frozen=True, kw_only=True, eq=False)
class PriorityGraph:
    """Who decides before whom, and what each pair owes: a frozen value around a `networkx.DiGraph`.

    Parameters
    ----------
    masses
        Displacement of every ship [kg]; a ship without edges stands here all the same.
    settlements
        One a pair that met.  No pair may come twice, and no unknown ship.
    ranks
        Place of every ship among those that wait for one another in a ring, the least first; by displacement,
        unless a ruleset has criteria of its own.  Ships that are alike are told apart by their ids.
    criterion
        What the ranks go by, for the log.

    Examples
    --------
    >>> graph = PriorityGraph(masses={ShipId("a"): 1.0, ShipId("b"): 2.0}, settlements=())
    >>> graph.generations()
    (('a', 'b'),)
    """

    masses: Mapping[ShipId, float]
    settlements: tuple[Settlement, ...] = ()
    ranks: Mapping[ShipId, tuple[float, ...]] | None = None
    criterion: str = LIGHTEST_FIRST
    _by_pair: Mapping[tuple[ShipId, ShipId], Settlement] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        pairs = [settlement.pair for settlement in self.settlements]
        if len(set(pairs)) != len(pairs):
            raise ValueError("a pair of ships is settled twice")
        strangers = {ship for pair in pairs for ship in pair} - set(self.masses)
        if strangers:
            raise ValueError(f"unknown ships in the priority graph: {', '.join(sorted(strangers))}")
        set_ = object.__setattr__
        set_(self, "masses", MappingProxyType(dict(self.masses)))
        set_(self, "_by_pair", MappingProxyType(dict(zip(pairs, self.settlements, strict=True))))

    @cached_property  # a ship that asks for its bearings only needs no order
    def digraph(self) -> Digraph:
        """Who decides before whom, cycles not yet opened; frozen."""
        graph: Digraph = nx.DiGraph()
        graph.add_nodes_from(sorted(self.masses))
        for settlement in self.settlements:
            if settlement.edge is not None:
                edge = settlement.edge
                graph.add_edge(edge.first, edge.then, kind=edge.kind)
        frozen: Digraph = nx.freeze(graph)
        return frozen

    @cached_property
    def _opened(self) -> tuple[tuple[tuple[ShipId, ...], ...], tuple[Opening, ...]]:
        ranks = self.ranks or {ship: (mass,) for ship, mass in self.masses.items()}
        return open_cycles(self.digraph, ranks, self.criterion)

    @property
    def order(self) -> tuple[tuple[ShipId, ...], ...]:
        """Generations of ships, cycles opened."""
        return self._opened[0]

    @property
    def openings(self) -> tuple[Opening, ...]:
        """Edges that had to be opened, and why."""
        return self._opened[1]

    def generations(self) -> tuple[tuple[ShipId, ...], ...]:
        """Ships in the order of decision; those of one generation decide at the same time."""
        return self.order

    def cycles(self) -> tuple[tuple[ShipId, ...], ...]:
        """Groups of ships that wait for one another in a ring, each sorted."""
        rings = (c for c in nx.strongly_connected_components(self.digraph) if len(c) > 1)
        return tuple(sorted(tuple(sorted(ring)) for ring in rings))

    def waits_for(self, ship: ShipId) -> frozenset[ShipId]:
        """Ships that decide before this one, cycles not yet opened."""
        return frozenset(self.digraph.predecessors(ship))

    def bearing(self, own: ShipId, other: ShipId) -> Bearing:
        """What layer 2 of `own` may know of its encounter with `other`."""
        settlement = self._by_pair.get((min(own, other), max(own, other)))
        return NO_BEARING if settlement is None else bearing(settlement, own)


def bearing(settlement: Settlement, own: ShipId) -> Bearing:
    """Read a settlement from the side of one of its ships."""
    side = None if settlement.fallback else settlement.one.passing_side
    edge = settlement.edge
    if settlement.mutual:
        role = Role.BOTH
    elif edge is None or edge.kind is EdgeKind.ORDER:
        role = Role.NONE
    else:
        role = Role.GIVE_WAY if edge.first == own else Role.STAND_ON
    return Bearing(role=role, passing_side=side, geometry=settlement.geometry)


def open_cycles(
    graph: Digraph, ranks: Mapping[ShipId, tuple[float, ...]], criterion: str = LIGHTEST_FIRST
) -> tuple[tuple[tuple[ShipId, ...], ...], tuple[Opening, ...]]:
    """Order the ships, and open the cycles that stand in the way (Sec. 3.2).

    Order edges on a cycle go first.  Then, in each source component of what is left, a ship alone
    decides, and among several the first by rank does (then the smallest id), until none is left.
    """
    left: Digraph = nx.DiGraph(graph)
    openings = []
    for edge in order_edges_on_cycles(left):
        left.remove_edge(edge.first, edge.then)
        openings.append(Opening(edge, "no duty"))
    generations = []
    while left:
        generation = []
        for component in source_components(left):
            first = min(component, key=lambda ship: (ranks[ship], ship))
            generation.append(first)
            openings.extend(
                Opening(Edge(other, first, left.edges[other, first]["kind"]), criterion)
                for other in sorted(left.predecessors(first))
            )
        left.remove_nodes_from(generation)
        generations.append(tuple(sorted(generation)))
    return tuple(generations), tuple(openings)


def source_components(graph: Digraph) -> Iterator[frozenset[ShipId]]:
    """Strongly connected components that wait for no ship outside: these may decide now."""
    for component in nx.strongly_connected_components(graph):
        if all(before in component for ship in component for before in graph.predecessors(ship)):
            yield frozenset(component)


def order_edges_on_cycles(graph: Digraph) -> tuple[Edge, ...]:
    """Edges without a duty between ships that wait for one another: the first to be left out."""
    home = {ship: n for n, ring in enumerate(nx.strongly_connected_components(graph)) for ship in ring}
    edges = (Edge(first, then, graph.edges[first, then]["kind"]) for first, then in sorted(graph.edges))
    return tuple(e for e in edges if e.kind is EdgeKind.ORDER and home[e.first] == home[e.then])
