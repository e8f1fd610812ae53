"""Encounters near a limit: ships that measure disagree, though the ruleset is consistent."""

from __future__ import annotations

import pytest

from ccas_core.proofs.nearness import SensorError, Share, nearness, parsed

from .rulesets import broken, shipped


def test_ships_that_measure_exactly_never_disagree_under_a_consistent_ruleset() -> None:
    found = nearness(shipped("bpr"), SensorError(), count=300)

    assert found.near.hits == found.disagreeing.hits == 0
    assert found.near.of > 100


def test_more_error_means_more_disagreement() -> None:
    fine = nearness(shipped("bpr"), SensorError(position=5.0, course=0.5, speed=0.1), count=600)
    coarse = nearness(shipped("bpr"), SensorError(position=50.0, course=5.0, speed=1.0), count=600)

    assert 0 < fine.near.hits < coarse.near.hits
    assert fine.disagreeing.value < coarse.disagreeing.value
    assert coarse.disagreeing.hits <= coarse.near.hits
    assert sum(count for _, count in coarse.rules) == coarse.disagreeing.hits


def test_a_broken_ruleset_disagrees_without_any_error() -> None:
    assert nearness(broken("both_privileged"), SensorError(), count=600).disagreeing.hits > 0


def test_the_same_seed_gives_the_same_report() -> None:
    error = parsed("20,3,0.3")

    one, two = (nearness(shipped("tran2026"), error, count=200, seed=7).lines() for _ in range(2))

    assert one == two
    assert one[0].startswith("with sensor errors of 20 m, 3 deg and 0.3 m/s")


def test_a_share_of_nothing_says_nothing() -> None:
    assert Share(0, 0).interval == (0.0, 1.0)
    assert Share(0, 100).interval[0] == 0.0
    assert Share(100, 100).interval[1] == pytest.approx(1.0)


@pytest.mark.parametrize("text", ["10", "1,2", "a,b,c", "-1,0,0", "nan,0,0"])
def test_an_error_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"number|convert"):
        parsed(text)
