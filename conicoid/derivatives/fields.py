"""Every number of a shape, by a name that says where it stands; and the shape again with other numbers.

One walk, in one order, serves both: the operands of Booleans, the steps of motions and a box within which a shape is
cut are gone into. Numbers are floats; what is infinite, such as the end of a range, is none.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Generator, Mapping
from typing import Any, TypeAlias

import numpy as np

from ..shapes.base import Shape
from ..shapes.bulk import Bulk
from ..shapes.ellipsoid import Ellipsoid
from ..shapes.motion import STILL, Motion, Step
from ..shapes.revolution import Revolution
from ..shapes.spheres import Spheres
from ..shapes.steps import Rotate, Scale, Transform, Translate

Take: TypeAlias = Callable[[str, float], Any]
"""What is to stand in place of a number, by its name."""
Make: TypeAlias = Callable[[Any, dict[str, Any]], Any]
"""A shape or a step with other values of some fields."""

Task: TypeAlias = Generator["Task", Any, Any]
"""What yields the tasks that it needs the results of."""

_ANGLES = ("start_angle", "end_angle")


def retold(shape: Any, take: Take, make: Make, path: str | None = "") -> Any:
    """The shape with every number replaced by what `take` gives for it. path: before the names; None for no names."""
    return _run(_retold(shape, take, make, path))


def value_retold(value: Any, take: Take, make: Make) -> Any:
    """The value of a field with every number replaced."""
    return _run(_value(value, take, make, None))


def _run(task: Task) -> Any:
    """What a task returns, which yields the tasks that it needs done before: nothing calls itself level by level."""
    waiting, result = [task], None
    while waiting:
        try:
            before = waiting[-1].send(result)
        except StopIteration as done:
            waiting.pop()
            result = done.value
        else:
            waiting.append(before)
            result = None
    return result


def _on(path: str | None, more: str) -> str | None:
    return None if path is None else path + more


def _retold(shape: Any, take: Take, make: Make, path: str | None) -> Task:
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(shape):
        if not field.init or field.name == "motion" or is_derived(shape, field.name):
            continue
        old = getattr(shape, field.name)
        new = yield _value(old, take, make, _on(path, field.name))
        if new is not old:
            changes[field.name] = new
    motion = retold_motion(shape.motion, take, make, _on(path, "motion"))
    if motion is not shape.motion:
        changes["motion"] = motion
    return make(shape, changes) if changes else shape


def is_derived(shape: Any, name: str) -> bool:
    """Does a field say nothing of its own: radii besides coefficients, angles of a whole turn?"""
    if name == "radii" and getattr(shape, "coefficients", None) is not None:
        return True
    if isinstance(shape, Revolution) and name in _ANGLES:
        return bool(shape.end_angle - shape.start_angle >= 360)
    return name in _ANGLES and getattr(shape, "reference", 0) is None


def retold_motion(motion: Motion, take: Take, make: Make, path: str | None) -> Motion:
    """The motion with every number of its steps replaced."""
    steps = tuple(_run(_step(step, take, make, _on(path, f"[{k}]."))) for k, step in enumerate(motion.steps))
    return motion if all(new is old for new, old in zip(steps, motion.steps, strict=True)) else Motion(steps)


def _step(step: Any, take: Take, make: Make, path: str | None) -> Task:
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(step):
        old = getattr(step, field.name)
        if isinstance(step, Transform):
            rows = yield _value(old[:3], take, make, _on(path, "matrix"))
            new: Any = (
                old if rows is old[:3] or all(a is b for a, b in zip(rows, old, strict=False)) else (*rows, old[3])
            )
        else:
            new = yield _value(old, take, make, _on(path, field.name))
        if new is not old:
            changes[field.name] = new
    return make(step, changes) if changes else step


def _value(value: Any, take: Take, make: Make, path: str | None) -> Task:
    if isinstance(value, float):
        return take(path or "", value) if math.isfinite(value) else value
    if isinstance(value, np.ndarray):
        return _array(value, take, path)
    if isinstance(value, Shape):
        made = yield _retold(value, take, make, _on(path, "."))
        return made
    if isinstance(value, Mapping):
        new = {name: take(_on(path, f".{name}") or "", number) for name, number in value.items()}
        return value if all(new[name] is number for name, number in value.items()) else new
    if isinstance(value, tuple):
        parts = []
        for k, part in enumerate(value):
            made = yield _value(part, take, make, _on(path, f"[{k}]"))
            parts.append(made)
        return value if all(new is old for new, old in zip(parts, value, strict=True)) else tuple(parts)
    return value


def _array(values: Any, take: Take, path: str | None) -> Any:
    """The numbers of many bodies."""
    old = values.tolist()
    if values.ndim == 1:
        new = [take(_on(path, f"[{i}]") or "", x) for i, x in enumerate(old)]
    else:
        new = [[take(_on(path, f"[{i}][{k}]") or "", x) for k, x in enumerate(row)] for i, row in enumerate(old)]
    return values if new == old else np.array(new)


def unchecked(thing: Any, changes: dict[str, Any]) -> Any:
    """A shape or a step with other values of fields, of which nothing is checked."""
    made = object.__new__(type(thing))
    for field in dataclasses.fields(thing):
        object.__setattr__(made, field.name, changes.get(field.name, getattr(thing, field.name)))
    return made


def checked(thing: Any, changes: dict[str, Any]) -> Any:
    """A shape with other values of fields, as if it was said so. Raises what its class raises."""
    if not isinstance(thing, Shape):
        return unchecked(thing, changes)
    motion = changes.pop("motion", None)
    made = dataclasses.replace(thing, **_said_again(thing, changes)) if changes else thing
    return made if motion is None else _moved(made, motion)


def _said_again(thing: Any, changes: dict[str, Any]) -> dict[str, Any]:
    if "coefficients" in changes and isinstance(thing, Ellipsoid):
        return {"radii": Ellipsoid.radii, **changes}
    return changes


def _moved(shape: Shape, motion: Motion) -> Shape:
    """The shape under a motion whose steps are asked for anew, so that they are checked."""
    told = STILL
    for step in motion.steps:
        told = _then(told, step)
    made: Shape = dataclasses.replace(shape, motion=told)
    told.check(type(shape).__name__)
    return made


def _then(motion: Motion, step: Step) -> Motion:
    if isinstance(step, Translate):
        return motion.translate(step.offset)
    if isinstance(step, Rotate):
        return motion.rotate(step.axis, step.degrees)
    if isinstance(step, Scale):
        return motion.scale(step.factors)
    return motion.transform(step.matrix) if isinstance(step, Transform) else motion.then(Motion((step,)))


def numbers_of(shape: Shape, path: str | None = "") -> tuple[list[str], list[float]]:
    """The names and the values of all numbers of a shape."""
    names: list[str] = []
    values: list[float] = []

    def take(name: str, value: float) -> float:
        names.append(name)
        values.append(value)
        return value

    retold(shape, take, unchecked, path)
    return names, values


def values_of(shape: Shape) -> Any:
    """`numbers_of`, the values alone: quickly also of many bodies."""
    if not isinstance(shape, Bulk):
        return np.array(numbers_of(shape, None)[1])
    parts = [np.ravel(getattr(shape, name)) for name in shape.columns]
    steps: list[float] = []

    def take(_: str, value: float) -> float:
        steps.append(value)
        return value

    retold_motion(shape.motion, take, unchecked, None)
    return np.concatenate([*parts, np.array(steps)])


def columns_of_leaf(shape: Bulk, leaf: int) -> tuple[str | float, ...]:
    """What the fields of one primitive of each body are of: columns, or constants."""
    leaves: Any = (("radii", "centers"),) if isinstance(shape, Spheres) else shape.leaves
    return tuple(leaves[leaf])
