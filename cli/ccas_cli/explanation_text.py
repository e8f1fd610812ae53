"""What an explanation looks like: on a terminal, and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from . import talk

if TYPE_CHECKING:
    from ccas_core.priority import Settlement
    from ccas_core.ships import ShipId
    from ccas_core.tapd.explanation import Explanation, NearMiss, Row, RuleSeen
    from ccas_core.tapd.facts import PairFacts
    from ccas_core.tapd.flip import Flip
    from ccas_core.verdict import Citation, Kind, Verdict

    from .meetings import Meeting, Side

_NEAREST = 5  # rules that are told on a terminal
_VALUES = {True: "yes", False: "no", None: "unknown"}

Line = tuple[str, str, str]  # a condition, its value, its margin


def show(meeting: Meeting, role: Kind | None, *, flip: bool) -> None:
    """Explain a pair on a terminal."""
    if meeting.heading:
        talk.show(meeting.heading)
    if meeting.settlement is None:
        _show_recorded(meeting)
        return
    talk.show(f"{' and '.join(meeting.pair)}: {_outcome(meeting.settlement)}")
    for note in meeting.notes:
        talk.show(f"  {note}")
    before: Explanation | None = None
    for view in (meeting.settlement.one, meeting.settlement.other):
        _show_head(view)
        found = _explained(meeting.sides[view.own], view)
        if found is None:
            _show_lines([(name, _fact(value), "") for name, value in view.facts.items()], 2)
        elif before is not None and _alike(found, before):
            talk.show("    for the same reasons")
        else:
            _show_explanation(found)
            before = found
        if role is not None:
            _show_why_not(meeting.sides[view.own], view, role)
    if flip:
        _show_flips(meeting)


def _show_head(view: Verdict) -> None:
    side = f", to pass {view.passing_side}" if view.passing_side else ""
    strength = f" ({view.strength})" if view.strength else ""
    talk.show(f"  {view.own} judges: {view.kind}{strength}{side}")
    source = f", {_cited(view.citation)}" if view.citation else ""
    talk.show(f"    by {view.ruleset} {view.version}, rule {view.rule or 'none'}{source}")
    if view.reason:
        talk.show(f"    because {view.reason}")


def _cited(citation: Citation) -> str:
    version = f", {citation.version}" if citation.version else ""
    return f"{citation} ({citation.confidence}{version})"


def _show_explanation(found: Explanation) -> None:
    told = found.verdict.reason
    for seen in found.rules:
        citation = seen.rule.citation
        if len(found.rules) > 1:
            talk.show(f"    rule {seen.rule.id}, {_cited(citation)}: {_VALUES[seen.value]}")
        if citation.text and citation.text not in told:
            talk.show(f"    {citation}: {citation.text}")
        if seen.rule.python:
            talk.show(f"    decided in Python, by '{seen.rule.python}' of a plugin")
        _show_lines(list(_lines(seen.rows, 0)), 3)
    if found.recognition:
        talk.show("    no rule applies; the encounter is recognised so:")
        _show_lines(list(_lines(found.recognition, 0)), 3)


def _lines(rows: Sequence[Row], depth: int) -> Iterator[Line]:
    for row in rows:
        label = f"{row.label}: " if row.label else ""
        joined = f", {row.joined}" if row.joined else ""
        yield f"{'  ' * depth}{label}{row.text}{joined}", _value(row), row.margin
        yield from _lines(row.parts, depth + 1)


def _value(row: Row) -> str:
    if row.value is None or row.reading is None:
        return f"{_VALUES[row.value]}{f', {row.found}' if row.found else ''}"
    return row.found


def _show_lines(lines: Sequence[Line], indent: int) -> None:
    """Print conditions with their values and margins below one another."""
    widths = [max((len(line[n]) for line in lines), default=0) for n in (0, 1)]
    for text, value, margin in lines:
        talk.show(f"{'  ' * indent}{text:<{widths[0]}}   {value:<{widths[1]}}   {margin}".rstrip())


# -- why not, and what would change it ---------------------------------------------------------------


def _show_why_not(side: Side, view: Verdict, role: Kind) -> None:
    if view.kind is role:
        return
    talk.show(f"    why not {role}:")
    found = _misses(side, role)
    if not found:
        talk.show("      no rule says so" if found is not None else "      its rules cannot be looked into")
        return
    for miss in found[:_NEAREST]:
        head = f"      {miss.rule.id} ({miss.rule.citation})"
        if not miss.failed:
            talk.show(f"{head} holds, but {miss.prevented_by} came before it")
            continue
        never = "" if miss.possible else ", which never holds"
        before = f"; {miss.prevented_by} came before it" if miss.prevented_by else ""
        talk.show(f"{head} fails{never}{before}:")
        _show_lines(list(_lines(miss.failed, 0)), 4)
    if len(found) > _NEAREST:
        talk.show(f"      and {talk.one_or_more(len(found) - _NEAREST, 'rule')} further away: --json has all")


def _show_flips(meeting: Meeting) -> None:
    found, why = _flips(meeting)
    for each in found:
        talk.show(f"  would be different: {_outcome_of(each)}, if {_manoeuvre(each)}")
    if not found:
        talk.show(f"  {why}")


def _manoeuvre(flip: Flip) -> str:
    from math import degrees

    if flip.turns:
        change, becomes = degrees(flip.change), degrees(flip.becomes)
        return f"{flip.ship} turned {change:.1f} deg {flip.manoeuvre}, to {becomes:.1f} deg"
    return f"{flip.ship} sailed {flip.change:.2f} m/s {flip.manoeuvre}, at {flip.becomes:.2f} m/s"


def _outcome_of(flip: Flip) -> str:
    from ccas_core.priority import settle

    one, other = flip.views
    return _outcome(settle(one, other, {one.own: 1.0, other.own: 1.0}))


def _outcome(settlement: Settlement) -> str:
    view = settlement.one
    if settlement.fallback:
        edge = settlement.edge
        first = f", {edge.first} decides first" if edge else ""
        return f"both give way by the safe mutual rule{first}, because {settlement.fallback}"
    if not view.give_way:
        wants = f" for {view.initiator}" if view.initiator else ""
        return "no encounter" if view.kind == "none" else f"{view.geometry}: {view.kind.value}{wants}"
    stands_on = f", {view.stand_on[0]} stands on" if view.stand_on else ""
    verb = "gives way" if len(view.give_way) == 1 else "give way"
    return f"{view.geometry}: {' and '.join(view.give_way)} {verb}{stands_on}"


def _show_recorded(meeting: Meeting) -> None:
    talk.show(f"{' and '.join(meeting.pair)}:")
    for note in meeting.notes:
        talk.show(f"  {note}")
    for ship, view in meeting.told.get("verdicts", {}).items():
        talk.show(f"  {ship} judged: {view['kind']}")
        source = f", {view['article']} ({view['confidence']})" if view["article"] else ""
        talk.show(f"    by {view['ruleset']} {view['version']}, rule {view['rule'] or 'none'}{source}")
        talk.show(f"    because {view['reason']}")
        _show_lines([(name, _fact(value), "") for name, value in view["facts"].items()], 2)


def _fact(value: object) -> str:
    """Fact as a person reads it.

    >>> _fact(True), _fact(12.3456), _fact(None)
    ('yes', '12.3', '')
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.1f}"
    return "" if value is None else str(getattr(value, "value", value))


