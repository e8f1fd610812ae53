"""The rulesets that we ship, as a plugin like any other."""

from __future__ import annotations

from collections.abc import Iterable

from ccas_core.hookspecs import hookimpl
from ccas_core.tapd.ruleset import AbstractRuleset

from .tran2026 import Tran2026, Tran2026Printed


@hookimpl
def ccas_rulesets() -> Iterable[AbstractRuleset]:
    """Return the rulesets that we ship."""
    return (Tran2026(), Tran2026Printed())
