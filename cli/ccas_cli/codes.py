"""`ccas code`: the page of a code that a finding has."""

from __future__ import annotations

import dataclasses
from typing import Annotated

import typer

from ccas_core.errors import Diagnostic, InputError, did_you_mean

from . import talk


def code(
    wanted: Annotated[
        str | None,
        typer.Argument(
            metavar="CODE", help="A code such as R102; without it, all are listed.", show_default=False
        ),
    ] = None,
    as_json: talk.AsJson = False,
) -> None:
    """Explain a code that a finding of `ccas check` has.

    The page says what the finding means, gives an example to avoid and one to prefer, and says why. Codes
    with R are remarks: the file can be used. Codes with E are errors.

    Example:
        ccas code R102
    """
    from ccas_core.tapd.code_pages import code_pages, page_text

    pages = code_pages()
    if wanted is None:
        if as_json:
            talk.show_json([dataclasses.asdict(page) for page in pages.values()])
        else:
            talk.show_table(("code", "meaning"), [(page.code, page.title) for page in pages.values()])
        return
    page = pages.get(wanted.upper())
    if page is None:
        hint = did_you_mean(wanted.upper(), pages)
        raise InputError(Diagnostic(source="CODE", message=f"there is no code '{wanted}'", hint=hint))
    if as_json:
        talk.show_json(dataclasses.asdict(page))
    else:
        talk.show(page_text(page).rstrip())
