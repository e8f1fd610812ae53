"""Spoil ruleset and encounter files at random, and see that they are read, or refused as they should be.

    python studies/mutate_files.py --count 10000 --seed 1
    python studies/mutate_files.py --only 1234 --seed 1     # one of them again, printed

Every file is one that we ship, or a small one, with one to three mutations: bytes flipped, lines dropped,
doubled or swapped, keys renamed, values replaced by nonsense, deep nesting, huge numbers, aliases, pieces
moved.  What comes of it must be a value that can be used, or a `RulesetError` with a finding that has a
place; nothing else, and soon.  A key that is renamed must be refused.  Mutation n of a seed is always the
same.
"""

from __future__ import annotations

import argparse
import re
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from ccas_core.errors import Diagnostic, RulesetError
from ccas_core.plugins import load
from ccas_core.ships import ShipId
from ccas_core.strict_yaml import Reader
from ccas_core.tapd.case_file import load_cases
from ccas_core.tapd.case_run import judge_case, pair_facts
from ccas_core.tapd.cases import Case, CaseShip
from ccas_core.tapd.library import RulesetLibrary
from ccas_core.tapd.ruleset_file import load_ruleset
from ccas_core.tapd.vocabulary import VOCABULARY
from ccas_core.yaml_nodes import Mapping as Keys
from ccas_core.yaml_nodes import Node, Scalar, Sequence

LIMIT: Final = 5.0  # for one file [s]
NONSENSE: Final = (
    *(
        "",
        "~",
        "true",
        "-1",
        "0",
        "1e400",
        "1e-400",
        "9" * 400,
        ".nan",
        ".inf",
        "-.inf",
        "0x1F",
        "2026-01-01",
    ),
    *(
        "own",
        "other",
        "own.length",
        "own.length < ",
        "not",
        "((((",
        "a.b.c",
        "1 m + 1 s < 3",
        "x" * 5000,
        "é",
    ),
    *("'", '"', "|", ">-", "&a b", "*a", "!!python/object:x.y {}", "<<", "{}", "[]", "[a, [b, [c]]]", "- a"),
    *(
        "{a: {b: c}}",
        "? x",
        "%",
        "@",
        "`",
        "\\u0000",
        "own == own == own",
        "true and " * 300 + "true",
        "12:30",
    ),
    *("-" * 70 + "3 < 4", "1e30 * 1e30 < 3", "tcpa * tcpa < 3", "own.heading < course_difference"),
    *("known(known)", "bearing(own, own) > 3 deg", "regime.x"),
)
# Keys below these are names that a file chooses, so that another name is no unknown key.
CHOSEN: Final = frozenset({"let", "params", "regimes", "citations", "ships", "expected", "conventions"})
# Keys below these are not read at all.
UNREAD: Final = frozenset({"about", "conventions", "kinds", "strengths", "confidence", "regime_flags"})


@dataclass(frozen=True)
class Base:
    """A file to be spoilt."""

    name: str
    text: str
    cases: bool = False  # an encounter file


@dataclass(frozen=True)
class Outcome:
    """What came of a spoilt file: nothing in `wrong` if that is as it should be."""

    what: str
    wrong: str = ""
    findings: tuple[Diagnostic, ...] = ()


# --- mutations --------------------------------------------------------------------------------------

Mutation = Callable[[bytes, np.random.Generator], bytes]


def _lines(data: bytes) -> list[bytes]:
    return data.split(b"\n")


def flip_bytes(data: bytes, generator: np.random.Generator) -> bytes:
    """Change some bytes."""
    changed = bytearray(data)
    for _ in range(int(generator.integers(1, 5))):
        if changed:
            changed[int(generator.integers(len(changed)))] ^= 1 << int(generator.integers(8))
    return bytes(changed)


def drop_lines(data: bytes, generator: np.random.Generator) -> bytes:
    """Leave out some lines that follow one another."""
    lines = _lines(data)
    at = int(generator.integers(len(lines)))
    return b"\n".join(lines[:at] + lines[at + int(generator.integers(1, 4)) :])


