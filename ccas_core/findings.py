"""A text file of the user: read, and all that is wrong with it collected, each with its place."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, NoReturn

from .errors import Diagnostic, InputError, did_you_mean

MAX_BYTES: Final = 2_000_000
MAX_FINDINGS: Final = 100


@dataclass(frozen=True, slots=True)
class Place:
    """A place in a file; both count from 1, and 0 is the file as a whole."""

    line: int
    column: int


class Findings:
    """All that is wrong with one file.

    Parameters
    ----------
    text
        The text of the file.
    source
        What the file is called in findings.
    kind
        What to raise.
    """

    def __init__(self, text: str, source: str, kind: type[InputError] = InputError) -> None:
        self._source, self._kind = source, kind
        self._findings: list[Diagnostic] = []
        if len(text) > MAX_BYTES:
            raise kind(_too_large(source))
        self.content: Final = _with_newlines(text.removeprefix("\ufeff"))
        self._lines = self.content.split("\n")

    @property
    def count(self) -> int:
        """Number of findings so far."""
        return len(self._findings)

    @property
    def source(self) -> str:
        """What the file is called in findings."""
        return self._source

    def line(self, number: int) -> str:
        """A line of the file; empty where there is none."""
        return self._lines[number - 1] if 0 < number <= len(self._lines) else ""

    def told(self) -> tuple[Diagnostic, ...]:
        """All findings so far, in the order of the file, each once."""
        ordered = sorted(self._findings, key=lambda each: (each.line, each.column))
        return tuple(dict.fromkeys(ordered))  # what an alias repeats is found again

    def refuse(
        self, at: Place, message: str, *, expected: str = "", hint: str = "", width: int = 1, code: str = ""
    ) -> None:
        """Add a finding; too many of them stop the reading."""
        line = self.line(at.line)
        told = _finding(self._source, at, line, message, expected=expected, hint=hint)
        self._findings.append(replace(told, width=width, code=code))
        if self.count == MAX_FINDINGS:
            self.finish()

    def unknown(self, at: Place, what: str, word: str, known: Iterable[str]) -> None:
        """Add the finding that a word is not among those that are known."""
        names = list(known)
        hint = did_you_mean(word[:40], names) if names else ""
        self.refuse(at, f"unknown {what} {quoted(word)}", hint=hint)

    def stop(
        self, at: Place, message: str, *, expected: str = "", hint: str = "", width: int = 1
    ) -> NoReturn:
        """Add a finding after which nothing more can be known, and raise."""
        self.refuse(at, message, expected=expected, hint=hint, width=width)
        self.finish()
        raise AssertionError("a finding has just been added")

    def finish(self) -> None:
        """Raise all findings, in the order of the file, if there are any."""
        if self._findings:
            raise self._kind(*self.told())


def read_text(path: str | Path, kind: type[InputError] = InputError) -> str:
    """Read a file as UTF-8; whatever hinders it is raised as a `kind`."""
    source = str(path)
    try:
        with Path(path).open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = (isinstance(error, OSError) and error.strerror) or str(error)
        hint = "give the path of a YAML file"
        raise kind(Diagnostic(source=source, message=f"cannot be read: {reason}", hint=hint)) from None
    if len(data) > MAX_BYTES:
        raise kind(_too_large(source))
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = _with_newlines(data[: error.start].decode(errors="replace"))
        rest = data[error.start : error.start + 80].decode(errors="replace")
        message = f"byte 0x{data[error.start]:02X} is not UTF-8"
        line = before[before.rfind("\n") + 1 :] + rest.splitlines()[0]
        told = _finding(source, place_after(before), line, message, hint="save the file as UTF-8")
        raise kind(told) from None


def place_after(before: str) -> Place:
    r"""Place of what follows a text.

    >>> place_after("a: 1\nb: ")
    Place(line=2, column=4)
    """
    return Place(before.count("\n") + 1, len(before) - before.rfind("\n"))


def quoted(text: str) -> str:
    """Quote what a file says, cut to a length that can be read."""
    return f"'{text[:40]}…'" if len(text) > 40 else f"'{text}'"


def _with_newlines(text: str) -> str:
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _too_large(source: str) -> Diagnostic:
    message = f"larger than {MAX_BYTES // 1_000_000} MB"
    return Diagnostic(
        source=source, line=1, column=1, message=message, hint="is this the file that you meant?"
    )


def _finding(
    source: str, at: Place, line: str, message: str, *, expected: str = "", hint: str = ""
) -> Diagnostic:
    cut = line[: max(100, at.column + 20)]
    shown = "".join(c if c.isprintable() else " " if c == "\t" else "\ufffd" for c in cut).rstrip()
    return Diagnostic(
        source=source,
        line=at.line,
        column=at.column,
        message=message,
        expected=expected,
        hint=hint,
        excerpt=shown if at.column <= min(200, len(shown) + 1) else "",
    )
