"""The support of half-spaces against polyhedra whose vertices are known."""

from __future__ import annotations

import decimal
import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

from conicoid.geometry.bounds.linear_program import half_spaces_bounds, half_spaces_support
from conicoid.geometry.bounds.support import plane_uv
from conicoid.geometry.cell import cartesian_uv
from conicoid.geometry.surface import PlaneSurface

from .test_boxes_of_half_spaces import corners


def support(normals, offsets, direction):
    def rows(values):
        return [Fraction(v) for v in values]

    return half_spaces_support([rows(n) for n in normals], rows(offsets), rows(direction))


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


@pytest.mark.parametrize("seed", range(10))
def test_random_polyhedra_against_their_vertices(seed: int) -> None:
    """Vertices by brute force: every three planes' common point that no other plane cuts off."""
    rng = np.random.default_rng(seed)
    normals = np.vstack([rng.integers(-9, 10, (8, 3)), np.array(CUBE)])
    normals = normals[normals.any(axis=1)]
    offsets = np.concatenate([rng.integers(1, 20, len(normals) - 6), [5] * 6])
    found = corners(list(zip(normals.tolist(), offsets.tolist(), strict=True)))
    for direction in rng.integers(-5, 6, (5, 3)).tolist():
        expected = max(sum(x * d for x, d in zip(corner, direction, strict=True)) for corner in found)
        assert support(normals.tolist(), offsets.tolist(), direction) == expected


def test_half_spaces_along_the_axes_are_bounded_as_all_others() -> None:
    """By their offsets; the simplex method, asked for each axis, agrees."""
    random = np.random.default_rng(4)
    for _ in range(200):
        count = random.integers(1, 8)
        normals = np.eye(3)[random.integers(0, 3, count)] * random.choice([1.0, -1.0, 3.0, -0.1, 1e-9], (count, 1))
        offsets = random.choice([0.0, 1.0, -0.3, 7e8, 0.7], count)
        planes = [PlaneSurface(tuple(n), float(d)) for n, d in zip(normals.tolist(), offsets, strict=True)]
        low, high = half_spaces_bounds(planes)
        for axis in np.eye(3):
            above, below = support(normals, offsets, axis), support(normals, offsets, -axis)
            for end, exact in ((high[axis == 1][0], above), (-low[axis == 1][0], below)):
                assert end == exact if not math.isfinite(exact) else 0 <= Fraction(end) - exact <= math.ulp(end)


@pytest.mark.parametrize("legs", [(3, 4, 5), (20, 21, 29), (119, 120, 169)])
def test_many_planes_through_one_corner(legs) -> None:
    """A pyramid whose sides, and planes that only touch its apex, meet in (1/3, 0, 7): that is the highest point."""
    a, b, c = legs
    sides = [(x, y, c) for p, q in ((a, b), (b, a), (c, 0), (0, c)) for x in (p, -p) for y in (q, -q)]
    normals = [*sides, *((x, y, 9 * z) for x, y, z in sides), (0, 0, -1)]
    offsets = [Fraction(x, 3) + 7 * z for x, _, z in normals[:-1]]
    assert support(normals, [*offsets, 0], (0, 0, 2)) == 14
    assert support(normals, [*offsets, 0], (0, 0, -1)) == 0


def test_empty_or_a_point_by_a_hair() -> None:
    hair = Fraction(1, 10**40)
    sides = [(1, 1, 0), (-1, 1, 0), (0, -1, 1), (0, -1, -1)]
    assert support(sides, [0, 0, 0, 0], (0, 3, 0)) == 0
    assert support(sides, [0, 0, hair, hair], (0, 3, 0)) == 0
    assert support(sides, [0, 0, -hair, -hair], (0, 3, 0)) == -math.inf


def test_prisms_without_ends() -> None:
    """Those of a square that stands on a corner, along each axis; and one that is empty, since two sides exclude."""
    for axis in range(3):
        sides = [np.insert(side, axis, 0.0) for side in itertools.product((1.0, -1.0), repeat=2)]
        low, high = half_spaces_bounds([PlaneSurface(tuple(side.tolist()), 3.0) for side in sides])
        across = np.arange(3) != axis
        assert (high[across] == 3).all()
        assert (low[across] == -3).all()
        assert (low[axis], high[axis]) == (-math.inf, math.inf)
        offsets = (3.0, 3.0, 3.0, -4.0)
        low, high = half_spaces_bounds(
            [PlaneSurface(tuple(side.tolist()), end) for side, end in zip(sides, offsets, strict=True)]
        )
        assert (low - high == math.inf).all()


@pytest.mark.parametrize("seed", range(3))
def test_axes_on_a_plane_to_the_last_bit(seed: int) -> None:
    """u and v of a plane by the formula in 120 decimal digits, whatever the size of its normal."""
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
