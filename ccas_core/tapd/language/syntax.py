"""Conditions as text: a tokeniser and a parser that know the place of everything they read.

    expression := or;   or := and {"or" and};   and := not {"and" not};   not := "not" not | comparison
    comparison := sum {relation sum} | sum ["not"] "in" "(" word {"," word} ")"
    sum := product {("+" | "-") product};   product := sign {"*" sign};   sign := "-" sign | value
    value := number [unit] | "true" | "false" | name | name "(" name {"," name} ")" | "(" or ")"

A name may have dots.  There is nothing else: no attribute, no index, no call of anything that the
vocabulary or the ruleset does not define.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final, NoReturn, TypeAlias

MAX_LENGTH: Final = 4000  # letters of a condition
MAX_DEPTH: Final = 60  # nested parentheses, negations and calls
MAX_DIGITS: Final = 40  # letters of a number

RELATIONS: Final = ("<=", ">=", "==", "!=", "<", ">")
_KEYWORDS: Final = frozenset({"and", "or", "not", "in", "true", "false"})
_TOKEN: Final = re.compile(
    r"""(?P<space>\s+)
    |(?P<number>\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)
    |(?P<name>[A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z_][A-Za-z0-9_]*)*)
    |(?P<mark><=|>=|==|!=|[<>()+\-*/,=])""",
    re.VERBOSE | re.ASCII,
)
_UNIT: Final = re.compile(r" +(m/s|km/h|[A-Za-z]+)(?![A-Za-z0-9_.(])", re.ASCII)


@dataclass(frozen=True, slots=True)
class Span:
    """Part of a text: letters from `begin` up to `end`, counted from 0."""

    begin: int
    end: int


class Fault(Exception):  # noqa: N818 - it is caught, and becomes a finding
    """What is wrong with a condition, and where in its text."""

    def __init__(self, span: Span, message: str, *, expected: str = "", hint: str = "") -> None:
        self.span, self.message, self.expected, self.hint = span, message, expected, hint
        super().__init__(message)


@dataclass(frozen=True, slots=True)
class Number:
    """A number as written, with its unit; without one, the unit is empty."""

    span: Span
    digits: str
    unit: str


@dataclass(frozen=True, slots=True)
class Word:
    """A name, or a value of a fact."""

    span: Span
    name: str


@dataclass(frozen=True, slots=True)
class Truth:
    """`true` or `false`."""

    span: Span
    value: bool


@dataclass(frozen=True, slots=True)
class Call:
    """A definition or a built-in quantity, asked for some ships."""

    span: Span
    name: str
    arguments: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Negation:
    """`not` a condition."""

    span: Span
    part: Expression


@dataclass(frozen=True, slots=True)
class Junction:
    """Several conditions joined by one word, `and` or `or`."""

    span: Span
    word: str
    parts: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Comparison:
    """A chain of comparisons, `0 s <= tcpa <= 300 s`: one more value than relations."""

    span: Span
    values: tuple[Expression, ...]
    relations: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Membership:
    """A value among some words."""

    span: Span
    value: Expression
    words: tuple[Word, ...]
    negated: bool


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """Two values joined by `+`, `-` or `*`."""

    span: Span
    sign: str
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class Minus:
    """A value with its sign turned."""

    span: Span
    part: Expression


Expression: TypeAlias = (
    Number | Word | Truth | Call | Negation | Junction | Comparison | Membership | Arithmetic | Minus
)


def parse(text: str) -> Expression:
    """Read a condition.

    Raises
    ------
    Fault
        With the first thing that is wrong, and its place.

    Examples
    --------
    >>> parse("own.length < 20 m").relations
    ('<',)
    """
    if len(text) > MAX_LENGTH:
        raise Fault(Span(0, 1), f"a condition of {len(text)} letters", expected=f"at most {MAX_LENGTH}")
    return _Parser(_tokens(text)).whole()


def is_name(text: str) -> bool:
    """Whether a text can be the name of a definition or a parameter.

    >>> is_name("small"), is_name("small craft"), is_name("or")
    (True, False, False)
    """
    return re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", text) is not None and text not in _KEYWORDS


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str  # number, name, mark or end
    text: str
    span: Span
    unit: str = ""


def _tokens(text: str) -> list[_Token]:
    tokens, at = [], 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise Fault(Span(at, at + 1), f"the character {text[at]!r} means nothing in a condition")
        kind, end = str(match.lastgroup), match.end()
        unit = ""
        if kind == "number":
            glued = re.compile(r"[A-Za-z_.]\S*").match(text, end)
            if glued:
                word = text[at : glued.end()]
                raise Fault(
                    Span(at, glued.end()), f"'{word}' is not a number", hint=_apart(match[0], glued[0])
                )
            if len(match[0]) > MAX_DIGITS or re.search(r"[eE][+-]?\d{3}", match[0]):
                raise Fault(Span(at, end), "a number beyond all measure", expected="at most 1e30")
            following = _UNIT.match(text, end)
            if following and following[1] not in _KEYWORDS:
                unit, end = following[1], following.end()
        if kind != "space":
            tokens.append(_Token(kind, match[0], Span(at, end), unit))
        at = end
    tokens.append(_Token("end", "", Span(len(text), len(text) + 1)))
    return tokens


def _apart(digits: str, word: str) -> str:
    return f"write '{digits} {word}'" if word[0] != "." else "a number is written like 20 or 22.5"


class _Parser:
    """Reads tokens from left to right; each method reads what it is named after."""

    def __init__(self, tokens: list[_Token]) -> None:
        self._tokens = tokens
        self._at = 0
        self._depth = 0

    def whole(self) -> Expression:
        if self._now.kind == "end":
            raise Fault(Span(0, 1), "an empty condition", expected="a condition, such as 'own.length < 20 m'")
        found = self._or()
        if self._now.kind != "end":
            self._refuse("the condition should end here, or go on with 'and' or 'or'")
        return found

    @property
    def _now(self) -> _Token:
        return self._tokens[self._at]

    def _take(self, *texts: str) -> _Token | None:
        token = self._now
        if token.kind in ("mark", "name") and token.text in texts:
            self._at += 1
            return token
        return None

    def _refuse(self, message: str, hint: str = "") -> NoReturn:
        token = self._now
        what = f"'{token.text}'" if token.kind != "end" else "the end"
        if token.text == "=":
            hint = "a comparison is written '=='"
        if token.text == "/":
            hint = "there is no division: multiply the other side"
        raise Fault(token.span, f"{what} is not expected here: {message}", hint=hint)

    def _nest(self, span: Span) -> None:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise Fault(
                span, f"nested more than {MAX_DEPTH} deep", hint="give a part of it a name under 'let'"
            )

    def _or(self) -> Expression:
        return self._junction("or")

    def _junction(self, word: str) -> Expression:
        def part() -> Expression:
            return self._junction("and") if word == "or" else self._not()

        parts = [part()]
        while self._take(word):
            parts.append(part())
        if len(parts) == 1:
            return parts[0]
        return Junction(Span(parts[0].span.begin, parts[-1].span.end), word, tuple(parts))

    def _not(self) -> Expression:
        token = self._take("not")
        if token is None:
            return self._comparison()
        self._nest(token.span)
        part = self._not()
        self._depth -= 1
        return Negation(Span(token.span.begin, part.span.end), part)

    def _comparison(self) -> Expression:
        values, relations = [self._sum()], []
        if self._now.text in ("in", "not") and self._now.kind == "name":
            return self._membership(values[0])
        while token := self._take(*RELATIONS):
            relations.append(token.text)
            values.append(self._sum())
        if not relations:
            return values[0]
        return Comparison(Span(values[0].span.begin, values[-1].span.end), tuple(values), tuple(relations))

    def _membership(self, value: Expression) -> Expression:
        negated = self._take("not") is not None
        if not self._take("in"):
            self._refuse("after 'not' between two values comes 'in'")
        if not self._take("("):
            self._refuse("after 'in' comes a list in parentheses, such as (sail, muscle)")
        words = [self._word()]
        while self._take(","):
            words.append(self._word())
        end = self._now.span.end
        if not self._take(")"):
            self._refuse("the list ends with ')'")
        return Membership(Span(value.span.begin, end), value, tuple(words), negated)

    def _word(self) -> Word:
        token = self._now
        if token.kind != "name" or token.text in _KEYWORDS:
            self._refuse("a list holds words")
        self._at += 1
        return Word(token.span, token.text)

    def _sum(self) -> Expression:
        left = self._product()
        while token := self._take("+", "-"):
            right = self._product()
            left = Arithmetic(Span(left.span.begin, right.span.end), token.text, left, right)
        return left

    def _product(self) -> Expression:
        left = self._sign()
        while self._take("*"):
            right = self._sign()
            left = Arithmetic(Span(left.span.begin, right.span.end), "*", left, right)
        return left

    def _sign(self) -> Expression:
        token = self._take("-")
        if token is None:
            return self._value()
        self._nest(token.span)
        part = self._sign()
        self._depth -= 1
        return Minus(Span(token.span.begin, part.span.end), part)

    def _value(self) -> Expression:
        token = self._now
        if self._take("("):
            self._nest(token.span)
            inner = self._or()
            self._depth -= 1
            if not self._take(")"):
                self._refuse(f"the parenthesis at letter {token.span.begin + 1} is still open")
            return inner
        if token.kind == "number":
            self._at += 1
            return Number(token.span, token.text, token.unit)
        if token.kind != "name" or token.text in _KEYWORDS - {"true", "false"}:
            self._refuse("a value is missing")
        self._at += 1
        if token.text in ("true", "false"):
            return Truth(token.span, token.text == "true")
        if self._now.text == "(":
            return self._call(token)
        return Word(token.span, token.text)

    def _call(self, name: _Token) -> Expression:
        self._take("(")
        self._nest(name.span)
        arguments = [self._sum()]
        while self._take(","):
            arguments.append(self._sum())
        end = self._now.span.end
        if not self._take(")"):
            self._refuse(f"the arguments of '{name.text}' end with ')'")
        self._depth -= 1
        return Call(Span(name.span.begin, end), name.text, tuple(arguments))
