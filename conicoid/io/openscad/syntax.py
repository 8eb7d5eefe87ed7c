"""Parser of .csg files into a tree of calls, and typed access to the arguments of a call.

`openscad -o model.csg model.scad` runs a program and writes its result: no variables, loops or functions, only calls
such as `cube(size = [1, 2, 3], center = false);` and `difference() { ... }`.
"""

from __future__ import annotations

import math
import re
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ..._util.files import Problem, SceneFileError, read_bounded
from ..._util.records import dataclass
from ..._util.validation import format_value
from ..importers import OmittedPart
from ..scene_file.nodes import shorten

MAX_CSG_BYTES, MAX_CALLS, MAX_CALL_DEPTH = 1 << 26, 1_000_000, 200
"""Most bytes and calls of a file, and most levels of calls within calls and lists within lists."""
_STATEMENTS = ("module", "function", "for", "intersection_for", "if", "let", "assign", "use", "include")
"""The first words of statements that OpenSCAD runs before it writes a .csg."""
# Blanks and comments, which belong to no group, are skipped.
_TOKEN = re.compile(
    r"[ \t\r\n]+|//[^\n]*|/\*.*?\*/"
    r"|(?P<number>[-+]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][-+]?\d+)?|[-+]?inf\b|-?nan\b)"
    r"|(?P<name>\$?[A-Za-z_][A-Za-z0-9_]*)"
    r'|(?P<text>"(?:[^"\\]++|\\.)*+")'
    r"|(?P<sign>[()\[\]{},;=%#!*])",
    re.S,
)


@dataclass
class CsgCall:
    """A call of a module; `position` is its offset in the text, `modifier` has the signs % # ! * before it."""

    name: str
    position: int
    arguments: dict[str, Any] = field(default_factory=dict)
    children: list[CsgCall] = field(default_factory=list)
    modifier: str = ""


class CsgText:
    """The text of a file, with errors at lines and columns. Raise SceneFileError for a file that is too large."""

    def __init__(self, path: Path) -> None:
        raw = read_bounded(path, MAX_CSG_BYTES)
        self.path, self.text = path, raw.decode("utf-8", "replace").removeprefix("\ufeff")

    def mistake(self, position: int, where: str, message: str) -> SceneFileError:
        """Return an error at a position."""
        return SceneFileError(self.path, [Problem(*self.place(position), where, message)])

    def place(self, position: int) -> tuple[int, int]:
        """Return (line, column) of a position, from 1."""
        line = bisect_left(self._ends, position)
        return line + 1, position - (self._ends[line - 1] if line else -1)

    @cached_property
    def _ends(self) -> list[int]:
        """Positions of line ends, cached: a file may have as many remarks as calls."""
        return [match.start() for match in re.finditer("\n", self.text)]


@dataclass
class _CsgToken:
    kind: str
    text: str
    position: int


