"""Scenario files: what is read, what is refused and where, and that what is written reads back."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ccas_core.dmpc.parameters import PARAMETERS, RiskShape, Start, Wait
from ccas_core.errors import Diagnostic, ScenarioError
from ccas_core.frames import NedPose
from ccas_core.quantities import MASS
from ccas_core.regions import Region
from ccas_core.ships import UNKNOWN, FactValue, Hull, Ship, ShipId
from ccas_core.sim.scenario import BusChoice, ControlChoice, Plan, Profile, Scenario
from ccas_core.sim.scenario_dump import dump_scenario
from ccas_core.sim.scenario_file import load_scenario, parse_scenario
from ccas_core.tapd.vocabulary import VOCABULARY, Fact, Scope, Source
from ccas_core.tapd.vocabulary import Kind as FactKind
from ccas_core.units import DEGREE
from ccas_core.waterway import Leg, Obstacle, Towards, Waters, Waterway

TEXT = """\
schema: ccas/scenario@1
name: two ships cross
title: Crossing
time: {step: 20 s, duration: 10 min}
waters:
  ruleset: bpr
  regions:
    - {id: north, ruleset: ccnr, polygon: [[-4000, 500], [4000, 500], [4000, 4000], [-4000, 4000]]}
  waterways:
    - {id: canal, centreline: [[-3000, 0], [3000, 0]], width: 160 m, upstream: none}
    - {id: river, centreline: [[0, -3000], [0, 3000]], width: 0.16 km, upstream: end, facts: {type: river, regime: [bpr_6_05, tidal]}}
    - {id: far, centreline: [[9000, -3000], [9000, 3000]], width: 160 m}
  obstacles:
    - {id: pier, at: [100, 20], radius: 15 m}
ships:
  - id: ship_1
    length: 103 m
    beam: 11.4 m
    weight: 2000 t
    route: [{waterway: canal, towards: end, offset: 20 m}]
    start: [-1800, -20]
    speed: 10.8 km/h
    facts: {propulsion: motor, blue_sign: true, windward: unknown, draught: 2.8 m, passengers_max: 12, heading: 90 deg}
  - id: ship_2
    length: 80 m
    beam: 10 m
    safety_length: 100 m
    safety_beam: 20 m
    weight: 900 t
    route: [{waterway: river, towards: start}, {waterway: canal, towards: start}]
    start: [0, 1500]
    course: 185 deg
    speed: 5.8 kn
control:
  horizon: 40
  iterations: 5
  profile: crossing
  parameters: {K_y: 0.5, chi_max: 25 deg, T_1: 0.5 min, K_e: 0.01 1/m, alpha_x: 6724 m2}
  wait: interleaved
  risk_shape: axis_bound
  starts: [last, nominal, starboard]
  deadlock_detection: false
