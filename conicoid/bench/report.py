"""Running rows and saying what came out: as a table, as Markdown, as JSON."""

from __future__ import annotations

import datetime
import json
import platform
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from rich.table import Table

from ..engine.threads import thread_count
from .peer import Absent, Peer
from .row import Measured, Row, Size

HEAD = ("rays", "scene", "peer", "ours", "peer's", "ratio", "floor", "aim")


@dataclass(frozen=True)
class Outcome:
    """A row with what was measured, or why it was not."""

    row: Row
    found: Measured | None
    why_not: str = ""

    def cells(self) -> tuple[str, ...]:
        """As the columns of `HEAD`."""
        row, found = self.row, self.found
        asked = tuple(f"{x:g} ×" if x else "" for x in (row.floor, row.aim))
        start = (row.rays, row.scene, f"{row.peer.name}, {row.peer.about}")
        if found is None:
            return (*start, "", "", self.why_not, *asked)
        if found.apart:
            return (*start, "", "", f"no ratio: {found.apart}", *asked)
        figures = (f"{found.ours:.3g} {found.unit}", f"{found.theirs:.3g} {found.unit}", f"{found.ratio:.2f} ×")
        return (*start, *figures, *asked)


def run(rows: Iterable[Row], size: Size, done: Callable[[Outcome], None]) -> list[Outcome]:
    """Measure row after row; one whose peer is absent says so."""
    outcomes = []
    for row in rows:
        try:
            row.peer.find()
            outcome = Outcome(row, row.measure(size))
        except Absent as absent:
            outcome = Outcome(row, None, str(absent))
        outcomes.append(outcome)
        done(outcome)
    return outcomes


def machine(peers: Iterable[Peer]) -> list[str]:
    """Date, processor, versions: what figures mean nothing without."""
    lines = [
        f"{datetime.date.today().isoformat()}, {processor()}, {thread_count()} threads, {platform.system()}, "
        f"Python {platform.python_version()}",
        f"{', '.join(versions('conicoid', 'numba', 'numpy'))}, {compiler()}",
    ]
    for peer in dict.fromkeys(peers):
        try:
            version = peer.find()
        except Absent:
            continue
        if version:
            lines.append(f"{version} ({peer.about})")
    return lines


def versions(*packages: str) -> list[str]:
    """Of those that are installed."""
    names = {each.name for each in metadata.distributions()}
    return [f"{name} {metadata.version(name)}" for name in packages if name in names]


def compiler() -> str:
    """How kernels are compiled: what a processor's figures depend on as well."""
    from ..compiler import machine_code

    if machine_code.SHIPPED is not None:
        return machine_code.about()
    from ..compiler.dispatch import PLAIN
    from ..compiler.vectors import about

    return "Numba's plain njit" if PLAIN else about()


def processor() -> str:
    """The processor's name, as far as the system tells it."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def table(outcomes: Iterable[Outcome]) -> Table:
    made = Table(*HEAD)
    for outcome in outcomes:
        made.add_row(*outcome.cells())
    return made


def markdown(outcomes: Iterable[Outcome], about: Iterable[str]) -> str:
    lines = [*(f"{line}  " for line in about), "", "| " + " | ".join(HEAD) + " |", "|---" * len(HEAD) + "|"]
    lines += ["| " + " | ".join(outcome.cells()) + " |" for outcome in outcomes]
    return "\n".join(lines) + "\n"


def as_json(outcomes: Iterable[Outcome], about: list[str]) -> str:
    def entry(outcome: Outcome) -> dict[str, Any]:
        row, found = outcome.row, outcome.found
        data: dict[str, Any] = {"name": row.name, "peer": row.peer.name, "floor": row.floor, "aim": row.aim}
        if found is None:
            return data | {"missing": outcome.why_not}
        return data | {name: getattr(found, name) for name in ("ours", "theirs", "ratio", "unit", "apart")}

    return json.dumps({"machine": about, "rows": [entry(outcome) for outcome in outcomes]}, indent=2) + "\n"
