"""Row layout: which rows of a scene's tables belong to which body. It is kept so that an edited scene can copy them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import field

import numpy as np

from .._util.records import dataclass
from ..kernels.tables import BALL, CELL, PLANE, POLYGON, QUADRIC, REGION, SHEET, SPHERE, Ints, Longs, Signs
from .coincidence import SurfaceTable
from .pattern import BodyGroups, BodyPattern

(
    SURFACES, PLANES, SPHERES, QUADRICS, CELLS, CELL_PLANES, PROGRAMS, LEAVES, GATES, SHEETS, POLYGONS, CORNERS, FACES,
    MAP_ROWS, FRAMES, BALLS, BODIES, ENTRIES, BALL_FRAMES,
) = range(19)  # fmt: skip
"""The kinds of rows that tables have. Surfaces are those that bodies came with, without bulk balls."""
AXES_OF_ROWS = BALL_FRAMES + 1
OF_PATTERNS = 17
"""The first 17 kinds follow from a body's pattern.

Entries and the frames of bulk balls follow from the scene's list.
"""
KINDS = {CELL: CELLS, REGION: PROGRAMS, SHEET: SHEETS, POLYGON: POLYGONS}


def _counts(pattern: BodyPattern | None) -> list[int]:
    """Count the rows of each kind of a body of a pattern; None: a bulk ball."""
    if pattern is None:
        return [0] * BALLS + [1, 1]
    p = pattern
    of_kind = [int((p.kinds == kind).sum()) for kind in (PLANE, SPHERE, QUADRIC)]
    parts = (p.cells, p.planes, p.programs, p.leaves, p.gates, p.sheets, p.polygons)
    rows = int(p.corners.sum()), len(p.angular), p.map_rows
    return [len(p.kinds), *of_kind, *map(len, parts), *rows, int(p.framed), 0, 1]


def _entry(pattern: BodyPattern | None) -> tuple[int, int, int]:
    """Return the tree entry of a body of a pattern: (kind, row, kind where cells that are balls count as balls)."""
    if pattern is None:
        return BALL, 0, BALL
    ball = pattern.kind == CELL and pattern.kinds.tolist() == [SPHERE] and pattern.cells.tolist() == [[0, 1, 0]]
    return pattern.kind, pattern.index, BALL if ball else pattern.kind


@dataclass(frozen=True)
class ScenePatterns:
    """The distinct patterns of a scene's bodies; number 0 stands for bulk balls, which have none."""

    known: tuple[BodyPattern | None, ...]
    numbers: dict[BodyPattern, int]
    counts: Longs  # (patterns, OF_PATTERNS)
    entries: Longs  # (patterns, 3) kind of entry, its row among the body's of that kind, kind with balls for ball cells

    @classmethod
    def of(cls, patterns: Iterable[BodyPattern]) -> ScenePatterns:
        """Collect patterns, each once."""
        known: list[BodyPattern | None] = [None, *dict.fromkeys(patterns)]
        numbers = {pattern: number for number, pattern in enumerate(known) if pattern is not None}
        counts = np.array([_counts(pattern) for pattern in known], np.int64)
        entries = np.array([_entry(pattern) for pattern in known], np.int64)
        return cls(tuple(known), numbers, counts, entries)

    def union(self, others: ScenePatterns) -> tuple[ScenePatterns, Ints]:
        """Return the union of both, and the numbers of the others' patterns in it."""
        new = ScenePatterns.of(pattern for pattern in others.numbers if pattern not in self.numbers)
        both = self
        if new.numbers:
            first = len(self.known) - 1
            both = ScenePatterns(
                self.known + new.known[1:],
                self.numbers | {pattern: first + number for pattern, number in new.numbers.items()},
                np.concatenate([self.counts, new.counts[1:]]),
                np.concatenate([self.entries, new.entries[1:]]),
            )
        return both, np.array([0, *(both.numbers[pattern] for pattern in others.numbers)], np.int32)


@dataclass(frozen=True)
class RowLayout:
    """Which rows of the tables belong to which body. Rows of every kind are in body order."""

    patterns: ScenePatterns
    which: Ints  # (bodies,) number of the pattern
    first_body: Longs  # (entries + 1,)
    first_frame: Longs  # (entries + 1,) first frame of bulk balls
    kinds: Signs  # (surfaces,) kinds of the surfaces that bodies came with
    input_senses: Signs  # (surfaces,) the senses they came with
    senses: Signs | None  # (surfaces and bulk balls,) their senses in the table; None: the input senses
    first: Ints | None  # (the same,) the surface whose record each takes; None: its own
    ids: Ints | None  # (the same,) number in the table of surfaces; None: the input number
    _starts: dict[int, Longs] = field(default_factory=dict, repr=False)

    @classmethod
    def of(
        cls, contents: BodyGroups, items: Sequence[int] | Ints, frames: Sequence[int], surfaces: SurfaceTable
    ) -> RowLayout | None:
        """Build the layout of a scene; None where some bodies belong to no group.

        `items` counts the bodies of each entry; `frames` counts the frames of bulk balls up to and with each entry.
        """
        patterns = ScenePatterns.of(group.pattern for group in contents.groups)
        grouped = sum(len(group.bodies) for group in contents.groups)
        if grouped + sum(len(balls.bodies) for balls in contents.balls) < contents.body_count:
            return None
        which = np.zeros(contents.body_count, np.int32)
        for group in contents.groups:
            which[group.bodies] = patterns.numbers[group.pattern]
        bodies, ball_frames = np.cumsum([0, *items]), np.array([0, *frames], np.int64)
        classes = (None, None, None) if surfaces.first is None else (surfaces.senses, surfaces.first, surfaces.ids)
        return cls(patterns, which, bodies, ball_frames, surfaces.raw.kinds, surfaces.raw.senses, *classes)

    def rows_up_to(self, entries: Longs) -> Longs:
        """Count the rows of each kind before these entries, which rise: (entries, AXES_OF_ROWS)."""
        bounds = self.first_body[entries]
        found = np.zeros((len(entries), AXES_OF_ROWS), np.int64)
        done, before = np.zeros(OF_PATTERNS, np.int64), 0
        for row, bound in enumerate(bounds.tolist()):
            if bound > before:
                members = np.bincount(self.which[before:bound])
                done = done + members @ self.patterns.counts[: len(members)]
                before = bound
            found[row, :OF_PATTERNS] = done
        found[:, ENTRIES], found[:, BALL_FRAMES] = entries, self.first_frame[entries]
        return found

    def starts(self, axis: int) -> Longs:
        """Return where the rows of one kind begin for each body, with the end of the last: (bodies + 1,)."""
        if axis not in self._starts:
            ends = np.cumsum(self.patterns.counts[:, axis][self.which])
            self._starts[axis] = np.concatenate([np.zeros(1, np.int64), ends])
        return self._starts[axis]
