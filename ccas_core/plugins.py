"""The typed host of plugins: loads them one by one, collects what they offer, reports what failed.

Our own rulesets come in by the same entry points as anybody's.  A plugin that cannot be loaded is
left out and reported; the others work on.  No other module touches pluggy, but `hookspecs`.
"""

from __future__ import annotations

import importlib.metadata
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Protocol

import pluggy

from . import hookspecs
from .errors import Diagnostic, RulesetError, did_you_mean
from .events import DeadlockDetected, Event, OrderDecided, RulesetSwitched
from .hookspecs import PluginInfo
from .tapd.library import RulesetLibrary, id_in
from .tapd.python_rules import PythonRule
from .tapd.ranking import RankingCriterion
from .tapd.ruleset import AbstractRuleset
from .tapd.vocabulary import VOCABULARY, Fact, Vocabulary
from .waterway import Region

GROUP: Final = "ccas"
_OBSERVERS: Final = {
    OrderDecided: "ccas_order_decided",
    RulesetSwitched: "ccas_ruleset_switched",
    DeadlockDetected: "ccas_deadlock_detected",
}
_COLLECTED: Final[Mapping[str, tuple[type, ...]]] = {  # what may be returned, by hook
    "ccas_facts": (Fact,),
    "ccas_rulesets": (AbstractRuleset, Path),
    "ccas_pair_rules": (PythonRule,),
    "ccas_criteria": (RankingCriterion,),
    "ccas_regions": (Region,),
}


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
    """A plugin that was left out, or a part of it, and why."""

    plugin: str
    target: str
    cause: str
    hint: str
    effect: str = "what it offers is not available"

    def __str__(self) -> str:
        return (
            f"warning: plugin {self.plugin!r} ({self.target}) is left out\n"
            f"    cause: {self.cause}\n    effect: {self.effect}\n    hint: {self.hint}"
        )


