"""`ccas plugins`: what was loaded, and what was left out and why."""

from __future__ import annotations

import typer

from . import inputs, talk
from .exits import Code


def plugins(context: typer.Context, as_json: talk.AsJson = False) -> None:
    """List the plugins that are loaded, and those that were left out, each with the cause.

    A plugin is any installed package with an entry point in the group 'ccas'. One that cannot be loaded
    does not stop the others. Exit code 1 if one was left out.

    Example:
        ccas --trace-hooks plugins
    """
    found = inputs.ask_plugins(context)
    offers: dict[str, list[str]] = {name: [] for name in found.loaded}
    for id_, owner in found.owners.items():
        offers[owner].append(id_)
    loaded = [
        {"plugin": name, "module": module, "rulesets": offers[name]} for name, module in found.loaded.items()
    ]
    failures = [
        {"plugin": each.plugin, "target": each.target, "cause": each.cause, "hint": each.hint}
        for each in found.failures
    ]
    if as_json:
        talk.show_json({"loaded": loaded, "failures": failures})
    else:
        rows = [(name, module, ", ".join(offers[name])) for name, module in found.loaded.items()]
        talk.show_table(("plugin", "module", "rulesets"), rows)
        if failures:
            talk.show("\nleft out:\n")
            talk.show_table(("plugin", "target", "cause", "hint"), [tuple(row.values()) for row in failures])
    if failures:
        raise typer.Exit(Code.FINDINGS)
