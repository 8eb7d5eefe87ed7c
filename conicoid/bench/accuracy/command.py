"""The command as a function: measure, write the files, hand back what is to be shown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ...formats.atomic import replacing, write_text
from ..command import Shown
from ..peer import Absent, module
from ..report import machine
from . import report
from .picture import draw
from .rows import cases, run
from .systems import SYSTEMS


def measure(
    wanted: Sequence[str], rays: int, figures: Path | None, picture: Path | None, tell: Callable[[str], None]
) -> Shown:
    """`tell` hears each outcome as it comes.

    Raises ValueError for unknown rows, and for a picture without matplotlib.
    """
    chosen = cases(wanted)
    if picture is not None:
        try:
            module("matplotlib.figure", "matplotlib")
        except Absent as reason:
            raise ValueError(f"bench: a picture needs matplotlib: {reason}") from None
    outcomes, absent = run(chosen, rays, lambda outcome: tell("  ".join(filter(None, report.cells(outcome)))))
    about = [*machine(system.peer for system in SYSTEMS), *absent, f"{rays:,} rays a row. {report.NOTE}"]
    if figures is not None:
        write_text(figures, report.as_json(outcomes, about, absent))
    if picture is not None:
        with replacing(picture) as partial:
            draw(outcomes, partial)
    return Shown(report.table(outcomes), report.markdown(outcomes, about), about)