@dataclass(slots=True, kw_only=True)
class _Loaded:
    """One plugin, and what it offers."""

    name: str
    target: str
    manager: pluggy.PluginManager
    info: PluginInfo | None
    offers: dict[str, list[Any]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Plugins:
    """What all plugins offer, by id, and what was left out."""

    rulesets: RulesetLibrary
    owners: Mapping[str, str]  # ruleset id -> plugin
    loaded: Mapping[str, str]  # plugin -> module
    failures: tuple[Failure, ...]
    infos: Mapping[str, PluginInfo]
    hooks: Mapping[str, tuple[str, ...]]  # plugin -> hooks that it implements
    vocabulary: Vocabulary
    facts: Mapping[str, str]  # name of a fact -> plugin that adds it
    pair_rules: Mapping[str, PythonRule]
    criteria: Mapping[str, RankingCriterion]
    regions: Mapping[str, Region]
    _managers: tuple[tuple[str, pluggy.PluginManager], ...] = ()

    def ruleset(self, name: str) -> AbstractRuleset:
        """Ruleset by its id, or by the path of its file.

        Raises
        ------
        RulesetError
            If no plugin that works offers it, with the name that comes nearest; or with all that is wrong
            in its file.
        """
        if name in self.rulesets:
            return self.rulesets[name]
        if name.endswith((".yaml", ".yml")) or "/" in name:
            return self.rulesets.loaded(Path(name))
        hint = did_you_mean(name, self.rulesets)
        if self.failures:
            hint += f"; {len(self.failures)} plugin(s) could not be loaded, see `ccas plugins`"
        raise RulesetError(Diagnostic(source="ruleset", message=f"unknown ruleset {name!r}", hint=hint))

    def observers(self) -> Observers:
        """Those who want to know what happens on a voyage."""
        return Observers(self._managers)


class Observers:
    """Plugins that observe a voyage; one that raises is told of once, and not asked again for that event."""

    def __init__(self, managers: Iterable[tuple[str, pluggy.PluginManager]]) -> None:
        self._managers = tuple(managers)
        self._silenced: set[tuple[str, str]] = set()

    def tell(self, event: Event) -> Iterator[Failure]:
        """Tell all observers of an event; yield those that failed."""
        hook = _OBSERVERS[type(event)]
        for name, manager in self._managers:
            if (name, hook) in self._silenced or not getattr(manager.hook, hook).get_hookimpls():
                continue
            try:
                getattr(manager.hook, hook)(event=event)
            except Exception as error:  # a plugin may raise anything, and the voyage goes on
                self._silenced.add((name, hook))
                cause = f"{hook} raised {type(error).__name__}: {error}"
                yield Failure(
                    name, hook, cause, "mend it, or uninstall it", "it observes no more such events"
                )


def load(
    entry_points: Iterable[EntryPoint] | None = None, trace: Callable[[str], object] | None = None
) -> Plugins:
    """Load plugins from entry points (those installed, unless given) and collect what they offer.

    `trace`, if given, is called with a line for every hook call, saying who answered what.  Ruleset files
    are read when a ruleset is first asked for.
    """
    points = importlib.metadata.entry_points(group=GROUP) if entry_points is None else entry_points
    loaded: list[_Loaded] = []
    failures: list[Failure] = []
    vocabulary = VOCABULARY
    facts: dict[str, str] = {}
    for point in sorted(points, key=lambda each: each.name):
        try:
            plugin = _loaded(point, trace)
            vocabulary = vocabulary.extended(plugin.offers["ccas_facts"])
        except Exception as error:  # a plugin may raise anything at import
            cause = f"{type(error).__name__}: {error}"
            failures.append(Failure(point.name, point.value, cause, "mend it, or uninstall it"))
            continue
        facts |= {fact.name: point.name for fact in plugin.offers["ccas_facts"]}
        loaded.append(plugin)
    python = _by_name(loaded, failures, "ccas_pair_rules", "rule in Python", lambda rule: rule.name)
    criteria = _by_name(loaded, failures, "ccas_criteria", "criterion", lambda each: each.name)
    regions = _by_name(loaded, failures, "ccas_regions", "region", lambda region: region.id)
    identified = _identified(loaded, failures)
    owned = _by_name(identified, failures, "ccas_rulesets", "ruleset", lambda each: each[0])
    owners = {each[0]: plugin.name for plugin in identified for each in plugin.offers["ccas_rulesets"]}
    library = RulesetLibrary(
        {id_: each for id_, (_, each) in owned.items() if isinstance(each, AbstractRuleset)},
        {id_: each for id_, (_, each) in owned.items() if isinstance(each, Path)},
        vocabulary=vocabulary,
        python=python,
        criteria=criteria,
    )
    return Plugins(
        rulesets=library,
        owners=MappingProxyType({id_: owners[id_] for id_ in sorted(owned) if id_ in library}),
        loaded=MappingProxyType({plugin.name: plugin.target for plugin in loaded}),
        failures=tuple(failures),
        infos=MappingProxyType({plugin.name: plugin.info for plugin in loaded if plugin.info}),
        hooks=MappingProxyType({plugin.name: tuple(_implemented(plugin.manager)) for plugin in loaded}),
        vocabulary=vocabulary,
        facts=MappingProxyType(facts),
        pair_rules=MappingProxyType(python),
        criteria=MappingProxyType(criteria),
        regions=MappingProxyType(regions),
        _managers=tuple((plugin.name, plugin.manager) for plugin in loaded),
    )


def _loaded(point: EntryPoint, trace: Callable[[str], object] | None) -> _Loaded:
    """Import one plugin, register it with a host of its own, and collect what it offers."""
    manager = pluggy.PluginManager(hookspecs.PROJECT)
    manager.add_hookspecs(hookspecs)
    plugin = point.load()
    manager.register(plugin, name=point.name)
    _check_names(plugin)
    manager.check_pending()
    info = manager.hook.ccas_plugin_info()
    if info is not None and not isinstance(info, PluginInfo):
        raise TypeError(f"ccas_plugin_info must return a PluginInfo, got {type(info).__name__}")
    if info is not None and info.api != hookspecs.API:
        raise TypeError(
            f"it was written for version {info.api} of the hooks, and this is version {hookspecs.API}"
        )
    found = _Loaded(name=point.name, target=point.value, manager=manager, info=info)
    for hook, kinds in _COLLECTED.items():
        found.offers[hook] = _collected(manager, hook, kinds)
        if trace is not None and getattr(manager.hook, hook).get_hookimpls():
            trace(f"{point.name}: {hook} -> {_named(found.offers[hook]) or 'nothing'}")
    return found


def _collected(manager: pluggy.PluginManager, hook: str, kinds: tuple[type, ...]) -> list[Any]:
    caller = getattr(manager.hook, hook)
    answers = caller()
    if len(answers) < len(caller.get_hookimpls()):  # pluggy drops None
        raise TypeError(f"{hook} must return {_wanted(hook)}, got None")
    offered = [each for answer in answers for each in answer]
    for each in offered:
        if not isinstance(each, kinds):
            raise TypeError(f"{hook} must return {_wanted(hook)}, got {type(each).__name__}")
        if isinstance(each, AbstractRuleset):
            _check_ruleset(each)
    return offered


def _wanted(hook: str) -> str:
    return hook.removeprefix("ccas_").replace("_", " ")


def _check_ruleset(ruleset: AbstractRuleset) -> None:
    for name in ("id", "version", "title"):
        if not isinstance(value := getattr(ruleset, name, None), str) or not value:
            raise TypeError(f"{name} of {type(ruleset).__name__} must be a text, got {value!r}")


def _named(offered: Iterable[Any]) -> str:
    return ", ".join(
        each.name if isinstance(each, Path) else str(getattr(each, "id", None) or each.name)
        for each in offered
    )


def _identified(loaded: Iterable[_Loaded], failures: list[Failure]) -> list[_Loaded]:
    """Plugins with their rulesets as (id, ruleset or path); a file without id is a failure of its own."""
    found = []
    for plugin in loaded:
        rulesets: list[Any] = []
        for each in plugin.offers["ccas_rulesets"]:
            try:
                id_ = each.id if isinstance(each, AbstractRuleset) else id_in(each)
            except RulesetError as error:
                cause = str(error.diagnostics[0]).splitlines()[0]
                hint = error.diagnostics[0].hint or "mend the file"
                failures.append(Failure(plugin.name, str(each), cause, hint, "this ruleset is not available"))
                continue
            rulesets.append((id_, each))
        offers = {**plugin.offers, "ccas_rulesets": rulesets}
        found.append(
            _Loaded(
                name=plugin.name,
                target=plugin.target,
                manager=plugin.manager,
                info=plugin.info,
                offers=offers,
            )
        )
    return found


def _by_name(
    loaded: Iterable[_Loaded], failures: list[Failure], hook: str, what: str, name: Callable[[Any], str]
) -> dict[str, Any]:
    """Offers of a hook by their names; a name that two plugins use is refused to both."""
    offers: dict[str, list[tuple[str, Any]]] = {}
    for plugin in loaded:
        for each in plugin.offers[hook]:
            offers.setdefault(name(each), []).append((plugin.name, each))
    found = {}
    for id_, offered in sorted(offers.items()):
        if len(offered) > 1:
            names = " and ".join(repr(owner) for owner, _ in offered)
            cause = f"plugins {names} both define {what} {id_!r}"
            effect = f"this {what} is not available"
            failures.append(Failure(offered[-1][0], id_, cause, "rename one of the two", effect))
            continue
        found[id_] = offered[0][1]
    return found


def _implemented(manager: pluggy.PluginManager) -> Iterator[str]:
    for name in sorted(vars(hookspecs)):
        if name.startswith("ccas_") and getattr(manager.hook, name).get_hookimpls():
            yield name


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