def double_lines(data: bytes, generator: np.random.Generator) -> bytes:
    """Write some lines twice."""
    lines = _lines(data)
    at = int(generator.integers(len(lines)))
    end = at + int(generator.integers(1, 8))
    return b"\n".join(lines[:end] + lines[at:])


def swap_lines(data: bytes, generator: np.random.Generator) -> bytes:
    """Exchange two lines."""
    lines = _lines(data)
    one, other = (int(n) for n in generator.integers(len(lines), size=2))
    lines[one], lines[other] = lines[other], lines[one]
    return b"\n".join(lines)


def move_piece(data: bytes, generator: np.random.Generator) -> bytes:
    """Take a piece out, and put it in elsewhere."""
    begin, to = (int(n) for n in generator.integers(len(data) + 1, size=2))
    piece = data[begin : begin + int(generator.integers(1, 60))]
    rest = data[:begin] + data[begin + len(piece) :]
    return rest[:to] + piece + rest[to:]


def cut_off(data: bytes, generator: np.random.Generator) -> bytes:
    """Leave out the end."""
    return data[: int(generator.integers(len(data) + 1))]


def _replaced(
    data: bytes, generator: np.random.Generator, pattern: bytes, by: Callable[[bytes], bytes]
) -> bytes:
    found = list(re.finditer(pattern, data))
    if not found:
        return data
    match = found[int(generator.integers(len(found)))]
    return data[: match.start(1)] + by(match[1]) + data[match.end(1) :]


def put_nonsense(data: bytes, generator: np.random.Generator) -> bytes:
    """Replace a value."""
    nonsense = NONSENSE[int(generator.integers(len(NONSENSE)))].encode()
    return _replaced(data, generator, rb": ([^{\[\n][^,}\n]*)", lambda _: nonsense)


def nest_deeply(data: bytes, generator: np.random.Generator) -> bytes:
    """Replace a value by lists in lists, keys in keys, or parentheses in parentheses."""
    depth = int(generator.choice([5, 30, 50, 200, 3000]))
    kinds = (
        (b"[", b"a", b"]"),
        (b"{a: ", b"b", b"}"),
        (b"(", b"own.ferry", b")"),
        (b"not ", b"own.ferry", b""),
    )
    left, inner, right = kinds[int(generator.integers(len(kinds)))]
    return _replaced(
        data, generator, rb": ([^{\[\n][^,}\n]*)", lambda _: left * depth + inner + right * depth
    )


def make_huge(data: bytes, generator: np.random.Generator) -> bytes:
    """Make a number very large, very small, or very long."""
    forms = (
        b"%s" + b"0" * 30,
        b"%s" + b"0" * 6000,
        b"%se300",
        b"%se-300",
        b"%se99999999",
        b"-%s",
        b"0.%s",
        b"%s" * 20,
    )
    form = forms[int(generator.integers(len(forms)))]
    return _replaced(data, generator, rb"(\d+)", lambda digits: form.replace(b"%s", digits))


def make_aliases(data: bytes, generator: np.random.Generator) -> bytes:
    """Give a value an anchor, and repeat it elsewhere; now and then, many times over."""
    if generator.random() < 0.2:
        laughs = [b"x0: &x0 [a, a]"]
        laughs += [b"x%d: &x%d [%s]" % (n, n, b", ".join([b"*x%d" % (n - 1)] * 9)) for n in range(1, 9)]
        return data + b"\n".join(laughs) + b"\n"
    marked = _replaced(data, generator, rb": ([^&*\n][^\n]*)", lambda value: b"&anchor " + value)
    return _replaced(marked, generator, rb": ([^&*\n][^\n]*)", lambda _: b"*anchor")


MUTATIONS: Final[tuple[Mutation, ...]] = (
    flip_bytes, drop_lines, double_lines, swap_lines, move_piece, cut_off, put_nonsense, put_nonsense,
    nest_deeply, make_huge, make_aliases,
)  # fmt: skip