class CsgReader:
    """A recursive descent parser of one text. All methods raise SceneFileError at the first error.

    It recurses no deeper than the text is nested, which `MAX_CALL_DEPTH` limits.
    """

    def __init__(self, text: CsgText) -> None:
        self._source, self._at, self._calls = text, 0, 0
        self._token = self._scan()

    def _scan(self) -> _CsgToken:
        """Return the next token after blanks and comments."""
        text = self._source.text
        while self._at < len(text):
            match = _TOKEN.match(text, self._at)
            if match is None:
                raise self._source.mistake(self._at, "text", f"must be a call, got {text[self._at : self._at + 20]!r}")
            begin, self._at = self._at, match.end()
            if match.lastgroup:
                return _CsgToken(match.lastgroup, match[0], begin)
        return _CsgToken("end", "", len(text))

    def _take(self) -> _CsgToken:
        """Return the current token and go on to the next."""
        token, self._token = self._token, self._scan()
        return token

    def _is(self, sign: str) -> bool:
        return self._token.kind == "sign" and self._token.text == sign

    def _expect(self, sign: str) -> None:
        if not self._is(sign):
            raise self._mismatch(repr(sign))
        self._take()

    def _mismatch(self, expected: str) -> SceneFileError:
        token = self._token
        text = "the end of the file" if token.kind == "end" else repr(shorten(token.text))
        return self._source.mistake(token.position, "text", f"must be {expected}, got {text}")

    def calls(self, depth: int = 0) -> list[CsgCall]:
        """Return the calls up to a closing brace or the end of the file."""
        self._check_depth(depth)
        calls: list[CsgCall] = []
        while self._token.kind != "end" and not self._is("}"):
            if self._is(";"):
                self._take()
                continue
            calls.append(self._call(depth))
        return calls

    def _check_depth(self, depth: int) -> None:
        if depth > MAX_CALL_DEPTH:
            raise self._source.mistake(self._token.position, "text", f"is nested more than {MAX_CALL_DEPTH} deep")

    def _call(self, depth: int) -> CsgCall:
        """Return one call with its children."""
        modifier = ""
        while self._token.kind == "sign" and self._token.text in "%#!*":
            modifier += self._take().text
        if self._token.kind != "name":
            raise self._mismatch("the name of a module")
        name = self._take()
        self._calls += 1
        if self._calls > MAX_CALLS:
            raise self._source.mistake(name.position, "text", f"has more than {MAX_CALLS:,} calls")
        call = CsgCall(name.text, name.position, modifier=modifier)
        if self._is("=") or name.text in _STATEMENTS:
            message = "is a program; `openscad -o model.csg model.scad` runs it and writes what can be read"
            raise self._source.mistake(name.position, name.text, message)
        self._expect("(")
        self._arguments(call)
        if self._is("{"):
            self._take()
            call.children = self.calls(depth + 1)
            self._expect("}")
        elif self._is(";"):
            self._take()
        else:  # one child without braces
            self._check_depth(depth + 1)
            call.children = [self._call(depth + 1)]
        return call

    def _arguments(self, call: CsgCall) -> None:
        """Read the arguments of a call; those without a name have that of the module's parameter at their place."""
        names = iter(PARAMETERS.get(call.name, ("",))[0].split())
        while not self._is(")"):
            name = ""
            if self._token.kind == "name":
                token = self._take()
                if self._is("="):
                    self._take()
                    name, value = token.text, self._value(0)
                else:
                    value = self._word(token)
            else:
                value = self._value(0)
            free = (each for each in names if each not in call.arguments)
            call.arguments[name or next(free, f"argument {len(call.arguments) + 1}")] = value
            if not self._is(")"):
                self._expect(",")
        self._take()

    def _value(self, depth: int) -> Any:
        """Return a value: a float, True, False, None, a text or a list of values."""
        token = self._token
        if token.kind == "number":
            return float(self._take().text)
        if token.kind == "text":
            return self._take().text[1:-1]
        if token.kind == "name":
            return self._word(self._take())
        if not self._is("[") or depth > MAX_CALL_DEPTH:
            raise self._mismatch("a number, a text, true, false, undef or a list")
        self._take()
        values = []
        while not self._is("]"):
            values.append(self._value(depth + 1))
            if not self._is("]"):
                self._expect(",")
        self._take()
        return values

    def _word(self, token: _CsgToken) -> bool | None:
        """Return the value of true, false or undef."""
        constants = {"true": True, "false": False, "undef": None}
        if token.text not in constants:
            expected = "a number, a text, true, false, undef or a list"
            raise self._source.mistake(token.position, "text", f"must be {expected}, got {shorten(token.text)!r}")
        return constants[token.text]

    def end(self) -> None:
        """Raise SceneFileError if text is left after the calls."""
        if self._token.kind != "end":
            raise self._mismatch("a call")


# Arguments of a call

PARAMETERS = {
    "cube": ("size center",), "sphere": ("r", "d"), "cylinder": ("h r1 r2 center", "r d d1 d2"), "circle": ("r", "d"),
    "square": ("size center",), "polygon": ("points paths convexity",), "multmatrix": ("m",), "color": ("c",),
    "polyhedron": ("points faces convexity", "triangles"),
    "linear_extrude": ("height", "h v center scale twist slices segments convexity"),
    "rotate_extrude": ("angle", "start convexity"),
}  # fmt: skip
"""Parameters of modules in the order of arguments without names, and those that only names give."""

ArgumentValue = TypeVar("ArgumentValue")


