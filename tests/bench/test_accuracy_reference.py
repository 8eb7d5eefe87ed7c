"""The integer reference of `python -m benchmarks --accuracy` against textbook formulas at 50 digits, and exact cases by hand."""

from __future__ import annotations

import itertools

import mpmath
import numpy as np
import pytest

from benchmarks.comparison.accuracy.bodies import (
    DOUBLE,
    FAMILIES,
    SHAPES,
    SINGLE,
    ExactBall,
    ExactBlock,
    ExactQuadric,
    ExactRevolution,
    inside,
    trials,
)
from benchmarks.comparison.accuracy.reference import first_crossings

from ..samples import sampled

BALL = ExactBall((0.1, 0.2, 0.3), 1.3)
BLOCK = ExactBlock((-1, -0.5, -0.25), (1, 0.7, 0.3))
ROD = ExactRevolution((-0.5, -0.25, 0.1), (0.3, 0.7, 0.9), 0.7, 0.7)
CONE = ExactRevolution((-0.5, -0.25, 0.1), (0.3, 0.7, 0.9), 0.8, 0.0)
FRUSTUM = ExactRevolution((-0.5, -0.25, 0.1), (0.3, 0.7, 0.9), 0.2, 0.5)
HYPERBOLOID = ExactQuadric(dict(xx=1.0, yy=2.0, zz=-1.5, xy=0.3, yz=0.2, xz=-0.4, x=0.1, y=0.2, z=0.3, constant=-1.0))
BODIES = {"ball": BALL, "block": BLOCK, "rod": ROD, "cone": CONE, "frustum": FRUSTUM, "hyperboloid": HYPERBOLOID}


def dot(a, b):
    return sum((x * y for x, y in zip(a, b, strict=True)), mpmath.mpf(0))


def quadratic(a, b, c):
    """Roots of a t² + 2 b t + c."""
    if a == 0:
        return [-c / (2 * b)] if b else []
    root = b * b - a * c
    return [] if root < 0 else [(-b - mpmath.sqrt(root)) / a, (-b + mpmath.sqrt(root)) / a]


def along(o, d, t):
    return [x + t * y for x, y in zip(o, d, strict=True)]


def turned_roots(body, o, d):
    """From the distance to the axis and the height along it, with square roots as they come."""
    start, end = (list(map(mpmath.mpf, p)) for p in (body.start, body.end))
    length = mpmath.sqrt(sum((q - p) ** 2 for p, q in zip(start, end, strict=True)))
    axis = [(q - p) / length for p, q in zip(start, end, strict=True)]
    slope = (mpmath.mpf(body.end_radius) - body.start_radius) / length
    p = [x - y for x, y in zip(o, start, strict=True)]
    h, k = dot(p, axis), dot(d, axis)
    across, turn = ([x - s * u for x, u in zip(v, axis, strict=True)] for v, s in ((p, h), (d, k)))
    radius = body.start_radius + slope * h
    roots = quadratic(
        dot(turn, turn) - (slope * k) ** 2, dot(across, turn) - radius * slope * k, dot(across, across) - radius**2
    )
    on_side = [t for t in roots if 0 < h + t * k < length]
    caps = [(-h / k, body.start_radius), ((length - h) / k, body.end_radius)] if k else []
    return on_side + [t for t, r in caps if dot(q := along(across, turn, t), q) < mpmath.mpf(r) ** 2]


def block_roots(body, o, d):
    result = []
    for i in range(3):
        for wall in (body.low[i], body.high[i]):
            if d[i] == 0:
                continue
            t = (mpmath.mpf(wall) - o[i]) / d[i]
            p = along(o, d, t)
            if all(body.low[j] < p[j] < body.high[j] for j in range(3) if j != i):
                result.append(t)
    return result


def general_roots(body, o, d):
    """From three values of the polynomial along the ray."""
    c = body.coefficients

    def value(t):
        x, y, z = along(o, d, mpmath.mpf(t))
        return (
            c["xx"] * x * x + c["yy"] * y * y + c["zz"] * z * z + c["xy"] * x * y + c["yz"] * y * z + c["xz"] * x * z
            + c["x"] * x + c["y"] * y + c["z"] * z + c["constant"]
        )  # fmt: skip

    at, after, before = value(0), value(1), value(-1)
    return quadratic((after + before) / 2 - at, (after - before) / 4, at)


def roots(body, o, d):
    if isinstance(body, ExactBall):
        p = [x - mpmath.mpf(y) for x, y in zip(o, body.center, strict=True)]
        return quadratic(dot(d, d), dot(p, d), dot(p, p) - mpmath.mpf(body.radius) ** 2)
    each = {ExactBlock: block_roots, ExactRevolution: turned_roots, ExactQuadric: general_roots}
    return each[type(body)](body, o, d)


