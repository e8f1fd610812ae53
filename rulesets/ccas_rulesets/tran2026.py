"""Algorithm 1 of Tran, Johansen and Negenborn (2026): as its text has it, and as it is printed.

The paper takes its rules from the Dutch BPR.  The print of Algorithm 1 contradicts its own text; no
reading of it satisfies the text.  `tran2026` is the algorithm that the text describes; `tran2026_printed`
is the print to the letter, kept as the worked example of an inconsistent ruleset.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ccas_core.roles import Geometry, PassingSide
from ccas_core.ships import FactValue
from ccas_core.tapd.facts import OPPOSITE, PairFacts, is_crossing, is_head_on, known, overtakes
from ccas_core.tapd.ruleset import PairRuleset
from ccas_core.verdict import Citation, Confidence, Kind, Verdict

REGULATION = "Tran et al. 2026"
EDITION = "doi:10.1016/j.oceaneng.2026.124802"
T_HO = 900.0  # T_ho of Eq. (3): the horizon of 45 periods, for the paper does not print it [s]
T_IC = 900.0  # T_IC of Algorithm 1, likewise [s]


def _cite(article: str) -> Citation:
    return Citation(regulation=REGULATION, article=article, version=EDITION, confidence=Confidence.TEXT_SEEN)


def stated(facts: PairFacts) -> dict[str, FactValue]:
    """Facts that Algorithm 1 looks at, by their names in the vocabulary."""
    return {
        "course_difference_deg": round(math.degrees(facts.course_difference), 6),
        "tcpa_s": round(facts.tcpa, 6),
        "dcpa_m": round(facts.dcpa, 6),
        "same_waterway": facts.same_waterway,
        "own.time_to_intersection_s": round(facts.own_time_to_intersection, 6),
        "other.time_to_intersection_s": round(facts.other_time_to_intersection, 6),
        "own.follows_starboard_side": facts.own_on_starboard_side,
        "other.follows_starboard_side": facts.other_on_starboard_side,
        "other_comes_from_starboard": facts.courses_cross_from > 0.0,
    }


@dataclass(frozen=True, slots=True)
class Tran2026(PairRuleset):
    """Algorithm 1 as the text of Sec. 3.1 describes it, with memory, and symmetric in the two ships."""

    id: str = "tran2026"
    version: str = "1.0.0"
    title: str = "Priority assignment of Tran et al. 2026, Algorithm 1, corrected"

    def judge(self, facts: PairFacts) -> Verdict:
        """Judge a pair: overtaking before head-on before crossing; an encounter keeps its geometry."""
        geometry, own_overtakes = self._classify(facts)
        if geometry is Geometry.NONE:
            return self._verdict(facts, Kind.NONE, geometry, "", None, "no_risk")
        if geometry is Geometry.OVERTAKING:
            kind = Kind.GIVE_WAY if own_overtakes else Kind.STAND_ON
            reason = "the overtaking ship keeps out of the way"
            return self._verdict(facts, kind, geometry, "overtaking", _cite("Sec. 3.1, overtaking"), reason)
        own, other = facts.own_on_starboard_side, facts.other_on_starboard_side
        if not (known(own) and known(other)):
            reason = "whether a ship follows the starboard side is not known"
            return self._verdict(facts, Kind.UNKNOWN_FACT, geometry, "", None, reason)
        if own != other:
            kind = Kind.STAND_ON if own else Kind.GIVE_WAY
            rule = f"{geometry}.starboard-side"
            reason = "the ship that follows the starboard side of the waterway stands on"
            return self._verdict(facts, kind, geometry, rule, _cite(f"Sec. 3.1, {_name(geometry)}"), reason)
        if geometry is Geometry.HEAD_ON:
            return self._verdict(
                facts,
                Kind.MUTUAL,
                geometry,
                "head_on.both",
                _cite("Sec. 3.1, head-on"),
                "both keep to starboard and pass port to port",
                PassingSide.PORT_TO_PORT,
            )
        if facts.courses_cross_from == 0.0:
            reason = "the courses do not cross, and the starboard side decides nothing"
            return self._verdict(facts, Kind.GAP, geometry, "", None, reason)
        kind = Kind.GIVE_WAY if facts.courses_cross_from > 0.0 else Kind.STAND_ON
        reason = "the ship that comes from port gives way"
        if own:
            reason += (
                "; the text has this rule for ships that do not follow the starboard side, these both do"
            )
        return self._verdict(
            facts, kind, geometry, "crossing.from-starboard", _cite("Sec. 3.1, crossing"), reason
        )

    def _classify(self, facts: PairFacts) -> tuple[Geometry, bool]:
        """Geometry of the encounter, and whether `own` overtakes."""
        memory = facts.encounter
        if memory.geometry is not Geometry.NONE:
            return memory.geometry, memory.overtaker == facts.own.id
        if overtakes(facts, T_HO):
            return Geometry.OVERTAKING, True
        if overtakes(facts.mirrored(), T_HO):
            return Geometry.OVERTAKING, False
        if is_head_on(facts, T_HO):
            return Geometry.HEAD_ON, False
        if is_crossing(facts, T_IC):
            return Geometry.CROSSING, False
        return Geometry.NONE, False

    def _verdict(
        self,
        facts: PairFacts,
        kind: Kind,
        geometry: Geometry,
        rule: str,
        citation: Citation | None,
        reason: str,
        side: PassingSide | None = None,
    ) -> Verdict:
        return Verdict(
            own=facts.own.id,
            other=facts.other.id,
            kind=kind,
            ruleset=self.id,
            version=self.version,
            rule=rule,
            citation=citation,
            geometry=geometry,
            strength="keep_clear" if kind in (Kind.GIVE_WAY, Kind.STAND_ON, Kind.MUTUAL) else "",
            passing_side=side,
            passing_required=side is not None,
            reason=reason,
            facts=stated(facts),
        )


def _name(geometry: Geometry) -> str:
    return geometry.value.replace("_", "-")


@dataclass(frozen=True, slots=True)
class Tran2026Printed(PairRuleset):
    """Algorithm 1 to the letter: inconsistent, and wrong by its own text.

    Read with line 21 comparing with rho_{j,i}, and STARBOARD as a relative bearing between 0 and 180
    degrees.  What the print does not say is not added: no lower bound on times, no memory, no rule for
    overtaking, no test of the situation before line 21, and p_list = 0 is taken for standing on.
    """

    id: str = "tran2026_printed"
    version: str = "1.0.0"
    title: str = "Priority assignment of Tran et al. 2026, Algorithm 1, as printed"

    def judge(self, facts: PairFacts) -> Verdict:
        """Run lines 1 to 26 on ship `own` for one ship j."""
        rho_own = 1.0 if facts.own_on_starboard_side is True else 0.0  # lines 2-6
        rho_other = 1.0 if facts.other_on_starboard_side is True else 0.0
        increment = 0.5  # varpi, 0 < varpi < 1
        geometry = Geometry.NONE
        if facts.own_time_to_intersection < T_IC and facts.other_time_to_intersection < T_IC:  # line 9
            geometry = Geometry.CROSSING
            if rho_other < 1.0:  # line 11
                if 0.0 < facts.bearing_of_own < math.pi:  # line 12: i comes from the starboard of j
                    rho_other += increment
                elif facts.bearing_of_own < 0.0:  # line 14
                    rho_other -= increment
        elif self._head_on(facts):  # line 18
            geometry = Geometry.HEAD_ON
        gives_way = rho_own > rho_other  # line 21
        return Verdict(
            own=facts.own.id,
            other=facts.other.id,
            kind=Kind.GIVE_WAY if gives_way else Kind.STAND_ON,
            ruleset=self.id,
            version=self.version,
            rule="line 22" if gives_way else "line 24",
            citation=_cite("Algorithm 1"),
            geometry=geometry,
            reason=f"rho_ii = {rho_own:g}, rho_ji = {rho_other:g}",
            facts=stated(facts),
        )

    @staticmethod
    def _head_on(facts: PairFacts) -> bool:
        """Eq. (3) as printed: no lower bound on TCPA, the waterway in the own frame, undefined at rest."""
        return (
            min(facts.own.speed, facts.other.speed) > 0.0
            and facts.course_difference > OPPOSITE
            and facts.tcpa <= T_HO
            and facts.same_waterway
        )
