"""The text of a .csg file as a tree of calls: name, arguments and children.

`openscad -o model.csg model.scad` writes what is left of a program when it has been run: no variables, loops or
functions, only calls such as `cube(size = [1, 2, 3], center = false);` and `difference() { ... }`.
"""

from __future__ import annotations

import math
import re
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ..._util.file_errors import Problem, SceneFileError
from ..._util.validation import format_value
from ..scene_file.nodes import shorten

MAX_CSG_BYTES, MAX_CALLS, MAX_CALL_DEPTH = 1 << 26, 1_000_000, 200
_TOKEN = re.compile(
    r"[ \t\r\n]+|//[^\n]*|/\*.*?\*/"
    r"|(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?inf\b|-?nan\b)"
    r"|(?P<name>\$?[A-Za-z_][A-Za-z0-9_]*)"
    r'|(?P<text>"(?:[^"\\]|\\.)*")'
    r"|(?P<sign>[()\[\]{},;=%#!*])",
    re.S,
)


@dataclass
class CsgCall:
    """A call of a module. `position` is where it stands, and `modifier` one of % # ! * or nothing."""

    name: str
    position: int
    arguments: dict[str, Any] = field(default_factory=dict)
    children: list[CsgCall] = field(default_factory=list)
    modifier: str = ""


class CsgText:
    """A text with its lines, and how mistakes in it are told."""

    def __init__(self, path: Path) -> None:
        size = path.stat().st_size
        if size > MAX_CSG_BYTES:
            told = f"has {size / 1e6:,.0f} MB, at most {MAX_CSG_BYTES / 1e6:,.0f} are read"
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
class _CsgToken:
    kind: str
    text: str
    position: int


class CsgReader:
    """Reads one text. Nothing here calls itself deeper than the text is nested, which has a limit."""

    def __init__(self, text: CsgText) -> None:
        self._source, self._at, self._calls = text, 0, 0
        self._token = self._scanned()

    def _scanned(self) -> _CsgToken:
        """The next token."""
        text = self._source.text
        while self._at < len(text):
            found = _TOKEN.match(text, self._at)
            if found is None:
                raise self._source.mistake(self._at, "text", f"must be a call, got {text[self._at : self._at + 20]!r}")
            begin, self._at = self._at, found.end()
            if found.lastgroup:
                return _CsgToken(found.lastgroup, found[0], begin)
        return _CsgToken("end", "", len(text))

    def _taken(self) -> _CsgToken:
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
        found = "the end of the file" if token.kind == "end" else repr(shorten(token.text))
        return self._source.mistake(token.position, "text", f"must be {expected}, got {found}")

    def calls(self, depth: int = 0) -> list[CsgCall]:
        """Calls up to a closing brace, or to the end of the file."""
        self._check_depth(depth)
        found: list[CsgCall] = []
        while self._token.kind != "end" and not self._is("}"):
            if self._is(";"):
                self._taken()
                continue
            found.append(self._call(depth))
        return found

    def _check_depth(self, depth: int) -> None:
        if depth > MAX_CALL_DEPTH:
            raise self._source.mistake(self._token.position, "text", f"is nested more than {MAX_CALL_DEPTH} deep")

    def _call(self, depth: int) -> CsgCall:
        modifier = ""
        while self._token.kind == "sign" and self._token.text in "%#!*":
            modifier += self._taken().text
        if self._token.kind != "name":
            raise self._unexpected("the name of a module")
        name = self._taken()
        self._calls += 1
        if self._calls > MAX_CALLS:
            raise self._source.mistake(name.position, "text", f"has more than {MAX_CALLS:,} calls")
        call = CsgCall(name.text, name.position, modifier=modifier)
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

    def _arguments(self, call: CsgCall) -> None:
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
        if not self._is("[") or depth > MAX_CALL_DEPTH:
            raise self._unexpected("a number, a text, true, false, undef or a list")
        self._taken()
        values = []
        while not self._is("]"):
            values.append(self._value(depth + 1))
            if not self._is("]"):
                self._expect(",")
        self._taken()
        return values

    def _word(self, token: _CsgToken) -> Any:
        known = {"true": True, "false": False, "undef": None}
        if token.text not in known:
            expected = "a number, a text, true, false, undef or a list"
            raise self._source.mistake(token.position, "text", f"must be {expected}, got {shorten(token.text)!r}")
        return known[token.text]

    def end(self) -> None:
        """Nothing may be left."""
        if self._token.kind != "end":
            raise self._unexpected("a call")


