"""Balls of flat sides, as OpenSCAD makes them by $fn: known again in the frustums that they are read as."""

from __future__ import annotations

import itertools
import math

from ....shapes.steps import Scale
from ...scad.flat import ring
from ...scad.solids import rings_of_ball
from ..pieces import Combined, Drawn, Leaf, Node

_NEAR = 4
"""Floats on either side of the radius that comes out of the highest ring."""


def ball_of_sides(node: Combined) -> tuple[float, int] | None:
    """The radius and the sides of the ball that a union of frustums is; None where it is none."""
    parts = node.parts
    if node.kind != "union" or not all(isinstance(part, Leaf) and isinstance(part.piece, Drawn) for part in parts):
        return None
    pieces = [part.piece for part in parts if isinstance(part, Leaf) and isinstance(part.piece, Drawn)]
    sides = len(pieces[0].outline)
    if (sides + 1) // 2 != len(parts) + 1 or any(len(piece.outline) != sides for piece in pieces):
        return None
    _, top = rings_of_ball(1.0, sides)[-1]
    last = pieces[-1]
    radius = max(last.high, -last.low) / top
    for _ in range(_NEAR):
        radius = math.nextafter(radius, 0.0)
    for _ in range(2 * _NEAR + 1):
        if list(parts) == _frustums(radius, sides):
            return radius, sides
        radius = math.nextafter(radius, math.inf)
    return None


def _frustums(radius: float, sides: int) -> list[Node]:
    """What such a ball is read as."""
    found: list[Node] = []
    for (first, low), (second, high) in itertools.pairwise(rings_of_ball(radius, sides)):
        if first >= second:
            found.append(Leaf(Drawn(ring(first, sides), low, high, second / first)))
        else:
            found.append(Leaf(Drawn(ring(second, sides), -high, -low, first / second), (Scale((1.0, 1.0, -1.0)),)))
    return found
