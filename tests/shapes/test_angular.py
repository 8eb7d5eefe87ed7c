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


@pytest.mark.parametrize("inner", [0, 0.6])
@pytest.mark.parametrize(("polar", "turn"), sampled(itertools.product(POLAR, TURNS), 7))
def test_parts_of_balls_equal_ranges_of_spherical_coordinates(turn, polar, inner):
    low, high = polar or (0, 180)
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


# --- Faces of tubes, parts of balls, polycones and flat solids: numbers, normals and uv by formulas, and common walls


RANGES = [(0, 360), (20, 110), (-30, 150), (100, 370), (-200, 30)]


def hits_of(shape, count=4000):
    """Return hits from all sides, and from within."""
    low, high = (np.array(end) for end in shape.bounds)
    random = np.random.default_rng(8)
    targets, directions = random.uniform(low, high, (count, 3)), random.normal(size=(count, 3))
    origins = targets - directions * np.where(random.random(count) < 0.6, 5, 0)[:, None]
    hits = co.Scene([shape]).first_hit(origins, directions)
    return hits[hits.hit]


def follow(shape, formulas, most=1e-12):
    """Assert that every face has the normal and the uv of its formula, a function of points (n, 3)."""
    hits = hits_of(shape)
    assert set(hits.face.tolist()) == set(formulas), shape
    for face, formula in formulas.items():
        here = hits.face == face
        p = hits.point[here]
        normal, u, v = formula(p)
        assert np.allclose(hits.normal[here], normal, rtol=0, atol=most), (shape, face)
        difference = hits.uv[here] - np.stack([u, v], axis=1)
        difference[:, 0] -= np.round(difference[:, 0]) if face in ROUND.get(type(shape), ()) else 0
        assert np.abs(difference).max() <= 1e-9, (shape, face)


ROUND = {co.Tube: (0, 5), co.Cone: (0,), co.SphereSection: (0, 1, 2, 3), co.Polycone: range(12)}
"""Faces whose u goes around: 0 and 1 are the same."""


def radius(p):
    return np.hypot(p[:, 0], p[:, 1])


def turns(p):
    return np.arctan2(p[:, 1], p[:, 0]) / (2 * math.pi) % 1


def walls(turn, first, r, h, z0=0):
    """Return the walls: at both angles, one at half a turn, none around."""
    found = {}
    for k, (angle, sense) in enumerate(zip(turn, (1, -1), strict=True)):
        s, c = math.sin(angle * DEG), math.cos(angle * DEG)
        found[first + k] = lambda p, s=s, c=c, sense=sense: (
            np.tile([sense * s, -sense * c, 0], (len(p), 1)), (p[:, 0] * c + p[:, 1] * s) / r, (p[:, 2] - z0) / h,
        )  # fmt: skip
    width = turn[1] - turn[0]
    return {} if width == 360 else {first: found[first]} if width == 180 else found


def level(sense, r):
    return lambda p: (np.tile([0, 0, sense], (len(p), 1)), p[:, 0] / r, p[:, 1] / r)


def side(slope, low, high, sense=1):
    """Return a cone or cylinder whose radius grows by `slope`."""

    def formula(p):
        out = np.column_stack([p[:, 0] / radius(p), p[:, 1] / radius(p), np.full(len(p), -slope)]) * sense
        return out / math.hypot(1, slope), turns(p), (p[:, 2] - low) / (high - low)

    return formula


@pytest.mark.parametrize("turn", RANGES)
def test_faces_of_tubes(turn):
    shape = co.Tube((0, 0, 0), (0, 0, 3), 0.75, 1.5, *turn, (1, 0, 0))
    ends = {1: level(-1, 1.5), 2: level(1, 1.5)}
    follow(shape, {0: side(0, 0, 3), 5: side(0, 0, 3, -1), **ends, **walls(turn, 3, 1.5, 3)})


