"""Tests of proofs, on a ruleset of four rules that is sound, and on what breaks when it is changed."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType

from ccas_core.plugins import load
from ccas_core.proofs.findings import Finding
from ccas_core.tapd.library import RulesetLibrary
from ccas_core.tapd.written import WrittenRuleset

SOUND = """\
schema: ccas/ruleset@1
id: mini
version: 1.0.0
title: Four rules
extends: common
regulation: {name: Mini, version: "1", language: en}
otherwise: {cite: {article: "9", text: Care}}
rules:
  - id: overtaking
    cite: {article: "1", text: Who overtakes keeps clear}
    when: overtakes(own) and risk
    then: give_way
  - id: head-on
    cite: {article: "2", text: Both go to starboard}
    when: head_on and risk
    then: mutual
    pass: port_to_port
  - id: crossing
    cite: {article: "3", text: Who has the other to starboard gives way}
    when: crossing and risk and has_starboard(own)
    then: give_way
tests:
  - name: A comes up from astern
    encounter: {geometry: overtaking, overtaker: A}
    ships: {A: {length: 80 m}, B: {length: 80 m}}
    expect: {kind: give_way, give_way: [A], by: overtaking}
  - name: A and B meet on opposite courses
    encounter: {geometry: head_on}
    ships: {A: {length: 80 m}, B: {length: 80 m}}
    expect: {kind: mutual, by: head-on}
  - name: A has B to starboard
    encounter: {geometry: crossing, has_other_on_starboard: A}
    ships: {A: {length: 80 m}, B: {length: 80 m}}
    expect: {kind: give_way, give_way: [A], by: crossing}
"""

# What is changed, by the property that must notice.
BROKEN: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "consistent": ("has_starboard(own)", "bearing(own, other) > 0 deg"),  # where the other is, not whence
        "complete": ("head_on and risk", "head_on and risk and own.ferry and other.ferry"),
        "no_dead_rule": (
            "then: mutual\n    pass: port_to_port\n",
            "then: mutual\n    pass: port_to_port\n{dead}",
        ),
        "tie_break_total": ("otherwise:", "deadlock: {resolve_by: [weight]}\notherwise:"),
        "domain_not_empty": ("otherwise:", "domain: {assume: [not risk_of_collision]}\notherwise:"),
    }
)
DEAD = """\
  - id: head-on-ferries
    cite: {article: "2a", text: Never reached}
    when: head_on and risk and own.ferry
    then: give_way
"""
WAIVER = """\
waivers:
  - check: CHECK
    reason: the law says so
    expires: EXPIRES
"""


def broken(property_: str) -> str:
    """Text of the ruleset with the fault that a property must notice."""
    before, after = BROKEN[property_]
    return SOUND.replace(before, after.replace("{dead}", DEAD))


def with_waiver_text(text: str, check: str, expires: str = "2999-12-31", rules: str = "") -> str:
    """Text of a ruleset with a waiver."""
    more = f"    rules: [{rules}]\n" if rules else ""
    return text + WAIVER.replace("CHECK", check).replace("EXPIRES", expires) + more


def ruleset(text: str = SOUND, source: str = "mini.yaml") -> WrittenRuleset:
    """Read the text of a ruleset."""
    found = library().parsed(text, source)
    assert isinstance(found, WrittenRuleset)
    return found


@cache
def library() -> RulesetLibrary:
    """Read what is shipped, which the texts extend."""
    return load().rulesets


def by_name(findings: tuple[Finding, ...]) -> dict[str, Finding]:
    """Findings by their properties."""
    return {finding.property: finding for finding in findings}


def written(folder: Path, text: str, name: str = "mini.yaml") -> Path:
    """Write the text of a ruleset into a file."""
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file
