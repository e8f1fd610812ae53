"""What a case expects of a ruleset, as files write it."""

from __future__ import annotations

from collections.abc import Iterable

from ..roles import PassingSide
from ..ships import ShipId
from ..strict_yaml import Reader
from ..verdict import Confidence, Kind
from ..yaml_nodes import Node, Sequence
from .cases import DIAGNOSES, CaseShip, Expected


class ExpectationReader:
    """Reads what is expected."""

    def __init__(self, reader: Reader) -> None:
        self._reader = reader

    def ship(self, node: Node, ids: Iterable[str]) -> str:
        """A ship of the case, or `none`."""
        text = self._reader.text(node)
        known = [*ids, "none"]
        if text and text not in known:
            self._reader.unknown(node, "ship", text, known)
        return text

    def expected(
        self,
        node: Node,
        ships: Iterable[CaseShip],
        *,
        hard: bool = False,
        order: tuple[ShipId, ...] | None = None,
        placed: bool = True,
    ) -> Expected:
        """What is expected of one ruleset."""
        reader = self._reader
        if hard and not placed:  # nothing to judge: the case is there to be read, and skipped
            told = {key.text: value for key, value in reader.entries(node)}
            diagnosis = told.get("diagnosis")
            return Expected(diagnosis=self._diagnosis(diagnosis) if diagnosis else None)
        block = reader.block(node)
        ids = [ship.id for ship in ships]

        def some(key: str) -> frozenset[ShipId] | None:
            found = block.find(key)
            return (
                None
                if found is None
                else frozenset(ShipId(each) for each in self._listed(found, ids, placed=placed))
            )

        def one(key: str) -> ShipId | None:
            found = block.find(key)
            return None if found is None else ShipId(self.ship(found, ids))

        def word(key: str) -> str | None:
            found = block.find(key)
            return None if found is None else reader.text(found)

        def pairs(key: str) -> frozenset[tuple[ShipId, ...]] | None:
            found = block.find(key)
            if found is None:
                return None
            listed = [
                self._listed(each, ids, placed=placed, at_least=2, at_most=2) for each in reader.items(found)
            ]
            return frozenset(tuple(ShipId(each) for each in pair) for pair in listed)

        give_way, stand_on = some("give_way"), some("stand_on")
        kind = block.find("kind")
        passing = block.find("pass")
        diagnosis = block.find("diagnosis")
        for key in ("note", "signal", "cooperates", "suggested", "verdict", "obligations"):
            block.find(key)
        confidence = block.find("confidence")
        sequence = block.find("order")
        found = Expected(
            kind=reader.choice(kind, Kind).value if kind else _kind_of(give_way, hard=hard),
            give_way=give_way,
            stand_on=stand_on,
            initiator=one("initiator"),
            passing_side=reader.choice(passing, PassingSide).value if passing else None,
            strength=word("strength"),
            side_chosen_by=one("side_chosen_by"),
            must_follow=some("must_follow"),
            facilitates=some("facilitates"),
            manoeuvre=word("required_manoeuvre") or word("manoeuvre"),
            reason=word("reason"),
            rule=word("by"),
            article=word("article") or "",
            diagnosis=self._diagnosis(diagnosis) if diagnosis else None,
            gives_way_to=pairs("gives_way_to"),  # type: ignore[arg-type]
            mutual=_unordered(pairs("mutual")),
            no_rule=_unordered(pairs("no_rule")),
            cycle=some("cycle"),
            order=tuple(ShipId(each) for each in self._listed(sequence, ids, placed=placed))
            if sequence
            else order,
            confidence=reader.choice(confidence, Confidence) if confidence else None,
        )
        if not hard and found.kind is None and found.diagnosis is None:
            reader.refuse(node, "nothing is expected", expected="kind, give_way or diagnosis")
        block.done()
        return found

    def _diagnosis(self, node: Node) -> str:
        text = self._reader.text(node)
        if text and text not in DIAGNOSES:
            self._reader.unknown(node, "diagnosis", text, DIAGNOSES)
        return text

    def _listed(
        self,
        node: Node,
        ids: Iterable[str],
        *,
        placed: bool = True,
        at_least: int = 0,
        at_most: int = 100,
    ) -> list[str]:
        """Ships of a list, or the one ship that stands there."""
        nodes = node.items if isinstance(node, Sequence) else (node,)
        if not at_least <= len(nodes) <= at_most:
            self._reader.refuse(node, f"a list of {len(nodes)}", expected=f"{at_least} ships")
        if not placed:
            return [self._reader.text(each) for each in nodes]
        return [self.ship(each, ids) for each in nodes]

    def resolution(self, node: Node | None) -> tuple[ShipId, ...] | None:
        """Order in which ships decide where a cycle is opened."""
        if node is None:
            return None
        block = self._reader.block(node)
        for key in ("secondary", "lightest_decides_first", "note"):
            block.find(key)
        order = block.find("order")
        block.done()
        return tuple(ShipId(self._reader.text(each)) for each in self._reader.items(order)) if order else None


def _kind_of(give_way: frozenset[ShipId] | None, *, hard: bool) -> str | None:
    if hard or give_way is None:
        return None
    return {0: None, 1: Kind.GIVE_WAY.value}.get(len(give_way), Kind.MUTUAL.value)


def _unordered(pairs: frozenset[tuple[ShipId, ...]] | None) -> frozenset[frozenset[ShipId]] | None:
    return None if pairs is None else frozenset(frozenset(pair) for pair in pairs)