@pytest.mark.parametrize("turn", RANGES)
def test_faces_of_cones_with_angles(turn):
    shape = co.Cone((0, 0, 0), (0, 0, 3), 0.5, 2, *turn, (1, 0, 0))
    follow(shape, {0: side(0.5, 0, 3), 1: level(-1, 0.5), 2: level(1, 2), **walls(turn, 3, 2, 3)})


def polar_wall(angle, sense, inner, outer):
    """Return the cone of a polar angle, or a plane."""
    if angle == 90:
        return level(-sense, outer)
    s, c = math.sin(angle * DEG), math.cos(angle * DEG)
    low, high = sorted((inner * c, outer * c))

    def formula(p):
        out = np.column_stack([c * p[:, 0] / radius(p), c * p[:, 1] / radius(p), np.full(len(p), -s)])
        return sense * out, turns(p), (p[:, 2] - low) / (high - low)

    return formula


@pytest.mark.parametrize("turn", RANGES)
@pytest.mark.parametrize("polar", [(0, 180), (30, 120), (90, 150), (50, 90), (20, 160), (100, 180)])
def test_faces_of_parts_of_balls(turn, polar):
    shape = co.SphereSection(2, 1, polar, *turn)
    formulas = {
        0: lambda p: (p / 2, turns(p), (p[:, 2] + 2) / 4),
        1: lambda p: (-p, turns(p), (p[:, 2] + 1) / 2),
        **walls(turn, 4, 2, 2),
    }
    formulas |= {2: polar_wall(polar[0], -1, 1, 2)} if polar[0] > 0 else {}
    formulas |= {3: polar_wall(polar[1], 1, 1, 2)} if polar[1] < 180 else {}
    if sum(polar) == 180 and polar[0]:
        upper, lower = (polar_wall(angle, sense, -2, 2) for angle, sense in zip(polar, (-1, 1), strict=True))
        del formulas[3]
        formulas[2] = lambda p: (np.where(p[:, 2:] > 0, upper(p)[0], lower(p)[0]), *upper(p)[1:])
    if 90 in polar:
        formulas[2 + polar.index(90)] = level(1 if polar[0] == 90 else -1, 2)
    follow(shape, formulas)


@pytest.mark.parametrize("turn", RANGES)
def test_faces_of_polycones(turn):
    """Two stretches stand about a step: outer sides 0 and 2, inner 3 and 5, level 6 to 9, walls 10 and 11."""
    shape = co.Polycone([(0, 0.5, 1), (1, 0.5, 2), (1, 1, 1.5), (2, 0.25, 1.5)], *turn)
    formulas = {0: side(1, 0, 1), 2: side(0, 1, 2), 3: side(0, 0, 1, -1), 5: side(-0.75, 1, 2, -1)}
    formulas |= {6: level(-1, 2), 7: level(1, 2), 9: level(1, 2), **walls(turn, 10, 2, 2)}
    follow(shape, formulas)


def test_stretches_in_one_line_keep_their_numbers():
    shape = co.Polycone([(0, 0.5, 1), (1, 0.75, 1), (2, 1, 1), (3, 1, 1.5)])
    outer = {0: side(0, 0, 1), 1: side(0, 1, 2), 2: side(0.5, 2, 3)}
    inner = {3: side(0.25, 0, 1, -1), 4: side(0.25, 1, 2, -1), 5: side(0, 2, 3, -1)}
    follow(shape, {**outer, **inner, 6: level(-1, 1.5), 9: level(1, 1.5)})


def test_edges_of_a_revolution_in_one_line_keep_their_numbers():
    scene = co.Scene([co.Revolution([(0.5, 0), (1, 0), (1, 1), (1, 2), (0.5, 2), (0.5, 1)])])
    hits = scene.first_hit([(0, 0, 0.5), (0, 0, 1.5), (5, 0, 0.5), (5, 0, 1.5)], [(1, 0, 0)] * 2 + [(-1, 0, 0)] * 2)
    assert hits.face.tolist() == [5, 4, 1, 2]
    assert hits.uv[:, 1].tolist() == [0.5] * 4


