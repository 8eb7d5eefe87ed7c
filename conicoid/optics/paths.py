"""The answer to `trace_paths`: segments of light as flat arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..engine.answers.no_names import numbered
from ..shapes.calm import calm
from ..shapes.fixed import fixed
from ..shapes.labels import counted
from ..shapes.other_names import hinted
from ..shapes.validate import integer, positive

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


@fixed
@dataclass(frozen=True)
class Balance:
    """Where the light of some rays went, as sums of weights: `given` is the sum of the others.

    escaped: to infinity; in_media: absorbed on the way through media; at_walls: absorbed by surfaces and coats;
    not_followed: what arrived at the last walls, and what was too weak.
    """

    given: float
    escaped: float
    in_media: float
    at_walls: float
    not_followed: float


@hinted
@fixed
@dataclass(frozen=True, eq=False, repr=False)
class Paths:
    """Segments of light, from wall to wall, level by level: those of the rays first. Row k of each array is segment k.

    start, end   float64 (n, 3): the points between which it goes; NaN is the end of one that escapes
    direction    float64 (n, 3): unit
    length       float64: inf of one that escapes
    body         int32: the transparent body that it goes through, -1 for none; of several that are the same to light,
                 between which there is no wall, the last
    index        float64: the refractive index there, at its wavelength
    optical_path float64: index · length
    weight       float64: the light at its start, as a share of its ray's, or times the weight that was given
    arriving     float64: what is left of that at its end
    deposited    float64: what the wall at its end keeps of it
    lost         float64: what was not followed any further
    parent       int64: the segment that it comes from, -1 of those of the rays
    ray          int64: the flat index of its ray
    level        int64: how many walls it has met before
    wavelength   float64: in μm, in vacuum
    wall         int32: the body whose wall it ends on, -1 for one that escapes
    surface      int32: the surface that it ends on, -1 likewise
    mirrored     bool: it began by reflection
    """

    start: FloatArray
    end: FloatArray
    direction: FloatArray
    length: FloatArray
    body: npt.NDArray[np.int32]
    index: FloatArray
    weight: FloatArray
    arriving: FloatArray
    deposited: FloatArray
    lost: FloatArray
    parent: IntArray
    ray: IntArray
    level: IntArray
    wavelength: FloatArray
    wall: npt.NDArray[np.int32]
    surface: npt.NDArray[np.int32]
    mirrored: npt.NDArray[np.bool_]

    def __post_init__(self) -> None:
        for array in vars(self).values():
            array.flags.writeable = False
        vars(self).update(numbered(vars(self)))

    @property
    def optical_path(self) -> FloatArray:
        return self.index * self.length

    @property
    def escaped(self) -> npt.NDArray[np.bool_]:
        """bool (n,): those that meet no wall any more."""
        return self.wall < 0

    @property
    def optical_path_from_start(self) -> FloatArray:
        """float64 (n,): the sum of index · length from the ray's origin to the end of each segment."""
        total = self.optical_path
        for level in range(1, int(self.level.max(initial=0)) + 1):
            rows = np.flatnonzero(self.level == level)
            total[rows] += total[self.parent[rows]]
        return total

    def balance(self) -> Balance:
        """Where the light went: what escaped, was absorbed and was not followed, which together are what was given."""
        escaped = self.escaped
        return Balance(
            float(self.weight[self.level == 0].sum()),
            float(self.arriving[escaped].sum()),
            float((self.weight - self.arriving).sum()),
            float(self.deposited.sum()),
            float(self.lost.sum()),
        )

    def chain(self, segment: int) -> IntArray:
        """int64: the segments from a ray's first one to the given one, along its parents.

        segment: its row.
        """
        at = integer("Paths", "segment", segment, 0, len(self) - 1)
        found = [at]
        while self.parent[at] >= 0:
            at = int(self.parent[at])
            found.append(at)
        return np.array(found[::-1], np.int64)

    @calm
    def lines(self, beyond: float = 1.0) -> FloatArray:
        """float64 (n, 2, 3): both ends of each segment, to be drawn.

        beyond: how far one that escapes is to be drawn.
        """
        far = positive("Paths", "beyond", beyond)
        ends = np.where(self.escaped[:, None], self.start + far * self.direction, self.end)
        return np.stack([self.start, ends], axis=1)

    def __len__(self) -> int:
        return len(self.length)

    def __repr__(self) -> str:
        rays = counted(int((self.level == 0).sum()), "ray", "rays")
        return f"Paths({counted(len(self), 'segment', 'segments')} of {rays})"
