"""Lengths, roots, sines and tangents of preparation are the nearest floats; sums of products keep the order of terms."""

import itertools
import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from conicoid._util.records import dot_rows, matmul_rows, unit_rows
from conicoid.apps.derivatives.wall_jacobians import Dual
from conicoid.geometry.bounds.quadric_extent import _stationary_directions
from conicoid.numerics import portable_math as rounded
from conicoid.numerics.bigfloat import exact
from conicoid.render.color_mapping import _sin_cos_degrees

MP = mpmath.mp.clone()
MP.prec = 1400


def angles():
    random = np.random.default_rng(1)
    near = 90 - 10.0 ** random.uniform(-12, 0, 50)
    return [*random.uniform(0, 360, 200).tolist(), *(10.0 ** random.uniform(-300, 2, 100)).tolist(), *near.tolist()]


def test_sines_of_degrees():
    for angle in angles():
        there = MP.mpf(angle) * MP.pi / 180
        assert rounded.sin_cos_degrees(angle) == (float(MP.sin(there)), float(MP.cos(there))), angle
    third = MP.pi * 2 / 3
    assert rounded.sin_cos_degrees(Fraction(-240)) == (float(MP.sin(third)), -0.5)


def test_sines_that_are_rational():
    found = [rounded.sin_cos_degrees(angle)[0] for angle in range(-30, 360, 30)]
    assert [s for s in found if s in (0.0, 0.5, 1.0, -0.5, -1.0)] == [-0.5, 0, 0.5, 1, 0.5, 0, -0.5, -1, -0.5]


def test_sines_of_radians():
    for angle in np.random.default_rng(2).uniform(-7, 7, 200).tolist():
        assert rounded.sin_cos(angle) == (float(MP.sin(MP.mpf(angle))), float(MP.cos(MP.mpf(angle))))


def test_tangents():
    assert (rounded.tan_degrees(45.0), rounded.tan_degrees(45)) == (1.0, 1.0)
    for angle in angles():
        if angle < 90:
            assert rounded.tan_degrees(angle) == float(MP.tan(MP.mpf(angle) * MP.pi / 180)), angle


def test_lengths():
    random = np.random.default_rng(3)
    for values in (random.uniform(-1, 1, (300, 3)) * 10.0 ** random.uniform(-150, 150, (300, 1))).tolist():
        assert rounded.hypot(*values) == float(MP.sqrt(sum(MP.mpf(x) ** 2 for x in values)))
    for values in (random.uniform(-1, 1, (300, 2)) * 10.0 ** random.uniform(-30, 30, (300, 2))).tolist():
        assert rounded.hypot(*values) == float(MP.sqrt(sum(MP.mpf(x) ** 2 for x in values)))
    assert rounded.hypot(-3.0, 4.0) == 5.0
    assert rounded.hypot(0.0, -0.0) == 0.0
    assert rounded.hypot(-1.0, math.inf) == math.inf
    assert rounded.hypot(2.0**-1074, 0.0) == 2.0**-1074


@pytest.mark.parametrize("n", [3, 5])
def test_odd_roots(n):
    values = 2.0 ** np.random.default_rng(n).uniform(-30, 30, 1000)
    for value, root in zip(values.tolist(), rounded.odd_root(values, n).tolist(), strict=True):
        assert abs(MP.mpf(root) - MP.root(MP.mpf(value), n)) <= 2 * math.ulp(root)
    assert rounded.odd_root(1.0, n) == 1.0


def test_sines_of_arrays():
    angles = np.linspace(-500, 900, 1401)
    for angle, s, c in zip(angles.tolist(), *_sin_cos_degrees(angles), strict=True):
        there = MP.mpf(angle) * MP.pi / 180
        assert max(abs(MP.sin(there) - MP.mpf(s)), abs(MP.cos(there) - MP.mpf(c))) < 2.0**-52


def test_products_are_added_from_the_first_term_to_the_last():
    """Python's floats, one operation after the other, are the reference. BLAS and einsum may add in another order."""
    random = np.random.default_rng(4)
    a, b = random.normal(size=(50, 3)), random.normal(size=(3, 7))
    for i in range(50):
        assert dot_rows(a[i], b[:, 0]) == a[i, 0] * b[0, 0] + a[i, 1] * b[1, 0] + a[i, 2] * b[2, 0]
        for j in range(7):
            assert matmul_rows(a, b)[i, j] == a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]
    assert (matmul_rows(a[0], b) == matmul_rows(a, b)[0]).all()


def test_stationary_directions_are_eigenvectors_across_the_normal():
    """P S P v = λ v with P the projection across n. Where S is the same in all directions across n, any two will do."""
    normals = np.concatenate([unit_rows(np.random.default_rng(5).normal(size=(40, 3)))[0], np.eye(3), -np.eye(3)])
    for squares in ((1, 1, -1), (1, -1, 0), (1, 0, 0), (1, 1, 1), (-1, -1, 1), (0, 0, 0)):
        first, second = _stationary_directions(normals, np.array(squares, float)).reshape(2, -1, 3)
        assert np.abs((first * second).sum(axis=1)).max() < 1e-15
        for v in (first, second):
            assert np.abs((v * v).sum(axis=1) - 1).max() < 1e-15
            assert np.abs((v * normals).sum(axis=1)).max() < 1e-15
            image = v * squares
            image -= (image * normals).sum(axis=1)[:, None] * normals
            assert np.abs(image - (image * v).sum(axis=1)[:, None] * v).max() < 1e-14


def test_the_axis_along_which_a_vector_is_least_is_the_first_of_several():
    steps = (-2.0, -1.0, 0.0, 1.0, 2.0)
    for vector in itertools.product(steps, steps, steps):
        sizes = [abs(x) for x in vector]
        expected = [0.0, 0.0, 0.0]
        expected[sizes.index(min(sizes))] = 1.0
        assert list(rounded.least_axis(vector)) == expected, vector
        assert list(rounded.least_axis([Fraction(x) for x in vector])) == expected, vector


def test_numbers_with_derivatives_are_counted_as_floats_are():
    """Dual numbers are symbols, but of no recording. A count, and the first sign, must not need a tape."""
    falling, still, nothing = Dual(exact(-2.0), {1: 1.0}), Dual(exact(3.0), {}), Dual(exact(0.0), {})
    assert rounded.count_nonzero([falling, nothing, still]) == 2
    assert rounded.leading_sign([nothing, falling, still]) == -1.0
    assert rounded.least_axis([falling, nothing, still]) == (0.0, 1.0, 0.0)
