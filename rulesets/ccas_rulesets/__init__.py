"""The rulesets that we ship, as a plugin like any other: files, and nothing of a regulation in Python."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ccas_core.hookspecs import PluginInfo, hookimpl

FOLDER = Path(__file__).parent


@hookimpl
def ccas_plugin_info() -> PluginInfo:
    """Say who we are."""
    from importlib.metadata import version

    return PluginInfo(name="rulesets", version=version("ccas"))


@hookimpl
def ccas_rulesets() -> Iterable[Path]:
    """Return the files of the rulesets that we ship."""
    return sorted(path for path in FOLDER.glob("*.yaml") if not path.name.endswith(".tests.yaml"))
