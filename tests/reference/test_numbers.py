"""Numbers, motions and roots of the reference, so that they can fail."""

from __future__ import annotations

import math

import numpy as np
import pytest

from .forms import Affine, chain, form, proportional
from .numbers import VANISHED, cosine, number, rational, root, rounded, sine
from .quadratics import compare, equal, in_order, roots, whole_ray


@pytest.mark.parametrize("degrees", range(-360, 375, 15))
def test_sines_of_multiples_of_fifteen_degrees(degrees):
    s, c = sine(degrees), cosine(degrees)
    assert s.exact
    assert math.isclose(float(s), math.sin(math.radians(degrees)), abs_tol=1e-15)
    assert math.isclose(float(c), math.cos(math.radians(degrees)), abs_tol=1e-15)
    assert s * s + c * c == 1
    assert sine(degrees + 30) == s * cosine(30) + c * sine(30)


def test_sines_of_other_angles_are_rounded():
    s, c = sine(0.7), cosine(0.7)
    assert not s.exact
    assert math.isclose(float(s), math.sin(math.radians(0.7)), rel_tol=1e-15)
    assert 0 <= abs(rational(s) ** 2 + rational(c) ** 2 - 1) < VANISHED
    assert s * s + c * c - 1 == 0


def test_sums_of_square_roots():
    assert root(8) == 2 * root(2)
    assert root(6) * root(10) == 2 * root(15)
    assert root(2.25) == 1.5
    assert (root(2) + root(3)) * (root(3) - root(2)) == 1
    assert (root(2) + root(3) - root(6)).sign == 1  # 3.146 - 2.449
    # 1 / (sqrt 2 + 1)^40 is 5e-16, and the difference of two numbers of 10^15
    tiny = number(1)
    for _ in range(40):
        tiny = tiny * (root(2) - 1)
    assert (tiny.sign, (-tiny).sign) == (1, -1)
    assert math.isclose(float(tiny), (math.sqrt(2) + 1) ** -40, rel_tol=1e-12)


def test_a_rounding_is_nearest():
    third = number(1) / 3
    for value in (third, third * 2.0**-200, third * (1 << 5000), -third):
        off = abs(rounded(value.fraction) - value.fraction) / abs(value.fraction)
        assert 0 <= off * 2**2990 <= 1


def test_motions_that_cancel_do():
    steps = (("rotate", (1, 2, 3), 105), ("scale", (2, 1, -0.5)), ("rotate", (1, 1, 0), 15))
    back = (("rotate", (1, 1, 0), -15), ("scale", (0.5, 1, -2)), ("rotate", (1, 2, 3), -105))
    assert chain((*steps, *back)) == Affine()
    assert chain([("rotate", (0, 0, 1), 15)] * 6).rows == chain([("rotate", (0, 0, 1), 90)]).rows
    rounded_back = chain([("rotate", (1, 2, 3), 40.5), ("rotate", (1, 2, 3), -40.5)])
    assert rounded_back == Affine()
    assert not rounded_back.rows[0][0].exact


def test_motions_compose_first_to_last():
    turn = chain([("translate", (1, 0, 0)), ("rotate", (0, 0, 1), 90), ("scale", (2, 3, 4))])
    assert turn.point((0, 0, 0)) == (0, 3, 0)
    assert turn.point((0, 1, 1)) == (-2, 3, 4)
    assert chain([("rotate", (1, 1, 1), 120)]).point((1, 2, 3)) == (3, 1, 2)
    *rows, last = turn.backwards()
    back = Affine(tuple(row[:3] for row in rows), tuple(row[3] for row in rows))
    assert [x / last[3] for x in back.point(turn.point((5, 6, 7)))] == [5, 6, 7]


def test_multiples_of_a_form_are_one_surface():
    f = {(0, 0): 1, (1, 2): root(2), (3, 3): -3}
    assert proportional(form(f), form({pair: -2 * k for pair, k in f.items()})) == -1
    assert proportional(form(f), form({pair: root(3) * k for pair, k in f.items()})) == 1
    assert proportional(form(f), form({**f, (3, 3): -3 + 2.0**-50})) == 0
    assert proportional(form(f), form({**f, (0, 3): 1})) == 0


def test_rays_are_whole_numbers():
    o, d, w = whole_ray((0.75, -3.0, 2.0**-1000), (1e10, 0, 0.5))
    assert (o, d, w) == ([3 * 2**998, -3 * 2**1000, 1], [10**10 * 2**1000, 0, 2**999], 2**1000)


def test_all_small_quadratics_in_order():
    """Roots that differ do so by more than 1e-12 here."""
    random = np.random.default_rng(1)
    every = [x for k in range(40) for x in roots(k, tuple(number(int(i)) for i in random.integers(-4, 5, 3)), True)]
    assert len(every) > 40
    for r in every:
        a, b, c = map(float, r.quadratic)
        assert abs((a * r.place + b) * r.place + c) < 1e-12
        assert np.sign(2 * a * r.place + b) == 2 * r.slope - 1
        for s in every:
            off = r.place - s.place
            assert compare(r, s) == (0 if abs(off) < 1e-12 else np.sign(off))
            assert r.surface == s.surface or equal(r, s) == (abs(off) < 1e-12)
    groups = in_order(every[::-1])
    assert [len({round(r.place, 9) for r in group}) for group in groups] == [1] * len(groups)
    assert sorted(r.place for r in every) == [r.place for group in groups for r in group]
