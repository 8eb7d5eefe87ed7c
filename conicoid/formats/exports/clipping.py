"""Convex polyhedra by their faces: a box that planes cut, in exact fractions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction

from .pieces import Corner, Cuboid, Faces

Plane = tuple[Corner, Fraction]
"""normal·x <= offset"""
_BOX_FACES = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))


def clipped(box: Cuboid, planes: Iterable[Plane]) -> Faces | None:
    """What of a box is inside of all planes; None where nothing is."""
    ends = tuple(tuple(map(Fraction, end)) for end in (box.low, box.high))
    corners = [(ends[k & 1][0], ends[k >> 1 & 1][1], ends[k >> 2 & 1][2]) for k in range(8)]
    loops = [[corners[k] for k in face] for face in _BOX_FACES]
    for plane in planes:
        loops = _cut(loops, plane)
        if len(loops) < 4:
            return None
    numbers: dict[Corner, int] = {}
    faces = tuple(tuple(numbers.setdefault(corner, len(numbers)) for corner in loop) for loop in loops)
    return Faces(tuple(numbers), faces, True)


def _cut(loops: list[list[Corner]], plane: Plane) -> list[list[Corner]]:
    """Faces of a convex polyhedron without what is beyond a plane, and the face in the plane."""
    heights = {corner: _height(plane, corner) for loop in loops for corner in loop}
    if not any(height > 0 for height in heights.values()):
        return loops
    kept, edges = [], {}
    for loop in loops:
        left = _part(loop, heights, plane)
        on = [corner for corner in left if not heights.get(corner, 0)]
        if len(left) < 3 or len(on) == len(left):
            continue
        kept.append(left)
        for a, b in zip(left, [*left[1:], left[0]], strict=True):
            if not heights.get(a, 0) and not heights.get(b, 0):
                edges[b] = a
    if len(edges) >= 3:
        first = next(iter(edges))
        cap, at = [first], edges[first]
        while at != first and len(cap) <= len(edges):
            cap.append(at)
            at = edges.get(at, first)
        kept.append(cap)
    return kept


def _part(loop: Sequence[Corner], heights: dict[Corner, Fraction], plane: Plane) -> list[Corner]:
    """A face's part on the inner side."""
    found: list[Corner] = []
    for a, b in zip(loop, [*loop[1:], loop[0]], strict=True):
        ha, hb = heights[a], heights[b]
        if ha <= 0:
            found.append(a)
        if ha * hb < 0:
            share = ha / (ha - hb)
            x, y, z = (p + share * (q - p) for p, q in zip(a, b, strict=True))
            found.append((x, y, z))
    return found


def _height(plane: Plane, corner: Corner) -> Fraction:
    (a, b, c), offset = plane
    return a * corner[0] + b * corner[1] + c * corner[2] - offset