def flat(normal, u, v):
    """Return a plane's normal, of any length, and uv as rows (a, b, c, d)."""
    unit = np.array(normal, float) / np.linalg.norm(normal)
    return lambda p: (np.tile(unit, (len(p), 1)), p @ u[:3] + u[3], p @ v[:3] + v[3])


X, Y, Z = (np.array(row) for row in ([0.25, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, 0.5, 0]))
ACROSS, UP = np.array([0, 1 / 3, 0, 0.5]), np.array([0, 0, 1 / 3, 1 / 3])
FLAT_FACES = {  # a solid, and of each of its faces the normal, u and v
    "a trapezoid, as a box": (  # from 4 by 2 at z = -1 to 2 by 3 about (1, 0) at z = 2: x from -2 to 2, y from -1.5 to 1.5
        co.Trapezoid((4, 2), (2, 3), (-1, 2), (1, 0)),
        [((-3, 0, 2), ACROSS, UP), ((1, 0, 0), ACROSS, UP), ((0, -3, -0.5), X, UP), ((0, 3, -0.5), X, UP),
         ((0, 0, -1), X, ACROSS), ((0, 0, 1), X, ACROSS)],
    ),
    "a wedge": (  # a ramp, its upright side at y = 1
        co.Wedge(4, 2, 2, edge_shift=1),
        [((-1, 0, 0), Y, Z), ((1, 0, 0), Y, Z), ((0, -1, 1), X, Z), ((0, 1, 0), X, Z), ((0, 0, -1), X, Y)],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FLAT_FACES)
def test_flat_faces(name):
    shape, faces = FLAT_FACES[name]
    follow(shape, {k: flat(*face) for k, face in enumerate(faces)})


@pytest.mark.parametrize("sides", [3, 4, 6, 7])
@pytest.mark.parametrize("top", [2, 1, 0])
def test_faces_of_prisms_and_pyramids(sides, top):
    start, low, high = 20, -1, 2
    shape = co.RegularPrism(sides, 2, (low, high), start) if top == 2 else co.Pyramid(sides, 2, (low, high), top, start)
    step, edge = 360 / sides, 4 * math.sin(math.pi / sides)
    lean = (2 - top) * math.cos(math.pi / sides) / 3
    up = np.array([0, 0, 1 / 3, 1 / 3])
    formulas = {}
    for k in range(sides):
        s, c = math.sin((start + (k + 0.5) * step) * DEG), math.cos((start + (k + 0.5) * step) * DEG)
        formulas[k] = flat((c, s, lean), np.array([-s / edge, c / edge, 0, 0.5]), up)
    x, y = np.array([0.5, 0, 0, 0]), np.array([0, 0.5, 0, 0])
    formulas[sides] = flat((0, 0, -1), x, y)
    formulas |= {sides + 1: flat((0, 0, 1), x * 2 / top, y * 2 / top)} if top else {}
    follow(shape, formulas)


def test_faces_of_a_parallelepiped():
    corner, edges = np.array([1.0, 2, 3]), np.array([(2, 0, 0), (0.5, 1, 0), (0.25, 0.5, -2)])
    back = np.linalg.inv(edges.T)
    rows = [np.array([*row, -row @ corner]) for row in back]
    formulas = {}
    for i, row in enumerate(back):
        u, v = (rows[k] for k in range(3) if k != i)
        formulas |= {2 * i: flat(-row, u, v), 2 * i + 1: flat(row, u, v)}
    follow(co.Parallelepiped(corner, *edges), formulas)


def test_hexagons_by_their_sides_share_walls():
    """A ray crosses three pins at their pitch. Where one ends the next begins, to the bit, in all three directions."""
    pitch = 1.26
    for angle in (30, 90, 150):
        way = np.array([math.cos(angle * DEG), math.sin(angle * DEG), 0])
        pins = [
            co.RegularPrism(6, pitch / 2, (0, 1), radius_to="sides").translate(tuple(k * pitch * way)) for k in (0, 1)
        ]
        spans = co.Scene(pins).spans((0, 0, 0.5) - 5 * way, way)
        assert spans.t_exit[0] == pytest.approx(spans.t_enter[1], abs=1e-15)
    stacked = co.Scene(
        [
            co.Polycone([(0, 1, 2), (1, 1, 3)]),
            co.Tube((0, 0, 0), (0, 0, 1), 0.5, 1),
            co.Cylinder((0, 0, 0), (0, 0, 1), 0.5),
        ]
    )
    spans = stacked.spans((-5, 0.3, 0.25), (1, 0, 0))
    assert np.array_equal(np.sort(spans.t_enter)[1:], np.sort(spans.t_exit)[:-1])


def test_shells_touch_the_ball_within_and_the_one_beside():
    """Two ranges with a common angle share its cone, and a shell shares the ball in it: no gap, no overlap."""
    bodies = [co.SphereSection(2, 1, (0, 40)), co.SphereSection(2, 1, (40, 180)), co.Sphere(1)]
    bodies += [
        co.SphereSection(3, 2, start_angle=0, end_angle=77),
        co.SphereSection(3, 2, start_angle=77, end_angle=360),
    ]
    scene = co.Scene(bodies)
    random = np.random.default_rng(4)
    origins, directions = random.normal(size=(2000, 3)), random.normal(size=(2000, 3))
    spans = scene.spans(origins - 20 * directions, directions)
    for first, last in itertools.pairwise(spans.offsets):
        enter, leave = np.sort(spans.t_enter[first:last]), np.sort(spans.t_exit[first:last])
        assert np.array_equal(enter[1:], leave[:-1])
    assert not [finding for finding in co.check(scene) if finding.kind == "overlap"]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: co.Tube((0, 0, 0), (0, 0, 1), 2, 1), "Tube: inner_radius must be < outer_radius = 1, got 2"),
        (lambda: co.Tube((0, 0, 0), (0, 0, 1), 1, 2, 0, 90), "Tube: reference must be given with angles"),
        (lambda: co.Cone((0, 0, 0), (0, 0, 1), 1, 2, 0, 90), "Cone: reference must be given with angles"),
        (lambda: co.SphereSection(1, 1), "SphereSection: inner_radius must be < radius = 1, got 1"),
        (lambda: co.SphereSection(1, polar_range=(-10, 90)), "polar_range must lie within 0 and 180 degrees, got"),
        (lambda: co.SphereSection(1, polar_range=(90, 30)), "polar_range must have low < high"),
        (lambda: co.SphereSection(1, start_angle=0, end_angle=400), r"must be in \(0, 360\]"),
        (lambda: co.Polycone([(0, 1, 2)]), "Polycone: sections must be from 2 to 10,000, got 1"),
        (lambda: co.Polycone([(0, 2, 1), (1, 1, 2)]), r"Polycone: sections\[0\] must have 0 <= inner radius <= outer"),
        (lambda: co.Polycone([(1, 1, 2), (0, 1, 2)]), r"sections\[1\] must rise in z, got 0 above 1"),
        (lambda: co.Polycone([(0, 1, 1), (1, 2, 2)]), "Polycone: sections must enclose a volume"),
        (lambda: co.Polycone(3), "must be two or more of"),
        (lambda: co.Trapezoid((1, 0), (2, 0)), "must not both be 0"),
        (lambda: co.Trapezoid((1, 1), (2, 2), (0, math.inf)), "z_range must be two finite numbers"),
        (lambda: co.Wedge(1, 1, 1, -1), "edge_length must be >= 0"),
        (lambda: co.RegularPrism(2, 1), "sides must be an integer >= 3"),
        (lambda: co.Pyramid(4, 1, radius_to="edges"), "radius_to must be 'corners' or 'sides', got 'edges'"),
        (lambda: co.Parallelepiped((0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 3, 0)), "must not lie in one plane"),
    ],
)
def test_impossible_angles_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_angles_in_radians_are_warned_of():
    with pytest.warns(UserWarning, match=r"polar_range\[1\] must be in degrees"):
        co.SphereSection(1, polar_range=(0, math.pi / 2))
