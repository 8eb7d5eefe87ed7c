"""Type names for the data that shapes are made of."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

Vector: TypeAlias = tuple[float, float, float]
if TYPE_CHECKING:
    VectorLike: TypeAlias = Any
    """A field that is a `Vector` and takes arrays and lists of three numbers as well, which a dataclass cannot say."""
else:
    VectorLike = Vector
Matrix4: TypeAlias = tuple[tuple[float, ...], ...]
Interval: TypeAlias = tuple[float, float]
FloatArray: TypeAlias = npt.NDArray[np.float64]
BoxEnds: TypeAlias = tuple[FloatArray, FloatArray]


# Arrays whose rows are vectors.
#
# Sums of products are written out: BLAS and `einsum` add them up in an order, and fused or not, that depends on the
# processor.


def dot_rows(a: FloatArray, b: FloatArray) -> FloatArray:
    """a·b along the last axis, the terms added from the first to the last."""
    result: FloatArray = a[..., 0] * b[..., 0]
    for k in range(1, a.shape[-1]):
        result += a[..., k] * b[..., k]
    return result


def matmul_rows(a: FloatArray, b: FloatArray) -> FloatArray:
    """a @ b of arrays (..., n) and (n, m)."""
    result: FloatArray = a[..., :1] * b[0]
    for k in range(1, len(b)):
        result += a[..., k : k + 1] * b[k]
    return result


def cross_rows(a: FloatArray, b: FloatArray) -> FloatArray:
    """a × b along the last axis, (..., 3)."""
    product: FloatArray = a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]]
    return product


def row_lengths(rows: FloatArray) -> FloatArray:
    """Euclidean lengths along the last axis."""
    result: FloatArray = np.sqrt(dot_rows(rows, rows))
    return result


def unit_rows(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Vectors divided by their lengths, and the lengths; zero vectors stay. Squares may not overflow."""
    largest = np.abs(rows).max(axis=-1, initial=0.0)
    largest = np.where(largest > 0, largest, 1.0)
    scaled = rows / largest[..., None]
    reach = row_lengths(scaled)
    return scaled / np.where(reach > 0, reach, 1.0)[..., None], reach * largest


# Numbers in rising order, each once: what NumPy's `unique` gives, which takes 8 ms when it is first called.
#
# It imports masked arrays then, which costs more than preparing a small scene, or than a whole edit. NaN may not be
# among
# the numbers.

IndexArray = npt.NDArray[np.int64]


def unique_sorted(*parts: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The different numbers of some arrays (n,), in rising order."""
    ordered = np.sort(parts[0] if len(parts) == 1 else np.concatenate(parts))
    found: npt.NDArray[Any] = ordered[_starts_run(ordered)]
    return found


def unique_with_inverse(numbers: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], IndexArray]:
    """The different numbers of an array (n,), in rising order, and (n,) the place of each given among them."""
    order = np.argsort(numbers)
    ordered = numbers[order]
    begins = _starts_run(ordered)
    return ordered[begins], _inverse_indices(order, begins)


def unique_first_with_inverse(numbers: npt.NDArray[Any]) -> tuple[IndexArray, IndexArray]:
    """Where each different number of an array (n,) stands first, by rising numbers; and (n,) as `distinct_places`."""
    order = np.argsort(numbers, kind="stable")
    begins = _starts_run(numbers[order])
    return order[begins], _inverse_indices(order, begins)


def is_member_sorted(numbers: npt.NDArray[Any], ordered: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Which of some numbers are there in an array of distinct numbers in rising order."""
    if not len(ordered):
        return np.zeros(numbers.shape, bool)
    place = np.searchsorted(ordered, numbers)
    found: npt.NDArray[np.bool_] = ordered[np.minimum(place, len(ordered) - 1)] == numbers
    return found


def _starts_run(ordered: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Which numbers are others than the one before."""
    other = np.ones(len(ordered), bool)
    np.not_equal(ordered[1:], ordered[:-1], out=other[1:])
    return other


def _inverse_indices(order: IndexArray, begins: npt.NDArray[np.bool_]) -> IndexArray:
    """The places among different numbers, of numbers that were ordered so."""
    found = np.empty(len(order), np.int64)
    found[order] = np.cumsum(begins) - 1
    return found
