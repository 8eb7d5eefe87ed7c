"""Pickle and copy immutable objects: fields travel, values of cached properties do not."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from functools import cache, cached_property
from itertools import repeat
from typing import Any

import numpy as np


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
