"""Rays and intervals that were once answered wrongly, as they were reported."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..reference.intervals import Interval
from ..reference.items import Item, combined
from ..reference.judge import Judge
from ..samples import in_turn

INF = float("inf")
ABOUT_Z = ("rotate", (0.0, 0.0, 1.0), 15.0)
CONE = Item("Cone", {"start": (0.0, 0.0, -1.0), "end": (0.0, 0.0, 1.0), "start_radius": 2.0, "end_radius": 1.0})
TUBE = Item("Cylinder", {"start": (0.0, 0.0, -1.0), "end": (0.0, 0.0, 1.0), "radius": 1.0})
WEDGE = Item("Cylinder", {**TUBE.parameters, "start_angle": 0.0, "end_angle": 120.0, "reference": (1.0, 0.0, 0.0)})
ROUND = (
    TUBE,
    Item("Ellipsoid", {"radii": (1.0, 1.0, 0.5)}),
    Item("DoubleCone", {"slope": 1.0}),
    Item("EllipticParaboloid", {"A": 1.0, "E": 1.0}),
    Item("OneSheetHyperboloid", {"A": 1.0, "E": 1.0, "H": 1.0}),
    WEDGE,
    combined("Difference", TUBE, Item("Box", {"low": (0.0, 0.0, 0.0), "high": (2.0, 2.0, 2.0)})),
)


def comparison(items, origin, direction):
    judge = Judge(co, items)
    return judge, judge.rays(np.array([origin], float), np.array([direction], float))


def check(items, origin, direction) -> Any:
    judge, one = comparison(items, origin, direction)
    good = one.lists()
    one.first()
    one.spans(good)
    judge.score.check()
    return one


@pytest.mark.parametrize("degrees", [0, 15, 16, 30, 45, 75, 105, 165])
def test_a_cone_is_met_through_its_rim(degrees):
    found = co.Scene([co.Cone((0, 0, -1), (0, 0, 1), 2, 1).rotate((0, 0, 1), degrees)]).crossings(
        (2, 3, 3), (-2, -2, -2), t_min=-9
    )
    assert np.allclose(found.t, [1, 13 / 7], rtol=1e-15)
    assert found.entering.tolist() == [True, False]


@pytest.mark.parametrize(("item", "degrees"), in_turn(ROUND, [15.0, 105.0]))
def test_touching_what_is_turned_about_its_own_axis(item, degrees):
    """The ray (5, -1, 0) -> (-1, 0, 0) and others like it touch the shape or run along it."""
    turned = item.moved(("rotate", (0.0, 0.0, 1.0), degrees))
    for height in (0.0, 0.5, 1.0, -1.0):
        for x, y in ((-1.0, 0.0), (0.0, -1.0), (-1.0, -1.0), (2.0, -1.0)):
            for side in (1.0, -1.0):
                away = np.array([-y, x, 0.0]) * side
                check([turned], np.array([0.0, 0.0, height]) + away - 5 * np.array([x, y, 0.0]), (x, y, 0.0))


@pytest.mark.parametrize("degrees", [*range(1, 180, 13), 15, 105, 0.5, 33.3, 1e-3])
def test_any_turn_about_the_own_axis_leaves_a_cylinder_as_it_is(degrees):
    """Rulings and tangents at lattice points: those of the cylinder that is not turned."""
    turned = TUBE.moved(("rotate", (0.0, 0.0, 1.0), float(degrees)), paper=())
    for origin, direction in (
        ((5, -1, 0), (-1, 0, 0)),
        ((1, 0, 5), (0, 0, -1)),
        ((5, -1, 1), (-1, 0, 0)),
        ((-1, 1, -3), (1, -1, 1)),
        ((3, 4, -3), (-1, -1, 1)),
    ):
        check([turned], origin, direction)


@pytest.mark.parametrize(
    ("item", "origin", "direction"),
    [
        (Item("DoubleCone", {"slope": 2.0, "z_range": (-1.0, 2.0)}, (("scale", 2.0), ABOUT_Z)), (4, -4, 0), (-1, -1, -1)),
        (Item("DoubleCone", {"slope": 2.0, "z_range": (-1.0, 2.0)}, (("scale", 2.0), ABOUT_Z)), (-4, -2, -4), (0, -1, -1)),
        (Item("EllipticParaboloid", {"A": 1.0, "E": 1.0, "z_range": (1.0, INF)}, (ABOUT_Z, ("scale", (1.0, 2.0, 1.0)))), (1, -1.5, 1.5), (0, 3, -1)),
        (Item("OneSheetHyperboloid", {"A": 1.0, "E": 1.0, "H": 4.0}, (("rotate", (0.0, 0.0, 1.0), -75.0),)), (-2, 0, 1), (-2, 0, 1)),
        (Item("CylinderPatch", {"start": (0.0, 0.0, 0.0), "end": (0.0, 0.0, 1.0), "radius": 1.25, "start_angle": 0.0, "end_angle": 300.0, "reference": (0.0, -3.0, -3.0)}, (("rotate", (0.0, 0.0, 1.0), -75.0),)), (2, -2, 1), (-1, 1, 0)),
    ],
    ids=["apex", "cap", "bound", "asymptote", "patch"],
)  # fmt: skip
def test_what_is_rational_on_paper(item, origin, direction):
    check([item], origin, direction)


def half_space(normal, offset) -> Item:
    return Item("HalfSpace", {"normal": normal, "offset": offset})


def test_an_interval_of_a_few_floats_about_a_crossing():
    """Planes that meet there: hit and occluded are one answer."""
    items = [
        half_space((2.0, -2.0, -2.0), -4.0),
        combined("Union", half_space((2.0, 2.0, -1.0), -2.0), half_space((-1.0, 2.0, 0.0), 0.0)),
    ]
    judge, one = comparison(items, (5, -3, 7), (-5, 3, -5))
    good = one.lists()
    one.first()
    floats = [1.0]
    for _ in range(3):
        floats = [np.nextafter(floats[0], 0), *floats, np.nextafter(floats[-1], 2)]
    for i, low in enumerate(floats):
        for high in floats[i:]:
            Interval(one, good, np.array([low]), np.array([high])).judge()
    judge.score.check()


def test_a_wall_that_rounding_takes_beyond_all_sizes():
    """Of the ray's direction 3.4e-21 lies along an axis that bends: the ray hits a body without an end at 3e20."""
    matrix = ((1.0, 0.0, 0.0, -1.0), (0.0, 1.0, 1.0, 0.0), (0.0, 0.0, 1.0, -1.0), (0.0, 0.0, 0.0, 1.0))
    body = Item(
        "Quadric",
        {"coefficients": dict(xx=0.0, yy=0.0, zz=0.0, xy=-1.0, yz=0.0, xz=0.0, x=0.0, y=-2.0, z=0.0, constant=-2.0)},
        (("transform", matrix), ("rotate", (1.0, 1.0, 0.0), 180.0)),
    )
    check([body], (-3, 0, 3.0000000000000027), (1, -3.3881317890172014e-21, -1))


