"""How far the preparing of a scene has come, in entries: each stage of it has a share in every entry."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Progress = Callable[[int, int], Any]

FEW = 1000
"""Entries up to which nothing takes long but lowering bodies one by one, which tells of every one."""
AFTER_READING, AFTER_BATCH, AFTER_LOWERING, AFTER_MERGING, AFTER_LAYOUT, AFTER_TREES = 0.2, 0.6, 0.75, 0.85, 0.9, 1.0
"""How far it has come at the end of each stage: bodies read, lowered together, and the others; surfaces merged, tables
laid out, trees built."""


class ProgressStages:
    """Tells of stages where there is somebody to be told."""

    def __init__(self, progress: Progress | None, count: int) -> None:
        self.progress, self.count = progress, count
        self.many = count > FEW
        self.told = 0

    def reached(self, share: float, end: float | None = None, done: int = 0, of: int = 1) -> None:
        """A stage has been reached; or so many parts are done of what leads from it to another."""
        if self.progress is None or not self.many:
            return
        share += (end - share) * done / max(of, 1) if end is not None else 0.0
        self._tell(round(share * self.count))

    def bodies(self, done: int) -> None:
        """So many entries are lowered."""
        if self.progress is not None:
            self._tell(round(self.count * AFTER_BATCH + (AFTER_LOWERING - AFTER_BATCH) * done) if self.many else done)

    def _tell(self, done: int) -> None:
        if done > self.told:
            assert self.progress is not None
            self.told = done
            self.progress(done, self.count)
