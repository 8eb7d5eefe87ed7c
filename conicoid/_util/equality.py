"""Equality by value of objects with arrays among their fields: one truth value, NaN equal to NaN."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np

Kind = TypeVar("Kind", bound=type)
_HASH_BYTES = 64
"""Bytes of an array that enter a hash."""


def equal_values(one: Any, other: Any) -> bool:
    """Return whether two fields are equal, including arrays, tuples and mappings at any depth."""
    if isinstance(one, np.ndarray | np.generic) or isinstance(other, np.ndarray | np.generic):
        one, other = np.asarray(one), np.asarray(other)
        # `equal_nan` fails for arrays of texts and objects
        return np.array_equal(one, other, equal_nan=one.dtype.kind == other.dtype.kind == "f")
    if isinstance(one, tuple | list) and type(one) is type(other):
        return len(one) == len(other) and all(map(equal_values, one, other))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(equal_values(one[name], other[name]) for name in one)
    return bool(one == other) or (isinstance(one, float) and isinstance(other, float) and one != one and other != other)


def compare_by_value(*names: str) -> Callable[[Kind], Kind]:
    """Return a decorator for classes whose instances are equal if these fields are; default: those of a dataclass."""

    def decorate(kind: Kind) -> Kind:
        fields = names or tuple(field.name for field in dataclasses.fields(kind))

        def equal(self: Any, other: object) -> Any:
            if type(other) is not type(self):
                return NotImplemented
            return self is other or all(equal_values(getattr(self, name), getattr(other, name)) for name in fields)

        def hash_of(self: Any) -> int:
            return hash((type(self), *(_hashable(getattr(self, name)) for name in fields)))

        for name, method in (("__eq__", equal), ("__hash__", hash_of)):
            setattr(kind, name, method)
        return kind

    return decorate


def _hashable(value: Any) -> Any:
    """Return a hashable part of a value that equal values share."""
    if isinstance(value, np.ndarray):
        return value.shape, _hash_sample(value).tobytes()
    if isinstance(value, tuple | list):
        return tuple(map(_hashable, value))
    if isinstance(value, Mapping):
        return len(value)  # equal mappings may differ in order
    # NaN hashes by identity, but equals NaN here
    return None if isinstance(value, float) and value != value else value


def _hash_sample(array: Any) -> Any:
    """Return the first numbers of an array; 0 and -0 become one, and all numbers that are not finite do."""
    first = array.reshape(-1)[: _HASH_BYTES // max(array.itemsize, 1)]
    return np.where(np.isfinite(first), first, 0) + 0 if first.dtype.kind == "f" else first
