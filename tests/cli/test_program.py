"""The program as a whole: how quickly it explains itself, and how it ends."""

from __future__ import annotations

import importlib.metadata
import subprocess
import sys
from pathlib import Path

import pytest
import typer

from ccas_cli import inputs
from ccas_cli.main import COMMANDS
from ccas_core.dmpc.solvers import SOLVERS

from . import MAIN, ccas, ccas_alone

HEAVY = ("casadi", "numpy", "matplotlib", "networkx", "numba", "scipy", "shapely", "pyproj", "rich", "yaml")
NAMES = [command.__name__.replace("_", "-") for command in COMMANDS]


@pytest.mark.parametrize("command", ["", *NAMES])
def test_help_imports_nothing_heavy(command: str, tmp_path: Path) -> None:
    program = (
        "import sys\nfrom ccas_cli.main import main\n"
        "try:\n    main()\n"
        f"finally:\n    print('heavy:', *(set({HEAVY}) & {{*sys.modules}}), file=sys.stderr)\n"
    )

    done = ccas_alone(*command.split(), "--help", cwd=tmp_path, program=program)

    assert done.returncode == 0
    assert done.stderr == "heavy:\n"
    assert "Example:\n" in done.stdout


def test_help_names_every_command() -> None:
    assert all(f"\n  {name}" in ccas("--help").stdout for name in NAMES)


def test_help_names_every_solver() -> None:
    assert all(name in ccas("simulate", "--help").stdout for name in SOLVERS)


def test_version_is_that_of_the_installed_package() -> None:
    assert ccas("--version").stdout == f"ccas {importlib.metadata.version('ccas')}\n"


@pytest.mark.parametrize(
    "arguments",
    ["simlate", "simulate", "simulate a b", "simulate --sover x", "graph x --format y", "explain"],
)
def test_wrong_use_ends_with_2_and_says_so_on_stderr(arguments: str) -> None:
    done = ccas(*arguments.split())

    assert done.exit_code == 2
    assert "Error: " in done.stderr
    assert done.stdout == ""


def test_fault_of_ours_is_told_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CCAS_DEBUG", raising=False)
    monkeypatch.setattr(inputs, "load_plugins", _fail)

    done = ccas("rulesets")

    assert done.exit_code == 101
    assert done.stderr.count("\n") == 1
    assert "a fault of ours: ZeroDivisionError: of all things" in done.stderr
    assert "CCAS_DEBUG=1" in done.stderr


def test_fault_of_ours_is_told_in_full_where_that_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CCAS_DEBUG", "1")
    monkeypatch.setattr(inputs, "load_plugins", _fail)

    done = ccas("rulesets")

    assert done.exit_code == 101
    assert "Traceback" in done.stderr
    assert "in _fail" in done.stderr


def test_ctrl_c_ends_any_command_with_130(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(inputs, "load_plugins", _interrupt)

    done = ccas("rulesets")

    assert (done.exit_code, done.stdout, done.stderr) == (130, "", "interrupted\n")


def test_reader_that_has_gone_is_no_reason_to_complain(tmp_path: Path) -> None:
    with subprocess.Popen(
        (sys.executable, "-c", MAIN, "scenarios"),
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        process.stdout.close()
        assert process.stderr is not None
        complaint = process.stderr.read()

    assert complaint == ""
    assert process.returncode == 141


def test_hooks_are_traced_on_stderr() -> None:
    done = ccas("--trace-hooks", "rulesets", "--json")

    assert "hook: rulesets: ccas_rulesets -> " in done.stderr
    assert "hook" not in done.stdout


def _fail(_: typer.Context) -> None:
    raise ZeroDivisionError("of all things\nand more")


def _interrupt(_: typer.Context) -> None:
    raise KeyboardInterrupt
