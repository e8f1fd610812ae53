"""Certificates: verified by arithmetic, refused when anything in them is changed."""

from __future__ import annotations

import json
import random
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import z3

from ccas_core.proofs.certificate import certificate, multiplied, write_certificate
from ccas_core.proofs.certificate_check import CertificateError, Lemma, Part, verify
from ccas_core.proofs.clauses import possible
from ccas_core.proofs.findings import Outcome
from ccas_core.proofs.statements import unturned
from ccas_core.tapd.language.polynomial import number, variable
from ccas_core.tapd.written import WrittenRuleset

from .rulesets import broken, finding, shipped

X, Y = variable("x"), variable("y")


@pytest.fixture(scope="module")
def ruleset() -> WrittenRuleset:
    return broken("equal_ships.repaired")


@pytest.fixture(scope="module")
def proof(ruleset: WrittenRuleset) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(certificate(ruleset))
    return document


@pytest.mark.parametrize("name", ["tran2026", "bpr", "cn_inland", "de_binsch"])
def test_a_shipped_ruleset_that_is_consistent_has_a_certificate_for_it(name: str, tmp_path: Path) -> None:
    covered = {each.name: each for each in write_certificate(shipped(name), tmp_path / "proof.json")}

    assert covered["consistent"].whole
    assert covered["mirror_sound"].whole
    assert not covered["complete"].whole


def test_a_ruleset_that_is_complete_has_a_certificate_for_that_too(
    ruleset: WrittenRuleset, proof: dict[str, Any]
) -> None:
    covered = verify(json.dumps(proof), ruleset)

    assert [each.name for each in covered] == ["consistent", "mirror_sound", "complete"]
    assert [each.open for each in covered] == [(), (), ()]


@pytest.mark.parametrize("name", ["gate_forgotten", "both_stand_on"])
def test_there_is_no_certificate_for_what_is_refuted(name: str) -> None:
    covered = {each.name: each for each in verify(certificate(broken(name)), broken(name))}

    for property_, each in covered.items():
        if finding(broken(name), property_).outcome is Outcome.REFUTED:
            assert each.open


def test_it_is_verified_without_a_solver() -> None:
    code = "import sys, ccas_core.proofs.certificate_check; sys.exit('z3' in sys.modules)"

    assert subprocess.run((sys.executable, "-c", code), check=False).returncode == 0


def refusal(proof: dict[str, Any], ruleset: WrittenRuleset) -> str:
    """What is said of a certificate that is refused."""
    with pytest.raises(CertificateError) as caught:
        verify(json.dumps(proof), ruleset)
    return str(caught.value)


def test_a_changed_factor_is_noticed(ruleset: WrittenRuleset, proof: dict[str, Any]) -> None:
    for n in range(len(proof["lemmas"])):
        changed = json.loads(json.dumps(proof))
        part = changed["lemmas"][n]["parts"][0]
        part["times"] = str(Fraction(part["times"]) + 1)

        assert f"lemma {n} does not hold: its terms do not add to nothing" in refusal(changed, ruleset)


def test_a_negative_factor_is_noticed(ruleset: WrittenRuleset, proof: dict[str, Any]) -> None:
    changed = json.loads(json.dumps(proof))
    changed["lemmas"][0]["parts"] = [{"times": "-1", "of": [], "monomial": []}]

    assert "a factor is negative" in refusal(changed, ruleset)


def test_a_lemma_that_is_left_out_is_noticed(ruleset: WrittenRuleset, proof: dict[str, Any]) -> None:
    for n, statement in enumerate(proof["statements"]):
        if statement["lemmas"]:
            changed = json.loads(json.dumps(proof))
            changed["statements"][n]["lemmas"] = statement["lemmas"][1:]

            assert "is not impossible by what is given for it" in refusal(changed, ruleset)


def test_a_part_that_is_left_out_is_noticed(ruleset: WrittenRuleset, proof: dict[str, Any]) -> None:
    changed = json.loads(json.dumps(proof))
    changed["statements"][0]["parts"].pop()

    assert "is not impossible by what is given for it" in refusal(changed, ruleset)


@pytest.mark.parametrize(
    ("key", "value"),
    [("version", "9.9.9"), ("digest", "0" * 64), ("ruleset", "another"), ("schema", "ccas/certificate@9")],
)
def test_another_ruleset_or_version_is_noticed(
    ruleset: WrittenRuleset, proof: dict[str, Any], key: str, value: str
) -> None:
    assert value in refusal({**proof, key: value}, ruleset)


def test_a_statement_that_the_ruleset_does_not_make_is_noticed(
    ruleset: WrittenRuleset, proof: dict[str, Any]
) -> None:
    more = {"property": "consistent", "title": "the moon is no ship", "parts": [], "lemmas": []}

    assert "the moon" in refusal({**proof, "statements": [*proof["statements"], more]}, ruleset)


def test_a_certificate_of_the_repaired_ruleset_is_none_of_the_broken_one(proof: dict[str, Any]) -> None:
    faulty = broken("equal_ships")
    posing = {**proof, "ruleset": faulty.id, "version": faulty.version}

    assert "digest" in refusal(posing, faulty)


@pytest.mark.parametrize("junk", ["", "[]", "{}", '{"schema": 1}', "null"])
def test_what_is_no_certificate_is_refused(ruleset: WrittenRuleset, junk: str) -> None:
    with pytest.raises(CertificateError):
        verify(junk, ruleset)


def test_a_lemma_needs_something_greater_than_zero() -> None:
    parts = (Part(times=Fraction(1), of=(0,)), Part(times=Fraction(1), of=(1,)))

    assert Lemma(signs=((X, ">="), (X, "<=")), parts=parts).fault.startswith("none of its terms")
    assert not Lemma(signs=((X, ">"), (X, "<=")), parts=parts).fault
    assert Lemma(signs=((X, ">"), (Y, "<=")), parts=parts).fault == "its terms do not add to nothing"


def test_factors_are_found_for_products() -> None:
    lemma = multiplied([(X, ">"), (Y, ">"), (X * Y, "<=")], products=True)

    assert lemma is not None
    assert not lemma.fault
    assert multiplied([(X, ">"), (Y, ">"), (X * Y, "<=")], products=False) is None
    assert multiplied([(X, ">"), (Y, ">")], products=True) is None


def test_a_polynomial_that_depends_on_north_is_told_from_one_that_does_not() -> None:
    square = variable("rx") * variable("rx") + variable("ry") * variable("ry")
    crossed = variable("rx") * variable("wy") - variable("ry") * variable("wx")

    assert unturned(square - number(100))
    assert unturned(crossed * crossed)
    assert not unturned(variable("rx"))
    assert not unturned(variable("rx") * variable("wx"))


def test_the_search_agrees_with_the_solver_on_random_clauses() -> None:
    draw = random.Random(7)  # noqa: S311 - no secret
    for _ in range(400):
        count = draw.randint(3, 12)
        clauses = [
            tuple(draw.choice((-1, 1)) * draw.randint(1, count) for _ in range(draw.randint(1, 3)))
            for _ in range(draw.randint(2, 5 * count))
        ]
        solver = z3.SimpleSolver()
        for clause in clauses:
            flags = [z3.Bool(str(abs(each))) for each in clause]
            solver.add(z3.Or([f if each > 0 else z3.Not(f) for f, each in zip(flags, clause, strict=True)]))

        assert possible(clauses) == (solver.check() == z3.sat), clauses
