"""The part of a plane that a slice shows: from a corner along two vectors at right angles, in pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from ..._util.arrays import BoxEnds, FloatArray
from ..._util.validation import as_integer, check_number, check_vector, format_value

AXES = ("x", "y", "z")
ACROSS = {"x": (1, 2), "y": (0, 2), "z": (0, 1)}
"""Which axes are to the right and up in slices across each axis."""
_SKEW = 1e-9
_MARGIN = 1.05
_MOST_PIXELS = 1 << 15


@dataclass(frozen=True, eq=False)
class Window:
    """corner + s u + t v, 0 <= s, t <= 1, in width x height pixels. Places in it are in lengths about its middle."""

    corner: FloatArray
    u: FloatArray
    v: FloatArray
    width: int
    height: int

    @property
    def size(self) -> tuple[float, float]:
        """Lengths of its sides."""
        return math.hypot(*self.u.tolist()), math.hypot(*self.v.tolist())

    @property
    def origin(self) -> tuple[float, float]:
        """Where the middle is along the directions of u and v: what is added to places for those of the user."""
        middle = self.corner + 0.5 * self.u + 0.5 * self.v
        return tuple(float(middle @ side) / length for side, length in zip((self.u, self.v), self.size, strict=True))  # type: ignore[return-value]

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """(left, right, bottom, top) in the user's places."""
        (x, y), (across, up) = self.origin, self.size
        return x - across / 2, x + across / 2, y - up / 2, y + up / 2

    def in_space(self, places: Any) -> FloatArray:
        """Points (n, 3) of places (n, 2) about the middle."""
        across, up = self.size
        s, t = places[:, :1] / across + 0.5, places[:, 1:] / up + 0.5
        points: FloatArray = self.corner + s * self.u + t * self.v
        return points

    def rows(self, first: int, last: int) -> FloatArray:
        """The centres of pixels (rows, width, 3), from row `first` to `last`; row 0 is the uppermost."""
        s = (np.arange(self.width) + 0.5) / self.width
        t = 1.0 - (np.arange(first, last) + 0.5) / self.height
        points: FloatArray = self.corner + s[None, :, None] * self.u + t[:, None, None] * self.v
        return points

    def exact(self) -> tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...], int]:
        """(middle, u, v, unit): integers, of which the middle and the sides are those over the unit."""
        corner, u, v = ([Fraction(float(x)) for x in part] for part in (self.corner, self.u, self.v))
        middle = [c + a / 2 + b / 2 for c, a, b in zip(corner, u, v, strict=True)]
        unit = math.lcm(*(x.denominator for part in (middle, u, v) for x in part))
        whole_ones = [tuple(int(x * unit) for x in part) for part in (middle, u, v)]
        return whole_ones[0], whole_ones[1], whole_ones[2], unit


def make_window(origin: Any, u: Any, v: Any, pixels: Any, at: Any, extent: BoxEnds) -> Window:
    """The window that the arguments of `Scene.slice` say."""
    if isinstance(origin, str):
        if u is not None or v is not None:
            raise ValueError("slice: u and v go with a corner as origin, not with an axis; at=... says where")
        corner, u, v = _across(origin, at, extent)
    else:
        if at is not None:
            raise ValueError("slice: at goes with an axis as origin, slice('z', at=0.5); a corner says where by itself")
        if u is None or v is None:
            raise ValueError("slice: origin must be 'x', 'y', 'z', or a corner with u and v, got a corner alone")
        corner, u, v = (
            np.array(check_vector("slice", name, given)) for name, given in (("origin", origin), ("u", u), ("v", v))
        )
    across, up = float(np.linalg.norm(u)), float(np.linalg.norm(v))
    if not (across > 0 and up > 0):
        raise ValueError(
            f"slice: u and v must not be zero, got {format_value(u.tolist())} and {format_value(v.tolist())}"
        )
    if abs(float(u @ v)) > _SKEW * across * up:
        raise ValueError(
            f"slice: u and v must be at right angles, got {format_value(u.tolist())} and {format_value(v.tolist())}"
        )
    return Window(corner, u, v, *_pixels(pixels, up / across))


def _across(axis: str, at: Any, extent: BoxEnds) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Corner and sides of a window that fits, across an axis."""
    if axis not in AXES:
        raise ValueError(f"slice: origin must be 'x', 'y', 'z', or a corner with u and v, got {format_value(axis)}")
    low, high = extent
    middle, half = (low + high) / 2, _MARGIN * (high - low) / 2
    right, up = ACROSS[axis]
    corner, sides = middle.copy(), np.zeros((2, 3))
    largest = float(max(half[right], half[up])) or 1.0
    for side, k in enumerate((right, up)):
        size = float(half[k]) or largest
        corner[k], sides[side, k] = middle[k] - size, 2 * size
    corner[AXES.index(axis)] = check_number("slice", "at", 0.0 if at is None else at)
    return corner, sides[0], sides[1]


def _pixels(pixels: Any, aspect: float) -> tuple[int, int]:
    """(width, height), from both or from the number along the longer side."""
    sizes = [as_integer(size) for size in pixels] if isinstance(pixels, tuple | list) else [as_integer(pixels)]
    given = [size for size in sizes if size is not None and 1 <= size <= _MOST_PIXELS]
    if len(given) != len(sizes) or len(given) not in (1, 2):
        raise ValueError(
            "slice: pixels must be a whole number, or (width, height), up to "
            f"{_MOST_PIXELS}, got {format_value(pixels)}"
        )
    if len(given) == 2:
        return given[0], given[1]
    longer = given[0]
    return (longer, max(1, round(longer * aspect))) if aspect <= 1 else (max(1, round(longer / aspect)), longer)
