"""How large, where and how heavy: `measure` and its answer."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from ..shapes.base import Shape
from ..shapes.body import Body
from ..shapes.region import Boolean, Complement, Union
from ..shapes.sphere import Sphere
from ..shapes.spheres import Spheres
from ..shapes.vector import FloatArray
from .chords import AREA, FIRST, PAIRS, SECOND, VOLUME, Progress, Sums
from .closed import Moments, closed_area, closed_moments
from .frames import FittedBox, fitted_box
from .sample import sample

FEWEST_RAYS = 60


@dataclass(frozen=True, eq=False)
class Measures:
    """What `measure` found, each value with its standard error (one sigma; 0 where a closed form was used).

    volume, area   floats; a solid's area is that of its whole boundary, a sheet's counts one side
    centroid       (3,), NaN where the volume is 0
    inertia        (3, 3) tensor about the centroid for density 1: ∫ (|r|² 1 - r rᵀ) dV
    rays           how many rays were followed
    """

    volume: float
    area: float
    centroid: FloatArray
    inertia: FloatArray
    volume_error: float
    area_error: float
    centroid_error: FloatArray
    inertia_error: FloatArray
    rays: int

    def __str__(self) -> str:
        rows = [
            ("volume", self.volume, self.volume_error),
            ("area", self.area, self.area_error),
            *((f"centroid {a}", c, e) for a, c, e in zip("xyz", self.centroid, self.centroid_error, strict=True)),
            *((f"inertia {'xyz'[i]}{'xyz'[j]}", self.inertia[i, j], self.inertia_error[i, j]) for i, j in PAIRS),
        ]
        return "\n".join(
            f"{name:<11}{value:>16.9g}" + (f"  ± {error:.2g}" if error else "") for name, value, error in rows
        )


def measure(shape: Shape | Body, rays: int = 1_000_000, seed: int = 0, progress: Progress | None = None) -> Measures:
    """Volume, surface area, centroid and inertia of a bounded shape, with standard errors.

    Primitives have closed forms for the volume, centroid and inertia under any motion, and some for the
    area; everything else comes from the exact chords of about `rays` rays. Equal seeds give equal
    answers, for any number of threads. `progress(done, total)` is called now and then.
    Balls of a `Spheres` count as their union. An empty solid measures zero, and so does the volume of a sheet.

    Raises ValueError for an unbounded shape, naming the axes, and for fewer than 60 rays.
    """
    shape = shape.shape if isinstance(shape, Body) else shape
    if not isinstance(shape, Shape):
        raise TypeError(f"measure: shape must be a shape or a Body, got {type(shape).__name__}")
    if isinstance(rays, bool) or not isinstance(rays, (int, np.integer)) or rays < FEWEST_RAYS:
        raise ValueError(f"measure: rays must be an integer >= {FEWEST_RAYS}, got {rays!r}")
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise ValueError(f"measure: seed must be an integer >= 0, got {seed!r}")
    shape = _plain(shape)
    box = fitted_box(shape)
    nothing = Moments(0.0, np.full(3, np.nan), np.zeros((3, 3)))
    if box.is_empty:
        return _closed(nothing, 0.0)
    moments, area = nothing if shape.is_sheet else closed_moments(shape), closed_area(shape)
    if moments is not None and area is not None:
        return _closed(moments, area)
    found = _sampled(sample(shape, box, int(rays), int(seed), progress), box)
    return found if moments is None else _closed(moments, found.area, found.area_error, found.rays)


def _plain(shape: Shape) -> Shape:
    """Balls as their union; what is only painted, or alone in a combination, as it is."""
    while isinstance(shape, Boolean) and len(shape.operands) == 1 and not isinstance(shape, Complement):
        inner = shape.operands[0]
        shape = dataclasses.replace(inner, motion=inner.motion.then(shape.motion))
    if not isinstance(shape, Spheres):
        return shape
    if len(shape) == 0:
        return Sphere() - Sphere()
    balls = (Sphere(r, tuple(c)) for c, r in zip(shape.centers.tolist(), shape.radii.tolist(), strict=True))
    return Union(tuple(balls), motion=shape.motion)


def _closed(moments: Moments, area: float, area_error: float = 0.0, rays: int = 0) -> Measures:
    inertia = np.trace(moments.second) * np.eye(3) - moments.second
    none = np.zeros(3), np.zeros((3, 3))
    return _measures(moments.volume, area, moments.centroid, inertia, 0.0, area_error, *none, rays)


def _sampled(sums: Sums, box: FittedBox) -> Measures:
    """From integrals about the center of the box to values in the world, errors to first order."""
    values, covariance = sums.values, sums.covariance
    volume, errors = float(values[VOLUME]), np.sqrt(covariance.diagonal())
    if volume <= 0:
        unknown = np.full(3, np.nan), np.zeros((3, 3))
        return _measures(0.0, values[AREA], *unknown, errors[VOLUME], errors[AREA], *unknown, sums.rays)
    offset = values[FIRST] / volume
    slopes = [_about(unit, offset, box.axes) for unit in np.eye(len(values))]
    centroid_slopes = np.array([box.axes @ (unit[FIRST] - unit[VOLUME] * offset) for unit in np.eye(len(values))])
    return _measures(
        volume,
        values[AREA],
        box.center + box.axes @ offset,
        _about(values, offset, box.axes),
        errors[VOLUME],
        errors[AREA],
        _propagated(centroid_slopes / volume, covariance),
        _propagated(np.array(slopes), covariance),
        sums.rays,
    )


def _about(values: FloatArray, offset: FloatArray, axes: FloatArray) -> FloatArray:
    """The inertia tensor in the world about a fixed point, linear in the integrals."""
    second = np.empty((3, 3))
    for value, (i, j) in zip(values[SECOND], PAIRS, strict=True):
        second[i, j] = second[j, i] = value
    first = values[FIRST]
    second += values[VOLUME] * np.outer(offset, offset) - np.outer(first, offset) - np.outer(offset, first)
    turned: FloatArray = axes @ (np.trace(second) * np.eye(3) - second) @ axes.T
    return (turned + turned.T) / 2


def _propagated(slopes: FloatArray, covariance: FloatArray) -> FloatArray:
    """Standard errors of linear functions with slopes (11, ...)."""
    variance = np.einsum("i...,ij,j...->...", slopes, covariance, slopes)
    result: FloatArray = np.sqrt(np.maximum(variance, 0.0))
    return result


def _measures(
    volume: float, area: float, centroid: FloatArray, inertia: FloatArray,
    volume_error: float, area_error: float, centroid_error: FloatArray, inertia_error: FloatArray, rays: int,
) -> Measures:  # fmt: skip
    for array in (centroid, inertia, centroid_error, inertia_error):
        array.flags.writeable = False
    scalars = float(volume), float(area), float(volume_error), float(area_error)
    return Measures(
        scalars[0], scalars[1], centroid, inertia, scalars[2], scalars[3], centroid_error, inertia_error, rays
    )
