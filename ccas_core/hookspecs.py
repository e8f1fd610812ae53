"""Every hook of CCAS, one sentence each.  A plugin imports `hookimpl` from here and nothing of pluggy.

Arguments are single values with fields, so that fields can be added; a hook is never changed otherwise.
`API` counts the changes that break plugins; a plugin may say which one it was written for.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import pluggy

if TYPE_CHECKING:
    from .controllers import AbstractController
    from .events import DeadlockDetected, OrderDecided, RulesetSwitched
    from .regions import Region
    from .tapd.python_rules import PythonRule
    from .tapd.ranking import RankingCriterion
    from .tapd.ruleset import AbstractRuleset
    from .tapd.vocabulary import Fact

PROJECT: Final = "ccas"
API: Final = 1
hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


@dataclass(frozen=True, slots=True, kw_only=True)
class PluginInfo:
    """What a plugin says of itself."""

    name: str
    version: str
    api: int = API  # of the hooks for which it was written
    homepage: str = ""


@hookspec(firstresult=True)
def ccas_plugin_info() -> PluginInfo:  # type: ignore[empty-body]
    """Return what the plugin is called, and for which version of the hooks it was written."""


@hookspec
def ccas_facts() -> Iterable[Fact]:  # type: ignore[empty-body]
    """Return facts that are added to the vocabulary of all rulesets."""


@hookspec
def ccas_rulesets() -> Iterable[AbstractRuleset | Path]:  # type: ignore[empty-body]
    """Return rulesets, or paths of ruleset files; each has an id that no other plugin uses."""


@hookspec
def ccas_pair_rules() -> Iterable[PythonRule]:  # type: ignore[empty-body]
    """Return rules in plain Python, which ruleset files ask for by their names."""


@hookspec
def ccas_criteria() -> Iterable[RankingCriterion]:  # type: ignore[empty-body]
    """Return criteria by which a ruleset may say who decides first in a ring of ships."""


@hookspec
def ccas_regions() -> Iterable[Region]:  # type: ignore[empty-body]
    """Return regions, which scenarios ask for by their ids."""


@hookspec
def ccas_controllers() -> Iterable[AbstractController]:  # type: ignore[empty-body]
    """Return controllers, which ships of a scenario ask for by their names: `control: NAME`."""


@hookspec
def ccas_order_decided(event: OrderDecided) -> None:
    """Observe that the ships have decided in an order."""


@hookspec
def ccas_ruleset_switched(event: RulesetSwitched) -> None:
    """Observe that a ship has come under another ruleset."""


@hookspec
def ccas_deadlock_detected(event: DeadlockDetected) -> None:
    """Observe that ships waited for one another in a ring, and how it was opened."""
