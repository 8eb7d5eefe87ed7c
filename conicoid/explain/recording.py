"""The numbers of the kernels for one ray, asked for once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..engine.answers.rays import Rays
from ..engine.arrays.crossing_arrays import trace_rows_alone
from ..engine.faces import cell_faces, numbers_of, plane_faces
from ..engine.prepared import Prepared
from ..engine.queries import recorded as kernels
from ..engine.queries.queries import arrays_of
from ..engine.ray import Ray, RayArrays, scaled_ray


class Recording:
    """What the kernels work out for a single ray in [t_min, t_max]."""

    def __init__(self, scene: Prepared, ray: Rays, t_min: Any, t_max: Any) -> None:
        self.scene, self.tables = scene, scene.lowered.tables
        self.arrays: RayArrays = arrays_of("explain", scene, ray, t_min, t_max)
        self.start = int(self.arrays.starts[0])
        self.t_min, self.t_max = float(self.arrays.t_min[0]), float(self.arrays.t_max[0])
        x, y, z = self.arrays.directions[0].tolist()
        whole = Ray(0.0, 0.0, 0.0, x, y, z, t_min=0.0, t_max=1.0, start=-1)
        self.scale = float(scaled_ray(whole)[1])
        """The kernels trace a direction so many times as long, a power of two: 1 for all that are usual."""

    def walk(self) -> tuple[Any, Any]:
        """(how far the ray gets with every entry, the balls around those that it reaches)."""
        count = len(self.tables.entry_kind)
        reached, balls = np.zeros(count, np.int8), np.full((count, 4), np.nan)
        kernels.record_walk(self.scene.geometry, self.arrays, 0, reached, balls)
        return reached, balls

    def surface(self, surface: int) -> Any:
        """The row of a surface."""
        rows = np.zeros((1, kernels.SURFACE_COLUMNS))
        kernels.record_surfaces(self.scene.geometry, self.arrays, 0, np.array([surface], np.int32), rows)
        return rows[0]

    def cell(self, cell: int) -> Any:
        """The row of a cell."""
        rows = np.zeros((1, kernels.CELL_COLUMNS))
        kernels.record_cells(self.scene.geometry, self.arrays, 0, np.array([cell], np.int32), rows)
        return rows[0]

    def sweep(self, program: int) -> Any:
        """The events of a program, after a row of what there is before them."""
        return kernels.record_sweep(self.scene.geometry, self.arrays, 0, program)

    def holds(self, program: int, t: float) -> bool:
        """Is the point at t in what clips a sheet?"""
        return bool(kernels.record_clip(self.scene.geometry, self.arrays, 0, program, t))

    def loop(self, polygon: int) -> tuple[bool, Any]:
        """(does the ray pass within an outline, its corners as the ray sees them)."""
        first = self.tables.polygon_first
        seen = np.zeros((int(first[polygon + 1] - first[polygon]), kernels.SEEN_COLUMNS))
        return bool(kernels.record_loop(self.scene.geometry, self.arrays, 0, polygon, seen)), seen

    def is_doubtful(self) -> bool:
        """Do the float formulas leave anything along the ray in doubt?"""
        counts, doubts = np.zeros(1, np.int32), np.zeros(1, np.int8)
        trace_rows_alone(self.scene.geometry, self.arrays, False, 0, 1, counts, doubts)
        return bool(doubts[0])

    def face_at(self, place: int) -> tuple[int, int]:
        """(surface, face number) of a place; (-1, -1) at infinity."""
        tables = self.tables
        if place == -1:
            return -1, -1
        if place < 0:
            return int(tables.cell_quadric[-2 - place]), int(numbers_of(cell_faces(tables, -2 - place)))
        return int(tables.plane_surface[place]), int(numbers_of(plane_faces(tables, place)))

    def counts(self, t: float, surface: int) -> bool:
        """Is a crossing within the interval, and not the one that the ray starts on? As `surface/interval.py`."""
        return self.t_min < t < self.t_max and not self.is_start(t, surface)

    def is_start(self, t: float, surface: int) -> bool:
        """Is a crossing the one that the ray starts on?"""
        return t == 0.0 and surface == self.start >= 0

    def ends(self, cell: Any) -> Sequence[tuple[float, int, float, int]]:
        """The spans of a cell's row: (t_in, place, t_out, place) each."""
        at = kernels.SPANS
        found = [(cell[at], int(cell[at + 2]), cell[at + 1], int(cell[at + 3]))]
        found.append((cell[at + 4], int(cell[at + 6]), cell[at + 5], int(cell[at + 7])))
        return [(float(a), p, float(b), q) for a, p, b, q in found[: int(cell[kernels.NUMBER])]]
