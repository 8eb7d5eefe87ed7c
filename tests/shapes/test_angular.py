"""Tubes, polycones, parts of balls, trapezoids, wedges, prisms, pyramids, parallelepipeds, cones with angles.

NumPy decides points in cylindrical or spherical coordinates. Volumes and areas are those of textbooks.
"""

import itertools
import math

import numpy as np
import pytest

import conicoid as co

from ..samples import sampled

DEG = math.pi / 180
COUNT = 10_000
TURNS = [
    (0, 360),
    (20, 110),
    (-30, 150),
    (45, 225),
    (100, 370),
    (-200, 30),
    (350, 380),
    (719.5, 720),
    (0, 0.25),
    (7.3, 367.3),
]
"""Pairs of angles: a turn, less and more than half a turn, half, negative, beyond a turn, next to nothing."""
POLAR = [
    None,
    (0, 90),
    (90, 180),
    (0, 30),
    (30, 90),
    (150, 180),
    (30, 150),
    (20, 70),
    (100, 160),
    (60, 135),
    (0, 179.5),
    (89.5, 90.5),
]


def points_in(shape, seed=3):
    low, high = (np.array(end) for end in shape.bounds)
    margin = 0.05 * (high - low)
    return np.random.default_rng(seed).uniform(low - margin, high + margin, (COUNT, 3))


def cylindrical(p):
    return np.hypot(p[:, 0], p[:, 1]), np.degrees(np.arctan2(p[:, 1], p[:, 0])), p[:, 2]


def within(angle, turn):
    return (angle - turn[0]) % 360 <= turn[1] - turn[0]


def agrees(shape, inside):
    p = points_in(shape)
    expected = inside(p)
    assert 20 < expected.sum() < COUNT - 20
    assert np.array_equal(co.Scene([shape]).contains(p), expected)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("bore", [0, 0.5, 0.97])
def test_tubes_equal_their_formula(turn, bore):
    def inside(p):
        r, angle, z = cylindrical(p)
        return (r >= bore) & (r <= 1) & (z >= -1) & (z <= 2) & within(angle, turn)

    agrees(co.Tube((0, 0, -1), (0, 0, 2), bore, 1, *turn, (1, 0, 0)), inside)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("radii", [(2, 0.5), (0, 1.5), (1, 1)])
def test_cones_with_angles_equal_their_formula(turn, radii):
    def inside(p):
        r, angle, z = cylindrical(p)
        return (r <= radii[0] + (radii[1] - radii[0]) * z / 3) & (z >= 0) & (z <= 3) & within(angle, turn)

    agrees(co.Cone((0, 0, 0), (0, 0, 3), *radii, *turn, (1, 0, 0)), inside)


@pytest.mark.parametrize(("polar", "turn"), sampled(itertools.product(POLAR, TURNS), 7))
def test_parts_of_balls_equal_ranges_of_spherical_coordinates(turn, polar):
    low, high = polar or (0, 180)
    for inner in (0, 0.6):
        shape = co.SphereSection(2, inner, polar, *turn)

        def inside(p, inner=inner):
            r = np.linalg.norm(p, axis=1)
            theta = np.degrees(np.arccos(p[:, 2] / r))
            return (r >= inner) & (r <= 2) & (theta >= low) & (theta <= high) & within(cylindrical(p)[1], turn)

        agrees(shape, inside)


STACK = [(-3, 0, 2), (-1, 0.5, 2), (-1, 1, 3), (0, 1, 1), (1, 0.5, 1.5), (1, 0, 0.5), (2, 0, 0)]


@pytest.mark.parametrize("turn", TURNS)
def test_polycones_lie_between_their_sections(turn):
    def inside(p):
        r, angle, z = cylindrical(p)
        found = np.zeros(len(p), bool)
        for (z0, a, b), (z1, c, d) in itertools.pairwise(STACK):
            if z0 < z1:
                t = (z - z0) / (z1 - z0)
                found |= (t >= 0) & (t <= 1) & (r >= a + (c - a) * t) & (r <= b + (d - b) * t)
        return found & within(angle, turn)

    agrees(co.Polycone(STACK, *turn), inside)


