"""A camera and lights for scenes that come without."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from .._util.arrays import BoxEnds, FloatArray, Vector, dot_rows, matmul_rows
from .._util.errstate import ignore_fp_errors
from .._util.validation import LARGEST, SMALLEST
from ..materials.light import AmbientLight, DirectionalLight, Light
from ..numerics.portable_math import sin_cos_degrees, tan_degrees
from .camera import AnyCamera, Camera, camera_basis

_TOWARDS = (-0.55, 1.0, -0.45)  # from the right, in front, above
_MARGIN = 1.08


@ignore_fp_errors
def fit_extent(boxes: FloatArray) -> BoxEnds:
    """The box around all finite bounds (n, 6); unbounded axes are cut to the size of the rest, or to ±1."""
    some = boxes[(boxes[:, :3] <= boxes[:, 3:]).all(axis=1)]
    low, high = some[:, :3], some[:, 3:]
    low = np.where(np.isfinite(low), low, np.inf).min(axis=0, initial=np.inf)
    high = np.where(np.isfinite(high), high, -np.inf).max(axis=0, initial=-np.inf)
    low, high = np.where(np.isfinite(low), low, np.nan), np.where(np.isfinite(high), high, np.nan)
    sizes = high - low
    size = float(np.nanmax(sizes)) if np.isfinite(sizes).any() and np.nanmax(sizes) > 0 else 2.0
    only_low, only_high = np.isfinite(low) & np.isnan(high), np.isnan(low) & np.isfinite(high)
    none = np.isnan(low) & np.isnan(high)
    high = np.where(only_low, low + size, np.where(none, size / 2, high))
    low = np.where(only_high, high - size, np.where(none, -size / 2, low))
    flat = low == high
    if flat.all():
        low, high = low - 1, high + 1
    return low, high


@ignore_fp_errors
def fit_camera(low: FloatArray, high: FloatArray, aspect: float, turns: int = 1) -> Camera:
    """A camera that has a box in view, on a picture `aspect` times as wide as high.

    With several `turns` also at all of so many equal turns of the box about the upright through its middle.

    The distance is the least at which all eight corners, at depth f along the view and u across it,
    keep |u| <= (distance + f) tan(half angle), with a margin.
    """
    center = (low + high) / 2
    position = center - np.array(_TOWARDS)
    right, up, forward = camera_basis(_vector(position), _vector(center), (0, 0, 1))
    half = tan_degrees(15)
    distance = 0.0
    corners = np.array(np.meshgrid(*np.stack([low, high], axis=1))).reshape(3, -1).T - center
    for turn in range(turns):
        s, c = sin_cos_degrees(Fraction(360 * turn, turns))
        turned = matmul_rows(corners, np.array([(c, s, 0), (-s, c, 0), (0, 0, 1)]))
        for across, slope in ((right, half * aspect), (up, half)):
            needed = _MARGIN * np.abs(dot_rows(turned, across)) / slope - dot_rows(turned, forward)
            distance = max(distance, float(needed.max()))
    position = center - distance * forward
    if not (np.abs([position, center]) <= LARGEST).all():
        raise ValueError(
            f"Scene: bounds must leave room for a camera within {LARGEST:g}, got {_vector(low)} to {_vector(high)}; "
            "give the scene a camera"
        )
    return Camera(snap_to_domain(position), snap_to_domain(center), field_of_view=30)


@ignore_fp_errors
def fit_lights(camera: AnyCamera) -> tuple[Light, ...]:
    """A key light from above the camera's left shoulder, a weak one from its right, and ambient light."""
    right, up, forward = camera_basis(camera.position, camera.look_at, camera.up)
    key, fill = forward + 0.7 * right - 0.9 * up, forward - 1.4 * right - 0.1 * up
    return (
        AmbientLight(0.22),
        DirectionalLight(_vector(key), 0.75),
        DirectionalLight(_vector(fill), 0.15),
    )


def snap_to_domain(point: FloatArray) -> Vector:
    """Return a point of the domain: a smaller component goes to the nearer of 0 and the least number."""
    least = np.where(2 * np.abs(point) < SMALLEST, 0.0, np.copysign(SMALLEST, point))
    return _vector(np.where(np.abs(point) < SMALLEST, least, point))


def _vector(v: FloatArray) -> Vector:
    """An array as three floats."""
    return float(v[0]), float(v[1]), float(v[2])
