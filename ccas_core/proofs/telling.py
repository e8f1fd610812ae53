"""Findings in words: what a property means, where the ships are, what each sees of the other, and why."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from ..errors import Diagnostic
from ..ships import ShipId
from ..tapd.case_run import pair_facts
from ..tapd.cases import Case, CaseShip
from ..tapd.language.formula import Before, Known, Same, Sign, Test, walk
from ..tapd.rules import Domain, Rule, RulesetText
from ..tapd.vocabulary import VOCABULARY, Fact, Scope, Vocabulary
from ..units import DEGREE
from ..verdict import Kind, Verdict
from .findings import Fault
from .search import Ships

MEANINGS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "domain_not_empty": "there are ships at risk in the domain, so that proofs about it say something",
        "mirror_sound": "both ships recognise the same encounter",
        "consistent": "the two ships come to opposite verdicts",
        "complete": "a risk of collision leads to a verdict that obliges somebody",
        "exclusive": "rules that apply together say the same",
        "tie_break_total": "a ring of ships can always be opened",
        "no_dead_rule": "each rule decides for some ships",
        "no_irrelevant_rule": "without any one rule some verdict would be another",
        "role_stable": "no role changes while nobody manoeuvres",
        "acyclic": "no ships wait for one another in a ring",
        "parameters": "what is proved holds for all parameters within their ranges",
        "border": "of two ships under two rulesets, never do both stand on",
        "against": "no ship is judged otherwise than by the old version",
    }
)
_ROLES: Final[Mapping[Kind, str]] = MappingProxyType(
    {
        Kind.GIVE_WAY: "gives way to {other}",
        Kind.STAND_ON: "stands on towards {other}",
        Kind.MUTUAL: "and {other} both give way",
        Kind.COOPERATE: "is to agree with {other} on what {initiator} wants",
        Kind.NEGOTIATE: "is to negotiate with {other}",
        Kind.NONE: "has no duty towards {other}",
        Kind.PROHIBITED: "finds that {initiator} must not do what it wants",
        Kind.CONFLICT: "finds that the rules on {other} contradict themselves",
        Kind.GAP: "finds that the rules on {other} decide nothing",
        Kind.UNKNOWN_FACT: "lacks a fact to judge {other}",
    }
)
_REASONS: Final[Mapping[str, str]] = MappingProxyType(
    {"no_rule": "no rule applies", "no_risk": "there is no risk of collision"}
)
_UNITS: Final = (("_mps", "m/s"), ("_deg", "deg"), ("_m", "m"), ("_s", "s"))
_COUNTED: Final = (Before, Known, Same, Sign, Test)
_PLAIN: Final = ("length", "beam")  # facts of ships that are told anyway


def heading(text: RulesetText) -> str:
    """Say in a line how large a ruleset is, and for which ships it is meant."""
    conditions = {part for rule in text.rules for part in walk(rule.condition) if isinstance(part, _COUNTED)}
    counted = f"{len(text.rules)} rules, {len(conditions)} conditions"
    return f"{text.id} {text.version}   {counted}, domain: {domain(text.domain)}"


def domain(found: Domain) -> str:
    """Say for which ships a ruleset is meant.

    >>> domain(Domain())
    '0.5 to 15 m/s, 5 to 200 m, at least 50 m apart'
    """
    speed, length = (" to ".join(f"{float(each):g}" for each in ends) for ends in (found.speed, found.length))
    more = f", {len(found.assume)} assumed" if found.assume else ""
    return f"{speed} m/s, {length} m, at least {float(found.separation):g} m apart{more}"


def marked(rule: Rule) -> Diagnostic:
    """Show where a rule is written, under its id; what is wrong with it is told elsewhere."""
    source = rule.source
    return Diagnostic(
        source=near(source.file),
        line=source.line,
        column=source.column,
        message=f"rule '{rule.id}', {rule.citation}",
        excerpt=source.excerpt,
        width=len(rule.id),
    )


def near(file: str) -> str:
    """Path of a file, as short as it can be said from here."""
    path = Path(file)
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else file


def ship_lines(ships: Ships, vocabulary: Vocabulary = VOCABULARY) -> tuple[str, ...]:
    """Say of each ship where it is, how it sails, and what it states of itself."""
    rows = [_ship_row(ship, vocabulary) for ship in ships.case.ships]
    widths = [max(len(row[n]) for row in rows) for n in range(len(rows[0]) - 1)]
    return tuple(
        "  ".join([*(cell.ljust(width) for cell, width in zip(row, widths, strict=False)), row[-1]]).rstrip()
        for row in rows
    )


def _ship_row(ship: CaseShip, vocabulary: Vocabulary) -> tuple[str, ...]:
    stated = ", ".join(_facts(ship.facts, Scope.SHIP, vocabulary))
    size = f"{float(ship.facts['length']):g} m" if "length" in ship.facts else ""
    if ship.pose is None or ship.speed is None:
        return ship.id, "anywhere", "", "", size, stated
    north, east, course = ship.pose
    place = f"at ({east:g}, {north:g}) m"
    return ship.id, place, f"{ship.speed:.2f} m/s", f"course {course / DEGREE % 360.0:3.0f}°", size, stated


def water_line(case: Case, vocabulary: Vocabulary = VOCABULARY) -> str:
    """Say what is stated of the waters and of the pair; empty where nothing is."""
    stated = list(_facts(case.waterway, Scope.WATERWAY, vocabulary))
    stated += [f"{name} {_value(value)}" for name, value in case.encounter.items()]
    return ", ".join(stated)


def _facts(facts: Mapping[str, Any], scope: Scope, vocabulary: Vocabulary) -> Iterator[str]:
    """Stated facts that are not as usual."""
    for name, value in facts.items():
        fact = vocabulary.find(scope, name)
        if (scope is Scope.SHIP and name in _PLAIN) or fact is None or value == fact.default:
            continue
        yield _fact(fact, value)


def _fact(fact: Fact, value: Any) -> str:
    if isinstance(value, bool):
        return fact.name if value else f"not {fact.name}"
    if isinstance(value, int | float) and fact.quantity.unit:
        return f"{fact.name} {value / fact.quantity.units[fact.quantity.unit]:g} {fact.quantity.unit}"
    return f"{fact.name} {_value(value)}"


def sights(ships: Ships, vocabulary: Vocabulary = VOCABULARY) -> tuple[str, ...]:
    """Say how the ships of each pair lie to one another, and how near they will come."""
    pairs = dict.fromkeys(tuple(sorted((view.own, view.other))) for view in ships.verdicts)
    return tuple(line for one, other in pairs for line in _sight(ships.case, one, other, vocabulary))


def _sight(case: Case, one: ShipId, other: ShipId, vocabulary: Vocabulary) -> Iterator[str]:
    facts = pair_facts(case, one, other, vocabulary)
    if not facts.moving:
        return
    there = [
        f"{here} sees {target} {_bearing(facts.quantity(('bearing', *ends)))}"
        for here, target, ends in ((one, other, ("own", "other")), (other, one, ("other", "own")))
    ]
    apart = facts.quantity(("course_difference",)) / DEGREE
    yield f"{there[0]}, {there[1]}; courses {apart:.1f}° apart"
    time, distance = facts.quantity(("tcpa",)), facts.quantity(("dcpa",))
    now = facts.quantity(("distance",))
    when = f"nearest {_in_time(time)}: {distance:.0f} m" if math.isfinite(time) else "and so they stay"
    yield f"{one} and {other} are {now:.0f} m apart, {when}"


def _in_time(time: float) -> str:
    return f"in {time:.0f} s" if time >= 0.0 else f"{-time:.0f} s ago"


def _bearing(angle: float) -> str:
    """Say a relative bearing as a helmsman would.

    >>> _bearing(-30.0 * DEGREE), _bearing(0.0)
    ('30.0° to port', 'right ahead')
    """
    degrees = angle / DEGREE
    if abs(degrees) < 0.05:
        return "right ahead"
    if abs(degrees) > 179.95:
        return "right astern"
    return f"{abs(degrees):.1f}° to {'starboard' if degrees > 0.0 else 'port'}"


def view_lines(view: Verdict) -> tuple[str, ...]:
    """Say what a ship makes of another: its verdict, by which rule and article, and the values behind it.

    What a rule looked at and is not so is left out.
    """
    lines = [duty_of(view) + (f", by '{view.rule}'" if view.rule else "")]
    if view.reason:
        lines.append(f"because {_REASONS.get(view.reason, view.reason)}")
    values = [_seen(name, value, view) for name, value in view.facts.items() if value is not False]
    if values:
        lines.append(f"with {', '.join(values)}")
    return tuple(lines)


def duty_of(view: Verdict) -> str:
    """Say in a few words what a ship takes its duty to be, and by which article.

    >>> duty_of(Verdict(own=ShipId("A"), other=ShipId("B"), kind=Kind.STAND_ON, ruleset="r", version="1"))
    'A stands on towards B'
    """
    role = _ROLES[view.kind].format(other=view.other, initiator=view.initiator)
    return f"{view.own} {role}" + (f" ({view.article})" if view.article else "")


def _seen(name: str, value: Any, view: Verdict) -> str:
    """A fact that a rule looked at, with the names of the ships.

    >>> view = Verdict(own=ShipId("A"), other=ShipId("B"), kind=Kind.NONE, ruleset="r", version="1")
    >>> _seen("own.speed_mps", 3.0, view), _seen("bearing(other, own)_deg", -12.0, view)
    ('A.speed 3 m/s', 'bearing(B, A) -12 deg')
    >>> _seen("other.ferry", False, view)
    'not B.ferry'
    """
    unit = ""
    for suffix, written in _UNITS:
        if name.endswith(suffix) and isinstance(value, float):
            name, unit = name.removesuffix(suffix), f" {written}"
            break
    ships = {"own": view.own, "other": view.other}
    name = re.sub(r"\b(own|other)\b", lambda match: ships[match[1]], name)
    if isinstance(value, bool):
        return name if value else f"not {name}"
    return f"{name} {_value(value)}{unit}"


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else str(getattr(value, "value", value))


def description(property_: str, fault: Fault, vocabulary: Vocabulary = VOCABULARY) -> str:
    """Say in a few sentences what a scenario shows."""
    about = f"Shows where '{property_}' fails ({MEANINGS.get(property_, property_)}): {fault.title}."
    rules = ", ".join(f"'{rule.id}' ({rule.citation})" for rule in fault.rules)
    lines = [about, f"Rules: {rules}." if rules else ""]
    if fault.ships is not None:
        lines += [f"{each}." for each in sights(fault.ships, vocabulary)]
        lines += [f"{duty_of(view)}." for view in fault.ships.verdicts]
    return " ".join(filter(None, lines))
