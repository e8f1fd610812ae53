"""`ccas sweep`, as it is typed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from . import ccas

SPEC = """schema: ccas/sweep@1
name: tiny
executor: local:1
rulesets: [tran2026, bpr]
cells:
  - {name: head_on, draw: head_on, count: 2}
  - {name: ignored, draw: crossing, breach: ignores}
"""


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    file = tmp_path / "tiny.yaml"
    file.write_text(SPEC, encoding="utf-8")
    return file


def test_a_sweep_can_be_begun_with_few_cases_and_finished_later(spec: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"

    few = ccas("sweep", spec, "--limit", "1", "--ruleset", "tran2026", "--seed", "3", "--out", out, "--json")
    all_ = ccas("sweep", spec, "--ruleset", "tran2026", "--seed", "3", "--out", out, "--parquet")

    assert (few.exit_code, all_.exit_code) == (0, 0)
    first, ignored = json.loads(few.stdout)["cells"]
    assert (first["n"], first["judged"], first["faithful"], first["restless"]) == (1, 1, 1, 0)
    assert (ignored["judged"], ignored["avoidable"], ignored["avoidable_collisions"]) == (0, 1, 0)
    assert "2 of 3 cases (2 from the journal)" in all_.stderr
    assert "report:" in all_.stdout
    assert {file.name for file in out.iterdir()} == {
        *("cases.csv", "cases.parquet", "summary.json", "report.html", "worst", "journal.jsonl")
    }


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--limit", "0"), "--limit"),
        (("--ruleset", "tran2027"), "did you mean"),
        (("--executor", "cloud"), "local, local:N with N at least 1"),
        (("--seed", "-1"), "--seed"),
    ],
)
def test_what_cannot_be_meant_is_refused(
    spec: Path, tmp_path: Path, arguments: tuple[str, str], said: str
) -> None:
    done = ccas("sweep", spec, *arguments, "--out", tmp_path / "out")

    assert done.exit_code == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