bus: {loss: 0.1, delay: 2 s, seed: 7}
"""  # noqa: E501 - a line of a file


def findings(text: str, rulesets: tuple[str, ...] | None = ("bpr", "ccnr")) -> tuple[Diagnostic, ...]:
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(text, "file.yaml", rulesets)
    return caught.value.diagnostics


def outcome(text: str) -> tuple[tuple[Diagnostic, ...], Scenario | None]:
    """Findings, or a scenario; anything else is an error of the test."""
    try:
        return (), parse_scenario(text, "file.yaml")
    except ScenarioError as error:
        return error.diagnostics, None


def changed(old: str, new: str) -> str:
    assert TEXT.count(old) == 1, old
    return TEXT.replace(old, new)


def place(text: str, piece: str) -> tuple[int, int]:
    """Line and column of the last occurrence of a piece."""
    before = text[: text.rindex(piece)]
    return before.count("\n") + 1, len(before) - before.rfind("\n")


def plain(value: object) -> object:
    """The same value, such that `==` compares it in full."""
    if dataclasses.is_dataclass(value):
        fields = (field for field in dataclasses.fields(value) if not field.name.startswith("_"))
        return type(value), {field.name: plain(getattr(value, field.name)) for field in fields}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, tuple):
        return [plain(each) for each in value]
    return value


# --- what is read ------------------------------------------------------------------------------


def test_a_scenario_is_read_in_si_and_with_north_first() -> None:
    scenario = parse_scenario(TEXT, rulesets={"bpr", "ccnr"})

    assert (scenario.name, scenario.title, scenario.description) == ("two ships cross", "Crossing", "")
    assert (scenario.time_step, scenario.duration) == (20.0, 600.0)
    canal, river, far = scenario.waters.waterways
    assert canal.centreline.tolist() == [[0.0, -3000.0], [0.0, 3000.0]]
    assert (river.width, river.upstream, far.upstream) == (160.0, Towards.END, Towards.NONE)
    assert dict(river.facts) == {"type": "river", "regime": "bpr_6_05 tidal"}
    assert scenario.waters.obstacles == (Obstacle(id="pier", x=20.0, y=100.0, radius=15.0),)
    assert scenario.waters.ruleset_at(NedPose(600.0, 0.0, 0.0)) == "ccnr"
    assert scenario.bus == BusChoice(loss=0.1, delay=2.0, seed=7)


def test_a_ship_is_read_with_what_it_states_of_itself() -> None:
    one, two = parse_scenario(TEXT).ships

    assert one.ship.hull == Hull(length=103.0, beam=11.4)
    assert (one.ship.mass, one.speed, one.route) == (2e6, 3.0, (Leg("canal", Towards.END, 20.0),))
    assert dict(one.ship.facts) == {
        "propulsion": "motor",
        "blue_sign": True,
        "windward": UNKNOWN,
        "draught": 2.8,
        "passengers_max": 12,
        "heading": pytest.approx(90.0 * DEGREE),
    }
    assert two.ship.hull == Hull(length=80.0, beam=10.0, safety_length=100.0, safety_beam=20.0)
    assert (two.start.x, two.start.y) == (1500.0, 0.0)
    assert two.start.course == pytest.approx(-175.0 * DEGREE)


def test_a_ship_without_course_starts_along_its_guiding_line() -> None:
    one, _ = parse_scenario(TEXT).ships
    other, _ = parse_scenario(changed("towards: end, offset: 20 m", "towards: start")).ships

    assert one.start == NedPose(-20.0, -1800.0, 90.0 * DEGREE)
    assert other.start.course == pytest.approx(-90.0 * DEGREE)


def test_control_is_read_and_has_defaults() -> None:
    control = parse_scenario(TEXT).control

    assert (control.horizon, control.iterations, control.profile) == (40, 5, Profile.CROSSING)
    assert control.parameters == pytest.approx(
        {"K_y": 0.5, "chi_max": 25.0 * DEGREE, "T_1": 30.0, "K_e": 0.01, "alpha_x": 6724.0}
    )
    assert (control.wait, control.risk_shape) == (Wait.INTERLEAVED, RiskShape.AXIS_BOUND)
    assert control.starts == (Start.LAST, Start.NOMINAL, Start.STARBOARD)
    assert control.deadlock_detection is False
    short = parse_scenario(TEXT[: TEXT.index("control:")])
    assert (short.control, short.bus) == (ControlChoice(), BusChoice())


def test_ships_may_start_with_overlapping_hulls() -> None:
    text = changed("start: [0, 1500]", "start: [0, -20]").replace("start: [-1800, -20]", "start: [0, -20]")

    assert len(parse_scenario(text).ships) == 2


def test_lonlat_positions_are_laid_on_a_plane_that_touches_at_the_first() -> None:
    text = """\
schema: ccas/scenario@1
name: on the map
time: {step: 20 s}
waters:
  ruleset: bpr
  waterways:
    - {id: rhine, centreline: [{lonlat: [6.10, 51.80]}, {lonlat: [6.10, 51.90]}], width: 300 m}
ships:
  - {id: a, length: 80 m, beam: 10 m, weight: 900 t, speed: 3 m/s, start: {lonlat: [6.101, 51.85]},
     route: [{waterway: rhine, towards: end}]}
