"""Every hook of CCAS, one sentence each.  A plugin imports `hookimpl` from here and nothing of pluggy."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import pluggy

if TYPE_CHECKING:
    from .tapd.ruleset import AbstractRuleset

PROJECT = "ccas"
hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


@hookspec
def ccas_rulesets() -> Iterable[AbstractRuleset]:  # type: ignore[empty-body]
    """Return rulesets; each has an id that no other plugin uses."""
