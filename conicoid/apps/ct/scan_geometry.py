"""Scans as data (`ScanGeometry`): for each view a source or a direction, and the places of the detector's pixels.

Constructors make scans around the z axis as in the ASTRA toolbox, from its dictionaries, and with RTK's parameters.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.arrays import FloatArray, ignore_fp_errors
from ..._util.records import compare_by_value, dataclass
from ..._util.validation import (
    check_flag,
    check_integer,
    check_nonnegative,
    check_number,
    check_numbers,
    check_positive,
    describe_kind,
    format_list,
    format_value,
    real_array,
    warn_of_degrees,
    warn_of_radians,
    zero_negligible,
)
from ...kernels.tables import Signs
from ...kernels.threads import KernelRange
from ...numerics.portable_math import sin_cos_degrees
from ...queries.hit_fields import scan_lines
from ...queries.rays import LazyRays


@compare_by_value()
@dataclass(frozen=True, eq=False)
class ScanGeometry:
    """Views of a scan, by ASTRA's twelve numbers each (`cone_vec` and `parallel3d_vec`).

    Parameters
    ----------
    vectors : ndarray (views, 12)
        The source, or the direction of parallel rays; the centre of the detector; u, from a pixel to the next in its
        row; v, from a pixel to the one in the next row.
    rows, columns : int
        Pixels of the detector. Pixel (i, j) is centred at
        centre + (j - (columns - 1) / 2) u + (i - (rows - 1) / 2) v.
    is_parallel : bool
        Whether rays are parallel. Then they are whole lines; else they go from the source to the pixel.
    is_plane : bool
        A scan of one row, whose sinogram has no axis of rows.
    radius : float
        Of a detector that is part of a cylinder about an axis along v, on the side of the source; 0 is a flat one. A
        pixel lies as far along the arc as it would in the plane that touches the cylinder.
    touch : float or ndarray (views,)
        Where that plane touches the cylinder: the distance from there to the centre, along u.

    Raises
    ------
    ValueError
        If the numbers make no scan.
    """

    vectors: FloatArray
    rows: int
    columns: int
    is_parallel: bool
    is_plane: bool = False
    radius: float = 0.0
    touch: Any = 0.0

    @ignore_fp_errors
    def __post_init__(self) -> None:
        vectors = np.array(real_array("ScanGeometry", "vectors", self.vectors))
        if vectors.ndim != 2 or vectors.shape[1] != 12 or not np.isfinite(vectors).all():
            raise ValueError(f"ScanGeometry: vectors must be finite numbers of shape (views, 12), got {vectors.shape}")
        u, v = vectors[:, 6:9], vectors[:, 9:]
        if len(vectors) and not np.cross(u, v).any(axis=1).all():
            raise ValueError("ScanGeometry: u and v of a view must not be parallel or zero")
        rows = check_integer("ScanGeometry", "rows", self.rows, 1)
        if check_flag("ScanGeometry", "is_plane", self.is_plane) and rows != 1:
            raise ValueError(f"ScanGeometry: rows must be 1 where the scan is plane, got {rows}")
        touch = real_array("ScanGeometry", "touch", self.touch, "a number for each view")
        if touch.shape not in ((), (len(vectors),)):
            raise ValueError(f"ScanGeometry: touch must be a number, or one for each view, got shape {touch.shape}")
        checked = dict(
            vectors=vectors,
            rows=rows,
            columns=check_integer("ScanGeometry", "columns", self.columns, 1),
            is_parallel=check_flag("ScanGeometry", "is_parallel", self.is_parallel),
            radius=check_nonnegative("ScanGeometry", "radius", self.radius),
            touch=np.array(np.broadcast_to(touch, len(vectors))),
        )
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        # A frozen dataclass: its arrays must not change either.
        vectors.flags.writeable = False

    @property
    def views(self) -> int:
        """Number of views."""
        return len(self.vectors)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the sinogram: (views, rows, columns), or (views, columns) of a plane scan."""
        return (self.views, self.columns) if self.is_plane else (self.views, self.rows, self.columns)

    @property
    def interval(self) -> tuple[float, float]:
        """t_min and t_max of the rays: 0 to 1 from the source to the pixel, or the whole of a line."""
        return (-np.inf, np.inf) if self.is_parallel else (0.0, 1.0)

    @property
    def lazy_rays(self) -> ScanRays:
        """The rays of all pixels, made only when they are traced."""
        return ScanRays(self)

    def __getitem__(self, index: Any) -> ScanGeometry:
        """Return the scan of some views, by a slice or numbers."""
        which = np.atleast_1d(np.arange(self.views)[index])
        return replace(self, vectors=self.vectors[which], touch=self.touch[which])

    def __len__(self) -> int:
        return self.views

    @ignore_fp_errors
    def pixels(self, view: Any, row: Any, column: Any) -> FloatArray:
        """Return the centres of pixels.

        Parameters
        ----------
        view, row, column : int or array_like of int
            Numbers of pixels; they broadcast together.

        Returns
        -------
        ndarray (..., 3)
        """
        center, u, v = (self.vectors[view, k : k + 3] for k in (3, 6, 9))
        across = np.asarray(column - (self.columns - 1) / 2)[..., None]
        up = np.asarray(row - (self.rows - 1) / 2)[..., None]
        if self.radius == 0:
            return np.asarray(center + across * u + up * v)
        length = np.sqrt((u * u).sum(axis=-1, keepdims=True))
        along, inwards = u / length, self._inwards(view)
        touch = self.touch[view][..., None]
        angle = (touch + across * length) / self.radius
        # 2 sin² (angle / 2) is 1 - cos angle without cancellation.
        bent = np.sin(angle) * self.radius * along + 2 * self.radius * np.sin(angle / 2) ** 2 * inwards
        return np.asarray(center - touch * along + bent + up * v)

    def _inwards(self, view: Any) -> FloatArray:
        """Return the normals of detectors, towards the source."""
        source, center, u, v = (self.vectors[view, k : k + 3] for k in (0, 3, 6, 9))
        normal = np.cross(u, v)
        normal = normal / np.sqrt((normal * normal).sum(axis=-1, keepdims=True))
        # Parallel rays travel along `source`, so the source is on the other side.
        back = -source if self.is_parallel else source - center
        return np.asarray(np.where((normal * back).sum(axis=-1, keepdims=True) < 0, -normal, normal))

    def __repr__(self) -> str:
        kind = "parallel" if self.is_parallel else "cone"
        return f"ScanGeometry({kind}, shape={self.shape})"


