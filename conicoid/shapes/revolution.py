"""The solid of revolution of a polygon: cylinders, cones and planes across the axis."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple

from . import exact as ex
from .base import PrimitiveSolid
from .cells import All, Any_, Cell, Face, Tree, around_z, flat
from .cylinder import arc_support, either, wedge_walls
from .degrees import turn
from .frustum import frustum_side
from .outline import check_simple, checked_outline
from .rounded import larger
from .support import sum_up
from .surface import PlaneSurface, QuadricSurface
from .vector import Vector

Profile = tuple[tuple[float, float], ...]


class _Edge(NamedTuple):
    """An edge of the profile from its lower end to its upper: (r, z) in fractions, and its number."""

    low: tuple[Any, Any]
    high: tuple[Any, Any]
    number: int

    def radius(self, z: Any) -> Any:
        """Its distance from the axis at a height."""
        (r, low), (end, high) = self.low, self.high
        return r + (end - r) * (z - low) / (high - low)


class _Ring(NamedTuple):
    """Between two heights, all from one edge (None for the axis) to another."""

    inner: _Edge | None
    outer: _Edge
    low: Any
    high: Any


@dataclass(frozen=True)
class Revolution(PrimitiveSolid):
    """A polygon in the half-plane of r and z, turned about the z axis: tubes, frustums and stacks of them.

    `profile` are its corners (r, z), r >= 0, in either sense; it must not cross itself, and may touch the axis. With
    angles only the part whose angle of (x, y) is from `start_angle` to `end_angle`, in degrees, their difference in
    (0, 360].
    Faces: i is what the edge from corner i to the next sweeps (nothing, on the axis), then the walls at start_angle
    and end_angle; half a turn has one plane for both. uv: (angle / 360, height from the lower end of the edge to the
    upper in [0, 1]) where it rises, (x, y) / the larger radius where it is level, (distance from the axis, z), in units
    of the largest of each, on the walls.
    Source: the polycones of detector simulation (Geant4, "Book for Application Developers", solids).
    """

    profile: tuple[tuple[float, float], ...]
    start_angle: float = 0.0
    end_angle: float = 360.0

    def __post_init__(self) -> None:
        profile = checked_outline("Revolution", "profile", self.profile)
        for k, (r, _) in enumerate(profile):
            if r < 0:
                raise ValueError(f"Revolution: profile[{k}] must have r >= 0, got ({r:g}, {profile[k][1]:g})")
        check_simple("Revolution", "profile", profile)
        object.__setattr__(self, "profile", profile)
        first, last = turn("Revolution", self.start_angle, self.end_angle)
        object.__setattr__(self, "start_angle", first)
        object.__setattr__(self, "end_angle", last)

    def tree(self) -> Tree:
        corners, ends = _corners_and_ends(self.profile)
        rising = _rising(ends)
        level = [(*sorted((a[0], b[0])), a[1], k) for k, (a, b) in enumerate(ends) if _equal(a[1], b[1])]
        walls = {edge.number: _wall(edge) for edge in rising if edge.low[0] > 0 or edge.high[0] > 0}
        parts = [_tree_of(ring, walls, level, len(corners) + 2) for ring in rings(rising)]
        whole: Tree = parts[0] if len(parts) == 1 else Any_(tuple(parts))
        ends_of_turn = self._walls(len(corners))
        if not ends_of_turn:
            return whole
        is_convex = self.end_angle - self.start_angle <= 180
        wedge: Tree = Cell(ends_of_turn) if is_convex else either(ends_of_turn)
        return All((whole, wedge))

    def _walls(self, first: int) -> tuple[Face, ...]:
        """The half-planes at the angles, as faces from a number on."""
        radius, size = (functools.reduce(larger, map(abs, numbers)) for numbers in zip(*self.profile, strict=True))
        made = wedge_walls(self.start_angle, self.end_angle, radius, size or 1.0)
        return tuple(replace(face, number=first + k) for k, face in enumerate(made))

    def support(self, direction: Vector) -> float:
        across = arc_support(1.0, self.start_angle, self.end_angle, direction)
        if self.end_angle - self.start_angle < 360:
            across += 2.0**-51 * abs(across)
        best = -float("inf")
        for r, z in self.profile:
            best = larger(best, sum_up(term for term in (r * across, z * direction[2]) if term))
        return best


def rings_of(profile: Profile) -> Iterator[tuple[float, float, tuple[float, float], tuple[float, float]]]:
    """The parts that an outline is made of: (lower z, upper z, inner radii at both, outer radii at both)."""
    for ring in rings(_rising(_corners_and_ends(profile)[1])):
        inner, outer = (
            (float(edge.radius(ring.low)), float(edge.radius(ring.high))) if edge else (0.0, 0.0)
            for edge in (ring.inner, ring.outer)
        )
        yield float(ring.low), float(ring.high), inner, outer


def _corners_and_ends(profile: Profile) -> tuple[list[Any], list[tuple[Any, Any]]]:
    """The corners in fractions, and the two of each edge."""
    corners = [(ex.rational(r), ex.rational(z)) for r, z in profile]
    return corners, list(zip(corners, [*corners[1:], corners[0]], strict=True))


def _rising(ends: Sequence[tuple[Any, Any]]) -> list[_Edge]:
    return [_Edge(min(a, b, key=_z), max(a, b, key=_z), k) for k, (a, b) in enumerate(ends) if not _equal(a[1], b[1])]


def _z(corner: Any) -> Any:
    return corner[1]


def _equal(a: Any, b: Any) -> bool:
    """By their values, whatever numbers they are: of two that are equal now and move apart `==` is false."""
    return bool(a <= b <= a)


def rings(edges: Sequence[_Edge]) -> list[_Ring]:
    """The polygon as rings between edges that rise: cut at the heights of corners, and put together again."""
    heights: list[Any] = []
    for z in sorted(end[1] for edge in edges for end in (edge.low, edge.high)):
        if not heights or heights[-1] < z:
            heights.append(z)
    open_: dict[tuple[int, int], _Ring] = {}
    found: list[_Ring] = []
    for low, high in itertools.pairwise(heights):
        middle = (low + high) / 2
        across = sorted((e for e in edges if e.low[1] <= low and high <= e.high[1]), key=lambda e: e.radius(middle))
        there = {}
        for inner, outer in zip(across[::2], across[1::2], strict=True):
            before = open_.get((inner.number, outer.number))
            there[inner.number, outer.number] = _Ring(inner, outer, before.low if before else low, high)
        found += [ring for key, ring in open_.items() if key not in there]
        open_ = there
    return [*found, *open_.values()]


def _wall(edge: _Edge) -> Face:
    """What an edge that rises sweeps, inside towards the axis: a cylinder, or a cone about its narrower end.

    The cylinder is the unit cylinder scaled, as those of OpenMC and MCNP are, so that all give the same bits.
    """
    (r0, z0), (r1, z1) = edge.low, edge.high
    uv = around_z(ex.rounded(z0), ex.rounded(z1))
    if r0 == r1:
        rows = ((1 / r0, 0.0, 0.0), (0.0, 1 / r0, 0.0), (0.0, 0.0, 1.0))
        return Face(QuadricSurface((1.0, 1.0, 0.0), rows=rows), edge.number, uv)
    return Face(frustum_side(r0, z0, r1, z1), edge.number, uv)


def _tree_of(ring: _Ring, walls: dict[int, Face], level: Sequence[Any], inner_number: int) -> Tree:
    """A ring as a cell, or two where it has a bore. `inner_number`: of planes between rings, which are no wall."""
    ends = []
    for z, sense in ((ring.low, -1.0), (ring.high, 1.0)):
        inner, outer = (edge.radius(z) if edge else Fraction(0) for edge in (ring.inner, ring.outer))
        number = next((k for a, b, at, k in level if _equal(at, z) and a < outer and inner < b), inner_number)
        radius = ex.rounded(max((b for _, b, at, k in level if k == number), default=Fraction(1)))
        uv = flat((radius, 0, 0), (0, radius, 0))
        ends.append(Face(PlaneSurface((0.0, 0.0, sense), sense * z, (0.0, 0.0, z)), number, uv))
    outside = walls[ring.outer.number]
    ends.sort(key=lambda face: face.number)
    body = Cell((outside, *ends))
    if ring.inner is None or ring.inner.number not in walls:
        return body
    # Between the same heights: else a bore that another edge has in one line with it would show this one's number
    return All((body, Cell((replace(walls[ring.inner.number], inside=-1), *ends))))
