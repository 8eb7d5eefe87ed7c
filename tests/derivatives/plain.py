"""Shapes and motions as plain values with numbers of mpmath, in 50 digits, and vectors of these.

Nothing here is Conicoid's: a shape is read into plain values, of which some are changed by the names of parameters.
"""

from __future__ import annotations

import dataclasses
import re
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np

mp = mpmath.MPContext()
mp.dps = 50


def read(thing: Any) -> Any:
    """A shape, a step of a motion or a value, as plain values with numbers of mpmath."""
    if isinstance(thing, float):
        return mp.mpf(thing)
    if isinstance(thing, np.ndarray):
        return read(thing.tolist())
    if isinstance(thing, tuple | list):
        return [read(each) for each in thing]
    if isinstance(thing, dict):
        return {name: read(value) for name, value in thing.items()}
    if dataclasses.is_dataclass(thing):
        values = {field.name: read(getattr(thing, field.name)) for field in dataclasses.fields(thing)}
        made = SimpleNamespace(kind=type(thing).__name__, **values)
        if hasattr(made, "motion"):
            made.motion = made.motion.steps
        return made
    return thing


def parts(name: str) -> list[Any]:
    """The way to a number: "motion[0].offset[1]" is motion, 0, offset, 1."""
    return [int(part) if part.isdigit() else part for part in re.findall(r"[^.\[\]]+", name)]


def holder(shape: Any, name: str) -> tuple[Any, Any]:
    """What holds a number, and under which key."""
    *way, last = parts(name)
    for part in way:
        if isinstance(shape, SimpleNamespace) and part == "operands" and not hasattr(shape, "operands"):
            shape = [shape.operand]
        else:
            shape = shape[part] if isinstance(shape, list | dict) else getattr(shape, part)
    return shape, last


def get(shape: Any, name: str) -> Any:
    owner, key = holder(shape, name)
    return getattr(owner, key) if isinstance(owner, SimpleNamespace) else owner[key]


def put(shape: Any, name: str, value: Any) -> None:
    owner, key = holder(shape, name)
    if isinstance(owner, SimpleNamespace):
        setattr(owner, key, value)
    else:
        owner[key] = value


# Vectors


def dot(a: Any, b: Any) -> Any:
    return sum((x * y for x, y in zip(a, b, strict=True)), mp.mpf(0))


def minus(a: Any, b: Any) -> Any:
    return [x - y for x, y in zip(a, b, strict=True)]


def cross(a: Any, b: Any) -> Any:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a: Any) -> Any:
    size = mp.sqrt(dot(a, a))
    return [x / size for x in a]


def turns(x: Any, y: Any) -> Any:
    return mp.atan2(y, x) / (2 * mp.pi) % 1


# Motions, backward


def back(steps: list[Any], x: Any) -> Any:
    for step in reversed(steps):
        x = _undone(step, x)
    return x


def _undone(step: Any, x: Any) -> Any:
    if step.kind == "Translate":
        return minus(x, step.offset)
    if step.kind == "Scale":
        return [a / k for a, k in zip(x, step.factors, strict=True)]
    if step.kind == "Rotate":
        k, angle = unit(step.axis), -step.degrees * mp.pi / 180
        s, c = mp.sin(angle), mp.cos(angle)
        along, aside = dot(k, x), cross(k, x)
        return [a * c + b * s + n * along * (1 - c) for a, b, n in zip(x, aside, k, strict=True)]
    if step.kind == "Back":
        return [dot(row[:3], x) + row[3] for row in step.rows]
    rows = step.matrix
    return solved([row[:3] for row in rows[:3]], [a - row[3] for a, row in zip(x, rows, strict=False)])


def solved(rows: Any, right: Any) -> Any:
    """x with rows x = right, by Cramer's rule."""
    a, b, c = rows
    columns = cross(b, c), cross(c, a), cross(a, b)
    size = dot(a, columns[0])
    return [sum(column[i] * value for column, value in zip(columns, right, strict=True)) / size for i in range(3)]


def undone(thing: Any) -> Any:
    """A shape whose motions are worked out backward, each as one affine map, so that points need no more than that."""
    if isinstance(thing, list):
        return [undone(each) for each in thing]
    if not isinstance(thing, SimpleNamespace):
        return thing
    made = SimpleNamespace(**{name: undone(value) for name, value in vars(thing).items() if name != "motion"})
    if hasattr(thing, "motion"):
        corners = [[mp.mpf(int(i == k)) for i in range(3)] for k in range(4)]
        *ends, origin = [back(thing.motion, corner) for corner in corners]
        rows = [[*(end[i] - origin[i] for end in ends), origin[i]] for i in range(3)]
        made.motion = [SimpleNamespace(kind="Back", rows=rows)] if thing.motion else []
    return made


# Frames


def least_of(axis: Any) -> int:
    """Where an axis is least; the first of those that are equal, but for a change that is to be a derivative."""
    return min(range(3), key=lambda i: round(float(abs(axis[i])), 12))


def axes(start: Any, axis: Any, reference: Any) -> Any:
    """x, y, z of the frame: z along the axis, x towards the reference, or the axis least along it."""
    z = unit(axis)
    if reference is None:
        least = least_of(axis)
        towards = [mp.mpf(int(i == least)) for i in range(3)]
    else:
        towards = minus(reference, start)
    x = unit(minus(towards, [dot(towards, z) * c for c in z]))
    return [x, cross(z, x), z]


def framed(start: Any, axis: Any, reference: Any, x: Any) -> Any:
    return [dot(row, minus(x, start)) for row in axes(start, axis, reference)]
