"""The strict reader: what it refuses, where it points, and that it stays quick and calm."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from ccas_core import quantities, yaml_nodes
from ccas_core.errors import Diagnostic, InputError, RulesetError
from ccas_core.findings import MAX_BYTES, MAX_FINDINGS, read_text
from ccas_core.quantities import ANGLE, LENGTH, MASS, NUMBER, SPEED, TIME, Range
from ccas_core.roles import Role
from ccas_core.strict_yaml import Reader
from ccas_core.yaml_nodes import Mapping, Node, Scalar, Sequence, written


@pytest.fixture(params=["CSafeLoader", "SafeLoader"])
def parser(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Both parsers of pyyaml: the one in C is not installed everywhere."""
    name = str(request.param)
    monkeypatch.setattr(yaml_nodes, "_LOADER", getattr(yaml, name))
    return name


def findings(text: str) -> tuple[Diagnostic, ...]:
    with pytest.raises(InputError) as caught:
        Reader(text, "file.yaml").finish()
    return caught.value.diagnostics


def value_of(text: str) -> tuple[Reader, Node]:
    reader = Reader(f"key: {text}", "file.yaml")
    assert isinstance(reader.root, Mapping)
    return reader, reader.root.entries[0][1]


def refusal(reader: Reader) -> Diagnostic:
    with pytest.raises(InputError) as caught:
        reader.finish()
    (finding,) = caught.value.diagnostics
    return finding


# --- what is refused as a whole ----------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("", 0, 0, "the file is empty"),
        ("# only a comment\n", 0, 0, "the file is empty"),
        ("a:\n\tb: 1\n", 2, 1, "a tab in the indentation"),
        ("a:\n  b: 1\n \tc: 1\n", 3, 2, "a tab in the indentation"),
        ("a: 1\nb: x\0y\n", 2, 5, "the character U+0000"),
        ("a: \u2028\n", 1, 4, "the character U+2028"),
        ("a: \ud800\n", 1, 4, "the character U+D800"),
        ("a: 1\nb: 2\na: 3\n", 3, 1, "the key 'a' is given twice"),
        ("{a: 1, 'a': 2}", 1, 8, "the key 'a' is given twice"),
        ("a: &x {b: 1}\nc:\n  <<: *x\n", 3, 3, "merge keys are not used here"),
        ("a: !!python/object/apply:os.system [ls]", 1, 4, "tags are not used here"),
        ("a: !local 3", 1, 4, "tags are not used here"),
        ("%YAML 1.1\n---\na: 1\n", 1, 1, "directives are not used here"),
        ("a: 1\n---\nb: 1\n", 2, 1, "a second document in the file"),
        ("a: *b", 1, 4, "the alias 'b' repeats nothing"),
        ("a: &a [*a]", 1, 8, "the alias 'a' repeats nothing"),
        ("[a, b]: 1", 1, 1, "got a list as a key"),
        ("? {a: 1}\n: 2\n", 1, 3, "got keys with values as a key"),
        ("a: 1\n?\n: 1\n", 2, 2, "a key is missing before ':'"),
        ("a: b: c", 1, 5, "not YAML: mapping values are not allowed"),
        ("a: [1, 2\nb: 3\n", 2, 2, "not YAML: "),
        ("a: @x", 1, 4, "not YAML: found character"),
        ('a: "x\n\n', 3, 1, "not YAML: found unexpected end of stream"),
        ('a: "\\UFFFFFFFF"', 1, 7, "not YAML: "),
        ("ships:\n  - id: a\n   beam: 3\n", 3, 4, "not YAML: "),
    ],
)
def test_what_is_not_strict_yaml_is_refused_at_its_place(
    parser: str, text: str, line: int, column: int, message: str
) -> None:
    (finding,) = findings(text)

    assert finding.message.startswith(message)
    if "UFFFF" not in text or parser == "CSafeLoader":  # the parser in Python loses this place
        assert (finding.line, finding.column) == (line, column)


