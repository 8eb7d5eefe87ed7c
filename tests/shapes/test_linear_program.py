"""The support of half-spaces against polyhedra with known vertices, and boxes of preparation around them."""

import decimal
import itertools
import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry import shape
from conicoid.geometry.bounds.linear_program import integer_row, integer_support
from conicoid.geometry.bounds.support import plane_uv
from conicoid.geometry.cell import cartesian_uv
from conicoid.geometry.surface import PlaneSurface

# --- The support of half-spaces against polyhedra with known vertices


def support(normals, offsets, direction):
    def rows(values):
        return [Fraction(v) for v in values]

    return integer_support(
        [integer_row((*rows(n), o)) for n, o in zip(normals, rows(offsets), strict=True)], rows(direction)
    )


CUBE = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
OCTAHEDRON = list(itertools.product((1, -1), repeat=3))


@pytest.mark.parametrize("direction", list(itertools.product((-2, 0, 1), repeat=3)))
def test_cube_and_octahedron(direction) -> None:
    """h(u) = |u|₁ of the cube |x|∞ <= 1, |u|∞ of the octahedron |x|₁ <= 1."""
    assert support(CUBE, [1] * 6, direction) == sum(abs(u) for u in direction)
    assert support(OCTAHEDRON, [1] * 8, direction) == max(abs(u) for u in direction)


def test_unbounded_and_empty() -> None:
    assert support([(1, 0, 0)], [2], (3, 0, 0)) == 6
    assert support([(1, 0, 0)], [2], (-1, 0, 0)) == math.inf
    assert support([(1, 0, 0)], [2], (1, Fraction(1, 10**30), 0)) == math.inf
    assert support([(1, 1, 0), (1, -1, 0)], [1, 1], (1, 0, 0)) == 1
    assert support([(1, 0, 0), (-1, 0, 0)], [1, -2], (0, 1, 0)) == -math.inf
    assert support([(1, 0, 0), (-1, 0, 0)], [1, -1], (1, 0, 0)) == 1
    assert support([(1, 0, 0), (-1, 0, 0)], [1, -1], (0, 0, 1)) == math.inf


@pytest.mark.parametrize(("seed", "unit"), [*((k, 1) for k in range(10)), (10, 1 + Fraction(1, 10**400))])
def test_random_polyhedra_against_their_vertices(seed: int, unit: Fraction) -> None:
    """Vertices are, by brute force, every three planes' common point that no other plane cuts off."""
    rng = np.random.default_rng(seed)
    normals = np.vstack([rng.integers(-9, 10, (8, 3)), np.array(CUBE)])
    normals = normals[normals.any(axis=1)]
    offsets = np.concatenate([rng.integers(1, 20, len(normals) - 6), [5] * 6])
    found = corners(list(zip(normals.tolist(), offsets.tolist(), strict=True)))
    for direction in rng.integers(-5, 6, (5, 3)).tolist():
        expected = max(sum(x * d for x, d in zip(corner, direction, strict=True)) for corner in found)
        assert support(normals.tolist(), [unit * offset for offset in offsets.tolist()], direction) == unit * expected


@pytest.mark.parametrize("legs", [(3, 4, 5), (20, 21, 29), (119, 120, 169)])
def test_many_planes_through_one_corner(legs) -> None:
    """A pyramid's sides, and planes that only touch its apex, meet in (1/3, 0, 7), the highest point."""
    a, b, c = legs
    sides = [(x, y, c) for p, q in ((a, b), (b, a), (c, 0), (0, c)) for x in (p, -p) for y in (q, -q)]
    normals = [*sides, *((x, y, 9 * z) for x, y, z in sides), (0, 0, -1)]
    offsets = [Fraction(x, 3) + 7 * z for x, _, z in normals[:-1]]
    assert support(normals, [*offsets, 0], (0, 0, 2)) == 14
    assert support(normals, [*offsets, 0], (0, 0, -1)) == 0


@pytest.mark.parametrize("digits", [40, 400])
def test_empty_or_a_point_by_a_hair(digits) -> None:
    hair = Fraction(1, 10**digits)
    sides = [(1, 1, 0), (-1, 1, 0), (0, -1, 1), (0, -1, -1)]
    assert support(sides, [0, 0, 0, 0], (0, 3, 0)) == 0
    assert support(sides, [0, 0, hair, hair], (0, 3, 0)) == 0
    assert support(sides, [0, 0, -hair, -hair], (0, 3, 0)) == -math.inf


