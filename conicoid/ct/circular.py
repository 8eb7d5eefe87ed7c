"""Scans around the z axis, by the names and conventions of the ASTRA toolbox; angles are in degrees.

At angle θ the source is at source_origin · (sin θ, -cos θ, 0) and the centre of the detector across from it, its
columns along (cos θ, sin θ, 0) and its rows along z. Parallel rays go along (sin θ, -cos θ, 0), and their detector
is centred on the axis. (ASTRA takes radians, and has sinograms as (rows, views, columns): np.swapaxes(s, 0, 1).)
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

from ..shapes.arrays import real_array
from ..shapes.calls import explained
from ..shapes.degrees import warn_of_radians
from ..shapes.rounded import sin_cos_degrees
from ..shapes.validate import number, numbers, positive
from ..shapes.vector import FloatArray
from .geometry import Geometry


@explained
def parallel(angles: Any, columns: int, *, spacing: float = 1.0, offset: float = 0.0) -> Geometry:
    """Parallel rays in the plane z = 0, ASTRA's `parallel`: (views, columns).

    angles: (views,), in degrees. columns: pixels; spacing: their distance; offset: of the detector along its row.
    """
    step, shift = positive("parallel", "spacing", spacing), number("parallel", "offset", offset)
    turns = _turns("parallel", angles)
    return Geometry(_vectors(turns, 1.0, 0.0, (step, 1.0), (shift, 0.0), True), 1, columns, True, is_plane=True)


@explained
def parallel3d(
    angles: Any, rows: int, columns: int, *, spacing: Any = (1.0, 1.0), offset: Any = (0.0, 0.0)
) -> Geometry:
    """Parallel rays on a detector of rows and columns, ASTRA's `parallel3d`: (views, rows, columns).

    angles: (views,), in degrees. spacing: (along a row, between rows), or one number for both.
    offset: of the detector, along these.
    """
    steps, shifts = _pair("parallel3d", "spacing", spacing), _pair("parallel3d", "offset", offset, False)
    return Geometry(_vectors(_turns("parallel3d", angles), 1.0, 0.0, steps, shifts, True), rows, columns, True)


@explained
def fanflat(
    angles: Any, columns: int, source_origin: float, origin_detector: float, *,
    spacing: float = 1.0, offset: float = 0.0, radius: float = 0.0,
) -> Geometry:  # fmt: skip
    """A fan of rays in the plane z = 0, ASTRA's `fanflat`: (views, columns).

    angles: (views,), in degrees. source_origin, origin_detector: distances from the axis.
    columns, spacing, offset: as for `parallel`.
    radius: of a curved detector; source_origin + origin_detector is one about the source, whose rays are at equal
        angles; 0 is a flat one.
    """
    step, shift = positive("fanflat", "spacing", spacing), number("fanflat", "offset", offset)
    far, near = _distances("fanflat", source_origin, origin_detector)
    vectors = _vectors(_turns("fanflat", angles), far, near, (step, 1.0), (shift, 0.0), False)
    return Geometry(vectors, 1, columns, False, True, radius, shift)


@explained
def cone(
    angles: Any, rows: int, columns: int, source_origin: float, origin_detector: float, *,
    spacing: Any = (1.0, 1.0), offset: Any = (0.0, 0.0), radius: float = 0.0,
) -> Geometry:  # fmt: skip
    """A cone of rays from a source that goes around in a circle, ASTRA's `cone`: (views, rows, columns).

    angles, rows, columns, spacing, offset: as for `parallel3d`. source_origin, origin_detector, radius: as for
    `fanflat`; a curved detector is straight along z.
    """
    return _turning("cone", angles, (rows, columns), (source_origin, origin_detector), 0.0, (spacing, offset), radius)


@explained
def helical(
    angles: Any, rows: int, columns: int, source_origin: float, origin_detector: float, pitch: float, *,
    spacing: Any = (1.0, 1.0), offset: Any = (0.0, 0.0), radius: float = 0.0,
) -> Geometry:  # fmt: skip
    """A `cone` whose source and detector move along z, by `pitch` in a turn: at angle θ they are at pitch θ / 360.

    angles: (views,), in degrees, over as many turns as wanted, also negative ones.
    """
    distances = source_origin, origin_detector
    return _turning("helical", angles, (rows, columns), distances, pitch, (spacing, offset), radius)


def _turning(
    owner: str, angles: Any, pixels: tuple[int, int], distances: tuple[Any, Any], pitch: Any, steps_and_shifts: Any,
    radius: float,
) -> Geometry:  # fmt: skip
    """A cone whose source moves along z by a pitch, 0 of a circle; owner: what messages call it."""
    steps, shifts = _pair(owner, "spacing", steps_and_shifts[0]), _pair(owner, "offset", steps_and_shifts[1], False)
    far, near = _distances(owner, *distances)
    turns = _turns(owner, angles)
    vectors = _vectors(turns, far, near, steps, shifts, False)
    heights = number(owner, "pitch", pitch) * (np.asarray(angles, float).ravel() / 360)
    vectors[:, 2] += heights
    vectors[:, 5] += heights
    return Geometry(vectors, *pixels, False, False, radius, shifts[0])


def _vectors(
    turns: FloatArray, far: float, near: float, steps: tuple[float, ...], shifts: tuple[float, ...], is_parallel: bool
) -> FloatArray:
    """The twelve numbers of each view, by the sines and cosines of their angles (views, 2)."""
    s, c = turns.T
    zero, one = np.zeros_like(s), np.ones_like(s)
    source, along = np.stack([s, -c, zero], axis=1), np.stack([c, s, zero], axis=1)
    up = np.stack([zero, zero, one], axis=1)
    center = shifts[0] * along + shifts[1] * up - (0.0 if is_parallel else near) * source
    return np.concatenate([source if is_parallel else far * source, center, steps[0] * along, steps[1] * up], axis=1)


def _turns(owner: str, angles: Any) -> FloatArray:
    """(sin, cos) of angles in degrees, each rounded once."""
    given = real_array(owner, "angles", angles, "numbers (views,)")
    if given.ndim != 1:
        hint = "; of so many views they are np.linspace(0, 180, views, endpoint=False)" if given.ndim == 0 else ""
        raise ValueError(f"{owner}: angles must be finite numbers of shape (views,), got shape {given.shape}{hint}")
    if not np.isfinite(given).all():
        raise ValueError(
            f"{owner}: angles must be finite numbers of shape (views,), got {given[~np.isfinite(given)][0]}"
        )
    warn_of_radians(owner, "angles", angles)
    return np.array([sin_cos_degrees(Fraction(angle)) for angle in given.tolist()]).reshape(-1, 2)


def _pair(owner: str, field: str, value: Any, is_positive: bool = True) -> tuple[float, ...]:
    if is_positive and np.ndim(value) == 0 and not isinstance(value, str):
        value = (value, value)  # square pixels
    found = numbers(owner, field, value, 2)
    return tuple(positive(owner, field, x) for x in found) if is_positive else found


def _distances(owner: str, source_origin: Any, origin_detector: Any) -> tuple[float, float]:
    far, near = positive(owner, "source_origin", source_origin), number(owner, "origin_detector", origin_detector)
    if far + near <= 0:
        raise ValueError(
            f"{owner}: origin_detector must be > -source_origin, got {near}: the detector is behind the source"
        )
    return far, near
