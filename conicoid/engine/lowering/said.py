"""What was said of a shape or of a step of a motion: the form of its fields, and their numbers.

Those of one form can be lowered by one recording.
"""

from __future__ import annotations

import dataclasses
import operator
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, cast

from ...shapes.recorder import Tape


@dataclass(slots=True)
class Said:
    """What was said of a shape: the form of its fields, and their numbers from the first to the last."""

    form: tuple[Hashable, ...]
    numbers: list[float]


_FIELDS: dict[type, Callable[[Any], tuple[Any, ...]]] = {}


def _fields_of(kind: type) -> Callable[[Any], tuple[Any, ...]]:
    """What reads the fields of a kind of shape or step, but for the motion."""
    found = _FIELDS.get(kind)
    if found is None:
        names = [each.name for each in dataclasses.fields(kind) if each.name != "motion"]
        get = operator.attrgetter(*names)
        found = _FIELDS[kind] = get if len(names) > 1 else lambda thing: (get(thing),)
    return found


def said(thing: Any) -> Said | None:
    """What was said of a shape or a step; None where there is more to it than numbers."""
    form: list[Hashable] = [cast(Hashable, type(thing))]
    numbers: list[float] = []
    for value in _fields_of(type(thing))(thing):
        if not _take(value, form, numbers):
            return None
    return Said(tuple(form), numbers)


def _take(value: Any, form: list[Hashable], numbers: list[float]) -> bool:
    """Add a value of a field; False for what has another form."""
    kind = type(value)
    if kind is float:
        form.append(float)
        numbers.append(value)
    elif kind is tuple:
        form.append(len(value))
        for place, each in enumerate(value):
            if type(each) is float:
                numbers.append(each)
                continue
            form.append((place,))
            if not _take(each, form, numbers):
                return False
    elif value is None or kind in (str, bool, int):
        form.append(value)
    else:
        return False
    return True


def _retold(value: Any, tape: Tape) -> Any:
    """A value of a field with numbers that are recorded."""
    if type(value) is float:
        return tape.input(value)
    return tuple(_retold(each, tape) for each in value) if type(value) is tuple else value


def again(thing: Any, tape: Tape) -> Any:
    """A shape or a step whose numbers are recorded; nothing of it is checked anew."""
    made = object.__new__(type(thing))
    for each in dataclasses.fields(thing):
        if each.name != "motion":
            object.__setattr__(made, each.name, _retold(getattr(thing, each.name), tape))
    return made
