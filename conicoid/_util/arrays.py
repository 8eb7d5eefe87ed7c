"""Type names of arrays and vectors, products of arrays whose rows are vectors, sorted unique numbers, warnings off.

Sums of products are written out term by term: BLAS and `einsum` add them in an order, and fused or not, that depends on
the processor.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ParamSpec, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

Vector: TypeAlias = tuple[float, float, float]
if TYPE_CHECKING:
    VectorLike: TypeAlias = Any
    """A field that is a `Vector` and takes arrays and lists of three numbers too, which a dataclass cannot express."""
else:
    VectorLike = Vector
Matrix4: TypeAlias = tuple[tuple[float, ...], ...]
Interval: TypeAlias = tuple[float, float]
FloatArray: TypeAlias = npt.NDArray[np.float64]
BoxEnds: TypeAlias = tuple[FloatArray, FloatArray]


# --- Arrays whose rows are vectors


def dot_rows(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a·b along the last axis, with terms added from the first to the last."""
    result: FloatArray = a[..., 0] * b[..., 0]
    for k in range(1, a.shape[-1]):
        result += a[..., k] * b[..., k]
    return result


def matmul_rows(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a @ b of arrays (..., n) and (n, m)."""
    result: FloatArray = a[..., :1] * b[0]
    for k in range(1, len(b)):
        result += a[..., k : k + 1] * b[k]
    return result


def cross_rows(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return a × b along the last axis, (..., 3)."""
    return a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]]


def row_lengths(rows: FloatArray) -> FloatArray:
    """Return Euclidean lengths along the last axis."""
    return np.sqrt(dot_rows(rows, rows))


def unit_rows(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return vectors divided by their lengths, and the lengths; zero vectors stay. Squares do not overflow."""
    largest = np.abs(rows).max(axis=-1, initial=0.0)
    largest = np.where(largest > 0, largest, 1.0)
    scaled = rows / largest[..., None]  # at most 1, so squares neither overflow nor all underflow
    reach = row_lengths(scaled)
    return scaled / np.where(reach > 0, reach, 1.0)[..., None], reach * largest


# --- Distinct numbers in rising order
#
# NumPy's `unique` gives them too, but takes 8 ms on its first call, in which it imports masked arrays. That is more
# than to prepare a small scene, or a whole edit. No number may be NaN here.

IndexArray = npt.NDArray[np.int64]


def unique_sorted(*parts: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the distinct numbers of some arrays (n,), in rising order.

    `np.unique` hashes integers, which takes a hundred times as long where millions are distinct.
    """
    ordered = np.sort(parts[0] if len(parts) == 1 else np.concatenate(parts))
    return ordered[_starts_run(ordered)]


def unique_with_inverse(numbers: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], IndexArray]:
    """Return the distinct numbers of an array (n,), in rising order, and (n,) the index of each number among them."""
    order = np.argsort(numbers)
    ordered = numbers[order]
    begins = _starts_run(ordered)
    return ordered[begins], _inverse_indices(order, begins)


def unique_first_with_inverse(numbers: npt.NDArray[Any]) -> tuple[IndexArray, IndexArray]:
    """Return the first index of each distinct number of an array (n,), by rising numbers, and (n,) the inverse."""
    order = np.argsort(numbers, kind="stable")  # so that the first of equal numbers leads their run
    begins = _starts_run(numbers[order])
    return order[begins], _inverse_indices(order, begins)


def row_ends(counts: Any) -> npt.NDArray[np.int32]:
    """Return where the rows of each begin, with the end of the last: (n + 1,)."""
    return np.concatenate([np.zeros(1, np.int32), np.cumsum(counts, dtype=np.int32)])


def is_member_sorted(numbers: npt.NDArray[Any], ordered: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Return which numbers are in an array of distinct numbers in rising order."""
    if not len(ordered):
        return np.zeros(numbers.shape, bool)
    place = np.searchsorted(ordered, numbers)
    return ordered[np.minimum(place, len(ordered) - 1)] == numbers


def _starts_run(ordered: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Return which numbers differ from the one before."""
    is_first = np.ones(len(ordered), bool)
    np.not_equal(ordered[1:], ordered[:-1], out=is_first[1:])
    return is_first


def _inverse_indices(order: IndexArray, begins: npt.NDArray[np.bool_]) -> IndexArray:
    """Return the index of each number among the distinct ones; `order` sorts the numbers."""
    inverse = np.empty(len(order), np.int64)
    inverse[order] = np.cumsum(begins) - 1
    return inverse


# --- Floating-point warnings of NumPy

P = ParamSpec("P")
R = TypeVar("R")


def ignore_fp_errors(function: Callable[P, R]) -> Callable[P, R]:
    """Return the function with NumPy warnings and errors off, whatever `np.seterr` or `np.errstate` the caller has set.

    Code checks for overflows and NaN where they matter, and a harmless underflow must not stop it.
    """

    @functools.wraps(function)
    def wrapper(*args: P.args, **keywords: P.kwargs) -> R:
        with np.errstate(all="ignore"):
            return function(*args, **keywords)

    return wrapper


def two_sum(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a sum and its rounding error (Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def two_product(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a product and its rounding error (Dekker)."""
    product, parts = a * b, []
    for factor in (a, b):
        scaled = 134217729.0 * factor  # 2^27 + 1: both halves have 26 bits
        high = scaled - (scaled - factor)
        parts.append((high, factor - high))
    (p, q), (r, s) = parts
    return product, ((p * r - product) + p * s + q * r) + q * s
