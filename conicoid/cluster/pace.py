"""How much of some work a task should take: about a second's, by what the tasks before it took."""

from __future__ import annotations

from collections.abc import Iterator

SECONDS = 1.0
"""That a task should take: long beside what a scheduler takes for it (a millisecond), short beside the whole."""
_STEP = 8  # a size is at most so many times the one before


class Pace:
    """Sizes of tasks between two limits: fixed, or by the measured rate, and smaller towards the end."""

    def __init__(self, fixed: int | None, least: int, most: int, workers: int) -> None:
        self.fixed, self.most, self.workers = fixed, max(1, most), max(1, workers)
        self.least = min(max(1, least), self.most)
        self.size = self.least

    def saw(self, count: int, seconds: float) -> None:
        """A task of `count` took some seconds."""
        wanted = count * SECONDS / max(seconds, 1e-6)
        self.size = int(min(self.most, max(self.least, min(wanted, _STEP * max(count, self.size)))))

    def pieces(self, begin: int, end: int, step: int = 1) -> Iterator[tuple[int, int]]:
        """(begin, end) of one piece after the other, by the rate known by then; multiples of `step` where they may.

        Towards the end pieces become smaller, so that all workers end at about the same time.
        """
        while begin < end:
            if self.fixed is not None:
                size = self.fixed
            else:
                size = max(self.least, min(self.size, -(-(end - begin) // (2 * self.workers))))
                size = size // step * step if size >= step else size
            yield begin, min(end, begin + size)
            begin += size
