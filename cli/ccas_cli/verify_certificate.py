"""`ccas verify-certificate`: whether a certificate proves what it says, by arithmetic alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from ccas_core.errors import InputError
from ccas_core.findings import read_text

from . import inputs, talk
from .consistency import written_ruleset
from .exits import Code


def verify_certificate(
    context: typer.Context,
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="The certificate, a JSON file.", show_default=False)
    ],
    ruleset: Annotated[
        str | None,
        typer.Argument(
            metavar="[RULESET]",
            help="Id of the ruleset, or path of its file; left out, the one that the certificate names.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Verify a certificate of `ccas check-consistency --certificate`, with fractions and without a solver.

    What must be impossible is made anew from the ruleset; of the certificate only the reasons are taken, each
    of them an identity of polynomials. Exit code 0 if all of it holds, 1 if anything does not.

    Example:
        ccas check-consistency bpr --certificate bpr.json
        ccas verify-certificate bpr.json
    """
    from ccas_core.proofs.certificate_check import CertificateError, verify

    text = read_text(file, InputError)
    name = ruleset or _named(text)
    judged = written_ruleset(inputs.load_plugins(context), name)
    try:
        covered = verify(text, judged)
    except CertificateError as error:
        talk.note(f"{file}: refused")
        talk.note(str(error))
        raise typer.Exit(Code.FINDINGS) from None
    talk.show(f"{judged.id} {judged.version}: the certificate holds")
    for each in covered:
        talk.show(f"    {each}")


def _named(text: str) -> str:
    """Id of the ruleset that a certificate names; nothing, of which there is no ruleset, if it names none."""
    try:
        document: Any = json.loads(text)
        return str(document["ruleset"])
    except (ValueError, LookupError, TypeError):
        return ""
