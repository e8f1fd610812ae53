"""A scenario file, in a folder of its own, from which the program is run."""

from __future__ import annotations

from pathlib import Path

import pytest

from . import TWO_SHIPS


@pytest.fixture
def two_ships(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Write the scenario, and go to its folder."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "two_ships.yaml"
    file.write_text(TWO_SHIPS, encoding="utf-8")
    return file