# The rays of a scan, made only when they are traced.


@compare_by_value("geometry")
class ScanRays(LazyRays):
    """Rays to the pixels of a scan, in the shape of its sinogram."""

    def __init__(self, geometry: ScanGeometry) -> None:
        self.geometry = geometry

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the sinogram."""
        return self.geometry.shape

    @property
    def interval(self) -> tuple[float, float]:
        """t_min and t_max: from the source to the pixel, or the whole of a line."""
        return self.geometry.interval

    def _lines(self, begin: int, end: int) -> tuple[FloatArray, FloatArray]:
        """Return origins and directions of the flat rays `begin` to `end`."""
        scan = self.geometry
        # The flat index runs over columns, then rows, then views.
        pixel, column = np.divmod(np.arange(begin, end), scan.columns)
        view, row = np.divmod(pixel, scan.rows)
        places, first = scan.pixels(view, row, column), scan.vectors[view, :3]
        # From the source with t = 1 at the pixel; parallel rays pass the pixel.
        origins, directions = (places, first) if scan.is_parallel else (first, places - first)
        return zero_negligible(origins), zero_negligible(directions)

    def _work(self, begin: int, origins: FloatArray, directions: FloatArray, bad: Signs) -> Any:
        scan = self.geometry
        # The kernel counts rows and columns in 31 bits
        if scan.radius != 0 or max(scan.rows, scan.columns) >= 2**31:
            return super()._work(begin, origins, directions, bad)
        before = np.ascontiguousarray(scan.vectors), begin, scan.rows, scan.columns, scan.is_parallel
        return KernelRange(scan_lines, before, (origins, directions, bad))

    def _share(self, begin: int, end: int) -> tuple[LazyRays, int, int]:
        """Return the rays of the views that hold the flat rays `begin` to `end`, and their place among these."""
        each = math.prod(self.shape[1:])
        # A worker needs only the views of its rays.
        first, last = begin // each, -(-end // each)
        return ScanRays(self.geometry[first:last]), begin - first * each, end - first * each


# Constructors of scans around the z axis
#
# Angles are in degrees. At angle θ the source is at source_origin · (sin θ, -cos θ, 0) and the centre of the detector
# across from it, its columns along (cos θ, sin θ, 0) and its rows along z. Parallel rays go along (sin θ, -cos θ, 0),
# and their detector is centred on the axis. (ASTRA takes radians, and has sinograms as (rows, views, columns):
# np.swapaxes(s, 0, 1).)


def parallel(angles: npt.ArrayLike, columns: int, *, spacing: float = 1.0, offset: float = 0.0) -> ScanGeometry:
    """Make a scan of parallel rays in the plane z = 0, ASTRA's `parallel`.

    Parameters
    ----------
    angles : array_like (views,)
        In degrees.
    columns : int
        Pixels.
    spacing : float
        Distance of pixels.
    offset : float
        Shift of the detector along its row.

    Returns
    -------
    ScanGeometry
        With sinograms (views, columns).
    """
    step, shift = check_positive("parallel", "spacing", spacing), check_number("parallel", "offset", offset)
    turns = _turns("parallel", angles)
    return ScanGeometry(_vectors(turns, 1.0, 0.0, (step, 1.0), (shift, 0.0), True), 1, columns, True, is_plane=True)


def parallel3d(
    angles: npt.ArrayLike,
    rows: int,
    columns: int,
    *,
    spacing: float | tuple[float, float] = (1.0, 1.0),
    offset: tuple[float, float] = (0.0, 0.0),
) -> ScanGeometry:
    """Make a scan of parallel rays on a detector of rows and columns, ASTRA's `parallel3d`.

    Parameters
    ----------
    angles : array_like (views,)
        In degrees.
    rows, columns : int
        Pixels.
    spacing : float or (float, float)
        Distances of pixels along a row and between rows, or one number for both.
    offset : (float, float)
        Shift of the detector along a row and along a column.

    Returns
    -------
    ScanGeometry
        With sinograms (views, rows, columns).
    """
    steps, shifts = _pair("parallel3d", "spacing", spacing), _pair("parallel3d", "offset", offset, False)
    return ScanGeometry(_vectors(_turns("parallel3d", angles), 1.0, 0.0, steps, shifts, True), rows, columns, True)


def fanflat(
    angles: npt.ArrayLike, columns: int, source_origin: float, origin_detector: float, *,
    spacing: float = 1.0, offset: float = 0.0, radius: float = 0.0,
) -> ScanGeometry:  # fmt: skip
    """Make a scan of fans of rays in the plane z = 0, ASTRA's `fanflat`.

    Parameters
    ----------
    angles : array_like (views,)
        In degrees.
    columns : int
        Pixels.
    source_origin, origin_detector : float
        Distances of source and detector from the axis.
    spacing, offset : float
        As for `parallel`.
    radius : float
        Radius of a curved detector; 0 is a flat one. source_origin + origin_detector is one about the source, whose
        rays are at equal angles.

    Returns
    -------
    ScanGeometry
        With sinograms (views, columns).
    """
    step, shift = check_positive("fanflat", "spacing", spacing), check_number("fanflat", "offset", offset)
    far, near = _distances("fanflat", source_origin, origin_detector)
    vectors = _vectors(_turns("fanflat", angles), far, near, (step, 1.0), (shift, 0.0), False)
    return ScanGeometry(vectors, 1, columns, False, True, radius, shift)


def cone(
    angles: npt.ArrayLike, rows: int, columns: int, source_origin: float, origin_detector: float, *,
    spacing: float | tuple[float, float] = (1.0, 1.0), offset: tuple[float, float] = (0.0, 0.0), radius: float = 0.0,
) -> ScanGeometry:  # fmt: skip
    """Make a scan of cones of rays from a source that moves in a circle, ASTRA's `cone`.

    Parameters
    ----------
    angles, rows, columns, spacing, offset
        As for `parallel3d`.
    source_origin, origin_detector, radius
        As for `fanflat`; a curved detector is straight along z.

    Returns
    -------
    ScanGeometry
        With sinograms (views, rows, columns).
    """
    return _turning("cone", angles, (rows, columns), (source_origin, origin_detector), 0.0, (spacing, offset), radius)


def helical(
    angles: npt.ArrayLike, rows: int, columns: int, source_origin: float, origin_detector: float, pitch: float, *,
    spacing: float | tuple[float, float] = (1.0, 1.0), offset: tuple[float, float] = (0.0, 0.0), radius: float = 0.0,
) -> ScanGeometry:  # fmt: skip
    """Make a `cone` whose source and detector move along z.

    Parameters
    ----------
    angles : array_like (views,)
        In degrees, over any number of turns, also negative ones.
    rows, columns, source_origin, origin_detector, spacing, offset, radius
        As for `cone`.
    pitch : float
        Rise in a turn: at angle θ source and detector are at z = pitch θ / 360.

    Returns
    -------
    ScanGeometry
        With sinograms (views, rows, columns).
    """
    distances = source_origin, origin_detector
    return _turning("helical", angles, (rows, columns), distances, pitch, (spacing, offset), radius)


def _turning(
    owner: str, angles: Any, pixels: tuple[int, int], distances: tuple[Any, Any], pitch: Any, steps_and_shifts: Any,
    radius: float,
) -> ScanGeometry:  # fmt: skip
    """Make a cone whose source rises by a pitch in a turn, 0 for a circle; `owner` is the name in messages."""
    steps, shifts = _pair(owner, "spacing", steps_and_shifts[0]), _pair(owner, "offset", steps_and_shifts[1], False)
    far, near = _distances(owner, *distances)
    turns = _turns(owner, angles)
    vectors = _vectors(turns, far, near, steps, shifts, False)
    heights = check_number(owner, "pitch", pitch) * (np.asarray(angles, float).ravel() / 360)
    # Source and centre of the detector rise together.
    vectors[:, 2] += heights
    vectors[:, 5] += heights
    return ScanGeometry(vectors, *pixels, False, False, radius, shifts[0])


def _vectors(
    turns: FloatArray, far: float, near: float, steps: tuple[float, ...], shifts: tuple[float, ...], is_parallel: bool
) -> FloatArray:
    """Return the twelve numbers of each view, from the sines and cosines of their angles (views, 2)."""
    s, c = turns.T
    zero, one = np.zeros_like(s), np.ones_like(s)
    source, along = np.stack([s, -c, zero], axis=1), np.stack([c, s, zero], axis=1)
    up = np.stack([zero, zero, one], axis=1)
    center = shifts[0] * along + shifts[1] * up - (0.0 if is_parallel else near) * source
    return np.concatenate([source if is_parallel else far * source, center, steps[0] * along, steps[1] * up], axis=1)


def _turns(owner: str, angles: Any) -> FloatArray:
    """Return (sin, cos) of angles in degrees, each rounded once."""
    degrees = real_array(owner, "angles", angles, "numbers (views,)")
    if degrees.ndim != 1:
        raise ValueError(f"{owner}: angles must be finite numbers of shape (views,), got shape {degrees.shape}")
    if not np.isfinite(degrees).all():
        raise ValueError(
            f"{owner}: angles must be finite numbers of shape (views,), got {degrees[~np.isfinite(degrees)][0]}"
        )
    warn_of_radians(owner, "angles", angles)
    # Fractions of degrees, so that sine and cosine are rounded once and exact at multiples of 90.
    return np.array([sin_cos_degrees(Fraction(angle)) for angle in degrees.tolist()]).reshape(-1, 2)


def _pair(owner: str, field: str, value: Any, is_positive: bool = True) -> tuple[float, ...]:
    """Return two numbers; one positive number stands for both."""
    if is_positive and np.ndim(value) == 0 and not isinstance(value, str):
        value = (value, value)  # square pixels
    pair = check_numbers(owner, field, value, 2)
    return tuple(check_positive(owner, field, x) for x in pair) if is_positive else pair


def _distances(owner: str, source_origin: Any, origin_detector: Any) -> tuple[float, float]:
    """Return the distances of source and detector from the axis, checked."""
    far, near = (
        check_positive(owner, "source_origin", source_origin),
        check_number(owner, "origin_detector", origin_detector),
    )
    if far + near <= 0:
        raise ValueError(
            f"{owner}: origin_detector must be > -source_origin, got {near}: the detector is behind the source"
        )
    return far, near


# Scans in the form of other software: ASTRA's dictionaries, and RTK's nine parameters for each view.


def from_astra(projection_geometry: Mapping[str, Any]) -> ScanGeometry:
    """Make a scan from a `proj_geom` of ASTRA: parallel, fanflat, parallel3d, cone, and each with _vec.

    Its angles are in radians, as in ASTRA. Views come first in our sinograms: (views, rows, columns).

    Parameters
    ----------
    projection_geometry : Mapping
        The dictionary of ASTRA.

    Returns
    -------
    ScanGeometry

    Raises
    ------
    ValueError
        For other types, and for dictionaries that lack an entry.
    """
    if not isinstance(projection_geometry, Mapping):
        raise TypeError(
            f"from_astra: projection_geometry must be a dictionary, got {describe_kind(projection_geometry)}"
        )
    entries = dict(projection_geometry)
    kind = entries.get("type")
    if kind not in _KINDS:
        raise ValueError(f"from_astra: type must be one of {', '.join(_KINDS)}, got {format_value(kind)}")
    is_parallel, is_plane, is_vec = (
        "parallel" in kind,
        kind.partition("_")[0] in ("parallel", "fanflat"),
        "_vec" in kind,
    )
    lacking = [name for name in _KINDS[kind] if name not in entries]
    if lacking:
        raise ValueError(f"from_astra: {kind} must have {format_list(lacking)}")
    rows, columns = (
        (1, entries["DetectorCount"]) if is_plane else (entries["DetectorRowCount"], entries["DetectorColCount"])
    )
    if is_vec:
        vectors = real_array("from_astra", "Vectors", entries["Vectors"])
        return ScanGeometry(_in_space(vectors) if is_plane else vectors, rows, columns, is_parallel, is_plane)
    angles = real_array("from_astra", "ProjectionAngles", entries["ProjectionAngles"])
    # ASTRA's angles are in radians: large ones are most likely degrees.
    warn_of_degrees("from_astra", "ProjectionAngles", angles)
    turns = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    distances = (
        (entries["DetectorWidth"], 1.0) if is_plane else (entries["DetectorSpacingX"], entries["DetectorSpacingY"])
    )
    far, near = (1.0, 0.0) if is_parallel else (entries["DistanceOriginSource"], entries["DistanceOriginDetector"])
    steps = check_numbers("from_astra", "spacing", distances, 2)
    far, near = (
        check_number("from_astra", "DistanceOriginSource", far),
        check_number("from_astra", "DistanceOriginDetector", near),
    )
    return ScanGeometry(
        _vectors(turns, far, near, steps, (0.0, 0.0), is_parallel), rows, columns, is_parallel, is_plane
    )


_FLAT = ("DetectorCount", "DetectorWidth", "ProjectionAngles")
_DEEP = ("DetectorRowCount", "DetectorColCount", "DetectorSpacingX", "DetectorSpacingY", "ProjectionAngles")
_FAR = ("DistanceOriginSource", "DistanceOriginDetector")
_KINDS = {
    "parallel": _FLAT, "fanflat": _FLAT + _FAR, "parallel3d": _DEEP, "cone": _DEEP + _FAR,
    "parallel_vec": ("DetectorCount", "Vectors"), "fanflat_vec": ("DetectorCount", "Vectors"),
    "parallel3d_vec": ("DetectorRowCount", "DetectorColCount", "Vectors"),
    "cone_vec": ("DetectorRowCount", "DetectorColCount", "Vectors"),
}  # fmt: skip
"""ASTRA's types, and the entries that each must have."""


