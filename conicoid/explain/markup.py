"""Blocks as HTML in itself: no script, no style sheet, nothing from a network."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence

from .blocks import Block, Heading, Line, Table

_LETTER = re.compile(r"(?<![\w&#;<])([A-Za-zα-ω])(?=[²³₀₁₂₊₋]|[^\w;]|$)")
_INDEX = re.compile(r"(?<!\w)([vtR])_(near|far|ca|hc|d|0|X|Y|Z)\b")
_RAISED = {"²": "2", "ᵗ": "t", "³": "3"}
_LOWERED = {"₀": "0", "₁": "1", "₂": "2", "₊": "+", "₋": "−"}
_STYLE = {
    "source": "color: #777; font-size: 85%; margin-left: .8em",
    "all": "font: 14px/1.5 system-ui, sans-serif; max-width: 60rem",
    "table": "border-collapse: collapse; margin: .3em 0 .6em",
    "cell": "text-align: left; padding: .1em .9em .1em 0; border-bottom: 1px solid #8884; vertical-align: top",
}


def html_of(blocks: Sequence[Block], picture: str = "") -> str:
    """All blocks; a picture stands behind the answer."""
    parts = [f'<div class="conicoid-explanation" style="{_STYLE["all"]}">']
    headings = 0
    for block in blocks:
        if isinstance(block, Heading):
            headings += 1
            if headings == 3 and picture:
                parts.append(picture)
                picture = ""
            parts.append(f"<h{block.level + 2}>{html.escape(block.text)}</h{block.level + 2}>")
        elif isinstance(block, Line):
            inset = f"margin: .1em 0 .1em {1.2 * (block.depth - 1):.1f}em"
            parts.append(f'<p style="{inset}">{formula(block.text)}{_source(block.source)}</p>')
        else:
            parts.append(_table(block))
    return "\n".join([*parts, picture, "</div>"])


def formula(text: str) -> str:
    """A line with its letters in italics and its indices lowered."""
    marked = _LETTER.sub(r"<i>\1</i>", html.escape(text, quote=False))
    marked = _INDEX.sub(r"<i>\1</i><sub>\2</sub>", marked)
    for sign, plain in _RAISED.items():
        marked = marked.replace(sign, f"<sup>{plain}</sup>")
    for sign, plain in _LOWERED.items():
        marked = marked.replace(sign, f"<sub>{plain}</sub>")
    return marked


def _source(source: str) -> str:
    return f'<span style="{_STYLE["source"]}">{html.escape(source)}</span>' if source else ""


def _table(block: Table) -> str:
    inset = f"margin-left: {1.2 * (block.depth - 1):.1f}em; "
    head = "".join(f'<th scope="col" style="{_STYLE["cell"]}">{formula(cell)}</th>' for cell in block.head)
    rows = "".join(f"<tr>{''.join(_cell(cell) for cell in row)}</tr>" for row in block.rows)
    return f'<table style="{inset}{_STYLE["table"]}"><tr>{head}</tr>{rows}</table>{_source(block.source)}'


def _cell(text: str) -> str:
    return f'<td style="{_STYLE["cell"]}">{html.escape(text)}</td>'
