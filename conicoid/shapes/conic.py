"""The conic of optics, by radius of curvature and conic constant: a solid cap, and an open sheet."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .base import PrimitiveSheet, PrimitiveSolid
from .cells import All, Cell, Face, Not, SurfaceSheet, Tree, flat, moved_uv
from .conic_wall import ConicWall, check_reach, plane, radius_of, tube
from .motion import Motion
from .validate import nonnegative, number, positive
from .vector import Vector


@dataclass(frozen=True)
class Conic(PrimitiveSolid):
    """x² + y² + (1 + k) z² <= 2 R z between the vertex, z = 0, and the plane of the rim: a solid cap.

    R is `radius_of_curvature`, over 0 where the centre lies at z > 0; k is `conic_constant`: below -1 a hyperboloid,
    -1 a paraboloid, above -1 an ellipsoid (long along z below 0, a sphere at 0, flat above). `aperture` is the diameter
    of the rim, which lies at z = c r² / (1 + sqrt(1 - (1 + k) c² r²)) with c = 1 / R, r = aperture / 2. An aperture
    beyond the ellipsoid's equator is refused. `sheet()` is the curved part alone.
    Faces: 0 the conic, 1 the flat end at the rim. uv: (angle / 360, height from vertex to rim in [0, 1]) on the conic,
    (x, y) / r on the flat end.
    """

    radius_of_curvature: float
    conic_constant: float = 0.0
    aperture: float = 1.0

    def __post_init__(self) -> None:
        check_conic(self)
        if math.isinf(self.radius_of_curvature):
            raise ValueError("Conic: radius_of_curvature must be finite: flat, it holds nothing (a ConicSheet may be)")

    def sheet(self) -> ConicSheet:
        """The conic as an open surface, without the flat end."""
        return ConicSheet(self.radius_of_curvature, self.conic_constant, self.aperture, motion=self.motion)

    @property
    def wall(self) -> ConicWall:
        """The conic in its own frame."""
        return wall_of(self)

    def tree(self) -> Cell:
        wall, r = self.wall, self.aperture / 2
        conic, *cut = wall.bowl().faces
        sense = 1 if self.radius_of_curvature > 0 else -1
        end = Face(plane(sense, wall.rim), 1, flat((r, 0, 0), (0, r, 0)))
        return Cell((conic, end, *cut))

    def support(self, direction: Vector) -> float:
        return self.wall.support(direction, hollow=True)


@dataclass(frozen=True)
class ConicSheet(PrimitiveSheet):
    """z = c r² / (1 + sqrt(1 - (1 + k) c² r²)), hole / 2 <= r <= aperture / 2: a thin mirror or an ideal surface.

    c is 1 / `radius_of_curvature`, 0 for an infinite one: a flat ring; k is `conic_constant`, `aperture` the diameter
    of the rim and `hole` that of a round hole about the vertex. The normal points to the side of negative z, whence
    light comes. Parts of it, off the axis or not round: ``sheet & solid``, ``sheet - solid``.
    Face 0. uv: (angle / 360, height from vertex to rim in [0, 1]); on a flat one (x, y) / (aperture / 2).
    """

    radius_of_curvature: float
    conic_constant: float = 0.0
    aperture: float = 1.0
    hole: float = 0.0

    def __post_init__(self) -> None:
        check_conic(self)
        object.__setattr__(self, "hole", nonnegative("ConicSheet", "hole", self.hole))
        if not self.hole < self.aperture:
            raise ValueError(f"ConicSheet: hole must be below aperture = {self.aperture:g}, got {self.hole:g}")

    @property
    def wall(self) -> ConicWall:
        """The conic in its own frame."""
        return wall_of(self)

    def sheet(self, motion: Motion) -> SurfaceSheet:
        wall, side = self.wall, -1
        if wall.is_plane:
            clip = ring_between(self.hole / 2, self.aperture / 2, motion)
        else:
            sense = 1 if self.radius_of_curvature > 0 else -1
            side = sense  # the gradient at the vertex points against the centre
            planes = [plane(sense, wall.rim), *(face.surface for face in wall.bowl().faces[1:])]
            if self.hole > 0:
                planes.append(plane(-sense, wall.sag(self.hole / 2)))
            clip = Cell(tuple(Face(surface.moved(motion), 0) for surface in planes))
        return SurfaceSheet(wall.surface.moved(motion), clip, side, uv=moved_uv(wall.uv, motion))

    def support(self, direction: Vector) -> float:
        return self.wall.support(direction, hollow=True, hole=self.hole / 2)


def check_conic(shape: Conic | ConicSheet) -> None:
    """Check the three numbers of a conic."""
    owner = type(shape).__name__
    object.__setattr__(shape, "radius_of_curvature", radius_of(owner, "radius_of_curvature", shape.radius_of_curvature))
    object.__setattr__(shape, "conic_constant", number(owner, "conic_constant", shape.conic_constant))
    object.__setattr__(shape, "aperture", positive(owner, "aperture", shape.aperture))
    check_reach(
        owner, "aperture", shape.radius_of_curvature, shape.conic_constant, shape.aperture,
        "radius_of_curvature and conic_constant give",
    )  # fmt: skip


def wall_of(shape: Conic | ConicSheet) -> ConicWall:
    """The wall of a conic with its vertex at the origin."""
    r = shape.aperture / 2
    return ConicWall(shape.radius_of_curvature, shape.conic_constant, 0.0, r, r)


def ring_between(inner: float, outer: float, motion: Motion) -> Tree:
    """Within `outer` of the axis and not within `inner`."""
    around = Cell((Face(tube(outer).moved(motion), 0),))
    return All((around, Not(Cell((Face(tube(inner).moved(motion), 0),))))) if inner > 0 else around
