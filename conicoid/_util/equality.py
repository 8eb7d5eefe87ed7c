"""Equality by value of what has arrays among its fields: one truth value, NaN counting as equal to NaN."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np

Kind = TypeVar("Kind", bound=type)
_HASH_BYTES = 64
"""Of an array, that a hash is made of."""


def equal_values(one: Any, other: Any) -> bool:
    """Are two fields equal, whatever arrays, tuples and mappings they are or hold?"""
    if isinstance(one, np.ndarray | np.generic) or isinstance(other, np.ndarray | np.generic):
        one, other = np.asarray(one), np.asarray(other)
        return np.array_equal(one, other, equal_nan=one.dtype.kind == other.dtype.kind == "f")
    if isinstance(one, tuple | list) and type(one) is type(other):
        return len(one) == len(other) and all(map(equal_values, one, other))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(equal_values(one[name], other[name]) for name in one)
    return bool(one == other) or (isinstance(one, float) and isinstance(other, float) and one != one and other != other)


def compare_by_value(*names: str) -> Callable[[Kind], Kind]:
    """A class whose instances are equal where these fields are, those of a dataclass if none is named."""

    def compared(kind: Kind) -> Kind:
        fields = names or tuple(field.name for field in dataclasses.fields(kind))

        def equal(self: Any, other: object) -> Any:
            if type(other) is not type(self):
                return NotImplemented
            return self is other or all(equal_values(getattr(self, name), getattr(other, name)) for name in fields)

        def hashed(self: Any) -> int:
            return hash((type(self), *(_hashable(getattr(self, name)) for name in fields)))

        for name, method in (("__eq__", equal), ("__hash__", hashed)):
            setattr(kind, name, method)
        return kind

    return compared


def _hashable(value: Any) -> Any:
    """A part of a value that equal ones share."""
    if isinstance(value, np.ndarray):
        return value.shape, _hash_sample(value).tobytes()
    if isinstance(value, tuple | list):
        return tuple(map(_hashable, value))
    if isinstance(value, Mapping):
        return len(value)
    return None if isinstance(value, float) and value != value else value


def _hash_sample(array: Any) -> Any:
    """The first numbers, of which 0 and -0, and all that are not finite, are one."""
    first = array.reshape(-1)[: _HASH_BYTES // max(array.itemsize, 1)]
    return np.where(np.isfinite(first), first, 0) + 0 if first.dtype.kind == "f" else first
