"""Plugins that observe a voyage: each is told of every event, and none can stop it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final, Protocol

from .events import DeadlockDetected, Event, OrderDecided, RulesetSwitched
from .plugin_failures import Failure

HOOKS: Final = {
    OrderDecided: "ccas_order_decided",
    RulesetSwitched: "ccas_ruleset_switched",
    DeadlockDetected: "ccas_deadlock_detected",
}


class Host(Protocol):
    """Host of one plugin, as pluggy has it."""

    @property
    def hook(self) -> Any:  # noqa: ANN401 - a caller for every hook, by its name
        """Callers of hooks."""


class Observers:
    """Plugins that observe a voyage; one that raises is told of once, and not asked again for that event."""

    def __init__(
        self, hosts: Iterable[tuple[str, Host]] = (), packages: Mapping[str, str] | None = None
    ) -> None:
        self._hosts = tuple(hosts)
        self._packages = packages or {}
        self._silenced: set[tuple[str, str]] = set()

    def tell(self, event: Event) -> Iterator[Failure]:
        """Tell all observers of an event; yield those that failed."""
        hook = HOOKS[type(event)]
        for name, host in self._hosts:
            caller = getattr(host.hook, hook)
            if (name, hook) in self._silenced or not caller.get_hookimpls():
                continue
            try:
                caller(event=event)
            except Exception as error:  # a plugin may raise anything, and the voyage goes on
                self._silenced.add((name, hook))
                yield Failure(
                    plugin=name,
                    target=hook,
                    cause=f"{hook} raised {type(error).__name__}: {error}",
                    effect="it observes no more such events; the voyage goes on",
                    package=self._packages.get(name, ""),
                    whole=False,
                )