def test_a_polycone_of_two_sections_is_a_hollow_cone():
    rays = np.random.default_rng(1).normal(size=(500, 3)) * 2, np.random.default_rng(2).normal(size=(500, 3))
    hollow = co.Cone((0, 0, 0), (0, 0, 2), 2, 3) - co.Cone((0, 0, 0), (0, 0, 2), 1, 2.5)
    found, expected = (co.Scene([shape]).spans(*rays) for shape in (co.Polycone([(0, 1, 2), (2, 2.5, 3)]), hollow))
    assert np.array_equal(found.t_enter, expected.t_enter)
    assert np.array_equal(found.t_exit, expected.t_exit)


def between(p, low, high, z0, z1, shift=(0, 0)):
    """Return rectangles `low` about the axis at z0, `high` about a shifted place at z1."""
    t = (p[:, 2] - z0) / (z1 - z0)
    found = (t >= 0) & (t <= 1)
    for i in (0, 1):
        found &= abs(p[:, i] - t * shift[i]) <= (low[i] + (high[i] - low[i]) * t) / 2
    return found


@pytest.mark.parametrize(
    ("bottom", "top", "shift"),
    [((4, 10), (12, 5), (0, 0)), ((3, 2), (0, 0), (1, -2)), ((0, 3), (4, 2), (0.3, 7)), ((0, 3), (2, 0), (1, 1))],
)
def test_trapezoids_are_rectangles_at_each_height(bottom, top, shift):
    shape = co.Trapezoid(bottom, top, (-1, 2.5), shift)
    agrees(shape, lambda p: between(p, bottom, top, -1, 2.5, shift))


@pytest.mark.parametrize(("edge", "shift"), [(None, 0), (1, 0), (5, 1), (0, -3), (3, 1.5)])
def test_wedges_are_rectangles_that_end_in_an_edge(edge, shift):
    shape = co.Wedge(3, 2, 1.5, edge, shift)
    agrees(shape, lambda p: between(p, (3, 2), (3 if edge is None else edge, 0), 0, 1.5, (0, shift)))


@pytest.mark.parametrize(
    ("to", "start", "sides"),
    sampled(itertools.product(["corners", "sides"], [0, 30, -45, 12.5, 400], [3, 4, 5, 6, 7, 12, 101]), 8),
)
def test_prisms_and_pyramids_keep_within_their_sides(sides, start, to):
    step = 360 / sides
    apothem = math.cos(step / 2 * DEG) if to == "corners" else 1

    def inside(p, top, low, high):
        r, angle, z = cylindrical(p)
        across = r * np.cos(((angle - start) % step - step / 2) * DEG)
        return (z >= low) & (z <= high) & (across <= 1.5 * apothem * (1 + (top - 1) * (z - low) / (high - low)))

    agrees(co.RegularPrism(sides, 1.5, (-1, 2), start, to), lambda p: inside(p, 1, -1, 2))
    agrees(co.Pyramid(sides, 1.5, (0, 2), 0, start, to), lambda p: inside(p, 0, 0, 2))
    agrees(co.Pyramid(sides, 1.5, (0, 2), 1.95, start, to), lambda p: inside(p, 1.3, 0, 2))


def test_a_parallelepiped_is_the_cube_carried():
    corner, edges = np.array([1, -2, 0.5]), np.array([[2, 0.5, 0], [-1, 1, 0.3], [0.2, -0.7, -3]])

    def inside(p):
        share = (p - corner) @ np.linalg.inv(edges)
        return ((share >= 0) & (share <= 1)).all(axis=1)

    agrees(co.Parallelepiped(corner, *edges), inside)


