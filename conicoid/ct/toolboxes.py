"""Scans that are given as other software gives them: ASTRA's dictionaries, and RTK's nine parameters a view."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from ..shapes.arrays import real_array
from ..shapes.calls import explained
from ..shapes.degrees import warn_of_degrees, warn_of_radians
from ..shapes.rounded import sin_cos_degrees
from ..shapes.validate import listed, number, numbers, shown, what
from ..shapes.vector import FloatArray
from .circular import _vectors
from .geometry import Geometry


@explained
def from_astra(projection_geometry: Mapping[str, Any]) -> Geometry:
    """The scan of a `proj_geom` of ASTRA: parallel, fanflat, parallel3d, cone, and each with _vec.

    Its angles are in radians, as ASTRA has them. Views come first in our sinograms: (views, rows, columns).
    Raises ValueError for other types, and for dictionaries that lack an entry.
    """
    if not isinstance(projection_geometry, Mapping):
        raise TypeError(f"from_astra: projection_geometry must be a dictionary, got {what(projection_geometry)}")
    given = dict(projection_geometry)
    kind = given.get("type")
    if kind not in _KINDS:
        raise ValueError(f"from_astra: type must be one of {', '.join(_KINDS)}, got {shown(kind)}")
    is_parallel, is_plane, is_vec = (
        "parallel" in kind,
        kind.partition("_")[0] in ("parallel", "fanflat"),
        "_vec" in kind,
    )
    lacking = [name for name in _KINDS[kind] if name not in given]
    if lacking:
        raise ValueError(f"from_astra: {kind} must have {listed(lacking)}")
    rows, columns = (1, given["DetectorCount"]) if is_plane else (given["DetectorRowCount"], given["DetectorColCount"])
    if is_vec:
        vectors = real_array("from_astra", "Vectors", given["Vectors"])
        return Geometry(_in_space(vectors) if is_plane else vectors, rows, columns, is_parallel, is_plane)
    angles = real_array("from_astra", "ProjectionAngles", given["ProjectionAngles"])
    warn_of_degrees("from_astra", "ProjectionAngles", angles)
    turns = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    distances = (given["DetectorWidth"], 1.0) if is_plane else (given["DetectorSpacingX"], given["DetectorSpacingY"])
    far, near = (1.0, 0.0) if is_parallel else (given["DistanceOriginSource"], given["DistanceOriginDetector"])
    steps = numbers("from_astra", "spacing", distances, 2)
    far, near = number("from_astra", "DistanceOriginSource", far), number("from_astra", "DistanceOriginDetector", near)
    return Geometry(_vectors(turns, far, near, steps, (0.0, 0.0), is_parallel), rows, columns, is_parallel, is_plane)


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
    """The twelve numbers of views in a plane, which are six: source or direction, centre, u."""
    if vectors.ndim != 2 or vectors.shape[1] != 6:
        raise ValueError(f"from_astra: Vectors of a plane scan must be of shape (views, 6), got {vectors.shape}")
    found = np.zeros((len(vectors), 12))
    for k in range(3):
        found[:, 3 * k : 3 * k + 2] = vectors[:, 2 * k : 2 * k + 2]
    found[:, 11] = 1.0
    return found


@explained
def rtk(
    gantry_angle: Any, rows: int, columns: int, source_to_isocenter: Any, source_to_detector: Any, *,
    spacing: Any = (1.0, 1.0), projection_offset: Any = (0.0, 0.0), out_of_plane_angle: Any = 0.0,
    in_plane_angle: Any = 0.0, source_offset: Any = (0.0, 0.0), radius: float = 0.0,
) -> Geometry:  # fmt: skip
    """A scan by the parameters of RTK's `ThreeDCircularProjectionGeometry`, one number or one for each view.

    The axis is y, angles are in degrees, and the rotated axes are the rows of
    R = Rz(-in_plane_angle) Rx(-out_of_plane_angle) Ry(-gantry_angle).

    gantry_angle: (views,). rows, columns, spacing: of the projections, whose middle is RTK's origin (0, 0) of them,
        columns along the rotated x axis and rows along the rotated y axis.
    source_to_isocenter, source_offset: the source is at (offset x, offset y, source_to_isocenter) in rotated axes.
    source_to_detector, projection_offset: the origin of the projection is at (offset x, offset y,
        source_to_isocenter - source_to_detector); 0 stands for parallel rays, and a detector as far as the source.
    radius: RTK's RadiusCylindricalDetector, 0 for a flat one. The cylinder touches the flat detector where it would
        be without `projection_offset`.

    Raises ValueError for numbers that do not fit the views.
    """
    angles = real_array("rtk", "gantry_angle", gantry_angle, "numbers (views,)")
    if angles.ndim != 1:
        raise ValueError(f"rtk: gantry_angle must be numbers of shape (views,), got shape {angles.shape}")
    for name, turned in (
        ("gantry_angle", gantry_angle), ("out_of_plane_angle", out_of_plane_angle), ("in_plane_angle", in_plane_angle),
    ):  # fmt: skip
        warn_of_radians("rtk", name, turned)
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
    steps = numbers("rtk", "spacing", spacing, 2)
    depth = -sid if is_parallel else sid - sdd
    views = []
    for k, angle in enumerate(angles.tolist()):
        axes = _turn(inside[k], 2) @ _turn(out[k], 0) @ _turn(angle, 1)
        source = -axes[2] if is_parallel else np.array([*start[k], sid[k]]) @ axes
        center = np.array([*shift[k], depth[k]]) @ axes
        views.append(np.concatenate([source, center, steps[0] * axes[0], steps[1] * axes[1]]))
    return Geometry(np.reshape(views, (-1, 12)), rows, columns, is_parallel, False, radius, shift[:, 0])


def _each(field: str, value: Any, views: int, *last: int) -> FloatArray:
    """A value for each view."""
    given = real_array("rtk", field, value)
    try:
        return np.broadcast_to(given, (views, *last))
    except ValueError:
        expected = f"{last[0]} numbers" if last else "a number"
        raise ValueError(f"rtk: {field} must be {expected}, or for each of {views} views, got {given.shape}") from None


def _turn(degrees: float, axis: int) -> FloatArray:
    """The rotation of the world by minus an angle about an axis, as RTK composes it."""
    s, c = sin_cos_degrees(Fraction(float(degrees)))
    matrix, (i, j) = np.eye(3), ((1, 2), (2, 0), (0, 1))[axis]
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = s, -s
    return matrix