def _in_space(vectors: FloatArray) -> FloatArray:
    """Return the twelve numbers of views in a plane from their six: source or direction, centre, u."""
    if vectors.ndim != 2 or vectors.shape[1] != 6:
        raise ValueError(f"from_astra: Vectors of a plane scan must be of shape (views, 6), got {vectors.shape}")
    views = np.zeros((len(vectors), 12))
    for k in range(3):
        views[:, 3 * k : 3 * k + 2] = vectors[:, 2 * k : 2 * k + 2]
    # v is the z axis, as the detector has one row.
    views[:, 11] = 1.0
    return views


def rtk(
    gantry_angle: npt.ArrayLike, rows: int, columns: int, source_to_isocenter: npt.ArrayLike,
    source_to_detector: npt.ArrayLike, *, spacing: npt.ArrayLike = (1.0, 1.0),
    projection_offset: npt.ArrayLike = (0.0, 0.0), out_of_plane_angle: npt.ArrayLike = 0.0,
    in_plane_angle: npt.ArrayLike = 0.0, source_offset: npt.ArrayLike = (0.0, 0.0), radius: float = 0.0,
) -> ScanGeometry:  # fmt: skip
    """Make a scan from the parameters of RTK's `ThreeDCircularProjectionGeometry`, one number or one for each view.

    The axis is y, angles are in degrees, and the rotated axes are the rows of
    R = Rz(-in_plane_angle) Rx(-out_of_plane_angle) Ry(-gantry_angle).

    Parameters
    ----------
    gantry_angle : array_like (views,)
        Angle about y.
    rows, columns, spacing
        Of the projections, whose middle is RTK's origin (0, 0): columns along the rotated x axis and rows along the
        rotated y axis.
    source_to_isocenter, source_offset
        The source is at (offset x, offset y, source_to_isocenter) in rotated axes.
    source_to_detector, projection_offset
        The origin of the projection is at (offset x, offset y, source_to_isocenter - source_to_detector). A distance of
        0 stands for parallel rays, and a detector as far as the source.
    out_of_plane_angle, in_plane_angle
        Angles about x and z, as in R.
    radius : float
        RTK's RadiusCylindricalDetector, 0 for a flat one. The cylinder touches the flat detector at its place without
        `projection_offset`.

    Returns
    -------
    ScanGeometry

    Raises
    ------
    ValueError
        If numbers do not fit the views.
    """
    angles = real_array("rtk", "gantry_angle", gantry_angle, "numbers (views,)")
    if angles.ndim != 1:
        raise ValueError(f"rtk: gantry_angle must be numbers of shape (views,), got shape {angles.shape}")
    for name, value in (
        ("gantry_angle", gantry_angle), ("out_of_plane_angle", out_of_plane_angle), ("in_plane_angle", in_plane_angle),
    ):  # fmt: skip
        warn_of_radians("rtk", name, value)
    sid, sdd, out, inside = (
        _each(name, value, len(angles))
        for name, value in (
            ("source_to_isocenter", source_to_isocenter), ("source_to_detector", source_to_detector),
            ("out_of_plane_angle", out_of_plane_angle), ("in_plane_angle", in_plane_angle),
        )
    )  # fmt: skip
    shift, start = (
        _each(name, value, len(angles), 2)
        for name, value in (("projection_offset", projection_offset), ("source_offset", source_offset))
    )
    is_parallel = bool(len(sdd)) and not sdd.any()
    if not is_parallel and not (sdd > 0).all():
        raise ValueError("rtk: source_to_detector must be > 0, or 0 for all views, which are parallel then")
    steps = check_numbers("rtk", "spacing", spacing, 2)
    # RTK's 0 stands for parallel rays: the detector is as far behind the axis as the source before it.
    depth = -sid if is_parallel else sid - sdd
    views = []
    for k, angle in enumerate(angles.tolist()):
        axes = _turn(inside[k], 2) @ _turn(out[k], 0) @ _turn(angle, 1)
        source = -axes[2] if is_parallel else np.array([*start[k], sid[k]]) @ axes
        center = np.array([*shift[k], depth[k]]) @ axes
        views.append(np.concatenate([source, center, steps[0] * axes[0], steps[1] * axes[1]]))
    return ScanGeometry(np.reshape(views, (-1, 12)), rows, columns, is_parallel, False, radius, shift[:, 0])


def _each(field: str, value: Any, views: int, *trailing: int) -> FloatArray:
    """Return a value for each view."""
    array = real_array("rtk", field, value)
    try:
        return np.broadcast_to(array, (views, *trailing))
    except ValueError:
        expected = f"{trailing[0]} numbers" if trailing else "a number"
        raise ValueError(f"rtk: {field} must be {expected}, or for each of {views} views, got {array.shape}") from None


def _turn(degrees: float, axis: int) -> FloatArray:
    """Return the rotation of the world by minus an angle about an axis, as RTK composes it."""
    s, c = sin_cos_degrees(Fraction(float(degrees)))
    matrix, (i, j) = np.eye(3), ((1, 2), (2, 0), (0, 1))[axis]
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = s, -s
    return matrix