@pytest.mark.parametrize("kind", ["tube", "cone", "section", "polycone"])
def test_angles_grow_counter_clockwise_about_the_axis(kind):
    """The axis of a quarter is y and its angle 0 is towards z: y × z = x, so that it lies at z > 0, x > 0."""
    start, end, reference = (0, 0, 0), (0, 4, 0), (0, 1, 5)
    shape = {
        "tube": lambda: co.Tube(start, end, 1, 2, 0, 90, reference),
        "cone": lambda: co.Cone(start, end, 2, 2, 0, 90, reference),
        # z to y, x to z: a third of a turn about (1, 1, 1), backwards
        "section": lambda: co.SphereSection(2, 1, (0, 90), 0, 90).rotate((1, 1, 1), -120),
        "polycone": lambda: co.Polycone([(0, 1, 2), (4, 1, 2)], 0, 90).rotate((1, 1, 1), -120),
    }[kind]()
    places = [(x, 0.5, z) for x in (-1, 1) for z in (-1, 1)]
    assert co.Scene([shape]).contains(places).tolist() == [False, False, False, True]
    assert np.array(shape.bounds).tolist() == [[0, 0, 0], [2, 2 if kind == "section" else 4, 2]]


def test_bounds_of_parts_end_where_the_parts_do():
    """The widest place is at an end of a range, or where the range passes an axis. Bounds are by hand."""
    half, root = 0.5, math.sqrt(0.75)
    cases = [
        (co.SphereSection(2, 1, (60, 90)), (-2, -2, 0), (2, 2, 1)),
        (co.SphereSection(2, 1, (0, 60)), (-2 * root, -2 * root, half), (2 * root, 2 * root, 2)),
        (co.SphereSection(2, 1, (90, 120), 0, 30), (root * root, 0, -1), (2, 1, 0)),
        (co.SphereSection(2, 1, (60, 120), 120, 210), (-2, -1, -1), (-half * root, 2 * root, 1)),
        (co.Tube((0, 0, 0), (0, 0, 1), 1, 2, -30, 60, (1, 0, 0)), (half, -1, 0), (2, 2 * root, 1)),
        (co.Cone((0, 0, 0), (0, 0, 1), 2, 1, 150, 210, (1, 0, 0)), (-2, -1, 0), (0, 1, 1)),
        (co.Polycone([(-1, 0, 1), (0, 0, 3), (0, 1, 2), (2, 2, 2)], 30, 90), (0, 0, -1), (3 * root, 3, 2)),
        (co.Trapezoid((4, 2), (2, 3), (-1, 2), (2, 0)), (-2, -1.5, -1), (3, 1.5, 2)),
        (co.Wedge(4, 2, 1, 6, -3), (-3, -3, 0), (3, 1, 1)),
        (co.RegularPrism(6, 2, (0, 1), 30), (-2 * root, -2, 0), (2 * root, 2, 1)),
        (co.Pyramid(4, 1, (0, 1), 0.5), (-1, -1, 0), (1, 1, 1)),
        (co.Parallelepiped((1, 1, 1), (2, 0, 0), (-1, 1, 0), (0, 0, -3)), (0, 1, -2), (3, 2, 1)),
    ]  # fmt: skip
    for shape, low, high in cases:
        assert np.allclose(np.array(shape.bounds), (low, high), rtol=1e-15, atol=1e-15), shape


def volume_and_area(shape):
    found = co.measure(shape)
    assert found.volume_error == found.area_error == 0
    return found.volume, found.area


