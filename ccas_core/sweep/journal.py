"""Journal of a sweep: one line a case that is done, by a key of all that decides about its result.

A sweep that was stopped goes on from it, and one that is finished is not sailed again.  What failed is
tried again.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

from ..sim.metrics import plain

FILE: Final = "journal.jsonl"


class Journal:
    """Append-only file of results by key."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self.results: dict[str, dict[str, Any]] = dict(_read(file))

    def add(self, key: str, name: str, result: dict[str, Any]) -> dict[str, Any]:
        """Keep a result, and return it as it will be read again."""
        text = json.dumps({"key": key, "case": name, "result": plain(result)}, allow_nan=False)
        with self._file.open("a", encoding="utf-8", newline="\n") as file:
            file.write(text + "\n")
        kept: dict[str, Any] = json.loads(text)["result"]
        self.results[key] = kept
        return kept


def _read(file: Path) -> Iterable[tuple[str, dict[str, Any]]]:
    if not file.exists():
        return
    text = file.read_text(encoding="utf-8")
    for line in text.split("\n"):
        try:
            found = json.loads(line)
            yield found["key"], found["result"]
        except (ValueError, KeyError, TypeError):
            continue  # a line that was cut off: its case is sailed again
    if text and not text.endswith("\n"):
        with file.open("a", encoding="utf-8") as cut:
            cut.write("\n")


def code_digest(packages: Iterable[str]) -> str:
    """Digest of the sources and rule files of packages: results of another code are not taken for ours."""
    digest = hashlib.sha256()
    for package in sorted(packages):
        spec = importlib.util.find_spec(package)
        for root in (spec.submodule_search_locations or ()) if spec else ():
            for file in sorted(Path(root).rglob("*")):
                if file.suffix in (".py", ".yaml"):
                    digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()[:20]
