"""GDML's solids of flat faces, but for those of outlines and sections."""

from __future__ import annotations

from fractions import Fraction
from functools import partial

import numpy as np

from ...shapes.box import Box
from ...shapes.mesh import Mesh
from ...shapes.rounded import sin_cos_degrees
from ..openmc.xml_tree import Element
from .convex import SIX_FACES, Twisted, convex, cross, dot, inside_of, minus, planes_of_convex
from .placement import Point, moved
from .reading import MOST_OF_CONVEX, LeftOut, Mistake, known, reference
from .templates import Make
from .twisted import between_sections
from .values import Values


def box(values: Values) -> Make:
    """x, y, z in all."""
    x, y, z = (values.positive(name) / 2 for name in "xyz")
    low, high = (-x, -y, -z), (x, y, z)
    return partial(_box, low, high)


def _box(low: Point, high: Point, shift: Point) -> Box:
    return Box(moved(low, shift), moved(high, shift))


def tangent(degrees: Fraction) -> Fraction:
    """Exact of 0 and 45 degrees. Raises ValueError at 90."""
    s, c = sin_cos_degrees(float(degrees))
    if abs(c) < 1e-12:
        raise ValueError("an angle must not be 90 degrees")
    return Fraction(1) if s == c else Fraction(s) / Fraction(c)


def trd(values: Values) -> Make:
    """x1, y1 at the lower end, x2, y2 at the upper, z, all in all."""
    half = values.positive("z") / 2
    x1, x2, y1, y2 = (values.radius(name) / 2 for name in ("x1", "x2", "y1", "y2"))
    return convex(_frustum((x1, x1, y1), (x2, x2, y2), half), SIX_FACES)


def _frustum(
    low: tuple[Fraction, Fraction, Fraction],
    high: tuple[Fraction, Fraction, Fraction],
    half: Fraction,
    slants: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0)),
    lean: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0)),
) -> list[Point]:
    """Eight corners of two trapezoids across z: half-widths at -y and at y, and half the height in y of each.

    slants: how x grows with y in each; lean: how x and y grow with z.
    """
    found: list[Point] = []
    for (below, above, y), z, slant in ((low, -half, slants[0]), (high, half, slants[1])):
        a, b = lean[0] * z, lean[1] * z
        found += [
            (a - slant * y - below, b - y, z), (a - slant * y + below, b - y, z),
            (a + slant * y + above, b + y, z), (a + slant * y - above, b + y, z),
        ]  # fmt: skip
    return found


def trap(values: Values) -> Make:
    """The general trapezoid of Geant4: z, theta, phi, y1, x1, x2, alpha1, y2, x3, x4, alpha2, lengths in all."""
    half = values.positive("z") / 2
    y1, x1, x2, y2, x3, x4 = (values.radius(name) / 2 for name in ("y1", "x1", "x2", "y2", "x3", "x4"))
    slants = tangent(values.angle("alpha1", 0)), tangent(values.angle("alpha2", 0))
    return _eight(_frustum((x1, x2, y1), (x3, x4, y2), half, slants, lean_of(values)), half)


def _eight(corners: list[Point], half: Fraction) -> Make:
    """Between four corners at -half and four at half; sides that are not flat are quadrics."""
    try:
        return convex(corners, SIX_FACES)
    except Twisted:
        low, high = ([(x, y) for x, y, _ in some] for some in (corners[:4], corners[4:]))
        return between_sections(low, high, half)


def lean_of(values: Values) -> tuple[Fraction, Fraction]:
    """How x and y grow with z, by theta and phi."""
    slope = tangent(values.angle("theta", 0))
    s, c = sin_cos_degrees(float(values.angle("phi", 0)))
    return slope * Fraction(c), slope * Fraction(s)


def para(values: Values) -> Make:
    """A parallelepiped: x, y, z in all, alpha, theta, phi."""
    x, y, half = (values.positive(name) / 2 for name in "xyz")
    slant = tangent(values.angle("alpha", 0))
    return convex(_frustum((x, x, y), (x, x, y), half, (slant, slant), lean_of(values)), SIX_FACES)


def tet(values: Values) -> Make:
    """Four corners, named positions."""
    corners = [_position(values, values.element, f"vertex{k}") for k in range(1, 5)]
    a, b, c = (minus(corner, corners[0]) for corner in corners[1:])
    if not dot(cross(a, b), c):
        raise Mistake(values.element, "vertex1 to vertex4 must not lie in a plane")
    return convex(corners, ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)))


def _position(values: Values, element: Element, attribute: str) -> Point:
    reading = values.reading
    table = reading.vectors.setdefault("position", {})
    found: Point = known(reading, table, reference(reading, element, attribute), element, "position")
    return found


def arb8(values: Values) -> Make:
    """v1x, v1y to v8x, v8y: four corners at -dz, four at dz."""
    half = values.positive("dz")
    corners: list[Point] = []
    for k in range(8):
        corners.append((values.length(f"v{k + 1}x"), values.length(f"v{k + 1}y"), half if k > 3 else -half))
    return _eight(corners, half)


def tessellated(values: Values) -> Make:
    """Triangles and quadrangles that close."""
    places: dict[Point, int] = {}
    faces = []
    for element in values.element.children:
        count = {"triangular": 3, "quadrangular": 4}.get(element.tag)
        if count is None:
            continue
        corners = [_position(values, element, f"vertex{k}") for k in range(1, count + 1)]
        if element.attributes.get("type", "ABSOLUTE") == "RELATIVE":
            x, y, z = corners[0]
            corners[1:] = [(a + x, b + y, c + z) for a, b, c in corners[1:]]
        face = tuple(dict.fromkeys(places.setdefault(corner, len(places)) for corner in corners))
        if len(face) > 2:
            faces.append(face)
    convex_ones = _is_convex(list(places), faces)
    planes = planes_of_convex(list(places), faces) if convex_ones else None
    if planes is not None:
        return inside_of(planes)
    values.reading.spend(len(faces), convex_ones)
    return closed(list(places), faces)


def _is_convex(vertices: list[Point], faces: list[tuple[int, ...]]) -> bool:
    """Are all corners on one side of each face, about?"""
    if len(faces) > MOST_OF_CONVEX or not faces:
        return False
    points = np.array([tuple(map(float, vertex)) for vertex in vertices])
    a, b, c = (points[[face[k] for face in faces]] for k in range(3))
    normals = np.cross(b - a, c - a)
    loose = 1e-9 * np.abs(normals).sum(axis=1) * max(float(np.ptp(points, axis=0).max()), 1e-300)
    for normal, corner, slack in zip(normals, a, loose, strict=True):
        heights = (points - corner) @ normal
        if heights.max() > slack and heights.min() < -slack:
            return False
    return True


def closed(vertices: list[Point], faces: list[tuple[int, ...]]) -> Make:
    """A closed surface, its faces all in one sense. LeftOut where it is none."""
    volume = Fraction(0)
    for face in faces:
        for k in range(2, len(face)):
            a, b, c = vertices[face[0]], vertices[face[k - 1]], vertices[face[k]]
            volume += dot(cross(a, b), c)
    if volume < 0:
        faces = [face[::-1] for face in faces]
    return partial(_mesh, vertices, tuple(faces))


def _mesh(vertices: list[Point], faces: tuple[tuple[int, ...], ...], shift: Point) -> Mesh:
    x, y, z = shift
    points = tuple((float(a + x), float(b + y), float(c + z)) for a, b, c in vertices)
    try:
        return Mesh(points, faces)
    except ValueError as error:
        raise LeftOut(f"its faces are no closed surface: {error}") from None
