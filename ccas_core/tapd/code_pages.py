"""A page for each code of a finding, read from `codes.yaml`: what it means, an example, and why.

A remark (R) is a doubt: the file can be used.  An error (E) has no code where it is found, but is known by
what it says (`coded`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Final

from ..errors import Diagnostic
from ..findings import read_text
from ..strict_yaml import Reader

_FILE: Final = Path(__file__).with_name("codes.yaml")
_HEAD: Final = """\
# Codes of findings

What `ccas check` says of ruleset files and encounter files.  A remark (R) is a doubt: the file can be used,
and the exit code is 1.  An error (E) makes it unusable, and the exit code is 2.  `ccas code CODE` prints
one of these pages.  Examples are pieces of ruleset files, or of encounter files where they begin with
`cases`.

This page is made by `docs/make_reference.py` from what the program knows.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class CodePage:
    """The page of one code; `says` is a pattern for the messages of an error."""

    code: str
    title: str
    meaning: str
    avoid: str
    prefer: str
    why: str
    says: str = ""

    @property
    def is_remark(self) -> bool:
        """Whether a file with this finding can be used all the same."""
        return self.code.startswith("R")


@cache
def code_pages() -> dict[str, CodePage]:
    """All pages, by code."""
    reader = Reader(read_text(_FILE), str(_FILE))
    pages = []
    for item in reader.items(reader.root):
        block = reader.block(item)
        texts = {key: reader.text(block.require(key)) for key in ("code", "title", "meaning", "why")}
        examples = {key: reader.text(block.require(key)).rstrip() for key in ("avoid", "prefer")}
        says = block.find("says")
        pages.append(CodePage(**texts, **examples, says=reader.text(says) if says else ""))
        block.done()
    reader.finish()
    return {page.code: page for page in pages}


def coded(finding: Diagnostic) -> Diagnostic:
    """Give an error its code, by what it says; one without a page has none."""
    finding = _marked(finding)
    if finding.code:
        return finding
    for code, pattern in _patterns():
        if pattern.match(finding.message):
            return replace(finding, code=code)
    return finding


def _marked(finding: Diagnostic) -> Diagnostic:
    """Mark the whole of a word that the finding quotes, if it stands at its place."""
    if finding.width > 1:
        return finding
    rest = finding.excerpt[finding.column - 1 :] if finding.column else ""
    words = re.findall(r"'([^']+)'", finding.message)
    width = next((len(word) for word in words if rest.lstrip("'\"").startswith(word)), 1)
    return replace(finding, width=width)


@cache
def _patterns() -> tuple[tuple[str, re.Pattern[str]], ...]:
    return tuple((page.code, re.compile(page.says)) for page in code_pages().values() if page.says)


def page_text(page: CodePage) -> str:
    """One page, in Markdown."""
    examples = "".join(
        f"\n{word}:\n\n```yaml\n{example}\n```\n"
        for word, example in (("Avoid", page.avoid), ("Prefer", page.prefer))
    )
    return f"## {page.code}: {page.title}\n\n{page.meaning}\n{examples}\n{page.why}\n"


def codes_page(pages: Iterable[CodePage]) -> str:
    """All pages as one, in Markdown."""
    return "\n".join([_HEAD, *map(page_text, pages)])
