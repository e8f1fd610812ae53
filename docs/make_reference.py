"""Write the pages that are made from what the program knows: `facts.md`, `codes.md`, the keys of rulesets.

.venv/bin/python docs/make_reference.py
"""

from __future__ import annotations

import re
from pathlib import Path

from ccas_core.tapd.code_pages import code_pages, codes_page
from ccas_core.tapd.facts_page import facts_page
from ccas_core.tapd.ruleset_keys import reference
from ccas_core.tapd.vocabulary import VOCABULARY

HERE = Path(__file__).parent
FORMAT = HERE / "ruleset-format.md"
KEYS = re.compile(
    r"(?<=<!-- keys: made by docs/make_reference.py -->\n).*(?=\n<!-- end of keys -->)", re.DOTALL
)


def format_page() -> str:
    """Put the tables of keys into the page on the format, in place of those that are there."""
    return KEYS.sub(lambda _: reference(), FORMAT.read_text(encoding="utf-8"))


PAGES = {
    HERE / "facts.md": lambda: facts_page(VOCABULARY),
    HERE / "codes.md": lambda: codes_page(code_pages().values()),
    FORMAT: format_page,
}

if __name__ == "__main__":
    for page, made in PAGES.items():
        page.write_text(made(), encoding="utf-8", newline="\n")
