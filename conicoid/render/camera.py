"""Cameras: data, and the rays of a picture's points.

On a picture w wide and h high the point (x, y), in pixels from the top left corner, has the film
coordinates u = (2x - w) / h to the right and v = (h - 2y) / h upwards. The usual cameras are linear in them:

    origin = o₀ + u o₁ + v o₂,   direction = d₀ + u d₁ + v d₂,

so for kernels they are `lens`, these six vectors, and pixels are square whatever w and h are. What else a camera is, an
opening or another way to lay directions on a picture, is `optics` (see `view`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shapes.calls import explained_methods
from ..shapes.calm import calm
from ..shapes.degrees import degrees
from ..shapes.other_names import hinted
from ..shapes.rounded import tan_degrees
from ..shapes.row_vectors import dot_rows, lengths, product
from ..shapes.validate import nonnegative, positive, shown, vector, what, whole
from ..shapes.vector import FloatArray, Vector, VectorLike

if TYPE_CHECKING:
    from ..engine.answers.lazy_rays import LazyRays
    from ..engine.answers.rays import Rays

UP = (0.0, 0.0, 1.0)
LINEAR, THIN_LENS, EQUIRECTANGULAR, FISHEYE = range(4)
"""Kinds of camera, as kernels know them."""
NUMBERS = 4
"""What a kind has beside its lens."""
MOST_BLADES = 100


@explained_methods
class AnyCamera:
    """What all cameras have."""

    position: Any
    look_at: Any
    up: Any

    @property
    def lens(self) -> FloatArray:
        """(6, 3): o₀, o₁, o₂, d₀, d₁, d₂."""
        raise NotImplementedError

    @property
    def optics(self) -> tuple[int, tuple[float, float, float, float]]:
        """The kind of camera, and its numbers (`view.View`)."""
        return LINEAR, (0.0, 0.0, 0.0, 0.0)

    def pixel(self, width: int, height: int) -> tuple[float, float]:
        """How large a pixel of a picture of `width` x `height` is at the camera, and how much more each unit away."""
        lens = self.lens
        return 2 * float(lengths(lens[2])) / height, 2 * float(lengths(lens[5])) / height

    def rays(self, width: int, height: int) -> Rays:
        """Rays through the pixel centres, of shape (height, width), first row on top, directions of unit length.

        Of a lens those through its middle.
        """
        return self.lazy_rays(width, height).made()

    def lazy_rays(self, width: int, height: int) -> LazyRays:
        """`rays(width, height)`, made where they are traced; `Rays.from_camera` is the same."""
        from .camera_rays import CameraRays

        return CameraRays(self, width, height)

    def project(self, points: Any, width: int, height: int) -> FloatArray:
        """(..., 2): where points (..., 3) are seen on a picture of `width` x `height` pixels, (x, y) from its top left.

        The centre of the first pixel is (0.5, 0.5); what lies beside the picture has coordinates beyond its edges.
        NaN for points that are not in front of the camera. Nothing is said of what hides them.
        """
        return projected(self, points, width, height)

    def _film(self, points: FloatArray, width: int, height: int) -> FloatArray:
        """(..., 2): the film coordinates u and v of points, NaN where there are none."""
        lens = self.lens
        from_camera = points - lens[0]
        across, depth = lens[1:3] + lens[4:6], dot_rows(from_camera, lens[3])
        film = product(from_camera, across.T) / dot_rows(across, across)
        return np.where((depth > 0)[..., None], film, np.nan)


@hinted
@explained_methods
@dataclass(frozen=True)
class Camera(AnyCamera):
    """A pinhole camera at `position` that looks at `look_at`; `field_of_view` is vertical, in degrees.

    Where `up` lies along the view, y is up in the picture (z, if the view is along y): `camera.up` says so.

    aperture: the diameter of the opening of a thin lens, in units of the scene; 0 for a pinhole, which sees all sharp.
        A lens is sharp at one depth, that of `look_at` or `focus_distance`; a point at another depth z becomes a disc,
        aperture |1 / focus_distance - 1 / z| wide where the view's depth is 1.
    focus_distance: along the view, from the lens to the plane that is in focus.
    blades: how many edges the opening has, 3 or more; 0 for a round one. The first corner is to the right.

    Raises ValueError if position equals look_at, and for a field of view not in (0, 180).
    """

    position: VectorLike
    look_at: VectorLike
    up: VectorLike = UP
    field_of_view: float = 40.0
    aperture: float = 0.0
    focus_distance: float | None = None
    blades: int = 0

    def __post_init__(self) -> None:
        _check(self)
        angle = degrees("Camera", "field_of_view", self.field_of_view)
        if not 0 < angle < 180:
            raise ValueError(f"Camera: field_of_view must be in (0, 180) degrees, got {angle}")
        object.__setattr__(self, "field_of_view", angle)
        object.__setattr__(self, "aperture", nonnegative("Camera", "aperture", self.aperture))
        if self.focus_distance is not None:
            object.__setattr__(self, "focus_distance", positive("Camera", "focus_distance", self.focus_distance))
        blades = whole(self.blades)
        if blades is None or not (blades == 0 or 3 <= blades <= MOST_BLADES):
            raise ValueError(
                f"Camera: blades must be 0, or a whole number from 3 to {MOST_BLADES}, got {shown(self.blades)}"
            )
        object.__setattr__(self, "blades", blades)

    @property
    def lens(self) -> FloatArray:
        """(6, 3): o₀, o₁, o₂, d₀, d₁, d₂."""
        right, up, forward = basis(self.position, self.look_at, self.up)
        half = tan_degrees(self.field_of_view / 2)
        zero = np.zeros(3)
        return np.array([self.position, zero, zero, forward, right * half, up * half])

    @property
    def optics(self) -> tuple[int, tuple[float, float, float, float]]:
        """A thin lens has (radius, distance of the plane in focus, blades, 0)."""
        if self.aperture == 0:
            return LINEAR, (0.0, 0.0, 0.0, 0.0)
        focus = self.focus_distance
        if focus is None:
            focus = float(lengths(np.subtract(self.look_at, self.position)))
        return THIN_LENS, (self.aperture / 2, focus, float(self.blades), 0.0)

    def _film(self, points: FloatArray, width: int, height: int) -> FloatArray:
        depth = dot_rows(points - self.lens[0], self.lens[3])
        return super()._film(points, width, height) / np.where(depth > 0, depth, np.nan)[..., None]


@hinted
@explained_methods
@dataclass(frozen=True)
class OrthographicCamera(AnyCamera):
    """Parallel rays from a window `height` high about `position`, along the way to `look_at`.

    `up` is that of a `Camera`.
    """

    position: VectorLike
    look_at: VectorLike
    up: VectorLike = UP
    height: float = 2.0

    def __post_init__(self) -> None:
        _check(self)
        object.__setattr__(self, "height", positive("OrthographicCamera", "height", self.height))

    @property
    def lens(self) -> FloatArray:
        """(6, 3): o₀, o₁, o₂, d₀, d₁, d₂."""
        right, up, forward = basis(self.position, self.look_at, self.up)
        half, zero = self.height / 2, np.zeros(3)
        return np.array([self.position, right * half, up * half, forward, zero, zero])


def as_camera(owner: str, camera: Any) -> AnyCamera | None:
    """A camera, or None for one that fits; a TypeError otherwise."""
    if camera is not None and not isinstance(camera, AnyCamera):
        kinds = "Camera, OrthographicCamera, EquirectangularCamera, FisheyeCamera or None"
        raise TypeError(f"{owner}: camera must be a {kinds}, got {what(camera)}")
    return camera


@calm
def basis(position: Vector, look_at: Vector, up: Vector) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(right, up, forward): unit vectors of the view."""
    forward = _unit(np.subtract(look_at, position))
    right = _unit(np.cross(forward, _unit(np.array(up))))
    return right, np.cross(right, forward), forward


