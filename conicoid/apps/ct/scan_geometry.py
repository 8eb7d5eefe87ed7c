"""Scans as data: for each view a source or a direction, and the places of the detector's pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.equality import compare_by_value
from ..._util.errstate import ignore_fp_errors
from ..._util.validation import check_flag, check_integer, check_nonnegative, real_array, zero_negligible
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

    def _share(self, begin: int, end: int) -> tuple[LazyRays, int, int]:
        """Return the rays of the views that hold the flat rays `begin` to `end`, and their place among these."""
        each = math.prod(self.shape[1:])
        # A worker needs only the views of its rays.
        first, last = begin // each, -(-end // each)
        return ScanRays(self.geometry[first:last]), begin - first * each, end - first * each
