"""How immutable things travel by pickle and copy: what was said of them goes along, what was worked out does not."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from functools import cache, cached_property
from itertools import repeat
from typing import Any

import numpy as np


def pickle_state(thing: Any) -> dict[str, Any]:
    """The attributes of an object without what its cached properties hold."""
    kind: type = type(thing)
    worked_out = _cached_names(kind)
    return {name: value for name, value in vars(thing).items() if name not in worked_out}


@cache
def _cached_names(kind: type) -> frozenset[str]:
    """The names of a class's cached properties."""
    found = {name: value for base in reversed(kind.__mro__) for name, value in vars(base).items()}
    return frozenset(name for name, value in found.items() if isinstance(value, cached_property))


def restore_state(thing: Any, state: dict[str, Any]) -> None:
    """Give an object its attributes back; arrays are read-only, which pickles do not keep."""
    vars(thing).update({name: align_array(value) for name, value in state.items()})
    freeze_arrays(thing)


def construct_many(kind: type[Any], count: int, **fields: Iterable[Any]) -> list[Any]:
    """So many objects of a class with these values of their fields, all of them, of which each was checked before."""
    made = list(map(object.__new__, repeat(kind, count)))
    for name, values in fields.items():
        deque(map(object.__setattr__, made, repeat(name), values), maxlen=0)
    return made


def align_array(value: Any) -> Any:
    """The same; a copy of an array that lies between the places of its numbers, as in a message of a network."""
    return value.copy() if isinstance(value, np.ndarray) and not value.flags.aligned else value


def freeze_arrays(thing: Any) -> None:
    """Make all arrays among an object's attributes read-only."""
    for value in vars(thing).values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
