"""The numbers that a user wrote for a shape, and the shape with each of them changed in its last place."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from ..shapes.coefficients import Coefficients
from ..shapes.motion import Motion

HALF_ULP = 2.0**-53
"""The relative change that is asked about: what rounding a number to float64 may do to it."""

Made = TypeVar("Made")


@dataclass(frozen=True)
class Change(Generic[Made]):
    """What one number, moved to the next float64, makes of a shape or a motion.

    number   as the user knows it: center[0], coefficients.xy, steps[1].degrees
    share    the change that is asked about (a relative 2^-53) as a part of the one that was made, in [1/2, 1]
    """

    number: str
    share: float
    made: Made


def changes(given: Made) -> Iterator[Change[Made]]:
    """A change for each number of a dataclass other than 0; what `given` refuses is left out. No motion of its own."""
    for name, value, put in _numbers(given, ""):
        for towards in (math.copysign(math.inf, value), 0.0):
            changed = math.nextafter(value, towards)
            if not changed or math.isinf(changed):
                continue
            try:
                made = put(changed)
            except ValueError:
                continue
            yield Change(name, HALF_ULP * abs(value / (changed - value)), made)
            break


def together(given: Any, change: Change[Any]) -> Change[Any] | None:
    """A change of all numbers that are equal to one in a table's column; None for any but the first of them."""
    found = _IN_TABLE.fullmatch(change.number)
    if found is None:
        return None
    field, row, column = found[1], int(found[2]), int(found[3])
    table = getattr(given, field)
    old, new = table[row][column], getattr(change.made, field)[row][column]
    rows = [k for k, each in enumerate(table) if each[column] == old]
    if rows[0] != row:
        return None
    changed = ((*each[:column], new, *each[column + 1 :]) if k in rows else each for k, each in enumerate(table))
    try:
        return dataclasses.replace(change, made=dataclasses.replace(given, **{field: tuple(changed)}))
    except ValueError:
        return None


_IN_TABLE = re.compile(r"(\w+)\[(\d+)\]\[(\d+)\]")

Put = Callable[[float], Any]


def _numbers(value: Any, name: str) -> Iterator[tuple[str, float, Put]]:
    """(name, number, what `value` is with another one in its place) for every finite number within."""
    if isinstance(value, float):
        if value and math.isfinite(value):
            yield name, value, lambda new: new
    elif isinstance(value, Coefficients):
        for key, number in value.items():
            yield f"{name}.{key}", number, _in_mapping(value, key)
    elif isinstance(value, tuple):
        for i, part in enumerate(value):
            for inner, number, put in _numbers(part, f"{name}[{i}]"):
                yield inner, number, _in_tuple(value, i, put)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        yield from _of_fields(value, name)


def _of_fields(value: Any, name: str) -> Iterator[tuple[str, float, Put]]:
    given = {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.init}
    if given.get("coefficients") is not None and "radii" in given:
        del given["radii"]  # they follow from the coefficients
    if not name and not isinstance(value, Motion):
        given.pop("motion", None)
    for field, part in given.items():
        for inner, number, put in _numbers(part, f"{name}.{field}" if name else field):
            yield inner, number, _in_field(value, given, field, put)


def _in_mapping(value: Coefficients, key: str) -> Put:
    return lambda new: Coefficients({**value, key: new})


def _in_tuple(value: tuple[Any, ...], i: int, put: Put) -> Put:
    return lambda new: (*value[:i], put(new), *value[i + 1 :])


def _in_field(value: Any, given: dict[str, Any], field: str, put: Put) -> Put:
    return lambda new: type(value)(**{**given, field: put(new)})
