"""`ccas new`: a ruleset file, or a plugin, to begin with."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from ccas_core.errors import Diagnostic, InputError

from . import inputs, talk
from .schema import schema_text

if TYPE_CHECKING:
    from ccas_core.plugins import Plugins

_NAME: Final = re.compile(r"[a-z][a-z0-9]*(?:[_-][a-z0-9]+)*")
_NOT_TEXTS: Final = ("null", "true", "false")  # in YAML
_BASE: Final = "common"
_TEMPLATES: Final = Path(__file__).with_name("templates")

Folder = Annotated[
    Path | None,
    typer.Option(
        "--out", metavar="DIR", help="Folder to write into, else the present one.", show_default=False
    ),
]


def ruleset(
    context: typer.Context,
    name: Annotated[str, typer.Argument(metavar="ID", help="Id of the ruleset.", show_default=False)],
    extends: Annotated[
        str, typer.Option("--extends", metavar="BASE", help="Ruleset on which it builds.")
    ] = _BASE,
    out: Folder = None,
) -> None:
    """Write a ruleset file to begin with, and the schema by which editors help.

    The file passes `ccas check` and `ccas test`; comments say what to change. A base with rules of its own
    makes it an overlay, which says what differs. Nothing is overwritten.

    Example:
        ccas new ruleset my_river
        ccas new ruleset my_harbour --extends bpr --out rules
    """
    from ccas_core.tapd.ruleset_schema import FILE_NAME

    _checked(name, "ruleset")
    plugins = inputs.load_plugins(context)
    if name in plugins.rulesets:
        hint = "choose another id; two rulesets of one id are refused"
        raise InputError(Diagnostic(source=name, message="there is a ruleset of this id", hint=hint))
    first = _first_rule(plugins, extends)
    folder = out or Path()
    words = {"id": name, "title": _title(name), "base": extends, "first": first}
    template = "overlay.yaml.txt" if first else "ruleset.yaml.txt"
    files = {folder / f"{name}.yaml": _filled(template, words)}
    if not (folder / FILE_NAME).exists():  # beside another ruleset, that is not a clash
        files[folder / FILE_NAME] = schema_text(plugins.vocabulary) + "\n"
    _write(files)
    path = folder / f"{name}.yaml"
    talk.note(f"next: ccas check {path}; ccas test {path}")


def plugin(
    context: typer.Context,
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the plugin.", show_default=False)],
    out: Folder = None,
) -> None:
    """Write a package that can be installed: a ruleset file, a fact, a rule in Python, tests.

    Nothing is overwritten.

    Example:
        ccas new plugin my-harbour && pip install ./ccas-my-harbour
    """
    from ccas_core.tapd.ruleset_schema import FILE_NAME

    _checked(name, "plugin")
    plugins = inputs.load_plugins(context)
    id_ = name.replace("-", "_")
    module = f"ccas_{id_}"
    package = f"ccas-{name.replace('_', '-')}"
    words = {
        "name": name,
        "id": id_,
        "module": module,
        "package": package,
        "title": _title(name),
        "rule": f"{id_}_draught",
    }
    folder = (out or Path()) / package
    code = folder / module
    _write(
        {
            folder / "pyproject.toml": _filled("plugin/pyproject.toml.txt", words),
            folder / "README.md": _filled("plugin/README.md.txt", words),
            code / "__init__.py": _filled("plugin/__init__.py.txt", words),
            code / f"{id_}.yaml": _filled("plugin/ruleset.yaml.txt", words),
            code / FILE_NAME: schema_text(plugins.vocabulary) + "\n",
            folder / "tests" / f"test_{id_}.py": _filled("plugin/test_plugin.py.txt", words),
        }
    )
    talk.note(f"next: pip install {folder}; ccas plugins --all; ccas test {id_}")


def _checked(name: str, what: str) -> None:
    if not _NAME.fullmatch(name) or name in _NOT_TEXTS or len(name) > 60:
        raise InputError(
            Diagnostic(
                source=name or "''",
                message=f"this cannot be the name of a {what}",
                expected="small letters and digits, joined by '_' or '-', such as my_river",
            )
        )


def _first_rule(plugins: Plugins, base: str) -> str:
    """First rule in the ladder of a base; empty where it has none."""
    from ccas_core.tapd.written import WrittenRuleset

    library = plugins.rulesets
    try:
        text, source = library.text_of(base)
    except KeyError as error:
        message = f"there is no ruleset file {base!r} to extend"
        raise InputError(Diagnostic(source="--extends", message=message, hint=str(error.args[0]))) from None
    found = library.parsed(text, source)
    assert isinstance(found, WrittenRuleset)  # noqa: S101 - it comes from a file
    return found.text.rules[0].id if found.text.rules else ""


def _title(name: str) -> str:
    """Title to begin with.

    >>> _title("my_river")
    'My river'
    """
    return re.sub("[_-]", " ", name).capitalize()


def _filled(template: str, words: Mapping[str, str]) -> str:
    text = (_TEMPLATES / template).read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda match: words[match[1]], text)


def _write(files: Mapping[Path, str]) -> None:
    """Write files, all or none."""
    for path in files:
        if path.exists():
            hint = "choose another name, or another folder with --out"
            raise InputError(Diagnostic(source=str(path), message="it is there already", hint=hint))
    for path, text in files.items():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            message = f"cannot be written: {error.strerror}"
            raise InputError(Diagnostic(source=str(path), message=message)) from None
        talk.show(str(path))
