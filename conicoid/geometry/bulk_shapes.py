"""Many shapes of one kind in one entry of a scene.

Solids: cylinders, capsules, cones, ellipsoids and boxes. Sheets: discs and triangles.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray, matmul_rows
from .._util.dataclass import dataclass
from .._util.validation import real_array
from .bulk import Bulk, balls_reach, discs_reach, points_reach
from .primitives import Box, Cone, Cylinder, Sphere
from .quadrics import Ellipsoid
from .shape import Sheet, Solid, Union
from .sheets import CLEAR_AREA, Disc, Triangle

_START, _END = ("start x", "start y", "start z"), ("end x", "end y", "end z")


@dataclass(frozen=True, eq=False)
class Cylinders(Bulk, Solid):
    """N closed circular cylinders from starts[i] to ends[i] as N bodies with consecutive ids.

    `starts`, `ends` (N, 3) or one point for all, `radii` (N,) or one number for all. A scene entry only: it does not
    combine with ``| & - ~``. Faces and uv as for `Cylinder` without angles.
    """

    starts: Any
    ends: Any
    radii: Any
    columns: ClassVar = {"starts": _START, "ends": _END, "radii": ("radius",)}
    leaves: ClassVar = (("starts", "ends", "radii", 0.0, 360.0),)

    def check_rows(self) -> None:
        self.refuse("radii", self.radii <= 0, "> 0")
        self.refuse("ends", (self.starts == self.ends).all(axis=1), "another point than its start")

    def single(self, index: int) -> Cylinder:
        start, end, radius = (self.row(index, name) for name in self.columns)
        return Cylinder(start, end, radius, motion=self.motion)

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        return _frustums_reach(self.starts, self.ends, self.radii, self.radii, rows)


@dataclass(frozen=True, eq=False)
class Capsules(Bulk, Solid):
    """N capsules, all points within radii[i] of the line from starts[i] to ends[i], as N bodies with consecutive ids.

    `starts`, `ends` (N, 3) or one point for all, `radii` (N,) or one number for all. A scene entry only: it does not
    combine with ``| & - ~``. Each is ``Cylinder(start, end, radius) | Sphere(radius, start) | Sphere(radius, end)``:
    face 0 is the side, 3 the ball at the start, 4 the one at the end, with the uv of these.
    """

    starts: Any
    ends: Any
    radii: Any
    columns: ClassVar = {"starts": _START, "ends": _END, "radii": ("radius",)}
    leaves: ClassVar = (("starts", "ends", "radii", 0.0, 360.0), ("radii", "starts"), ("radii", "ends"))

    check_rows = Cylinders.check_rows

    def single(self, index: int) -> Union:
        start, end, radius = (self.row(index, name) for name in self.columns)
        return Union((Cylinder(start, end, radius), Sphere(radius, start), Sphere(radius, end)), motion=self.motion)

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        return balls_reach((self.starts, self.ends), (self.radii, self.radii), rows)


@dataclass(frozen=True, eq=False)
class Cones(Bulk, Solid):
    """N closed cones or frustums from starts[i] to ends[i] as N bodies with consecutive ids.

    `starts`, `ends` (N, 3) or one point for all, `start_radii`, `end_radii` (N,) or one number for all, not both 0. A
    scene entry only: it does not combine with ``| & - ~``. Faces and uv as for `Cone` without angles.
    """

    starts: Any
    ends: Any
    start_radii: Any
    end_radii: Any
    columns: ClassVar = {"starts": _START, "ends": _END, "start_radii": ("start radius",), "end_radii": ("end radius",)}
    leaves: ClassVar = (("starts", "ends", "start_radii", "end_radii", 0.0, 360.0),)

    def check_rows(self) -> None:
        self.refuse("start_radii", self.start_radii < 0, ">= 0")
        self.refuse("end_radii", self.end_radii < 0, ">= 0")
        self.refuse("end_radii", (self.start_radii == 0) & (self.end_radii == 0), "> 0 where start_radii is 0")
        self.refuse("ends", (self.starts == self.ends).all(axis=1), "another point than its start")

    def single(self, index: int) -> Cone:
        start, end, first, last = (self.row(index, name) for name in self.columns)
        return Cone(start, end, first, last, motion=self.motion)

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        return _frustums_reach(self.starts, self.ends, self.start_radii, self.end_radii, rows)


@dataclass(frozen=True, eq=False)
class Ellipsoids(Bulk, Solid):
    """N ellipsoids about centers[i] with half-axes radii[i] along x, y and z, as N bodies with consecutive ids.

    `centers`, `radii` (N, 3) or three numbers for all. A scene entry only: it does not combine with ``| & - ~``. Faces
    and uv as for `Ellipsoid`.
    """

    centers: Any
    radii: Any
    columns: ClassVar = {"centers": ("x", "y", "z"), "radii": ("radius x", "radius y", "radius z")}
    leaves: ClassVar = (("radii", "centers"),)

    def check_rows(self) -> None:
        self.refuse("radii", (self.radii <= 0).any(axis=1), "> 0")

    def single(self, index: int) -> Ellipsoid:
        return Ellipsoid(self.row(index, "radii"), self.row(index, "centers"), motion=self.motion)

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        at, reach = matmul_rows(self.centers, rows.T), np.sqrt(matmul_rows(self.radii**2, rows.T**2))
        return reach - at, reach + at


@dataclass(frozen=True, eq=False)
class Boxes(Bulk, Solid):
    """N boxes from lows[i] to highs[i], edges along the axes, as N bodies with consecutive ids.

    `lows`, `highs` (N, 3) or one corner for all. A scene entry only: it does not combine with ``| & - ~``. Faces and uv
    as for `Box`.
    """

    lows: Any
    highs: Any
    columns: ClassVar = {"lows": ("low x", "low y", "low z"), "highs": ("high x", "high y", "high z")}
    leaves: ClassVar = (("lows", "highs"),)

    def check_rows(self) -> None:
        bad = np.flatnonzero(~(self.lows < self.highs).all(axis=1))
        if len(bad):
            low, high = self.row(int(bad[0]), "lows"), self.row(int(bad[0]), "highs")
            raise ValueError(f"Boxes: highs[{bad[0]}] must be > lows[{bad[0]}] = {low} in each component, got {high}")

    def single(self, index: int) -> Box:
        return Box(self.row(index, "lows"), self.row(index, "highs"), motion=self.motion)

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        at, half = (
            matmul_rows((self.lows + self.highs) / 2, rows.T),
            matmul_rows((self.highs - self.lows) / 2, np.abs(rows.T)),
        )
        return half - at, half + at


def _frustums_reach(
    starts: FloatArray, ends: FloatArray, first: FloatArray, last: FloatArray, rows: FloatArray
) -> tuple[FloatArray, FloatArray]:
    return discs_reach((starts, ends), ends - starts, (first, last), rows)


# Sheets


@dataclass(frozen=True, eq=False)
class Discs(Bulk, Sheet):
    """N discs about centers[i] across normals[i] as N bodies with consecutive ids.

    `centers`, `normals` (N, 3) or three numbers for all, `radii` (N,) or one number for all. A scene entry only: solids
    do not clip it. Face and uv as for `Disc`.
    """

    centers: Any
    normals: Any
    radii: Any
    columns: ClassVar = {
        "centers": ("x", "y", "z"),
        "normals": ("normal x", "normal y", "normal z"),
        "radii": ("radius",),
    }
    leaves: ClassVar = (("centers", "normals", "radii"),)

    def check_rows(self) -> None:
        self.refuse("radii", self.radii <= 0, "> 0")
        self.refuse("normals", (self.normals == 0).all(axis=1), "another vector than zero")

    def single(self, index: int) -> Disc:
        center, normal, radius = (self.row(index, name) for name in self.columns)
        return Disc(center, normal, radius, motion=self.motion)

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        return discs_reach((self.centers,), self.normals, (self.radii,), rows)


@dataclass(frozen=True, eq=False)
class Triangles(Bulk, Sheet):
    """N triangles a[i], b[i], c[i] as N bodies with consecutive ids; `Triangles.of_mesh` takes vertices and faces.

    `a`, `b`, `c` (N, 3) or one corner for all. A scene entry only: solids do not clip it. Face and uv as for
    `Triangle`.
    """

    a: Any
    b: Any
    c: Any
    columns: ClassVar = {"a": ("a x", "a y", "a z"), "b": ("b x", "b y", "b z"), "c": ("c x", "c y", "c z")}
    leaves: ClassVar = (("a", "b", "c"),)

    @classmethod
    def of_mesh(cls, vertices: npt.ArrayLike, faces: npt.ArrayLike) -> Triangles:
        """Return the triangles of a mesh.

        Parameters
        ----------
        vertices : array (V, 3)
            The points.
        faces : array (N, 3)
            Indices of the three corners of each triangle.

        Raises
        ------
        ValueError
            For arrays of another shape, and for an index that is no integer or has no point.
        """
        points = real_array("Triangles", "vertices", vertices)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ValueError(f"Triangles: vertices must have shape (V, 3), got {points.shape}")
        given = real_array("Triangles", "faces", faces)
        given = given.reshape(-1, 3) if given.size == 0 else given
        if given.ndim != 2 or given.shape[1] != 3:
            raise ValueError(f"Triangles: faces must have shape (N, 3), got {given.shape}")
        uneven = np.flatnonzero((given != np.floor(given)).any(axis=1))
        if len(uneven):
            raise ValueError(f"Triangles: faces[{uneven[0]}] must be integers, got {given[uneven[0]]}")
        corners = np.clip(given, -1, len(points)).astype(np.int64)
        bad = np.flatnonzero(((corners < 0) | (corners >= len(points))).any(axis=1))
        if len(bad):
            these = ", ".join(f"{index:g}" for index in given[bad[0]].tolist())
            raise ValueError(f"Triangles: faces[{bad[0]}] must be at least 0 and below {len(points)}, got ({these})")
        return cls(*(points[corners[:, k]] for k in range(3)))

    def check_rows(self) -> None:
        x, y = (self.b - self.a).T, (self.c - self.a).T
        clear = np.zeros(len(self), bool)
        for i, j in ((1, 2), (2, 0), (0, 1)):
            one, other = x[i] * y[j], x[j] * y[i]
            clear |= np.abs(one - other) > CLEAR_AREA * (np.abs(one) + np.abs(other))
        # Floats leave these open: the single triangle decides exactly
        for index in np.flatnonzero(~clear).tolist():
            try:
                self.single(index)
            except ValueError:
                corners = ", ".join(str(self.row(index, name)) for name in self.columns)
                corner = f"a[{index}], b[{index}], c[{index}]"
                raise ValueError(f"Triangles: {corner} must not lie on a line, got {corners}") from None

    def single(self, index: int) -> Triangle:
        a, b, c = (self.row(index, name) for name in self.columns)
        return Triangle(a, b, c, motion=self.motion)

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        return points_reach((self.a, self.b, self.c), rows)
