"""The typed host of plugins: loads them one by one, collects what they offer, reports what failed.

Our own rulesets come in by the same entry points as anybody's.  A plugin that cannot be loaded is
left out and reported; the others work on.  No other module touches pluggy, but `hookspecs`.
"""

from __future__ import annotations

import importlib.metadata
import sys
import traceback
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import pluggy

from . import hookspecs
from .controllers import RESERVED, AbstractController
from .entry_points import EntryPoint, apart, package_of
from .errors import Diagnostic, RulesetError, did_you_mean
from .hookspecs import PluginInfo
from .observers import Observers
from .plugin_failures import Failure, Guard, Troubles
from .regions import Region
from .tapd.library import RulesetLibrary, id_in
from .tapd.python_rules import PythonRule
from .tapd.ranking import RankingCriterion
from .tapd.ruleset import AbstractRuleset
from .tapd.vocabulary import VOCABULARY, Fact, Vocabulary

GROUP: Final = "ccas"
_COLLECTED: Final[Mapping[str, tuple[type, ...]]] = {  # what may be returned, by hook
    "ccas_facts": (Fact,),
    "ccas_rulesets": (AbstractRuleset, Path),
    "ccas_pair_rules": (PythonRule,),
    "ccas_criteria": (RankingCriterion,),
    "ccas_regions": (Region,),
    "ccas_controllers": (AbstractController,),
}


@dataclass(slots=True, kw_only=True)
class _Loaded:
    """One plugin, and what it offers."""

    name: str
    target: str
    package: str
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
    controllers: Mapping[str, AbstractController]
    packages: Mapping[str, str]  # plugin -> its distribution, with its version
    offers: Mapping[str, Mapping[str, tuple[str, ...]]]  # plugin -> hook -> names of what it offers
    troubles: Troubles  # what fails while plugins are at work
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
        return Observers(self._managers, self.packages)


def load(
    entry_points: Iterable[EntryPoint] | None = None,
    trace: Callable[[str], object] | None = None,
    only: Collection[str] | None = None,
) -> Plugins:
    """Load plugins from entry points (those installed, unless given) and collect what they offer.

    `trace`, if given, is called with a line for every hook call, saying who answered what.  With `only`,
    plugins of other names are not even imported, save those that come with this package.  Ruleset files are
    read when a ruleset is first asked for.
    """
    points = list(importlib.metadata.entry_points(group=GROUP) if entry_points is None else entry_points)
    wanted = [each for each in points if only is None or each.name in only or _is_ours(each)]
    loaded: list[_Loaded] = []
    failures: list[Failure] = []
    troubles = Troubles()
    vocabulary = VOCABULARY
    for point in apart(wanted, failures):
        try:
            plugin = _loaded(point, trace, troubles)
            vocabulary = vocabulary.extended(plugin.offers["ccas_facts"])
        except (Exception, SystemExit) as error:  # a plugin may raise anything at import
            failures.append(_left_out(point, error))
            continue
        loaded.append(plugin)
    return _together(loaded, failures, vocabulary, troubles)


def _together(
    loaded: list[_Loaded], failures: list[Failure], vocabulary: Vocabulary, troubles: Troubles
) -> Plugins:
    """Put together what plugins offer; what two of them call by one name is refused to both."""
    python = _by_name(loaded, failures, "ccas_pair_rules", "rule in Python", lambda rule: rule.name)
    criteria = _by_name(loaded, failures, "ccas_criteria", "criterion", lambda each: each.name)
    regions = _by_name(loaded, failures, "ccas_regions", "region", lambda region: region.id)
    controllers = _by_name(loaded, failures, "ccas_controllers", "controller", lambda each: each.name)
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
        facts=MappingProxyType(
            {fact.name: plugin.name for plugin in loaded for fact in plugin.offers["ccas_facts"]}
        ),
        pair_rules=MappingProxyType(python),
        criteria=MappingProxyType(criteria),
        regions=MappingProxyType(regions),
        controllers=MappingProxyType(controllers),
        packages=MappingProxyType({plugin.name: plugin.package for plugin in loaded}),
        offers=MappingProxyType({plugin.name: _offered(plugin) for plugin in identified}),
        troubles=troubles,
        _managers=tuple((plugin.name, plugin.manager) for plugin in loaded),
    )


def _is_ours(point: EntryPoint) -> bool:
    return package_of(point).startswith("ccas ")


def _left_out(point: EntryPoint, error: BaseException) -> Failure:
    return Failure(
        plugin=point.name,
        target=point.value,
        cause=f"{type(error).__name__}: {error}",
        package=package_of(point),
        hint=f"`ccas plugins --debug {point.name}` shows where; mend it, or uninstall its package",
        trace="".join(traceback.format_exception(error)),
    )


def _loaded(point: EntryPoint, trace: Callable[[str], object] | None, troubles: Troubles) -> _Loaded:
    """Import one plugin, register it with a host of its own, and collect what it offers."""
    manager = pluggy.PluginManager(hookspecs.PROJECT)
    manager.add_hookspecs(hookspecs)
    plugin = point.load()
    _check_version(plugin)  # before all else: what else is wrong may come from there
    _check_names(plugin)
    manager.register(plugin, name=point.name)
    manager.check_pending()
    found = _Loaded(
        name=point.name,
        target=point.value,
        package=package_of(point),
        manager=manager,
        info=manager.hook.ccas_plugin_info(),
    )
    for hook, kinds in _COLLECTED.items():
        found.offers[hook] = _collected(manager, hook, kinds)
        if trace is not None and getattr(manager.hook, hook).get_hookimpls():
            trace(f"{point.name}: {hook} -> {', '.join(_names(found.offers[hook])) or 'nothing'}")
    guard = Guard(point.name, found.package, troubles)
    for hook, guarded in (
        ("ccas_facts", guard.fact),
        ("ccas_pair_rules", guard.rule),
        ("ccas_criteria", guard.criterion),
    ):
        found.offers[hook] = [guarded(each) for each in found.offers[hook]]
    return found


