"""`ccas simulate` with plugins aboard: observers are told, and what does not work is told once."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from ccas_core import plugins
from ccas_core.events import OrderDecided
from ccas_core.hookspecs import hookimpl
from ccas_core.tapd.facts import PairFacts
from ccas_core.tapd.ruleset import PairRuleset
from ccas_core.verdict import Verdict

from . import ccas


class _Point:
    """Entry point of a plugin that is made for a test."""

    name = "aboard"
    value = "aboard"

    def __init__(self, **hooks: Callable[..., object]) -> None:
        self.hooks = hooks

    def load(self) -> object:
        return SimpleNamespace(**{name: hookimpl(hook) for name, hook in self.hooks.items()})


class _Failing(PairRuleset):
    """A ruleset that raises."""

    id, version, title = "failing", "1", "for a test"

    def judge(self, facts: PairFacts) -> Verdict:
        raise KeyError(facts.own)


def _aboard(monkeypatch: pytest.MonkeyPatch, **hooks: Callable[..., object]) -> None:
    points = importlib.metadata.entry_points(group=plugins.GROUP)
    found = plugins.load([*points, _Point(**hooks)])
    monkeypatch.setattr(plugins, "load", lambda **_: found)


def _sailed(two_ships: Path, *more: str) -> tuple[int, str]:
    done = ccas("simulate", two_ships, "--json", "--quiet", "--no-pictures", *more)
    return done.exit_code, done.stderr


def test_observers_are_told_of_every_period(two_ships: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[OrderDecided] = []

    def ccas_order_decided(event: OrderDecided) -> None:
        told.append(event)

    _aboard(monkeypatch, ccas_order_decided=ccas_order_decided)

    assert _sailed(two_ships) == (0, "")
    assert [each.time for each in told[:3]] == [0.0, 20.0, 40.0]
    assert told[0].generations == (("ship_1",), ("ship_2",))


def test_observer_that_raises_is_told_of_once(two_ships: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def ccas_order_decided(event: OrderDecided) -> None:
        raise OSError(f"disk full at {event.time}")

    _aboard(monkeypatch, ccas_order_decided=ccas_order_decided)
    code, err = _sailed(two_ships)

    assert code == 0
    assert err.count("warning: ") == 1
    assert "part of plugin 'aboard' does not work: ccas_order_decided" in err
    assert "cause: ccas_order_decided raised OSError: disk full at 0.0" in err


def test_ruleset_that_raises_is_told_of_once_and_the_ships_sail_on(
    two_ships: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _aboard(monkeypatch, ccas_rulesets=lambda: [_Failing()])
    code, err = _sailed(two_ships, "--ruleset", "failing")

    assert code in (0, 1)  # without a rule, ships of this size may touch
    assert err.count("warning: ") == 1
    assert "part of plugin 'aboard' does not work: ruleset 'failing'" in err
    assert "effect: both ships give way by the safe mutual rule" in err
