"""Counts of comparisons and failures, with messages that reproduce them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .items import Item

SHOWN = 3


@dataclass
class Score:
    """`wrong` counts by sort of failure; `messages` has the first few of each; `queries` counts rays times queries."""

    rays: int = 0
    queries: int = 0
    rows: int = 0
    doubtful: int = 0
    errors: list[float] = field(default_factory=list)
    """|t - exact| of crossings as a share of |t|, and the bounds of that."""
    bounds: list[float] = field(default_factory=list)
    wrong: dict[str, int] = field(default_factory=dict)
    messages: dict[str, list[str]] = field(default_factory=dict)

    def fail(self, sort: str, message: str, count: int = 1) -> None:
        self.wrong[sort] = self.wrong.get(sort, 0) + count
        shown = self.messages.setdefault(sort, [])
        if len(shown) < SHOWN:
            shown.append(message)

    def add(self, other: Score) -> None:
        for name in ("rays", "queries", "rows", "doubtful", "errors", "bounds"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        for sort, count in other.wrong.items():
            self.wrong[sort] = self.wrong.get(sort, 0) + count
            shown = self.messages.setdefault(sort, [])
            shown += other.messages[sort][: SHOWN - len(shown)]

    @property
    def slackness(self) -> float:
        """Return median bound over median error, or 0 if no ray crosses anything, as where Booleans are empty."""
        if not self.errors:
            return 0.0
        return float(np.median(self.bounds) / (np.median(self.errors) or np.inf))

    def check(self) -> None:
        text = "\n\n".join(f"{sort}: {m}" for sort in self.wrong for m in self.messages[sort])
        assert not self.wrong, f"{self.wrong} of {self.rays} rays\n\n{text}"


def scene_text(items: Sequence[Item]) -> str:
    return f"scene = co.Scene([{', '.join(map(repr, items))}])"


def vector_text(v: Any) -> str:
    return "(" + ", ".join(repr(float(x)).removesuffix(".0") for x in v) + ")"