@pytest.mark.parametrize("seed", range(3))
def test_axes_on_a_plane_to_the_last_bit(seed: int) -> None:
    """The formula gives u and v of a plane in 120 decimal digits, for any size of its normal."""
    rng = np.random.default_rng(seed)
    with decimal.localcontext(prec=120):
        for _ in range(40):
            normal = rng.normal(size=3) * 10.0 ** rng.integers(-40, 40)
            normal[rng.integers(3)] *= rng.choice([0.0, 1e-20, 1.0])
            n = [decimal.Decimal(c) for c in normal.tolist()]
            e = min(range(3), key=lambda i: abs(n[i]))
            length = sum(c * c for c in n).sqrt()
            n = [c / length for c in n]
            u = [(i == e) - n[e] * n[i] for i in range(3)]
            size = sum(c * c for c in u).sqrt()
            u = [c / size for c in u]
            v = [n[i - 2] * u[i - 1] - n[i - 1] * u[i - 2] for i in range(3)]
            plane = PlaneSurface(tuple(normal.tolist()), 0.0)
            for row, axis in zip(plane_uv(plane).matrix, (u, v), strict=False):
                # What cancels leaves some 10⁻¹²⁰
                floats = tuple(float(c) if abs(c) > decimal.Decimal("1e-100") else 0.0 for c in axis)
                expected = cartesian_uv(floats, (1.0, 0.0, 0.0)).matrix[0]
                assert row[:3] == pytest.approx(expected[:3], rel=0, abs=0)


# --- Boxes of preparation in floats around half-spaces: against corners in fractions, and never inside of them


Point = tuple[Fraction, Fraction, Fraction]
CELL = [(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)]
"""The normals of a tetrahedron."""


def corners(planes: list[tuple[Any, Any]]) -> list[Point]:
    """Return the points common to three planes (normal, offset) that no other plane cuts off, by Cramer's rule."""
    rows = [tuple(map(Fraction, (*normal, offset))) for normal, offset in planes]
    found = []
    for a, b, c in itertools.combinations(rows, 3):
        unit = _determinant(a[:3], b[:3], c[:3])
        if not unit:
            continue
        columns = list(zip(a, b, c, strict=True))
        point = [_determinant(*(columns[3] if k == i else columns[k] for k in range(3))) / unit for i in range(3)]
        if all(sum(n * x for n, x in zip(row[:3], point, strict=True)) <= row[3] for row in rows):
            found.append((point[0], point[1], point[2]))
    return found


def _determinant(a: Any, b: Any, c: Any) -> Fraction:
    return sum(
        (a[i] * (b[i - 2] * c[i - 1] - b[i - 1] * c[i - 2]) for i in range(3)),
        Fraction(0),
    )


def random_cell(rng: np.random.Generator, count: int) -> list[tuple[Any, Any]]:
    """Return a tetrahedron cut by further planes. Some have whole numbers, so that several meet in a point."""
    normals = np.concatenate([np.array(CELL) + 0.3 * rng.normal(size=(4, 3)), rng.normal(size=(count, 3))])
    if rng.random() < 0.5:
        normals = np.round(2 * normals) / 2
    center, offsets = 10.0 ** rng.integers(-1, 4) * rng.normal(size=3), rng.uniform(0.2, 2, len(normals))
    planes = []
    for normal, offset in zip(normals.tolist(), offsets.tolist(), strict=True):
        if any(normal):
            planes.append((tuple(normal), float(np.dot(normal, center) + offset)))
    return planes


@pytest.mark.parametrize("count", [0, 1, 3, 6])
def test_boxes_hold_all_corners_tightly(count, noted_calls) -> None:
    """All bodies have one plan, or each is alone. Floats decide nearly all."""
    rng = np.random.default_rng(count)
    cells = [random_cell(rng, count) for _ in range(12)]
    left = noted_calls(shape, "region_bounds")
    solids = [co.Intersection(tuple(co.HalfSpace(*plane) for plane in planes)) for planes in cells]
    together = co.Scene(solids)._prepared.lowered.boxes
    for planes, solid, box in zip(cells, solids, together, strict=True):
        points = corners(planes)
        ends = [max(sign * point[k] for point in points) for sign in (-1, 1) for k in range(3)]
        alone = co.Scene([solid.translate((0.0, 0.0, 0.0))])._prepared.lowered.boxes[0]
        for found in (box, alone):
            size = max(map(abs, found.tolist())) * 1e-14 + (found[3:] - found[:3]).max() * 1e-8
            for end, value in zip(ends, [*(-found[:3]).tolist(), *found[3:].tolist()], strict=True):
                assert 0 <= Fraction(value) - end <= size
    # Bodies alone are bounded in floats, too, where an earlier scene of many has recorded their form
    assert len(left) <= 6
