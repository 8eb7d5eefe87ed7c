"""Cameras as data, projections of points onto their pictures, and a camera and lights for scenes that come without.

On a picture w wide and h high the point (x, y), in pixels from the top left corner, has the film coordinates
u = (2x - w) / h to the right and v = (h - 2y) / h upwards. The usual cameras are linear in them:

    origin = o₀ + u o₁ + v o₂,   direction = d₀ + u d₁ + v d₂,

so for kernels they are `lens`, these six vectors, and pixels are square whatever w and h are. An opening, or another
projection of directions onto the picture, is `optics` (see `camera_rays.CameraView`).
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

import numpy as np

from .._util.arrays import BoxEnds, FloatArray, Vector, VectorLike, dot_rows, ignore_fp_errors, matmul_rows, row_lengths
from .._util.records import dataclass
from .._util.text import check_choice
from .._util.validation import (
    LARGEST,
    SMALLEST,
    as_integer,
    check_degrees,
    check_direction,
    check_fields,
    check_nonnegative,
    check_positive,
    check_vector,
    describe_kind,
    format_value,
    optional,
)
from ..materials.light import AmbientLight, DirectionalLight, Light
from ..numerics.portable_math import sin_cos_degrees, tan_degrees
from .options import EQUIDISTANT, EQUIRECTANGULAR, EQUISOLID, FISHEYE, LINEAR, STEREOGRAPHIC, THIN_LENS, check_size

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..queries.rays import LazyRays, Rays


UP = (0.0, 0.0, 1.0)
MOST_BLADES = 100
"""The largest number of edges of an opening."""


class AnyCamera:
    """The base class of cameras: rays and projections of points."""

    position: Any
    look_at: Any
    up: Any

    @property
    def lens(self) -> FloatArray:
        """(6, 3): o₀, o₁, o₂, d₀, d₁, d₂."""
        raise NotImplementedError

    @property
    def optics(self) -> tuple[int, tuple[float, float, float, float]]:
        """The kind of camera, and its numbers (`camera_rays.CameraView`)."""
        return LINEAR, (0.0, 0.0, 0.0, 0.0)

    def pixel(self, width: int, height: int) -> tuple[float, float]:
        """Return the size of a pixel at the camera, and its growth for each unit of distance.

        Parameters
        ----------
        width, height : int
            Of the picture, in pixels.
        """
        lens = self.lens
        return 2 * float(row_lengths(lens[2])) / height, 2 * float(row_lengths(lens[5])) / height

    def rays(self, width: int, height: int) -> Rays:
        """Return the rays through the centres of pixels, those of a lens through its centre.

        Parameters
        ----------
        width, height : int
            Of the picture, in pixels.

        Returns
        -------
        Rays
            Of shape (height, width), the first row on top, with directions of unit length.
        """
        return self.lazy_rays(width, height).to_rays()

    def lazy_rays(self, width: int, height: int) -> LazyRays:
        """Return `rays(width, height)`, computed where they are traced; `Rays.from_camera` is the same.

        Parameters
        ----------
        width, height : int
            Of the picture, in pixels.
        """
        from .camera_rays import CameraRays

        return CameraRays(self, width, height)

    def project(self, points: npt.ArrayLike, width: int, height: int) -> FloatArray:
        """Return the places of points on a picture, whether or not other bodies hide them.

        Parameters
        ----------
        points : (..., 3)
            In the world.
        width, height : int
            Of the picture, in pixels.

        Returns
        -------
        float64 (..., 2)
            (x, y) in pixels from the top left corner. The centre of the first pixel is (0.5, 0.5); points beside the
            picture have coordinates beyond its edges. NaN for points that are not in front of the camera.
        """
        return project_points(self, points, width, height)

    def _film(self, points: FloatArray, width: int, height: int) -> FloatArray:
        """Return the film coordinates u and v of points, (..., 2); NaN for points that have none."""
        lens = self.lens
        # The inverse of the linear map: o₁ or d₁ is zero, so their sum is the vector across
        from_camera = points - lens[0]
        across, depth = lens[1:3] + lens[4:6], dot_rows(from_camera, lens[3])
        film = matmul_rows(from_camera, across.T) / dot_rows(across, across)
        return np.where((depth > 0)[..., None], film, np.nan)


@dataclass(frozen=True)
class Camera(AnyCamera):
    """A pinhole camera, or a thin lens.

    Parameters
    ----------
    position, look_at : (3,)
        The place of the camera, and the point in the middle of the picture.
    up : (3,)
        Upwards in the picture. If it lies along the view, it becomes y (z, if the view is along y).
    field_of_view : float
        Vertical, in degrees, in (0, 180).
    aperture : float
        The diameter of the opening of a thin lens, in units of the scene; 0 for a pinhole, which images everything
        sharply. A lens is sharp at one depth, that of `look_at` or `focus_distance`; a point at another depth z becomes
        a disc that is aperture |1 / focus_distance - 1 / z| wide at depth 1.
    focus_distance : float, optional
        Along the view, from the lens to the plane in focus.
    blades : int
        The number of edges of the opening, 3 or more; 0 for a round one. The first corner is to the right.

    Raises
    ------
    ValueError
        If position equals look_at, and for a field of view outside of (0, 180).
    """

    position: VectorLike
    look_at: VectorLike
    up: VectorLike = UP
    field_of_view: float = 40.0
    aperture: float = 0.0
    focus_distance: float | None = None
    blades: int = 0

    def __post_init__(self) -> None:
        _check_camera(self)
        check_fields(
            self,
            field_of_view=check_degrees,
            aperture=check_nonnegative,
            focus_distance=optional(check_positive),
        )
        if not 0 < self.field_of_view < 180:
            raise ValueError(f"Camera: field_of_view must be in (0, 180) degrees, got {self.field_of_view}")
        blades = as_integer(self.blades)
        if blades is None or not (blades == 0 or 3 <= blades <= MOST_BLADES):
            raise ValueError(
                f"Camera: blades must be 0, or a whole number from 3 to {MOST_BLADES}, got {format_value(self.blades)}"
            )
        object.__setattr__(self, "blades", blades)

    @property
    def lens(self) -> FloatArray:
        """(6, 3): o₀, o₁, o₂, d₀, d₁, d₂."""
        right, up, forward = camera_basis(self.position, self.look_at, self.up)
        half = tan_degrees(self.field_of_view / 2)
        zero = np.zeros(3)
        return np.array([self.position, zero, zero, forward, right * half, up * half])

    @property
    def optics(self) -> tuple[int, tuple[float, float, float, float]]:
        """The kind; a thin lens has the numbers (radius, distance of the plane in focus, blades, 0)."""
        if self.aperture == 0:
            return LINEAR, (0.0, 0.0, 0.0, 0.0)
        focus = self.focus_distance
        if focus is None:
            # Sharp at the point that the camera looks at, unless the scene states a distance
            focus = float(row_lengths(np.subtract(self.look_at, self.position)))
        return THIN_LENS, (self.aperture / 2, focus, float(self.blades), 0.0)

    def _film(self, points: FloatArray, width: int, height: int) -> FloatArray:
        # A pinhole divides by the depth; parallel rays do not
        depth = dot_rows(points - self.lens[0], self.lens[3])
        return super()._film(points, width, height) / np.where(depth > 0, depth, np.nan)[..., None]


@dataclass(frozen=True)
class OrthographicCamera(AnyCamera):
    """Parallel rays from a window about `position`, in the direction of `look_at`.

    Parameters
    ----------
    position, look_at : (3,)
        The centre of the window, and a point in the middle of the picture.
    up : (3,)
        As for `Camera`.
    height : float
        The height of the window, in units of the scene.

    Raises
    ------
    ValueError
        If position equals look_at, and for a height that is not positive.
    """

    position: VectorLike
    look_at: VectorLike
    up: VectorLike = UP
    height: float = 2.0

    def __post_init__(self) -> None:
        _check_camera(self)
        check_fields(self, height=check_positive)

    @property
    def lens(self) -> FloatArray:
        """(6, 3): o₀, o₁, o₂, d₀, d₁, d₂."""
        right, up, forward = camera_basis(self.position, self.look_at, self.up)
        half, zero = self.height / 2, np.zeros(3)
        return np.array([self.position, right * half, up * half, forward, zero, zero])


def as_camera(owner: str, camera: Any) -> AnyCamera | None:
    """Return a camera, or None for one that fits; raise TypeError for anything else."""
    if camera is not None and not isinstance(camera, AnyCamera):
        kinds = "Camera, OrthographicCamera, EquirectangularCamera, FisheyeCamera or None"
        raise TypeError(f"{owner}: camera must be a {kinds}, got {describe_kind(camera)}")
    return camera


@ignore_fp_errors
def camera_basis(position: Vector, look_at: Vector, up: Vector) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the unit vectors (right, up, forward) of a view."""
    forward = _unit(np.subtract(look_at, position))
    # `_check_camera` has replaced an `up` along the view, so this is not zero
    right = _unit(np.cross(forward, _unit(np.array(up))))
    return right, np.cross(right, forward), forward


