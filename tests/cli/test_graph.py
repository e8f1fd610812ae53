"""`ccas graph` and `ccas explain`: who decides first, and why."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from . import TWO_SHIPS, ccas

ARTICLE = "Tran et al. 2026 Sec. 3.1, crossing"
HARD_NAME = 'a "b" [red]'


def test_graph_tells_edges_with_their_source(two_ships: Path) -> None:
    done = ccas("graph", two_ships, "--json")

    found = json.loads(done.stdout)
    (edge,) = found["edges"]
    assert (edge["first"], edge["then"], edge["kind"]) == ("ship_1", "ship_2", "duty")
    assert (edge["ruleset"], edge["article"]) == ("tran2026", ARTICLE)
    assert edge["reason"] == "The ship that comes from port gives way"
    assert found["generations"] == [["ship_1"], ["ship_2"]]
    assert (found["cycles"], found["openings"], found["without_edge"]) == ([], [], [])


def test_graph_as_text_says_the_same(two_ships: Path) -> None:
    done = ccas("graph", two_ships)

    assert "ship_1 -> ship_2" in done.stdout
    assert ARTICLE in done.stdout
    assert "order of decision: ship_1, then ship_2" in done.stdout


def test_graph_tells_rings_and_how_they_are_opened() -> None:
    found = json.loads(ccas("graph", "tran2026/fig_14", "--json").stdout)

    assert found["cycles"] == [["ship_1", "ship_2", "ship_3", "ship_4"]]
    (opening,) = found["openings"]
    assert opening["criterion"] == "lightest first"
    assert [each["kind"] for each in found["without_edge"]] == ["mutual", "mutual"]
    text = ccas("graph", "tran2026/fig_14").stdout
    assert "rings of ships that wait for one another: ship_1, ship_2, ship_3, ship_4" in text
    assert "by: lightest first" in text


def test_graph_in_the_language_of_graphviz_keeps_hard_names(two_ships: Path) -> None:
    two_ships.write_text(TWO_SHIPS.replace("id: ship_1", f"id: '{HARD_NAME}'"), encoding="utf-8")

    done = ccas("graph", two_ships, "--format", "dot")

    assert done.stdout.startswith('digraph "two ships cross" {')
    assert '"a \\"b\\" [red]" -> "ship_2"' in done.stdout


SVG = "{http://www.w3.org/2000/svg}"


def drawn(*arguments: object) -> ET.Element:
    done = ccas("graph", *map(str, arguments), "--format", "svg")
    assert done.exit_code == 0
    return ET.fromstring(done.stdout)  # noqa: S314 - our own text


def test_graph_is_drawn_with_a_column_for_each_generation(two_ships: Path) -> None:
    svg = drawn(two_ships)

    texts = [each.text for each in svg.iter(f"{SVG}text")]
    (path,) = (each for each in svg.iter(f"{SVG}path") if "edge" in each.get("class", ""))
    assert texts[:2] == ["ship_1", "ship_2"]
    assert texts[2] == "Sec. 3.1, crossing"
    assert (path.get("class"), path.get("marker-end")) == ("edge duty", "url(#arrow)")
    assert "prefers-color-scheme: dark" in (svg.findtext(f"{SVG}style") or "")


def test_drawing_shows_what_was_left_out_and_where_both_act() -> None:
    kinds = [each.get("class") for each in drawn("tran2026/fig_14").iter(f"{SVG}path") if each.get("class")]

    assert kinds.count("edge duty opened") == 1
    assert kinds.count("edge mutual") == 2
    assert kinds.count("edge duty") == 3


def test_drawing_keeps_hard_names(two_ships: Path) -> None:
    two_ships.write_text(TWO_SHIPS.replace("id: ship_1", "id: '<a> & \"b\"'"), encoding="utf-8")

    assert '<a> & "b"' in [each.text for each in drawn(two_ships).iter(f"{SVG}text")]


def test_hard_names_stay_as_they_are_in_text(two_ships: Path) -> None:
    two_ships.write_text(TWO_SHIPS.replace("id: ship_1", f"id: '{HARD_NAME}'"), encoding="utf-8")

    assert f"{HARD_NAME} -> ship_2" in ccas("graph", two_ships).stdout


def test_ruleset_in_place_of_the_scenario_s_is_used(two_ships: Path) -> None:
    found = json.loads(ccas("graph", two_ships, "--ruleset", "tran2026_printed", "--json").stdout)

    assert {edge["ruleset"] for edge in found["edges"]} == {"tran2026_printed"}


def test_views_that_do_not_fit_are_told_as_the_safe_mutual_rule(two_ships: Path) -> None:
    met = TWO_SHIPS.replace("waterway: river, towards: end", "waterway: canal, towards: start")
    two_ships.write_text(met.replace("[0, -320]", "[200, 0]"), encoding="utf-8")

    explained = ccas("explain", two_ships, "--ruleset", "tran2026_printed").stdout
    (edge,) = json.loads(ccas("graph", two_ships, "--ruleset", "tran2026_printed", "--json").stdout)["edges"]

    why = "ship_1 sees stand_on, ship_2 sees stand_on"
    assert f"both give way by the safe mutual rule, ship_1 decides first, because {why}" in explained
    assert (edge["kind"], edge["reason"]) == ("order", f"safe mutual rule, because {why}")


def test_explanation_holds_both_views_with_article_reason_and_facts(two_ships: Path) -> None:
    (pair,) = json.loads(ccas("explain", two_ships, "--json").stdout)

    views = pair["verdicts"]
    assert pair["pair"] == ["ship_1", "ship_2"]
    assert (views["ship_1"]["kind"], views["ship_2"]["kind"]) == ("give_way", "stand_on")
    assert all(view["rule"] == "crossing.from-starboard" for view in views.values())
    assert all(view["article"] == ARTICLE and view["reason"] and view["facts"] for view in views.values())


def test_explanation_as_text_says_the_same(two_ships: Path) -> None:
    text = ccas("explain", two_ships).stdout

    assert "ship_1 and ship_2: crossing: ship_1 gives way, ship_2 stands on" in text
    assert ARTICLE in text
    assert "because The ship that comes from port gives way" in text
    assert "ship_1.time_to_intersection < 900 s" in text


def test_explanation_of_one_pair_is_of_that_pair() -> None:
    done = ccas("explain", "fig_12", "--pair", "ship_3", "ship_1", "--json")

    assert [each["pair"] for each in json.loads(done.stdout)] == [["ship_1", "ship_3"]]


def test_ships_that_do_not_meet_are_explained_too(two_ships: Path) -> None:
    two_ships.write_text(TWO_SHIPS.replace("[0, -320]", "[0, 100]"), encoding="utf-8")

    assert "ship_1 and ship_2: no encounter" in ccas("explain", two_ships).stdout
    assert "no two ships meet" in ccas("graph", two_ships).stdout


@pytest.mark.parametrize(
    ("pair", "message"),
    [(("ship_1", "ship_9"), "did you mean 'ship_"), (("ship_1", "ship_1"), "expected: two ships")],
)
def test_pair_that_cannot_be_is_refused(pair: tuple[str, str], message: str, two_ships: Path) -> None:
    done = ccas("explain", two_ships, "--pair", *pair)

    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith("--pair: ")
    assert message in done.stderr
