"""Columns of tables that are filled group by group."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..tables import Ints, Signs
from .apart import empty
from .pattern import Group
from .places import Places


class Columns:
    """Columns of one table, which are filled group by group: "b" for those of small numbers, "i" for others."""

    def __init__(self, places: Places, kinds: str) -> None:
        self.places = places
        self.columns: list[Any] = [empty(places.count, np.int8 if kind == "b" else np.int32) for kind in kinds]

    def put(self, group: Group, rows: Ints, shifts: dict[int, Ints]) -> None:
        """Rows of a pattern for each body of a group; numbers in some columns count on from a body's first one.

        Of bodies that have the rows in common they are written once.
        """
        first = self.places.first[group.bodies].astype(np.intp)
        if len(first) > 1 and first[0] == first[-1]:
            first, shifts = first[:1], {column: counted[:1] for column, counted in shifts.items()}
        for k, row in enumerate(rows.tolist()):
            at = first + k
            for column, (values, number) in enumerate(zip(self.columns, row, strict=True)):
                values[at] = shifts[column] + np.int32(number) if column in shifts and number >= 0 else number

    def signed(self, column: int, senses: Signs) -> Any:
        """A column of numbers with signs, each times a sense."""
        values = self.columns[column]
        values *= senses
        return values


def ends_of(counts: Ints) -> Ints:
    """Where each begins, and the last ends."""
    return np.concatenate([np.zeros(1, np.int32), np.cumsum(counts, dtype=np.int32)])