# -- looking ---------------------------------------------------------------------------------------


def _explained(side: Side, view: Verdict) -> Explanation | None:
    """Conditions behind a verdict; none where the ruleset is not a file, or failed."""
    from ccas_core.tapd.explanation import explain
    from ccas_core.tapd.written import WrittenRuleset

    if not isinstance(side.ruleset, WrittenRuleset) or view.reason.startswith("the ruleset failed"):
        return None
    return explain(side.ruleset, side.facts)


def _alike(found: Explanation, before: Explanation) -> bool:
    """Whether two views rest on the same rules; one that names a ship must take the same for own ship."""
    symmetric = found.verdict.kind is before.verdict.kind
    rules, others = ([(r.rule.id, "" if symmetric else r.own) for r in e.rules] for e in (found, before))
    return rules == others and (not symmetric or found.verdict.kind not in ("give_way", "stand_on"))


def _misses(side: Side, role: Kind) -> tuple[NearMiss, ...] | None:
    from ccas_core.tapd.explanation import why_not
    from ccas_core.tapd.written import WrittenRuleset

    return why_not(side.ruleset, side.facts, role) if isinstance(side.ruleset, WrittenRuleset) else None


def _flips(meeting: Meeting) -> tuple[tuple[Flip, ...], str]:
    """Smallest changes that change the verdict; and why there are none."""
    from ccas_core.tapd.flip import flips
    from ccas_core.tapd.ruleset import PairRuleset

    settlement = meeting.settlement
    if settlement is None:
        return (), "no change is looked for, for the facts are not known"
    mine, theirs = (meeting.sides[view.own] for view in (settlement.one, settlement.other))
    one, two = mine.ruleset, theirs.ruleset
    if not isinstance(one, PairRuleset) or not isinstance(two, PairRuleset):
        return (), "no change is looked for, for the ruleset does not judge pairs"
    if not mine.fresh.moving:
        return (), "no change is looked for, for positions and courses are not known"

    def judge(facts: PairFacts) -> tuple[Verdict, Verdict]:
        return one.judge(facts), two.judge(facts.mirrored())

    views = judge(mine.fresh)
    if [each.kind for each in views] != [settlement.one.kind, settlement.other.kind]:
        told = ", ".join(f"{each.own} {each.kind}" for each in views)
        return (), f"no change is looked for: recognised anew from positions and courses, it is {told}"
    found = flips(judge, mine.fresh)
    return found, "no change of one ship's course or speed alone would change the verdict"


