"""Docstrings as reStructuredText for autodoc. They are written to be read in a terminal: columns, and few marks."""

from __future__ import annotations

import re
from typing import Any

_COLUMNS = re.compile(r"[^\s.?:] {2,}\S")
_LABEL = re.compile(r"(Raises |[A-Za-z_]+(, [A-Za-z_]+)*: )")
_CODE = re.compile(r"(``[^`]+``|`[^`]+`)")
_MOTION = re.compile(r", motion=Motion\(steps=\(\)\)")
_MADE_BY_OTHERS = ("Shape", "Solid", "Sheet", "Hits", "Spans", "Crossings")  # users do not call these classes
_MARKS = re.compile(r"([*|\\_])")


def process(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """The event "autodoc-process-docstring"."""
    lines[:] = [] if what == "data" else structured(lines)  # a number's docstring is that of all numbers


def signature(app: Any, what: str, name: str, obj: Any, options: Any, given: str | None, returned: str | None) -> Any:
    """The event "autodoc-process-signature": what only the package itself may pass has no place in the reference."""
    if given is None:
        return None
    if what == "exception" or name.removeprefix("conicoid.") in _MADE_BY_OTHERS:
        return ("", None)
    return (_MOTION.sub("", given).replace(", *)", ")"), None)


def structured(lines: list[str]) -> list[str]:
    """Columns and indented formulas stay as they are written; the rest are paragraphs, one for each label."""
    result: list[str] = []
    for block in _blocks(lines):
        if any(_COLUMNS.search(line) for line in block[1:] or block) or all(line.startswith(" ") for line in block):
            result += ["::", "", *("   " + line for line in block), ""]
        else:
            for line in block:
                if _LABEL.match(line):
                    result.append("")
                result.append(escaped(line.strip()))
            result.append("")
    return result


def escaped(line: str) -> str:
    """A line without marks, but that `code` is code."""
    parts = _CODE.split(line)
    for k, part in enumerate(parts):
        if k % 2:
            ends = "\\ " if re.match(r"\w", parts[k + 1]) else ""  # `Body`s: the markup wants an end of the word
            parts[k] = "``" + part.strip("`") + "``" + ends
        else:
            parts[k] = _MARKS.sub(r"\\\1", part)
    return "".join(parts)


def _blocks(lines: list[str]) -> list[list[str]]:
    blocks: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            blocks[-1].append(line.rstrip())
        elif blocks[-1]:
            blocks.append([])
    return [block for block in blocks if block]
