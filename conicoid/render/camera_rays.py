"""The rays of a camera's pixels, made where they are traced."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from .._jit.decorators import helper, inline, kernel, record_shapes
from .._util.arrays import FloatArray
from .._util.records import compare_by_value
from ..kernels.numbers.elementary import cos_sin_turns
from ..kernels.numbers.vectors import normalize, quotient, unit_vector
from ..kernels.tables import Floats, Signs
from ..kernels.threads import KernelRange
from ..queries.hit_fields import put_ray
from ..queries.rays import LazyRays
from .film import QUANTILES, lower_filter
from .options import (
    CAMERA_NUMBERS,
    EQUIDISTANT,
    EQUIRECTANGULAR,
    EQUISOLID,
    LINEAR,
    THIN_LENS,
    CameraModel,
    Filter,
    check_size,
)


@compare_by_value("camera", "width", "height")
class CameraRays(LazyRays):
    """`camera.rays(width, height)`, of shape (height, width)."""

    def __init__(self, camera: CameraModel, width: int, height: int) -> None:
        self.camera = camera
        self.width, self.height = check_size(width, height)

    @property
    def shape(self) -> tuple[int, ...]:
        return self.height, self.width

    def _work(self, begin: int, origins: FloatArray, directions: FloatArray, bad: Signs) -> KernelRange:
        before = self._view, begin, 0.5, 0.5, self.width, self.height
        return KernelRange(pixel_lines, before, (origins, directions, bad))

    @cached_property
    def _view(self) -> CameraView:
        """Of a lens that of its middle, as a pinhole has it."""
        view = lower_view(self.camera, "box")
        return view._replace(kind=LINEAR) if view.kind == THIN_LENS else view

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_view"}


# Cameras as kernels take them: rays of points of a picture, through points of a lens, and filters.
#
# A thin lens (Potmesil and Chakravarty 1981): all rays of a point of the film meet in one point of the plane in
# focus, so
# the ray through the point p of the lens goes from there to that where the ray through its middle meets this plane.


@record_shapes(lens="6 3", numbers=str(CAMERA_NUMBERS), quantiles=str(QUANTILES), kind="0..3", filtered="0..1")
class CameraView(NamedTuple):
    """A camera and a filter."""

    lens: Floats
    """`AnyCamera.lens`"""
    kind: int
    numbers: Floats
    """`AnyCamera.optics`"""
    filtered: int
    """Is there a filter other than the square of a pixel?"""
    quantiles: Floats
    """Of the filter's absolute value, in even steps (`film.lower_filter`)."""
    sign_change: float
    """How far from a pixel's middle, in pixels, the filter becomes negative."""
    scale: float
    """The weight of every sample, so that their mean is 1."""


def lower_view(camera: CameraModel, form: Filter) -> CameraView:
    """Return the arguments of kernels."""
    kind, numbers = camera.optics
    quantiles, sign_change, scale = lower_filter(form)
    return CameraView(camera.lens, kind, np.array(numbers), int(form != "box"), quantiles, sign_change, scale)


@inline
def camera_ray(
    lens: Floats, x: float, y: float, width: int, height: int
) -> tuple[float, float, float, float, float, float]:
    """Origin and unit direction through a point of the picture, in pixels (see `camera`)."""
    high = float(height)
    inverse = 1.0 / high
    u, v = quotient(2.0 * x - width, high, inverse), quotient(high - 2.0 * y, high, inverse)
    dx, dy, dz = unit_vector(
        lens[3, 0] + u * lens[4, 0] + v * lens[5, 0],
        lens[3, 1] + u * lens[4, 1] + v * lens[5, 1],
        lens[3, 2] + u * lens[4, 2] + v * lens[5, 2],
    )
    ox = lens[0, 0] + u * lens[1, 0] + v * lens[2, 0]
    oy = lens[0, 1] + u * lens[1, 1] + v * lens[2, 1]
    oz = lens[0, 2] + u * lens[1, 2] + v * lens[2, 2]
    return ox, oy, oz, dx, dy, dz


@inline
def square_to_disc(a: float, b: float) -> tuple[float, float]:
    """A point of the unit disc, evenly spread as (a, b) is over [0, 1)² (Shirley and Chiu 1997)."""
    p, q = 2.0 * a - 1.0, 2.0 * b - 1.0
    if p == 0.0 and q == 0.0:
        return 0.0, 0.0
    if abs(p) > abs(q):
        r, turns = p, 0.125 * (q / p)
    else:
        r, turns = q, 0.25 - 0.125 * (p / q)
    c, s = cos_sin_turns(turns)
    return r * c, r * s


@inline
def square_to_polygon(a: float, b: float, corners: float) -> tuple[float, float]:
    """A point of the regular polygon with corners on the unit circle, the first at (1, 0), evenly spread."""
    place = a * corners
    edge = np.floor(place)
    c0, s0 = cos_sin_turns(edge / corners)
    c1, s1 = cos_sin_turns((edge + 1.0) / corners)
    r, along = math.sqrt(b), place - edge
    return r * (c0 + along * (c1 - c0)), r * (s0 + along * (s1 - s0))


