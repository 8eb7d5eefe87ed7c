"""Flatten shapes and steps of motions into a hashable structure and a list of float parameters, and back.

Shapes of one structure can be lowered by one recording.
"""

from __future__ import annotations

import dataclasses
import math
import operator
from collections.abc import Callable, Hashable, Mapping, Sequence
from functools import cache
from itertools import chain
from typing import Any, cast

import numpy as np

from .._util.records import dataclass
from ..geometry.shape import Shape
from ..kernels.tables import Floats, Longs
from ..numerics.tracing import Tape


@dataclasses.dataclass(slots=True)
class ShapeParameters:
    """A shape or step flattened: the structure of its fields, and their numbers in order."""

    form: tuple[Hashable, ...]
    numbers: list[float]


@cache
def _field_readers(kind: Any) -> list[Callable[[Any], Any]]:
    """Return readers of the fields of a type of shape or step, except its motion."""
    return [operator.attrgetter(each.name) for each in dataclasses.fields(kind) if each.name != "motion"]


def _field_columns(kind: Any, things: Sequence[Any]) -> list[list[Any]]:
    """Read each field of all things of one type."""
    return [list(map(get, things)) for get in _field_readers(kind)]


def flatten(thing: Any) -> ShapeParameters | None:
    """Flatten a shape or a step; None where it holds more than numbers, strings, None, tuples and mappings of these."""
    form: list[Hashable] = [cast(Hashable, type(thing))]
    numbers: list[float] = []
    for get in _field_readers(cast(Any, type(thing))):
        if not _flatten_value(get(thing), form, numbers):
            return None
    return ShapeParameters(tuple(form), numbers)


def _flatten_value(value: Any, form: list[Hashable], numbers: list[float]) -> bool:
    """Flatten a value of a field into `form` and `numbers`; return False for a value of another type."""
    kind = type(value)
    if kind is float and math.isfinite(value):
        form.append(float)
        numbers.append(value)
    elif kind is tuple:
        form.append(len(value))
        for place, each in enumerate(value):
            if type(each) is float and math.isfinite(each):
                numbers.append(each)
                continue
            # Places of items that are no floats separate, say, ((1.0, 2.0), 3.0) from (1.0, (2.0, 3.0)).
            form.append((place,))
            if not _flatten_value(each, form, numbers):
                return False
    elif value is None or kind in (str, bool, int, float):  # a flat side of a lens has an infinite radius
        form.append(value)
    elif isinstance(value, Mapping):  # coefficients by their names
        form.append(tuple(value))
        return _flatten_value(tuple(value.values()), form, numbers)
    elif isinstance(value, Shape) and not value.motion.steps:  # such as the box that cuts a quadric
        flat = flatten(value)
        if flat is None:
            return False
        form.append(flat.form)
        numbers += flat.numbers
    else:
        return False
    return True


@dataclass(frozen=True)
class ParameterRows:
    """The parameters of shapes or steps of one structure: which ones, and their numbers (n, numbers)."""

    form: tuple[Hashable, ...]
    which: Longs
    numbers: Floats


def flatten_all(things: Sequence[Any]) -> list[ParameterRows]:
    """Flatten many shapes or steps, grouped by structure; those that cannot be flattened are in no group.

    A field is read for all of them at once. An object that occurs several times, such as a part that many bodies share,
    is read once.
    """
    # Grouping by identity pays where many objects occur several times.
    place = dict(zip(map(id, things), range(len(things)), strict=True))
    if 2 * len(place) > len(things):
        return _flatten_distinct(things, np.arange(len(things)))
    number = {key: rank for rank, key in enumerate(place)}
    index = np.fromiter(map(number.__getitem__, map(id, things)), np.int64, len(things))
    found = []
    for group in _flatten_distinct([things[k] for k in place.values()], np.arange(len(place))):
        row = np.full(len(place), -1)
        row[group.which] = np.arange(len(group.which))
        rows = row[index]
        which = np.flatnonzero(rows >= 0)
        found.append(ParameterRows(group.form, which, group.numbers[rows[which]]))
    return found


