"""Turn what a caller passes into arrays of float64, or refuse it by name."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from .validate import LARGEST, SMALLEST, is_complex, masked_arrays, shown
from .vector import FloatArray

_DEEPEST = 5
_BELOW_ROUNDING = 2.0**-60


def real_array(owner: str, field: str, values: Any, expected: str = "an array of numbers") -> FloatArray:
    """`values` as an array of float64, NaN and infinity among them; not a copy where it is one already, and is aligned.

    Raises ValueError that names object and field for anything but real numbers: texts, None, complex numbers, masked
    entries, numbers beyond float64, lists of uneven lengths.
    """
    name = f"{owner}: {field}" if owner else field
    if isinstance(values, np.ndarray) and values.dtype == np.float64 and not isinstance(values, masked_arrays()):
        return values if values.flags.aligned else values.copy()  # such come from networks and records
    if _is_plain(values):  # one ray's: what follows takes longer than tracing it
        with contextlib.suppress(OverflowError):
            return np.array(values, dtype=np.float64)
    if is_masked(values):
        raise ValueError(f"{name} must be {expected} without masked entries")
    try:
        with np.errstate(all="ignore"):
            array = np.asarray(values)
            if array.dtype == object:
                # Fractions, decimals and large integers
                array = np.array([_real(item) for item in array.ravel()]).reshape(array.shape)
            if array.dtype.kind not in "fiub":
                raise TypeError
            return np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        found = f"an array of {values.dtype}" if isinstance(values, np.ndarray) else shown(values)
        raise ValueError(f"{name} must be {expected}, got {found}{_instead(values)}") from None


_AXES = ["x", "y", "z"]


def refuse_columns(owner: str, field: str, values: Any) -> None:
    """ValueError for a table whose three columns are named after x, y and z, in another order."""
    columns = getattr(values, "columns", None)
    if columns is None or len(columns) != 3:
        return
    names = [str(name) for name in columns]
    axes = [next((letter for letter in (name[-1:].lower(), name[:1].lower()) if letter in _AXES), "") for name in names]
    if sorted(axes) == _AXES and axes != _AXES:
        ordered = [names[axes.index(axis)] for axis in _AXES]
        raise ValueError(
            f"{owner}: {field} must have columns in the order x, y, z, got {names}; table[{ordered}] has it"
        )


def _instead(values: Any) -> str:
    """Where the numbers are of something that has arrays as its fields."""
    pair = isinstance(values, tuple) and len(values) == 2
    if pair and isinstance(values[0], np.ndarray) and getattr(values[1], "dtype", None) == np.bool_:
        return "; co.refract gives two things, directions, total = co.refract(...)"
    one = values[0] if isinstance(values, list | tuple) and values else values
    fields = getattr(type(one), "instead", "")
    if not fields or one is values:
        return f"; {fields} are arrays" if fields else ""
    return f"; co.{type(one).__name__}.concatenate joins them"


_PLAIN = frozenset((float, int))


def _is_plain(values: Any) -> bool:
    """Whether they are a number of Python's, or a list or tuple of such."""
    kind = type(values)
    return kind in _PLAIN or ((kind is tuple or kind is list) and bool(values) and _PLAIN.issuperset(map(type, values)))


def _real(item: Any) -> float:
    if item is None or isinstance(item, (str, bytes)) or is_complex(item):
        raise TypeError
    return float(item)


def is_lazy(values: Any) -> bool:
    """Whether they are Dask's: those of xarray are where their data are, and have no graph where these are at hand."""
    graph = getattr(values, "__dask_graph__", None)
    return callable(graph) and graph() is not None


def is_masked(values: Any) -> bool:
    """Whether there are masked entries, also in lists, where NumPy takes them for NaN with a warning."""
    level = [values]
    for _ in range(_DEEPEST):
        kinds = set(map(type, level))
        if any(issubclass(kind, masked_arrays()) for kind in kinds) and any(map(_has_masked, level)):
            return True
        lists = {kind for kind in kinds if issubclass(kind, Sequence) and not issubclass(kind, (str, bytes))}
        level = list(itertools.chain.from_iterable(item for item in level if type(item) in lists))
    return False


def _has_masked(item: Any) -> bool:
    return isinstance(item, masked_arrays()) and bool(np.ma.getmaskarray(item).any())


def without_traces(vectors: FloatArray) -> FloatArray:
    """Vectors (..., 3) that are rounded themselves, with 0 for components that are neither of the domain nor of weight.

    What is below 1e-100 and 2^-60 of the largest component is less than the rounding of the vector's length.
    """
    sizes = np.abs(vectors)
    small = sizes < SMALLEST
    if not small.any():  # as almost always
        return vectors
    with np.errstate(all="ignore"):
        trace = small & (sizes <= _BELOW_ROUNDING * sizes.max(axis=-1, keepdims=True, initial=0.0))
    return np.where(trace, 0.0, vectors) if trace.any() else vectors


def outside(points: FloatArray) -> Any:
    """Indices of those rows of points (n, 3) that are not finite or lie beyond the domain."""
    if points.size and points.max() <= LARGEST and points.min() >= -LARGEST:  # NaN is neither
        return np.zeros(0, np.intp)
    return np.flatnonzero(~(np.abs(points) <= LARGEST).all(axis=1))
