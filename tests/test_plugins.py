"""The host of plugins: what it loads, what it leaves out, and what it says."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from types import ModuleType, SimpleNamespace
from typing import NoReturn

import pytest

from ccas_core import hookspecs, plugins
from ccas_core.errors import RulesetError
from ccas_core.hookspecs import hookimpl
from ccas_core.priority import EdgeKind, PriorityGraph, settle
from ccas_core.ships import ShipId
from ccas_core.tapd.assign import assign
from ccas_core.tapd.facts import PairFacts
from ccas_core.tapd.ruleset import AbstractRuleset, PairRuleset, Situation
from ccas_core.verdict import Kind, Verdict

from .tapd import A, B, C, head_on, verdict


@dataclass(frozen=True)
class Point:
    """An entry point made by hand."""

    name: str
    plugin: Callable[[], object]
    value: str = "some.module"

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
        return verdict(facts.own.id, facts.other.id, Kind.NONE)


class Failing(Silent):
    """Rules with a fault."""

    def judge(self, facts: PairFacts) -> NoReturn:
        """Raise."""
        raise ZeroDivisionError(f"no speed of {facts.own.id}")


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


def offering(*rulesets: object) -> object:
    """Plugin that offers what it is told to."""

    class Plugin:
        @hookimpl
        def ccas_rulesets(self) -> Iterable[object]:
            return rulesets

    return Plugin()


def point(name: str, *rulesets: object) -> Point:
    return Point(name, lambda: offering(*rulesets))


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


def test_ccas_rulesets_are_collected_by_id_with_their_owner() -> None:
    one, two = Silent("one"), Silent("two")

    found = plugins.load([point("late", two), point("early", one)])

    assert found.rulesets == {"one": one, "two": two}
    assert found.owners == {"one": "early", "two": "late"}
    assert found.loaded == {"early": "some.module", "late": "some.module"}
    assert found.failures == ()


def test_ccas_rulesets_may_be_a_generator() -> None:
    class Plugin:
        @hookimpl
        def ccas_rulesets(self) -> Iterable[AbstractRuleset]:
            yield Silent()

    assert plugins.load([Point("p", Plugin)]).rulesets.keys() == {"silent"}


def test_plugin_may_be_a_module() -> None:
    module = ModuleType("some.module")
    module.ccas_rulesets = hookimpl(lambda: [Silent()])  # type: ignore[attr-defined]

    assert plugins.load([Point("p", lambda: module)]).owners == {"silent": "p"}


def test_plugin_that_offers_nothing_is_loaded_all_the_same() -> None:
    found = plugins.load([Point("empty", SimpleNamespace)])

    assert (found.rulesets, found.failures) == ({}, ())
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


def test_id_that_two_plugins_use_is_refused_to_both() -> None:
    found = plugins.load([point("one", Silent("x"), Silent("y")), point("two", Silent("x"))])

    assert found.rulesets.keys() == {"y"}
    assert causes(found) == [("two", "plugins 'one' and 'two' both define ruleset 'x'")]


def test_misspelt_hook_is_refused_with_the_name_that_was_meant() -> None:
    plugin = SimpleNamespace(ccas_ruleset=lambda: [Silent()])

    found = plugins.load([Point("bad", lambda: plugin)])

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
            return verdict(facts.own.id, C, Kind.GIVE_WAY)

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