@calm
def projected(camera: AnyCamera, points: Any, width: int, height: int) -> FloatArray:
    """The pixel coordinates of points: the film coordinates u and v of the rays through them, turned around."""
    from ..engine.answers.rays import points_array

    width, height = checked_size(width, height, "project")
    places = points_array("project", "points", points)
    film = camera._film(places, width, height)
    pixels: FloatArray = (film * (height, -height) + (width, height)) / 2
    return pixels


def checked_size(width: int, height: int, owner: str = "rays") -> tuple[int, int]:
    """Width and height of what asks for them, as positive integers, or an error."""
    for name, value in (("width", width), ("height", height)):
        pixels = whole(value)
        if pixels is None or not 1 <= pixels < 1 << 31:
            raise ValueError(f"{owner}: {name} must be a whole number of pixels >= 1, got {shown(value)}")
    return int(width), int(height)


@calm
def _check(camera: AnyCamera) -> None:
    """Check and normalise the fields that all cameras have."""
    owner: str = type(camera).__name__
    position, look_at = vector(owner, "position", camera.position), vector(owner, "look_at", camera.look_at)
    up = vector(owner, "up", camera.up, nonzero=True)
    if position == look_at:
        raise ValueError(f"{owner}: look_at must differ from position, got {position} for both")
    forward = np.subtract(look_at, position)
    if _are_along(forward, up):  # a plan view
        up = (0.0, 0.0, 1.0) if _are_along(forward, (0.0, 1.0, 0.0)) else (0.0, 1.0, 0.0)
    for field, value in (("position", position), ("look_at", look_at), ("up", up)):
        object.__setattr__(camera, field, value)


def _are_along(a: FloatArray, b: Vector) -> bool:
    """Whether two vectors are parallel, up to rounding."""
    return float(np.abs(np.cross(_unit(a), _unit(np.array(b)))).max()) < 1e-12


def _unit(v: FloatArray) -> FloatArray:
    scaled = v / np.abs(v).max()
    return np.asarray(scaled / lengths(scaled))
