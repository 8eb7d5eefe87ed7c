"""The rows of bodies of one pattern (`pattern`), by the numbers in them that differ.

Most numbers of a row stand in it several times, or are the same in every row: of 180 of a box, 34 differ.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..tables import Floats, Ints

_AT_ONCE = 1 << 13


@dataclass(frozen=True)
class Rows:
    """Tables with a row for each body, and for each column of a row where its number stands in them.

    `rows[:, a:b]` and `rows[:, a]` are arrays, as `rows[which, a:b]` is for some bodies; `rows[which]` are rows.
    """

    tables: tuple[Floats, ...]  # (bodies, any) each
    table: Ints  # (columns,)
    column: Ints  # (columns,)

    @classmethod
    def of(cls, values: Floats, columns: Ints) -> Rows:
        """Rows whose columns are these of one table."""
        return cls((values,), np.zeros(len(columns), np.int32), columns)

    @classmethod
    def joined(cls, parts: Sequence[tuple[Rows, int, int]]) -> Rows:
        """Side by side: of each part the columns from one to another."""
        first: dict[int, int] = {}
        tables: list[Floats] = []
        for rows, _, _ in parts:
            if id(rows) not in first:
                first[id(rows)] = len(tables)
                tables += rows.tables
        table = [rows.table[a:b] + np.int32(first[id(rows)]) for rows, a, b in parts]
        return cls(tuple(tables), np.concatenate(table), np.concatenate([rows.column[a:b] for rows, a, b in parts]))

    def __len__(self) -> int:
        return len(self.tables[0])

    def __getitem__(self, where: Any) -> Any:
        if not isinstance(where, tuple):
            return Rows(tuple(table[where] for table in self.tables), self.table, self.column)
        some, columns = where
        if not isinstance(columns, slice):
            return self.tables[self.table[columns]][some, self.column[columns]]
        table, column = self.table[columns], self.column[columns]
        ends = [len(table)]
        if len(self.tables) > 1:
            ends = [*(np.flatnonzero(table[1:] != table[:-1]) + 1).tolist(), len(table)]
        if len(ends) == 1 and ends[0] > 0:
            return _taken(self.tables[table[0]], some, column)
        found, begin = np.empty((len(self.tables[0][some]), len(column))), 0
        for end in ends if len(table) else ():
            found[:, begin:end] = _taken(self.tables[table[begin]], some, column[begin:end])
            begin = end
        return found


def _taken(table: Floats, some: Any, columns: Ints) -> Floats:
    """Some columns of some rows."""
    first, count = int(columns[0]), len(columns)
    if int(columns[-1]) == first + count - 1 and (columns[1:] > columns[:-1]).all():
        found: Floats = table[some, first : first + count]
        return found
    return table[some].take(columns, axis=1)


def blocks(count: int) -> Iterator[slice]:
    """So many bodies, some at a time: what is made of these is still in the cache when it is read."""
    for begin in range(0, count, _AT_ONCE):
        yield slice(begin, min(count, begin + _AT_ONCE))