def test_two_equal_keys_are_told_with_both_positions() -> None:
    (finding,) = findings("rule: 1\nother: 2\nrule: 3\n")

    assert (finding.line, finding.column, finding.excerpt) == (3, 1, "rule: 3")
    assert finding.hint == "the first is at line 1, column 1; remove one"


def test_all_equal_keys_are_told_even_before_a_fault_of_syntax() -> None:
    told = findings("a: 1\na: 2\na: 3\nb: c: d\n")

    assert [each.line for each in told] == [2, 3, 4]


def test_a_fault_of_syntax_says_what_would_help() -> None:
    (finding,) = findings("a: [1, 2\nb: 3\n")

    assert finding.hint == "close the bracket, or put a comma between its items (begins at line 1)"


@pytest.mark.parametrize("piece", ["[", "{a: ", "- ", "? ", "a:\n "])
def test_ten_megabytes_of_nesting_are_refused_quickly(tmp_path: Path, piece: str) -> None:
    path = tmp_path / "deep.yaml"
    path.write_text(piece * (10_000_000 // len(piece)))
    before = time.process_time()

    with pytest.raises(InputError, match="larger than 2 MB"):
        read_text(path)
    assert time.process_time() - before < 2.0


@pytest.mark.parametrize("piece", ["[", "{a: ", "- ", "? "])
def test_deep_nesting_within_the_size_is_refused_quickly(parser: str, piece: str) -> None:
    text = piece * (MAX_BYTES // len(piece))
    before = time.process_time()

    (finding,) = findings(text)
    assert finding.message == "nested more than 40 deep"
    assert finding.line == 1
    assert time.process_time() - before < 2.0


def test_nesting_up_to_the_bound_is_read() -> None:
    depth = yaml_nodes.MAX_DEPTH

    Reader("[" * depth + "]" * depth, "file.yaml").finish()
    assert findings("[" * (depth + 1) + "]" * (depth + 1))[0].column == depth + 1


def test_aliases_that_multiply_are_refused_quickly(parser: str) -> None:
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 30)]
    before = time.process_time()

    (finding,) = findings("\n".join(lines))
    assert finding.message == "the file holds more than 100000 values"
    assert finding.hint == "an alias counts for all that it repeats"
    assert time.process_time() - before < 2.0


def test_aliases_that_nest_one_another_are_refused() -> None:
    lines = ["a0: &a0 [1]"] + [f"a{i}: &a{i} [*a{i - 1}]" for i in range(1, 60)]

    (finding,) = findings("\n".join(lines))
    assert finding.message == "nested more than 40 deep"


def test_an_alias_repeats_its_anchor() -> None:
    reader = Reader("a: &here {x: 1 m}\nb: *here\n", "file.yaml")
    block = reader.block(reader.root)

    lengths = [reader.number(reader.block(block.require(key)).require("x"), LENGTH) for key in ("a", "b")]
    assert lengths == [1.0, 1.0]


def test_findings_come_in_the_order_of_the_file_and_stop_when_there_are_too_many() -> None:
    told = findings("a: 1\n" * 300)

    assert len(told) == MAX_FINDINGS
    assert [each.line for each in told] == list(range(2, MAX_FINDINGS + 2))


# --- files -------------------------------------------------------------------------------------


def test_a_missing_file_and_a_directory_are_told_by_name(tmp_path: Path) -> None:
    for path, reason in ((tmp_path / "none.yaml", "No such file"), (tmp_path, "directory")):
        with pytest.raises(RulesetError, match=reason) as caught:
            read_text(path, RulesetError)
        assert caught.value.diagnostics[0].source == str(path)
        assert caught.value.diagnostics[0].hint


def test_a_path_with_nul_is_told_like_a_missing_file() -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_text("a\0b")


def test_bytes_that_are_not_utf_8_are_told_with_line_and_column(tmp_path: Path) -> None:
    path = tmp_path / "latin.yaml"
    path.write_bytes("schema: x\nname: Zür".encode() + "ü".encode("latin-1") + b"ich\nmore: 1\n")

    with pytest.raises(InputError) as caught:
        read_text(path)
    (finding,) = caught.value.diagnostics
    assert (finding.line, finding.column) == (2, 10)
    assert finding.message == "byte 0xFC is not UTF-8"
    assert finding.hint == "save the file as UTF-8"
    assert finding.excerpt.startswith("name: Zür")


def test_a_byte_order_mark_and_line_ends_of_other_systems_change_nothing(tmp_path: Path) -> None:
    path = tmp_path / "windows.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: 1\r\nb: 2\rc: 3\n")

    reader = Reader(read_text(path), "windows.yaml")
    assert isinstance(reader.root, Mapping)
    assert [(key.text, key.line, value.line) for key, value in reader.root.entries] == [
        ("a", 1, 1),
        ("b", 2, 2),
        ("c", 3, 3),
    ]


