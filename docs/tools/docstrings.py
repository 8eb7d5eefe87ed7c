"""Docstrings as reStructuredText for autodoc: plain prose and columns, then sections of numpydoc."""

from __future__ import annotations

import itertools
import re
from typing import Any

_COLUMNS = re.compile(r"[^\s.?:] {2,}\S")
_LABEL = re.compile(r"(Raises |[A-Za-z_]+(, [A-Za-z_]+)*: )")
_CODE = re.compile(r"(``[^`]+``|`[^`]+`)")
_MOTION = re.compile(r", motion=Motion\(steps=\(\)\)")
_MADE_BY_OTHERS = ("Shape", "Solid", "Sheet", "Hits", "Spans", "Crossings")  # users do not call these classes
_MARKS = re.compile(r"([*|\\_])")
_FIELDS = ("Parameters", "Returns", "Yields", "Raises", "Warns", "Attributes")
"""Sections whose entries are a name, a type, and an indented description."""
_CUSTOM = [("Attributes", "params_style")]
_PROSE = ("Notes", "Examples")
_UNDERLINE = re.compile(r"-{3,}$")


def process(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Handle the event "autodoc-process-docstring": replace the lines in place."""
    lines[:] = [] if what == "data" else rendered(lines)  # a number's docstring is that of all numbers


def signature(app: Any, what: str, name: str, obj: Any, options: Any, given: str | None, returned: str | None) -> Any:
    """Handle the event "autodoc-process-signature": leave out arguments that only the package itself passes."""
    if given is None:
        return None
    if what == "exception" or name.removeprefix("conicoid.") in _MADE_BY_OTHERS:
        return ("", None)
    return (_MOTION.sub("", given).replace(", *)", ")"), None)


def rendered(lines: list[str]) -> list[str]:
    """Return a docstring as reStructuredText; Sphinx's napoleon makes field lists of the sections."""
    from sphinx.ext.napoleon import Config
    from sphinx.ext.napoleon.docstring import NumpyDocstring

    # Attributes as a list of their own: napoleon's field `ivar` takes one name, and ours may be "body, face, surface".
    config = Config(napoleon_use_param=False, napoleon_use_rtype=False, napoleon_custom_sections=_CUSTOM)
    return list(NumpyDocstring(sectioned(lines), config).lines())


def sectioned(lines: list[str]) -> list[str]:
    """Return a docstring whose prose is reStructuredText, with numpydoc sections of escaped text."""
    starts = [i for i in range(len(lines) - 1) if lines[i] in (*_FIELDS, *_PROSE) and _UNDERLINE.match(lines[i + 1])]
    result = structured(lines[: starts[0]] if starts else lines)
    for start, end in itertools.pairwise([*starts, len(lines)]):
        name, body = lines[start], lines[start + 2 : end]
        result += [*lines[start : start + 2], *(_entries(name, body) if name in _FIELDS else structured(body)), ""]
    return result


def _entries(section: str, lines: list[str]) -> list[str]:
    """Return the entries of a section with marks escaped, apart from names of parameters."""
    result = []
    for line in lines:
        name, colon, kind = line.partition(" : ")
        if section in ("Parameters", "Attributes") and line[:1].strip():
            result.append(name + colon + escaped(kind))
        else:
            result.append(line[: len(line) - len(line.lstrip())] + escaped(line.strip()))
    while result and not result[-1]:
        result.pop()
    return result


def structured(lines: list[str]) -> list[str]:
    """Return prose as paragraphs, one for each label; columns and indented formulas stay as they are written."""
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
    """Return a line with its marks escaped; `code` becomes ``code``."""
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
