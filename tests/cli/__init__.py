"""Tests of the command line, a scenario for them, and ways to run the program."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from typer.testing import CliRunner, Result

from ccas_cli.main import app

MAIN = "from ccas_cli.main import main; main()"

TWO_SHIPS = """\
schema: ccas/scenario@1
name: two ships cross
time: {step: 20 s}
waters:
  ruleset: tran2026
  regions: []
  waterways:
    - {id: canal, centreline: [[-500, 0], [250, 0]], width: 160 m}
    - {id: river, centreline: [[0, -500], [0, 250]], width: 160 m}
ships:
  - id: ship_1
    length: 40 m
    beam: 6 m
    weight: 400 t
    route: [{waterway: canal, towards: end}]
    start: [-300, 0]
    speed: 3 m/s
  - id: ship_2
    length: 40 m
    beam: 6 m
    weight: 500 t
    route: [{waterway: river, towards: end}]
    start: [0, -320]
    speed: 3 m/s
control: {horizon: 10, iterations: 1}
"""


def ccas(*arguments: str | Path) -> Result:
    """Run a command in this process."""
    return CliRunner().invoke(app, [str(each) for each in arguments])


def ccas_alone(*arguments: str | Path, cwd: Path, program: str = MAIN) -> subprocess.CompletedProcess[str]:
    """Run a command in a process of its own."""
    command = (sys.executable, "-c", program, *map(str, arguments))
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False, timeout=200)
