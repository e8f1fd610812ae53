"""The page of a replay: one HTML file that asks for nothing else, `replay.html` with the data put in."""

from __future__ import annotations

import errno
import html
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from .run_folder import explained

TEMPLATE: Final = Path(__file__).with_name("replay.html")
_TITLE, _DATA = "%TITLE%", "%DATA%"  # where they go in the template


def page(shown: Mapping[str, Any]) -> str:
    """Put what `replay` gathered into the page."""
    data = json.dumps(shown, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    for letter in "<>&\u2028\u2029":  # so that no name ends the script that holds it
        data = data.replace(letter, f"\\u{ord(letter):04x}")
    before, title, rest = TEMPLATE.read_text(encoding="utf-8").partition(_TITLE)
    middle, mark, after = rest.partition(_DATA)
    if not (title and mark):
        raise ValueError(f"{TEMPLATE.name} has no place for {_TITLE} and {_DATA}")
    return before + html.escape(shown["name"]) + middle + data + after


def write_page(shown: Mapping[str, Any], file: Path) -> int:
    """Write the page, whole or not at all; how many bytes it has.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    content = page(shown).encode("utf-8")
    with explained(file, hint="free space, or choose another file with --out"):
        if file.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(file))
        part = file.with_name(f".{file.name}.part")
        try:
            part.write_bytes(content)
            part.replace(file)
        finally:
            part.unlink(missing_ok=True)
    return len(content)