# --- scalars -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("no", "no"),
        ("NO", "NO"),
        ("yes", "yes"),
        ("on", "on"),
        ("off", "off"),
        ("y", "y"),
        ("12:30", "12:30"),
        ("190:20:30", "190:20:30"),
        ("1_000", "1_000"),
        ("0x1F", "0x1F"),
        ("2024-01-01", "2024-01-01"),
        ("1e3", 1000.0),
        ("1.", 1.0),
        (".5", 0.5),
        ("-.5e-1", -0.05),
        ("010", 10),
        ("+3", 3),
        ("true", True),
        ("FALSE", False),
        ("'true'", "true"),
        ('"12"', "12"),
        ("~", None),
        ("null", None),
        ("", None),
        (".inf", math.inf),
        ("-.INF", -math.inf),
        ("|\n  no", "no"),
    ],
)
def test_scalars_are_those_of_yaml_1_2(parser: str, text: str, value: object) -> None:
    _, node = value_of(text)

    assert isinstance(node, Scalar)
    assert node.value == value
    assert type(node.value) is type(value)


def test_norway_is_a_text_where_a_text_is_wanted_and_no_flag_where_a_flag_is_wanted() -> None:
    for word in ("no", "NO", "off", "1", "12:30", "true"):
        reader, node = value_of(word)
        assert reader.text(node) == word
        reader.finish()

    reader, node = value_of("no")
    reader.flag(node)
    finding = refusal(reader)
    assert (finding.line, finding.column, finding.message) == (1, 6, "got 'no'")
    assert finding.expected == "true or false"


def test_every_key_and_value_knows_its_place() -> None:
    reader = Reader("a: 1\nb:\n  - x\n  - {c: 'y', d: }\n", "file.yaml")

    assert reader.root == Mapping(
        1,
        1,
        (
            (Scalar(1, 1, "a"), Scalar(1, 4, "1")),
            (
                Scalar(2, 1, "b"),
                Sequence(
                    3,
                    3,
                    (
                        Scalar(3, 5, "x"),
                        Mapping(
                            4,
                            5,
                            (
                                (Scalar(4, 6, "c"), Scalar(4, 9, "y", plain=False)),
                                (Scalar(4, 14, "d"), Scalar(4, 17, "")),
                            ),
                        ),
                    ),
                ),
            ),
        ),
    )


@pytest.mark.parametrize(
    ("text", "quantity", "value"),
    [
        ("20 s", TIME, 20.0),
        ("2 min", TIME, 120.0),
        ("1.5 h", TIME, 5400.0),
        ("22.5 deg", ANGLE, math.pi / 8),
        ("-0.5 rad", ANGLE, -0.5),
        ("3 m/s", SPEED, 3.0),
        ("10.8 km/h", SPEED, 3.0),
        ("5.8 kn", SPEED, 2.98377777778),
        ("2000 t", MASS, 2e6),
        ("5e3 kg", MASS, 5e3),
        ("1 NM", LENGTH, 1852.0),
        ("'1.2 km'", LENGTH, 1200.0),
        ("0.5", NUMBER, 0.5),
        ("0.0092 1/m", quantities.CURVATURE, 0.0092),
        ("6724 m2", quantities.AREA, 6724.0),
    ],
)
def test_numbers_with_units_are_read_in_si(text: str, quantity: quantities.Quantity, value: float) -> None:
    reader, node = value_of(text)

    assert reader.number(node, quantity) == pytest.approx(value, rel=1e-11)
    reader.finish()


