"""The blocks of an explanation, headings, lines with their source and tables, and their output as text and HTML."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from dataclasses import field
from typing import TypeAlias

from ..._util.records import dataclass


@dataclass(frozen=True)
class Heading:
    """A heading of level 1, 2 or 3."""

    text: str
    level: int = 1


@dataclass(frozen=True)
class TextLine:
    """A sentence or a formula; `source` is the document that it comes from, `depth` its indentation."""

    text: str
    source: str = ""
    depth: int = 1


@dataclass(frozen=True)
class TextTable:
    """Rows of cells under a head."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    source: str = ""
    depth: int = 1


Block: TypeAlias = Heading | TextLine | TextTable


@dataclass(frozen=True)
class Board:
    """One step as a lecturer writes it: lines with their source, and the numbers in them by name.

    The numbers come from exact arithmetic and are rounded once; they are not those of the kernels.
    """

    blocks: tuple[Block, ...]
    numbers: dict[str, float] = field(default_factory=dict)


# The documents that formulas come from.


class Citation:
    """The sources of formulas, by the names that docs/theory.md has for them."""

    NOTES = "the ray tracing notes"
    CLEMSON = "the Clemson notes"
    SASAKI = "Sasaki 2021"
    TEXTBOOK = "the graphics textbook"
    ROTH = "Roth 1982"

    SPHERE_ALGEBRAIC = f'{NOTES}, "ray and sphere", the algebraic method'
    SPHERE_GEOMETRIC = f'{NOTES}, "ray and sphere", the geometric method'
    PLANE = f'{NOTES}, "ray and plane"'
    POLYGON = f'{NOTES}, "ray and polygon", even-odd'
    AREAS = f"{NOTES}, barycentric coordinates"
    BOX = f'{NOTES}, "ray and box"'
    QUADRIC = f'{NOTES}, "ray and quadrics"; {CLEMSON} (13.3), (13.4)'
    NORMAL = f'{NOTES}, "ray and quadrics", steps 6 and 7'
    CYLINDER = f"{SASAKI} (2) to (10)"
    CAPS = f"{CLEMSON}, caps"
    FALSE = f"{TEXTBOOK}, false intersections; NA8FIR"
    TOUCH = f"{TEXTBOOK}, tangency is invisibility"
    ROOTS = f"{TEXTBOOK}, KVADR; Goldberg 1991"
    BOOLEAN = f"{ROTH}; docs/theory.md, section 8"
    MOMENT = "docs/theory.md, section 10"
    STARTS = "docs/theory.md, section 12"
    DOUBT = "docs/dev/exactness.md"


# Blocks as self-contained HTML: no script, no style sheet, nothing from a network.

# Single letters are variables, unless they are part of a word, an entity or a tag
_LETTER = re.compile(r"(?<![\w&#;<])([A-Za-zα-ω])(?=[²³₀₁₂₊₋]|[^\w;]|$)")
_INDEX = re.compile(r"(?<!\w)([vtR])_(near|far|ca|hc|d|0|X|Y|Z)\b")
_SUPERSCRIPTS = {"²": "2", "ᵗ": "t", "³": "3"}
_SUBSCRIPTS = {"₀": "0", "₁": "1", "₂": "2", "₊": "+", "₋": "−"}
_STYLE = {
    "source": "color: #777; font-size: 85%; margin-left: .8em",
    "all": "font: 14px/1.5 system-ui, sans-serif; max-width: 60rem",
    "table": "border-collapse: collapse; margin: .3em 0 .6em",
    "cell": "text-align: left; padding: .1em .9em .1em 0; border-bottom: 1px solid #8884; vertical-align: top",
}


def html_of(blocks: Sequence[Block], picture: str = "") -> str:
    """Return all blocks as HTML; `picture` follows the answer, ahead of the third heading."""
    parts = [f'<div class="conicoid-explanation" style="{_STYLE["all"]}">']
    headings = 0
    for block in blocks:
        if isinstance(block, Heading):
            headings += 1
            # The ray and the answer have the first two headings
            if headings == 3 and picture:
                parts.append(picture)
                picture = ""
            parts.append(f"<h{block.level + 2}>{html.escape(block.text)}</h{block.level + 2}>")
        elif isinstance(block, TextLine):
            inset = f"margin: .1em 0 .1em {1.2 * (block.depth - 1):.1f}em"
            parts.append(f'<p style="{inset}">{html_formula(block.text)}{_html_source(block.source)}</p>')
        else:
            parts.append(_html_table(block))
    return "\n".join([*parts, picture, "</div>"])


def html_formula(text: str) -> str:
    """Return a line as HTML with single letters in italics, powers raised and indices lowered."""
    # Escape first: the tags that follow must stay
    marked = _LETTER.sub(r"<i>\1</i>", html.escape(text, quote=False))
    marked = _INDEX.sub(r"<i>\1</i><sub>\2</sub>", marked)
    for sign, plain in _SUPERSCRIPTS.items():
        marked = marked.replace(sign, f"<sup>{plain}</sup>")
    for sign, plain in _SUBSCRIPTS.items():
        marked = marked.replace(sign, f"<sub>{plain}</sub>")
    return marked


def _html_source(source: str) -> str:
    """Return the source of a line; nothing if it has none."""
    return f'<span style="{_STYLE["source"]}">{html.escape(source)}</span>' if source else ""


def _html_table(block: TextTable) -> str:
    """Return a table as HTML."""
    inset = f"margin-left: {1.2 * (block.depth - 1):.1f}em; "
    head = "".join(f'<th scope="col" style="{_STYLE["cell"]}">{html_formula(cell)}</th>' for cell in block.head)
    rows = "".join(f"<tr>{''.join(_html_cell(cell) for cell in row)}</tr>" for row in block.rows)
    return f'<table style="{inset}{_STYLE["table"]}"><tr>{head}</tr>{rows}</table>{_html_source(block.source)}'


def _html_cell(text: str) -> str:
    """Return a cell of a table; its text is no formula, so letters stay upright."""
    return f'<td style="{_STYLE["cell"]}">{html.escape(text)}</td>'


# Blocks as text for a terminal.

_TEXT_INDENT = "  "


def text_of(blocks: Sequence[Block]) -> str:
    """Return all blocks as lines of text."""
    lines: list[str] = []
    for block in blocks:
        if isinstance(block, Heading):
            lines += _text_heading(block, bool(lines))
        elif isinstance(block, TextLine):
            lines.append(_TEXT_INDENT * block.depth + block.text + _text_source(block.source))
        else:
            lines += _text_table(block)
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _text_source(source: str) -> str:
    """Return the source of a line in brackets; nothing if it has none."""
    return f"   [{source}]" if source else ""


def _text_heading(block: Heading, follows: bool) -> list[str]:
    """Return the lines of a heading, underlined at levels 1 and 2; `more` if lines stand before it."""
    if block.level == 3:
        return [f"{_TEXT_INDENT}{block.text}:"]
    under = {1: "=", 2: "-"}[block.level] * len(block.text)
    return [*([""] if follows else []), block.text, under]


def _text_table(block: TextTable) -> list[str]:
    """Return the lines of a table, its columns padded to equal widths."""
    rows = [block.head, *block.rows]
    widths = [max(len(row[k]) for row in rows) for k in range(len(block.head))]
    # Columns are two spaces apart
    padded = [
        _TEXT_INDENT * block.depth + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        for row in rows
    ]
    return [padded[0].rstrip() + _text_source(block.source), *padded[1:]]
