"""The typed host of plugins: loads them one by one, collects what they return, reports what failed.

Our own rulesets come in by the same entry points as anybody's.  A plugin that cannot be loaded is
left out and reported; the others work on.
"""

from __future__ import annotations

import importlib.metadata
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

import pluggy

from . import hookspecs
from .errors import Diagnostic, RulesetError, did_you_mean
from .tapd.ruleset import AbstractRuleset

GROUP = "ccas"


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


@dataclass(frozen=True, slots=True)
class Failure:
    """A plugin that was left out, and why."""

    plugin: str
    target: str
    cause: str
    hint: str

    def __str__(self) -> str:
        return (
            f"warning: plugin {self.plugin!r} ({self.target}) is left out\n"
            f"    cause: {self.cause}\n    effect: what it offers is not available\n    hint: {self.hint}"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Plugins:
    """What all plugins offer, by id, and what was left out."""

    rulesets: Mapping[str, AbstractRuleset]
    owners: Mapping[str, str]  # ruleset id -> plugin
    loaded: Mapping[str, str]  # plugin -> module
    failures: tuple[Failure, ...]

    def ruleset(self, id_: str) -> AbstractRuleset:
        """Ruleset by its id.

        Raises
        ------
        RulesetError
            If no plugin that works offers it; the hint names what comes nearest.
        """
        if id_ in self.rulesets:
            return self.rulesets[id_]
        hint = did_you_mean(id_, self.rulesets)
        if self.failures:
            hint += f"; {len(self.failures)} plugin(s) could not be loaded, see `ccas plugins`"
        raise RulesetError(Diagnostic(source="ruleset", message=f"unknown ruleset {id_!r}", hint=hint))


def load(
    entry_points: Iterable[EntryPoint] | None = None, trace: Callable[[str], object] | None = None
) -> Plugins:
    """Load plugins from entry points (those installed, unless given) and collect what they offer.

    `trace`, if given, is called with a line for every hook call, saying who answered what.
    """
    points = importlib.metadata.entry_points(group=GROUP) if entry_points is None else entry_points
    loaded: dict[str, str] = {}
    failures: list[Failure] = []
    offers: dict[str, list[tuple[str, AbstractRuleset]]] = {}
    for point in sorted(points, key=lambda each: each.name):
        try:
            answers = _ask(point, trace)
        except Exception as error:  # a plugin may raise anything at import
            cause = f"{type(error).__name__}: {error}"
            failures.append(Failure(point.name, point.value, cause, "mend it, or uninstall it"))
            continue
        loaded[point.name] = point.value
        for ruleset in answers:
            offers.setdefault(ruleset.id, []).append((point.name, ruleset))
    rulesets, owners = {}, {}
    for id_, offered in sorted(offers.items()):
        if len(offered) > 1:
            names = " and ".join(repr(name) for name, _ in offered)
            cause = f"plugins {names} both define ruleset {id_!r}"
            failures.append(Failure(offered[-1][0], id_, cause, "rename one of the two"))
            continue
        owners[id_], rulesets[id_] = offered[0]
    return Plugins(
        rulesets=MappingProxyType(rulesets),
        owners=MappingProxyType(owners),
        loaded=MappingProxyType(loaded),
        failures=tuple(failures),
    )


def _ask(point: EntryPoint, trace: Callable[[str], object] | None) -> list[AbstractRuleset]:
    """Import one plugin, register it with a host of its own, and collect its rulesets."""
    manager = pluggy.PluginManager(hookspecs.PROJECT)
    manager.add_hookspecs(hookspecs)
    plugin = point.load()
    manager.register(plugin, name=point.name)
    _check_names(plugin)
    manager.check_pending()
    answers = manager.hook.ccas_rulesets()
    if len(answers) < len(manager.hook.ccas_rulesets.get_hookimpls()):  # pluggy drops None
        raise TypeError("ccas_rulesets must return rulesets, got None")
    rulesets = [ruleset for answer in answers for ruleset in answer]
    for ruleset in rulesets:
        if not isinstance(ruleset, AbstractRuleset):
            raise TypeError(f"ccas_rulesets must return rulesets, got {type(ruleset).__name__}")
        for name in ("id", "version", "title"):
            if not isinstance(value := getattr(ruleset, name, None), str) or not value:
                raise TypeError(f"{name} of {type(ruleset).__name__} must be a text, got {value!r}")
    if trace is not None:
        trace(f"{point.name}: ccas_rulesets -> {', '.join(ruleset.id for ruleset in rulesets) or 'nothing'}")
    return rulesets


def _check_names(plugin: object) -> None:
    """Refuse a misspelt hook, with the name that was probably meant."""
    known = [name for name in vars(hookspecs) if name.startswith("ccas_")]
    for name in dir(plugin):
        if name.startswith("ccas_") and callable(getattr(plugin, name)) and name not in known:
            raise TypeError(f"unknown hook {name!r}; {did_you_mean(name, known)}")


def warn(failures: Iterable[Failure]) -> None:
    """Say on the standard error which plugins were left out."""
    for failure in failures:
        print(failure, file=sys.stderr)
