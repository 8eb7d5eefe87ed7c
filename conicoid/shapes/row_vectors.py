"""Arrays whose rows are vectors.

Sums of products are written out: BLAS and `einsum` add them up in an order, and fused or not, that depends on the
processor.
"""

from __future__ import annotations

import numpy as np

from .vector import FloatArray


def dot_rows(a: FloatArray, b: FloatArray) -> FloatArray:
    """a·b along the last axis, the terms added from the first to the last."""
    result: FloatArray = a[..., 0] * b[..., 0]
    for k in range(1, a.shape[-1]):
        result += a[..., k] * b[..., k]
    return result


def product(a: FloatArray, b: FloatArray) -> FloatArray:
    """a @ b of arrays (..., n) and (n, m)."""
    result: FloatArray = a[..., :1] * b[0]
    for k in range(1, len(b)):
        result += a[..., k : k + 1] * b[k]
    return result


def cross_rows(a: FloatArray, b: FloatArray) -> FloatArray:
    """a × b along the last axis, (..., 3)."""
    product: FloatArray = a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]]
    return product


def lengths(rows: FloatArray) -> FloatArray:
    """Euclidean lengths along the last axis."""
    result: FloatArray = np.sqrt(dot_rows(rows, rows))
    return result


def unit_rows(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Vectors divided by their lengths, and the lengths; zero vectors stay. Squares may not overflow."""
    largest = np.abs(rows).max(axis=-1, initial=0.0)
    largest = np.where(largest > 0, largest, 1.0)
    scaled = rows / largest[..., None]
    reach = lengths(scaled)
    return scaled / np.where(reach > 0, reach, 1.0)[..., None], reach * largest
