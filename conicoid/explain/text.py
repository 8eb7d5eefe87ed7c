"""Blocks as text for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from .blocks import Block, Heading, Line, Table

_STEP = "  "


def text_of(blocks: Sequence[Block]) -> str:
    """The lines of all blocks."""
    lines: list[str] = []
    for block in blocks:
        if isinstance(block, Heading):
            lines += _heading(block, bool(lines))
        elif isinstance(block, Line):
            lines.append(_STEP * block.depth + block.text + _source(block.source))
        else:
            lines += _table(block)
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _source(source: str) -> str:
    return f"   [{source}]" if source else ""


def _heading(block: Heading, more: bool) -> list[str]:
    if block.level == 3:
        return [f"{_STEP}{block.text}:"]
    under = {1: "=", 2: "-"}[block.level] * len(block.text)
    return [*([""] if more else []), block.text, under]


def _table(block: Table) -> list[str]:
    rows = [block.head, *block.rows]
    widths = [max(len(row[k]) for row in rows) for k in range(len(block.head))]
    padded = [
        _STEP * block.depth + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        for row in rows
    ]
    return [padded[0].rstrip() + _source(block.source), *padded[1:]]
