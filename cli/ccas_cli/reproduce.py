"""`ccas reproduce`: the cases of the two papers sailed anew, figures drawn, claims checked."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from . import inputs, talk
from .exits import Code, answered
from .reproduction import CASES, Reproduction


@answered
def reproduce(
    context: typer.Context,
    case: Annotated[
        str, typer.Argument(metavar="[CASE]", help="table-2, fig-5 to fig-14, wait, sim-1 to sim-5, or all.")
    ] = "all",
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where pictures go.")] = Path(
        "reproduction"
    ),
    solver: inputs.SolverName = None,
    as_json: talk.AsJson = False,
) -> None:
    """Sail the papers' cases anew, draw their figures, and check what their texts claim.

    table-2, fig-5 to fig-14 and wait: Tran et al. 2026. sim-1 to sim-5: the dynamic bumper MPC. Prints our
    figures beside the paper's, then one line for each claim. Exit code 1 if a claim fails.

    Example:
        ccas reproduce table-2
        ccas reproduce fig-12 --out pictures
        ccas reproduce all --solver ipopt
    """
    from ccas_core.errors import Diagnostic, InputError, did_you_mean

    if case != "all" and case not in CASES:
        hint = did_you_mean(case, [*CASES, "all"])
        raise InputError(Diagnostic(source="reproduce", message=f"unknown case {case!r}", hint=hint))
    plugins = inputs.load_plugins(context)
    ready = inputs.ready_solver(solver)
    made = Reproduction(
        rulesets=plugins.rulesets,
        solver_name=ready.name,
        solver=ready,
        out=out,
        json=as_json,
        controllers=plugins.controllers,
    )
    for name, do in CASES.items():
        if case in (name, "all"):
            do(made)
    failed = sum(not claim.holds for claims in made.findings.values() for claim in claims)
    if as_json:
        claims = {
            name: [{"text": claim.text, "holds": claim.holds} for claim in found]
            for name, found in made.findings.items()
        }
        talk.show_json(
            {"case": case, "solver": ready.name, "data": made.data, "claims": claims, "failed": failed}
        )
    else:
        talk.show(f"\n{sum(map(len, made.findings.values()))} claims, {failed} failed")
    if failed:
        raise typer.Exit(Code.FINDINGS)
