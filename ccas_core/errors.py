"""What went wrong for the user, with place, cause and hint.

A `Diagnostic` is one finding in a file; an `InputError` carries all of a file's findings at
once.  A solver that fails is not an error but an `Outcome` (`ccas_core.dmpc.outcome`).
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnostic:
    """One finding: where, what was found, what was expected, and what would help.

    `line` and `column` count from 1; 0 means that the finding concerns the file as a whole.  `width` is how
    many letters are meant.  A finding with a `code` has a page of its own (`ccas code CODE`).
    """

    source: str
    line: int = 0
    column: int = 0
    message: str
    expected: str = ""
    hint: str = ""
    excerpt: str = ""
    width: int = 1
    code: str = ""

    def __str__(self) -> str:
        place = self.source if not self.line else f"{self.source}:{self.line}:{self.column}"
        code = f"[{self.code}] " if self.code else ""
        lines = [f"{place}: {code}{self.message}"]
        if self.excerpt:
            gutter = str(self.line)
            lines.append(f" {gutter} | {self.excerpt}")
            marks = "^" * max(1, min(self.width, len(self.excerpt) - self.column + 1))
            lines.append(f" {' ' * len(gutter)} | {' ' * (self.column - 1)}{marks}")
        if self.expected:
            lines.append(f"    expected: {self.expected}")
        if self.hint:
            lines.append(f"    hint: {self.hint}")
        return "\n".join(lines)


class CcasError(Exception):
    """Base of all errors that concern the user, not a fault of the program."""


class InputError(CcasError):
    """A file or an argument that cannot be used; carries every finding as a `Diagnostic`."""

    def __init__(self, *diagnostics: Diagnostic) -> None:
        self.diagnostics = diagnostics
        super().__init__("\n".join(str(each) for each in diagnostics))


class ScenarioError(InputError):
    """A scenario that cannot be sailed."""


class RulesetError(InputError):
    """A ruleset that is unknown, or that cannot be understood."""


class PluginError(CcasError):
    """A plugin that cannot be used; `plugin` names the culprit."""

    def __init__(self, plugin: str, message: str) -> None:
        self.plugin = plugin
        super().__init__(f"plugin {plugin!r}: {message}")


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Say which known words are nearest to `word`, or list them all.

    >>> did_you_mean("lenght", ["length", "beam"])
    "did you mean 'length'?"
    >>> did_you_mean("xyz", ["length", "beam"])
    'known: beam, length'
    >>> did_you_mean("xyz", [])
    'there are none'
    """
    names = sorted(known)
    if not names:
        return "there are none"
    near = difflib.get_close_matches(word, names, n=1)
    return f"did you mean '{near[0]}'?" if near else f"known: {', '.join(names)}"
