"""The public names of `ccas_core`: each is what type checkers take it for, and costs nothing unused."""

from __future__ import annotations

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import ccas_core

HEAVY = ("casadi", "matplotlib", "networkx", "numba", "numpy", "pyproj", "shapely", "yaml")


def shown_to_type_checkers() -> dict[str, tuple[str, str]]:
    """Names under TYPE_CHECKING, each with its module and its name there."""
    tree = ast.parse(Path(ccas_core.__file__).read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If) and isinstance(node.test, ast.Name))
    imports = [node for node in block.body if isinstance(node, ast.ImportFrom)]
    shown = {
        each.asname or each.name: (f"ccas_core.{node.module}", each.name)
        for node in imports
        for each in node.names
    }
    shown["load_plugins"] = shown.pop("load")
    return shown


@pytest.mark.parametrize("name", ccas_core.__all__)
def test_public_name_is_what_type_checkers_take_it_for(name: str) -> None:
    module, there = shown_to_type_checkers()[name]

    assert getattr(ccas_core, name) is getattr(import_module(module), there)
    assert name in dir(ccas_core)


def test_type_checkers_see_the_public_names_and_no_others() -> None:
    assert set(ccas_core.__all__) == set(shown_to_type_checkers())
    assert ccas_core.__all__ == sorted(ccas_core.__all__)


@pytest.mark.parametrize(
    "name",
    [
        "Case", "Fact", "FactKind", "FactScope", "FactSource", "PairView", "PluginInfo", "PythonRule",
        "RankingCriterion", "RoleDecision", "VOCABULARY", "Vocabulary", "WrittenRuleset", "load_ruleset",
    ],
)  # fmt: skip
def test_what_authors_of_rules_and_plugins_need_is_public(name: str) -> None:
    assert name in ccas_core.__all__


def test_name_that_is_not_there_is_told_as_in_any_module() -> None:
    with pytest.raises(AttributeError, match="module 'ccas_core' has no attribute 'Verdikt'"):
        getattr(ccas_core, "Verdikt")  # noqa: B009, a type checker knows that it is not there


@pytest.mark.parametrize("program", ["import ccas_core", "from ccas_core import InputError, ShipId"])
def test_import_loads_nothing_heavy(program: str) -> None:
    told = f"import sys; {program}; print([name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True)

    assert done.stdout == "[]\n"
