"""`ccas diff`: where two rulesets disagree, with an example for each pair of articles."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ccas_core.errors import Diagnostic, InputError

from . import inputs, talk
from .exits import Code

if TYPE_CHECKING:
    from ccas_core.plugins import Plugins
    from ccas_core.sim.scenario import Scenario
    from ccas_core.tapd.cases import Case
    from ccas_core.tapd.comparison import Disagreement, Group
    from ccas_core.tapd.ruleset import PairRuleset


def diff(
    context: typer.Context,
    one: Annotated[str, typer.Argument(metavar="A", help="Id of a ruleset, or path of its file.")],
    other: Annotated[str, typer.Argument(metavar="B", help="The other one.")],
    cases: Annotated[
        list[Path] | None,
        typer.Option("--cases", metavar="FILE", help="Encounter files to compare on.", show_default=False),
    ] = None,
    samples: Annotated[int, typer.Option(help="Encounters made at random.", min=0)] = 2000,
    seed: Annotated[int, typer.Option(help="Seed of these.", min=0)] = 0,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Write the examples into this folder.", show_default=False),
    ] = None,
    as_json: talk.AsJson = False,
) -> None:
    """Tell where two rulesets disagree, grouped by the articles behind it, with an example each.

    They are compared on the tests of both, on encounter files, and on encounters made at random over the
    facts that the two ask for: half of them with a stated geometry, half with ships under way. Each example
    states no more than it needs. With --out it is written as an encounter file, which `ccas test` reads;
    where the ships are under way also as a scenario, which `ccas simulate` sails. Exit code 1 if they
    disagree.

    Example:
        ccas diff bpr tran2026 --out differences
        ccas diff old/harbour.yaml new/harbour.yaml --cases encounters.yaml
    """
    from ccas_core.tapd.comparison import compare

    plugins = inputs.load_plugins(context)
    rulesets = _of_pairs(plugins, one), _of_pairs(plugins, other)
    compared = compare(*rulesets, _cases(plugins, rulesets, cases or (), samples, seed))
    told = [
        _told(plugins, rulesets, group, number, out) for number, group in enumerate(compared.groups, start=1)
    ]
    if as_json:
        head = {"one": _named(rulesets[0]), "other": _named(rulesets[1])}
        counts = {"tried": compared.tried, "differing": compared.differing}
        talk.show_json({**head, "seed": seed, **counts, "groups": told})
    else:
        for each in told:
            _show(each)
        names = " and ".join(f"{each.id} {each.version}" for each in rulesets)
        where = f" in {talk.one_or_more(len(told), 'pair')} of articles" if told else ""
        talk.show(f"{names}: {compared.differing} of {compared.tried} encounters judged differently{where}")
    if compared.groups:
        raise typer.Exit(Code.FINDINGS)


def _of_pairs(plugins: Plugins, name: str) -> PairRuleset:
    from ccas_core.tapd.ruleset import PairRuleset

    ruleset = plugins.ruleset(name)
    if not isinstance(ruleset, PairRuleset):
        message = "it orders whole groups of ships, and judges no pairs"
        raise InputError(Diagnostic(source=name, message=message, hint="sail by it with `ccas simulate`"))
    return ruleset


def _named(ruleset: PairRuleset) -> dict[str, str]:
    return {"id": ruleset.id, "version": ruleset.version}


def _cases(
    plugins: Plugins, rulesets: tuple[PairRuleset, ...], files: Iterable[Path], samples: int, seed: int
) -> Iterator[Case]:
    """Encounters at hand, then generated ones."""
    import numpy as np

    from ccas_core.tapd.case_file import load_cases
    from ccas_core.tapd.generated import asked_by, encounters
    from ccas_core.tapd.written import WrittenRuleset

    for ruleset in rulesets:
        if isinstance(ruleset, WrittenRuleset):
            yield from ruleset.text.tests
    for file in files:
        read = load_cases(file, plugins.vocabulary)
        if read.findings:
            raise InputError(*read.findings)
        yield from (case for case in read.cases if case.ships)
    yield from islice(encounters(asked_by(*rulesets), np.random.default_rng(seed)), samples)


def _told(
    plugins: Plugins, rulesets: tuple[PairRuleset, ...], group: Group, number: int, out: Path | None
) -> dict[str, Any]:
    from ccas_core.tapd.case_dump import case_tree

    example = group.example
    said = _said(rulesets, example)
    return {
        "what": example.what,
        "count": group.count,
        "one": _view(example.one),
        "other": _view(example.other),
        "example": case_tree(example.case, said, plugins.vocabulary),
        "files": _written(plugins, rulesets, group, number, out) if out else [],
    }


def _said(rulesets: tuple[PairRuleset, ...], example: Disagreement) -> dict[str, Any]:
    """What the rulesets say, by their ids; of two versions of one, what the second says."""
    return {rulesets[0].id: example.one, rulesets[1].id: example.other}


def _view(view: Mapping[str, Any]) -> dict[str, Any]:
    keys = ("article", "by", "kind", "give_way", "stand_on", "initiator", "pass", "reason")
    return {key: view[key] for key in keys}


def _written(
    plugins: Plugins, rulesets: tuple[PairRuleset, ...], group: Group, number: int, out: Path
) -> list[str]:
    """Write the example of a group as an encounter file, and one with ships under way as a scenario."""
    from ccas_core.sim.scenario_dump import dump_scenario
    from ccas_core.tapd.case_dump import dump_cases

    out.mkdir(parents=True, exist_ok=True)
    example = group.example
    case = replace(example.case, id=f"difference_{number}", title=_title(example))
    text = dump_cases([(case, _said(rulesets, example))], plugins.vocabulary)
    files = {out / f"{number:03}.yaml": text}
    for moving in group.moving:
        case = replace(moving.case, id=f"difference {number}", title=_title(moving))
        if (scenario := _replayed(rulesets, case)) is not None:
            files[out / f"{number:03}.scenario.yaml"] = dump_scenario(scenario, plugins.vocabulary)
            break
    for path, content in files.items():
        path.write_text(content, encoding="utf-8")
    return [str(path) for path in files]


def _title(example: Disagreement) -> str:
    return " against ".join(f"{view['article']}: {view['kind']}" for view in (example.one, example.other))


def _replayed(rulesets: tuple[PairRuleset, ...], case: Case) -> Scenario | None:
    """A scenario in which the rulesets disagree at the start; None where on a chart they do not."""
    from ccas_core.sim.case_scenario import scenario_of
    from ccas_core.sim.start import settlements_at_start

    scenario = scenario_of(case, rulesets[0].id)
    said = []
    for ruleset in rulesets:
        under = replace(scenario, waters=replace(scenario.waters, ruleset=ruleset.id))
        (settlement,) = settlements_at_start(under, {ruleset.id: ruleset})
        said.append((settlement.one.kind, settlement.one.passing_side, settlement.one.initiator))
    return scenario if said[0] != said[1] else None


def _show(told: Mapping[str, Any]) -> None:
    talk.show(f"{talk.one_or_more(told['count'], 'encounter')}, the {told['what']} differs")
    for side in ("one", "other"):
        talk.show(f"    {told[side]['article'] or 'no article'}: {_words(told[side])}")
    example = {
        key: value for key, value in told["example"].items() if key in ("waterway", "encounter", "ships")
    }
    from ccas_core.tapd.case_dump import flow

    for key, value in example.items():
        talk.show(f"    {key}: {flow(value)}")
    for file in told["files"]:
        talk.show(f"    written: {file}")
    talk.show("")


def _words(view: Mapping[str, Any]) -> str:
    if view["kind"] == "give_way":
        duty = f"{view['give_way'][0]} gives way"
    elif view["kind"] in ("cooperate", "prohibited"):
        duty = f"{view['kind']}, {view['initiator']} begins"
    else:
        duty = str(view["kind"])
    return duty + (f", passing {view['pass'].replace('_', ' ')}" if view["pass"] else "")
