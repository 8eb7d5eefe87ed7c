"""Faces of tubes, parts of balls, polycones and flat solids: numbers, normals and uv by formulas, and common walls."""

import itertools
import math

import numpy as np
import pytest

import conicoid as co

DEG = math.pi / 180
TURNS = [(0, 360), (20, 110), (-30, 150), (100, 370), (-200, 30)]


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


@pytest.mark.parametrize("turn", TURNS)
def test_faces_of_tubes(turn):
    shape = co.Tube((0, 0, 0), (0, 0, 3), 0.75, 1.5, *turn, (1, 0, 0))
    ends = {1: level(-1, 1.5), 2: level(1, 1.5)}
    follow(shape, {0: side(0, 0, 3), 5: side(0, 0, 3, -1), **ends, **walls(turn, 3, 1.5, 3)})


@pytest.mark.parametrize("turn", TURNS)
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


@pytest.mark.parametrize("turn", TURNS)
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


@pytest.mark.parametrize("turn", TURNS)
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