# -- JSON ------------------------------------------------------------------------------------------


def as_json(meeting: Meeting, role: Kind | None, *, flip: bool) -> dict[str, Any]:
    """Tell a pair as `decisions.jsonl` does, with the conditions of both views."""
    told: dict[str, Any] = {**meeting.about, **meeting.told, "notes": list(meeting.notes)}
    told.setdefault("pair", list(meeting.pair))
    if meeting.settlement is None:
        return {**told, "explanations": {}}
    views = (meeting.settlement.one, meeting.settlement.other)
    found = {view.own: _explained(meeting.sides[view.own], view) for view in views}
    told["explanations"] = {ship: _explanation(each) for ship, each in found.items() if each is not None}
    if role is not None:
        told["why_not"] = {view.own: _why_not(meeting.sides[view.own], role) for view in views}
    if flip:
        flips, why = _flips(meeting)
        told["flips"] = [_flip(each) for each in flips]
        told["no_flip"] = None if flips else why
    return told


def _explanation(found: Explanation) -> dict[str, Any]:
    return {
        "rules": [
            {**_rule(seen), "holds": seen.value, "conditions": [_row(row) for row in seen.rows]}
            for seen in found.rules
        ],
        "recognition": [_row(row) for row in found.recognition],
    }


def _rule(seen: RuleSeen | NearMiss) -> dict[str, Any]:
    citation = seen.rule.citation
    return {
        "rule": seen.rule.id,
        "article": str(citation),
        "version": citation.version,
        "confidence": citation.confidence.value,
        "text": citation.text,
        "source": f"{seen.rule.source.file}:{seen.rule.source.line}",
        "own": seen.own,
        "other": seen.other,
    }


def _row(row: Row) -> dict[str, Any]:
    reading = row.reading
    return {
        "condition": row.text,
        "value": row.value,
        "found": row.found or None,
        "number": _finite(reading.value) if reading else None,
        "limit": _finite(reading.limit) if reading else None,
        "unit": reading.unit if reading else None,
        "margin": _finite(reading.away) if reading else None,
        "label": row.label or "when",
        "joined": row.joined or "all of",
        "parts": [_row(part) for part in row.parts],
    }


def _why_not(side: Side, role: Kind) -> list[dict[str, Any]]:
    return [
        {
            **_rule(miss),
            "failed": [_row(row) for row in miss.failed],
            "possible": miss.possible,
            "prevented_by": miss.prevented_by or None,
        }
        for miss in _misses(side, role) or ()
    ]


def _flip(flip: Flip) -> dict[str, Any]:
    from math import degrees

    views: dict[ShipId, str] = {view.own: view.kind.value for view in flip.views}
    size = degrees(flip.change) if flip.turns else flip.change
    becomes = degrees(flip.becomes) if flip.turns else flip.becomes
    return {
        "ship": flip.ship,
        "manoeuvre": flip.manoeuvre.value,
        "change": size,
        "becomes": becomes,
        "unit": "deg" if flip.turns else "m/s",
        "verdicts": views,
        "words": f"{_outcome_of(flip)}, if {_manoeuvre(flip)}",
    }


def _finite(value: float) -> float | None:
    from math import isfinite

    return value if isfinite(value) else None
