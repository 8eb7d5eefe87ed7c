"""Many sheets of one kind in one entry of a scene: discs and triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .arrays import real_array
from .base import Sheet
from .bulk import Bulk, reach_of_discs, reach_of_points
from .disc import Disc
from .triangle import CLEAR, Triangle
from .vector import FloatArray


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
        return reach_of_discs((self.centers,), self.normals, (self.radii,), rows)


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
    def of_mesh(cls, vertices: Any, faces: Any) -> Triangles:
        """The triangles of a mesh.

        vertices: (V, 3) points. faces: (N, 3) indices of the corners of each triangle.
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
            clear |= np.abs(one - other) > CLEAR * (np.abs(one) + np.abs(other))
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
        return reach_of_points((self.a, self.b, self.c), rows)
