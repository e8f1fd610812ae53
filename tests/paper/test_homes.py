"""The numbered results of the paper all have a home; `test_repository` holds each home to its claim."""

from __future__ import annotations

import ast
import re

import pytest

from ..test_repository import HOMES, ROOT, claims

CORE = ROOT / "ccas_core"


def summaries() -> dict[str, str]:
    """First paragraph of each module's docstring."""
    trees = {file: ast.parse(file.read_text(encoding="utf-8")) for file in sorted(CORE.rglob("*.py"))}
    return {
        file.relative_to(ROOT).as_posix(): (ast.get_docstring(tree) or "").partition("\n\n")[0]
        for file, tree in trees.items()
    }


def test_every_numbered_equation_of_the_paper_has_a_home() -> None:
    assert {number for number in HOMES if number.isdigit()} == {str(number) for number in range(1, 14)}


def test_no_module_claims_an_equation_that_the_paper_does_not_have() -> None:
    claimed = {number for text in summaries().values() for number in claims(text)}

    assert claimed <= HOMES.keys() | {"13a", "13c", "13d"}


@pytest.mark.parametrize(
    ("algorithm", "home"), [("1", "ccas_core/tapd/assign.py"), ("2", "ccas_core/dmpc/negotiate.py")]
)
def test_algorithm_has_one_home_that_claims_it(algorithm: str, home: str) -> None:
    claim = re.compile(rf", Algorithm {algorithm}\b")  # others may speak of it, or of a step of it

    assert [name for name, text in summaries().items() if claim.search(text)] == [home]


def test_every_equation_test_tests_the_home_of_its_equation() -> None:
    for file in sorted((ROOT / "tests" / "paper").glob("test_eq_*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        imported = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
        imported |= {
            f"{node.module}.{each.name}"
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom)
            for each in node.names
        }
        for number in re.findall(r"\d+", file.stem):
            home = HOMES[str(int(number))].removesuffix(".py").replace("/", ".")
            assert home in imported, f"{file.name} does not import {home}"