@pytest.mark.parametrize(
    ("text", "message", "expected", "hint"),
    [
        ("20", "'20' has no unit", "a time in s, min or h", "if it is in s, write '20 s'"),
        ("20s", "'20s' has no space before its unit", "a time in s, min or h", "write '20 s'"),
        ("20 m", "'20 m' is a length, not a time", "a time in s, min or h", ""),
        ("20 mn", "'20 mn' has an unknown unit", "a time in s, min or h", "did you mean 'min'?"),
        ("soon", "'soon' is not a time", "a time in s, min or h", ""),
        ("1,5 s", "'1,5 s' is not a time", "a time in s, min or h", ""),
        ("1e999 s", "'1e999 s' is not finite", "a time in s, min or h", ""),
        (".nan s", "'.nan s' is not finite", "a time in s, min or h", ""),
        ("-1 s", "'-1 s' is out of range", "above 0 s and at most 60 s", ""),
        ("2 min", "'2 min' is out of range", "above 0 s and at most 60 s", ""),
        ("", "got nothing", "a time in s, min or h", ""),
        ("[20 s]", "got a list", "a time in s, min or h", ""),
    ],
)
def test_a_number_that_cannot_be_used_is_refused(text: str, message: str, expected: str, hint: str) -> None:
    reader, node = value_of(text)

    reader.number(node, TIME, Range(above=0.0, at_most=60.0))
    finding = refusal(reader)
    assert (finding.message, finding.expected, finding.hint) == (message, expected, hint)
    assert (finding.line, finding.column) == (1, 6 if text else 5)


def test_a_unit_where_none_is_wanted_is_refused() -> None:
    reader, node = value_of("5 s")

    reader.number(node, NUMBER)
    assert refusal(reader).message == "'5 s' is a time, not a number without unit"


def test_open_values_keep_their_kind() -> None:
    for text, value in (
        ("no", "no"),
        ("true", True),
        ("3", 3),
        ("2 t", 2000.0),
        ("'2 t'", "2 t"),
        ("5 of 6", "5 of 6"),
    ):
        reader, node = value_of(text)
        assert reader.value(node) == value
        reader.finish()

    reader, node = value_of("300 kmh")
    reader.value(node)
    assert refusal(reader).hint == "did you mean 'km/h'?; a text needs quotes"


CHECKS: list[tuple[str, Callable[[Reader, Node], object], str, str]] = [
    ("giveway", lambda reader, node: reader.choice(node, Role), "got 'giveway'", "did you mean 'give_way'?"),
    ("4.5", lambda reader, node: reader.integer(node, 1, 9), "got '4.5'", ""),
    ("true", lambda reader, node: reader.integer(node, 1, 9), "got 'true'", ""),
    ("10", lambda reader, node: reader.integer(node, 1, 9), "got '10'", ""),
    ("' '", lambda reader, node: reader.text(node), "an empty text", ""),
    ("x", lambda reader, node: reader.items(node), "got 'x'", ""),
    ("[1]", lambda reader, node: reader.items(node, 2), "a list of 1", ""),
    ("[1]", lambda reader, node: reader.entries(node), "got a list", ""),
]


@pytest.mark.parametrize(("text", "read", "message", "hint"), CHECKS)
def test_words_whole_numbers_and_shapes_are_checked(
    text: str, read: Callable[[Reader, Node], object], message: str, hint: str
) -> None:
    reader, node = value_of(text)

    read(reader, node)
    finding = refusal(reader)
    assert (finding.message, finding.hint, finding.line, finding.column) == (message, hint, 1, 6)


