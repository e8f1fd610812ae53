"""`ccas rulesets`: the rulesets that there are."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import typer

from ccas_core.errors import RulesetError
from ccas_core.verdict import Confidence

from . import inputs, talk
from .exits import Code

if TYPE_CHECKING:
    from ccas_core.plugins import Plugins


def rulesets(context: typer.Context, as_json: talk.AsJson = False) -> None:
    """List the rulesets that there are, and which plugin each comes from.

    A ruleset says who gives way to whom. A scenario names the ruleset of its waters by the id that
    stands here; `--ruleset` of other commands takes the same ids. Of a ruleset file are told its base,
    how many rules there are with those of the base, and how well the sources of these were seen. Exit code 1
    if one cannot be understood; `ccas check` says all that is wrong with it.

    Example:
        ccas rulesets --json
    """
    found = inputs.load_plugins(context)
    rows: list[dict[str, Any]] = []
    broken: list[dict[str, Any]] = []
    for id_ in found.rulesets:
        try:
            rows.append(_row(found, id_))
        except RulesetError as error:
            first = str(error.diagnostics[0]).splitlines()[0]
            count = len(error.diagnostics)
            broken.append({"id": id_, "plugin": found.owners[id_], "findings": count, "first": first})
    if as_json:
        talk.show_json([*rows, *broken])
    else:
        talk.show_table(
            ("id", "version", "title", "regulation", "base", ">rules", "sources", "plugin"), map(_cells, rows)
        )
        for each in broken:
            findings = talk.one_or_more(each["findings"], "finding")
            talk.show(f"\n{each['id']} ({each['plugin']}) cannot be used: {findings}, first {each['first']}")
    if broken:
        raise typer.Exit(Code.FINDINGS)


def _row(found: Plugins, id_: str) -> dict[str, Any]:
    from ccas_core.tapd.written import WrittenRuleset

    ruleset = found.rulesets[id_]
    row: dict[str, Any] = {
        "id": id_,
        "version": ruleset.version,
        "title": ruleset.title,
        "plugin": found.owners[id_],
    }
    if not isinstance(ruleset, WrittenRuleset):
        return row
    text = ruleset.text
    seen = Counter(rule.citation.confidence for rule in text.rules)
    return row | {
        "regulation": text.regulation,
        "edition": text.edition,
        "base": text.lineage[0] if text.lineage else None,
        "rules": len(text.rules),
        "confidence": {each.value: seen[each] for each in Confidence if seen[each]},
    }


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    sources = ", ".join(f"{count} {name}" for name, count in row.get("confidence", {}).items())
    base, rules = row.get("base") or "", str(row.get("rules", "in Python"))
    return (
        row["id"],
        row["version"],
        row["title"],
        row.get("regulation", ""),
        base,
        rules,
        sources,
        row["plugin"],
    )
