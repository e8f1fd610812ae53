"""Whether roles stay while nobody manoeuvres: from the first verdict on, until past and clear.

Ships remember how their encounter began (`tapd.encounters`): risk, geometry, who overtakes, who has the
other to starboard.  A role can then change only by a condition of a rule that looks at motion itself.  What
would happen without memory is told as a note.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..tapd.cases import Case, CaseShip
from ..tapd.language.polynomial import variable
from ..tapd.written import WrittenRuleset
from ..verdict import Kind, Verdict
from .findings import Fault, Finding
from .ladder import Ladder
from .pairs import Tally
from .questions import Questions
from .search import A, B, Ships, case_of, judged, meetings, suggested
from .solver import NONLINEAR_LIMIT, Answer, Found, ask_linear, ask_nonlinear
from .symbols import View, constants_of

LATER: tuple[float, ...] = (20.0, 60.0, 120.0, 240.0)  # times at which ships are looked at again [s]
_TRIES = 600
_ROLES = {Kind.GIVE_WAY, Kind.STAND_ON}


def role_stable(questions: Questions) -> Finding:
    """No ship that had to give way has to stand on later, or the other way round, by itself."""
    tally = Tally()
    ruleset = questions.rulesets[0]
    constants = constants_of(ruleset.text, free=questions.free)
    elapsed = variable("elapsed")
    first = Ladder(View(questions.symbols, ruleset.text, A, B, constants, remembered=True))
    then = Ladder(View(questions.symbols, ruleset.text, A, B, constants, remembered=True, later=elapsed))
    later = questions.symbols.sign(elapsed, frozenset({1}))
    for before, after in ((Kind.GIVE_WAY, Kind.STAND_ON), (Kind.STAND_ON, Kind.GIVE_WAY)):
        tally.questions += 1
        terms = [later, first.says(before), then.says(after), *questions.domain()]
        answer = ask_linear(questions.symbols, terms, questions.budget)
        if not answer.impossible:
            guess = answer
            answer = ask_nonlinear(questions.symbols, terms, questions.budget, NONLINEAR_LIMIT)
            if not answer.impossible:
                _look(tally, ruleset, answer if answer.found is Found.POSSIBLE else guess)
                continue
        tally.methods.add(answer.method)
    if not tally.faults:
        tally.notes += _without_memory(ruleset)
    return tally.finding("role_stable")


def _look(tally: Tally, ruleset: WrittenRuleset, answer: Answer) -> None:
    found = flipping(ruleset, answer, remembered=True)
    if found is None:
        tally.open.append("a role may change by itself: possible for the solver, and no ships were found")
        return
    ships, seconds, after = found
    before = ships.verdicts[0]
    title = f"{before.kind} by '{before.rule}' becomes {after.kind} by '{after.rule}' after {seconds:.0f} s"
    rules = tuple(ruleset.text.rule(id_) for id_ in dict.fromkeys((before.rule, after.rule)))
    if title not in [fault.title for fault in tally.faults]:
        tally.faults.append(Fault(title=title, rules=rules, ships=ships, kind="instability"))


def _without_memory(ruleset: WrittenRuleset) -> list[str]:
    found = flipping(ruleset, Answer(found=Found.POSSIBLE, method=""), remembered=False)
    if found is None:
        return []
    ships, seconds, after = found
    before = ships.verdicts[0]
    was, now = (f"{view.kind} by '{view.rule}' ({view.article})" for view in (before, after))
    return [f"thanks to memory: without it {was} would become {now} after {seconds:.0f} s"]


def flipping(
    ruleset: WrittenRuleset, answer: Answer, *, remembered: bool, seed: int = 0
) -> tuple[Ships, float, Verdict] | None:
    """Ships whose roles are swapped some time later; the time, and own ship's verdict then."""
    facts = suggested(ruleset.text, answer)
    facts = replace(facts, pair={name: v for name, v in facts.pair.items() if name.startswith("same_")})
    domain = ruleset.text.domain
    speeds = (float(domain.speed[0]), float(domain.speed[1]))
    rng = np.random.default_rng(seed)
    for places in meetings(rng, speeds, float(domain.separation), _TRIES):
        case = case_of(facts, places)
        now = judged((ruleset, ruleset), case)
        if now[0].kind not in _ROLES:
            continue
        for seconds in LATER:
            then = judged((ruleset, ruleset), sailed_on(case, seconds, now[0] if remembered else None))
            if {then[0].kind, now[0].kind} == _ROLES:
                return Ships(case=case, verdicts=now, margin=0.0), seconds, then[0]
    return None


def sailed_on(case: Case, seconds: float, memory: Verdict | None) -> Case:
    """The same ships later, both at constant velocity; with what they remember of their encounter."""
    encounter = {name: value for name, value in case.encounter.items() if name.startswith("same_")}
    if memory is not None:
        encounter |= {
            "risk_of_collision": True,
            "geometry": memory.geometry.value,
            "overtaker": memory.overtaker or "none",
            "has_other_on_starboard": memory.has_other_on_starboard or "none",
        }
    return replace(case, ships=tuple(_ahead(ship, seconds) for ship in case.ships), encounter=encounter)


def _ahead(ship: CaseShip, seconds: float) -> CaseShip:
    assert ship.pose is not None and ship.speed is not None  # noqa: S101, PT018
    north, east, course = ship.pose
    way = ship.speed * seconds
    return replace(ship, pose=(north + way * math.cos(course), east + way * math.sin(course), course))
