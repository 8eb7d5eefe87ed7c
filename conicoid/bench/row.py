"""A row of the benchmark, and what measuring it gives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .peer import Peer

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
    """Ours and the peer's figure, how many times better ours is, and a unit; `apart` says how they disagree."""

    ours: float
    theirs: float
    ratio: float
    unit: str
    apart: str = ""


@dataclass(frozen=True)
class Row:
    """A comparison: `floor` is asked for, `aim` wished for; 0 where nothing is."""

    name: str
    rays: str
    scene: str
    peer: Peer
    floor: float
    aim: float
    measure: Callable[[Size], Measured]
