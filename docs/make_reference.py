"""Write the pages that are made from what the program knows: `facts.md` and `codes.md`.

.venv/bin/python docs/make_reference.py
"""

from __future__ import annotations

from pathlib import Path

from ccas_core.tapd.code_pages import code_pages, codes_page
from ccas_core.tapd.facts_page import facts_page
from ccas_core.tapd.vocabulary import VOCABULARY

HERE = Path(__file__).parent
PAGES = {
    HERE / "facts.md": lambda: facts_page(VOCABULARY),
    HERE / "codes.md": lambda: codes_page(code_pages().values()),
}

if __name__ == "__main__":
    for page, made in PAGES.items():
        page.write_text(made(), encoding="utf-8", newline="\n")
