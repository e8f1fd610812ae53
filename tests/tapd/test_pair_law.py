"""The law of a pair: the same for both ships, whichever chart and place; and what is done without it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from ccas_core.frames import FloatArray, NedPose
from ccas_core.plugins import load
from ccas_core.priority import PriorityGraph, settle
from ccas_core.regions import Law, Region
from ccas_core.roles import Geometry
from ccas_core.ships import Hull, Ship, ShipId
from ccas_core.tapd.aboard import OtherVersion, aboard, judging
from ccas_core.tapd.assign import assign_by_law, judged_by_law, remembered
from ccas_core.tapd.encounters import LINGERS, NO_ENCOUNTER, Encounter
from ccas_core.tapd.pair_law import FORESIGHT, law_of_pair, place_of_meeting
from ccas_core.tapd.ruleset import Situation
from ccas_core.verdict import Kind, Verdict
from ccas_core.waterway import Towards, Waters, Waterway
from ccas_core.world import ShipReport, World

RULESETS = load().rulesets
A, B = ShipId("a"), ShipId("b")
RIVER = Waterway(id="river", centreline=np.array([[-5000.0, 0.0], [5000.0, 0.0]]), width=300.0)
BEND = Waterway(id="bend", centreline=np.array([[-5000.0, 0.0], [0.0, 0.0], [0.0, 5000.0]]), width=300.0)
NORTH = Region(
    id="north", ruleset="ccnr", polygon=np.array([[0.0, -9e3], [0.0, 9e3], [9e3, 9e3], [9e3, -9e3]])
)
WATERS = Waters(ruleset="bpr", waterways=(RIVER, BEND), regions=(NORTH,))


def report(
    id_: ShipId, pose: NedPose, speed: float, waterway: str = "river", towards: Towards = Towards.END
) -> ShipReport:
    ship = Ship(id=id_, hull=Hull(length=80.0, beam=9.0), mass=1e6, facts={"propulsion": "motor"})
    return ShipReport(ship=ship, pose=pose, speed=speed, waterway=waterway, towards=towards, ruleset="bpr")


def drawn_pose(rng: np.random.Generator, reach: float) -> NedPose:
    north, east = rng.uniform(-reach, reach, 2)
    return NedPose(float(north), float(east), float(rng.uniform(-math.pi, math.pi)))


def charts(count: int) -> Iterator[tuple[Waters, ShipReport, ShipReport]]:
    """Random charts of overlapping regions, bent waterways, and pairs of ships on them."""
    rng = np.random.default_rng(7)
    rulesets = ["bpr", "ccnr@2022.3.26", "cevni", "de_danube"]
    for _ in range(count):
        ways = tuple(
            Waterway(
                id=name,
                centreline=np.cumsum(rng.uniform(200.0, 2000.0, (4, 2)), axis=0) - 3000.0,
                width=200.0,
            )
            for name in ("one", "two")
        )
        regions = tuple(
            Region(
                id=f"r{n}",
                ruleset=str(rng.choice(rulesets)),
                polygon=rng.uniform(-3000.0, 3000.0, 2)
                + rng.uniform(500.0, 3000.0) * np.array([[0, 0], [1, 0], [1, 1]]),
                precedence=n,
            )
            for n in range(int(rng.integers(1, 5)))
        )
        reports = [
            report(
                id_,
                drawn_pose(rng, 2000.0),
                float(rng.choice([0.0, rng.uniform(0.5, 8.0)])),
                str(rng.choice(["one", "two"])),
                Towards.END if rng.random() < 0.5 else Towards.START,
            )
            for id_ in (A, B)
        ]
        yield Waters(ruleset="colregs", waterways=ways, regions=regions), reports[0], reports[1]


def test_both_ships_of_thousands_of_pairs_come_to_one_law() -> None:
    laws = set()
    for waters, one, other in charts(4000):
        assert place_of_meeting(waters, one, other) == place_of_meeting(waters, other, one)
        law = law_of_pair(waters, one, other)
        assert law == law_of_pair(waters, other, one)
        laws.add(law)

    assert len(laws) == 5  # the pairs are spread over all of them


def test_the_law_of_a_pair_depends_on_neither_ids_nor_hulls_nor_what_a_ship_says_of_its_law() -> None:
    for waters, one, other in charts(500):
        renamed = replace(
            other, ship=Ship(id=ShipId("z"), hull=Hull(length=9.0, beam=3.0), mass=9.0), ruleset="x"
        )

        assert law_of_pair(waters, one, renamed) == law_of_pair(waters, one, other)


def test_the_law_moves_and_turns_with_the_chart() -> None:
    turn, shift = 0.7, np.array([1234.0, -567.0])
    cos, sin = math.cos(turn), math.sin(turn)

    def moved(points: FloatArray) -> FloatArray:
        return np.asarray(points @ np.array([[cos, sin], [-sin, cos]]) + shift)

    def moved_pose(pose: NedPose) -> NedPose:
        north, east = moved(np.array([pose.x, pose.y]))
        return NedPose(float(north), float(east), pose.course + turn)

    same = []
    for waters, one, other in charts(500):
        there = replace(
            waters,
            waterways=tuple(replace(each, centreline=moved(each.centreline)) for each in waters.waterways),
            regions=tuple(replace(each, polygon=moved(each.polygon)) for each in waters.regions),
        )
        reports = [replace(each, pose=moved_pose(each.pose)) for each in (one, other)]
        same.append(law_of_pair(there, *reports) == law_of_pair(waters, one, other))

    assert np.mean(same) > 0.99  # but for places on a border itself, within rounding


def test_ships_that_meet_beyond_a_border_judge_by_the_law_beyond_it() -> None:
    south = report(A, NedPose(-900.0, 0.0, 0.0), 4.0)
    faster = report(B, NedPose(600.0, 0.0, math.pi), 2.0, towards=Towards.START)

    met = place_of_meeting(WATERS, south, faster)
    assert (met.x, met.y) == pytest.approx((100.0, 0.0), abs=1e-2)
    assert law_of_pair(WATERS, south, faster) == Law("ccnr")


@pytest.mark.parametrize(
    ("speeds", "north"),
    [((3.0, 3.0), 50.0), ((3.0, 5.0), 50.0), ((3.0 + 1e-3, 3.0), 50.0 + 3.0 * FORESIGHT)],
    ids=["never", "past", "far ahead"],
)
def test_ships_that_do_not_meet_soon_are_taken_where_they_are_or_at_the_foresight(
    speeds: tuple[float, float], north: float
) -> None:
    behind, ahead = (
        report(id_, NedPose(x, 0.0, 0.0), speed)
        for id_, x, speed in zip((A, B), (0.0, 100.0), speeds, strict=True)
    )

    assert place_of_meeting(WATERS, behind, ahead).x == pytest.approx(north, abs=1.0)


def test_round_a_bend_ships_meet_on_the_water() -> None:
    coming = report(A, NedPose(-1000.0, 0.0, 0.0), 3.0, "bend")
    going = report(B, NedPose(0.0, 400.0, -math.pi / 2.0), 3.0, "bend", Towards.START)

    met = place_of_meeting(WATERS, coming, going)
    assert (met.x, met.y) == pytest.approx((-300.0, 0.0), abs=0.1)


# --- memory ---------------------------------------------------------------------------------------


def head_on(north: float, memory: Encounter | None = None) -> Situation:
    """Two ships 800 m apart that meet half-way, at `north`."""
    reports = {
        A: report(A, NedPose(north - 400.0, 0.0, 0.0), 3.0),
        B: report(B, NedPose(north + 400.0, 0.0, math.pi), 3.0, towards=Towards.START),
    }
    world = World(time=0.0, waters=WATERS, reports=reports)
    return Situation(world=world, encounters={(A, B): memory} if memory else {})


def opening(north: float) -> Situation:
    """The same two ships, past one another and sailing away, `north` of the border."""
    met = head_on(north)
    a, b = (met.world.reports[ship] for ship in (A, B))
    reports = {
        A: replace(a, pose=replace(b.pose, course=0.0)),
        B: replace(b, pose=replace(a.pose, course=math.pi)),
    }
    return replace(met, world=replace(met.world, reports=reports))


def views(
    situation: Situation, mine: tuple[str, ...] = (), theirs: tuple[str, ...] = ()
) -> tuple[Verdict, Verdict]:
    return (
        judged_by_law(aboard(RULESETS, mine), situation, A, B),
        judged_by_law(aboard(RULESETS, theirs), situation, B, A),
    )


def test_an_encounter_keeps_the_law_that_it_began_with() -> None:
    begun = head_on(-200.0)
    pair, memory = remembered(begun, *views(begun))
    later = head_on(200.0, memory)

    assert pair == (A, B)
    assert memory.law == Law("bpr")
    assert {view.ruleset for view in views(later)} == {"bpr"}
    assert remembered(later, *views(later))[1].law == Law("bpr")
    assert {view.ruleset for view in views(head_on(200.0))} == {"ccnr"}  # a new one goes by the new law


def test_ships_that_part_and_soon_meet_again_go_on_under_the_law_that_they_had() -> None:
    """An overtaker may fall back, so that the range grows, and come up again beyond the border."""
    over = opening(900.0)
    memory: Encounter | None = Encounter(
        geometry=Geometry.HEAD_ON, law=Law("bpr"), distance=700.0, opening_periods=1
    )
    log = []
    for _ in range(LINGERS + 1):
        now = replace(over, encounters={(A, B): memory} if memory else {})
        memory = remembered(now, *views(now))[1]
        log.append(memory)

    assert not any(each.lasts for each in log)
    assert [each.law for each in log] == [Law("bpr")] * LINGERS + [None]
    assert log[-1] is NO_ENCOUNTER
    assert {view.ruleset for view in views(head_on(200.0, log[0]))} == {"bpr"}
    assert {view.ruleset for view in views(head_on(200.0, log[-1]))} == {"ccnr"}
    again = head_on(200.0, log[3])
    met = remembered(again, *views(again))[1]
    assert (met.lasts, met.law, met.parted_periods) == (True, Law("bpr"), 0)


def test_ships_that_remember_two_laws_forget_both_and_come_together_again() -> None:
    one, other = (
        head_on(200.0, Encounter(geometry=Geometry.HEAD_ON, law=Law(law), distance=900.0))
        for law in ("bpr", "ccnr")
    )
    mine, theirs = views(one)[0], views(other)[1]
    settled = settle(mine, theirs, {A: 1.0, B: 2.0})

    assert settled.fallback == "a judges by bpr 2026.6.17, b by ccnr 2022.3.26"
    after = remembered(one, mine, theirs)[1], remembered(other, theirs, mine)[1]
    assert [each.law for each in after] == [None, None]
    again = head_on(190.0, after[0])
    assert not settle(*views(again), {A: 1.0, B: 2.0}).fallback
    assert remembered(again, *views(again))[1].law == Law("ccnr")


def test_a_verdict_that_was_not_heard_is_no_reason_to_forget_the_law() -> None:
    begun = head_on(-200.0)

    assert remembered(begun, views(begun)[0])[1].law == Law("bpr")


# --- ships that have not got a ruleset ------------------------------------------------------------


def test_a_ship_without_the_law_judges_by_its_own_and_both_fall_back_and_say_why() -> None:
    situation = head_on(200.0)
    mine, theirs = views(situation, mine=("bpr", "cevni"))
    settled = settle(mine, theirs, {A: 1.0, B: 2.0})

    assert (mine.ruleset, mine.lacks, theirs.ruleset, theirs.lacks) == ("bpr", "ccnr", "ccnr", "")
    assert settled.mutual
    assert settled.fallback == "a judges by bpr 2026.6.17 for want of ccnr, b by ccnr 2022.3.26"


def test_in_waters_of_a_law_that_both_have_the_two_agree() -> None:
    mine, theirs = views(head_on(-600.0), mine=("bpr",))

    assert not settle(mine, theirs, {A: 1.0, B: 2.0}).fallback
    assert mine.lacks == theirs.lacks == ""


def test_ships_of_two_versions_fall_back() -> None:
    mine, theirs = views(head_on(-600.0), mine=("bpr@2019.1.1",))
    settled = settle(mine, theirs, {A: 1.0, B: 2.0})

    assert settled.fallback == "a judges by bpr 2019.1.1, b by bpr 2026.6.17"
    assert (mine.kind, mine.geometry) == (Kind.UNKNOWN_FACT, theirs.geometry)


def test_two_ships_of_a_version_that_is_not_installed_fall_back_as_nobody_knows_its_rules() -> None:
    mine, theirs = views(head_on(-600.0), mine=("bpr@2019.1.1",), theirs=("bpr@2019.1.1",))

    assert settle(mine, theirs, {A: 1.0, B: 2.0}).fallback == (
        "unknown_fact: the rules of bpr 2019.1.1 are not installed"
    )


def test_another_version_says_nothing_of_ships_that_do_not_meet_and_ranks_as_the_installed_one() -> None:
    installed = RULESETS["bpr"]
    other = OtherVersion(installed, "1")
    apart = Situation(
        world=World(
            time=0.0,
            waters=WATERS,
            reports={
                A: report(A, NedPose(0.0, 0.0, math.pi), 3.0, towards=Towards.START),
                B: report(B, NedPose(900.0, 0.0, 0.0), 3.0),
            },
        )
    )
    ship = apart.world.reports[A].ship

    seen = other.view(apart, A, B)
    assert seen is None or (seen.kind, seen.version) == (Kind.NONE, "1")
    assert (other.rank(ship), other.criterion) == (installed.rank(ship), installed.criterion)
    assert other.emit(head_on(0.0)).settlements[0].fallback


def test_what_is_aboard_is_all_unless_it_is_named() -> None:
    assert aboard(RULESETS, ()) is RULESETS
    assert list(aboard(RULESETS, ("ccnr", "bpr"))) == ["ccnr", "bpr"]
    assert aboard(RULESETS, (f"bpr@{RULESETS['bpr'].version}",))["bpr"] is RULESETS["bpr"]
    assert judging(aboard(RULESETS, ("ccnr", "bpr")), Law("cevni")).id == "ccnr"


# --- groups on both sides -------------------------------------------------------------------------


def test_groups_partly_on_each_side_have_an_order_without_cycles() -> None:
    rng = np.random.default_rng(3)
    mixed = 0
    for _ in range(150):
        ids = [ShipId(f"s{n}") for n in range(int(rng.integers(3, 7)))]
        reports = {}
        for id_ in ids:
            on, towards = (
                str(rng.choice(["river", "bend"])),
                (Towards.END, Towards.START)[int(rng.integers(2))],
            )
            reports[id_] = report(id_, drawn_pose(rng, 400.0), float(rng.uniform(1.0, 5.0)), on, towards)
        situation = Situation(world=World(time=0.0, waters=WATERS, reports=reports))
        judged = {id_: {v.other: v for v in assign_by_law(RULESETS, situation, id_)} for id_ in ids}
        masses = {id_: float(rng.uniform(1e5, 1e7)) for id_ in ids}
        pairs = [(one, other) for n, one in enumerate(ids) for other in ids[n + 1 :]]
        settled = [settle(judged[one][other], judged[other][one], masses) for one, other in pairs]
        graph = PriorityGraph(masses=masses, settlements=tuple(settled))
        order = [id_ for generation in graph.generations() for id_ in generation]
        opened = {(each.edge.first, each.edge.then) for each in graph.openings}

        assert sorted(order) == ids
        for first, then in set(graph.digraph.edges) - opened:
            assert order.index(first) < order.index(then)
        assert all(each.one.ruleset == each.other.ruleset for each in settled)
        mixed += len({each.one.ruleset for each in settled}) > 1
    assert mixed > 50