def fixed_keys(node: Node, above: tuple[str, ...] = ()) -> Iterator[Scalar]:
    """Keys whose names the format fixes."""
    if isinstance(node, Sequence):
        for each in node.items:
            yield from fixed_keys(each, above)
    elif isinstance(node, Keys):
        chosen = bool(above) and above[-1] in CHOSEN
        for key, value in node.entries:
            if not chosen:
                yield key
            if not UNREAD & {key.text} or above:
                yield from fixed_keys(value, (*above, key.text))


def rename_key(text: str, generator: np.random.Generator) -> str | None:
    """Rename one key whose name the format fixes, in a file that is well; None where there is none."""
    keys = [key for key in fixed_keys(Reader(text, "file", RulesetError).root) if key.plain]
    if not keys:
        return None
    key = keys[int(generator.integers(len(keys)))]
    lines = text.split("\n")
    line = lines[key.line - 1]
    at = key.column - 1
    letters = list(key.text)
    place = int(generator.integers(len(letters) + 1))
    letters.insert(place, "abcdefghijklmnopqrstuvwxyz"[int(generator.integers(26))])
    lines[key.line - 1] = line[:at] + "".join(letters) + line[at + len(key.text) :]
    return "\n".join(lines)


@dataclass(frozen=True)
class Spoilt:
    """A file with mutations; `renamed` says that it is well but for a key of another name."""

    base: Base
    data: bytes
    renamed: bool
    how: str


def spoilt(bases: tuple[Base, ...], seed: int, number: int) -> Spoilt:
    """Mutation `number` of a seed."""
    generator = np.random.default_rng((seed, number))
    base = bases[int(generator.integers(len(bases)))]
    if generator.random() < 0.15:
        text = rename_key(base.text, generator)
        if text is not None:
            return Spoilt(base, text.encode(), renamed=True, how="rename_key")
    data, how = base.text.encode(), []
    for _ in range(int(generator.integers(1, 4))):
        mutation = MUTATIONS[int(generator.integers(len(MUTATIONS)))]
        data = mutation(data, generator)
        how.append(mutation.__name__)
    return Spoilt(base, data, renamed=False, how=", ".join(how))


# --- what comes of it -------------------------------------------------------------------------------


def tried(file: Spoilt, library: RulesetLibrary, folder: Path) -> Outcome:
    """Read a spoilt file, and use what comes of it."""
    path = folder / "spoilt.yaml"
    path.write_bytes(file.data)
    try:
        findings = _read_cases(path, library) if file.base.cases else _read_ruleset(path, library)
    except RulesetError as error:
        findings = error.diagnostics
        if not findings:
            return Outcome("refused", "a RulesetError without findings")
    except Exception as error:  # noqa: BLE001 - that is what is looked for
        return Outcome("raised", f"{type(error).__name__}: {str(error)[:200]}")
    if not findings:
        return Outcome("read", "an unknown key was accepted" if file.renamed else "")
    if not any(each.line for each in findings) and file.data.strip():
        return Outcome("refused", f"no finding has a place: {findings[0]}", findings)
    return Outcome("refused", "", findings)


def _read_ruleset(path: Path, library: RulesetLibrary) -> tuple[Diagnostic, ...]:
    rules = load_ruleset(path, library.text_of, library.vocabulary)
    ships = tuple(
        CaseShip(id=ShipId(name), facts={"length": 30.0}, pose=(at, 0.0, course), speed=3.0)
        for name, at, course in (("a", 0.0, 0.0), ("b", 500.0, 3.0))
    )
    facts = pair_facts(Case(id="case", ships=ships), ShipId("a"), ShipId("b"), VOCABULARY)
    for view in (facts, facts.mirrored()):
        rules.judge(view)
    assert isinstance(rules.text.remarks, tuple)
    return ()


