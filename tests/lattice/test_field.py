"""The lattice oracle itself: its numbers, its order of roots, and its crossings beside the other oracle's."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ..exactness.exact import ExactRay, as_pair
from ..exactness.nice import PLAIN
from ..exactness.shapes import exact_shape
from ..exactness.traced import crossings
from ..oracle.cases import Case
from .aims import lattice_rays
from .columns import Column
from .field import cosine, number, root, sine
from .items import Item
from .kinds import generator, motion, plain
from .lines import Table
from .motions import IDENTITY, chain
from .order import compare
from .shapes import bodies
from .trace import Trace, body_at


def trace(item: Item, *rays) -> Trace:
    origins, directions = zip(*rays, strict=True)
    return Trace(Table(bodies([item])), np.array(origins, float), np.array(directions, float))


def found(item: Item, origin, direction):
    """[(t, entering, face)]"""
    one = trace(item, (origin, direction))
    c = one.crossings
    t = [float(one.ball(int(s), int(f), 0).mid()) for s, f in zip(c.slope, c.surface, strict=True)]
    return list(zip(t, c.entering.tolist(), c.face.tolist(), strict=True))


@pytest.mark.parametrize("degrees", range(-360, 375, 15))
def test_sines_of_multiples_of_fifteen_degrees(degrees):
    s, c = sine(degrees), cosine(degrees)
    assert math.isclose(float(s), math.sin(math.radians(degrees)), abs_tol=1e-15)
    assert math.isclose(float(c), math.cos(math.radians(degrees)), abs_tol=1e-15)
    assert s * s + c * c == 1
    assert sine(degrees + 30) == s * cosine(30) + c * sine(30)


def test_numbers_of_the_field():
    assert root(8) == 2 * root(2)
    assert root(6) * root(10) == 2 * root(15)
    assert (root(2) + root(3)) * (root(3) - root(2)) == 1
    assert (root(2) + root(3) - root(6)).sign == 1  # 3.146 - 2.449
    # 1 / (sqrt 2 + 1)^40 is 5e-16, and the difference of two numbers of 10^15
    tiny = number(1)
    for _ in range(40):
        tiny = tiny * (root(2) - 1)
    assert tiny.sign == 1
    assert (-tiny).sign == -1
    assert math.isclose(float(tiny), (math.sqrt(2) + 1) ** -40, rel_tol=1e-12)


def test_columns_are_exact_where_integers_of_64_bits_would_not_be():
    r = generator("columns", 0)
    big = Column({1: r.integers(-(1 << 40), 1 << 40, 50), 2: r.integers(-(1 << 40), 1 << 40, 50)}, 1 << 40)
    square = big * big
    for i in range(50):
        a, b = int(big.parts[1][i]), int(big.parts[2][i])
        assert square.at(i) == {s: k for s, k in ((1, a * a + 2 * b * b), (2, 2 * a * b)) if k}
    assert (square.sign == 1).all()
    assert ((square - square).sign == 0).all()


def test_motions_that_cancel_do():
    steps = (("rotate", (1, 2, 3), 105), ("scale", (2, 1, -0.5)), ("rotate", (1, 1, 0), 15))
    back = (("rotate", (1, 1, 0), -15), ("scale", (0.5, 1, -2)), ("rotate", (1, 2, 3), -105))
    assert chain((*steps, *back)) == IDENTITY
    assert chain([("rotate", (0, 0, 1), 15)] * 6).rows == chain([("rotate", (0, 0, 1), 90)]).rows


def test_a_turn_about_the_own_axis_changes_nothing():
    cone = Item("Cone", {"start": (0, 0, -1), "end": (0, 0, 1), "start_radius": 2, "end_radius": 1})
    for degrees in (0, 15, 45, 105):
        turned = cone.moved(("rotate", (0, 0, 1), degrees))
        assert found(turned, (2, 3, 3), (-2, -2, -2)) == [(1, True, 0), (13 / 7, False, 0)]


def test_known_answers():
    box = Item("Box", {"low": (-1, -1, -1), "high": (1, 1, 1)})
    turned = box.moved(("rotate", (0, 0, 1), 45))
    assert found(turned, (-3, 0, 0), (1, 0, 0)) == [
        (pytest.approx(3 - 2**0.5), True, 0),
        (pytest.approx(3 + 2**0.5), False, 1),
    ]
    assert found(box, (-2, 0, 0), (1, 1, 0)) == []  # through an edge
    assert found(box, (1, 0, -5), (0, 0, 1)) == [
        (4, True, 4),
        (6, False, 5),
    ]  # within x = 1, as if that stood further out
    assert found(box, (-1, 0, -5), (0, 0, 1)) == []
    assert found(Item("Sphere", {"radius": 5, "center": (0, 0, 0)}), (5, -9, 0), (0, 1, 0)) == []
    wedge = {
        "start": (0, 0, 0),
        "end": (0, 0, 1),
        "radius": 2,
        "start_angle": 15,
        "end_angle": 75,
        "reference": (1, 0, 0),
    }
    # the diagonal of the wedge, from the axis on, and its walls from beside
    assert found(Item("Cylinder", wedge), (0, 0, 0.5), (1, 1, 0)) == [(0, True, 3), (pytest.approx(2**0.5), False, 0)]


def test_roots_that_agree_to_many_digits_are_told_apart():
    """x² + y² + 2^-k z² <= 1 and x² + y² <= 1 along x, at z = 1: they differ by 2^-(k + 1) of their place."""
    tube = Item("Quadric", {"coefficients": {"xx": 1, "yy": 1, "constant": -1}})
    for size, expected in ((2.0**-100, [0, 1, 2, 3]), (2.0**-1000, [0, 1, 2, 3]), (0.0, [0, 1])):
        other = Item("Quadric", {"coefficients": {"xx": 1, "yy": 1, "zz": size, "constant": -1}})
        both = Trace(Table(bodies([other, tube])), np.array([[-5.0, 0, 1]]), np.array([[1.0, 0, 0]]))
        assert both.order.group[0].tolist() == expected
        if size:
            assert compare(both.lines, 0, (0, 0), (0, 1)) == 1
            assert compare(both.lines, 0, (1, 0), (1, 1)) == -1
    joined = Item(
        "Quadric", {"coefficients": {"xx": 1, "yy": 1, "zz": 1, "z": -1, "constant": -1}}
    )  # in common where z = 0 or 1
    both = Trace(Table(bodies([joined, tube])), np.array([[-5.0, 0, 1]]), np.array([[1.0, 0, 0]]))
    assert both.order.group[0].tolist() == [0, 0, 1, 1]


def as_case(item: Item) -> Case:
    return Case(item.kind, item.parameters, (0.0, 0.0, 0.0), 8.0, steps=item.steps)


@pytest.mark.parametrize("kind", sorted(set(PLAIN) - {"Spheres"}))
def test_the_other_oracle_agrees(kind):
    """That of the exactness suite: one ray at a time, irrational numbers to 3000 bits and what is near is equal."""
    compared = 0
    for number_ in range(3):
        r = generator(f"agree {kind}", number_)
        item = plain(r, kind).moved(*motion(r))
        shape, table = exact_shape(as_case(item)), Table(bodies([item]))
        origins, directions = lattice_rays(r, [item], 40)
        mine = Trace(table, origins, directions)
        c = mine.crossings
        for i in range(len(origins)):
            rows = range(int(c.offsets[i]), int(c.offsets[i + 1]))
            other = crossings(shape, ExactRay(origins[i], directions[i]))
            assert [(bool(c.entering[k]), int(c.face[k])) for k in rows] == [(x.entering, x.face) for x in other], (
                item,
                origins[i],
                directions[i],
            )
            for k, x in zip(rows, other, strict=True):
                ball = mine.ball(int(c.slope[k]), int(c.surface[k]), i)
                assert abs(float(ball.mid()) - as_pair(x.root)[0]) <= 1e-12 * (1 + abs(as_pair(x.root)[0]))
                compared += 1
        points = origins + directions
        assert body_at(table, points).tolist() == [shape.body_at(p) for p in points]
    assert compared > 3