def _flatten_distinct(things: Sequence[Any], which: Longs) -> list[ParameterRows]:
    """`flatten_all` for distinct things."""
    kinds = list(map(type, things))
    if len(set(kinds)) > 1:
        return _flatten_by_key(things, which, kinds)
    columns = [np.zeros((len(things), 0))]
    for column in _field_columns(kinds[0], things) if things else ():
        numbers = _column_numbers(column)
        if numbers is None:
            keys = list(map(_value_key, column))
            return _flatten_by_key(things, which, keys) if len(set(keys)) > 1 else _one_by_one(things, which)
        columns.append(np.array(numbers, np.float64).reshape(len(things), -1))
    flat = flatten(things[0]) if things else None
    return [ParameterRows(flat.form, which, np.concatenate(columns, axis=1))] if flat is not None else []


def _flatten_by_key(things: Sequence[Any], which: Longs, keys: Sequence[Hashable]) -> list[ParameterRows]:
    """`_flatten_distinct` for the things of each key; there are several keys."""
    found: list[ParameterRows] = []
    for part in positions_by_key(keys).values():
        found += _flatten_distinct([things[k] for k in part], which[part])
    return found


def positions_by_key(keys: Sequence[Hashable]) -> dict[Any, list[int]]:
    """Return the positions of each key."""
    parts: dict[Any, list[int]] = {}
    if len(set(keys)) == 1:
        return {keys[0]: list(range(len(keys)))}
    for place, key in enumerate(keys):
        parts.setdefault(key, []).append(place)
    return parts


def _one_by_one(things: Sequence[Any], which: Longs) -> list[ParameterRows]:
    """`_flatten_distinct` for things whose fields are too deep to read together."""
    flat = list(map(flatten, things))
    parts = positions_by_key([None if each is None else each.form for each in flat])
    parts.pop(None, None)
    return [
        ParameterRows(
            form, which[part], np.array([cast(ShapeParameters, flat[k]).numbers for k in part]).reshape(len(part), -1)
        )
        for form, part in parts.items()
    ]


def _column_numbers(column: Sequence[Any]) -> Sequence[float] | None:
    """Return the numbers in a field of all things, one thing after the other; None where their structures differ."""
    kinds = set(map(type, column))
    if len(kinds) > 1:
        return None
    kind = next(iter(kinds), float)
    if kind is float and all(map(math.isfinite, column)):
        return column
    if kind is tuple:
        if len(set(map(len, column))) > 1:
            return None
        within = list(chain.from_iterable(column))
        return _column_numbers(within) if set(map(type, within)) in ({float}, {tuple}) else None
    return () if kind in (type(None), str, bool, int, float) and len(set(column)) == 1 else None


def _value_key(value: Any) -> Hashable:
    """Return a key that separates values of different structure, one level deep."""
    if type(value) is tuple:
        return tuple, len(value)
    is_constant = type(value) in (str, bool, int) or (type(value) is float and not math.isfinite(value))
    return (type(value), value) if is_constant else cast(Hashable, type(value))


def _rebuild_value(value: Any, tape: Tape) -> Any:
    """Rebuild a value of a field with traced numbers."""
    if type(value) is float:
        return tape.input(value) if math.isfinite(value) else value
    if isinstance(value, Shape):
        return unflatten(value, tape)
    if isinstance(value, Mapping):
        return {name: tape.input(number) for name, number in value.items()}
    return tuple(_rebuild_value(each, tape) for each in value) if type(value) is tuple else value


def unflatten(thing: Any, tape: Tape) -> Any:
    """Rebuild a shape or a step with traced numbers; nothing of it is validated again."""
    rebuilt = object.__new__(type(thing))
    for each in dataclasses.fields(thing):
        value = getattr(thing, each.name)
        object.__setattr__(rebuilt, each.name, value if each.name == "motion" else _rebuild_value(value, tape))
    return rebuilt
