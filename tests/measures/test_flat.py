"""Solids with flat faces have closed forms: against formulas, fractions, and counts of unit cubes."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.io.openscad.solids import sided_ball

from .solids import askew

SHEAR = [[1, 0.4, 0, 1], [-0.3, 1, 0.2, 0], [0, 0.5, 0.8, -2], [0, 0, 0, 1]]
OCTAHEDRON = co.Polyhedron(tuple(itertools.product((-1, 1), repeat=3)), (1,) * 8)
L_OUTLINE = ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))


def closed(shape: co.Solid) -> co.Measures:
    """Return measures, which must come from no ray."""
    found = co.measure(shape)
    assert (found.rays, found.volume_error, found.area_error) == (0, 0, 0)
    return found


def test_an_octahedron():
    found = closed(OCTAHEDRON)
    assert found.volume == pytest.approx(4 / 3, rel=1e-14)
    assert found.area == pytest.approx(4 * math.sqrt(3), rel=1e-14)
    assert found.centroid == pytest.approx(np.zeros(3), abs=1e-14)
    # ∫ x² over |x| + |y| + |z| <= 1 is ∫ x² 2 (1 - |x|)² dx = 2 / 15
    assert found.inertia == pytest.approx(4 / 15 * np.eye(3), abs=1e-14)


def test_half_spaces_that_repeat_touch_or_are_far_change_nothing():
    more = (*OCTAHEDRON.normals, (2, 2, 2), (1, 0, 0), (1, 1, 0), (0, 0, 1))
    found = closed(co.Polyhedron(more, (*OCTAHEDRON.offsets, 2, 1, 1, 1e9)))
    assert found.volume == pytest.approx(4 / 3, rel=1e-14)
    assert found.area == pytest.approx(4 * math.sqrt(3), rel=1e-14)


@pytest.mark.parametrize("sides", [7, 40])
def test_a_ball_of_so_many_sides(sides: int):
    """A stack of frustums of regular polygons: h (A + B + sqrt(A B)) / 3 each; sides are trapezoids."""
    count = (sides + 1) // 2
    rings = [math.radians(180 * (k + 0.5) / count) for k in range(count)]
    areas = [sides / 2 * math.sin(math.tau / sides) * (3 * math.sin(a)) ** 2 for a in rings]
    edges = [2 * math.sin(math.pi / sides) * 3 * math.sin(a) for a in rings]
    flat = 3 * math.cos(math.pi / sides)
    volume, area = 0.0, areas[0] + areas[-1]
    for k in range(count - 1):
        rise = 3 * (math.cos(rings[k]) - math.cos(rings[k + 1]))
        volume += rise * (areas[k] + areas[k + 1] + math.sqrt(areas[k] * areas[k + 1])) / 3
        slant = math.hypot(rise, flat * (math.sin(rings[k + 1]) - math.sin(rings[k])))
        area += sides * (edges[k] + edges[k + 1]) / 2 * slant
    found = closed(sided_ball(3.0, sides).translate((1e3, 0, 0)))
    assert found.volume == pytest.approx(volume, rel=1e-12)
    assert found.area == pytest.approx(area, rel=1e-12)
    assert found.centroid == pytest.approx((1e3, 0, 0), abs=1e-12)


def test_random_tetrahedra_as_meshes():
    """A sixth of a determinant, in fractions; the mean of the corners; areas by Heron's formula."""
    rng = np.random.default_rng(4)
    for _ in range(12):
        corners = rng.integers(-9, 9, (4, 3)).tolist()
        a, b, c = ([Fraction(p - q) for p, q in zip(corner, corners[0], strict=True)] for corner in corners[1:])
        six = abs(
            a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
        if not six:
            continue
        found = closed(co.Mesh(corners, ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))))
        assert found.volume == pytest.approx(float(six / 6), rel=1e-12)
        assert found.centroid == pytest.approx(np.mean(corners, axis=0), abs=1e-12)
        area = 0.0
        for three in itertools.combinations(corners, 3):
            p, q, r = (math.dist(one, other) for one, other in itertools.combinations(three, 2))
            area += math.sqrt(max((p + q + r) * (-p + q + r) * (p - q + r) * (p + q - r), 0.0)) / 4
        assert found.area == pytest.approx(area, rel=1e-9)


