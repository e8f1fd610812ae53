"""Scenarios shipped with CCAS, as YAML files in sets, and how to find one by its name."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from ccas_core.errors import Diagnostic, ScenarioError, did_you_mean


def names() -> tuple[str, ...]:
    """Names of all shipped scenarios, as 'set/name', sorted.

    >>> "tran2026/fig_12" in names()
    True
    """
    folder = _folder()
    return tuple(
        sorted(file.relative_to(folder).with_suffix("").as_posix() for file in folder.glob("*/*.yaml"))
    )


def path(name: str) -> Path:
    """Find the file of a shipped scenario by 'set/name', or by its bare name where that is unique.

    >>> path("fig_12") == path("tran2026/fig_12")
    True

    Raises
    ------
    ScenarioError
        No scenario has this name, or several sets have one of it.
    """
    known = names()
    found = [each for each in known if name in {each, each.rpartition("/")[2]}]
    if len(found) == 1:
        return _folder() / f"{found[0]}.yaml"
    if found:
        message = "several shipped scenarios have this name"
        raise ScenarioError(Diagnostic(source=name, message=message, expected=f"one of {', '.join(found)}"))
    alike = known if "/" in name else {each.rpartition("/")[2] for each in known}
    message = "no shipped scenario has this name"
    raise ScenarioError(Diagnostic(source=name, message=message, hint=did_you_mean(name, alike)))


def _folder() -> Path:
    return Path(str(resources.files(__name__)))