def test_a_ball_is_left_behind_just_beyond_the_origin():
    """At t = 6.9e-19, where the roots of the fast formulas lie behind: lists of rays are to doubt it, by themselves and in packets."""
    ball = Item("Sphere", {"radius": 3.0, "center": (-2.0, 1.0, 0.0)})
    for copies in (1, 80):
        judge = Judge(co, [ball])
        origin, direction = (-1.734723475976807e-18, -1, -1), (1, -1.0000009536743164, -1)
        one = judge.rays(
            np.tile(np.array(origin, float), (copies, 1)), np.tile(np.array(direction, float), (copies, 1))
        )
        good = one.lists()
        one.first()
        for low in (0.0, 5e-324, 6.9e-19, -5e-324):
            Interval(one, good, np.full(copies, low), np.full(copies, np.inf)).judge()
        judge.score.check()


def test_an_empty_interval_is_never_doubtful():
    scene = co.Scene([co.Box((0, -2, 0), (4, 4, 2))])
    origins, directions = np.tile((1.0, 1.0, 2.0), (3000, 1)), np.tile((-1.0, 1.0, -2.0), (3000, 1))
    for end in (0.0, -5e-324, 1.0):
        for hits in (
            scene.first_hit(origins, directions, end, end),
            scene.first_hit(origins[0], directions[0], end, end),
        ):
            assert not np.isfinite(hits.t).any()
            assert not np.any(hits.doubtful)


def test_streams_doubt_what_a_ray_alone_does_in_an_interval_below_every_number():
    scene = co.Scene([co.Disc((1, 0, -0.5), (-1, 1, -2), 3)])
    origins, directions = np.tile((1.0, 0.0, -0.5), (33 * 64, 1)), np.tile((0.0, -1.0, -1.0), (33 * 64, 1))
    origins[1::2] += (0.0, 50.0, 0.0)  # in no order, so that they make a stream
    for low, high in ((-1e-323, -5e-324), (-5e-324, 0.0), (-5e-324, 5e-324), (0.0, 5e-324)):
        alone = scene.first_hit(origins[0], directions[0], low, high)
        stream = scene.first_hit(origins, directions, low, high)
        assert (stream.t[::2] == alone.t).all()
        assert (stream.doubtful[::2] == alone.doubtful).all()
