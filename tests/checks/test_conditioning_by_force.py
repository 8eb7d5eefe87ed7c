"""Digits that remain, against brute force in exact arithmetic: every number up or down, and every combination of them."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import conicoid as co

from .digits_kept import U, only


def ball_coefficients(center, radius) -> dict[str, float]:
    x, y, z = center
    constant = x * x + y * y + z * z - radius * radius
    return dict(xx=1.0, yy=1.0, zz=1.0, x=-2.0 * x, y=-2.0 * y, z=-2.0 * z, constant=constant)


def distance_after(values: dict[str, float], signs: tuple[int, ...], point, normal) -> mpmath.mpf:
    """How far along the normal the surface lies whose numbers have changed by u, with these signs."""
    mp = mpmath.mp
    changed = {name: mp.mpf(v) * (1 + s * mp.mpf(U)) for (name, v), s in zip(values.items(), signs, strict=True)}

    def at(t):
        x, y, z = (p + t * n for p, n in zip(point, normal, strict=True))
        terms = dict(xx=x * x, yy=y * y, zz=z * z, x=x, y=y, z=z, constant=mp.mpf(1))
        return mp.fsum(changed[name] * terms[name] for name in changed)

    c, a_plus_b, a_minus_b = at(0), at(1) - at(0), at(-1) - at(0)
    a, b = (a_plus_b + a_minus_b) / 2, (a_plus_b - a_minus_b) / 2
    disc = b * b - 4 * a * c
    return mp.inf if disc < 0 else abs(2 * c / (b + (mp.sqrt(disc) if b > 0 else -mp.sqrt(disc))))


@pytest.mark.parametrize("center", [(10.0, 0.0, 0.0), (300.0, -400.0, 125.0), (4096.0, 4096.0, 4096.0)])
def test_a_ball_by_coefficients_against_all_signs_of_all_changes(center):
    """Every number up or down: what the worst combination does at the place that is named, and nowhere much more."""
    radius = 2.0
    values = ball_coefficients(center, radius)
    values = {name: value for name, value in values.items() if value}
    found = only(co.Quadric(coefficients=values))
    with mpmath.workdps(60):
        rng = np.random.default_rng(1)
        places = [found.point - np.array(center), *rng.normal(size=(4, 3))]
        worst = []
        for direction in places:
            normal = [mpmath.mpf(float(c)) for c in direction]
            length = mpmath.sqrt(mpmath.fsum(c * c for c in normal))
            normal = [c / length for c in normal]
            point = [mpmath.mpf(c) + radius * n for c, n in zip(center, normal, strict=True)]
            every = itertools.product((1, -1), repeat=len(values))
            worst.append(float(max(distance_after(values, signs, point, normal) for signs in every)) / (2 * radius))
    assert worst[0] / math.sqrt(3) * 0.999 <= found.movement <= worst[0] * 1.001
    assert max(worst[1:]) <= 2 * math.sqrt(3) * found.movement
    assert found.digits == pytest.approx(-math.log10(found.movement))


def test_nearly_parallel_planes_move_their_edge():
    """z <= d, -n z + a x <= b: they meet at x = (b + n d) / a, here 0.5; the body reaches from -1.5 to there."""
    a, n, d, b = 2.0**-30, 1.0, 0.3, -0.3 + 2.0**-31
    normals = [(0, 0, 1), (a, 0, -n), (-1, 0, 0), (0, 1, 0), (0, -1, 0)]
    found = only(co.Polyhedron(normals, [d, b, 1.5, 1, 1]))
    numbers = [Fraction(v) for v in (1, a, n, d, b)]  # the first is the 1 in (0, 0, 1)
    edges = []
    for signs in itertools.product((1, -1), repeat=5):
        one, a_, n_, d_, b_ = (v * (1 + s * Fraction(U)) for v, s in zip(numbers, signs, strict=True))
        edges.append((b_ + n_ * d_ / one) / a_)
    moves = float(max(abs(edge - Fraction(b + n * d) / Fraction(a)) for edge in edges)) / 2
    assert moves * 0.9 <= found.movement <= 3 * moves
    assert "surfaces meet there" in found.reason
    assert found.number in ("normals[0][2]", "normals[1][2]", "offsets[0]", "offsets[1]")


def rodrigues(axis, degrees, point):
    """The point turned about an axis, in mpmath."""
    mp = mpmath.mp
    length = mp.sqrt(mp.fsum(a * a for a in axis))
    k = [a / length for a in axis]
    c, s = mp.cos(mp.radians(degrees)), mp.sin(mp.radians(degrees))
    across = [k[1] * point[2] - k[2] * point[1], k[2] * point[0] - k[0] * point[2], k[0] * point[1] - k[1] * point[0]]
    along = mp.fsum(a * p for a, p in zip(k, point, strict=True)) * (1 - c)
    return [p * c + x * s + a * along for p, x, a in zip(point, across, k, strict=True)]


@pytest.mark.parametrize("seed", range(6))
def test_a_moved_box_against_its_corners(seed):
    """low, high, rotate, translate, one number after the other: how far each face goes at each of its corners.

    In units of the extent across the face that is all: faces of a box are at right angles where it has its own size.
    """
    mp = mpmath.mp
    rng = np.random.default_rng(seed)
    low, high = rng.normal(size=3) * 10 ** rng.uniform(0, 3, 3), rng.uniform(1e-3, 1e3, 3)
    high = low + high
    axis, degrees, shift = rng.normal(size=3), float(rng.uniform(10, 300)), rng.normal(size=3) * 1e4
    found = only(co.Box(low, high).rotate(axis, degrees).translate(shift))
    with mpmath.workdps(50):
        ends = [[mp.mpf(v) for v in end.tolist()] for end in (low, high)]
        size = [b - a for a, b in zip(*ends, strict=True)]
        numbers = [mp.mpf(v) for v in (*axis.tolist(), degrees, *shift.tolist())]

        def moved(point, values):
            turned = rodrigues(values[:3], values[3], point)
            return [t + s for t, s in zip(turned, values[4:], strict=True)]

        normals = [rodrigues(numbers[:3], numbers[3], [mp.mpf(i == k) for i in range(3)]) for k in range(3)]
        worst = mp.mpf(0)
        for pick in itertools.product((0, 1), repeat=3):
            corner = [ends[end][k] for k, end in enumerate(pick)]
            at = moved(corner, numbers)
            steps = []
            for i, value in enumerate(numbers):
                changed = [*numbers[:i], value * (1 + mp.mpf(U)), *numbers[i + 1 :]]
                steps.append([a - b for a, b in zip(moved(corner, changed), at, strict=True)])
            for k in range(3):
                goes = mp.fsum(abs(mp.fsum(a * b for a, b in zip(step, normals[k], strict=True))) for step in steps)
                worst = max(worst, (goes + mp.mpf(U) * abs(corner[k])) / size[k])
    assert found.movement == pytest.approx(float(worst), rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_an_oblique_cylinder_against_its_definition(seed):
    """Its side and ends by their definition: |distance from the axis - r|, and heights above the ends."""
    mp = mpmath.mp
    rng = np.random.default_rng(seed)
    start, end, radius = rng.normal(size=3) * 1e3, rng.normal(size=3) * 1e3, 10 ** rng.uniform(-1, 1)
    found = only(co.Cylinder(start, end, radius))
    across = np.cross(end - start, [1.0, 0.3, 0.2])
    across /= np.linalg.norm(across)
    other = np.cross(end - start, across) / np.linalg.norm(end - start)
    with mpmath.workdps(40):
        given = [mp.mpf(v) for v in (*start.tolist(), *end.tolist(), float(radius))]

        def heights(values, point):
            """(distance from the axis - r, height above start, height above end)"""
            a, b, r = values[:3], values[3:6], values[6]
            axis = [q - p for p, q in zip(a, b, strict=True)]
            length = mp.sqrt(mp.fsum(c * c for c in axis))
            d = [x - p for p, x in zip(a, point, strict=True)]
            up = mp.fsum(p * q for p, q in zip(d, axis, strict=True)) / length
            return mp.sqrt(mp.fsum(c * c for c in d) - up * up) - r, up, up - length

        worst = 0.0
        sizes = (2 * radius, float(np.linalg.norm(end - start)), float(np.linalg.norm(end - start)))
        for angle, foot in itertools.product(np.linspace(0, 2 * np.pi, 16, endpoint=False), (start, end)):
            place = foot + radius * (math.cos(angle) * across + math.sin(angle) * other)
            point = [mp.mpf(c) for c in place.tolist()]
            base = heights(given, point)
            for which in (0, 1 if foot is start else 2):
                goes = mp.mpf(0)
                for i, value in enumerate(given):
                    changed = [*given[:i], value * (1 + mp.mpf(U)), *given[i + 1 :]]
                    goes += abs(heights(changed, point)[which] - base[which])
                worst = max(worst, float(goes) / sizes[which])
    # The side's width counts up to √2 times more between the axes of its section; the best of 16 angles may be missed
    assert worst / math.sqrt(2) * 0.9 <= found.movement <= worst * 1.1
