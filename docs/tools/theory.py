"""The figures of docs/theory.md, drawn by Conicoid: plane figures are thin things seen from above."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

import conicoid as co

PAPER = "#fbfaf7"
INK, PALE, RED, GREEN, BLUE, GOLD = "#333333", "#cfd8e3", "#c0392b", "#2e8b57", "#2b5f93", "#e0a526"
Point = Sequence[float]


def rod(start: Point, end: Point, color: str, radius: float = 0.015) -> co.Body:
    """A line of the figure."""
    return co.Body(co.Cylinder(start, end, radius), _flat(color))


def dot(place: Point, color: str = INK, radius: float = 0.045) -> co.Body:
    """A point of the figure."""
    return co.Body(co.Sphere(radius, place), _flat(color))


def arrow(start: Point, way: Point, color: str, radius: float = 0.02) -> list[co.Body]:
    """A line with a tip."""
    start, way = np.asarray(start, dtype=float), np.asarray(way, dtype=float)
    neck = start + way * (1 - 8 * radius / np.linalg.norm(way))
    return [rod(start, neck, color, radius), co.Body(co.Cone(neck, start + way, 3 * radius, 0), _flat(color))]


def half(solid: co.Solid, color: str) -> co.Body:
    """The part of a solid under the plane of the figure, z = -0.2, so that lines lie over it."""
    return co.Body(solid & co.HalfSpace((0, 0, 1), -0.2), _flat(color))


def _flat(color: str) -> co.Material:
    return co.Material(color, ambient=1, diffuse=0, specular=0)


def drawn(bodies: Iterable[co.Body], middle: Point, height: float, size: tuple[int, int], scale: float) -> co.Image:
    """The figure from above, `height` high, every line in its own colour, without shadows."""
    camera = co.OrthographicCamera((*middle, 50), (*middle, 0), up=(0, 1, 0), height=height)
    scene = co.Scene(list(bodies), [co.AmbientLight(1)], camera, PAPER)
    return scene.render(round(size[0] * scale), round(size[1] * scale), samples=16)


def sphere(scale: float) -> co.Image:
    """A ray and a sphere: the foot of the perpendicular from the centre, half the chord, the normals."""
    origin, way = np.array([-3.0, 0.55, 0]), np.array([1.0, 0, 0])
    ball = co.Sphere(1)
    ends = co.Scene([ball]).crossings(origin, way).point
    foot = ends.mean(axis=0)
    return drawn(
        [
            half(ball, PALE),
            *arrow(origin, 5 * way, INK),
            rod((0, 0, 0), foot, RED),
            rod(ends[0], foot, GOLD, 0.03),
            *arrow(ends[0], 0.7 * ends[0], BLUE),
            *arrow(ends[1], 0.7 * ends[1], BLUE),
            *(dot(place) for place in (origin, (0, 0, 0), foot, *ends)),
        ],
        (-0.4, 0.1), 2.6, (560, 260), scale,
    )  # fmt: skip


def refraction(scale: float) -> co.Image:
    """Light from within a half ball of glass: refracted, along the wall, and totally reflected."""
    glass = co.Sphere(1.6) & co.HalfSpace((1, 0, 0), 0)
    bodies = [half(glass, PALE), dot((0, 0, 0))]
    for degrees, color in ((15, BLUE), (30, GREEN), (40, GOLD), (50, RED)):
        angle = np.radians(degrees)
        way = np.array([np.cos(angle), np.sin(angle), 0])
        beyond, _ = co.refract(way, (1, 0, 0), 1.52)
        bodies += [rod(-1.6 * way, (0, 0, 0), color), *arrow((0, 0, 0), 1.6 * beyond, color)]
    return drawn(bodies, (0, 0.2), 3.6, (480, 420), scale)


def even_odd(scale: float) -> co.Image:
    """A star that crosses itself, and how often two rays in its plane cross its edges."""
    corners = [(np.sin(0.8 * np.pi * k), np.cos(0.8 * np.pi * k), -0.2) for k in range(5)]
    bodies = [co.Body(co.Polygon(corners), _flat(PALE))]
    edges = list(zip(corners, corners[1:] + corners[:1], strict=True))
    bodies += [rod((*a[:2], 0), (*b[:2], 0), INK, 0.012) for a, b in edges]
    for y, x in ((-0.05, 0.0), (0.2, 0.4)):
        bodies += [*arrow((x, y, 0.1), (1.4 - x, 0, 0), RED), dot((x, y, 0.1), RED)]
        bodies += [dot((*place, 0.1), BLUE) for place in _met(edges, x, y)]
    return drawn(bodies, (0.1, 0.05), 2.3, (420, 340), scale)


def _met(edges: list[tuple[Point, Point]], x: float, y: float) -> list[tuple[float, float]]:
    places = [(a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1]), y) for a, b in edges if (a[1] < y) != (b[1] < y)]
    return [place for place in places if place[0] > x]


def booleans(scale: float) -> co.Image:
    """The spans of one ray in two solids and in their combinations."""
    a, b = co.Sphere(1, (-0.5, 0, 0)), co.Sphere(1, (0.5, 0, 0))
    bodies = []
    for k, solid in enumerate((a | b, a & b, a - b, b - a)):
        right = 3.6 * k
        bodies += [half(part.translate((right, 0, 0)), "#eceff3") for part in ((a | b) - solid,)]
        bodies.append(half(solid.translate((right, 0, 0)), "#9fb9d6"))
        origin = np.array([right - 1.75, 0.3, 0])
        bodies.append(rod(origin, origin + (3.5, 0, 0), INK))
        spans = co.Scene([solid.translate((right, 0, 0))]).spans(origin, (1, 0, 0))
        for enter, leave in zip(spans.t_enter, spans.t_exit, strict=True):
            bodies.append(rod(origin + (enter, 0, 0), origin + (leave, 0, 0), RED, 0.05))
    return drawn(bodies, (5.4, 0), 2.4, (760, 126), scale)


def cell(scale: float) -> co.Image:
    """A quadric, two planes, and the cell that they make."""
    wall = co.OneSheetHyperboloid(A=2, E=2, H=1, z_range=(-1.6, 1.6))
    slab = co.Cylinder((0, 0, -0.8), (0, 0, 0.8), 1.9)
    whole = co.OneSheetHyperboloid(A=2, E=2, H=1, z_range=(-0.8, 0.8))
    floor = co.Body(co.Plane((0, 0, 1), -1.6), co.matte("#e9e6e1"))
    bodies = [
        co.Body(solid.translate((4.2 * k, 0, 0)), co.lacquer(color))
        for k, (solid, color) in enumerate(((wall, BLUE), (slab, GOLD), (whole, GREEN)))
    ]
    camera = co.Camera((4.2, -18, 8), (4.2, 0, -0.15), field_of_view=16)
    lights = [co.AmbientLight(0.35), co.PointLight((-4, -12, 14), 0.7)]
    scene = co.Scene([*bodies, floor], lights, camera, "#e9e6e1")
    return scene.render(round(720 * scale), round(260 * scale), samples=9)


FIGURES: dict[str, Callable[[float], co.Image]] = {
    "sphere": sphere, "refraction": refraction, "even_odd": even_odd, "cell": cell, "booleans": booleans,
}  # fmt: skip
