"""Files spoilt at random, a share of `studies/mutate_files.py`: read, or refused with a place, and soon."""

from __future__ import annotations

import runpy
import time
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from ..test_repository import ROOT
from .rulesets import ENCOUNTER, HEAD, OTHERWISE, RULES

COUNT = 1200
SEED = 7
Bases: TypeAlias = tuple[tuple[Any, ...], Any]  # to be spoilt, and the library
LIMIT = 2.0  # for one file [s]
SMALL = (
    HEAD
    + """\
description: All that a file may hold
params:
  T: 300 s
  D: {value: 0.1 km, range: [50 m, 200 m], meaning: how near}
regimes: {tidal: where the tide runs}
let:
  near: dcpa < D and tcpa < T
  short(ship): ship.length < 20 m and not ship.ferry or ship.convoy_only_small
gates:
  - {id: tide, when: regime.tidal and near, off: [sail.*, ferry], cite: {article: "8"}, note: as seen}
deadlock: {resolve_by: [length descending, weight ascending, id]}
domain: {speed: [1 m/s, 10 m/s], length: [5 m, 0.2 km], separation: 100 m, assume: "own.length > 3 m"}
waivers:
  - {check: both-obliged, reason: the law itself, expires: 2027-06-30, rules: [ferry]}
tests:
  - name: a ferry stands on
    waterway: {type: canal}
    encounter: {geometry: crossing, has_other_on_starboard: A}
    ships: {A: {ferry: true, length: 20 m}, B: {at: [0 m, 3 m], course: 3 deg, speed: 2 m/s}}
    expect: {give_way: B, by: ferry}
"""
    + ENCOUNTER
    + RULES
    + """\
  - id: short
    cite: {article: "4", version: "3", confidence: derived, text: Short ships wait}
    where: waterway.sign_a2
    when: [short(own), not short(other)]
    unless: [own.nuc, {when: own.ram, unless: other.ram}]
    then: give_way
    strength: wait
    pass: port_to_port
    passing: preferred
    note: not seen
"""
    + OTHERWISE
)


@pytest.fixture(scope="module")
def study() -> dict[str, Any]:
    return runpy.run_path(str(ROOT / "studies" / "mutate_files.py"), run_name="study")


@pytest.fixture(scope="module")
def bases(study: dict[str, Any]) -> Bases:
    shipped, library = study["shipped"]()
    small = study["Base"]("small", SMALL)
    cases = [base for base in shipped if base.cases]
    brief = [base for base in shipped if base.name in ("common", "tran2026_printed")]
    return (small, small, small, *cases, *brief), library


def test_files_to_be_spoilt_are_well(study: dict[str, Any], bases: Bases, tmp_path: Path) -> None:
    for base in bases[0]:
        file = study["Spoilt"](base, base.text.encode(), renamed=False, how="")
        outcome = study["tried"](file, bases[1], tmp_path)
        assert (outcome.what, outcome.wrong) == ("read", ""), outcome


def test_spoilt_files_are_read_or_refused_with_a_place_and_soon(
    study: dict[str, Any], bases: Bases, tmp_path: Path
) -> None:
    wrong, seen = [], {"read": 0, "refused": 0}
    for number in range(COUNT):
        file = study["spoilt"](bases[0], SEED, number)
        before = time.process_time()
        outcome = study["tried"](file, bases[1], tmp_path)
        took = time.process_time() - before
        if outcome.wrong or took > LIMIT:
            wrong.append(f"{number} ({file.base.name}, {file.how}): {outcome.wrong or f'{took:.1f} s'}")
        seen[outcome.what] = seen.get(outcome.what, 0) + 1

    assert wrong == []
    assert min(seen["read"], seen["refused"]) > 50


def test_every_key_of_the_files_is_refused_under_another_name(
    study: dict[str, Any], bases: Bases, tmp_path: Path
) -> None:
    for base in dict.fromkeys(bases[0]):
        reader = study["Reader"](base.text, "file")
        for key in study["fixed_keys"](reader.root):
            lines = base.text.split("\n")
            line, at = lines[key.line - 1], key.column - 1
            lines[key.line - 1] = f"{line[:at]}{key.text}z{line[at + len(key.text) :]}"
            file = study["Spoilt"](base, "\n".join(lines).encode(), renamed=True, how=key.text)
            outcome = study["tried"](file, bases[1], tmp_path)
            assert (outcome.what, outcome.wrong) == ("refused", ""), (base.name, key)


def test_mutation_of_a_seed_is_always_the_same(study: dict[str, Any], bases: Bases) -> None:
    for number in range(20):
        one, two = (study["spoilt"](bases[0], SEED, number) for _ in range(2))
        assert one == two
        assert one.data != one.base.text.encode() or not one.renamed
