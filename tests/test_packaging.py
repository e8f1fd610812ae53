"""The wheel: what is in it, and that it works where the repository is not."""

from __future__ import annotations

import importlib.metadata
import os
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = {
    "ccas_core": ROOT / "ccas_core",
    "ccas_rulesets": ROOT / "rulesets" / "ccas_rulesets",
    "ccas_plugins": ROOT / "plugins" / "ccas_plugins",
    "ccas_cli": ROOT / "cli" / "ccas_cli",
    "ccas_scenarios": ROOT / "scenarios" / "ccas_scenarios",
}


def run(*command: str | Path, cwd: Path) -> str:
    """Run a program that sees nothing of the repository by way of PYTHONPATH; return its output."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def project() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the wheel once, with the hatchling that is installed: no network."""
    folder = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT, cwd=folder)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def programs(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the wheel into an environment of its own, which borrows the dependencies; its programs."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder)
    scheme = {"base": str(folder), "platbase": str(folder)}
    own = Path(sysconfig.get_path("purelib", "venv", scheme))
    own.joinpath("borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    programs = Path(sysconfig.get_path("scripts", "venv", scheme))
    pip = (sys.executable, "-m", "pip", "--python", programs / "python")
    run(*pip, "install", "--quiet", "--no-deps", "--no-index", wheel, cwd=folder)
    return programs


def test_wheel_holds_every_file_of_the_packages_and_nothing_else(wheel: Path) -> None:
    expected = {
        f"{name}/{file.relative_to(folder).as_posix()}"
        for name, folder in PACKAGES.items()
        for file in folder.rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    }

    with zipfile.ZipFile(wheel) as archive:
        found = {name for name in archive.namelist() if ".dist-info/" not in name}

    assert found == expected


def test_wheel_holds_the_scenarios_and_the_marker_of_types(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        found = set(archive.namelist())

    assert {"ccas_scenarios/tran2026/fig_12.yaml", "ccas_core/py.typed"} <= found


def test_wheel_is_clean(wheel: Path) -> None:
    run(sys.executable, "-m", "check_wheel_contents", "--config", ROOT / "pyproject.toml", wheel, cwd=ROOT)


def test_names_at_top_level_are_the_packages(project: dict[str, Any]) -> None:
    packages = project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]

    assert {ROOT / package for package in packages} == set(PACKAGES.values())
    assert set(project["tool"]["check-wheel-contents"]["toplevel"]) == set(PACKAGES)
    assert set(project["tool"]["importlinter"]["root_packages"]) == set(PACKAGES)


def test_dev_tools_are_the_same_as_extra_and_as_group(project: dict[str, Any]) -> None:
    assert project["project"]["optional-dependencies"]["dev"] == project["dependency-groups"]["dev"]


def test_version_is_the_same_wherever_it_is_written(project: dict[str, Any]) -> None:
    version = project["project"]["version"]

    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert importlib.metadata.version("ccas") == version


def test_installed_packages_are_those_of_the_wheel(programs: Path, tmp_path: Path) -> None:
    imports = "; ".join(f"import {name}; print({name}.__file__)" for name in PACKAGES)

    files = run(programs / "python", "-c", imports, cwd=tmp_path).splitlines()

    assert all(Path(file).is_relative_to(programs.parent) for file in files), files


def test_installed_program_explains_itself(programs: Path, tmp_path: Path) -> None:
    assert "simulate" in run(programs / "ccas", "--help", cwd=tmp_path)


def test_installed_program_has_the_scenarios(programs: Path, tmp_path: Path) -> None:
    assert "tran2026/fig_12" in run(programs / "ccas", "scenarios", cwd=tmp_path)


def test_installed_program_finds_the_shipped_rulesets(programs: Path, tmp_path: Path) -> None:
    assert "tran2026" in run(programs / "ccas", "rulesets", cwd=tmp_path)
