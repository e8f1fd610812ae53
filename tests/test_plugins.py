"""The host of plugins: its hooks, what it loads, what it leaves out, and what it says."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import NoReturn

import numpy as np
import pytest

import ccas_rulesets
from ccas_core import hookspecs, plugins
from ccas_core.controllers import AbstractController, Outlook, Steering
from ccas_core.errors import RulesetError
from ccas_core.events import DeadlockDetected, OrderDecided, RulesetSwitched
from ccas_core.hookspecs import PluginInfo, hookimpl
from ccas_core.plugin_failures import Failure
from ccas_core.priority import Edge, EdgeKind, Opening, PriorityGraph, settle
from ccas_core.quantities import LENGTH
from ccas_core.regions import Region
from ccas_core.ships import UNKNOWN, FactValue, Ship, ShipId
from ccas_core.tapd.assign import assign
from ccas_core.tapd.case_run import judge_case
from ccas_core.tapd.cases import Case, CaseShip
from ccas_core.tapd.facts import PairFacts
from ccas_core.tapd.python_rules import PairView, PythonRule, RoleDecision
from ccas_core.tapd.ranking import RankingCriterion
from ccas_core.tapd.ruleset import AbstractRuleset, PairRuleset, Situation
from ccas_core.tapd.vocabulary import Fact, Scope, Source
from ccas_core.tapd.vocabulary import Kind as FactKind
from ccas_core.verdict import Kind, Verdict
from ccas_core.waterway import Waters
from ccas_core.world import ShipReport

from .tapd import A, B, C, head_on, verdict


@dataclass(frozen=True)
class Point:
    """An entry point made by hand."""

    name: str
    plugin: Callable[[], object]
    value: str = "some.module"
    dist: object = None

    def load(self) -> object:
        """Give what it points at, or raise."""
        return self.plugin()


class Silent(PairRuleset):
    """Rules that say nothing about anybody."""

    version = "1"
    title = "nothing"

    def __init__(self, id_: str = "silent") -> None:
        self.id = id_

    def judge(self, facts: PairFacts) -> Verdict:
        """Say that there is nothing."""
        return verdict(facts.own, facts.other, Kind.NONE)


class Failing(Silent):
    """Rules with a fault."""

    def judge(self, facts: PairFacts) -> NoReturn:
        """Raise."""
        raise ZeroDivisionError(f"no speed of {facts.own}")


class Centre(AbstractRuleset):
    """A traffic centre: it gives the whole order at once, the greatest id first."""

    id = "centre"
    version = "1"
    title = "traffic centre"

    def emit(self, situation: Situation) -> PriorityGraph:
        """Give the order."""
        ships = sorted(situation.world.reports)
        masses = dict.fromkeys(ships, 1.0)
        pairs = pairwise(ships)
        ordered = (
            settle(verdict(a, b, Kind.STAND_ON), verdict(b, a, Kind.GIVE_WAY), masses) for a, b in pairs
        )
        return PriorityGraph(masses=masses, settlements=tuple(ordered))


def plugin(**offers: Iterable[object]) -> object:
    """Plugin that offers what it is told to: ccas_facts=[…]."""
    return SimpleNamespace(**{hook: hookimpl(lambda found=found: found) for hook, found in offers.items()})


def point(name: str, *rulesets: object) -> Point:
    return Point(name, lambda: plugin(ccas_rulesets=rulesets))


def package(name: str, version: str = "1.2") -> object:
    """Distribution that an entry point comes from."""
    return SimpleNamespace(name=name, version=version)


def flag(name: str, compute: Callable[..., FactValue] | None = None) -> Fact:
    """Fact of a ship that is true or false."""
    return Fact(
        name=name,
        scope=Scope.SHIP,
        kind=FactKind.FLAG,
        meaning="for a test",
        source=Source.MESSAGE,
        default=False,
        compute=compute,
    )


def ruleset_file(folder: Path, *rules: str, id_: str = "x", more: str = "") -> Path:
    """Write a ruleset file with rules in flow style."""
    path = folder / f"{id_}.yaml"
    lines = "".join(f"  - {{{rule}, cite: {{article: '1'}}}}\n" for rule in rules)
    path.write_text(FILE.format(id=id_, rules=lines, more=more), encoding="utf-8")
    return path


FILE = """\
schema: ccas/ruleset@1
id: {id}
version: 1.0.0
title: for a test
extends: common
regulation: {{name: R, version: "1"}}
{more}rules:
{rules}otherwise: {{cite: {{article: '0'}}}}
"""


def with_common(*points: Point) -> plugins.Plugins:
    """Load plugins beside the file that others extend."""
    common = Path(ccas_rulesets.__file__).with_name("common.yaml")
    return plugins.load([point("common", common), *points])


def broken() -> NoReturn:
    raise ImportError("No module named 'fancy'")


def causes(found: plugins.Plugins) -> list[tuple[str, str]]:
    return [(failure.plugin, failure.cause) for failure in found.failures]


# --- the hooks ------------------------------------------------------------------------------------


def test_every_hook_has_a_test_that_is_named_after_it() -> None:
    hooks = [name for name in vars(hookspecs) if name.startswith("ccas_")]
    tests = [name for name in globals() if name.startswith("test_")]

    assert hooks
    for hook in hooks:
        assert any(name.startswith(f"test_{hook}") for name in tests), hook


def test_every_hook_says_in_one_sentence_what_it_is_for() -> None:
    for name, hook in vars(hookspecs).items():
        if name.startswith("ccas_"):
            assert (hook.__doc__ or "").strip().endswith(".")


def examples() -> dict[str, str]:
    """Code under each heading of the guide."""
    text = (Path(__file__).parents[1] / "docs" / "plugins.md").read_text(encoding="utf-8")
    parts = re.findall(r"^## (\w+)$(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    return {
        heading: "\n".join(re.findall(r"```python\n(.*?)```", part, re.DOTALL)) for heading, part in parts
    }


def test_every_hook_has_a_heading_in_the_guide_and_no_other_hook_is_there() -> None:
    hooks = {name for name in vars(hookspecs) if name.startswith("ccas_")}

    assert {heading for heading in examples() if heading.startswith("ccas_")} == hooks


@pytest.mark.parametrize("hook", [name for name in vars(hookspecs) if name.startswith("ccas_")])
def test_example_of_the_guide_is_a_plugin_that_works(hook: str) -> None:
    def module() -> ModuleType:
        made = ModuleType("example")
        exec(examples()[hook], made.__dict__)  # noqa: S102 - our own page
        return made

    found = plugins.load([Point("example", module)])

    assert found.failures == ()
    assert found.hooks["example"] == (hook,)
    for event in (ORDER, SWITCH, RING):
        assert list(found.observers().tell(event)) == []


def test_ccas_plugin_info_says_what_the_plugin_is() -> None:
    info = PluginInfo(name="harbour rules", version="2.0", homepage="here")

    found = plugins.load([Point("p", lambda: SimpleNamespace(ccas_plugin_info=hookimpl(lambda: info)))])

    assert found.infos == {"p": info}
    assert found.hooks == {"p": ("ccas_plugin_info",)}


def test_ccas_facts_are_added_to_the_vocabulary_of_all_rulesets(tmp_path: Path) -> None:
    file = ruleset_file(tmp_path, "id: tug, when: risk and not own.tug and other.tug, then: give_way")

    found = with_common(Point("p", lambda: plugin(ccas_facts=[flag("tug")])), point("q", file))
    (mine,) = assign(found.ruleset("x"), head_on().situation(), A)

    assert found.facts == {"tug": "p"}
    assert found.vocabulary.find(Scope.SHIP, "tug") is not None
    assert mine.kind is Kind.NONE


def test_ccas_facts_may_be_computed_from_reports_and_waters(tmp_path: Path) -> None:
    def leads(report: ShipReport, waters: Waters) -> bool:
        return report.id == A and len(waters.waterways) == 2

    file = ruleset_file(tmp_path, "id: tug, when: not own.leads and other.leads, then: give_way")
    found = with_common(Point("p", lambda: plugin(ccas_facts=[flag("leads", leads)])), point("q", file))

    (mine,) = assign(found.ruleset("x"), head_on().situation(), B)

    assert (mine.kind, mine.give_way) == (Kind.GIVE_WAY, (B,))


def test_ccas_rulesets_are_collected_by_id_with_their_owner() -> None:
    one, two = Silent("one"), Silent("two")

    found = plugins.load([point("late", two), point("early", one)])

    assert found.rulesets == {"one": one, "two": two}
    assert found.owners == {"one": "early", "two": "late"}
    assert found.loaded == {"early": "some.module", "late": "some.module"}
    assert found.failures == ()


def test_ccas_rulesets_may_be_paths_of_files(tmp_path: Path) -> None:
    file = ruleset_file(tmp_path, "id: all, when: risk, then: mutual, pass: port_to_port")

    found = with_common(point("p", file))

    assert found.owners == {"x": "p"}
    assert found.ruleset("x").title == "for a test"
    assert found.offers["p"]["ccas_rulesets"] == ("x",)


def test_ccas_rulesets_may_be_a_generator() -> None:
    class Plugin:
        @hookimpl
        def ccas_rulesets(self) -> Iterable[AbstractRuleset]:
            yield Silent()

    assert plugins.load([Point("p", Plugin)]).rulesets.keys() == {"silent"}


def test_ccas_pair_rules_are_asked_for_by_ruleset_files_and_from_both_sides(tmp_path: Path) -> None:
    def longer(pair: PairView) -> RoleDecision | None:
        return RoleDecision("give_way", because="by id") if pair.own.length <= 100 else None

    file = ruleset_file(tmp_path, "id: ids, when: risk, python: longer")
    found = with_common(
        Point("p", lambda: plugin(ccas_pair_rules=[PythonRule("longer", longer)])), point("q", file)
    )
    (mine,) = assign(found.ruleset("x"), head_on().situation(), A)

    assert (mine.kind, mine.reason, mine.rule) == (Kind.GIVE_WAY, "by id", "ids")
    assert found.pair_rules["longer"].plugin == "p"


def test_ccas_criteria_decide_who_goes_first_in_a_ring(tmp_path: Path) -> None:
    def letters(ship: Ship) -> float:
        return -ord(ship.id[-1])

    more = "deadlock: {resolve_by: [letters, id]}\n"
    file = ruleset_file(tmp_path, "id: all, when: risk, then: mutual", more=more)
    criterion = RankingCriterion("letters", letters, "the last letter, backwards")

    found = with_common(Point("p", lambda: plugin(ccas_criteria=[criterion])), point("q", file))

    assert found.ruleset("x").rank(head_on().own.ship) == (-ord("a"),)
    assert found.ruleset("x").criterion == "by letters, id"


def test_ccas_regions_are_collected_by_id() -> None:
    found = plugins.load([Point("p", lambda: plugin(ccas_regions=[REGION]))])

    assert found.regions == {"basin": REGION}


def test_ccas_controllers_are_collected_by_name() -> None:
    waiting = Waiting()

    found = plugins.load([Point("p", lambda: plugin(ccas_controllers=[waiting]))])

    assert found.controllers == {"waiting": waiting}
    assert found.offers["p"]["ccas_controllers"] == ("waiting",)


@pytest.mark.parametrize("name", ["tracked", "cooperative", "two words", "", None])
def test_controller_with_a_name_that_no_scenario_could_say_is_refused(name: object) -> None:
    waiting = Waiting()
    waiting.name = name  # type: ignore[assignment]

    found = plugins.load([Point("p", lambda: plugin(ccas_controllers=[waiting]))])

    assert found.controllers == {}
    assert "name of Waiting must be a word" in found.failures[0].cause


class Waiting(AbstractController):
    """A controller that does nothing."""

    name = "waiting"

    def steer(self, outlook: Outlook, memory: object) -> Steering:
        """Do nothing."""
        raise NotImplementedError


REGION = Region(id="basin", ruleset="bpr", polygon=np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]]))
ORDER = OrderDecided(time=20.0, generations=((A,), (B,)))
SWITCH = RulesetSwitched(time=20.0, ship=A, before="bpr", after="ccnr")
RING = DeadlockDetected(time=20.0, openings=(Opening(Edge(A, B, EdgeKind.DUTY), "lightest first"),))


class Observer:
    """Plugin that writes down what it is told."""

    def __init__(self) -> None:
        self.told: list[object] = []

    @hookimpl
    def ccas_order_decided(self, event: OrderDecided) -> None:
        """Note it."""
        self.told.append(event)

    @hookimpl
    def ccas_ruleset_switched(self, event: RulesetSwitched) -> None:
        """Note it."""
        self.told.append(event)

    @hookimpl
    def ccas_deadlock_detected(self, event: DeadlockDetected) -> None:
        """Note it."""
        self.told.append(event)


def observed(event: OrderDecided | RulesetSwitched | DeadlockDetected) -> list[object]:
    observer = Observer()
    observers = plugins.load([Point("p", lambda: observer), Point("q", SimpleNamespace)]).observers()
    assert list(observers.tell(event)) == []
    return observer.told


def test_ccas_order_decided_is_told_who_decided_when() -> None:
    assert observed(ORDER) == [ORDER]


def test_ccas_ruleset_switched_is_told_from_where_to_where() -> None:
    assert observed(SWITCH) == [SWITCH]


def test_ccas_deadlock_detected_is_told_how_it_was_opened() -> None:
    assert observed(RING) == [RING]


def test_plugin_may_be_a_module() -> None:
    module = ModuleType("some.module")
    module.ccas_rulesets = hookimpl(lambda: [Silent()])  # type: ignore[attr-defined]

    assert plugins.load([Point("p", lambda: module)]).owners == {"silent": "p"}


def test_plugin_that_offers_nothing_is_loaded_all_the_same() -> None:
    found = plugins.load([Point("empty", SimpleNamespace)])

    assert (len(found.rulesets), found.failures) == (0, ())
    assert "empty" in found.loaded


# --- what is left out -----------------------------------------------------------------------------


def test_plugin_that_cannot_be_imported_is_left_out_and_the_others_work() -> None:
    found = plugins.load([Point("bad", broken), point("good", Silent())])

    assert causes(found) == [("bad", "ImportError: No module named 'fancy'")]
    assert found.loaded.keys() == {"good"}
    assert found.ruleset("silent").id == "silent"


def test_failure_names_the_plugin_its_module_the_cause_the_effect_and_a_hint(
    capsys: pytest.CaptureFixture[str],
) -> None:
    plugins.warn(plugins.load([Point("bad", broken, "harbour.rules")]).failures)
    out, err = capsys.readouterr()

    assert out == ""
    assert "'bad' (harbour.rules)" in err
    for label in ("cause: ImportError", "effect: ", "hint: "):
        assert label in err


def test_failure_names_the_package_and_keeps_the_traceback() -> None:
    (failure,) = plugins.load([Point("bad", broken, dist=package("bad-rules"))]).failures

    assert failure.package == "bad-rules 1.2"
    assert "    package: bad-rules 1.2\n" in str(failure)
    assert "ccas plugins --debug bad" in failure.hint
    assert "in broken" in failure.trace


def test_plugin_that_ends_the_program_at_import_does_not() -> None:
    def leave() -> NoReturn:
        raise SystemExit(3)

    assert causes(plugins.load([Point("bad", leave), point("good", Silent())])) == [("bad", "SystemExit: 3")]


def test_plugin_for_another_version_of_the_hooks_is_told_so_whatever_else_is_wrong() -> None:
    info = PluginInfo(name="p", version="1", api=2)
    newer = SimpleNamespace(ccas_plugin_info=hookimpl(lambda: info), ccas_weather=hookimpl(lambda: ()))

    found = plugins.load([Point("bad", lambda: newer)])

    assert found.loaded == {}
    assert found.failures[0].cause.endswith(
        "it was written for version 2 of the hooks, and this is version 1"
    )


def test_plugin_whose_info_is_something_else_is_left_out() -> None:
    odd = SimpleNamespace(ccas_plugin_info=hookimpl(lambda: "me"))

    (failure,) = plugins.load([Point("bad", lambda: odd)]).failures
    assert "ccas_plugin_info must return a PluginInfo, got str" in failure.cause


def test_hook_that_is_not_marked_is_refused_for_it_would_never_be_called() -> None:
    unmarked = SimpleNamespace(ccas_rulesets=lambda: [Silent()])

    (failure,) = plugins.load([Point("bad", lambda: unmarked)]).failures

    assert failure.cause == "TypeError: ccas_rulesets would never be called: write @hookimpl above it"


def test_plugin_name_that_two_packages_use_is_refused_to_both() -> None:
    one, two = (
        Point("x", lambda: plugin(ccas_rulesets=[Silent()]), f"m{n}", package(f"p{n}")) for n in (1, 2)
    )

    found = plugins.load([two, one, point("good", Silent("good"))])

    assert found.rulesets.keys() == {"good"}
    assert causes(found) == [("x", "p1 1.2 and p2 1.2 both define a plugin 'x'")]


@pytest.mark.parametrize(
    ("hook", "offer", "what"),
    [
        ("ccas_pair_rules", PythonRule("same", lambda _: None), "rule in Python 'same'"),
        ("ccas_criteria", RankingCriterion("same", lambda _: 0.0), "criterion 'same'"),
        ("ccas_regions", REGION, "region 'basin'"),
        ("ccas_controllers", Waiting(), "controller 'waiting'"),
    ],
)
def test_name_that_two_plugins_use_is_refused_to_both(hook: str, offer: object, what: str) -> None:
    points = [Point(name, lambda: plugin(**{hook: [offer]})) for name in ("one", "two")]

    found = plugins.load(points)

    assert causes(found) == [("two", f"plugins 'one' and 'two' both define {what}")]
    assert not found.failures[0].whole
    assert found.loaded.keys() == {"one", "two"}
    for offers in (found.pair_rules, found.criteria, found.regions):
        assert not offers


@pytest.mark.parametrize("name", ["length", "tug"])
def test_fact_whose_name_is_taken_leaves_its_plugin_out(name: str) -> None:
    first = Point("a", lambda: plugin(ccas_facts=[flag("tug")]))

    found = plugins.load([first, Point("b", lambda: plugin(ccas_facts=[flag(name)]))])

    assert causes(found) == [("b", f"ValueError: there is a fact '{name}' of a ship already")]
    assert found.loaded.keys() == {"a"}


@pytest.mark.parametrize(
    "hook",
    ["ccas_facts", "ccas_pair_rules", "ccas_criteria", "ccas_regions", "ccas_controllers", "ccas_rulesets"],
)
def test_hook_that_returns_another_type_leaves_its_plugin_out(hook: str) -> None:
    found = plugins.load([Point("bad", lambda: plugin(**{hook: [7]})), point("good", Silent())])

    assert found.rulesets.keys() == {"silent"}
    assert found.failures[0].cause.startswith(f"TypeError: {hook} must return ")
    assert found.failures[0].cause.endswith("got int")


def test_file_that_cannot_be_read_is_left_out_and_the_rest_of_its_plugin_works(tmp_path: Path) -> None:
    found = plugins.load([point("p", tmp_path / "none.yaml", Silent())])

    assert found.rulesets.keys() == {"silent"}
    assert found.failures[0].target == str(tmp_path / "none.yaml")
    assert str(found.failures[0]).startswith("warning: part of plugin 'p' does not work: ")


def test_file_with_a_fault_makes_its_own_ruleset_unavailable_and_no_other(tmp_path: Path) -> None:
    file = ruleset_file(tmp_path, "id: all, when: rsk, then: mutual")

    found = with_common(point("p", file), point("good", Silent()))

    with pytest.raises(RulesetError, match="did you mean 'risk'"):
        found.ruleset("x")
    assert found.ruleset("silent").id == "silent"


def test_only_plugins_that_are_named_are_imported() -> None:
    ours = Point("ours", lambda: plugin(ccas_rulesets=[Silent("ours")]), dist=package("ccas"))

    found = plugins.load([Point("bad", broken), point("good", Silent()), ours], only=["good"])

    assert found.loaded.keys() == {"good", "ours"}
    assert found.failures == ()


def test_id_that_two_plugins_use_is_refused_to_both() -> None:
    found = plugins.load([point("one", Silent("x"), Silent("y")), point("two", Silent("x"))])

    assert found.rulesets.keys() == {"y"}
    assert causes(found) == [("two", "plugins 'one' and 'two' both define ruleset 'x'")]


def test_misspelt_hook_is_refused_with_the_name_that_was_meant() -> None:
    misspelt = SimpleNamespace(ccas_ruleset=lambda: [Silent()])

    found = plugins.load([Point("bad", lambda: misspelt)])

    assert found.loaded == {}
    assert "unknown hook 'ccas_ruleset'; did you mean 'ccas_rulesets'?" in found.failures[0].cause


def test_hook_that_asks_for_an_unknown_argument_is_refused() -> None:
    class Plugin:
        @hookimpl
        def ccas_rulesets(self, weather: str) -> Iterable[AbstractRuleset]:
            return [Silent(weather)]

    assert "weather" in plugins.load([Point("bad", Plugin)]).failures[0].cause


@pytest.mark.parametrize("offered", [Silent, "bpr", 3, None])
def test_what_is_not_a_ruleset_is_refused(offered: object) -> None:
    found = plugins.load([point("bad", Silent(), offered), point("good", Silent("good"))])

    assert found.rulesets.keys() == {"good"}
    assert "ccas_rulesets must return rulesets, got" in found.failures[0].cause


def test_hook_that_raises_leaves_the_plugin_out() -> None:
    class Plugin:
        @hookimpl
        def ccas_rulesets(self) -> Iterable[AbstractRuleset]:
            raise RuntimeError("the file is gone")

    found = plugins.load([Point("bad", Plugin)])

    assert causes(found) == [("bad", "RuntimeError: the file is gone")]
    assert found.loaded == {}


@pytest.mark.parametrize("id_", [..., None])
def test_ruleset_without_a_proper_id_is_left_out_and_the_others_work(id_: object) -> None:
    nameless = Silent()
    if id_ is ...:
        del nameless.id
    else:
        nameless.id = id_  # type: ignore[assignment]

    found = plugins.load([point("bad", nameless), point("good", Silent("good"))])

    assert found.rulesets.keys() == {"good"}
    assert [failure.plugin for failure in found.failures] == ["bad"]


def test_hook_that_returns_nothing_at_all_is_reported() -> None:
    class Plugin:
        @hookimpl
        def ccas_rulesets(self) -> None:
            [Silent()]

    assert plugins.load([Point("bad", Plugin)]).failures


# --- asking for a ruleset -------------------------------------------------------------------------


def test_unknown_ruleset_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(RulesetError, match="unknown ruleset 'silnt'") as caught:
        plugins.load([point("p", Silent())]).ruleset("silnt")

    assert caught.value.diagnostics[0].hint == "did you mean 'silent'?"


def test_unknown_ruleset_is_refused_with_a_word_about_plugins_that_are_missing() -> None:
    with pytest.raises(RulesetError, match=r"1 plugin\(s\) could not be loaded, see `ccas plugins`"):
        plugins.load([Point("bad", broken), point("p", Silent())]).ruleset("bpr")


def test_what_was_found_cannot_be_changed() -> None:
    found = plugins.load([point("p", Silent())])

    for mapping in (found.rulesets, found.owners, found.loaded):
        with pytest.raises(TypeError):
            mapping["x"] = Silent("x")  # type: ignore[index]


# --- plugins that fail at work --------------------------------------------------------------------


def judged_by(decide: Callable[[PairView], object], folder: Path) -> tuple[Verdict, list[Failure]]:
    """Verdict of a ruleset with one rule in Python, and what was told of it."""
    file = ruleset_file(folder, "id: odd, when: risk, python: odd")
    rule = PythonRule("odd", decide)  # type: ignore[arg-type]
    owner = Point(
        "p", lambda: plugin(ccas_pair_rules=[rule], ccas_rulesets=[file]), dist=package("odd-rules")
    )
    found = with_common(owner)
    situation = head_on().situation()
    for _ in range(2):
        (mine,) = assign(found.ruleset("x"), situation, A)
        (theirs,) = assign(found.ruleset("x"), situation, B)
    assert settle(mine, theirs, {A: 1.0, B: 2.0}).fallback
    return mine, list(found.troubles.fresh())


def test_rule_that_raises_while_judging_gives_a_conflict_and_is_told_once(tmp_path: Path) -> None:
    mine, (failure,) = judged_by(lambda _: 1 // 0, tmp_path)

    assert mine.kind is Kind.CONFLICT
    assert mine.reason.startswith("rule 'odd' failed (plugin 'p', package odd-rules 1.2): ZeroDivisionError")
    assert (failure.plugin, failure.package, failure.target) == ("p", "odd-rules 1.2", "rule 'odd'")
    assert failure.cause.startswith("ZeroDivisionError")
    assert "both ships give way" in failure.effect


@pytest.mark.parametrize("answer", [7, "giveway", RoleDecision("give_way", strength="a bit")])
def test_rule_that_answers_with_no_decision_gives_a_conflict(answer: object, tmp_path: Path) -> None:
    mine, (failure,) = judged_by(lambda _: answer, tmp_path)

    assert mine.kind is Kind.CONFLICT
    assert failure.cause.startswith(("TypeError", "ValueError"))


def test_rule_that_asks_for_a_fact_that_there_is_not_is_told_so(tmp_path: Path) -> None:
    mine, (failure,) = judged_by(lambda pair: pair.own.lenght > 3, tmp_path)

    assert mine.kind is Kind.CONFLICT
    assert "there is no fact 'own.lenght'" in failure.cause


def test_rule_that_asks_for_a_fact_that_nobody_knows_gives_unknown_fact(tmp_path: Path) -> None:
    mine, told = judged_by(lambda pair: "give_way" if pair.own.draught > 3 else None, tmp_path)

    assert mine.kind is Kind.UNKNOWN_FACT
    assert told == []


@pytest.mark.parametrize("answer", ["raise", 7, "yes"])
def test_fact_that_cannot_be_computed_is_unknown_and_costs_no_other_ruleset_anything(
    answer: object, tmp_path: Path
) -> None:
    def compute(report: ShipReport, waters: Waters) -> FactValue:
        if answer == "raise":
            raise KeyError(report.id)
        return answer  # type: ignore[return-value]

    file = ruleset_file(tmp_path, "id: odd, when: risk and own.odd, then: give_way")
    found = with_common(
        Point("p", lambda: plugin(ccas_facts=[flag("odd", compute)], ccas_rulesets=[file])),
        point("q", ruleset_file(tmp_path, "id: all, when: risk, then: mutual", id_="y")),
    )
    situation = head_on().situation()

    assert assign(found.ruleset("x"), situation, A)[0].kind is Kind.UNKNOWN_FACT
    assert assign(found.ruleset("y"), situation, A)[0].kind is Kind.MUTUAL
    assert [each.effect for each in found.troubles.fresh()] == ["the fact is unknown"]
    assert list(found.troubles.fresh()) == []


def test_fact_may_be_computed_as_unknown() -> None:
    found = plugins.load([Point("p", lambda: plugin(ccas_facts=[flag("odd", lambda *_: UNKNOWN)]))])

    found.vocabulary.by_scope[Scope.SHIP][-1].compute(None, None)  # type: ignore[misc]
    assert list(found.troubles.fresh()) == []


@pytest.mark.parametrize("answer", ["raise", "heavy", float("nan")])
def test_criterion_that_fails_tells_no_ships_apart(answer: object) -> None:
    def value(ship: Ship) -> float:
        if answer == "raise":
            raise KeyError(ship.id)
        return answer  # type: ignore[return-value]

    found = plugins.load([Point("p", lambda: plugin(ccas_criteria=[RankingCriterion("odd", value)]))])

    assert found.criteria["odd"].value(head_on().own.ship) == 0.0
    assert [each.target for each in found.troubles.fresh()] == ["criterion 'odd'"]


def test_observer_that_raises_is_told_of_once_and_the_others_are_told_all() -> None:
    class Bad(Observer):
        @hookimpl
        def ccas_order_decided(self, event: OrderDecided) -> None:
            raise OSError("disk full")

    good, bad = Observer(), Bad()
    points = [Point("bad", lambda: bad, dist=package("bad-eyes")), Point("good", lambda: good)]
    observers = plugins.load(points).observers()

    (failure,) = observers.tell(ORDER)

    assert failure.cause == "ccas_order_decided raised OSError: disk full"
    assert (failure.package, failure.whole) == ("bad-eyes 1.2", False)
    assert "the voyage goes on" in failure.effect
    assert list(observers.tell(ORDER)) == []
    assert list(observers.tell(SWITCH)) == []
    assert good.told == [ORDER, ORDER, SWITCH]
    assert bad.told == [SWITCH]


def test_fact_of_a_quantity_is_named_with_its_unit_in_encounter_files() -> None:
    fact = Fact(
        name="air_draught",
        scope=Scope.SHIP,
        kind=FactKind.NUMBER,
        meaning="height above water",
        source=Source.AIS,
        quantity=LENGTH,
    )
    found = plugins.load([Point("p", lambda: plugin(ccas_facts=[fact]))])

    assert found.vocabulary.by_scope[Scope.SHIP][-1].key == "air_draught_m"


# --- tracing --------------------------------------------------------------------------------------


def test_trace_has_a_line_for_every_call_that_says_who_answered_what() -> None:
    lines: list[str] = []

    plugins.load([point("b", Silent("x"), Silent("y")), point("a"), Point("bad", broken)], lines.append)

    assert lines == ["a: ccas_rulesets -> nothing", "b: ccas_rulesets -> x, y"]


# --- the rulesets that we ship --------------------------------------------------------------------


def test_shipped_rulesets_come_in_through_the_entry_point() -> None:
    found = plugins.load()

    assert {"tran2026", "tran2026_printed"} <= found.rulesets.keys()
    assert found.owners["tran2026"] == "rulesets"
    assert found.loaded["rulesets"] == "ccas_rulesets"


def test_every_ruleset_that_is_found_has_an_id_a_version_and_a_title() -> None:
    for id_, ruleset in plugins.load().rulesets.items():
        assert ruleset.id == id_
        assert ruleset.version
        assert ruleset.title


# --- what a ruleset may do ------------------------------------------------------------------------


def test_ruleset_that_raises_gives_a_conflict_and_so_the_safe_mutual_rule() -> None:
    (mine,) = assign(Failing(), head_on().situation(), A)
    (theirs,) = assign(Failing(), head_on().situation(), B)

    settlement = settle(mine, theirs, {A: 1.0, B: 2.0})

    assert mine.kind is Kind.CONFLICT
    assert mine.reason == "the ruleset failed: ZeroDivisionError: no speed of a"
    assert settlement.mutual
    assert "ZeroDivisionError" in settlement.fallback


def test_ruleset_that_raises_gives_a_conflict_for_cases_too() -> None:
    case = Case(id="c", ships=(CaseShip(id=A, facts={}), CaseShip(id=B, facts={})))

    judged = judge_case(Failing(), case)

    assert judged.pair.one.reason == "the ruleset failed: ZeroDivisionError: no speed of a"


def test_ruleset_that_answers_something_else_than_a_verdict_gives_a_conflict() -> None:
    class Chatty(Silent):
        def view(self, situation: Situation, own: ShipId, other: ShipId) -> Verdict | None:
            return "after you"  # type: ignore[return-value]

    (mine,) = assign(Chatty(), head_on().situation(), A)

    assert (mine.kind, mine.reason) == (
        Kind.CONFLICT,
        "the ruleset failed: TypeError: expected a Verdict, got str",
    )


def test_ruleset_that_answers_about_another_pair_gives_a_conflict() -> None:
    class Confused(Silent):
        def judge(self, facts: PairFacts) -> Verdict:
            return verdict(facts.own, C, Kind.GIVE_WAY)

    (mine,) = assign(Confused(), head_on().situation(), A)

    assert (mine.own, mine.other, mine.kind) == (A, B, Kind.CONFLICT)


def test_ruleset_may_emit_a_whole_graph_and_both_views_are_read_from_it() -> None:
    (mine,) = assign(Centre(), head_on().situation(), A)
    (theirs,) = assign(Centre(), head_on().situation(), B)

    assert (mine.own, mine.other, mine.kind) == (A, B, Kind.STAND_ON)
    assert (theirs.own, theirs.other, theirs.kind) == (B, A, Kind.GIVE_WAY)
    edge = settle(mine, theirs, {A: 1.0, B: 1.0}).edge
    assert edge is not None
    assert (edge.first, edge.then, edge.kind) == (B, A, EdgeKind.DUTY)


def test_graph_that_says_nothing_of_a_pair_gives_no_rule() -> None:
    class Mute(Centre):
        def emit(self, situation: Situation) -> PriorityGraph:
            return PriorityGraph(masses=dict.fromkeys(situation.world.reports, 1.0))

    (mine,) = assign(Mute(), head_on().situation(), A)

    assert (mine.kind, mine.reason, mine.ruleset) == (Kind.NONE, "no_rule", "centre")


def test_pair_rules_emit_the_graph_of_their_verdicts() -> None:
    found = plugins.load().ruleset("tran2026")

    graph = found.emit(head_on(True, False).situation())

    assert graph.generations() == ((B,), (A,))
    assert [settlement.pair for settlement in graph.settlements] == [(A, B)]
    assert Silent().emit(head_on().situation()).settlements == ()