"""
    scenario = parse_scenario(text)

    (rhine,) = scenario.waters.waterways
    assert rhine.centreline[0].tolist() == [0.0, 0.0]
    assert rhine.centreline[1].tolist() == pytest.approx([11127.0, 0.0], abs=5.0)
    start = scenario.ships[0].start
    assert start.x == pytest.approx(5563.0, abs=5.0)
    assert start.y == pytest.approx(69.0, abs=1.0)
    assert start.course == 0.0
    assert plain(parse_scenario(dump_scenario(scenario))) == plain(scenario)
    (finding,) = findings(text.replace("51.90", "15.90"))
    assert finding.message == "more than 500 km from the first position"


# --- what is refused ---------------------------------------------------------------------------

# One change each: what stands there, what the user writes instead, what of it is pointed at, what is told.
FAULTS = [
    ("name: two", "nme: two", "nme", "unknown key 'nme'", "did you mean 'name'?"),
    ("beam: 11.4 m", "baem: 11.4 m", "baem", "unknown key 'baem'", "did you mean 'beam'?"),
    ("step: 20 s", "step: 20", "20,", "'20' has no unit", "if it is in s, write '20 s'"),
    ("step: 20 s", "step: 0 s", "0 s,", "'0 s' is out of range", ""),
    ("step: 20 s", "step: -20 s", "-20 s", "'-20 s' is out of range", ""),
    ("duration: 10 min", "duration: -1 s", "-1 s", "'-1 s' is out of range", ""),
    ("length: 103 m", "length: 103 kg", "103 kg", "'103 kg' is a weight, not a length", ""),
    ("length: 103 m", "length: 0 m", "0 m\n    beam: 11", "'0 m' is out of range", ""),
    ("length: 103 m", "length: .inf m", ".inf m", "'.inf m' is not finite", ""),
    ("beam: 11.4 m", "beam: -11.4 m", "-11.4", "'-11.4 m' is out of range", ""),
    ("weight: 2000 t", "weight: 0 t", "0 t\n    route: [{waterway: canal", "'0 t' is out of range", ""),
    ("weight: 2000 t", "weight: 2000", "2000\n", "'2000' has no unit", "if it is in t, write '2000 t'"),
    ("speed: 10.8 km/h", "speed: 0 m/s", "0 m/s", "'0 m/s' is out of range", ""),
    ("speed: 10.8 km/h", "speed: 31 m/s", "31 m/s", "'31 m/s' is out of range", ""),
    ("speed: 5.8 kn", "speed: 5.8 m", "5.8 m", "'5.8 m' is a length, not a speed", ""),
    ("width: 0.16 km", "width: -1 m", "-1 m", "'-1 m' is out of range", ""),
    ("radius: 15 m", "radius: 0 m", "0 m}\nships", "'0 m' is out of range", ""),
    ("id: ship_2", "id: ship_1", "ship_1", "a second ship 'ship_1'",
     "the first is at line 16, column 9; rename one"),
    ("{id: far", "{id: canal", "canal, c", "a second waterway 'canal'",
     "the first is at line 10, column 12; rename one"),
    ("ruleset: bpr\n", "ruleset: brp\n", "brp", "unknown ruleset 'brp'", "did you mean 'bpr'?"),
    ("ruleset: ccnr", "ruleset: rhine", "rhine", "unknown ruleset 'rhine'", "known: bpr, ccnr"),
    ("waterway: river", "waterway: rivr", "rivr", "unknown waterway 'rivr'", "did you mean 'river'?"),
    ("towards: end", "towards: none", "none, offset", "got 'none'", ""),
    ("upstream: none", "upstream: up", "up}", "got 'up'", ""),
    ("[-1800, -20]", "[-1800, -200]", "[-1800", "the ship starts outside its first waterway 'canal'",
     "it is 200 m off a centreline with 80 m to each side"),
    ("[-1800, -20]", "[-3800, -20]", "[-3800", "the ship starts outside its first waterway 'canal'",
     "it is before the start or past the end of the centreline"),
    ("[-1800, -20]", "[3000, -20]", "[3000, -20]", "the ship starts past the end of its route",
     "is 'towards' the other end?"),
    ("{waterway: canal, towards: start}", "{waterway: far, towards: end}", "{waterway: far",
     "no guiding line can be drawn: the legs along 'river' and 'far' do not meet",
     "a route goes over to the next waterway where the guiding lines cross"),
    ("{waterway: canal, towards: start}", "{waterway: river, towards: end}", "{waterway: river, towards: end",
     "no guiding line can be drawn: the legs along 'river' double back",
     "a route goes over to the next waterway where the guiding lines cross"),
    ("[-1800, -20]", "[-1800]", "[-1800]", "a list of 1",
     "a position is [east, north] in metres, or {lonlat: [longitude, latitude]}"),
    ("[-1800, -20]", "here", "here", "got 'here'", ""),
    ("[-1800, -20]", "{lonlat: [6, 51]}", "[6, 51]", "lonlat and [east, north] positions in one file",
     "this file began with [east, north], at line 10; write all positions in that way"),
    ("[[0, -3000], [0, 3000]]", "[[0, -3000]]", "[[0, -3000]]", "a list of 1", ""),
    ("[[0, -3000], [0, 3000]]", "[[0, 7], [0, 7], [0, 9]]", "[0, 7]",
     "the same point as the one before", "remove one"),
    ("[[0, -3000], [0, 3000]]", "[[0, 0], [0, 99], [0, 7]]", "[0, 99]", "the centreline turns back here",
     "begin another waterway instead"),
    ("[4000, 500], [4000, 4000], [-4000, 4000]]", "[4000, 500]]", "[[-4000, 500]", "a list of 2", ""),
    ("[4000, 500], [4000, 4000], [-4000, 4000]]", "[4000, 4000], [4000, 500], [-4000, 4000]]",
     "[[-4000, 500]",
     "the polygon crosses itself or has no area", "go once around the region"),
    ("horizon: 40", "horizon: 0", "0\n  iter", "got '0'", ""),
    ("horizon: 40", "horizon: 201", "201", "got '201'", ""),
    ("iterations: 5", "iterations: 101", "101", "got '101'", ""),
    ("iterations: 5", "iterations: 2.5", "2.5\n", "got '2.5'", ""),
    ("profile: crossing", "profile: cross", "cross\n  param", "got 'cross'", "did you mean 'crossing'?"),
    ("K_y: 0.5", "K_z: 0.5", "K_z", "unknown parameter 'K_z'", "did you mean 'K_y'?"),
    ("K_y: 0.5", "K_y: -0.5", "-0.5", "'-0.5' is out of range", ""),
    ("K_y: 0.5", "K_y: 0.5 m", "0.5 m,", "'0.5 m' is a length, not a number without unit", ""),
    ("chi_max: 25 deg", "chi_max: 95 deg", "95 deg", "'95 deg' is out of range", ""),
    ("wait: interleaved", "wait: ", " \n  risk", "got nothing", ""),
    ("starts: [last, nominal, starboard]", "starts: []", "[]", "a list of 0", ""),
    ("deadlock_detection: false", "deadlock_detection: off", "off", "got 'off'", ""),
    ("loss: 0.1", "loss: 1", "1, d", "'1' is out of range", ""),
    ("seed: 7", "seed: -1", "-1}", "got '-1'", ""),
    ("draught: 2.8 m", "draught: 2.8", "2.8,", "'2.8' has no unit", "if it is in m, write '2.8 m'"),
    ("draught: 2.8 m", "draught: 2.8 t", "2.8 t", "'2.8 t' is a weight, not a length", ""),
    ("draught: 2.8 m", "draft: 2.8 m", "draft", "unknown fact of a ship 'draft'", "did you mean 'draught'?"),
    ("type: river", "tipe: river", "tipe", "unknown fact of a waterway 'tipe'", "did you mean 'type'?"),
    ("propulsion: motor", "propulsion: moter", "moter", "unknown value of 'propulsion' 'moter'",
     "did you mean 'motor'?"),
    ("blue_sign: true", "blue_sign: yes", "yes", "got 'yes'", ""),
    ("passengers_max: 12", "passengers_max: dozen", "dozen", "'passengers_max' is a number", ""),
    ("- {id: north, ruleset: ccnr, polygon: [[-4000, 500], [4000, 500], [4000, 4000], [-4000, 4000]]}",
     "- rotterdm", "rotterdm", "unknown region 'rotterdm'", ""),
    ("course: 185 deg", "course: 185", "185\n", "'185' has no unit", "if it is in deg, write '185 deg'"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "pointed", "message", "hint"), FAULTS)
def test_a_fault_is_told_with_its_place_and_a_hint(
    old: str, new: str, pointed: str, message: str, hint: str
) -> None:
    text = changed(old, new)
    (finding,) = findings(text)

    assert (finding.message, finding.hint) == (message, hint)
    assert (finding.line, finding.column) == place(text, pointed)
    assert finding.source == "file.yaml"
    assert finding.excerpt == text.splitlines()[finding.line - 1][: len(finding.excerpt)]


def test_a_missing_key_is_told_at_its_block() -> None:
    told = findings(changed("    speed: 5.8 kn\n", ""))

    assert [(each.line, each.column, each.message) for each in told] == [
        (24, 5, "the key 'speed' is missing here")
    ]


def test_all_faults_of_a_file_are_told_at_once() -> None:
    text = changed("step: 20 s", "step: 20").replace(" beam:", " baem:").replace("loss: 0.1", "loss: 2")

    assert [(each.line, each.message) for each in findings(text)] == [
        (4, "'20' has no unit"),
        (18, "unknown key 'baem'"),
        (26, "unknown key 'baem'"),
        (43, "'2' is out of range"),
    ]


def test_a_fault_of_a_waterway_brings_no_faults_of_its_ships() -> None:
    (finding,) = findings(changed("width: 160 m, upstream: none", "width: 160"))

    assert finding.message == "'160' has no unit"


def test_regions_and_obstacles_have_ids_of_their_own() -> None:
    again = "    - {id: pier, at: [0, 0], radius: 1 m}\nships:"
    (finding,) = findings(changed("ships:", again))

    assert finding.message == "a second obstacle 'pier'"
    region = "    - {id: north, ruleset: bpr, polygon: [[0, 0], [9, 0], [9, 9]]}\n  waterways:"
    (finding,) = findings(changed("  waterways:", region))
    assert finding.message == "a second region 'north'"


def test_an_alias_does_not_hide_that_two_ships_have_one_id() -> None:
    start, end = TEXT.index("  - id: ship_1"), TEXT.index("  - id: ship_2")
    text = TEXT[:start] + "  - &it\n    id: ship_1" + TEXT[start + 14 : end] + "  - *it\n" + TEXT[end:]

    assert [each.message for each in findings(text)] == ["a second ship 'ship_1'"]


ROTTERDAM = Region(id="rotterdam", ruleset="ccnr", polygon=np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]]))


def named(name: str) -> str:
    """The file, with a region that is only named."""
    drawn = TEXT[TEXT.index("- {id: north") : TEXT.index("  waterways:")]
    return changed(drawn, f"- {name}\n")


def test_a_region_of_a_plugin_is_taken_by_its_id() -> None:
    scenario = parse_scenario(named("rotterdam"), rulesets={"bpr", "ccnr"}, regions={"rotterdam": ROTTERDAM})

    assert scenario.waters.regions == (ROTTERDAM,)
    assert plain(parse_scenario(dump_scenario(scenario))) == plain(scenario)


def test_a_region_that_no_plugin_has_is_told_with_the_nearest() -> None:
    with pytest.raises(ScenarioError, match="did you mean 'rotterdam'"):
        parse_scenario(named("roterdam"), regions={"rotterdam": ROTTERDAM})


def test_a_region_of_a_plugin_under_a_ruleset_that_is_not_there_is_refused() -> None:
    with pytest.raises(ScenarioError, match="region 'rotterdam' is under the unknown ruleset 'ccnr'"):
        parse_scenario(named("rotterdam"), rulesets={"bpr"}, regions={"rotterdam": ROTTERDAM})


def test_facts_of_plugins_are_read_and_written_by_their_vocabulary() -> None:
    tugs = Fact(
        name="tug_power",
        scope=Scope.SHIP,
        kind=FactKind.NUMBER,
        meaning="pull of its tugs",
        source=Source.MESSAGE,
        quantity=MASS,
    )
    vocabulary = VOCABULARY.extended([tugs])
    text = changed("draught: 2.8 m", "tug_power: 50 t")

    scenario = parse_scenario(text, vocabulary=vocabulary)

    assert scenario.ships[0].ship.facts["tug_power"] == 50_000.0
    again = dump_scenario(scenario, vocabulary)
    assert "tug_power: 50 t" in again
    assert plain(parse_scenario(again, vocabulary=vocabulary)) == plain(scenario)


def test_rulesets_are_not_checked_where_none_are_named() -> None:
    assert parse_scenario(changed("ruleset: bpr\n", "ruleset: any\n")).waters.ruleset == "any"


def test_a_file_of_another_kind_is_told_so() -> None:
    (finding,) = findings(changed("ccas/scenario@1", "ccas/ruleset@1"))

    assert (finding.line, finding.column, finding.expected) == (1, 9, "ccas/scenario@1")


def test_the_schema_must_come_first() -> None:
    lines = TEXT.splitlines(keepends=True)
    (finding,) = findings("".join([lines[1], lines[0], *lines[2:]]))

    assert (finding.line, finding.message) == (1, "'schema' must come first")


def test_a_file_that_is_not_there_is_a_scenario_error(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="No such file"):
        load_scenario(tmp_path / "none.yaml")


# --- there and back ----------------------------------------------------------------------------

_names = st.one_of(
    st.sampled_from(
        ["a", "ship 1", "no", "12:30", "3", "2 t", "true", "null", "x: y", "#", "é", "- a", "~", "*x"]
    ),
    st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=8).filter(
        lambda text: text.strip()
    ),
)
_sizes = st.floats(0.1, 500.0)


def _values_of(fact: Fact) -> st.SearchStrategy[FactValue]:
    """All values that a file can state for a fact."""
    words = st.lists(_names.filter(lambda text: len(text.split()) == 1), max_size=3)
    known: dict[FactKind, st.SearchStrategy[FactValue]] = {
        FactKind.FLAG: st.booleans(),
        FactKind.NUMBER: st.floats(-1e6, 1e6).map(fact.quantity.keep),
        FactKind.CHOICE: st.sampled_from(fact.choices or ("",)),
        FactKind.FLAGS: words.map(lambda found: " ".join(each.strip() for each in found)),
        FactKind.TEXT: _names.filter(lambda text: text != "unknown"),
    }
    return st.one_of(st.just(UNKNOWN), known[fact.kind])


def _facts_of(scope: Scope) -> st.SearchStrategy[dict[str, FactValue]]:
    one = st.sampled_from(VOCABULARY.by_scope[scope]).flatmap(
        lambda fact: st.tuples(st.just(fact.name), _values_of(fact))
    )
    return st.lists(one, max_size=3).map(dict)


@st.composite
def scenarios(draw: st.DrawFn) -> Scenario:
    """Scenarios with odd numbers and odd texts, on a cross of two waterways."""
    names = draw(st.lists(_names, min_size=2, max_size=2, unique=True))
    arm = draw(st.floats(1000.0, 9000.0))
    lines = [[-arm, 0.0], [0.0, draw(st.floats(-9.0, 9.0))], [arm, 0.0]], [[0.0, -arm], [0.0, arm]]
    waterways = tuple(
        Waterway(
            id=name,
            centreline=np.array(line),
            width=draw(st.floats(50.0, 500.0)),
            upstream=draw(st.sampled_from(Towards)),
            facts=draw(_facts_of(Scope.WATERWAY)),
        )
        for name, line in zip(names, lines, strict=True)
    )
    polygon = np.array([[0.0, 0.0], [draw(_sizes), 0.0], [0.0, draw(_sizes)]])
    waters = Waters(
        ruleset=draw(_names),
        waterways=waterways,
        regions=(Region(id="r", ruleset=draw(_names), polygon=polygon),) if draw(st.booleans()) else (),
        obstacles=(Obstacle(id=draw(_names), x=draw(_sizes), y=draw(_sizes), radius=draw(_sizes)),),
    )
    legs = [
        Leg(name, draw(st.sampled_from([Towards.START, Towards.END])), draw(st.floats(-9.0, 9.0)))
        for name in names
    ]
    ships = tuple(
        Plan(
            ship=Ship(
                id=ShipId(id_),
                hull=Hull(
                    length=draw(_sizes), beam=draw(_sizes), safety_beam=draw(st.sampled_from([0.0, 33.3]))
                ),
                mass=draw(st.floats(1e3, 1e7)),
                facts=draw(_facts_of(Scope.SHIP)),
            ),
            route=tuple(legs[: draw(st.integers(1, 2))]),
            start=NedPose(
                draw(st.floats(-900.0, 900.0)), draw(st.floats(-9.0, 9.0)), draw(st.floats(-3.1, 3.1))
            ),
            speed=draw(st.floats(0.1, 29.0)),
        )
        for id_ in draw(st.lists(_names, min_size=1, max_size=3, unique=True))
    )
    parameters = draw(st.lists(st.sampled_from(sorted(PARAMETERS)), unique=True, max_size=4))
    control = ControlChoice(
        horizon=draw(st.integers(1, 200)),
        profile=draw(st.sampled_from(Profile)),
        parameters={
            name: draw(st.floats(PARAMETERS[name].low * 1.01 + 1e-9, min(1.5, PARAMETERS[name].high)))
            for name in parameters
        },
        wait=draw(st.none() | st.sampled_from(Wait)),
        risk_shape=draw(st.none() | st.sampled_from(RiskShape)),
        starts=draw(st.none() | st.lists(st.sampled_from(Start), min_size=1).map(tuple)),
        deadlock_detection=draw(st.booleans()),
    )
    return Scenario(
        name=draw(_names),
        title=draw(st.just("") | _names),
        description=draw(st.just("") | _names),
        waters=waters,
        ships=ships,
        time_step=draw(_sizes),
        duration=draw(st.floats(0.0, 1e5)),
        control=control,
        bus=BusChoice(
            loss=draw(st.floats(0.0, 0.99)), delay=draw(_sizes), seed=draw(st.integers(0, 2**63 - 1))
        ),
    )


def test_what_was_read_is_written_and_read_back_bit_for_bit() -> None:
    scenario = parse_scenario(TEXT)
    text = dump_scenario(scenario)

    assert plain(parse_scenario(text)) == plain(scenario)
    assert dump_scenario(parse_scenario(text)) == text
    assert max(map(len, text.splitlines())) <= 100


@settings(derandomize=True, deadline=None, max_examples=150)
@given(scenarios())
def test_any_scenario_is_written_and_read_back(scenario: Scenario) -> None:
    text = dump_scenario(scenario)
    told, once = outcome(text)
    if once is None:  # a route that cannot be drawn, or a start beyond its end
        unfit = ("no guiding line can be drawn", "the ship starts past the end of its route")
        assert all(each.message.startswith(unfit) for each in told)
        return
    again = parse_scenario(dump_scenario(once))

    assert dump_scenario(once) == text
    assert plain(again) == plain(once)
    for one, other in zip(scenario.ships, once.ships, strict=True):
        assert other.ship.facts == one.ship.facts
        assert (other.ship.id, other.route[0].waterway) == (one.ship.id, one.route[0].waterway)
        assert other.speed == pytest.approx(one.speed, rel=1e-11)
        assert math.cos(other.start.course - one.start.course) == pytest.approx(1.0)


DAMAGE = [
    *(each.encode() for each in ["\x00", "\t", "[", "]", "{", "}", "'", '"', "!", "?", "|", "#", "-", "0"]),
    *(b"", b"\n", b": ", b"- ", b"&a ", b"*a", b"<<: ", b"---\n", b"\xff", b"\xe2\x80\xa8"),
    *(b" m", b"null", b".nan", b"1e300", b"1e-300"),
]


@settings(derandomize=True, deadline=None, max_examples=600)
@given(st.data())
def test_a_damaged_file_gives_findings_or_a_scenario_and_nothing_else(data: st.DataObject) -> None:
    raw = bytearray(TEXT.encode())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(raw)))
        raw[at : at + data.draw(st.integers(0, 12))] = data.draw(
            st.sampled_from(DAMAGE) | st.binary(max_size=3)
        )
    told, scenario = outcome(raw.decode("utf-8", "surrogateescape"))

    if scenario is None:
        assert told
        assert all(each.message and each.source == "file.yaml" for each in told)
    else:
        assert plain(parse_scenario(dump_scenario(scenario))) == plain(scenario)


@settings(derandomize=True, deadline=None, max_examples=200)
@given(data=st.binary(max_size=80))
def test_bytes_without_sense_give_findings(data: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("garbage") / "file.yaml"
    path.write_bytes(data)

    with pytest.raises(ScenarioError):
        load_scenario(path)