@ignore_fp_errors
def project_points(camera: AnyCamera, points: npt.ArrayLike, width: int, height: int) -> FloatArray:
    """Return the pixel coordinates of points: the film coordinates of the rays through them, inverted."""
    from ..queries.rays import points_array

    width, height = check_size(width, height, "project")
    places = points_array("project", "points", points)
    film = camera._film(places, width, height)
    return (film * (height, -height) + (width, height)) / 2


@ignore_fp_errors
def _check_camera(camera: AnyCamera) -> None:
    """Check and normalise the fields that all cameras have."""
    check_fields(camera, position=check_vector, look_at=check_vector, up=check_direction)
    position, look_at = camera.position, camera.look_at
    if position == look_at:
        raise ValueError(f"{type(camera).__name__}: look_at must differ from position, got {position} for both")
    forward = np.subtract(look_at, position)
    if _are_along(forward, camera.up):  # a plan view: `up` cannot be along it
        up = (0.0, 0.0, 1.0) if _are_along(forward, (0.0, 1.0, 0.0)) else (0.0, 1.0, 0.0)
        object.__setattr__(camera, "up", up)


def _are_along(a: FloatArray, b: Vector) -> bool:
    """Return whether two vectors are parallel, up to rounding."""
    return float(np.abs(np.cross(_unit(a), _unit(np.array(b)))).max()) < 1e-12


