"""The letters of a scene file before they are parsed: what is refused of them, and where they stand."""

from __future__ import annotations

import re

from .errors import Problem
from .nodes import shortened

_BREAKS = "\n\r\x85\u2028\u2029"
"""What ends a line in YAML."""


class Unreadable(Exception):
    """The text has no tree; `problem` says why and where."""

    def __init__(self, line: int, column: int, message: str) -> None:
        self.problem = Problem(line, column, "", message)
        super().__init__(message)


def place(text: str, position: int) -> tuple[int, int]:
    """Line and column, from 1, of a position in a text."""
    return text.count("\n", 0, position) + 1, position - (text.rfind("\n", 0, position) + 1) + 1


def line_numbers(text: str) -> list[int]:
    """A number for each line that a parser may see, and one more."""
    return list(range(1, 3 + sum(text.count(each) for each in _BREAKS)))


def check_directives(text: str) -> None:
    """Only a %YAML line may stand before the document (libyaml is slow on many %TAG lines)."""
    if not text.startswith("%") and "\n%" not in text:
        return
    found = re.search(r"^%(?!YAML 1\.).*", text, re.MULTILINE)
    if found and not re.search(r"^[ \t]*[^\s#%]", text[: found.start()], re.MULTILINE):
        message = f"directive {shortened(found.group().strip())!r} is not allowed in scene files"
        raise Unreadable(*place(text, found.start()), message)


def joined_surrogates(text: str) -> str:
    """JSON writes a character beyond U+FFFF as two escapes; YAML as one character."""
    if "\\" not in text or not re.search(r"\\u[dD][89abAB]", text):
        return text

    def joined(match: re.Match[str]) -> str:
        if match.group(1) is None:
            return match.group()
        high, low = int(match.group(1), 16), int(match.group(2), 16)
        return chr(0x10000 + ((high - 0xD800) << 10) + (low - 0xDC00))

    return re.sub(
        r"\\(?:u([dD][89abAB]{hex})\\u([dD][c-fC-F]{hex})|.)".replace("{hex}", "[0-9a-fA-F]{2}"), joined, text
    )
