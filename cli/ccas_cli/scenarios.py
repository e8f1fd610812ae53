"""`ccas scenarios`: the scenarios that are shipped."""

from __future__ import annotations

from . import talk


def scenarios(as_json: talk.AsJson = False) -> None:
    """List the scenarios and sweeps that are shipped, each with its title.

    They are in sets: `tran2026` holds those of the paper, `sweeps` those for `ccas sweep`. Other commands
    take the whole name, as 'tran2026/fig_12', or its last part where that is enough.

    Example:
        ccas scenarios --json
    """
    import ccas_scenarios

    rows = [{"name": name, "title": _title(name)} for name in ccas_scenarios.names()]
    if as_json:
        talk.show_json(rows)
    else:
        talk.show_table(("name", "title"), [tuple(row.values()) for row in rows])


def _title(name: str) -> str:
    """Title of a shipped scenario, without reading the rest of it."""
    import ccas_scenarios
    from ccas_core.findings import read_text
    from ccas_core.strict_yaml import Reader

    path = ccas_scenarios.path(name)
    reader = Reader(read_text(path), str(path))
    block = reader.block(reader.root)
    title = block.find("title") or block.find("name")
    return reader.text(title) if title else ""