@inline
def lens_ray(
    view: CameraView, x: float, y: float, a: float, b: float, width: int, height: int
) -> tuple[float, float, float, float, float, float]:
    """The ray of a point of the picture through that point of the lens which (a, b) in [0, 1)² stands for."""
    lens, radius, focus, blades = view.lens, view.numbers[0], view.numbers[1], view.numbers[2]
    u, v = (2.0 * x - width) / height, (height - 2.0 * y) / height
    if blades > 0.0:
        p, q = square_to_polygon(a, b, blades)
    else:
        p, q = square_to_disc(a, b)
    # d₁ and d₂ are as long as the tangent of half the angle
    half = math.sqrt(lens[5, 0] * lens[5, 0] + lens[5, 1] * lens[5, 1] + lens[5, 2] * lens[5, 2])
    p, q = p * radius / half, q * radius / half
    u, v = u * focus - p, v * focus - q
    ox = lens[0, 0] + p * lens[4, 0] + q * lens[5, 0]
    oy = lens[0, 1] + p * lens[4, 1] + q * lens[5, 1]
    oz = lens[0, 2] + p * lens[4, 2] + q * lens[5, 2]
    dx, dy, dz = normalize(
        focus * lens[3, 0] + u * lens[4, 0] + v * lens[5, 0],
        focus * lens[3, 1] + u * lens[4, 1] + v * lens[5, 1],
        focus * lens[3, 2] + u * lens[4, 2] + v * lens[5, 2],
    )
    return ox, oy, oz, dx, dy, dz


@inline
def panoramic_ray(
    view: CameraView, x: float, y: float, width: int, height: int
) -> tuple[float, float, float, float, float, float, bool]:
    """Return a ray, and whether the camera sees there, of an `EquirectangularCamera` or a `FisheyeCamera`."""
    lens, is_inside = view.lens, True
    if view.kind == EQUIRECTANGULAR:
        c, s = cos_sin_turns(x / width - 0.5)
        along, up = cos_sin_turns(0.25 - 0.5 * (y / height))
        f, r = along * c, along * s
    else:
        u, v = (2.0 * x - width) / height, (height - 2.0 * y) / height
        far = math.sqrt(u * u + v * v)
        is_inside = far <= 1.0
        if view.numbers[0] == EQUIDISTANT:
            f, s = cos_sin_turns(far * view.numbers[1])
        elif view.numbers[0] == EQUISOLID:
            sine = min(1.0, far * view.numbers[2])
            f, s = 1.0 - 2.0 * sine * sine, 2.0 * sine * math.sqrt(1.0 - sine * sine)
        else:
            tangent = far * view.numbers[3]
            below = 1.0 + tangent * tangent
            f, s = (1.0 - tangent * tangent) / below, 2.0 * tangent / below
        r, up = (u / far * s, v / far * s) if far > 0.0 else (0.0, 0.0)
    dx, dy, dz = normalize(
        f * lens[3, 0] + r * lens[4, 0] + up * lens[5, 0],
        f * lens[3, 1] + r * lens[4, 1] + up * lens[5, 1],
        f * lens[3, 2] + r * lens[4, 2] + up * lens[5, 2],
    )
    return lens[0, 0], lens[0, 1], lens[0, 2], dx, dy, dz, is_inside


@helper
def general_ray(
    view: CameraView, x: float, y: float, a: float, b: float, width: int, height: int
) -> tuple[float, float, float, float, float, float, bool]:
    """(ray, does the camera see there?) of any camera; (a, b) in [0, 1)² is the place on its lens."""
    if view.kind == LINEAR:
        ox, oy, oz, dx, dy, dz = camera_ray(view.lens, x, y, width, height)
        return ox, oy, oz, dx, dy, dz, True
    if view.kind == THIN_LENS:
        ox, oy, oz, dx, dy, dz = lens_ray(view, x, y, a, b, width, height)
        return ox, oy, oz, dx, dy, dz, True
    return panoramic_ray(view, x, y, width, height)


@inline
def filtered_offset(view: CameraView, a: float) -> tuple[float, float]:
    """(distance of a sample from the middle of its pixel, and its weight) along one axis, for a in [0, 1)."""
    place = a * (QUANTILES - 1)
    k = int(place)
    low = view.quantiles[k]
    offset = low + (place - k) * (view.quantiles[k + 1] - low)
    return offset, -1.0 if abs(offset) > view.sign_change else 1.0


@kernel(
    first="0..4611686018427387904",
    width="1..2147483647",
    height="1..2147483647",
    begin="0..end",
    end="0..n",
    origins="out n 3",
    directions="out n 3",
    bad="out 1",
)
def pixel_lines(
    view: CameraView, first: int, a: float, b: float, width: int, height: int, begin: int, end: int, origins: Floats,
    directions: Floats, bad: Signs,
) -> None:  # fmt: skip
    """Compute rays through the centres of pixels, row by row: rays begin..end of those from pixel `first` on.

    All go through one point (a, b) of the lens; (1/2, 1/2) is its centre. bad[0] = 1 where a ray cannot be traced.
    """
    row, column = (first + begin) // width, (first + begin) % width
    linear, wrong = view.kind == LINEAR, 0
    for i in range(begin, end):
        if linear:  # merged into the loop
            ox, oy, oz, dx, dy, dz = camera_ray(view.lens, column + 0.5, row + 0.5, width, height)
        else:
            ox, oy, oz, dx, dy, dz, _ = general_ray(view, column + 0.5, row + 0.5, a, b, width, height)
        wrong |= put_ray(origins, directions, i, ox, oy, oz, dx, dy, dz)
        column += 1
        if column == width:
            row, column = row + 1, 0
    if wrong != 0:
        bad[0] = 1
