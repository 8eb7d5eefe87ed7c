"""The exact oracle itself: what is known by hand, and the 90 digits of `tests/oracle` on random shapes."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

from ..oracle import rays as hard_rays
from ..oracle.cases import Case
from ..oracle.precision import mp, number
from ..oracle.restricted import line
from ..oracle.samples import KINDS, generator, random_case
from ..oracle.sheets import sheet_crossings
from ..oracle.trace import trace
from .exact import ExactRay, as_pair, compare, distance, integers
from .forms import chain
from .rational import VANISHED
from .shapes import exact_shape, reference
from .traced import Shape, crossings


def found(case: Case, origin, direction):
    return [(as_pair(c.root)[0], c.entering) for c in crossings(exact_shape(case), ExactRay(origin, direction))]


def plain(kind: str, *steps, **parameters) -> Case:
    return Case(kind, parameters, (0, 0, 0), 1.0, steps=steps)


BOX = plain("Box", low=(-1, -1, -1), high=(1, 1, 1))
TUBE = plain("Cylinder", start=(0, 0, -1), end=(0, 0, 1), radius=5.0)


def test_known_answers():
    assert found(plain("Sphere", radius=5, center=(0, 0, 0)), (3, -9, 0), (0, 1, 0)) == [(5, True), (13, False)]
    assert found(BOX, (-3, 0, 0), (2, 0, 0)) == [(1, True), (2, False)]
    assert found(TUBE, (3, -9, 0), (0, 1, 0)) == [(5, True), (13, False)]
    turned = plain("Cylinder", ("rotate", (1, 1, 1), 120), start=(0, 0, -1), end=(0, 0, 1), radius=5.0)
    assert found(turned, (0, 3, -9), (0, 0, 1)) == [(5, True), (13, False)]


def test_touching_is_no_crossing():
    assert found(plain("Sphere", radius=5, center=(0, 0, 0)), (5, -9, 0), (0, 1, 0)) == []
    assert found(plain("Sphere", radius=5, center=(0, 0, 0)), (3, 4, 9), (0, 0, 1)) == []
    assert found(TUBE, (5, 0, -9), (0, 0, 1)) == []  # along a ruling
    assert found(BOX, (-2, 0, 0), (1, 1, 0)) == []  # through the edge x = -1, y = 1
    assert found(plain("Sphere", radius=5, center=(0, 0, 0)), (math.nextafter(5, 0), -9, 0), (0, 1, 0)) != []
    nappes = plain("DoubleCone", slope=1.0, z_range=None)
    assert found(nappes, (0, -3, 0), (0, 1, 0)) == []  # through the apex, outside
    assert found(nappes, (-1, 0, -2), (1, 0, 2)) == []  # through the apex, inside all along


def test_a_ray_in_a_face_counts_to_one_side():
    """The plane counts as if it stood further along (1, 0, 0): the high face is met, the low one is not."""
    assert found(BOX, (1, 0, -5), (0, 0, 1)) == [(4, True), (6, False)]
    assert found(BOX, (-1, 0, -5), (0, 0, 1)) == []


def test_corners_and_coincident_walls():
    assert found(BOX, (-3, -3, -3), (1, 1, 1)) == [(2, True), (4, False)]
    left, right = plain("Box", low=(-2, -1, -1), high=(0, 1, 1)), plain("Box", low=(0, -1, -1), high=(2, 1, 1))
    both = Case("Union", {}, (0, 0, 0), 1.0, operands=(left, right))
    assert found(both, (-3, 0, 0), (1, 0, 0)) == [(1, True), (5, False)]
    nothing = Case("Difference", {}, (0, 0, 0), 1.0, operands=(left, left))
    assert found(nothing, (-3, 0, 0), (1, 0, 0)) == []


def test_irrational_frames_know_what_is_zero_on_paper():
    """Along the axis of a turn nothing is turned; there and back is where it was."""
    turned = plain("Box", ("rotate", (0, 0, 1), 37), low=(-1, -1, -1), high=(1, 1, 1))
    assert found(turned, (0, 0, -3), (0, 0, 1)) == [(2, True), (4, False)]
    there_and_back = chain([("rotate", (1, 2, 3), 40.5), ("rotate", (1, 2, 3), -40.5)])
    assert not there_and_back.exact
    off = [abs(x - int(i == j)) for i, row in enumerate(there_and_back.rows) for j, x in enumerate(row)]
    assert max(off) < VANISHED
    assert sum(1 for x in off if x == 0) >= 6  # what is zero is so exactly


def test_roots_in_common_are_recognised():
    """Spheres about (0, 0, 0) and (2, 0, 0) of radius 5/4 have a circle at x = 1 in common, but equal."""
    first, second = (plain("Sphere", radius=1.25, center=(x, 0, 0)) for x in (0, 2))
    shape = Shape([("any", (reference(first), reference(second)))])
    ray = ExactRay((1, -4, 0), (0, 1, 0))
    assert len(crossings(shape, ray)) == 2
    nudged = ExactRay((math.nextafter(1, 2), -4, 0), (0, 1, 0))
    assert len(crossings(shape, nudged)) == 2
    entering = crossings(shape, nudged)[0].root
    other = crossings(exact_shape(first), nudged)[0]
    assert compare(entering, other.root) == -1
    assert distance(other.root, as_pair(entering)[0])[0] > 0


def test_distances_are_bounds():
    ray = ExactRay((-3, 0, 0), (1, 0, 0))
    (root, _) = (c.root for c in crossings(exact_shape(plain("Sphere", radius=0.1, center=(0, 0, 0))), ray))
    exact = 3 - Fraction(0.1)
    assert distance(root, 2.9)[0] <= float(abs(exact - Fraction(2.9))) <= distance(root, 2.9)[1]
    assert distance(root, 2.9)[1] < 1e-15
    high, low = as_pair(root)
    assert abs(Fraction(high) + Fraction(low) - exact) < Fraction(1, 2**100)


def test_integers_of_floats():
    numbers, e = integers((0.75, -3.0, 2.0**-1000))
    assert [Fraction(int(n), 1 << e) for n in numbers] == [Fraction(3, 4), -3, Fraction(1, 1 << 1000)]


@pytest.mark.parametrize("kind", sorted(set(KINDS) - {"Spheres"}))
def test_against_ninety_digits(kind: str):
    """Where the reference in mpmath is certain, both have the same crossings."""
    compared = 0
    for index in range(3):
        random = generator(kind, 500 + index)
        case = random_case(kind, random)
        known_formula, size = case.reference(), number(case.world_size)
        shape = exact_shape(case)
        for o, d in zip(*hard_rays.rays(case, 8, random), strict=True):
            ray = line(o, d)
            reach = mp.mpf(10) ** 7 * (size + mp.norm(ray.origin)) / ray.speed
            if case.is_sheet:
                known = sheet_crossings(known_formula, ray, size, reach)
                certain, expected = all(k.on is not None for k in known), [k.crossing for k in known]
            else:
                traced = trace(known_formula, ray, size, reach)
                certain, expected = not traced.in_band, traced.crossings
            if not certain:
                continue
            mine = [c for c in crossings(shape, ExactRay(o, d)) if abs(as_pair(c.root)[0]) < reach]
            assert len(mine) == len(expected)
            for c, e in zip(mine, expected, strict=True):
                assert c.entering == e.entering
                assert c.face in (-1, e.face) or e.face is None
                assert abs(sum(map(mp.mpf, as_pair(c.root))) - e.t) <= mp.mpf(2) ** -100 * abs(e.t)
            compared += 1
    assert compared > 10
