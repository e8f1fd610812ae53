"""Regions of scenario files: versions, stretches, precedence, hysteresis; what is refused, with its place."""

from __future__ import annotations

import numpy as np
import pytest

from ccas_core.errors import Diagnostic, ScenarioError
from ccas_core.frames import NedPose
from ccas_core.plugins import load
from ccas_core.regions import Hysteresis, Law, Region
from ccas_core.sim.scenario import Scenario
from ccas_core.sim.scenario_dump import dump_scenario
from ccas_core.sim.scenario_file import parse_scenario

RULESETS = load().rulesets
CCNR = RULESETS["ccnr"].version
TEXT = """\
schema: ccas/scenario@1
name: border
time: {step: 20 s}
waters:
  ruleset: bpr
  regions:
    - {id: rhine, ruleset: ccnr, stretch: {waterway: river, from: 2 km, to: 4000 m}}
  waterways:
    - {id: river, centreline: [[-3000, 0], [0, 0], [3000, 500]], width: 200 m}
ships:
  - id: one
    length: 103 m
    beam: 11.4 m
    weight: 2000 t
    route: [{waterway: river, towards: end}]
    start: [-2500, 0]
    speed: 3 m/s
"""
STRETCH = "stretch: {waterway: river, from: 2 km, to: 4000 m}"
RHINE = f"    - {{id: rhine, ruleset: ccnr, {STRETCH}}}\n"
WEST = "polygon: [[-4000, -500], [0, -500], [0, 500], [-4000, 500]]"


def read(text: str) -> Scenario:
    scenario = parse_scenario(text, "file.yaml", RULESETS)
    again = dump_scenario(scenario)
    assert dump_scenario(parse_scenario(again, rulesets=RULESETS)) == again
    return scenario


def changed(old: str, new: str) -> str:
    assert TEXT.count(old) == 1, old
    return TEXT.replace(old, new)


def finding(text: str) -> Diagnostic:
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(text, "file.yaml", RULESETS)
    (found,) = caught.value.diagnostics
    return found


def law_at(scenario: Scenario, east: float, north: float = 0.0) -> Law:
    return scenario.waters.laws.at(NedPose(north, east, 0.0))


def test_a_stretch_is_the_water_from_bank_to_bank_round_a_bend() -> None:
    scenario = read(TEXT)

    places = {-1001.0: "bpr", -999.0: "ccnr", 985.0: "ccnr", 1005.0: "bpr"}
    assert {east: law_at(scenario, east, max(0.0, east / 6.0)).ruleset for east in places} == places
    assert law_at(scenario, -500.0, 99.0).ruleset == "ccnr"
    assert law_at(scenario, -500.0, 101.0).ruleset == "bpr"


def test_a_stretch_without_ends_is_the_whole_waterway() -> None:
    scenario = read(changed(STRETCH, "stretch: {waterway: river}"))

    assert {law_at(scenario, east).ruleset for east in (-2999.0, 0.0, 400.0)} == {"ccnr"}


def test_a_version_is_written_behind_the_id() -> None:
    scenario = read(changed("ruleset: ccnr", f"ruleset: ccnr@{CCNR}"))

    assert law_at(scenario, -500.0) == Law("ccnr", CCNR)


def test_what_prevails_where_regions_overlap_is_written_as_precedence() -> None:
    more = f"{RHINE}    - {{id: basin, ruleset: cevni, precedence: 2, {WEST}}}\n"
    scenario = read(changed(RHINE, more))

    assert law_at(scenario, -500.0) == Law("cevni")
    assert law_at(scenario, 500.0, 80.0) == Law("ccnr")


def test_hysteresis_is_read_and_written() -> None:
    text = changed("  waterways:", "  hysteresis: {width: 25 m, time: 2 min}\n  waterways:")

    assert read(text).waters.hysteresis == Hysteresis(width=25.0, time=120.0)
    assert read(TEXT).waters.hysteresis == Hysteresis()


def test_regions_that_cover_all_water_need_no_default() -> None:
    more = f"    - {{id: rhine, ruleset: ccnr, {WEST}}}\n{REST}"
    scenario = read(changed(RHINE, more).replace("  ruleset: bpr\n", ""))

    assert scenario.waters.laws.default is None
    assert (law_at(scenario, -500.0).ruleset, law_at(scenario, 500.0).ruleset) == ("ccnr", "bpr")


def test_rulesets_aboard_are_read_in_any_version() -> None:
    scenario = read(TEXT + "    rulesets: [bpr, ccnr@2019.1.1]\n")

    assert scenario.ships[0].rulesets == ("bpr", "ccnr@2019.1.1")
    assert read(TEXT).ships[0].rulesets == ()


REST = "    - {id: rest, ruleset: bpr, polygon: [[0, -500], [4000, -500], [4000, 900], [0, 900]]}\n"
DEGREES = "[[5.8, 51.8], [6.1, 51.8], [6.1, 51.9]]"

