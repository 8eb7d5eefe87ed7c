"""The command as a function: time the rows, write the file, hand back what is to be shown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from rich.table import Table

from ..formats.atomic import write_text
from . import report
from .row import QUICK, Row, Size
from .rows import ROWS


class Shown(NamedTuple):
    """What a benchmark found, for a terminal and as Markdown, and lines about machine and versions."""

    table: Table
    markdown: str
    about: list[str]


def measure(wanted: Sequence[str], quick: bool, figures: Path | None, tell: Callable[[str], None]) -> Shown:
    """`tell` hears each row as it is measured. Raises ValueError for an unknown row."""
    chosen = named(wanted)
    size = QUICK if quick else Size()
    outcomes = report.run(chosen, size, lambda outcome: tell("  ".join(filter(None, outcome.cells()))))
    about = report.machine(row.peer for row in chosen)
    if figures is not None:
        write_text(figures, report.as_json(outcomes, about))
    return Shown(report.table(outcomes), report.markdown(outcomes, about), about)


def named(wanted: Sequence[str]) -> list[Row]:
    """The rows of these names, or all."""
    known = {row.name: row for row in ROWS}
    unknown = sorted(set(wanted) - set(known))
    if unknown:
        raise ValueError(f"bench: there is no row {unknown[0]!r}; the rows are {', '.join(known)}")
    return [known[name] for name in wanted] if wanted else list(ROWS)
