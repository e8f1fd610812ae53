"""Rulesets by id, each read when it is first asked for.

A file that cannot be understood makes its ruleset unavailable, and no other.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from ..errors import Diagnostic, RulesetError, did_you_mean
from ..findings import read_text
from .python_rules import PythonRule
from .ranking import RankingCriterion
from .ruleset import AbstractRuleset
from .vocabulary import VOCABULARY, Vocabulary

_ID: Final = re.compile(r"^id:[ \t]*[\"']?([^\s\"'#]+)", re.MULTILINE)
_ABSTRACT: Final = re.compile(r"^abstract:[ \t]*true\b", re.MULTILINE)


class RulesetLibrary(Mapping[str, AbstractRuleset]):
    """All rulesets that can be sailed by, by id; bases that are only there to be extended are left out.

    Parameters
    ----------
    made
        Rulesets that are there already.
    files
        Paths of ruleset files, by the ids in them (`id_in`).
    """

    def __init__(
        self,
        made: Mapping[str, AbstractRuleset] | None = None,
        files: Mapping[str, Path] | None = None,
        *,
        vocabulary: Vocabulary = VOCABULARY,
        python: Mapping[str, PythonRule] | None = None,
        criteria: Mapping[str, RankingCriterion] | None = None,
    ) -> None:
        self._made = dict(made or {})
        self._files = dict(files or {})
        self._texts = {id_: read_text(path, RulesetError) for id_, path in self._files.items()}
        self._ids = sorted(
            {*self._made, *(id_ for id_, text in self._texts.items() if not _ABSTRACT.search(text))}
        )
        self.vocabulary = vocabulary
        self._python, self._criteria = dict(python or {}), dict(criteria or {})

    def __getitem__(self, id_: str) -> AbstractRuleset:
        """Ruleset by its id.

        Raises
        ------
        KeyError
            If there is none.
        RulesetError
            If its file cannot be understood.
        """
        if id_ not in self._made:
            if id_ not in self._ids:
                raise KeyError(id_)
            self._made[id_] = self.parsed(self._texts[id_], str(self._files[id_]))
        return self._made[id_]

    def __contains__(self, id_: object) -> bool:
        return id_ in self._made or id_ in self._ids

    def __iter__(self) -> Iterator[str]:
        return iter(self._ids)

    def __len__(self) -> int:
        return len(self._ids)

    def parsed(self, text: str, source: str) -> AbstractRuleset:
        """Read the text of a ruleset file, which may extend any ruleset of the library."""
        from .ruleset_file import parse_ruleset

        return parse_ruleset(text, source, self.text_of, self.vocabulary, self._python, self._criteria)

    def loaded(self, path: Path) -> AbstractRuleset:
        """Read a ruleset file that is not part of the library; from now on it stands for the id in it."""
        found = self.parsed(read_text(path, RulesetError), str(path))
        self._made[found.id] = found
        self._ids = sorted({*self._ids, found.id})
        return found

    def text_of(self, id_: str) -> tuple[str, str]:
        """Text and path of a ruleset file; `KeyError`, with a hint, where there is none."""
        if id_ not in self._files:
            raise KeyError(did_you_mean(id_, self._files))
        return self._texts[id_], str(self._files[id_])

    def path(self, id_: str) -> Path | None:
        """File of a ruleset; None where it has none."""
        return self._files.get(id_)


def id_in(path: Path) -> str:
    """Id that a ruleset file gives itself, without reading the rest of it.

    Raises
    ------
    RulesetError
        If the file cannot be read, or names none.
    """
    text = read_text(path, RulesetError)
    found = _ID.search(text)
    if found is None:
        hint = "a ruleset file begins with 'schema: ccas/ruleset@1' and 'id: …'"
        raise RulesetError(Diagnostic(source=str(path), message="the file names no ruleset", hint=hint))
    return found[1]
