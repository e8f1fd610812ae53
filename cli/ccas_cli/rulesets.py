"""`ccas rulesets`: the rulesets that there are."""

from __future__ import annotations

import typer

from . import inputs, talk


def rulesets(context: typer.Context, as_json: talk.AsJson = False) -> None:
    """List the rulesets that there are, and which plugin each comes from.

    A ruleset says who gives way to whom. A scenario names the ruleset of its waters by the id that
    stands here; `--ruleset` of other commands takes the same ids.

    Example:
        ccas rulesets --json
    """
    found = inputs.load_plugins(context)
    rows = [
        {"id": id_, "version": each.version, "title": each.title, "plugin": found.owners[id_]}
        for id_, each in found.rulesets.items()
    ]
    if as_json:
        talk.show_json(rows)
    else:
        talk.show_table(("id", "version", "title", "plugin"), [tuple(row.values()) for row in rows])
