"""The guide "Write a ruleset in twenty minutes", done word for word."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from . import ccas

DOCS = Path(__file__).parents[2] / "docs"
GUIDE = (DOCS / "write-a-ruleset.md").read_text(encoding="utf-8")
FILE = Path("my_river.yaml")
STEP = re.compile(
    r"""^<!-- edit: (?:before "(?P<before>.*?)"|replace "(?P<old>.*?)" by "(?P<new>.*?)"|(?P<end>end)) -->$"""
    r"|^```(?P<kind>console|yaml)\n(?P<block>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)


def told(command: str) -> str:
    """Run a command of the guide; what it says on both streams."""
    program, *arguments = shlex.split(command)
    assert program == "ccas"
    done = ccas(*arguments)
    assert done.exit_code in (0, 1, 2), done.output
    return done.stdout + done.stderr


def shown(block: str) -> None:
    """Run the commands of a block; every line below a command must be among what it says."""
    commands = re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", block, re.MULTILINE)
    assert commands
    for command, lines in commands:
        said = [line.rstrip() for line in told(command).splitlines()]
        for line in lines.splitlines():
            assert line.rstrip() in said, f"{command}\n{line}"


@pytest.mark.timeout(120)
def test_guide_is_true_word_for_word(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    place: re.Match[str] | None = None
    for step in STEP.finditer(GUIDE):
        if step["kind"] == "console":
            shown(step["block"])
        elif step["kind"] == "yaml":
            assert place is not None
            text = FILE.read_text(encoding="utf-8")
            at = len(text) if place["end"] else text.index(f"{place['before']}\n")
            FILE.write_text(text[:at] + step["block"] + text[at:], encoding="utf-8")
        elif step["old"]:
            FILE.write_text(
                FILE.read_text(encoding="utf-8").replace(step["old"], step["new"]), encoding="utf-8"
            )
        place = step

    assert (tmp_path / "differences" / "001.yaml").is_file()
    assert (tmp_path / "differences" / "001.scenario.yaml").is_file()
    assert "difference_1" in told("ccas explain differences/001.yaml --case difference_1")
    assert ccas("check", "differences").exit_code == 1  # remarks alone: my_river is not installed


def test_example_of_the_format_is_a_ruleset_that_passes(tmp_path: Path) -> None:
    text = (DOCS / "ruleset-format.md").read_text(encoding="utf-8")
    example = re.search(r"```yaml\n(.*?)```", text, re.DOTALL)
    assert example
    file = tmp_path / "example.yaml"
    file.write_text(example[1], encoding="utf-8")

    assert ccas("check", file).exit_code == 0
    assert ccas("test", file).exit_code == 0
