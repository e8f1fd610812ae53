"""What a voyage came to: every definition of the contract, on voyages made by hand."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from ccas_core.frames import NedPose, PathFrame
from ccas_core.priority import Edge, EdgeKind, Opening
from ccas_core.roles import Geometry, PassingSide
from ccas_core.ships import Hull, Ship, ShipId
from ccas_core.sim.conduct import Encounter, Judgement, encounters, judge
from ccas_core.sim.frame import Frame
from ccas_core.sim.metrics import deadlocks, guiding_frames, plain, safety_indices, summary
from ccas_core.sim.scenario import Scenario
from ccas_core.verdict import Kind
from ccas_core.waterway import Obstacle

from . import (
    EAST,
    NORTH,
    WEST,
    A,
    B,
    C,
    Commands,
    Settled,
    always,
    plan,
    scenario,
    settlement,
    voyage,
    waters,
)

HEAD_ON = scenario(plan(A, EAST, before=600.0), plan(B, WEST, before=600.0))  # TCPA 200 s, half of it 100 s
CROSSING = scenario(plan(A, EAST, before=600.0), plan(B, NORTH, before=600.0))
STAY: Commands = [(0.0, 1.0)]
ASIDE: Commands = [(0.0, 1.0), (0.0, 1.0), (30.0, 1.0)]
SLOW: Commands = [(0.0, 1.0), (0.0, 0.4), (0.0, 0.4), (0.0, 0.4), (0.0, 0.4), (0.0, 0.4), (0.0, 1.0)]
GIVE_WAY = settlement(Kind.GIVE_WAY, Kind.STAND_ON, geometry=Geometry.CROSSING)
MUTUAL = settlement(Kind.MUTUAL, Kind.MUTUAL, side=PassingSide.PORT_TO_PORT)
NONE = settlement(Kind.NONE, Kind.NONE)

KEYS = {
    "schema",
    "scenario",
    "solver",
    "collisions",
    "entries",
    "groundings",
    "allisions",
    "frozen",
    "min_clearance_m",
    "min_safety_index_m",
    "ships",
    "encounters",
    "ruleset_switches",
    "deadlocks",
    "domains",
    "remarks",
    "update_ms",
}
SHIP_KEYS = {
    "min_clearance_m",
    "min_safety_index_m",
    "max_offset_change_m",
    "min_speed_factor",
    "delay_s",
    "arrived",
    "frozen",
}
ENCOUNTER_KEYS = {
    "ships",
    "geometry",
    "kind",
    "ruleset",
    "give_way",
    "stand_on",
    "article",
    "risky",
    "faithful",
    "calm",
}


def judged(of: Scenario, one: Commands, other: Commands, settled: Settled) -> Judgement:
    frames = voyage(of, {A: one, B: other}, settled)
    (encounter,) = encounters(frames)
    return judge(encounter, of, frames, guiding_frames(of))


# --- safety index


def test_safety_index_uses_the_own_ships_axes_and_safety_area() -> None:
    small = Ship(id=B, hull=Hull(length=40.0, beam=8.0), mass=1.0)  # safety area 40 x 12
    paper = HEAD_ON.ships[0].ship
    northward, eastward = (PathFrame(np.array([[0.0, 0.0], end])) for end in ([9.0, 0.0], [0.0, 9.0]))

    indices = safety_indices(
        {A: NedPose(0.0, 0.0, 0.0), B: NedPose(200.0, 30.0, 0.0)},
        {A: paper, B: small},
        {A: northward, B: eastward},
    )

    assert indices == pytest.approx({A: 200.0 - 51.5, B: 200.0 - 6.0})


def test_ship_alone_has_no_safety_index() -> None:
    ship, line = HEAD_ON.ships[0].ship, PathFrame(np.array([[0.0, 0.0], [9.0, 0.0]]))

    assert safety_indices({A: NedPose(0.0, 0.0, 0.0)}, {A: ship}, {A: line}) == {A: None}
    assert safety_indices({}, {}, {}) == {}


# --- encounters


def kinds(*settled: str) -> list[Frame]:
    """Frames in which the pair is in an encounter (x), judged to be in none (o), or not settled (-)."""
    table = {"x": (GIVE_WAY,), "o": (NONE,), "-": ()}
    return voyage(HEAD_ON, {A: STAY, B: STAY}, lambda k: table[settled[k]], periods=len(settled))


@pytest.mark.parametrize(
    ("settled", "spans"),
    [
        ("oxxxo", [(1, 4)]),
        ("oxx-xx", [(1, 6)]),  # one period without a settlement does not end it
        ("oxx--xx", [(1, 3), (5, 7)]),
        ("xxoxx", [(0, 2), (3, 5)]),
        ("ooo", []),
        ("x----", [(0, 1)]),
    ],
)
def test_encounter_lasts_from_the_first_verdict_until_none_again(
    settled: str, spans: list[tuple[int, int]]
) -> None:
    assert [(each.begin, each.end) for each in encounters(kinds(*settled))] == spans


def test_duty_and_geometry_are_those_of_the_first_verdict() -> None:
    later = settlement(Kind.STAND_ON, Kind.GIVE_WAY, geometry=Geometry.OVERTAKING)
    frames = voyage(HEAD_ON, {A: STAY, B: STAY}, lambda k: (GIVE_WAY,) if k < 2 else (later,), periods=5)

    (encounter,) = encounters(frames)

    assert (encounter.geometry, encounter.kind) == (Geometry.CROSSING, Kind.GIVE_WAY)
    assert (encounter.give_way, encounter.stand_on) == ((A,), (B,))


def first_encounter(one: Kind, other: Kind) -> Encounter:
    frames = voyage(HEAD_ON, {A: STAY, B: STAY}, always(settlement(one, other)), periods=2)
    return encounters(frames)[0]


def test_stand_on_view_of_the_first_ship_is_a_give_way_encounter() -> None:
    encounter = first_encounter(Kind.STAND_ON, Kind.GIVE_WAY)

    assert (encounter.kind, encounter.give_way, encounter.stand_on) == (Kind.GIVE_WAY, (B,), (A,))


def test_fallback_is_a_mutual_encounter() -> None:
    encounter = first_encounter(Kind.GIVE_WAY, Kind.NONE)

    assert (encounter.kind, encounter.give_way, encounter.stand_on) == (Kind.MUTUAL, (A, B), ())
    assert encounter.article == "BPR 6.04"


# --- risky, calm


@pytest.mark.parametrize(
    ("aside", "risky", "calm"),
    [
        (0.0, True, False),
        (21.3, True, False),  # 21.3 - 11.4 = 9.9
        (21.5, False, False),
        (61.3, False, False),
        (61.5, False, True),  # 50.1
    ],
)
def test_risky_and_calm_are_those_of_the_undisturbed_hulls(aside: float, risky: bool, calm: bool) -> None:
    of = scenario(plan(A, EAST, before=600.0, aside=aside), plan(B, WEST, before=600.0))

    judgement = judged(of, [(aside, 0.2)], [(0.0, 0.2)], always(GIVE_WAY))

    assert (judgement.risky, judgement.calm) == (risky, calm)
    assert (judgement.faithful is None) == (not risky)


def test_only_two_ships_are_judged() -> None:
    of = scenario(*HEAD_ON.ships, plan(C, NORTH, before=2900.0))
    frames = voyage(of, {A: ASIDE, B: STAY, C: STAY}, always(GIVE_WAY))

    judgement = judge(encounters(frames)[0], of, frames, guiding_frames(of))

    assert judgement == Judgement(risky=True, calm=False, faithful=None)


@pytest.mark.parametrize("kind", [Kind.COOPERATE, Kind.PROHIBITED])
def test_encounter_without_a_duty_is_not_judged(kind: Kind) -> None:
    assert judged(HEAD_ON, ASIDE, STAY, always(settlement(kind, kind))).faithful is None


# --- faithful: one gives way, the other stands on


@pytest.mark.parametrize("acting", [ASIDE, SLOW, [(-11.0, 1.0)], [(0.0, 0.89)]])
def test_give_way_ship_that_acts_early_is_faithful(acting: Commands) -> None:
    assert judged(HEAD_ON, acting, STAY, always(GIVE_WAY)).faithful is True


@pytest.mark.parametrize(
    "acting",
    [
        STAY,
        [(10.0, 0.9)],  # neither more than 10 m nor below 0.9
        [(0.0, 1.0)] * 5 + [(30.0, 1.0)],  # at 100 s, when half of the TCPA has passed
    ],
)
def test_give_way_ship_that_does_too_little_or_acts_late_is_not(acting: Commands) -> None:
    assert judged(HEAD_ON, acting, STAY, always(GIVE_WAY)).faithful is False


def test_acting_in_the_last_period_before_half_of_the_tcpa_is_early_enough() -> None:
    assert judged(HEAD_ON, [(0.0, 1.0)] * 4 + [(30.0, 1.0)], STAY, always(GIVE_WAY)).faithful is True


@pytest.mark.parametrize("keeping", [[(5.0, 0.95)], [(-5.0, 1.0)]])
def test_stand_on_ship_may_do_a_little(keeping: Commands) -> None:
    assert judged(CROSSING, SLOW, keeping, always(GIVE_WAY)).faithful is True


@pytest.mark.parametrize("moving", [[(5.1, 1.0)], [(0.0, 0.94)], [(0.0, 1.0)] * 8 + [(0.0, 0.5), (0.0, 1.0)]])
def test_stand_on_ship_that_moves_before_past_and_clear_is_not_faithful(moving: Commands) -> None:
    assert judged(CROSSING, SLOW, moving, always(GIVE_WAY)).faithful is False


def test_stand_on_ship_is_free_when_past_and_clear() -> None:
    head_on_passed = [(0.0, 1.0)] * 14 + [(-40.0, 0.5)]  # hulls are past at 240 s

    assert judged(HEAD_ON, ASIDE, head_on_passed, always(GIVE_WAY)).faithful is True


def test_offset_is_compared_with_that_in_force_at_the_first_verdict() -> None:
    beside = scenario(plan(A, EAST, before=900.0, aside=15.0), plan(B, WEST, before=900.0, aside=-15.0))
    late = lambda k: (GIVE_WAY,) if k >= 2 else ()  # noqa: E731

    assert judged(beside, [(15.0, 1.0)], [(-15.0, 1.0)], late).faithful is False
    assert judged(beside, [(15.0, 1.0)] * 2 + [(26.0, 1.0)], [(-15.0, 1.0)], late).faithful is True


def test_stand_on_ship_with_a_side_to_follow_may_move() -> None:
    bound = settlement(Kind.GIVE_WAY, Kind.STAND_ON, side=PassingSide.PORT_TO_PORT, required=True)
    preferred = settlement(Kind.GIVE_WAY, Kind.STAND_ON, side=PassingSide.PORT_TO_PORT)

    assert judged(HEAD_ON, ASIDE, ASIDE, always(bound)).faithful is True
    assert judged(HEAD_ON, ASIDE, ASIDE, always(preferred)).faithful is False


def test_stand_on_ship_follows_the_side_that_the_other_chooses() -> None:
    side = PassingSide.PORT_TO_PORT
    by_other = settlement(Kind.GIVE_WAY, Kind.STAND_ON, side=side, chosen_by=A)
    by_itself = settlement(Kind.GIVE_WAY, Kind.STAND_ON, side=side, chosen_by=B)

    assert judged(HEAD_ON, ASIDE, ASIDE, always(by_other)).faithful is True
    assert judged(HEAD_ON, ASIDE, ASIDE, always(by_itself)).faithful is False


def test_where_courses_part_at_first_the_undisturbed_approach_sets_the_time() -> None:
    frames = voyage(HEAD_ON, {A: ASIDE, B: STAY}, always(GIVE_WAY))
    turned = {
        id_: replace(ship, pose=replace(ship.pose, course=-ship.pose.course))
        for id_, ship in frames[0].ships.items()
    }
    frames[0] = replace(frames[0], ships=turned)

    judgement = judge(encounters(frames)[0], HEAD_ON, frames, guiding_frames(HEAD_ON))

    assert judgement == Judgement(risky=True, calm=False, faithful=True)


# --- faithful: both give way


TO_PORT: Commands = [(0.0, 1.0), (-30.0, 1.0)]


@pytest.mark.parametrize(
    ("one", "other", "faithful"),
    [
        (ASIDE, ASIDE, True),
        (ASIDE, STAY, False),  # only one acts
        (STAY, STAY, False),
        (TO_PORT, TO_PORT, False),  # both act, and pass on the wrong side
    ],
)
def test_in_mutual_both_act_and_pass_on_the_prescribed_side(
    one: Commands, other: Commands, faithful: bool
) -> None:
    assert judged(HEAD_ON, one, other, always(MUTUAL)).faithful is faithful


def test_starboard_to_starboard_is_the_mirror_image() -> None:
    mirrored = settlement(Kind.MUTUAL, Kind.MUTUAL, side=PassingSide.STARBOARD_TO_STARBOARD)

    assert judged(HEAD_ON, TO_PORT, TO_PORT, always(mirrored)).faithful is True
    assert judged(HEAD_ON, ASIDE, ASIDE, always(mirrored)).faithful is False


def test_each_ship_has_the_other_on_the_prescribed_side() -> None:
    astern = scenario(plan(A, EAST, before=600.0), plan(B, EAST, before=490.0))  # 7 m between them
    overtaking = {"one": [(30.0, 1.0)], "other": [(0.0, 0.3)]}  # a has b on port, b has a on starboard

    assert judged(astern, **overtaking, settled=always(MUTUAL)).faithful is False
    assert judged(astern, **overtaking, settled=always(settlement(Kind.GIVE_WAY, Kind.NONE))).faithful is True


def test_fallback_prescribes_no_side() -> None:
    fallback = settlement(Kind.GIVE_WAY, Kind.NONE, side=PassingSide.PORT_TO_PORT)

    assert judged(HEAD_ON, TO_PORT, TO_PORT, always(fallback)).faithful is True


# --- the summary


def test_summary_has_every_key_of_the_contract_and_is_json() -> None:
    frames = voyage(HEAD_ON, {A: ASIDE, B: STAY}, always(GIVE_WAY))

    found = summary(HEAD_ON, frames, "ddp")

    assert set(found) == KEYS
    assert found["schema"] == "ccas/summary@1"
    assert (found["scenario"], found["solver"]) == ("by hand", "ddp")
    assert {frozenset(ship) for ship in found["ships"].values()} == {frozenset(SHIP_KEYS)}  # type: ignore[attr-defined]
    assert {frozenset(each) for each in found["encounters"]} == {frozenset(ENCOUNTER_KEYS)}  # type: ignore[attr-defined]
    assert found["update_ms"] == {"median": 2.0, "p99": 3.0, "max": 3.0}
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_summary_of_a_passing() -> None:
    frames = voyage(HEAD_ON, {A: ASIDE, B: STAY}, always(GIVE_WAY))

    found = summary(HEAD_ON, frames, "ddp")

    assert [found[key] for key in ("collisions", "entries", "groundings", "allisions", "frozen")] == [0] * 5
    assert found["min_clearance_m"] == pytest.approx(30.0 - 11.4)
    assert found["encounters"] == [
        {
            "ships": ["a", "b"],
            "geometry": "crossing",
            "kind": "give_way",
            "ruleset": "bpr",
            "give_way": ["a"],
            "stand_on": ["b"],
            "article": "BPR 6.04",
            "risky": True,
            "faithful": True,
            "calm": False,
        }
    ]


def test_summary_counts_collisions_and_entries_of_pairs() -> None:
    found = summary(HEAD_ON, voyage(HEAD_ON, {A: STAY, B: STAY}), "ddp")

    assert (found["collisions"], found["entries"]) == (1, 1)
    assert found["min_clearance_m"] == 0.0
    assert found["min_safety_index_m"] == pytest.approx(-8.6)


def test_summary_counts_groundings_of_ships_and_allisions() -> None:
    pier = Obstacle(id="pier", x=0.0, y=0.0, radius=5.0)
    of = replace(HEAD_ON, waters=waters(width=60.0, obstacles=(pier,)))

    found = summary(of, voyage(of, {A: [(26.0, 1.0)], B: STAY}), "ddp")

    assert (found["groundings"], found["allisions"]) == (1, 1)


def ship_entry(of: Scenario, frames: list[Frame], id_: ShipId) -> dict[str, object]:
    ships = summary(of, frames, "ddp")["ships"]
    assert isinstance(ships, dict)
    entry: dict[str, object] = ships[id_]
    return entry


def test_ship_alone_has_neither_clearance_nor_index() -> None:
    of = scenario(plan(A, EAST, before=-2900.0))
    frames = voyage(of, {A: [(4.0, 1.0), (-6.0, 0.5)]})

    assert ship_entry(of, frames, A) == {
        "min_clearance_m": None,
        "min_safety_index_m": None,
        "max_offset_change_m": 6.0,
        "min_speed_factor": 0.5,
        "delay_s": pytest.approx(40.0 / 1.5 - 40.0 / 3.0),
        "arrived": True,
        "frozen": False,
    }
    assert summary(of, frames, "ddp")["min_clearance_m"] is None


def test_ship_that_arrives_on_time_has_no_delay() -> None:
    of = scenario(plan(A, EAST, before=-2000.0))

    assert ship_entry(of, voyage(of, {A: STAY}), A)["delay_s"] == pytest.approx(0.0)


@pytest.mark.parametrize(("stopped", "frozen"), [(20, False), (21, True)])
def test_ship_is_frozen_after_a_delay_of_more_than_20_periods(stopped: int, frozen: bool) -> None:
    of = scenario(plan(A, EAST, before=-2940.0))

    entry = ship_entry(of, voyage(of, {A: [(0.0, 0.0)] * stopped + [(0.0, 1.0)]}), A)

    assert (entry["arrived"], entry["frozen"]) == (True, frozen)


def test_ship_that_did_not_arrive_is_frozen() -> None:
    of = scenario(plan(A, EAST, before=600.0))

    entry = ship_entry(of, voyage(of, {A: STAY}, periods=5), A)

    assert (entry["arrived"], entry["delay_s"], entry["frozen"]) == (False, None, True)


def test_change_of_ruleset_is_told() -> None:
    frames = voyage(HEAD_ON, {A: ASIDE, B: STAY}, periods=4)
    rhine = {id_: replace(ship, ruleset="ccnr") for id_, ship in frames[2].ships.items() if id_ == A}
    frames[2:] = [replace(frame, ships={**frame.ships, **rhine}) for frame in frames[2:]]

    found = summary(HEAD_ON, frames, "ddp")

    assert found["ruleset_switches"] == [{"ship": "a", "time_s": 40.0, "from": "bpr", "to": "ccnr"}]


def test_deadlock_is_told_once_with_all_its_ships() -> None:
    ring = (
        settlement(Kind.GIVE_WAY, Kind.STAND_ON, pair=(A, B)),
        settlement(Kind.STAND_ON, Kind.GIVE_WAY, pair=(A, C)),
        settlement(Kind.GIVE_WAY, Kind.STAND_ON, pair=(B, C)),
    )
    opening = Opening(Edge(C, A, EdgeKind.DUTY), "lightest first")
    of = scenario(*HEAD_ON.ships, plan(C, NORTH, before=900.0))
    frames = voyage(of, {A: STAY, B: STAY, C: STAY}, always(*ring), periods=4)
    frames = [replace(frame, openings=(opening,)) if frame.index else frame for frame in frames]

    (deadlock,) = deadlocks(frames, {A: 1.0, B: 2.0, C: 3.0})

    assert (deadlock.time, deadlock.ships, deadlock.openings) == (20.0, (A, B, C), (opening,))
    assert summary(of, frames, "ddp")["deadlocks"] == [
        {"time_s": 20.0, "ships": ["a", "b", "c"], "opened": [["c", "a", "lightest first"]]}
    ]


def test_voyage_without_solves_has_no_update_times() -> None:
    frames = voyage(HEAD_ON, {A: ASIDE, B: STAY}, periods=2)
    frames = [
        replace(frame, ships={id_: replace(ship, update_ms=()) for id_, ship in frame.ships.items()})
        for frame in frames
    ]

    assert summary(HEAD_ON, frames, "ddp")["update_ms"] == {"median": None, "p99": None, "max": None}


def test_voyage_without_frames_has_no_summary() -> None:
    with pytest.raises(ValueError, match="without frames"):
        summary(HEAD_ON, [], "ddp")


def test_what_is_not_a_finite_number_is_null() -> None:
    assert plain({"t": (math.nan, -math.inf, 1.0), "kind": Kind.NONE}) == {
        "t": [None, None, 1.0],
        "kind": "none",
    }
