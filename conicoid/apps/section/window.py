"""`Window`: the rectangle of a plane that a slice shows, from a corner along two perpendicular vectors, in pixels."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from ..._util.arrays import BoxEnds, FloatArray
from ..._util.records import dataclass
from ..._util.validation import as_integer, check_number, check_vector, format_value

AXES = ("x", "y", "z")
PLANE_AXES = {"x": (1, 2), "y": (0, 2), "z": (0, 1)}
"""Axis across a slice -> the axes that point to the right and up in it."""
_SKEW = 1e-9
"""Largest cosine between u and v that counts as a right angle."""
_MARGIN = 1.05
"""Size of a fitting window, in sizes of the scene."""
_MOST_PIXELS = 1 << 15
"""Along one side."""


@dataclass(frozen=True, eq=False)
class Window:
    """The rectangle corner + s u + t v, 0 <= s, t <= 1, in width x height pixels.

    Places in it are lengths along u and v from its middle.
    """

    corner: FloatArray
    u: FloatArray
    v: FloatArray
    width: int
    height: int

    @property
    def size(self) -> tuple[float, float]:
        """The lengths of u and v."""
        return math.hypot(*self.u.tolist()), math.hypot(*self.v.tolist())

    @property
    def origin(self) -> tuple[float, float]:
        """The coordinates of the middle along u and v. Adding them to places gives those of the user."""
        middle = self.corner + 0.5 * self.u + 0.5 * self.v
        return tuple(float(middle @ side) / length for side, length in zip((self.u, self.v), self.size, strict=True))  # type: ignore[return-value]

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """(left, right, bottom, top) in the coordinates of the user."""
        (x, y), (across, up) = self.origin, self.size
        return x - across / 2, x + across / 2, y - up / 2, y + up / 2

    def in_space(self, places: Any) -> FloatArray:
        """Return the points (n, 3) of places (n, 2) about the middle."""
        across, up = self.size
        s, t = places[:, :1] / across + 0.5, places[:, 1:] / up + 0.5
        return self.corner + s * self.u + t * self.v

    def rows(self, first: int, last: int) -> FloatArray:
        """Return the centres of pixels, (rows, width, 3), of the rows `first` to `last`; row 0 is the top row."""
        # Pixel centres; t falls with the row, since row 0 is at the top.
        s = (np.arange(self.width) + 0.5) / self.width
        t = 1.0 - (np.arange(first, last) + 0.5) / self.height
        return self.corner + s[None, :, None] * self.u + t[:, None, None] * self.v

    def exact(self) -> tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...], int]:
        """Return (middle, u, v, unit): exact integer vectors, to be divided by the integer `unit`."""
        # Floats are fractions with powers of two below: one common unit makes all of them integers.
        corner, u, v = ([Fraction(float(x)) for x in part] for part in (self.corner, self.u, self.v))
        middle = [c + a / 2 + b / 2 for c, a, b in zip(corner, u, v, strict=True)]
        unit = math.lcm(*(x.denominator for part in (middle, u, v) for x in part))
        whole_ones = [tuple(int(x * unit) for x in part) for part in (middle, u, v)]
        return whole_ones[0], whole_ones[1], whole_ones[2], unit


def make_window(plane: Any, at: Any, corner: tuple[Any, Any, Any], pixels: Any, extent: BoxEnds) -> Window:
    """Return the window from the arguments of `Scene.slice`; `corner` is (origin, u, v), `extent` the scene's box.

    Raise ValueError for arguments that do not go together, and for sides that are zero or not perpendicular.
    """
    if plane is not None or all(part is None for part in corner):
        if any(part is not None for part in corner):
            raise ValueError("slice: origin, u and v give a plane of their own; leave out the axis")
        origin, u, v = _across("z" if plane is None else plane, at, extent)
    else:
        if at is not None:
            raise ValueError("slice: at is the place along an axis, slice('z', 0.5); origin gives the place")
        if any(part is None for part in corner):
            raise ValueError("slice: origin, u and v must be given together")
        named = zip(("origin", "u", "v"), corner, strict=True)
        origin, u, v = (np.array(check_vector("slice", name, value)) for name, value in named)
    across, up = float(np.linalg.norm(u)), float(np.linalg.norm(v))
    if not (across > 0 and up > 0):
        raise ValueError(
            f"slice: u and v must not be zero, got {format_value(u.tolist())} and {format_value(v.tolist())}"
        )
    if abs(float(u @ v)) > _SKEW * across * up:
        raise ValueError(
            f"slice: u and v must be at right angles, got {format_value(u.tolist())} and {format_value(v.tolist())}"
        )
    return Window(origin, u, v, *_pixels(pixels, up / across))


def _across(axis: Any, at: Any, extent: BoxEnds) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return corner and sides of a window across an axis that fits the scene."""
    if not isinstance(axis, str) or axis not in AXES:
        raise ValueError(f"slice: plane must be 'x', 'y' or 'z', got {format_value(axis)}; origin=, u=, v= give others")
    low, high = extent
    middle, half = (low + high) / 2, _MARGIN * (high - low) / 2
    right, up = PLANE_AXES[axis]
    corner, sides = middle.copy(), np.zeros((2, 3))
    largest = float(max(half[right], half[up])) or 1.0  # a flat side gets the length of the other one
    for side, k in enumerate((right, up)):
        size = float(half[k]) or largest
        corner[k], sides[side, k] = middle[k] - size, 2 * size
    corner[AXES.index(axis)] = check_number("slice", "at", 0.0 if at is None else at)
    return corner, sides[0], sides[1]


def _pixels(pixels: Any, aspect: float) -> tuple[int, int]:
    """Return (width, height), from both or from the number along the longer side."""
    sizes = [as_integer(size) for size in pixels] if isinstance(pixels, tuple | list) else [as_integer(pixels)]
    valid = [size for size in sizes if size is not None and 1 <= size <= _MOST_PIXELS]
    if len(valid) != len(sizes) or len(valid) not in (1, 2):
        raise ValueError(
            "slice: pixels must be a whole number, or (width, height), up to "
            f"{_MOST_PIXELS}, got {format_value(pixels)}"
        )
    # Both are given; else the shorter side follows from the aspect.
    if len(valid) == 2:
        return valid[0], valid[1]
    longer = valid[0]
    return (longer, max(1, round(longer * aspect))) if aspect <= 1 else (max(1, round(longer / aspect)), longer)
