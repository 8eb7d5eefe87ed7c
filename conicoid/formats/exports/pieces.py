"""Bounded solids in words that other programs know: balls, boxes, what is turned or drawn, closed faces, Booleans.

What has no end is cut beyond the body that it is a part of, by a room around that: nothing of the body is lost.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal, TypeAlias

from ...shapes.steps import Step
from ...shapes.vector import Vector

Kind: TypeAlias = Literal["union", "intersection", "difference"]
Corner: TypeAlias = tuple[Fraction, Fraction, Fraction]
Steps: TypeAlias = tuple[Step, ...]


@dataclass(frozen=True)
class Ball:
    """x² + y² + z² <= radius²"""

    radius: float


@dataclass(frozen=True)
class Egg:
    """An ellipsoid about the origin."""

    radii: Vector


@dataclass(frozen=True)
class Cuboid:
    """low <= (x, y, z) <= high"""

    low: Vector
    high: Vector


@dataclass(frozen=True)
class Frustum:
    """About z, from a circle of one radius at `low` to one of another at `high`."""

    first: float
    second: float
    low: float
    high: float


@dataclass(frozen=True)
class Turned:
    """A polygon of (r, z) about z, from one angle to another."""

    profile: tuple[tuple[float, float], ...]
    start: float = 0.0
    end: float = 360.0


@dataclass(frozen=True)
class Drawn:
    """A polygon of (x, y) from `low` to `high`, scaled there about the z axis."""

    outline: tuple[tuple[float, float], ...]
    low: float
    high: float
    scale: float = 1.0


@dataclass(frozen=True)
class Bowl:
    """x² + y² <= g0 + g1 z + g2 z² between two heights: a paraboloid or hyperboloid; coefficients as they are."""

    g0: Fraction
    g1: Fraction
    g2: Fraction
    low: float
    high: float


@dataclass(frozen=True)
class Faces:
    """What flat faces enclose, counter-clockwise as seen from outside if `is_convex`.

    planes: those of the shape, (normal, offset), where it was given by such.
    """

    corners: tuple[Corner, ...]
    faces: tuple[tuple[int, ...], ...]
    is_convex: bool = False
    planes: tuple[tuple[Vector, float], ...] | None = None


@dataclass(frozen=True)
class Native:
    """An element of the format itself, as text: its tag, attributes and children; and where its middle is."""

    tag: str
    attributes: str
    children: str = ""
    shift: Corner = (Fraction(0), Fraction(0), Fraction(0))


Piece: TypeAlias = Ball | Egg | Cuboid | Frustum | Turned | Drawn | Bowl | Faces | Native


@dataclass(frozen=True)
class Leaf:
    """A piece that is moved by steps. `is_rounded` where its numbers are not those of the shape."""

    piece: Piece
    steps: Steps = ()
    is_rounded: bool = False


@dataclass(frozen=True)
class Combined:
    """Several of them, moved by steps; of a difference the first without the others. `color`: of what is painted."""

    kind: Kind
    parts: tuple[Node, ...]
    steps: Steps = ()
    color: str | None = None


Node: TypeAlias = Leaf | Combined
