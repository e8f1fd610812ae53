"""`ccas plugins`: what was loaded, and what was left out and why."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from ccas_core.errors import Diagnostic, InputError, did_you_mean

from . import inputs, talk
from .exits import Code

if TYPE_CHECKING:
    from ccas_core.plugins import Plugins

_OFFERS: Final = {  # hook: what `ccas plugins` calls its offers
    "ccas_rulesets": "rulesets",
    "ccas_facts": "facts",
    "ccas_pair_rules": "rules",
    "ccas_criteria": "criteria",
    "ccas_regions": "regions",
    "ccas_controllers": "controllers",
}


def plugins(
    context: typer.Context,
    everything: Annotated[
        bool, typer.Option("--all", help="Also the hooks of each plugin, and all that it offers.")
    ] = False,
    debug: Annotated[
        str | None,
        typer.Option(
            "--debug",
            metavar="NAME",
            help="Show where loading this plugin failed, with the traceback.",
            show_default=False,
        ),
    ] = None,
    as_json: talk.AsJson = False,
) -> None:
    """List the plugins that are loaded, and those that were left out, each with package and cause.

    A plugin is any installed package with an entry point in the group 'ccas'. One that cannot be loaded
    does not stop the others. Exit code 1 if one was left out, or a part of one.

    Example:
        ccas plugins --all
        ccas --trace-hooks plugins
    """
    found = inputs.ask_plugins(context)
    if debug is not None:
        _debug(found, debug)
        return
    loaded = [_loaded(found, name) for name in found.loaded]
    failures = [
        {
            "plugin": each.plugin,
            "target": each.target,
            "package": each.package,
            "cause": each.cause,
            "effect": each.effect,
            "hint": each.hint,
        }
        for each in found.failures
    ]
    if as_json:
        talk.show_json({"loaded": loaded, "failures": failures})
    else:
        headings = ("plugin", "package", "module", "rulesets")
        rows = [(row["plugin"], row["package"], row["module"], ", ".join(row["rulesets"])) for row in loaded]
        talk.show_table(headings, rows)
        if everything:
            _show_offers(loaded)
        for each in found.failures:
            talk.show(f"\n{each}")
    if failures:
        raise typer.Exit(Code.FINDINGS)


def _loaded(found: Plugins, name: str) -> dict[str, Any]:
    info = found.infos.get(name)
    offers = {what: list(found.offers[name].get(hook, ())) for hook, what in _OFFERS.items()}
    offers["rulesets"] = [id_ for id_, owner in found.owners.items() if owner == name]  # no bases, no clashes
    return {
        "plugin": name,
        "package": found.packages[name],
        "module": found.loaded[name],
        "name": info.name if info else "",
        "version": info.version if info else "",
        "api": info.api if info else None,
        "homepage": info.homepage if info else "",
        "hooks": list(found.hooks[name]),
        **offers,
    }


def _show_offers(loaded: list[dict[str, Any]]) -> None:
    for row in loaded:
        talk.show(f"\n{row['plugin']}" + (f": {row['name']} {row['version']}" if row["name"] else ""))
        talk.show(f"    hooks: {', '.join(row['hooks']) or 'none'}")
        for what in _OFFERS.values():
            if row[what]:
                talk.show(f"    {what}: {', '.join(row[what])}")


def _debug(found: Plugins, name: str) -> None:
    failed = [each for each in found.failures if each.plugin == name]
    if not failed and name not in found.loaded:
        known = [*found.loaded, *(each.plugin for each in found.failures)]
        hint = did_you_mean(name, known)
        raise InputError(Diagnostic(source="--debug", message=f"there is no plugin {name!r}", hint=hint))
    for each in failed:
        talk.show(str(each))
        if each.trace:
            talk.show(each.trace)
    if not failed:
        talk.show(f"plugin {name!r} was loaded: {found.loaded[name]}")
        return
    raise typer.Exit(Code.FINDINGS)
