"""Rows of the numbers that differ give what the rows written out give, whatever is asked of them."""

from __future__ import annotations

import numpy as np
import pytest

from conicoid.prepare.pattern import RowTable, row_blocks

RNG = np.random.default_rng(5)


def some_rows(bodies, width, different):
    """(rows, the same written out)"""
    values, columns = RNG.normal(size=(bodies, different)), RNG.integers(0, different, width).astype(np.int32)
    return RowTable.of(values, columns), values[:, columns]


def every_answer(rows, whole):
    """Pairs of what is found, and what should be."""
    some, mask = np.array([3, 0, 5]), np.arange(len(whole)) % 3 == 1
    for a, b in ((0, whole.shape[1]), (2, 5), (4, 4), (-5, -2), (None, 7), (6, None), (0, 0)):
        for which in (slice(None), slice(1, 4), slice(0, 0), some, mask):
            yield rows[which, a:b], whole[which, a:b]
            yield rows[which][:, a:b], whole[which][:, a:b]
    for column in (0, 7, -1):
        yield rows[:, column], whole[:, column]


@pytest.mark.parametrize("seed", range(5))
def test_rows_are_those_written_out(seed):
    a, b, c = (some_rows(9, width, different) for width, different in ((12, 5), (8, 8), (6, 1)))
    parts = [(a, 3, 9), (b, 0, 8), (a, 0, 4), (c, 2, 5), (b, 4, 6)]
    joined = RowTable.joined([(rows, first, last) for (rows, _), first, last in parts])
    whole = np.concatenate([written[:, first:last] for (_, written), first, last in parts], axis=1)
    assert len(joined) == 9
    for rows, written in ((a[0], a[1]), (joined, whole), (RowTable.joined([(joined, 2, 17)]), whole[:, 2:17])):
        for found, expected in every_answer(rows, written):
            assert found.shape == expected.shape
            assert found.tolist() == expected.tolist()


@pytest.mark.parametrize("count", [0, 1, 8192, 8193, 30000])
def test_blocks_hold_each_body_once(count):
    assert [k for some in row_blocks(count) for k in range(some.start, some.stop)] == list(range(count))
