"""Which atoms are bonded: by distance, found through a grid, or as they are given."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from ...shapes.arrays import real_array
from ...shapes.vector import FloatArray
from .elements import COVALENT

TOLERANCE = 0.45
"""Å that bonded atoms may be further apart than the sum of their covalent radii (Meng and Lewis 1991)."""
LEAST = 0.4
"""Å: atoms that are nearer are one atom in two places."""
_AT_ONCE = 1 << 22
_LONGEST_GRID = 1 << 20

Indices = npt.NDArray[np.int64]


def bonds_by_distance(positions: FloatArray, numbers: Indices) -> Indices:
    """(M, 2) pairs of atoms, the first the smaller, in order."""
    if len(positions) < 2:
        return np.zeros((0, 2), np.int64)
    radii = COVALENT[numbers]
    reach = 2 * float(radii.max()) + TOLERANCE
    found = [_bonded(positions, radii, first, second) for first, second in _near(positions, reach)]
    pairs = np.sort(np.concatenate([*found, np.zeros((0, 2), np.int64)]), axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _bonded(positions: FloatArray, radii: FloatArray, first: Indices, second: Indices) -> Indices:
    """Those of some pairs that are bonded."""
    far = ((positions[first] - positions[second]) ** 2).sum(axis=1)
    most = radii[first] + radii[second] + TOLERANCE
    kept = (far <= most * most) & (far >= LEAST * LEAST)
    return np.column_stack([first[kept], second[kept]])


def _near(positions: FloatArray, reach: float) -> Iterator[tuple[Indices, Indices]]:
    """Pairs of atoms, each once, among them all that are no further apart than `reach`: those of neighbouring squares.

    Squares of a row along z have consecutive keys, so the neighbours of one are five ranges of sorted atoms.
    """
    low = positions.min(axis=0)
    size = max(reach, float((positions.max(axis=0) - low).max()) / _LONGEST_GRID)
    square = np.floor((positions - low) / size).astype(np.int64) + 1
    _, rows, columns = (square.max(axis=0) + 2).tolist()
    key = (square[:, 0] * rows + square[:, 1]) * columns + square[:, 2]
    order = np.argsort(key, kind="stable")
    key = key[order]
    own = np.arange(len(key))
    ranges = [(own + 1, np.searchsorted(key, key + 1, "right"))]
    for shift in (columns, (rows - 1) * columns, rows * columns, (rows + 1) * columns):
        ranges.append((np.searchsorted(key, key + shift - 1), np.searchsorted(key, key + shift + 1, "right")))
    for begin, end in ranges:
        counts = np.maximum(end - begin, 0)
        for part in _parts(counts):
            many = counts[part]
            first = np.repeat(own[part], many)
            within = np.arange(len(first)) - np.repeat(np.cumsum(many) - many, many)
            yield order[first], order[np.repeat(begin[part], many) + within]


def _parts(counts: Indices) -> Iterator[slice]:
    """Slices of atoms that have no more pairs together than fit into memory well."""
    ends = np.cumsum(counts)
    begin = 0
    while begin < len(counts):
        before = int(ends[begin - 1]) if begin else 0
        end = max(begin + 1, int(np.searchsorted(ends, before + _AT_ONCE, "right")))
        yield slice(begin, end)
        begin = end


def checked_bonds(given: Any, count: int) -> FloatArray:
    """(M, 3) floats: two different atoms, the first the smaller, and the order of their bond. ValueError otherwise."""
    bonds = np.array(real_array("molecule", "bonds", given))
    bonds = bonds.reshape(0, 3) if bonds.size == 0 else bonds
    if bonds.ndim != 2 or bonds.shape[1] not in (2, 3):
        raise ValueError(f"molecule: bonds must have shape (M, 2), or (M, 3) with orders, got {bonds.shape}")
    if bonds.shape[1] == 2:
        bonds = np.column_stack([bonds, np.ones(len(bonds))])
    ends = bonds[:, :2]
    wrong = ~((ends >= 0) & (ends < count) & (ends == np.floor(ends))).all(axis=1) | (ends[:, 0] == ends[:, 1])
    for bad, expected in (
        (wrong, f"two different atoms from 0 to {count - 1}"),
        (~((bonds[:, 2] > 0) & (bonds[:, 2] <= 4)), "of an order > 0 and <= 4"),
    ):
        rows = np.flatnonzero(bad)
        if len(rows):
            raise ValueError(f"molecule: bonds[{rows[0]}] must be {expected}, got {bonds[rows[0]].tolist()}")
    bonds[:, :2].sort(axis=1)
    return bonds
