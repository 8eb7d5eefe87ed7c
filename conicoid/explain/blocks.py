"""What is told, before it is text or HTML: headings, lines with their source, tables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True)
class Heading:
    """Of level 1, 2 or 3."""

    text: str
    level: int = 1


@dataclass(frozen=True)
class Line:
    """A sentence or a formula; `source` is the document it comes from, `depth` how far it is set in."""

    text: str
    source: str = ""
    depth: int = 1


@dataclass(frozen=True)
class Table:
    """Rows of cells under their heads."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    source: str = ""
    depth: int = 1


Block: TypeAlias = Heading | Line | Table
