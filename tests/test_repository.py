"""The repository itself: fit for anybody's machine, and true to what it says of itself."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = ("ccas_core", "rulesets", "plugins", "cli", "scenarios", "tests", "studies")
FOLDERS = ("rulesets", "plugins", "cli", "scenarios")
DOCUMENTS = (
    "README.md",
    "CONTRIBUTING.md",
    "plugins/example_harbour/README.md",
    "docs/plugins.md",
    "docs/write-a-ruleset.md",
    *(f"{folder}/README.md" for folder in FOLDERS),
)

MACHINE_PATH = re.compile(r"(?<![\w.])(/(home|root|tmp|work|Users|opt|mnt)/\w|[A-Z]:\\\\?Users\b)")
REGISTRY_HOST = re.compile(
    r"pypi\.org|pythonhosted\.org|conda\.anaconda\.org|npmjs\.org|index[-]url|find[-]links"
)

# Equation of Tran, Johansen, Negenborn (2026) -> the module that is its home.
HOMES = {
    "1": "ccas_core/dmpc/nadmm.py",
    "2": "ccas_core/dmpc/nadmm.py",
    "3": "ccas_core/tapd/facts.py",
    "4": "ccas_core/dmpc/kinematics.py",
    "5": "ccas_core/dmpc/kinematics.py",
    "6": "ccas_core/dmpc/risk.py",
    "7": "ccas_core/dmpc/cost.py",
    "8": "ccas_core/dmpc/cost.py",
    "9": "ccas_core/dmpc/cost.py",
    "10": "ccas_core/dmpc/local_problem.py",
    "11": "ccas_core/dmpc/local_problem.py",
    "12": "ccas_core/dmpc/local_problem.py",
    "13": "ccas_core/dmpc/nadmm.py",
    "13b": "ccas_core/dmpc/local_problem.py",
    "A.3": "ccas_core/dmpc/nadmm.py",
}
CLAIM = re.compile(r"Eq\.\s+\(([\w.]+)\)((?:(?:,|,? and| to)\s+(?:Eq\.\s+)?\([\w.]+\))*)")


def files() -> list[Path]:
    """All files that are in the repository, or would be with the next commit."""
    git = shutil.which("git")
    if git is None or not (ROOT / ".git").exists():
        pytest.skip("not a clone of the repository")
    command = (git, "ls-files", "-z", "--cached", "--others", "--exclude-standard")
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [ROOT / name for name in listed.split("\0") if name and (ROOT / name).is_file()]


def lines() -> Iterator[tuple[str, str]]:
    """All lines of all text files, each with its place."""
    for file in files():
        content = file.read_bytes()
        if b"\0" in content:
            continue
        for number, line in enumerate(content.decode("utf-8").splitlines(), start=1):
            yield f"{file.relative_to(ROOT)}:{number}", line


@pytest.fixture(scope="module")
def docstrings() -> dict[str, str]:
    """All modules with their docstrings; folders of tests are named after what they test."""
    found = (file for folder in SOURCES for file in sorted((ROOT / folder).rglob("*.py")))
    trees = {file.relative_to(ROOT): ast.parse(file.read_text(encoding="utf-8")) for file in found}
    return {
        file.as_posix(): ast.get_docstring(tree) or ""
        for file, tree in trees.items()
        if file.parts[0] != "tests" or file.name != "__init__.py"
    }


@pytest.fixture(scope="module")
def explained() -> str:
    """What `ccas --help` says."""
    program = "import sys; from ccas_cli.main import main; sys.exit(main())"
    environment = {**os.environ, "COLUMNS": "200", "NO_COLOR": "1"}
    command = (sys.executable, "-c", program, "--help")
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout


def claims(text: str) -> set[str]:
    """Read the equations that a docstring claims.

    >>> sorted(claims("Eq. (1) and (2), then Eq. (7) to (9)"))
    ['1', '2', '7', '8', '9']
    """
    claimed: set[str] = set()
    for first, more in CLAIM.findall(text):
        previous = first
        claimed.add(first)
        for word, number in re.findall(r"(and|to|,)\s+(?:Eq\.\s+)?\(([\w.]+)\)", more):
            span = range(int(previous), int(number)) if word == "to" else ()
            claimed.update({number, *map(str, span)})
            previous = number
    return claimed


def commands_of(program: str, document: str) -> set[str]:
    """Sub-commands of a program that a document shows in its code: fenced, indented, or in a line."""
    text = (ROOT / document).read_text(encoding="utf-8")
    code = re.findall(r"```.*?```|^ {4}.*?$|`[^`\n]+`", text, flags=re.MULTILINE | re.DOTALL)
    command = re.compile(rf"(?:^|`|\$)\s*{program} ([a-z][a-z-]*)", flags=re.MULTILINE)
    return {found for piece in code for found in command.findall(piece)}


def targets() -> set[str]:
    return set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE))


def test_no_file_names_a_path_of_one_machine() -> None:
    assert [place for place, line in lines() if MACHINE_PATH.search(line)] == []


def test_no_file_names_a_package_registry() -> None:
    assert [place for place, line in lines() if REGISTRY_HOST.search(line)] == []


def test_every_module_says_what_it_is(docstrings: dict[str, str]) -> None:
    assert [name for name, docstring in docstrings.items() if not docstring] == []


@pytest.mark.parametrize(("equation", "home"), HOMES.items())
def test_equation_has_one_home_that_claims_it(equation: str, home: str, docstrings: dict[str, str]) -> None:
    summaries = {name: docstring.partition("\n\n")[0] for name, docstring in docstrings.items()}
    library = {name: text for name, text in summaries.items() if not name.startswith(("tests/", "studies/"))}

    assert home in docstrings
    assert equation in claims(docstrings[home])
    assert [name for name, text in library.items() if equation in claims(text) and name != home] == []


@pytest.mark.parametrize("document", ["README.md", "CONTRIBUTING.md"])
def test_make_commands_of_the_documents_are_in_the_makefile(document: str) -> None:
    commands = commands_of("make", document)

    assert {"demo", "test"} <= commands
    assert commands <= targets()


@pytest.mark.parametrize("document", DOCUMENTS)
def test_ccas_commands_of_the_documents_are_in_the_program(document: str, explained: str) -> None:
    unknown = {each for each in commands_of("ccas", document) if not re.search(rf"\b{each}\b", explained)}

    assert unknown == set()


def test_continuous_check_is_the_test_command_of_the_readme() -> None:
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")

    assert script.rstrip().endswith("exec make test")


@pytest.mark.parametrize("folder", FOLDERS)
def test_folder_says_what_it_is(folder: str) -> None:
    text = (ROOT / folder / "README.md").read_text(encoding="utf-8")

    assert text.startswith(f"# {folder}: ")
