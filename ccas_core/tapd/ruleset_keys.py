"""Every key of a ruleset file, with what it means and what it holds.

The schema of `ccas schema` and the tables of docs/ruleset-format.md are made from this; a test holds it
against what the reader asks for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Final

from ..roles import Geometry, PassingSide
from ..verdict import Confidence
from ..verdict import Kind as VerdictKind
from .cases import DIAGNOSES
from .rules import Criterion, Diagnosis, Mirror, Policy, Side, Strength
from .ruleset_draft import SCHEMA
from .ruleset_reader import Claimed, Passing, Then


class Shape(Enum):
    """What stands at a key; values are what the reference says."""

    TEXT = "a text"
    FLAG = "`true` or `false`"
    DATE = "a day, such as `2027-06-30`"
    CONDITION = "a condition, or a list of conditions that must all hold"
    NUMBER = "a number with its unit"
    SPAN = "two numbers with units, the least first"
    NAME = "a name"
    NAMES = "a name, or a list of names"
    CRITERIA = "a list of criteria, each `NAME` or `NAME descending`"
    EXCEPTIONS = "a condition, a block with `when`, `unless` and `cite`, or a list of them"
    SHIP = "a ship of the test"
    SHIPS = "a ship of the test, or a list of them"
    PAIRS = "a list of pairs of ships"
    TIMES = "a time for each ship, by name"
    SHIP_FACTS = "ships by name, each with its facts"
    WATERWAY_FACTS = "facts of the waterway"
    BLOCK = "a block"
    BLOCKS = "a list of blocks"
    NAMED_BLOCKS = "blocks by name"
    NAMED_TEXTS = "texts by name"
    NAMED_CONDITIONS = "conditions by name"


@dataclass(frozen=True, slots=True)
class Key:
    """One key of a block."""

    name: str
    meaning: str
    shape: Shape = Shape.TEXT
    required: bool = False
    words: tuple[str, ...] = ()  # the only values, where there are some
    block: str = ""  # name of the block that stands there
    example: str = ""


def _words(options: Iterable[str]) -> tuple[str, ...]:
    return tuple(str(each) for each in options)


_SIDES: Final = _words(Side)
_CITE: Final = Key("cite", "Where the regulation says so.", Shape.BLOCK, required=True, block="citation")
_NOTE: Final = Key("note", "A remark for whoever reads the file.")

_RULESET: Final = (
    Key("schema", f"The kind of file: `{SCHEMA}`. It comes first.", required=True, words=(SCHEMA,)),
    Key("id", "Name by which scenarios and commands ask for the ruleset.", required=True, example="bpr"),
    Key("version", "Version of this file; each verdict carries it.", required=True, example="1.0.0"),
    Key("title", "What it is, on one line.", required=True),
    Key("description", "What it covers, what it leaves out, and what it rests on."),
    Key("abstract", "It is only there to be extended; it need not have rules.", Shape.FLAG),
    Key("extends", "The base: id of a ruleset, or path of a file beside this one.", Shape.NAME),
    Key("regulation", "The regulation that is written here.", Shape.BLOCK, block="regulation"),
    Key("policy", "What it means that two rules apply.", words=_words(Policy)),
    Key("mirror", "Whether a rule also says what the other ship sees.", words=_words(Mirror)),
    Key("params", "Numbers with names, for conditions.", Shape.NAMED_BLOCKS, block="parameter"),
    Key(
        "let",
        "Conditions with names: `NAME` about the pair, `NAME(ship)` about one ship.",
        Shape.NAMED_CONDITIONS,
    ),
    Key("regimes", "Flags of stretches of water, each with its meaning.", Shape.NAMED_TEXTS),
    Key("encounter", "How an encounter is recognised.", Shape.BLOCK, block="encounter"),
    Key("gates", "Conditions that switch whole articles off.", Shape.BLOCKS, block="gate"),
    Key("remove", "Rules of the base that do not hold here.", Shape.NAMES),
    Key("rules", "The ladder of rules: the first that applies decides.", Shape.BLOCKS, block="rule"),
    Key(
        "citations",
        "Rules of the base by id, with the article by which they stand here.",
        Shape.NAMED_BLOCKS,
        block="citation",
    ),
    Key("otherwise", "What holds where no rule applies.", Shape.BLOCK, block="otherwise"),
    Key("deadlock", "Who decides first in a ring of ships.", Shape.BLOCK, block="deadlock"),
    Key("domain", "For which ships the ruleset is meant; proofs stay in it.", Shape.BLOCK, block="domain"),
    Key("waivers", "Faults that are accepted, with a reason.", Shape.BLOCKS, block="waiver"),
    Key("claims", "Properties that hold for some ships only.", Shape.BLOCKS, block="claim"),
    Key("tests", "Encounters, and what the ruleset must say of them.", Shape.BLOCKS, block="test"),
)
_RULE: Final = (
    Key("id", "Name of the rule; small letters, digits, `.`, `-`, `_`.", Shape.NAME, required=True),
    _CITE,
    Key("where", "On which waters it holds; facts of the waterway and regimes only.", Shape.CONDITION),
    Key("when", "When it applies, from own ship's side.", Shape.CONDITION),
    Key("unless", "Exceptions, which may have exceptions of their own.", Shape.EXCEPTIONS),
    Key("then", "What own ship does.", words=_words(Then)),
    Key("strength", "How much the obliged ship owes.", words=_words(Strength)),
    Key("pass", "The side on which the ships pass.", words=_words(PassingSide)),
    Key("passing", "How binding that side is; required, unless said.", words=_words(Passing)),
    Key("side_chosen_by", "The ship that chooses the side.", words=_SIDES),
    Key("must_follow", "The ship that must follow that choice.", words=_SIDES),
    Key("facilitates", "The privileged ship that must help all the same.", words=_SIDES),
    Key("signal", "Signal that the rule asks for."),
    Key("manoeuvre", "Manoeuvre that the rule asks for."),
    Key("diagnosis", "What is wrong with the law, for `gap` and `conflict`.", words=_words(Diagnosis)),
    Key("reason", "Reason of the verdict, in place of the text of the article."),
    Key("because", "The same, with `{own}` and `{other}` for the ships."),
    Key("python", "Rule of a plugin that decides in place of `then`.", Shape.NAME),
    Key("before", "Rule of the base before which it stands.", Shape.NAME),
    Key("after", "Rule of the base behind which it stands.", Shape.NAME),
    Key("replaces", "Rule of the base in whose place it stands.", Shape.NAME),
    _NOTE,
)
_EXPECT: Final = (
    Key("kind", "Kind of the verdict.", words=tuple(k for k in _words(VerdictKind) if k != "stand_on")),
    Key("give_way", "Ships that give way; both for `mutual`.", Shape.SHIPS),
    Key("stand_on", "Ships that stand on.", Shape.SHIPS),
    Key("by", "Id of the rule that decides.", Shape.NAME),
    Key("article", "Article that is cited; compared by its number, where `by` is stated."),
    Key("pass", "The side on which they pass.", words=_words(PassingSide)),
    Key("strength", "How much the obliged ship owes.", words=_words(Strength)),
    Key("initiator", "The ship that wants the manoeuvre.", Shape.SHIP),
    Key("side_chosen_by", "The ship that chooses the side.", Shape.SHIP),
    Key("must_follow", "Ships that must follow that choice.", Shape.SHIPS),
    Key("facilitates", "Privileged ships that must help.", Shape.SHIPS),
    Key("manoeuvre", "Manoeuvre that is asked for."),
    Key("required_manoeuvre", "The same, as encounter files write it."),
    Key("reason", "`no_rule` or `no_risk`, for the kind `none`."),
    Key("diagnosis", "What is wrong with the verdicts.", words=DIAGNOSES),
    Key("gives_way_to", "Of a group: pairs of which the first gives way to the second.", Shape.PAIRS),
    Key("mutual", "Of a group: pairs in which both give way.", Shape.PAIRS),
    Key("no_rule", "Of a group: pairs for which no rule applies.", Shape.PAIRS),
    Key("cycle", "Of a group: ships that wait for one another in a ring.", Shape.SHIPS),
    Key("order", "Of a group: the order in which they decide.", Shape.SHIPS),
    Key("confidence", "How sure that is; `derived` and `unverified` fail nobody.", words=_words(Confidence)),
    *(
        Key(name, "Told, and not compared.")
        for name in ("note", "signal", "cooperates", "suggested", "verdict", "obligations")
    ),
)

BLOCKS: Final[Mapping[str, tuple[Key, ...]]] = MappingProxyType(
    {
        "ruleset": _RULESET,
        "regulation": (
            Key("name", "Its short name; citations begin with it.", required=True, example="BPR"),
            Key("version", "The edition that is written here.", required=True),
            Key("title", "Its full name."),
            Key("url", "Where it can be read."),
            Key("language", "Its language."),
        ),
        "parameter": (
            Key("value", "The value.", Shape.NUMBER, required=True, example="900 s"),
            Key("range", "Values for which the ruleset is meant to hold; proofs cover them.", Shape.SPAN),
            Key("meaning", "What it is."),
        ),
        "encounter": (
            Key("risk", "There is a risk of collision.", Shape.CONDITION),
            Key("overtaking", "Own ship overtakes the other; tried first.", Shape.CONDITION),
            Key("head_on", "They meet head-on; tried next.", Shape.CONDITION),
            Key("crossing", "Their courses cross; tried last.", Shape.CONDITION),
            Key("from_starboard", "Own ship has the other on its starboard side.", Shape.CONDITION),
        ),
        "gate": (
            Key("id", "Name of the gate.", Shape.NAME, required=True),
            Key(
                "when",
                "When the rules are off; it holds for both views alike.",
                Shape.CONDITION,
                required=True,
            ),
            Key(
                "off", "Rules that are off; `crossing.*` means all that begin so.", Shape.NAMES, required=True
            ),
            _CITE,
            _NOTE,
        ),
        "rule": _RULE,
        "exception": (
            Key("when", "When the rule does not apply.", Shape.CONDITION, required=True),
            Key("unless", "When it does, all the same.", Shape.EXCEPTIONS),
            Key("cite", "Where the regulation says so.", Shape.BLOCK, block="citation"),
        ),
        "citation": (
            Key("article", "Article and paragraph.", required=True, example="6.04(2)"),
            Key("regulation", "Another regulation than that of the file."),
            Key("version", "Its edition."),
            Key("confidence", "How well the source was seen.", words=_words(Confidence)),
            Key("text", "What the article says, in your own words."),
        ),
        "otherwise": (_CITE,),
        "deadlock": (
            Key(
                "resolve_by",
                f"Criteria, the least value first: {', '.join(_words(Criterion))}, and those of plugins.",
                Shape.CRITERIA,
                required=True,
                example="[weight, id]",
            ),
        ),
        "domain": (
            Key("speed", "Speeds of ships.", Shape.SPAN, example="[0.5 m/s, 12 m/s]"),
            Key("length", "Lengths of ships.", Shape.SPAN, example="[5 m, 200 m]"),
            Key("separation", "Ships are never closer than this.", Shape.NUMBER, example="50 m"),
            Key("assume", "Conditions that always hold.", Shape.CONDITION),
        ),
        "waiver": (
            Key("check", "Check that may fail, such as `consistent` or `complete`.", required=True),
            Key("reason", "Why that is accepted.", required=True),
            Key("expires", "When it is to be looked at again.", Shape.DATE, required=True),
            Key("rules", "Rules that it is about; otherwise all.", Shape.NAMES),
        ),
        "claim": (
            Key("name", "Name under which the claim is told.", Shape.NAME, required=True),
            Key("check", "What is claimed.", required=True, words=_words(Claimed)),
            Key("assume", "Of which ships it is claimed.", Shape.CONDITION, required=True),
            Key("on_a_reach", "Of ships that follow one reach of a river.", Shape.FLAG),
            Key("note", "What a reader should know."),
        ),
        "test": (
            Key("name", "What is tested, as a sentence.", required=True),
            Key("ships", "Two ships or more.", Shape.SHIP_FACTS, required=True),
            Key("waterway", "Facts of the waterway.", Shape.WATERWAY_FACTS),
            Key("encounter", "Facts of the pair, where they are stated.", Shape.BLOCK, block="meeting"),
            Key("expect", "What the ruleset must say.", Shape.BLOCK, required=True, block="expect"),
        ),
        "meeting": (
            Key("risk_of_collision", "There is a risk; true, unless said.", Shape.FLAG),
            Key("geometry", "How the ships meet.", words=_words(Geometry)),
            Key("overtaker", "The ship that overtakes, or `none`.", Shape.SHIP),
            Key("has_other_on_starboard", "The ship that has the other on its starboard side.", Shape.SHIP),
            Key("windward", "The ship to windward.", Shape.SHIP),
            Key("same_waterway", "Each lies between the banks of the other's waterway.", Shape.FLAG),
            Key("same_direction", "Both follow one waterway, in one direction.", Shape.FLAG),
            Key("time_to_intersection", "How far each is from the intersection.", Shape.TIMES),
        ),
        "expect": _EXPECT,
    }
)

TITLES: Final[Mapping[str, str]] = MappingProxyType(
    {
        "ruleset": "The file",
        "regulation": "`regulation`",
        "parameter": "A parameter (`params: {NAME: …}`)",
        "encounter": "`encounter`",
        "gate": "A gate (`gates`)",
        "rule": "A rule (`rules`)",
        "exception": "An exception (`unless`)",
        "citation": "A citation (`cite`, `citations`)",
        "otherwise": "`otherwise`",
        "deadlock": "`deadlock`",
        "domain": "`domain`",
        "waiver": "A waiver (`waivers`)",
        "claim": "A claim (`claims`)",
        "test": "A test (`tests`)",
        "meeting": "`encounter` of a test",
        "expect": "`expect` of a test",
    }
)


def reference() -> str:
    """All keys as Markdown, block by block."""
    parts = []
    for name, keys in BLOCKS.items():
        rows = [
            f"| {'**' if key.required else ''}`{key.name}`{'**' if key.required else ''} "
            f"| {_held(key)} | {key.meaning} |"
            for key in keys
        ]
        parts.append(
            "\n".join([f"### {TITLES[name]}\n", "| key | holds | meaning |", "| --- | --- | --- |", *rows])
        )
    return "\n\n".join(parts)


def _held(key: Key) -> str:
    if key.words:
        return ", ".join(f"`{word}`" for word in key.words)
    held = key.shape.value
    return f"{held}: {TITLES[key.block]}" if key.block else held
