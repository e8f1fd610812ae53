"""Files that are damaged in many ways: told, never a traceback, never passed over."""

from __future__ import annotations

import random
from pathlib import Path

from . import ccas
from .test_cases import CASES, RULESET

MANY = 40
PIECES = [
    "",
    "\n",
    ":",
    "- ",
    "{",
    "]",
    "'",
    "own.",
    "not ",
    "20",
    " m",
    "é",
    "\t",
    "&a ",
    "*a",
    "unknown",
    "~",
]


def damaged(text: str, chance: random.Random) -> str:
    """Take something out of a text, put something in, or say something twice; a few times."""
    for _ in range(chance.randint(1, 3)):
        begin = chance.randrange(len(text))
        end = min(len(text), begin + chance.randint(0, 12))
        match chance.randrange(4):
            case 0:
                text = text[:begin] + text[end:]
            case 1:
                text = text[:begin] + chance.choice(PIECES) + text[begin:]
            case 2:
                text = text[:begin] + text[begin:end] * 2 + text[end:]
            case _:
                lines = text.split("\n")
                one, other = (chance.randrange(len(lines)) for _ in range(2))
                lines[one], lines[other] = lines[other], lines[one]
                text = "\n".join(lines)
    return text


def test_damaged_files_are_told_by_every_command(tmp_path: Path) -> None:
    chance = random.Random(11)  # noqa: S311 - damage need not be secret
    for number in range(MANY):
        file = tmp_path / f"damaged_{number}.yaml"
        cases = number % 2 == 0
        file.write_text(damaged(CASES if cases else RULESET, chance), encoding="utf-8")

        checked = ccas("check", file)
        tested = ccas("test", file)
        explained = ccas("explain", file, "--case", "G1" if cases else "the ship from port gives way")

        for done in (checked, tested, explained):
            assert done.exit_code in (0, 1, 2), (file.read_text(), done.output)
            assert done.exit_code != 2 or done.stdout or done.stderr
        assert (checked.exit_code == 2) <= (tested.exit_code == 2), file.read_text()