def test_volumes_and_areas_of_textbooks():
    """Bronshtein and Semendyayev, Handbook of Mathematics, 3.3: solids. A sector of a ball is 2π R² h / 3."""
    cases = [
        (co.Tube((1, 2, 3), (4, 6, 3), 1, 2), 3 * math.pi * 5, 2 * math.pi * 3 * 5 + 6 * math.pi),
        (co.Tube((0, 0, 0), (0, 0, 5), 1, 2, 0, 90, (1, 0, 0)), 15 * math.pi / 4, 7.5 * math.pi + 1.5 * math.pi + 10),
        (co.Cone((0, 0, 0), (0, 0, 4), 3, 0, 0, 180, (1, 0, 0)), 6 * math.pi, 7.5 * math.pi + 4.5 * math.pi + 12),
        (co.SphereSection(3, polar_range=(0, 90)), 18 * math.pi, 27 * math.pi),
        (co.SphereSection(3, polar_range=(0, 60)), 2 * math.pi * 9 * 1.5 / 3, 9 * math.pi + math.pi * 3 * 3 * math.sqrt(0.75)),
        (co.SphereSection(3, 1), 4 / 3 * math.pi * 26, 4 * math.pi * 10),
        (co.SphereSection(3, start_angle=10, end_angle=55), 36 * math.pi / 8, 36 * math.pi / 8 + 9 * math.pi),
        (co.Polycone([(0, 0, 1), (1, 0, 1), (1, 1, 2), (2, 1, 2)]), math.pi + 3 * math.pi, math.pi * (1 + 2 + 3 + 3 + 1 + 2 + 4)),
        (co.Trapezoid((2, 2), (0, 0), (0, 3)), 4, 4 + 4 * math.sqrt(10)),
        (co.Wedge(4, 3, 2, 1), 3 * 2 * (2 * 4 + 1) / 6, 12 + 3 * math.hypot(2, 1.5) + 5 * math.hypot(2, 1.5)),
        (co.RegularPrism(6, 2, (0, 5)), 6 * math.sqrt(3) * 5, 12 * math.sqrt(3) + 60),
        (co.RegularPrism(6, 1, (0, 5), radius_to="sides"), 2 * math.sqrt(3) * 5, 4 * math.sqrt(3) + 20 * math.sqrt(3)),
        (co.Pyramid(4, math.sqrt(2), (0, 3)), 4, 4 + 4 * math.sqrt(10)),
        (co.Pyramid(4, math.sqrt(8), (0, 1), math.sqrt(2)), (16 + 8 + 4) / 3, 20 + 12 * math.sqrt(2)),
    ]  # fmt: skip
    for shape, volume, area in cases:
        assert volume_and_area(shape) == pytest.approx((volume, area), rel=1e-13), shape


def test_the_volume_of_a_parallelepiped_is_the_triple_product():
    a, b, c = np.array([(2, 0, 0), (1, 3, 0), (1, 1, -4)], float)
    faces = 2 * sum(np.linalg.norm(np.cross(u, v)) for u, v in ((a, b), (b, c), (c, a)))
    assert volume_and_area(co.Parallelepiped((5, 5, 5), a, b, c)) == pytest.approx((24, faces), rel=1e-13)


@pytest.mark.parametrize(
    "shape",
    [
        co.Tube((0, 0, 0), (0, 1, 2), 1, 2, 20, 250, (3, 0, 0)), co.Cone((0, 0, 0), (0, 0, 2), 1, 2, 0, 90, (1, 0, 0)),
        co.SphereSection(2, 1, (30, 120), 20, 220), co.Polycone(STACK, 10, 210), co.Trapezoid((4, 10), (0, 3), (-7, 7), (1, 2)),
        co.Wedge(4, 2, 1, 2, 1), co.RegularPrism(5, 1, (0, 1), 10, "sides"), co.Pyramid(7, 2, (0, 3), 1, 12),
        co.Parallelepiped((0, 0, 0), (1, 0, 0), (0.5, 1, 0), (0.2, 0.3, 1)), co.Revolution([(0, 0), (2, 0), (1, 1), (0, 2)], 20, 300),
    ],
    ids=lambda shape: type(shape).__name__,
)  # fmt: skip
def test_closed_forms_equal_sums_of_rays(shape):
    """Centroid and inertia of moved solids, too, are within five standard errors of chords."""
    moved = shape.rotate((1, 2, 3), 40).translate((1, 2, 3))
    closed, sampled = co.measure(moved), co.measure(moved & co.Sphere(60), rays=6_000)
    assert closed.volume_error == 0
    for name in ("volume", "area", "centroid", "inertia"):
        difference = np.abs(getattr(closed, name) - getattr(sampled, name))
        assert (difference <= 5 * getattr(sampled, f"{name}_error") + 1e-12).all(), name
