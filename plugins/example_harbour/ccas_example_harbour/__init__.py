"""A sample plugin: the by-law of a harbour on top of the BPR, a fact, a rule in Python, an observer."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ccas_core.events import OrderDecided
from ccas_core.hookspecs import PluginInfo, hookimpl
from ccas_core.regions import Region
from ccas_core.tapd.python_rules import PairView, PythonRule, RoleDecision, ShipView
from ccas_core.tapd.vocabulary import Fact, Kind, Scope, Source

DECIDED: Counter[int] = Counter()  # how often so many ships had to decide one after the other

# Art. 3: points for the need of deep water.  A table of the by-law, which a condition cannot hold.
DRAUGHT_POINTS = ((10.0, 3), (7.0, 2), (4.0, 1), (0.0, 0))  # from this draught [m]: points


@hookimpl
def ccas_plugin_info() -> PluginInfo:
    """Say who we are."""
    return PluginInfo(name="example harbour", version="1.0.0")


@hookimpl
def ccas_facts() -> Iterable[Fact]:
    """Return the fact that the by-law needs, besides those that there are."""
    yield Fact(
        name="tug_assisted",
        scope=Scope.SHIP,
        kind=Kind.FLAG,
        meaning="is made fast to a tug",
        source=Source.MESSAGE,
        default=False,
    )


@hookimpl
def ccas_rulesets() -> Iterable[Path]:
    """Return the ruleset file, which lies beside this module."""
    yield Path(__file__).with_name("harbour.yaml")


@hookimpl
def ccas_pair_rules() -> Iterable[PythonRule]:
    """Return the rule that `harbour.yaml` asks for by `python: deep_water`."""
    yield PythonRule("deep_water", deep_water)


def deep_water(pair: PairView) -> RoleDecision | None:
    """Say that the ship with fewer points gives way; with as many, the articles that follow decide."""
    own, other = points(pair.own), points(pair.other)
    if own >= other:
        return None  # the rule is asked with the ships swapped, too
    because = f"{own} points for deep water against {other}"
    return RoleDecision("give_way", because=because, strength="keep_clear")


def points(ship: ShipView) -> int:
    """Count the points of a ship: for its draught, and one for a tug.

    >>> from types import SimpleNamespace
    >>> points(SimpleNamespace(draught=8.0, tug_assisted=True))
    3
    """
    for_draught = next(count for least, count in DRAUGHT_POINTS if ship.draught >= least)
    return for_draught + bool(ship.tug_assisted)


@hookimpl
def ccas_regions() -> Iterable[Region]:
    """Return the harbour, for scenarios that name it: `regions: [example_harbour]`."""
    corners = [[-400.0, -400.0], [-400.0, 400.0], [400.0, 400.0], [400.0, -400.0]]  # north, east [m]
    yield Region(id="example_harbour", ruleset="harbour", polygon=np.array(corners))


@hookimpl
def ccas_order_decided(event: OrderDecided) -> None:
    """Count, and do nothing else: an observer cannot change anything."""
    DECIDED[len(event.generations)] += 1