def check(body, origins, directions, digits):
    """Compare all rays but ties; returns how many hit."""
    found = first_crossings(body, origins, directions)
    with mpmath.workdps(digits):
        for i in np.flatnonzero(~found.tie):
            o, d = ([*map(mpmath.mpf, row.tolist())] for row in (origins[i], directions[i]))
            expected = min((t for t in roots(body, o, d) if t > 0), default=None)
            if expected is None:
                assert np.isinf(found.high[i])
                continue
            assert found.high[i] == float(expected)
            both = mpmath.mpf(float(found.high[i])) + mpmath.mpf(float(found.low[i]))
            assert abs(both / expected - 1) < mpmath.mpf(2) ** -104
    return np.isfinite(found.high).sum()


@pytest.mark.parametrize("single", [True, False], ids=["float32", "float64"])
@pytest.mark.parametrize("name", BODIES)
def test_first_crossings_are_those_of_textbook_formulas(name, single):
    random = np.random.default_rng(5)
    origins = random.uniform(-3, 3, (150, 3))
    directions = random.uniform(-1, 1, (150, 3)) - origins * random.uniform(0, 1, (150, 1))
    if single:
        origins, directions = (x.astype(np.float32).astype(float) for x in (origins, directions))
    assert check(BODIES[name], origins, directions, 50) > 15


@pytest.mark.parametrize(
    ("shape", "family", "precision"),
    sampled(itertools.product(SHAPES, FAMILIES, (SINGLE, DOUBLE)), 5),
    ids=lambda value: getattr(value, "name", value),
)
def test_the_measured_rays_have_the_answers_of_textbook_formulas(shape, family, precision):
    """With 160 digits: the square roots of the formulas cancel on grazing and parallel rays."""
    made = trials(shape, family, precision, 60)
    assert sum(check(trial.body, trial.origins, trial.directions, 160) for trial in made) > 10


@pytest.mark.parametrize(
    ("body", "origin", "direction"),
    [
        (ExactBall((0, 0, 0), 5.0), (3, 4, -9), (0, 0, 1)),  # touches: 3² + 4² = 5²
        (ExactBlock((0, 0, 0), (1, 1, 1)), (0.25, 0, -1), (0, 0, 1)),  # runs in a face
        (ExactBlock((0, 0, 0), (1, 1, 1)), (-1, 0.5, 0), (1, 0, 1)),  # passes through an edge only
        (ExactRevolution((0, 0, 0), (0, 0, 2), 5.0, 5.0), (3, 4, -1), (0, 0, 1)),  # runs in the wall
        (ExactBall((0, 0, 0), 5.0), (3, 4, 0), (1, 0, 0)),  # starts on it
    ],
)
def test_what_only_touches_has_no_agreed_answer(body, origin, direction):
    found = first_crossings(body, *(np.array([x], float) for x in (origin, direction)))
    assert found.tie.tolist() == [True]


def test_a_hair_beside_tangency_is_known():
    ball = ExactBall((0, 0, 0), 1.0)
    origins = np.array([(np.nextafter(1, 0), 0, -2), (np.nextafter(1, 2), 0, -2)])
    found = first_crossings(ball, origins, np.array([(0, 0, 1.0)] * 2))
    # z² = 1 - (1 - 2^-53)² = 2^-52 - 2^-106
    assert found.high[0] == float(2 - mpmath.sqrt(mpmath.mpf(2) ** -52))
    assert np.isinf(found.high[1])


def test_errors_are_exact():
    ball = ExactBall((0, 0, 0), 1.0)
    found = first_crossings(ball, np.array([(0.5, 0, -2.0)]), np.array([(0, 0, 3.0)]))
    with mpmath.workdps(50):
        exact = (2 - mpmath.sqrt(mpmath.mpf(3) / 4)) / 3
        t = np.array([0.378])
        assert found.errors(t)[0] == pytest.approx(float(abs(mpmath.mpf(0.378) - exact)), rel=1e-15)


@pytest.mark.parametrize("name", BODIES)
def test_inside_is_where_the_line_says(name):
    """A point is inside if the ray from it leaves an odd number of times: here, of convex bodies, if it hits at all both ways."""
    body, random = BODIES[name], np.random.default_rng(6)
    points = random.uniform(-1.5, 1.5, (300, 3))
    if name == "hyperboloid":
        c = body.coefficients
        x, y, z = points.T
        value = (
            c["xx"] * x * x + c["yy"] * y * y + c["zz"] * z * z + c["xy"] * x * y + c["yz"] * y * z + c["xz"] * x * z
        )
        expected = value + c["x"] * x + c["y"] * y + c["z"] * z + c["constant"] <= 0
    else:
        directions = random.normal(size=points.shape)
        expected = np.all([np.isfinite(first_crossings(body, points, s * directions).high) for s in (1, -1)], axis=0)
    assert np.array_equal(inside(body, points), expected)
