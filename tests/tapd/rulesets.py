"""A small ruleset as text, with parts put in or left out, for tests of files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from ccas_core.errors import Diagnostic, RulesetError
from ccas_core.tapd.ruleset_file import Library, parse_ruleset
from ccas_core.tapd.written import WrittenRuleset

HEAD = """\
schema: ccas/ruleset@1
id: small
version: 1.0.0
title: A small ruleset
regulation: {name: RULES, version: "2026"}
"""
ENCOUNTER = """\
encounter:
  risk: closing
  overtaking: abs(bearing(other, own)) > 112.5 deg and own.speed > other.speed and closing
  head_on: course_difference > 157.5 deg and closing
  crossing: from_starboard(own, other) or from_starboard(other, own)
  from_starboard: from_starboard(own, other)
"""
RULES = """\
rules:
  - id: ferry
    cite: {article: "1"}
    when: own.ferry and not other.ferry
    then: stand_on
  - id: sail.over-motor
    cite: {article: "2"}
    when: own.propulsion == motor and other.propulsion == sail
    then: give_way
  - id: sail.wind
    cite: {article: "3"}
    when: own.wind_side == port and other.wind_side == starboard
    then: give_way
"""
OTHERWISE = """\
otherwise: {cite: {article: "9"}}
"""
SMALL = HEAD + ENCOUNTER + RULES + OTHERWISE


def library(**texts: str) -> Library:
    """Bases by their ids."""

    def text_of(id_: str) -> tuple[str, str]:
        if id_ not in texts:
            raise KeyError("there are others")
        return texts[id_], f"{id_}.yaml"

    return text_of


def read(text: str, **bases: str) -> WrittenRuleset:
    """Read a ruleset; bases by their ids."""
    return parse_ruleset(text, "small.yaml", library(**bases))


def refused(text: str, more: Mapping[str, Any] | None = None, **bases: str) -> tuple[Diagnostic, ...]:
    """What is wrong with a ruleset."""
    with pytest.raises(RulesetError) as caught:
        parse_ruleset(text, "small.yaml", library(**bases), **(more or {}))
    return caught.value.diagnostics


def one_finding(text: str, more: Mapping[str, Any] | None = None, **bases: str) -> Diagnostic:
    """The one thing that is wrong with a ruleset."""
    (found,) = refused(text, more, **bases)
    return found


def with_rule(rule: str) -> str:
    """The small ruleset with one more rule at its end, given as lines without indentation."""
    lines = rule.strip("\n").split("\n")
    indented = "\n".join(f"  {'- ' if n == 0 else '  '}{line}" for n, line in enumerate(lines))
    return f"{HEAD}{ENCOUNTER}{RULES}{indented}\n{OTHERWISE}"


def with_first_rule(rule: str) -> str:
    """The small ruleset with one more rule before all others."""
    text = with_rule(rule)
    added = text[text.index(RULES) + len(RULES) : text.index(OTHERWISE)]
    return text.replace(added, "").replace("rules:\n", "rules:\n" + added)


def overlay(rest: str = "", *, base: str = "small") -> str:
    """A ruleset that extends another."""
    return (
        f"schema: ccas/ruleset@1\nid: over\nversion: 2.0.0\ntitle: Over another\nextends: {base}\n"
        f"regulation: {{name: OVER, version: '7'}}\n{rest}"
    )


def ids(rules: WrittenRuleset) -> list[str]:
    """Ids of all rules, in the order in which they are tried."""
    return [rule.id for rule in rules.text.rules]
