"""Arguments in each other's places: a call whose numbers stand where vectors are wanted is told how it goes."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np

_NUMBERS, _VECTORS = ("float", "int"), ("VectorLike", "VectorLike | None")
_HIDDEN = ("self", "cls")
_BESIDES = {
    "Plane": "; through a point p its offset is normal·p",
    "HalfSpace": "; through a point p its offset is normal·p",
    "Cylinder": "; along an axis, end is start + height * axis",
    "Cone": "; along an axis, end is start + height * axis",
    "Camera": "; an angle is named, field_of_view=40",
    "Body": "",
}
"""What there is to say besides of things that are given otherwise elsewhere."""


def misplaced(names: Mapping[str, inspect.Parameter], args: Sequence[Any]) -> bool:
    """Whether an argument without a name is plainly none of its place: a number for a vector, a vector for a number.

    Or anything for a shape, where a shape is in another place. One argument alone has no other place.
    """
    places = [one for name, one in names.items() if name not in _HIDDEN]
    pairs = [(str(one.annotation), value) for one, value in zip(places, args, strict=False)]
    if len(pairs) < 2:
        return False
    some_number = any(_is_number(value) for wanted, value in pairs if wanted not in _NUMBERS)
    for wanted, value in pairs:
        if wanted in _NUMBERS and (_is_vector(value) or (isinstance(value, str) and some_number)):
            return True
        if wanted in _VECTORS and _is_number(value):
            return True
        if wanted == "Shape" and not _is_shape(value) and any(map(_is_shape, args)):
            return True
    return False


def order(name: str, written: str) -> str:
    """What to add to a message: how the call goes."""
    return f"; call it as {name}({written}){_BESIDES.get(name, '')}"


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _is_vector(value: Any) -> bool:
    return isinstance(value, (tuple, list, np.ndarray)) and len(np.shape(value)) == 1 and len(value) == 3


def _is_shape(value: Any) -> bool:
    return hasattr(value, "bounds_under")
