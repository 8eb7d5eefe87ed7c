"""Progress of preparing a scene, counted in entries: each stage has a share of every entry."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Progress = Callable[[int, int], Any]

FEW = 1000
"""Up to so many entries only lowering bodies one by one takes long, which reports every body."""
AFTER_READING, AFTER_BATCH, AFTER_LOWERING, AFTER_MERGING, AFTER_LAYOUT, AFTER_TREES = 0.2, 0.6, 0.75, 0.85, 0.9, 1.0
"""Shares completed at the end of each stage: bodies read, lowered in batches, lowered one by one.

Surfaces merged, tables laid out, trees built.
"""


class ProgressStages:
    """Reports stages to a callback, if there is one, in rising numbers."""

    def __init__(self, progress: Progress | None, count: int) -> None:
        self.progress, self.count = progress, count
        self.many = count > FEW
        self.reported = 0

    def advance(self, share: float, end: float | None = None, done: int = 0, of: int = 1) -> None:
        """Report a share of the work, or the part `done / of` of the way from `share` to `end`.

        Small scenes report bodies only.
        """
        if self.progress is None or not self.many:
            return
        share += (end - share) * done / max(of, 1) if end is not None else 0.0
        self._report(round(share * self.count))

    def bodies(self, done: int) -> None:
        """Report that so many entries are lowered."""
        if self.progress is not None:
            self._report(round(self.count * AFTER_BATCH + (AFTER_LOWERING - AFTER_BATCH) * done) if self.many else done)

    def _report(self, done: int) -> None:
        if done > self.reported:
            assert self.progress is not None
            self.reported = done
            self.progress(done, self.count)
