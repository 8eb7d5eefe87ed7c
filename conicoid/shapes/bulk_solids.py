"""Many solids of one kind in one entry of a scene: cylinders, capsules, cones, ellipsoids and boxes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .base import Solid
from .box import Box
from .bulk import Bulk, reach_of_balls, reach_of_discs
from .cone import Cone
from .cylinder import Cylinder
from .ellipsoid import Ellipsoid
from .region import Union
from .row_vectors import product
from .sphere import Sphere
from .vector import FloatArray

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
        return _reach_of_frustums(self.starts, self.ends, self.radii, self.radii, rows)


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

    def check_rows(self) -> None:
        self.refuse("radii", self.radii <= 0, "> 0")
        self.refuse("ends", (self.starts == self.ends).all(axis=1), "another point than its start")

    def single(self, index: int) -> Union:
        start, end, radius = (self.row(index, name) for name in self.columns)
        return Union((Cylinder(start, end, radius), Sphere(radius, start), Sphere(radius, end)), motion=self.motion)

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        return reach_of_balls((self.starts, self.ends), (self.radii, self.radii), rows)


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
        return _reach_of_frustums(self.starts, self.ends, self.start_radii, self.end_radii, rows)


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
        at, reach = product(self.centers, rows.T), np.sqrt(product(self.radii**2, rows.T**2))
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
        at, half = product((self.lows + self.highs) / 2, rows.T), product((self.highs - self.lows) / 2, np.abs(rows.T))
        return half - at, half + at


def _reach_of_frustums(
    starts: FloatArray, ends: FloatArray, first: FloatArray, last: FloatArray, rows: FloatArray
) -> tuple[FloatArray, FloatArray]:
    return reach_of_discs((starts, ends), ends - starts, (first, last), rows)