class CallArguments:
    """The arguments of one call by name, as numbers, lists and matrices.

    All methods raise SceneFileError at the call for a value of another kind.
    """

    def __init__(self, text: CsgText, call: CsgCall) -> None:
        self._text, self.call = text, call

    def refuse(self, message: str) -> Exception:
        """Return an error at the call."""
        return self._text.mistake(self.call.position, self.call.name, message)

    def value(self, name: str) -> Any:
        """Return the value of an argument; None if it is missing."""
        return self.call.arguments.get(name)

    def number(self, name: str, otherwise: float) -> float:
        """Return a finite number; `otherwise` if it is missing. Raise OmittedPart for others, as OpenSCAD goes on."""
        value = self.value(name)
        if value is None:
            return otherwise
        if isinstance(value, bool) or not isinstance(value, float):
            raise self.refuse(f"{name} must be a finite number, got {format_value(value)}")
        if not math.isfinite(value):
            raise OmittedPart(f"has the {name} {value:g}")
        return value

    def radius(self, end: str, otherwise: float) -> float:
        """Return a radius, or half of a diameter, which OpenSCAD takes if both are given; `end` ends their names."""
        return self.number(f"d{end}", 2 * self.number(f"r{end}", otherwise)) / 2

    def unknown(self) -> list[str]:
        """Return the names of arguments that the module does not have; $ begins those of all modules."""
        known = " ".join(PARAMETERS.get(self.call.name, ())).split() or self.call.arguments
        return [name for name in self.call.arguments if name not in known and not name.startswith("$")]

    def flag(self, name: str) -> bool:
        """Return a flag; False if it is missing."""
        value = self.value(name)
        if value is not None and not isinstance(value, bool):
            raise self.refuse(f"{name} must be true or false, got {format_value(value)}")
        return bool(value)

    def rows(self, name: str, width: int) -> list[tuple[float, ...]]:
        """Return a list of points of `width` finite numbers each. Raise OmittedPart if it is missing."""
        value = self.value(name)
        if value is None:
            raise OmittedPart(f"has no {name}")
        try:
            rows = [tuple(float(number) for number in row) for row in value]
        except (TypeError, ValueError):
            raise self.refuse(f"{name} must be a list of points, got {format_value(value)}") from None
        for k, row in enumerate(rows):
            if len(row) != width:
                raise self.refuse(f"{name}[{k}] must be {width} finite numbers, got {format_value(row)}")
            if not all(map(math.isfinite, row)):
                raise OmittedPart(f"has the point {format_value(row)}")
        return rows

    def paths(self, name: str, count: int) -> list[tuple[int, ...]]:
        """Return a list of paths, three or more indices of points below `count` each. Raise OmittedPart if missing."""
        value = self.value(name)
        if value is None:
            raise OmittedPart(f"has no {name}")
        paths = []
        for k, row in enumerate(value if isinstance(value, list) else [value]):
            numbers = row if isinstance(row, list) else [row]
            # The parser knows floats only, as OpenSCAD does
            whole = [int(n) for n in numbers if isinstance(n, float) and n == n // 1 and 0 <= n < count]
            if len(whole) != len(numbers) or len(whole) < 3:
                raise self.refuse(
                    f"{name}[{k}] must be three or more numbers of points below {count}, got {format_value(row)}"
                )
            paths.append(tuple(whole))
        return paths

    def matrix(self) -> np.ndarray[Any, Any]:
        """Return the matrix (4, 4) of a multmatrix, whose last row may be missing."""
        rows = self.value("m")
        try:
            matrix = np.array(rows, np.float64)
        except (TypeError, ValueError):
            matrix = np.zeros(0)
        if matrix.shape == (3, 4):
            matrix = np.vstack([matrix, [0, 0, 0, 1]])
        if matrix.shape != (4, 4) or matrix[3].tolist() != [0, 0, 0, 1]:
            raise self.refuse(f"m must be four rows of four numbers, the last 0 0 0 1, got {format_value(rows)}")
        return matrix

    def sides(self, smooth: bool) -> int:
        """Return the number of sides that $fn gives a circle; 0 for a round one, which `smooth` makes of all."""
        value = self.value("$fn")
        if smooth or not isinstance(value, float) or not value > 0:
            return 0
        if value > 10_000:
            raise self.refuse(f"$fn must be at most 10,000, got {value:g}")
        # OpenSCAD draws a circle with at least three sides, and drops the fraction of $fn
        return max(3, int(value))

    def build(self, make: Callable[[], ArgumentValue]) -> ArgumentValue:
        """Return make(); raise the errors of shapes as errors at the call."""
        try:
            return make()
        except SceneFileError:
            raise
        except (ValueError, ArithmeticError) as error:
            raise self.refuse(str(error)) from None
