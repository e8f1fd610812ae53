"""Who may import whom: the contracts hold, and each of them notices a wrong import."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = (
    "ccas_core",
    "rulesets/ccas_rulesets",
    "plugins/ccas_plugins",
    "cli/ccas_cli",
    "scenarios/ccas_scenarios",
)

# importing module, imported module, contract that has to notice
WRONG_IMPORTS = (
    ("ccas_core.units", "ccas_rulesets", "The core knows none of its users"),
    ("ccas_plugins", "ccas_rulesets", "they do not know each other"),
    ("ccas_scenarios", "ccas_cli", "they do not know each other"),
    ("ccas_core.tapd", "ccas_core.dmpc", "two independent layers"),
    ("ccas_core.dmpc.outcome", "ccas_core.tapd", "two independent layers"),
    ("ccas_core.dmpc.risk", "ccas_core.agent", "Inside the core"),
    ("ccas_core.agent", "ccas_core.sim.frame", "Inside the core"),
    ("ccas_core.frames", "ccas_core.waterway", "Inside the core"),
    ("ccas_core.dmpc.cost", "ccas_core.verdict", "Layer 2 reads roles"),
    ("ccas_core.sim", "casadi", "casadi is imported"),
    ("ccas_core.tapd", "casadi", "casadi is imported"),
    ("ccas_plugins", "casadi", "casadi is imported"),
    ("ccas_rulesets", "pluggy", "pluggy is imported"),
    ("ccas_core.priority", "yaml", "yaml is imported"),
    ("ccas_cli", "yaml", "yaml is imported"),
    ("ccas_core.strict_yaml", "yaml", "yaml is imported"),
    ("ccas_core.sim", "ccas_core.proofs", "Inside the core"),
    ("ccas_core.tapd", "z3", "z3 is imported"),
    ("ccas_cli", "z3", "z3 is imported"),
    ("ccas_core.sim.frame", "matplotlib", "matplotlib is imported"),
    ("ccas_core.dmpc.solvers", "numba", "numba is imported"),
    ("ccas_core.sim", "typer", "typer and rich are imported"),
    ("ccas_scenarios", "rich", "typer and rich are imported"),
)


def lint_imports(folder: Path) -> subprocess.CompletedProcess[str]:
    """Check the contracts of `folder`; packages that lie in it come before installed ones."""
    program = "from importlinter.cli import lint_imports_command; lint_imports_command()"
    command = (sys.executable, "-c", program, "--no-logo", "--no-cache")
    environment = {**os.environ, "COLUMNS": "500"}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def report_on_wrong_imports(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Add all wrong imports to a copy of the packages; what the contracts say of it."""
    copy = tmp_path_factory.mktemp("copy")
    shutil.copy(ROOT / "pyproject.toml", copy)
    for package in PACKAGES:
        shutil.copytree(ROOT / package, copy / Path(package).name)
    for module, imported, _ in WRONG_IMPORTS:
        path = copy.joinpath(*module.split("."))
        file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
        with file.open("a", encoding="utf-8") as text:
            text.write(f"\nimport {imported}\n")
    done = lint_imports(copy)
    assert done.returncode == 1, done.stdout + done.stderr
    return done.stdout


def test_contracts_are_kept() -> None:
    done = lint_imports(ROOT)

    assert done.returncode == 0, done.stdout + done.stderr
    assert " 0 broken" in done.stdout


@pytest.mark.parametrize(("module", "imported", "contract"), WRONG_IMPORTS)
def test_wrong_import_is_noticed(
    module: str, imported: str, contract: str, report_on_wrong_imports: str
) -> None:
    _, _, broken = report_on_wrong_imports.partition("Broken contracts")
    _, *sections = re.split(r"^(.+)\n-+$", broken, flags=re.MULTILINE)
    found = zip(sections[::2], sections[1::2], strict=True)

    assert any(contract in name and f"{module} -> {imported} " in text for name, text in found), broken
