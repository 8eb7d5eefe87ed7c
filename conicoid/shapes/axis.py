"""The axis from start to end that cylinders and cones stand on."""

from __future__ import annotations

from . import exact as ex
from .motion import Frame, Motion
from .vector import Vector


def check_axis(owner: str, start: Vector, end: Vector) -> None:
    """Refuse ends that are equal."""
    if start == end:
        raise ValueError(f"{owner}: end must differ from start, got {end} for both")


def difference(start: Vector, end: Vector) -> ex.Row:
    """end - start, exact."""
    x, y, z = (ex.exact(b) - ex.exact(a) for a, b in zip(start, end, strict=True))
    return x, y, z


def axis_frame(start: Vector, end: Vector, reference: Vector | None) -> Motion:
    """Own frame to world: origin at start, z towards end, x towards the reference (Sasaki 2021)."""
    return Motion((Frame(start, difference(start, end), reference),))


def exact_length(start: Vector, end: Vector) -> ex.Exact:
    """|end - start| in 3000 bits."""
    axis = difference(start, end)
    return ex.sqrt(ex.dot(axis, axis))
