"""What a sweep came to: counts by cell and ruleset, confidence bounds, worst cases."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final

from .case import Case, geometry
from .mixed import rows
from .workers import Status

CONFIDENCE: Final = 0.95
FREE_OF_COST: Final = 1e-3  # a joint optimum below is no measure for what was sailed
_MARKS: Final = ("collisions", "groundings", "frozen", "entries")  # worst first


@dataclass(frozen=True, slots=True)
class Result:
    """A case, what became of it, and what was kept of it or said by it."""

    case: Case
    status: Status
    kept: dict[str, Any]


def cell_entries(results: Iterable[Result]) -> list[dict[str, Any]]:
    """Count by cell, ruleset and variant: the entries `cells` of `summary.json` (contract)."""
    groups: dict[tuple[str, str, str], list[Result]] = {}
    for each in results:
        key = each.case.cell.name, each.case.under, each.case.variant.name
        groups.setdefault(key, []).append(each)
    return [_entry(group) for group in groups.values()]


def _entry(group: Sequence[Result]) -> dict[str, Any]:
    first = group[0].case
    done = [each.kept for each in group if each.status is Status.DONE]
    encounters = [met for kept in done for met in kept["encounters"]]
    judged = [met for met in encounters if met["faithful"] is not None]
    calm = [kept for kept in done if kept["calm"]]
    avoidable = [kept for kept in done if kept["avoidable"]]
    delays = [delay for kept in done for delay in _delays(kept)]
    stand_on = [share for kept in done for share in _stand_on_delays(kept)]
    changes = [max(kept["changes_of_mind"].values(), default=0) for kept in done]
    indices = [kept["min_safety_index_m"] for kept in done if kept["min_safety_index_m"] is not None]
    return {
        "name": first.cell.name,
        "ruleset": first.under,
        "variant": first.variant.name,
        "geometry": geometry(first.cell),
        "n": len(group),
        "done": len(done),
        "risky": sum(met["risky"] for met in encounters),
        "judged": len(judged),
        "faithful": sum(met["faithful"] for met in judged),
        "kinds": dict(sorted(Counter(met["kind"] for met in encounters).items())),
        "calm": len(calm),
        "calm_acted": sum(bool(kept["acted"]) for kept in calm),
        **{mark: sum(kept[mark] for kept in done) for mark in _MARKS},
        "avoidable": len(avoidable),
        "avoidable_collisions": sum(kept["collisions"] for kept in avoidable),
        "collision_rate_upper": upper_bound(sum(kept["collisions"] > 0 for kept in done), len(done)),
        "min_safety_index_m": min(indices, default=None),
        "mean_delay_s": _mean(delays),
        "mean_stand_on_delay_share": _mean(stand_on),
        "most_changes_of_mind": max(changes, default=0),
        "restless": sum(len(kept["restless"]) for kept in done),
        "mean_actions": _mean([float(n) for kept in done for n in kept["actions"].values()]),
        "laws": _laws(done),
    }


def _laws(done: Sequence[dict[str, Any]]) -> dict[str, int] | None:
    """Sums of what the logs say of laws; None where no case had a border."""
    logs = [kept["laws"] for kept in done if kept["laws"]]
    return {key: sum(log[key] for log in logs) for key in logs[0]} if logs else None


def _delays(kept: dict[str, Any]) -> Iterator[float]:
    return (ship["delay_s"] for ship in kept["ships"].values() if ship["delay_s"] is not None)


def _stand_on_delays(kept: dict[str, Any]) -> Iterator[float]:
    """Delay of ships that stood on throughout, as a share of their undisturbed voyage."""
    met = kept["encounters"]
    gave_way = {id_ for each in met for id_ in each["give_way"]}
    for id_ in {id_ for each in met for id_ in each["stand_on"]} - gave_way:
        delay = kept["ships"][id_]["delay_s"]
        if delay is not None:
            yield delay / kept["undisturbed_s"][id_]


def _mean(values: Sequence[float]) -> float | None:
    return sum(values) / len(values) if values else None


def upper_bound(count: int, n: int) -> float | None:
    """Upper confidence bound of a rate (Clopper-Pearson, one-sided): what n cases with `count` hits allow.

    >>> round(upper_bound(0, 300), 4)   # the rule of three
    0.0099
    """
    if n == 0:
        return None
    if count >= n:
        return 1.0
    low, high = count / n, 1.0
    for _ in range(60):
        middle = (low + high) / 2.0
        if _at_most(count, n, middle) > 1.0 - CONFIDENCE:
            low = middle
        else:
            high = middle
    return high


def _at_most(count: int, n: int, rate: float) -> float:
    """Probability of at most `count` hits in n."""
    log_rate, log_rest = math.log(rate), math.log1p(-rate)
    terms = (
        math.lgamma(n + 1) - math.lgamma(k + 1) - math.lgamma(n - k + 1) + k * log_rate + (n - k) * log_rest
        for k in range(count + 1)
    )
    return sum(math.exp(term) for term in terms)


def faults(result: Result) -> tuple[str, ...]:
    """What is wrong with a case, worst first; empty where nothing is."""
    if result.status is not Status.DONE:
        return (str(result.status),)
    kept = result.kept
    found = [mark for mark in _MARKS if kept[mark]]
    if (kept.get("laws") or {}).get("faults"):
        found.append("laws")
    if any(met["faithful"] is False for met in kept["encounters"]):
        found.append("unfaithful")
    if kept["calm"] and kept["acted"]:
        found.append("needless")
    if kept["restless"]:
        found.append("restless")
    return tuple(found)


def worst(results: Iterable[Result]) -> list[tuple[Result, tuple[str, ...]]]:
    """All cases with a fault, the worst first, then by the least clearance."""
    order = (*(str(status) for status in Status), *_MARKS, "laws", "unfaithful", "needless", "restless")
    found = [(each, what) for each in results if (what := faults(each))]

    def rank(pair: tuple[Result, tuple[str, ...]]) -> tuple[int, float, str]:
        clearance = pair[0].kept.get("min_clearance_m")
        return order.index(pair[1][0]), math.inf if clearance is None else clearance, pair[0].case.name

    return sorted(found, key=rank)


def price(compared: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Sum up what `baseline.compare` says of cases: the price of being distributed.

    `dearer` is the cost as sailed over the joint optimum, where that costs something.

    >>> one = {"free": True, "converged": True, "joint_cost": 10.0, "sailed_cost": 15.0}
    >>> price({"a": one, "b": {"why": "took too long"}})["dearer_median"]
    1.5
    """
    solved = [each for each in compared.values() if "joint_cost" in each]
    ratios = sorted(
        each["sailed_cost"] / each["joint_cost"] for each in solved if each["joint_cost"] > FREE_OF_COST
    )
    return {
        "compared": len(compared),
        "solved": len(solved),
        "converged": sum(each["converged"] for each in solved),
        "free": sum(each["free"] for each in solved),
        "costly": len(ratios),
        "dearer_median": _quantile(ratios, 0.5),
        "dearer_p90": _quantile(ratios, 0.9),
        "mean_joint_cost": _mean([each["joint_cost"] for each in solved]),
        "mean_sailed_cost": _mean([each["sailed_cost"] for each in solved]),
    }


def _quantile(values: Sequence[float], share: float) -> float | None:
    """Quantile of sorted values: the least that so large a share does not exceed."""
    return values[max(0, math.ceil(share * len(values)) - 1)] if values else None


def summary(name: str, seed: int, results: Sequence[Result]) -> dict[str, Any]:
    """Summarise a sweep: counts, not rates (contract), and what failed."""
    statuses = Counter(str(each.status) for each in results if each.status is not Status.DONE)
    return {
        "schema": "ccas/sweep-summary@1",
        "spec": name,
        "seed": seed,
        "cells": cell_entries(results),
        "failures": dict(sorted(statuses.items())),
        "mixed": [asdict(row) for row in rows((each.case.under, each.kept) for each in results)],
        "worst": [{"case": each.case.name, "faults": list(what)} for each, what in worst(results)],
    }