def _read_cases(path: Path, library: RulesetLibrary) -> tuple[Diagnostic, ...]:
    found = load_cases(path)
    rules = library["tran2026"]
    for case in found.cases:
        if len(case.ships) == 2:
            judge_case(rules, case)  # type: ignore[arg-type]
    return found.findings


# --- all of it --------------------------------------------------------------------------------------

SMALL_CASES: Final = """\
schema_version: 1
defaults: {ship: {length_m: 103.0}, waterway: {type: river}}
golden_cases:
  - id: ferry
    title: A ferry crosses
    tags: [ferry]
    waterway: {type: canal, width_m: 80.0, current: none, regime: [tidal]}
    encounter: {geometry: crossing, has_other_on_starboard: A, tcpa_s: 120, bearing_of_B_from_A_deg: 30}
    ships:
      A: {length_m: 40.0, ferry: true, weight_t: 300, wind_side: unknown}
      B: {propulsion: sail, follows_starboard_side: true}
    expected:
      tran2026: {kind: give_way, give_way: [B], stand_on: A, article: "Sec. 3.1", confidence: derived}
  - id: placed
    ships:
      A: {kinematics: {north_m: 0.0, east_m: 0.0, course_deg: 0.0, speed_mps: 3.0}}
      B: {kinematics: {north_m: 900.0, east_m: 0.0, course_deg: 180.0, speed_mps: 3.0}, blue_sign: false}
    expected:
      tran2026: {kind: mutual, give_way: [A, B], pass: port_to_port}
hard_cases:
  - id: ring
    ships: {A: {}, B: {}, C: {}}
    resolution: {order: [A, B, C], note: x}
    expected:
      tran2026: {diagnosis: cycle, gives_way_to: [[A, B], [B, C], [C, A]], cycle: [A, B, C]}
"""


def shipped() -> tuple[tuple[Base, ...], RulesetLibrary]:
    """The files to be spoilt, and the library in which they find their bases."""
    library = load().rulesets
    texts = {name: library.text_of(name)[0] for name in ("common", "tran2026", "tran2026_printed", "bpr")}
    rulesets = tuple(Base(name, text) for name, text in texts.items())
    return (
        *rulesets,
        Base("cases", SMALL_CASES, cases=True),
        Base("cases", SMALL_CASES, cases=True),
    ), library


def run(count: int, seed: int) -> Mapping[str, list[str]]:
    """Spoil files, and give what is wrong, by kind."""
    bases, library = shipped()
    wrong: dict[str, list[str]] = {}
    counted: Counter[str] = Counter()
    slowest = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            file = spoilt(bases, seed, number)
            signal.setitimer(signal.ITIMER_REAL, LIMIT)
            before = time.perf_counter()
            outcome = tried(file, library, Path(folder))
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            slowest = max(slowest, time.perf_counter() - before)
            counted[f"{'renamed, ' if file.renamed else ''}{outcome.what}"] += 1
            if outcome.wrong:
                wrong.setdefault(outcome.wrong.partition(":")[0], []).append(
                    f"{number} ({file.base.name}, {file.how}): {outcome.wrong}"
                )
    print(f"{count} files: {dict(counted)}; the slowest took {slowest:.2f} s")
    return wrong


def _too_slow(*_: object) -> None:
    raise TimeoutError(f"longer than {LIMIT} s")


def main() -> int:
    """Run the program."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    options = parser.parse_args()
    signal.signal(signal.SIGALRM, _too_slow)
    if options.only is not None:
        bases, library = shipped()
        file = spoilt(bases, options.seed, options.only)
        with tempfile.TemporaryDirectory() as folder:
            outcome = tried(file, library, Path(folder))
        sys.stdout.buffer.write(file.data)
        print(f"\n{file.how}: {outcome.what} {outcome.wrong}", *map(str, outcome.findings), sep="\n")
        return 0
    wrong = run(options.count, options.seed)
    for kind, examples in wrong.items():
        print(f"{kind}: {len(examples)}", *examples[:5], sep="\n    ")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
