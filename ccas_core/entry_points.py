"""Entry points of plugins: where each comes from, and which of them claim the same name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol

from .plugin_failures import Failure


class EntryPoint(Protocol):
    """What is needed of an entry point; `importlib.metadata.EntryPoint` has it."""

    @property
    def name(self) -> str:
        """Name of the plugin."""

    @property
    def value(self) -> str:
        """Module that it points at."""

    def load(self) -> object:
        """Import the plugin."""


def package_of(point: EntryPoint) -> str:
    """Name and version of the distribution that an entry point comes from; empty where it is not known."""
    distribution = getattr(point, "dist", None)
    return f"{distribution.name} {distribution.version}" if distribution is not None else ""


def apart(points: Iterable[EntryPoint], failures: list[Failure]) -> Iterator[EntryPoint]:
    """Plugins whose names are their own; a name that two packages use is refused to both."""
    named: dict[str, list[EntryPoint]] = {}
    for point in points:
        named.setdefault(point.name, []).append(point)
    for name, same in sorted(named.items()):
        if len(same) == 1:
            yield same[0]
            continue
        owners = " and ".join(sorted(package_of(each) or each.value for each in same))
        cause = f"{owners} both define a plugin {name!r}"
        targets = ", ".join(sorted(each.value for each in same))
        failures.append(Failure(plugin=name, target=targets, cause=cause, hint="uninstall one of the two"))
