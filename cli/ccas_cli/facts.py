"""`ccas facts`: what conditions of rulesets may ask for."""

from __future__ import annotations

import dataclasses
from enum import StrEnum
from typing import Annotated

import typer

from . import inputs, talk


class _Scope(StrEnum):
    """What a fact is about; the same words as `ccas_core.tapd.vocabulary.Scope`, which is heavy to import."""

    SHIP = "ship"
    WATERWAY = "waterway"
    PAIR = "pair"


def facts(
    context: typer.Context,
    scope: Annotated[
        _Scope | None,
        typer.Option("--scope", help="Only facts about this.", show_default=False),
    ] = None,
    as_json: talk.AsJson = False,
) -> None:
    """List the facts that conditions of rulesets may ask for, also those that plugins add.

    A fact of a ship is asked for as own.length or other.length, one of the waterway as waterway.current,
    one of the pair by its name alone. What a file does not state has the default; 'computed' is taken from
    positions, courses and the chart. The same is in docs/facts.md.

    Example:
        ccas facts --scope pair
    """
    from ccas_core.tapd.facts_page import rows
    from ccas_core.tapd.vocabulary import Scope

    plugins = inputs.load_plugins(context)
    listed = list(rows(plugins.vocabulary, plugins.facts, Scope(scope.value) if scope else None))
    if as_json:
        talk.show_json([dataclasses.asdict(row) for row in listed])
        return
    headings = ("fact of a", "name", "values", "unit", "default", "known from", "plugin", "meaning")
    talk.show_table(
        headings,
        [
            (row.scope, row.name, row.values, row.unit, row.default, row.source, row.plugin, row.meaning)
            for row in listed
        ],
    )