@pytest.mark.parametrize("top", [0.0, 0.5, 1.0, 2.0])
def test_extrusions(top: float):
    """The area of the outline times the height times (1 + s + s²) / 3."""
    found = closed(co.Extrusion(L_OUTLINE, (1, 4), top))
    assert found.volume == pytest.approx(3 * 3 * (1 + top + top * top) / 3, rel=1e-14)
    if top == 1:
        assert found.area == pytest.approx(2 * 3 + 8 * 3, rel=1e-14)
        assert found.centroid == pytest.approx((2.5 / 3, 2.5 / 3, 2.5), abs=1e-14)


@pytest.mark.parametrize("shape", [OCTAHEDRON, co.Extrusion(L_OUTLINE, (0, 1), 0.5)], ids=["polyhedron", "extrusion"])
def test_motions(shape: co.Solid):
    own, turned, sheared = closed(shape), closed(askew(shape)), closed(shape.transform(SHEAR))
    factor = turned.volume / own.volume
    assert turned.area == pytest.approx(own.area * factor ** (2 / 3), rel=1e-12)
    assert sheared.volume == pytest.approx(own.volume * abs(np.linalg.det(np.array(SHEAR)[:3, :3])), rel=1e-13)
    sampled = co.measure(shape.transform(SHEAR) | shape.transform(SHEAR), rays=20_000)
    assert sheared.area == pytest.approx(sampled.area, abs=5 * sampled.area_error)
    assert (np.abs(sheared.inertia - sampled.inertia) <= 5 * sampled.inertia_error).all()


def test_faces_back_to_back_bound_nothing():
    """Two cubes of one mesh that share a wall have the area of a box of 1 × 1 × 2."""
    corners, faces = [], []
    for z in (0, 1):
        first = len(corners)
        corners += [(x, y, z + up) for up in (0, 1) for y in (0, 1) for x in (0, 1)]
        cube = (0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)
        faces += [tuple(first + k for k in face) for face in cube]
    found = co.measure(co.Mesh(corners, faces), rays=2000)
    assert (found.volume, found.volume_error) == (pytest.approx(2, rel=1e-14), 0)
    assert found.area == pytest.approx(10, abs=5 * found.area_error + 1e-9)


# Booleans of boxes


