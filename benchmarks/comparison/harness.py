"""Rows of the benchmark and the peers that they compare with, run and printed as a table, Markdown or JSON."""

from __future__ import annotations

import datetime
import importlib
import json
import platform
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from rich.table import Table

from conicoid._jit.machine_code import describe_code
from conicoid.cli.report import processor, versions
from conicoid.kernels.threads import thread_count

ROOT = Path(__file__).resolve().parents[2]
"""The repository: peers in processes of their own are started there."""


class Absent(Exception):
    """A peer is not installed, or does not run; the message names the remedy."""


@dataclass(frozen=True)
class Peer:
    """`find()` returns its version, or raises Absent."""

    name: str
    about: str
    find: Callable[[], str]


def distribution(name: str) -> str:
    """The version of an installed package; raises Absent with the way to install it."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        raise Absent(f"not installed: pip install {name}") from None


def module(name: str, package: str) -> Any:
    """A module of a package; raises Absent where it cannot be imported."""
    distribution(package)
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise Absent(f"{package} is installed but cannot be imported: {error}") from None


# A row of the benchmark, and what measuring it gives.

RUNS = 5


@dataclass(frozen=True)
class Size:
    """How much is traced."""

    width: int = 1024
    rays: int = 1 << 20
    runs: int = RUNS
    balls: int = 1_000_000


QUICK = Size(128, 1 << 12, 2, 10_000)


@dataclass(frozen=True)
class Measured:
    """Our figure and the peer's, how many times better ours is, and a unit; `apart` describes a disagreement."""

    ours: float
    theirs: float
    ratio: float
    unit: str
    apart: str = ""


@dataclass(frozen=True)
class BenchRow:
    """A comparison: `floor` is required, `aim` is the goal; 0 stands for none."""

    name: str
    rays: str
    scene: str
    peer: Peer
    floor: float
    aim: float
    measure: Callable[[Size], Measured]


# Running rows and printing the results: as a table, as Markdown, as JSON.

HEAD = ("rays", "scene", "peer", "ours", "peer's", "ratio", "floor", "aim")


@dataclass(frozen=True)
class RowOutcome:
    """A row with its measurement, or the reason for none."""

    row: BenchRow
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


def run(rows: Iterable[BenchRow], size: Size, done: Callable[[RowOutcome], None]) -> list[RowOutcome]:
    """Measure row after row; a row whose peer is absent has the reason."""
    outcomes = []
    for row in rows:
        try:
            row.peer.find()
            outcome = RowOutcome(row, row.measure(size))
        except Absent as absent:
            outcome = RowOutcome(row, None, str(absent))
        outcomes.append(outcome)
        done(outcome)
    return outcomes


def machine(peers: Iterable[Peer]) -> list[str]:
    """Return date, processor and versions, without which figures mean nothing."""
    lines = [
        f"{datetime.date.today().isoformat()}, {processor()}, {thread_count()} threads, {platform.system()}, "
        f"Python {platform.python_version()}",
        f"{', '.join(versions('conicoid', 'numba', 'numpy'))}, {describe_code()}",
    ]
    for peer in dict.fromkeys(peers):
        try:
            version = peer.find()
        except Absent:
            continue
        if version:
            lines.append(f"{version} ({peer.about})")
    return lines


def table(outcomes: Iterable[RowOutcome]) -> Table:
    made = Table(*HEAD)
    for outcome in outcomes:
        made.add_row(*outcome.cells())
    return made


def markdown(outcomes: Iterable[RowOutcome], about: Iterable[str]) -> str:
    lines = [*(f"{line}  " for line in about), "", "| " + " | ".join(HEAD) + " |", "|---" * len(HEAD) + "|"]
    lines += ["| " + " | ".join(outcome.cells()) + " |" for outcome in outcomes]
    return "\n".join(lines) + "\n"


def as_json(outcomes: Iterable[RowOutcome], about: list[str]) -> str:
    def entry(outcome: RowOutcome) -> dict[str, Any]:
        row, found = outcome.row, outcome.found
        data: dict[str, Any] = {"name": row.name, "peer": row.peer.name, "floor": row.floor, "aim": row.aim}
        if found is None:
            return data | {"missing": outcome.why_not}
        return data | {name: getattr(found, name) for name in ("ours", "theirs", "ratio", "unit", "apart")}

    return json.dumps({"machine": about, "rows": [entry(outcome) for outcome in outcomes]}, indent=2) + "\n"