def _check_version(plugin: object) -> None:
    """Refuse a plugin that was written for another version of the hooks."""
    ask = getattr(plugin, "ccas_plugin_info", None)
    if not callable(ask):
        return
    info = ask()
    if not isinstance(info, PluginInfo):
        raise TypeError(f"ccas_plugin_info must return a PluginInfo, got {type(info).__name__}")
    if info.api != hookspecs.API:
        here = f"this is version {hookspecs.API}"
        raise TypeError(f"it was written for version {info.api} of the hooks, and {here}")


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
        if isinstance(each, AbstractController):
            _check_controller(each)
    return offered


def _wanted(hook: str) -> str:
    return hook.removeprefix("ccas_").replace("_", " ")


def _check_ruleset(ruleset: AbstractRuleset) -> None:
    for name in ("id", "version", "title"):
        if not isinstance(value := getattr(ruleset, name, None), str) or not value:
            raise TypeError(f"{name} of {type(ruleset).__name__} must be a text, got {value!r}")


def _check_controller(controller: AbstractController) -> None:
    name = getattr(controller, "name", None)
    if not isinstance(name, str) or not name.isidentifier() or name in RESERVED:
        taken = " or ".join(RESERVED)
        kind = type(controller).__name__
        raise TypeError(f"name of {kind} must be a word, and not {taken}, got {name!r}")


def _names(offered: Iterable[Any]) -> tuple[str, ...]:
    """Names of what a plugin offers; of a ruleset file that has been looked into, its id."""
    return tuple(_name(each[0] if isinstance(each, tuple) else each) for each in offered)


def _offered(plugin: _Loaded) -> dict[str, tuple[str, ...]]:
    return {hook: _names(each) for hook, each in plugin.offers.items()}


def _name(each: Any) -> str:  # noqa: ANN401 - whatever hooks return
    if isinstance(each, str | Path):
        return each if isinstance(each, str) else each.name
    return str(getattr(each, "id", None) or each.name)


def _identified(loaded: Iterable[_Loaded], failures: list[Failure]) -> list[_Loaded]:
    """Plugins with their rulesets as (id, ruleset or path); a file without id is a failure of its own."""
    found = []
    for plugin in loaded:
        rulesets: list[Any] = []
        for each in plugin.offers["ccas_rulesets"]:
            try:
                id_ = each.id if isinstance(each, AbstractRuleset) else id_in(each)
            except RulesetError as error:
                failures.append(
                    Failure(
                        plugin=plugin.name,
                        target=str(each),
                        cause=error.diagnostics[0].message,
                        hint=error.diagnostics[0].hint or "mend the file",
                        effect="this ruleset is not available",
                        package=plugin.package,
                        whole=False,
                    )
                )
                continue
            rulesets.append((id_, each))
        found.append(replace(plugin, offers={**plugin.offers, "ccas_rulesets": rulesets}))
    return found


def _by_name(
    loaded: Iterable[_Loaded], failures: list[Failure], hook: str, what: str, name: Callable[[Any], str]
) -> dict[str, Any]:
    """Offers of a hook by their names; a name that two plugins use is refused to both."""
    offers: dict[str, list[tuple[_Loaded, Any]]] = {}
    for plugin in loaded:
        for each in plugin.offers[hook]:
            offers.setdefault(name(each), []).append((plugin, each))
    found = {}
    for id_, offered in sorted(offers.items()):
        if len(offered) > 1:
            last, names = offered[-1][0], [repr(owner.name) for owner, _ in offered]
            cause = f"plugins {' and '.join(names)} both define {what} {id_!r}"
            if len(set(names)) == 1:
                cause = f"plugin {names[0]} defines {what} {id_!r} twice"
            failures.append(
                Failure(
                    plugin=last.name,
                    target=f"{what} {id_!r}",
                    cause=cause,
                    hint="rename one of the two",
                    effect=f"this {what} is not available",
                    package=last.package,
                    whole=False,
                )
            )
            continue
        found[id_] = offered[0][1]
    return found


def _implemented(manager: pluggy.PluginManager) -> Iterator[str]:
    for name in sorted(vars(hookspecs)):
        if name.startswith("ccas_") and getattr(manager.hook, name).get_hookimpls():
            yield name


def _check_names(plugin: object) -> None:
    """Refuse a misspelt hook, with the name that was probably meant, and one that is not marked as a hook."""
    known = [name for name in vars(hookspecs) if name.startswith("ccas_")]
    for name in dir(plugin):
        if not name.startswith("ccas_") or not callable(function := getattr(plugin, name)):
            continue
        if name not in known:
            raise TypeError(f"unknown hook {name!r}; {did_you_mean(name, known)}")
        if not hasattr(function, f"{hookspecs.PROJECT}_impl"):
            raise TypeError(f"{name} would never be called: write @hookimpl above it")


def warn(failures: Iterable[Failure]) -> None:
    """Say on the standard error which plugins were left out."""
    for failure in failures:
        print(failure, file=sys.stderr)
