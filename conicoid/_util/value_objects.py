"""Objects that are values: equality and hashes by fields, arrays among them, and pickles.

Equality is one truth value, and NaN equals NaN. Fields travel in a pickle, values of cached properties do not.
"""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from functools import cache, cached_property
from itertools import repeat
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


# --- Pickles and copies


def pickle_state(thing: Any) -> dict[str, Any]:
    """Return the attributes of an object without the values of its cached properties."""
    kind: type = type(thing)
    cached = _cached_names(kind)
    return {name: value for name, value in vars(thing).items() if name not in cached}


@cache
def _cached_names(kind: type) -> frozenset[str]:
    """Return the names of the cached properties of a class."""
    # Bases first: a subclass may replace a cached property
    attributes = {name: value for base in reversed(kind.__mro__) for name, value in vars(base).items()}
    return frozenset(name for name, value in attributes.items() if isinstance(value, cached_property))


def restore_state(thing: Any, state: dict[str, Any]) -> None:
    """Set the attributes of an object; make arrays read-only, which pickles do not preserve."""
    vars(thing).update({name: align_array(value) for name, value in state.items()})
    freeze_arrays(thing)


def construct_many(kind: type[Any], count: int, **fields: Iterable[Any]) -> list[Any]:
    """Return `count` objects of a class from the values of all its fields, without checks.

    The caller has checked each value.
    """
    objects = list(map(object.__new__, repeat(kind, count)))
    # The loop over objects runs in C, and sets frozen fields without the `__setattr__` of the class
    for name, values in fields.items():
        deque(map(object.__setattr__, objects, repeat(name), values), maxlen=0)
    return objects


def align_array(value: Any) -> Any:
    """Return the value; for an array that is not aligned, as in a message of a network, an aligned copy."""
    return value.copy() if isinstance(value, np.ndarray) and not value.flags.aligned else value


def freeze_arrays(thing: Any) -> None:
    """Make all arrays among the attributes of an object read-only."""
    for value in vars(thing).values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