# --- blocks ------------------------------------------------------------------------------------


def test_all_faults_of_a_block_are_told_at_once() -> None:
    reader = Reader("lenght: 3 m\nbeam: 2\ncolour: red\n", "ship.yaml")
    block = reader.block(reader.root)
    for key in ("length", "beam", "weight"):
        reader.number(block.require(key), LENGTH)

    assert not block.done()
    with pytest.raises(InputError) as caught:
        reader.finish()
    assert [(each.line, each.column, each.message, each.hint) for each in caught.value.diagnostics] == [
        (1, 1, "unknown key 'lenght'", "did you mean 'length'?"),
        (1, 1, "the key 'weight' is missing here", ""),
        (2, 7, "'2' has no unit", "if it is in m, write '2 m'"),
        (3, 1, "unknown key 'colour'", "known: beam, length, weight"),
    ]
    assert str(caught.value).startswith(
        "ship.yaml:1:1: unknown key 'lenght'\n 1 | lenght: 3 m\n   | ^\n    hint: did you mean 'length'?"
    )


def read_as_x(text: str) -> None:
    reader = Reader(text, "file.yaml")
    reader.document("ccas/x@1")
    reader.finish()


def test_the_schema_comes_first() -> None:
    for text, line, message in (
        ("a: 1\n", 1, "the file does not say of which kind it is"),
        ("- 1\n", 1, "the file holds a list"),
        ("schema: ccas/y@1\n", 1, "'ccas/y@1' is not the kind that is read here"),
        ("a: 1\nschema: ccas/x@1\n", 1, "'schema' must come first"),
    ):
        with pytest.raises(InputError) as caught:
            read_as_x(text)
        (finding,) = caught.value.diagnostics
        assert (finding.line, finding.message) == (line, message)


def test_a_schema_of_another_version_is_told_so() -> None:
    with pytest.raises(InputError, match="another version of ccas"):
        Reader("schema: ccas/x@2\n", "file.yaml").document("ccas/x@1")


# --- properties --------------------------------------------------------------------------------


@settings(derandomize=True, deadline=None, max_examples=300)
@given(st.text())
def test_a_text_that_is_written_is_read_back(text: str) -> None:
    if any("\ud800" <= each <= "\udfff" for each in text):
        return  # lone surrogates are in no file
    reader = Reader(f"{{{written(text)}: [{written(text)}]}}", "file.yaml")

    assert isinstance(reader.root, Mapping)
    ((key, value),) = reader.root.entries
    assert isinstance(value, Sequence)
    assert isinstance(value.items[0], Scalar)
    assert (key.text, value.items[0].value) == (text, text)


@settings(derandomize=True, deadline=None, max_examples=300)
@given(
    st.floats(allow_nan=False, allow_infinity=False, width=32), st.sampled_from([TIME, ANGLE, MASS, SPEED])
)
def test_a_number_that_is_kept_is_written_and_read_back_bit_for_bit(
    value: float, quantity: quantities.Quantity
) -> None:
    kept = quantity.keep(value)
    reader, node = value_of(quantity.write(kept))

    assert reader.number(node, quantity) == kept
    assert kept == pytest.approx(value, rel=1e-11)


@settings(derandomize=True, deadline=None, max_examples=500)
@given(st.text(alphabet="ab01.-:,#'\"[]{}&*!|>%@`?~< \n\t\\\0é\u2028", max_size=60), st.booleans())
def test_garbage_is_read_or_refused_but_nothing_else(text: str, in_c: bool) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(yaml_nodes, "_LOADER", yaml.CSafeLoader if in_c else yaml.SafeLoader)
        with contextlib.suppress(InputError):
            reader = Reader(text, "file.yaml")
            reader.block(reader.root).done()
            reader.finish()
