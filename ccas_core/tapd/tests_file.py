"""Tests of a ruleset in a file beside it: `bpr.tests.yaml` beside `bpr.yaml`, read when asked for."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Final

from ..errors import RulesetError
from ..findings import read_text
from ..strict_yaml import Reader
from .case_file import read_tests
from .cases import Case
from .vocabulary import Vocabulary

SCHEMA: Final = "ccas/ruleset-tests@1"
SUFFIX: Final = ".tests.yaml"


def beside(source: str) -> Path:
    """Where the tests of a ruleset file would stand.

    >>> beside("rules/bpr.yaml").as_posix()
    'rules/bpr.tests.yaml'
    """
    return Path(source).with_suffix(SUFFIX)


def tests_beside(source: str, ruleset: str, vocabulary: Vocabulary) -> Callable[[], tuple[Case, ...]]:
    """Give the tests beside a ruleset file when they are asked for; none where there is no such file."""

    @cache
    def read() -> tuple[Case, ...]:
        path = beside(source)
        if not path.is_file():
            return ()
        named, cases = parse_tests(read_text(path, RulesetError), str(path), vocabulary)
        return cases if named == ruleset else ()

    return read


def parse_tests(text: str, source: str, vocabulary: Vocabulary) -> tuple[str, tuple[Case, ...]]:
    """Read the text of a file of tests: the id of the ruleset, and the tests.

    Raises
    ------
    RulesetError
        With all that is wrong.
    """
    reader = Reader(text, source, RulesetError)
    root = reader.document(SCHEMA)
    ruleset = reader.text(root.require("ruleset"))
    cases = read_tests(reader, root.require("tests"), ruleset, vocabulary)
    root.done()
    reader.finish()
    return ruleset, cases
