"""`ccas schema`: the JSON Schema by which editors help."""

from __future__ import annotations

import json
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ccas_core.errors import Diagnostic, InputError

from . import inputs, talk

if TYPE_CHECKING:
    from ccas_core.tapd.vocabulary import Vocabulary


class Kind(StrEnum):
    """Kinds of files that have a schema."""

    RULESET = "ruleset"


def schema(
    context: typer.Context,
    kind: Annotated[Kind, typer.Argument(metavar="[ruleset]", help="The kind of file.")] = Kind.RULESET,
    write: Annotated[
        Path | None,
        typer.Option(
            "--write",
            metavar="PATH",
            help="Write it to this file, or into this folder under its usual name.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Print the JSON Schema (draft 7) of ruleset files: every key with its meaning, all words allowed.

    An editor that reads it completes keys and tells what is wrong while one writes; the file names it on its
    first line: '# yaml-language-server: $schema=./ccas-ruleset-1.schema.json'. Facts of installed plugins
    are in it.

    Example:
        ccas schema ruleset --write .
    """
    from ccas_core.tapd.ruleset_schema import FILE_NAME

    del kind  # there is one, so far
    text = schema_text(inputs.load_plugins(context).vocabulary)
    if write is None:
        talk.show(text)
        return
    path = write / FILE_NAME if write.is_dir() else write
    try:
        path.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(
            Diagnostic(source=str(path), message=f"cannot be written: {error.strerror}")
        ) from None
    talk.show(str(path))


def schema_text(vocabulary: Vocabulary) -> str:
    """Write the schema of ruleset files, with the facts of a vocabulary."""
    from ccas_core.tapd.ruleset_schema import ruleset_schema

    return json.dumps(ruleset_schema(vocabulary), indent=2, ensure_ascii=False)