# Arguments of a call as numbers, lists and matrices, with mistakes told at the call.

ArgumentValue = TypeVar("ArgumentValue")


class CallArguments:
    """The arguments of one call, asked for by name."""

    def __init__(self, text: CsgText, call: CsgCall) -> None:
        self._text, self.call = text, call

    def refuse(self, message: str) -> Exception:
        """What is wrong with the call."""
        return self._text.mistake(self.call.position, self.call.name, message)

    def given(self, name: str) -> Any:
        """A value, None where it is not given."""
        return self.call.arguments.get(name)

    def number(self, name: str, otherwise: float) -> float:
        """A finite number."""
        value = self.given(name)
        if value is None:
            return otherwise
        if isinstance(value, bool) or not isinstance(value, float) or not math.isfinite(value):
            raise self.refuse(f"{name} must be a finite number, got {format_value(value)}")
        return value

    def flag(self, name: str) -> bool:
        """True or false; false where it is not given."""
        value = self.given(name)
        if value is not None and not isinstance(value, bool):
            raise self.refuse(f"{name} must be true or false, got {format_value(value)}")
        return bool(value)

    def rows(self, name: str, width: int) -> list[tuple[float, ...]]:
        """A list of points of so many finite numbers."""
        value = self.given(name)
        try:
            rows = [tuple(float(number) for number in row) for row in value]
        except (TypeError, ValueError):
            raise self.refuse(f"{name} must be a list of points, got {format_value(value)}") from None
        for k, row in enumerate(rows):
            if len(row) != width or not all(map(math.isfinite, row)):
                raise self.refuse(f"{name}[{k}] must be {width} finite numbers, got {format_value(row)}")
        return rows

    def paths(self, name: str, count: int) -> list[tuple[int, ...]]:
        """A list of lists of numbers of points."""
        value = self.given(name)
        found = []
        for k, row in enumerate(value if isinstance(value, list) else [value]):
            numbers = row if isinstance(row, list) else [row]
            whole = [int(n) for n in numbers if isinstance(n, float) and n == n // 1 and 0 <= n < count]
            if len(whole) != len(numbers) or len(whole) < 3:
                raise self.refuse(
                    f"{name}[{k}] must be three or more numbers of points below {count}, got {format_value(row)}"
                )
            found.append(tuple(whole))
        return found

    def matrix(self) -> np.ndarray[Any, Any]:
        """(4, 4) of multmatrix, whose last row may be left out."""
        rows = self.given("m") or self.given("0")
        try:
            found = np.array(rows, np.float64)
        except (TypeError, ValueError):
            found = np.zeros(0)
        if found.shape == (3, 4):
            found = np.vstack([found, [0, 0, 0, 1]])
        if found.shape != (4, 4) or not np.isfinite(found).all() or found[3].tolist() != [0, 0, 0, 1]:
            raise self.refuse(f"m must be four rows of four finite numbers, the last 0 0 0 1, got {format_value(rows)}")
        return found

    def sides(self, smooth: bool) -> int:
        """How many sides a circle has that is asked for as a polygon by $fn; 0 for a round one."""
        value = self.given("$fn")
        if smooth or not isinstance(value, float) or not value > 0:
            return 0
        if value > 10_000:
            raise self.refuse(f"$fn must be at most 10,000, got {value:g}")
        return max(3, int(value))

    def made(self, make: Callable[[], ArgumentValue]) -> ArgumentValue:
        """make(), with what shapes refuse told at the call."""
        try:
            return make()
        except SceneFileError:
            raise
        except (ValueError, ArithmeticError) as error:
            raise self.refuse(str(error)) from None