def _unit(v: FloatArray) -> FloatArray:
    """Return a vector divided by its length; scaled before, so that no square overflows."""
    scaled = v / np.abs(v).max()
    return np.asarray(scaled / row_lengths(scaled))


# --- Cameras that see more than a plane film can hold

Projection: TypeAlias = Literal["equidistant", "equisolid", "stereographic"]


class _PanoramicCamera(AnyCamera):
    """A camera whose rays meet in its position, in any direction."""

    @property
    def lens(self) -> FloatArray:
        """(6, 3): the position, zeros, and the unit vectors forward, to the right and upwards."""
        right, up, forward = camera_basis(self.position, self.look_at, self.up)
        zero = np.zeros(3)
        return np.array([self.position, zero, zero, forward, right, up])

    def pixel(self, width: int, height: int) -> tuple[float, float]:
        """Return the size of a pixel at the camera, which is 0, and its growth for each unit of distance.

        Parameters
        ----------
        width, height : int
            Of the picture, in pixels.
        """
        kind, numbers = self.optics
        return 0.0, (4 * math.pi * numbers[1] if kind == FISHEYE else math.pi) / height

    def _directions(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the coordinates of points to the right, upwards and forward; NaN for the position itself."""
        lens = self.lens
        offsets = points - lens[0]
        offsets = np.where((offsets == 0).all(axis=-1, keepdims=True), np.nan, offsets)
        return dot_rows(offsets, lens[4]), dot_rows(offsets, lens[5]), dot_rows(offsets, lens[3])


@dataclass(frozen=True)
class EquirectangularCamera(_PanoramicCamera):
    """A map of everything around `position`: 360 degrees of longitude across the picture, 180 of latitude down.

    A picture twice as wide as high has square pixels at its equator: programs take it for a panorama or environment.

    Parameters
    ----------
    position, look_at : (3,)
        The place of the camera, and the point in the middle of the picture.
    up : (3,)
        Its part across the view is the axis of longitudes, which grow to the right.

    Raises
    ------
    ValueError
        If position equals look_at.
    """

    position: VectorLike
    look_at: VectorLike
    up: VectorLike = UP

    def __post_init__(self) -> None:
        _check_camera(self)

    @property
    def optics(self) -> tuple[int, tuple[float, float, float, float]]:
        """The kind; it has no numbers."""
        return EQUIRECTANGULAR, (0.0, 0.0, 0.0, 0.0)

    def _film(self, points: FloatArray, width: int, height: int) -> FloatArray:
        right, up, forward = self._directions(points)
        longitude, latitude = np.arctan2(right, forward), np.arctan2(up, np.hypot(right, forward))
        return np.stack([longitude * (width / height / math.pi), latitude * (2 / math.pi)], axis=-1)


@dataclass(frozen=True)
class FisheyeCamera(_PanoramicCamera):
    """A circle as high as the picture, of all directions within the field of view; black around it.

    Parameters
    ----------
    position, look_at : (3,)
        The place of the camera, and the point in the middle of the picture.
    up : (3,)
        Upwards in the picture.
    field_of_view : float
        In degrees, in (0, 360]; for a stereographic projection below 360.
    projection : {"equidistant", "equisolid", "stereographic"}
        The angle θ from the middle as a function of the distance r from it, 1 at the rim. Equidistant: θ in proportion
        to r. Equisolid: sin(θ/2) in proportion to r, equal areas for equal solid angles, as most lenses do.
        Stereographic: tan(θ/2) in proportion to r: small circles stay circles.

    Raises
    ------
    ValueError
        If position equals look_at, and for a field of view outside of its range.
    """

    position: VectorLike
    look_at: VectorLike
    up: VectorLike = UP
    field_of_view: float = 180.0
    projection: Projection = "equidistant"

    def __post_init__(self) -> None:
        _check_camera(self)
        check_fields(self, field_of_view=check_degrees)
        angle = self.field_of_view
        check_choice("FisheyeCamera", "projection", self.projection, get_args(Projection))
        if not 0 < angle <= 360 or (angle == 360 and self.projection == "stereographic"):
            limits = "(0, 360)" if self.projection == "stereographic" else "(0, 360]"
            raise ValueError(f"FisheyeCamera: field_of_view must be in {limits} degrees, got {angle}")

    @property
    def optics(self) -> tuple[int, tuple[float, float, float, float]]:
        """The kind, and (projection, θ at the rim in turns, sin(θ/2) there, tan(θ/2) there)."""
        number = get_args(Projection).index(self.projection)
        quarter = self.field_of_view / 4
        tangent = tan_degrees(quarter) if number == STEREOGRAPHIC else 0.0
        return FISHEYE, (float(number), self.field_of_view / 720, sin_cos_degrees(quarter)[0], tangent)

    def _film(self, points: FloatArray, width: int, height: int) -> FloatArray:
        right, up, forward = self._directions(points)
        across = np.hypot(right, up)
        angle = np.arctan2(across, forward)
        number, rim, sine, tangent = self.optics[1]
        if number == EQUIDISTANT:
            r = angle / (2 * math.pi * rim)
        else:
            r = np.sin(angle / 2) / sine if number == EQUISOLID else np.tan(angle / 2) / tangent
        divisor = np.where(across > 0, across, 1.0)
        film = np.stack([right, up], axis=-1) * np.where(across > 0, r / divisor, 0.0)[..., None]
        return np.where(np.isnan(row_lengths(film))[..., None], np.nan, film)


CAMERAS: dict[str, type[AnyCamera]] = {
    each.__name__: each for each in (Camera, OrthographicCamera, EquirectangularCamera, FisheyeCamera)
}
"""Scene-file name -> class."""


# --- A camera and lights for scenes that come without

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
            distances = _MARGIN * np.abs(dot_rows(turned, across)) / slope - dot_rows(turned, forward)
            distance = max(distance, float(distances.max()))
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
