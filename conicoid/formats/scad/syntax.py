"""The text of a .csg file as a tree of calls: name, arguments and children.

`openscad -o model.csg model.scad` writes what is left of a program when it has been run: no variables, loops or
functions, only calls such as `cube(size = [1, 2, 3], center = false);` and `difference() { ... }`.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from ..errors import Problem, SceneFileError
from ..nodes import shortened

MOST_BYTES, MOST_CALLS, DEEPEST = 1 << 26, 1_000_000, 200
_TOKEN = re.compile(
    r"[ \t\r\n]+|//[^\n]*|/\*.*?\*/"
    r"|(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?inf\b|-?nan\b)"
    r"|(?P<name>\$?[A-Za-z_][A-Za-z0-9_]*)"
    r'|(?P<text>"(?:[^"\\]|\\.)*")'
    r"|(?P<sign>[()\[\]{},;=%#!*])",
    re.S,
)


@dataclass
class Call:
    """A call of a module. `position` is where it stands, and `modifier` one of % # ! * or nothing."""

    name: str
    position: int
    arguments: dict[str, Any] = field(default_factory=dict)
    children: list[Call] = field(default_factory=list)
    modifier: str = ""


class Text:
    """A text with its lines, and how mistakes in it are told."""

    def __init__(self, path: Path) -> None:
        size = path.stat().st_size
        if size > MOST_BYTES:
            told = f"has {size / 1e6:,.0f} MB, at most {MOST_BYTES / 1e6:,.0f} are read"
            raise SceneFileError(path, [Problem(0, 0, "file", told)])
        self.path, self.text = path, path.read_bytes().decode("utf-8", "replace").removeprefix("\ufeff")

    def mistake(self, position: int, where: str, message: str) -> SceneFileError:
        """What is wrong at a place."""
        return SceneFileError(self.path, [Problem(*self.place(position), where, message)])

    def place(self, position: int) -> tuple[int, int]:
        """(line, column), from 1."""
        line = bisect_left(self._ends, position)
        return line + 1, position - (self._ends[line - 1] if line else -1)

    @cached_property
    def _ends(self) -> list[int]:
        """Where lines end: a file may have as many remarks as calls."""
        return [found.start() for found in re.finditer("\n", self.text)]


@dataclass
class _Token:
    kind: str
    text: str
    position: int


class Reader:
    """Reads one text. Nothing here calls itself deeper than the text is nested, which has a limit."""

    def __init__(self, text: Text) -> None:
        self._source, self._at, self._calls = text, 0, 0
        self._token = self._scanned()

    def _scanned(self) -> _Token:
        """The next token."""
        text = self._source.text
        while self._at < len(text):
            found = _TOKEN.match(text, self._at)
            if found is None:
                raise self._source.mistake(self._at, "text", f"must be a call, got {text[self._at : self._at + 20]!r}")
            begin, self._at = self._at, found.end()
            if found.lastgroup:
                return _Token(found.lastgroup, found[0], begin)
        return _Token("end", "", len(text))

    def _taken(self) -> _Token:
        token, self._token = self._token, self._scanned()
        return token

    def _is(self, sign: str) -> bool:
        return self._token.kind == "sign" and self._token.text == sign

    def _expect(self, sign: str) -> None:
        if not self._is(sign):
            raise self._unexpected(repr(sign))
        self._taken()

    def _unexpected(self, expected: str) -> SceneFileError:
        token = self._token
        found = "the end of the file" if token.kind == "end" else repr(shortened(token.text))
        return self._source.mistake(token.position, "text", f"must be {expected}, got {found}")

    def calls(self, depth: int = 0) -> list[Call]:
        """Calls up to a closing brace, or to the end of the file."""
        self._check_depth(depth)
        found: list[Call] = []
        while self._token.kind != "end" and not self._is("}"):
            if self._is(";"):
                self._taken()
                continue
            found.append(self._call(depth))
        return found

    def _check_depth(self, depth: int) -> None:
        if depth > DEEPEST:
            raise self._source.mistake(self._token.position, "text", f"is nested more than {DEEPEST} deep")

    def _call(self, depth: int) -> Call:
        modifier = ""
        while self._token.kind == "sign" and self._token.text in "%#!*":
            modifier += self._taken().text
        if self._token.kind != "name":
            raise self._unexpected("the name of a module")
        name = self._taken()
        self._calls += 1
        if self._calls > MOST_CALLS:
            raise self._source.mistake(name.position, "text", f"has more than {MOST_CALLS:,} calls")
        call = Call(name.text, name.position, modifier=modifier)
        if self._is("="):
            told = "is a program; `openscad -o model.csg model.scad` runs it and writes what can be read"
            raise self._source.mistake(name.position, name.text, told)
        self._expect("(")
        self._arguments(call)
        if self._is("{"):
            self._taken()
            call.children = self.calls(depth + 1)
            self._expect("}")
        elif self._is(";"):
            self._taken()
        else:
            self._check_depth(depth + 1)
            call.children = [self._call(depth + 1)]
        return call

    def _arguments(self, call: Call) -> None:
        while not self._is(")"):
            name = f"{len(call.arguments)}"
            if self._token.kind == "name":
                token = self._taken()
                if self._is("="):
                    self._taken()
                    name = token.text
                    call.arguments[name] = self._value(0)
                else:
                    call.arguments[name] = self._word(token)
            else:
                call.arguments[name] = self._value(0)
            if not self._is(")"):
                self._expect(",")
        self._taken()

    def _value(self, depth: int) -> Any:
        """A number, True, False, None, a text or a list."""
        token = self._token
        if token.kind == "number":
            return float(self._taken().text)
        if token.kind == "text":
            return self._taken().text[1:-1]
        if token.kind == "name":
            return self._word(self._taken())
        if not self._is("[") or depth > DEEPEST:
            raise self._unexpected("a number, a text, true, false, undef or a list")
        self._taken()
        values = []
        while not self._is("]"):
            values.append(self._value(depth + 1))
            if not self._is("]"):
                self._expect(",")
        self._taken()
        return values

    def _word(self, token: _Token) -> Any:
        known = {"true": True, "false": False, "undef": None}
        if token.text not in known:
            expected = "a number, a text, true, false, undef or a list"
            raise self._source.mistake(token.position, "text", f"must be {expected}, got {shortened(token.text)!r}")
        return known[token.text]

    def end(self) -> None:
        """Nothing may be left."""
        if self._token.kind != "end":
            raise self._unexpected("a call")