def sponge(level: int, cut: bool = False) -> co.Solid:
    """Return Menger's sponge as the union of its cubes, or as a cube less square bars."""
    if cut:
        bars = []
        for size in (3**k for k in range(level)):
            for i, j in itertools.product(range(3**level // (3 * size)), repeat=2):
                a, b = size * (3 * i + 1), size * (3 * j + 1)
                for axis in range(3):
                    low, high = [a, b], [a + size, b + size]
                    low.insert(axis, 0)
                    high.insert(axis, 3**level)
                    bars.append(co.Box(low, high))
        return co.Difference((co.Box((0, 0, 0), (3**level,) * 3), *bars))
    places = [(0, 0, 0)]
    for _ in range(level):
        steps = [d for d in itertools.product(range(3), repeat=3) if sum(k == 1 for k in d) < 2]
        places = [tuple(3 * x + y for x, y in zip(p, d, strict=True)) for p in places for d in steps]
    return co.Union(tuple(co.Box(p, tuple(x + 1 for x in p)) for p in places))


@pytest.mark.parametrize("cut", [False, True])
def test_mengers_sponge(cut: bool):
    """20 of 27 cubes are left at each level; the area is 2 (20 / 9)^n + 4 (8 / 9)^n of the first cube's side squared."""
    for level in (1, 2):
        found = closed(sponge(level, cut).rotate((1, 2, 3), 33).translate((10, 20, 30)))
        assert found.volume == pytest.approx(20**level, rel=1e-13)
        assert found.area == pytest.approx(9**level * (2 * (20 / 9) ** level + 4 * (8 / 9) ** level), rel=1e-12)


def test_random_booleans_of_boxes():
    """Counts of unit cubes, and of the squares between those inside and outside."""
    rng = np.random.default_rng(6)
    at = np.stack(np.meshgrid(*[np.arange(-1, 9) + 0.5] * 3, indexing="ij"), axis=-1)

    def box():
        low = rng.integers(0, 6, 3)
        high = low + rng.integers(1, 3, 3)
        return co.Box(low.tolist(), high.tolist()), ((at > low) & (at < high)).all(axis=-1)

    for _ in range(8):
        (a, p), (b, q), (c, r), (d, s) = (box() for _ in range(4))
        whole = ((a | b | c) - d) | (d & ~a & b)
        inside = ((p | q | r) & ~s) | (s & ~p & q)
        found = closed(whole.scale((2, 1, 3)))
        x, y, z = (2 * (np.arange(-1, 9) + 0.5), np.arange(-1, 9) + 0.5, 3 * (np.arange(-1, 9) + 0.5))
        walls = [np.abs(np.diff(inside.astype(int), axis=axis)).sum() for axis in range(3)]
        assert found.volume == pytest.approx(6 * inside.sum(), rel=1e-13)
        assert found.area == pytest.approx(3 * walls[0] + 6 * walls[1] + 2 * walls[2], rel=1e-13)
        i, j, k = np.nonzero(inside)
        assert found.centroid == pytest.approx((x[i].mean(), y[j].mean(), z[k].mean()), rel=1e-13)
        square = np.array([((x[i] - x[i].mean()) ** 2 + 4 / 12).sum(), ((y[j] - y[j].mean()) ** 2 + 1 / 12).sum()])
        assert found.inertia[2, 2] == pytest.approx(6 * square.sum(), rel=1e-12)
        mixed = ((x[i] - x[i].mean()) * (y[j] - y[j].mean())).sum()
        assert found.inertia[0, 1] == pytest.approx(-6 * mixed, rel=1e-9, abs=1e-9)


def test_tilted_boxes_are_left_to_other_rules():
    tilted = co.Box((0, 0, 0), (1, 1, 1)) | co.Box((0, 0, 0), (1, 1, 1)).rotate((1, 1, 0), 30)
    assert co.measure(tilted, rays=600).rays > 0


@pytest.mark.parametrize(
    ("solid", "volume", "area"),
    [
        (co.Box((0, 0, 0), (1, 1, 1)) - co.Box((0, 0, 5e-13), (1, 1, 1)), 5e-13, 2.0),
        (co.Box((0, 0, 1000), (1, 1, 1000 + 1e-9)) | co.Box((0, 0, 1000), (1, 0.5, 1000 + 1e-9)), 1e-9, 2.0),
    ],
)
def test_thin_boxes_are_not_lost(solid, volume, area):
    """Their walls are apart by more than rounding, however little that is beside their place."""
    found = co.measure(solid)
    assert found.volume == pytest.approx(volume, rel=1e-3, abs=5 * found.volume_error)
    assert found.area == pytest.approx(area, rel=1e-3, abs=5 * found.area_error)


CUBE = (0, 0, 0), (3, 3, 3)
"""A cube of 27, to which boxes are added, or from which they are taken as faces that look inward."""


@pytest.mark.parametrize(
    "boxes",
    [
        [(((1, 1, 0), (2, 2, 2)), -1)],
        [(((1, 1, 0), (2, 2, 3)), -1)],
        [(((1, 1, 1), (2, 2, 2)), -1)],
        [(((0, 0, 0), (2, 2, 2)), -1)],
        [(((0, 1, 0), (2, 2, 2)), -1)],
        [(((0, 0, 0), (1, 1, 3)), -1), (((1, 1, 0), (2, 2, 3)), -1)],
        [(((3, 1, 1), (4, 2, 2)), 1), (((1, 1, 3), (2, 2, 4)), 1)],
        [(((3, 0, 0), (4, 3, 3)), 1)],
    ],
)
def test_holes_and_blocks_that_share_a_wall(boxes):
    """Of two faces that lie on one another, one may be larger: a hole that is flush with a wall, a block on it."""
    corners, faces = [], []
    for (low, high), sense in [(CUBE, 1), *boxes]:
        quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        faces += [tuple(len(corners) + k for k in quad[::sense]) for quad in quads]
        corners += [tuple((low, high)[k >> axis & 1][axis] for axis in range(3)) for k in range(8)]
    mesh = co.Mesh(corners, faces)
    points = np.random.default_rng(5).uniform(-0.5, 4.5, (4000, 3))
    count = sum(sense * ((points > low) & (points < high)).all(axis=1) for (low, high), sense in [(CUBE, 1), *boxes])
    assert np.array_equal(co.Scene([mesh]).contains(points), count > 0)
    volume = 27 + sum(sense * np.prod(np.subtract(high, low)) for (low, high), sense in boxes)
    assert co.measure(mesh).volume == pytest.approx(volume, rel=1e-12)