FAULTS = [
    ("ruleset: ccnr", "ruleset: ccnr@2019.1.1", "ccnr@2019",
     "version 2019.1.1 of ruleset 'ccnr' is not installed",
     f"installed is ccnr@{CCNR}; without a version, that one is meant"),
    ("ruleset: ccnr", "ruleset: ccnr@", "ccnr@", "no version follows '@'", "write 'ccnr' for any version"),
    ("ruleset: ccnr", "ruleset: cnr@1", "cnr@1", "unknown ruleset 'cnr'", "did you mean 'ccnr'?"),
    (RHINE, f"{RHINE}    - {{id: basin, ruleset: cevni, {WEST}}}\n", "[[-4000",
     "regions 'rhine' and 'basin' overlap, under ccnr and cevni",
     "say which of them prevails there: give it a greater `precedence: 1`"),
    ("  ruleset: bpr\n  regions:\n" + RHINE, f"  regions:\n{REST}", "- {id: rest",
     "no ruleset is in force at [-1504, 0]: the regions leave a hole",
     "draw a region there, or give the waters a 'ruleset' for all that lies outside"),
    (STRETCH, f"polygon: {DEGREES}", DEGREES, "the polygon lies on no water: are these degrees?",
     "a position in degrees is {lonlat: [longitude, latitude]}, throughout the file"),
    (STRETCH, "polygon: [[126.97, 37.55], [126.99, 37.55], [126.99, 37.57]]", "[[126",
     "the polygon lies on no water: are these degrees?",
     "a position in degrees is {lonlat: [longitude, latitude]}, throughout the file"),
    ("[[-3000, 0], [0, 0], [3000, 500]]", "[[5.8, 51.8], [6.1, 51.9]]", "[[5.8",
     "the centreline is shorter than a ship: are these degrees?",
     "a position in degrees is {lonlat: [longitude, latitude]}, throughout the file"),
    (STRETCH, "polygon: [[-900, -90], [0, 90], [0, -90], [-900, 90]]", "[[-900",
     "the polygon crosses itself or has no area", "go once around the region"),
    (STRETCH, "polygon: [[[-900, -90], [0, -90], [0, 90]], [[-90, -9], [-9, -9], [-9, 9]]]", "[[[-900",
     "a polygon with a hole", "what lies inside is a region of its own, with a greater `precedence`"),
    (STRETCH, "stretch: {waterway: rivr}", "rivr", "unknown waterway 'rivr'", "did you mean 'river'?"),
    ("to: 4000 m", "to: 9 km", "9 km", "a stretch from 2000 m to 9000 m", ""),
    ("to: 4000 m", "to: 1 km", "1 km", "a stretch from 2000 m to 1000 m", ""),
    ("to: 4000 m", "until: 4000 m", "until", "unknown key 'until'", "known: from, to, waterway"),
    (STRETCH, f"{STRETCH}, {WEST}", "{waterway: river, from", "a region has a polygon or a stretch", ""),
    (f", {STRETCH}", "", "{id: rhine", "a region has a polygon or a stretch", ""),
    ("from: 2 km", "from: 2000", "2000, to", "'2000' has no unit", "if it is in m, write '2000 m'"),
    ("  waterways:", "  hysteresis: {width: -1 m}\n  waterways:", "-1 m", "'-1 m' is out of range", ""),
    ("    speed: 3 m/s\n", "    speed: 3 m/s\n    rulesets: [bpr, ccr]\n", "ccr]", "unknown ruleset 'ccr'",
     "did you mean 'ccnr'?"),
    ("    speed: 3 m/s\n", "    speed: 3 m/s\n    rulesets: [bpr, bpr@1]\n", "bpr@1",
     "ruleset 'bpr' is aboard twice",
     "remove one"),
    ("    speed: 3 m/s\n", "    speed: 3 m/s\n    rulesets: []\n", "[]", "a list of 0",
     "a ship needs a ruleset; without this key it has all"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "pointed", "message", "hint"), FAULTS)
def test_a_fault_is_told_with_its_place_and_a_hint(
    old: str, new: str, pointed: str, message: str, hint: str
) -> None:
    text = changed(old, new)
    found = finding(text)
    at = text.rindex(pointed)

    assert (found.message, found.hint) == (message, hint)
    assert (found.line, found.column) == (text[:at].count("\n") + 1, at - text.rfind("\n", 0, at))


def test_waters_without_regions_need_a_ruleset() -> None:
    found = finding(changed("  ruleset: bpr\n  regions:\n" + RHINE, ""))

    assert (found.message, found.line) == ("the key 'ruleset' is missing here", 5)


def test_a_region_of_a_plugin_in_a_version_that_is_not_installed_is_refused() -> None:
    offered = Region(id="port", ruleset="ccnr@1", polygon=np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]]))
    text = changed(RHINE, "    - port\n")

    with pytest.raises(ScenarioError, match="version 1 of ruleset 'ccnr' is not installed"):
        parse_scenario(text, rulesets=RULESETS, regions={"port": offered})


def test_degrees_are_right_where_the_whole_file_is_in_degrees() -> None:
    text = changed("[[-3000, 0], [0, 0], [3000, 500]]", "[{lonlat: [5.9, 51.8]}, {lonlat: [6.0, 51.8]}]")
    text = text.replace("[-2500, 0]", "{lonlat: [5.91, 51.8]}").replace(
        STRETCH,
        "polygon: [{lonlat: [5.95, 51.7]}, {lonlat: [6.1, 51.7]}, {lonlat: [5.95, 51.9]}]",
    )
    scenario = parse_scenario(text, rulesets=RULESETS)

    assert (law_at(scenario, 2000.0).ruleset, law_at(scenario, 5000.0).ruleset) == ("bpr", "ccnr")
