"""The solid of revolution of a polygon: cylinders, cones and planes across the axis."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple

from . import exact as ex
from .base import PrimitiveSolid
from .cells import All, Any_, Cell, Face, Tree, around_z, flat
from .cylinder import arc_support, either, wedge_walls
from .degrees import degrees
from .outline import check_simple, checked_outline
from .rounded import larger
from .support import sum_up
from .surface import PlaneSurface, QuadricSurface
from .vector import Vector


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
        first = degrees("Revolution", "start_angle", self.start_angle)
        last = degrees("Revolution", "end_angle", self.end_angle)
        if not 0 < last - first <= 360:
            told = f"{last} - {first} = {last - first}"
            raise ValueError(f"Revolution: end_angle - start_angle must be in (0, 360], got {told}")
        object.__setattr__(self, "start_angle", first)
        object.__setattr__(self, "end_angle", last)

    def tree(self) -> Tree:
        corners = [(ex.rational(r), ex.rational(z)) for r, z in self.profile]
        ends = list(zip(corners, [*corners[1:], corners[0]], strict=True))
        rising = [
            _Edge(min(a, b, key=_z), max(a, b, key=_z), k) for k, (a, b) in enumerate(ends) if not _equal(a[1], b[1])
        ]
        level = [(*sorted((a[0], b[0])), a[1], k) for k, (a, b) in enumerate(ends) if _equal(a[1], b[1])]
        walls = {edge.number: _wall(edge) for edge in rising if edge.low[0] > 0 or edge.high[0] > 0}
        parts = [_tree_of(ring, walls, level, len(corners)) for ring in rings(rising)]
        whole: Tree = parts[0] if len(parts) == 1 else Any_(tuple(parts))
        turn = self._walls(len(corners))
        if not turn:
            return whole
        wedge: Tree = Cell(turn) if self.end_angle - self.start_angle <= 180 else either(turn)
        return All((whole, wedge))

    def _walls(self, first: int) -> tuple[Face, ...]:
        """The half-planes at the angles, as faces from a number on."""
        radius, size = max(r for r, _ in self.profile), max(abs(z) for _, z in self.profile) or 1.0
        made = wedge_walls(self.start_angle, self.end_angle, radius, size)
        return tuple(replace(face, number=first + k) for k, face in enumerate(made))

    def support(self, direction: Vector) -> float:
        across = arc_support(1.0, self.start_angle, self.end_angle, direction)
        if self.end_angle - self.start_angle < 360:
            across += 2.0**-51 * abs(across)
        best = -float("inf")
        for r, z in self.profile:
            best = larger(best, sum_up(term for term in (r * across, z * direction[2]) if term))
        return best


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
    """What an edge that rises sweeps, inside towards the axis: a cylinder, or a cone about its narrower end."""
    (r0, z0), (r1, z1) = edge.low, edge.high
    slope = (r1 - r0) / (z1 - z0)
    r, z = (r0, z0) if slope >= 0 else (r1, z1)
    uv = around_z(ex.rounded(z0), ex.rounded(z1))
    if not slope:
        return Face(QuadricSurface((1.0, 1.0, 0.0), constant=r * r), edge.number, uv)
    surface = QuadricSurface((1.0, 1.0, -slope * slope), (0.0, 0.0, -slope * r), r * r, anchor=(0.0, 0.0, z))
    return Face(surface, edge.number, uv)


def _tree_of(ring: _Ring, walls: dict[int, Face], level: Sequence[Any], inner_number: int) -> Tree:
    """A ring as a cell, or two where it has a bore."""
    ends = []
    for z, sense in ((ring.low, -1.0), (ring.high, 1.0)):
        inner, outer = (edge.radius(z) if edge else Fraction(0) for edge in (ring.inner, ring.outer))
        number = next((k for a, b, at, k in level if _equal(at, z) and a < outer and inner < b), inner_number)
        radius = ex.rounded(max((b for _, b, at, k in level if k == number), default=Fraction(1)))
        uv = flat((radius, 0, 0), (0, radius, 0))
        ends.append(Face(PlaneSurface((0.0, 0.0, sense), sense * z, (0.0, 0.0, z)), number, uv))
    outside = walls[ring.outer.number]
    body = Cell((outside, *sorted(ends, key=lambda face: face.number)))
    if ring.inner is None or ring.inner.number not in walls:
        return body
    return All((body, Cell((replace(walls[ring.inner.number], inside=-1),))))
