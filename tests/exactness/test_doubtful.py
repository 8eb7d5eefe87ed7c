"""Hits that depend on a tie, the reach of doubt, and rays whose answers were once wrong."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels import tables as table
from conicoid.kernels.tables import Geometry
from conicoid.queries.exact import doubtful_rays
from conicoid.queries.exact.ranks import count_form_floats

from ..reference.intervals import Interval
from ..reference.items import Item, combined
from ..reference.judge import Judge
from ..reference.routes import in_doubt, ties
from ..samples import in_turn

# --- Which hits depend on a tie, and that doubt reaches every end of a body; rows of them keep the user's interval


BOX = co.Box((0, 0, 0), (1, 1, 1))


def test_rays_through_edges_are_doubtful_others_are_not() -> None:
    scene = co.Scene([BOX])
    random = np.random.default_rng(5)
    places = random.uniform(0.01, 0.99, (4000, 2))
    through_face = np.column_stack([places, np.full(len(places), 3.0)])
    directions = np.array([0.0, 0.0, -1.0]) + random.uniform(-1e-3, 1e-3, (len(places), 3))
    assert not scene.first_hit(through_face, directions).doubtful.any()
    # (2, 0.25, 2) - (1, 0, 1): through the edge x = z = 1, exactly
    edge = scene.first_hit((2.0, 0.25, 2.0), (-1, 0, -1))
    assert edge.doubtful
    assert edge.t == 1.0
    corner = scene.first_hit([[3.0, 3.0, 3.0], [0.5, 0.5, 3.0]], [[-1, -1, -1], [0, 0, -1]])
    assert corner.doubtful.tolist() == [True, False]
    assert corner[::-1].doubtful.tolist() == [False, True]


def test_tangents_are_doubtful() -> None:
    """Rays run along x = 1 beside the unit ball, a unit in the last place nearer (exact methods decide), and inside."""
    scene = co.Scene([co.Sphere()])
    x = [1.0, math.nextafter(1, 0), 0.5]
    hits = scene.first_hit([(value, 0.0, 5.0) for value in x], (0, 0, -1))
    assert hits.doubtful.tolist() == [True, False, False]
    assert in_doubt(scene, hits.rays).tolist() == [True, True, False]
    assert np.isfinite(hits.t).tolist() == [False, True, True]


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("wall", [-1.0, -0.5, 0.5, 1.0])
def test_ends_of_both_spans_of_a_body_near_the_origin(wall: float, direction: float) -> None:
    """The bow tie x² + y² <= z², |z| <= 1 holds z in [-1, -0.5] and [0.5, 1] along x = 0.5, y = 0.

    Rays start from each of the four walls, or one unit in the last place beside it: in packets, in lists and alone.
    """
    scene = co.Scene([co.DoubleCone(z_range=(-1, 1))])
    for z in (math.nextafter(wall, -2), wall, math.nextafter(wall, 2)):
        walls = sorted((w - z) * direction for w in (-1.0, -0.5, 0.5, 1.0))
        ahead = [t for t in walls if t > 0]
        origins = np.tile((0.5, 0.0, z), (8, 32, 1))
        for rays in (origins, origins[0], origins[0, 0]):
            hits = scene.first_hit(rays, (0, 0, direction))
            assert np.all(hits.doubtful == (z == wall))
            assert np.all(in_doubt(scene, hits.rays))
            assert np.all(hits.t == (ahead[0] if ahead else math.inf))
            assert np.all(hits.entering == (len(ahead) in (2, 4)))
        spans = scene.spans(origins, (0, 0, direction))
        ends = [max(walls[0], 0.0), walls[1], max(walls[2], 0.0), walls[3]]
        expected = [(low, high) for low, high in (ends[:2], ends[2:]) if high > 0]
        assert np.diff(spans.offsets).tolist() == [len(expected)] * 256
        assert spans.t_enter.reshape(256, -1).tolist() == [[low for low, _ in expected]] * 256
        assert spans.t_exit.reshape(256, -1).tolist() == [[high for _, high in expected]] * 256


@pytest.mark.parametrize("speed", [1.0, 1e-60, 1e60, 3e99, 7e-99])
def test_clipped_ends_are_those_of_the_interval_to_the_bit(speed: float) -> None:
    """Rays are certain or doubtful, with directions of any length."""
    scene = co.Scene([co.HalfSpace((0, 0, 1), 0), co.Box((-1, -1, -1), (1, 1, 1))])
    low, high = 0.1 / speed, math.nextafter(0.7 / speed, math.inf)
    for x in (0.25, 1.0):  # within the box, and along its wall
        spans = scene.spans((x, 0.5, -0.9), (0, 0, speed), t_min=low, t_max=high)
        assert spans.enter_clipped.all()
        assert spans.exit_clipped.all()
        assert (spans.t_enter == low).all()
        assert (spans.t_exit == high).all()
        assert spans.body.tolist()[0] == 0


def test_an_interval_that_ends_beyond_all_scaled_numbers() -> None:
    """The interval begins at 1e300, and the direction has the length 1e90: finite at every scale."""
    scene = co.Scene([co.HalfSpace((0, 0, 1), 0)])
    spans = scene.spans((0, 0, -1), (0, 0, -1e90), t_min=1e300)
    assert spans.t_enter.tolist() == [1e300]
    assert spans.t_exit.tolist() == [math.inf]
    assert not scene.occluded((0, 0, -1), (0, 0, 1e90), t_min=1e300)


TIES = {
    "the wall of a box touched by a ball that is cut out": (((-0.5, 0, 5), (0, 0, -1)), False),
    "through both": (((0, 0, 5), (0, 0, -1)), True),
    "beside": (((0.25, 0, 5), (0, 0, -1)), False),
    "from a wall, outwards": (((0.5, 0.25, 0.3), (1, 0, 0)), True),
    "from a wall, inwards": (((0.5, 0.25, 0.3), (-1, 0, 0)), True),
    "within a wall": (((0.25, -0.5, 5), (0, 0, -1)), False),
    "through an edge": (((-1, 0.25, 1), (1, 0, -1)), True),
    "beside it by the least": (((-1, 0.25, math.nextafter(1, 2)), (1, 0, -1)), False),
    "past an edge": (((-1, 0.25, 0), (1, 0, 1)), True),
}


@pytest.mark.parametrize("name", TIES)
def test_ties_of_a_box_without_a_ball_in_it(name: str) -> None:
    """The ray goes alone, and in one packet with rays in another direction."""
    (origin, direction), tied = TIES[name]
    scene = co.Scene([co.Box((-0.5,) * 3, (0.5,) * 3) - co.Sphere(0.5)])
    assert scene.first_hit(origin, direction).doubtful == tied
    around = co.Rays([(x / 4 - 0.5, 0, 5) for x in range(63)], (0, 0, -1))
    rays = co.Rays.concatenate([co.Rays([origin], [direction]), around])
    assert scene.first_hit(rays).doubtful[0] == tied
    assert ties(scene, rays)[1][0] == tied


CAKE = co.HalfSpace((0, 0, 1), 0)  # z <= 0, cut by the planes x = 0 and x + z = 0, which meet in a line of that wall
PIECES = CAKE & co.HalfSpace((1, 0, 0), 0), co.HalfSpace((-1, 0, 0), 0) & co.HalfSpace((1, 0, 1), 0)
TILES = co.Box((0, 0, 0), (1, 1, 1)), co.Box((1, 0, 0), (2, 1, 1))
BALL_HALVES = [co.Sphere() & co.HalfSpace((side, 0, 0), 0) for side in (1, -1)]
SEAMS = {  # ray, t and normal of its hit, and the faces that rays beside it cross there
    "a cap of an extrusion at the plane of a side": (
        co.Extrusion(((-3, 2), (-4, 3), (0, 3), (5, -3), (2, -2), (1, -4)), (-2, 1), 2),
        ((-0.125, -0.875, -20.25), (0, 0, 1), 18.25, (0, 0, -1)), {6}),
    "two boxes, inwards": (TILES[0] | TILES[1], ((3, 0.5, 3), (-1, 0, -1), 2, (0, 0, 1)), {5, 11}),
    "two boxes, outwards": (TILES[0] | TILES[1], ((0.5, 0.5, 0.5), (1, 0, 1), 0.5, (0, 0, 1)), {5, 11}),
    "two painted boxes": (
        TILES[0].painted("red") | TILES[1].painted("blue"), ((-1, -0.5, 3), (1, 0.5, -1), 2, (0, 0, 1)), {5, 11}),
    "three planes through one line": (
        PIECES[0] | PIECES[1] | (CAKE & co.HalfSpace((-1, 0, -1), 0)), ((1, 0, 1), (-1, 0, -1), 1, (0, 0, 1)), {0, 4}),
    "halves of a ball": (BALL_HALVES[0] | BALL_HALVES[1], ((1, 0, 2), (-1, 0, -1), 1, (0, 0, 1)), {0, 2}),
}  # fmt: skip


@pytest.mark.parametrize("name", SEAMS)
def test_a_seam_within_a_body_is_no_wall_and_no_tie(name: str) -> None:
    """Rays beside this one cross one wall only, in the order of (g·v) / (g·d): alone, in packets and in lists."""
    shape, (origin, direction, t, normal), faces = SEAMS[name]
    scene = co.Scene([shape])
    hit, hits = scene.first_hit(origin, direction), scene.first_hit([origin] * 70, direction)
    crossings = scene.crossings(origin, direction)
    assert (hit.t, hit.doubtful, hit.before, hit.after) == (t, False, *((-1, 0) if hit.entering else (0, -1)))
    assert hit.normal == pytest.approx(normal, abs=1e-15)
    assert hit.face in faces
    assert crossings.face[0] == hit.face
    assert crossings.t[0] == t
    beside = np.add(origin, np.multiply(t, direction)) + np.divide(normal, 8)
    assert scene.distance(beside, exact=True).face == hit.face
    assert (hits.surface == hit.surface).all()
    assert (hits.face == hit.face).all()
    assert not hits.doubtful.any()
    assert np.asarray(hits.normal).tolist() == [np.asarray(hit.normal).tolist()] * 70


def test_a_wall_that_touches_an_edge_has_no_face() -> None:
    """The plane x = -2 has the lowest number. It touches a wedge along the edge of its faces 1 and 2."""
    normals = [(-1, 0, 0), (-1, 0, 1), (-1, 0, -1), (1, 0, 0), (0, 1, 0), (0, -1, 0)]
    scene = co.Scene([co.Polyhedron(normals, [2] * 6).rotate("z", -90)])
    crossings = scene.crossings((0, 9, 0), (0, -1, 0))
    assert (crossings.t.tolist(), crossings.face.tolist()) == ([7, 11], [1, 3])
    assert scene.first_hit((0, 9, 0), (0, -1, 0)).face == 1
    assert scene.distance((0, 9, 0), exact=True).face in (1, 2)


@pytest.mark.parametrize("seed", range(40))
def test_a_corner_of_three_walls_is_a_tie_if_rays_beside_it_hit_others(seed: int) -> None:
    """Rays beside this one cross the walls x = y = z = 0 in each of the six orders, and have no ties themselves."""
    random = np.random.default_rng(seed)
    walls = [co.HalfSpace(-np.eye(3)[k], 0.0) for k in random.permutation(3)]
    shape = walls[0] & co.Sphere(1, (0, 5, 50))  # it has the number of the first wall, and the ray does not come near
    for k in random.integers(0, 3, 5):
        operand = walls[k] if random.random() < 0.7 else ~walls[k]
        shape = shape | operand if random.random() < 0.5 else operand & shape
    scene = co.Scene([shape])
    beside = 1e-9 * np.array(list(itertools.permutations((-1, 0, 1)))) - 1
    hits, hit = scene.first_hit(beside, (1, 1, 1)), scene.first_hit((-1, -1, -1), (1, 1, 1))
    assert not hits.doubtful.any()
    others = {(bool(h.hit), int(h.surface), bool(h.entering)) for h in hits}
    assert hit.doubtful == (len(others | {(bool(hit.hit), int(hit.surface), bool(hit.entering))}) > 1)


@pytest.mark.parametrize("count", [7, 8, 12, 20, 41])
@pytest.mark.parametrize("more", [0, 1])
def test_a_tip_of_any_number_of_walls_is_a_tie(count: int, more: int) -> None:
    """Rays below the tip of a pyramid hit it, and rays above do not: alone, and in one body with another tip behind it."""
    for seed in range(20):
        angles = np.random.default_rng(seed).permutation(count) * 2 * math.pi / count + 0.1
        normals = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles + 0.5])
        tip = co.Polyhedron([*normals, (0, 0, -1)], [0.0] * count + [1.0])
        scene = co.Scene([tip | tip.rotate("z", 0.5).translate((3, 0, 0)) if more else tip])
        hits = scene.first_hit([(-5, 0, -1e-9), (-5, 0, 0), (-5, 0, 1e-9)], (1, 0, 0))
        assert hits.hit.tolist()[::2] == [True, False]
        assert hits.doubtful.tolist() == [False, True, False]


def test_ties_on_outlines_and_tips() -> None:
    halves = co.Scene([co.Triangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), co.Triangle((1, 1, 0), (1, 0, 0), (0, 1, 0))])
    down = halves.first_hit([(0.5, 0.5, 1), (0, 0.5, 1), (0.25, 0.5, 1)], (0, 0, -1))
    assert down.doubtful.tolist() == [True, True, False]
    loop = np.array([(0, 0, 0), (2, 0, 0), (2, 2, 0), (1, 1, 0), (0, 2, 0)], float)
    on_edges = np.concatenate([loop, (loop + np.roll(loop, 1, axis=0)) / 2])
    scenes = [
        co.Scene([shape(loop)]) for shape in (co.Polygon, lambda p: co.Triangle(*p[:3]), lambda p: co.Triangle(*p[2:]))
    ]
    for direction in [d for d in itertools.product((-2, -1, 0, 1, 2), repeat=3) if d[2]]:
        marks = [scene.first_hit(on_edges - 4 * np.array(direction), direction).doubtful for scene in scenes]
        assert marks[0].all()
        assert marks[1][[0, 1, 2, 6, 7]].all()  # corners, and the middles of the edges between them
        assert marks[2][[2, 3, 4, 8, 9]].all()
        assert scenes[0].first_hit(on_edges, direction).doubtful.all()  # rays start on the polygon and on its edge
    patch = co.Scene([co.CylinderPatch((0, 0, 0), (0, 0, 1), 1, 0, 180, (1, 0, 0))])
    for direction in itertools.product((-3, -1, 1, 3), (-2, 2), (-1, 1)):  # through its corners, across all its edges
        corners = np.array([(x, 0, z) for x in (-1, 1) for z in (0, 1)]) - 4 * np.array(direction)
        hits = patch.first_hit(corners, direction)
        assert (hits.doubtful == (hits.t > 3.9)).all()
    cone = co.Scene([co.Cone((0, 0, 0), (0, 0, 1), 1, 0)])
    hits = cone.first_hit([(0, 0, 5), (5, 0, 1), (0.25, 0, 5)], [(0, 0, -1), (-1, 0, 0), (0, 0, -1)])
    assert hits.doubtful.tolist() == [True, True, False]
    tube = co.Scene([co.Cylinder((0, 0, -1), (0, 0, 1), 1)])
    hits = tube.first_hit([(1, -5, 0), (1, 0, 5), (3, 0, 3)], [(0, 1, 0), (0, 0, -1), (-1, 0, -1)])
    assert hits.doubtful.tolist() == [True, False, True]  # a rule decides for a ray along a ruling


def test_limits_of_canonical_quadrics_lie_within_their_memory() -> None:
    """Kernels load two limits by the number of a form.

    Here the places and lengths belong to a lattice of pins cut by eight planes.
    """
    geometry = Geometry(np.zeros(2 * table.LENGTHS + 5, np.int64), np.zeros(0, np.int32), np.zeros(53_536))
    geometry.places[[table.QUADRIC_FORMS, table.QUADRIC_LIMITS, table.LENGTHS + table.QUADRICS]] = 5_000, 49_304, 60
    size = len(geometry.floats) + count_form_floats(geometry)
    forms = (size - 5_000) // table.FORM_SIZE  # the last form ends where the memory ends
    assert 49_304 + 2 * forms <= size


AT_A_THIRD = {  # walls that a ray from (1, -1, -2) to (1, 2, 4) meets at t = 1/3, and (t, entering) of its hit
    "an edge": ([co.Box((0, 0, 0), (2, 1, 1))], (1 / 3, True)),
    "past two edges": ([co.Box((0, 0, -9), (2, 1, 0)), co.Box((0, -9, 0), (2, 0, 1))], (math.inf, False)),
    "two balls that touch": ([co.Sphere(), co.Sphere(1, (2, 0, 0))], (math.inf, False)),
    "a ball at a wall": ([co.Sphere(), co.HalfSpace((0, -1, 0), 0)], (1 / 3, True)),
    "a ball in a tube": ([co.Sphere(), co.Cylinder((0, 0, -1), (0, 0, 1), 1)], (math.inf, False)),
}


@pytest.mark.parametrize("name", AT_A_THIRD)
def test_ties_at_a_quotient_that_no_float_is_need_no_integers(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """1/3 has an error in pairs of floats, and its numerator and denominator have none.

    Integers would take 50 times as long.
    """
    solids, (t, entering) = AT_A_THIRD[name]
    calls: list[int] = []
    monkeypatch.setattr(doubtful_rays, "put_exact_ranks", lambda *arguments: calls.append(1))
    hit = co.Scene(solids).first_hit((1, -1, -2), (0, 3, 6))
    assert not calls
    assert (hit.t, hit.entering, hit.doubtful) == (t, entering, True)


@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (3, -2, 0)])
def test_rays_of_one_root_need_no_integers(direction: tuple[int, int, int], monkeypatch: pytest.MonkeyPatch) -> None:
    """x z - y z + linear terms, as sides of twisted solids: no square is along the ray, and its record has rounded ones."""
    terms = {"xz": 0.000308541, "yz": -0.000308541, "x": -0.7071, "y": -0.7073, "z": 0.02, "constant": 0.5}
    shift = (-550.0, 3.7, 0.25)
    monkeypatch.setattr(doubtful_rays, "put_exact_ranks", lambda *arguments: pytest.fail("integers"))
    origins = np.random.default_rng(1).uniform(-15, 15, (70, 3)) + shift
    hits = co.Scene([co.Quadric(coefficients=terms).translate(shift)]).first_hit(origins, direction, t_min=-math.inf)
    for origin, t in zip(origins.tolist(), hits.t.tolist(), strict=True):
        x, y, z = (Fraction(a) - Fraction(b) for a, b in zip(origin, shift, strict=True))
        u, v, w = direction
        k = {name: Fraction(value) for name, value in terms.items()}
        slope = k["xz"] * (x * w + z * u) + k["yz"] * (y * w + z * v) + k["x"] * u + k["y"] * v + k["z"] * w
        value = k["xz"] * x * z + k["yz"] * y * z + k["x"] * x + k["y"] * y + k["z"] * z + k["constant"]
        assert t == pytest.approx(float(-value / slope), rel=1e-12)


@pytest.mark.parametrize("radius", [1e-60, 1e-75, 1e-80, 1e-90, 1e-100])
def test_rays_at_the_smallest_angles_to_thin_rods(radius: float) -> None:
    """y = (t - 3) r along the ray, so that it is within from 2 to 4. Discriminants are r⁴, below the least float."""
    scene = co.Scene([co.Cylinder((-10, 0, 0), (10, 0, 0), radius)])
    spans = scene.spans((-5, -3 * radius, 0), (1, radius, 0))
    assert spans.t_enter == pytest.approx([2], rel=1e-14)
    assert spans.t_exit == pytest.approx([4], rel=1e-14)
    assert scene.first_hit([(-5, -3 * radius, 0)] * 70, (1, radius, 0)).t == pytest.approx(np.full(70, 2), rel=1e-14)
    assert not scene.first_hit((-5, -3 * radius, 2 * radius), (1, radius, 0)).hit


@pytest.mark.parametrize("radius", [1e-20, 1e-33, 1e-40, 1e-100])
def test_balls_that_are_tiny_beside_their_distance(radius: float) -> None:
    """A ray goes through the very center. Its crossings are 2 r apart, less than two floats together resolve."""
    center, rays = (0.59, 0.586, 1.02), ([(-3.1, 0.586, 1.02)] * 70, (1, 0, 0))
    for ball in (co.Sphere(radius, center), co.Ellipsoid((radius, radius, radius), center)):
        scene = co.Scene([ball])
        hits, crossings = scene.first_hit(*rays), scene.crossings(*rays)
        assert hits.t == pytest.approx(np.full(70, 3.69), rel=1e-15)
        assert scene.occluded(*rays).all()
        assert crossings.entering.tolist() == [True, False] * 70


def test_curved_solids_thinner_than_the_rounding_of_their_distance() -> None:
    """A ray goes through the middle of a lens of thickness 1e-20 and width 1.

    Both its crossings are at one float, t = 5.
    """
    thin, ball = co.Ellipsoid((1e-20, 1, 1), (1, 0, 0)), co.Sphere(0.1, (9, 0, 0))
    for solid in (thin, thin.rotate("x", 30), thin | ball, co.Body(thin | ball).shape - co.Sphere(0.1, (5, 5, 5))):
        scene = co.Scene([solid])
        hits = scene.first_hit([(-4, 0, 0)] * 70, (1, 0, 0))
        assert hits.t.tolist() == [5] * 70
        assert not hits.doubtful.any()
        assert scene.first_hit((-4, 0, 0), (1, 0, 0)).t == 5
        assert scene.crossings([(-4, 0, 0)], (1, 0, 0)).t.tolist()[:2] == [5, 5]
        assert scene.occluded((-4, 0, 0), (1, 0, 0))


# --- Rays and intervals whose answers were once wrong, as users reported them


INF = float("inf")
ABOUT_Z = ("rotate", (0.0, 0.0, 1.0), 15.0)
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


def check(items, origin, direction):
    judge, one = comparison(items, origin, direction)
    good = one.lists()
    one.first()
    one.spans(good)
    judge.score.check()
    return one


@pytest.mark.parametrize("degrees", [0, 15, 16, 30, 45, 75, 105, 165])
def test_a_ray_through_the_rim_hits_a_cone(degrees):
    found = co.Scene([co.Cone((0, 0, -1), (0, 0, 1), 2, 1).rotate((0, 0, 1), degrees)]).crossings(
        (2, 3, 3), (-2, -2, -2), t_min=-9
    )
    assert np.allclose(found.t, [1, 13 / 7], rtol=1e-15)
    assert found.entering.tolist() == [True, False]


@pytest.mark.parametrize("height", [0.0, 0.5, 1.0, -1.0])
@pytest.mark.parametrize(("item", "degrees"), in_turn(ROUND, [15.0, 105.0]))
def test_grazing_a_body_turned_about_its_own_axis(item, degrees, height):
    """The ray (5, -1, 0) -> (-1, 0, 0) and others like it touch the shape or run along it."""
    turned = item.moved(("rotate", (0.0, 0.0, 1.0), degrees))
    for x, y in ((-1.0, 0.0), (0.0, -1.0), (-1.0, -1.0), (2.0, -1.0)):
        for side in (1.0, -1.0):
            away = np.array([-y, x, 0.0]) * side
            check([turned], np.array([0.0, 0.0, height]) + away - 5 * np.array([x, y, 0.0]), (x, y, 0.0))


@pytest.mark.parametrize(
    ("origin", "direction"),
    [
        ((5, -1, 0), (-1, 0, 0)),
        ((1, 0, 5), (0, 0, -1)),
        ((5, -1, 1), (-1, 0, 0)),
        ((-1, 1, -3), (1, -1, 1)),
        ((3, 4, -3), (-1, -1, 1)),
    ],
)
@pytest.mark.parametrize("degrees", [*range(1, 180, 13), 15, 105, 0.5, 33.3, 1e-3])
def test_any_turn_about_the_own_axis_leaves_a_cylinder_as_it_is(degrees, origin, direction):
    """Rulings and tangents at lattice points are those of the cylinder that is not turned."""
    turned = TUBE.moved(("rotate", (0.0, 0.0, 1.0), float(degrees)), paper=())
    check([turned], origin, direction)


@pytest.mark.parametrize(
    ("item", "origin", "direction"),
    [
        (Item("DoubleCone", {"slope": 2.0, "z_range": (-1.0, 2.0)}, (("scale", 2.0), ABOUT_Z)), (4, -4, 0), (-1, -1, -1)),
        (Item("DoubleCone", {"slope": 2.0, "z_range": (-1.0, 2.0)}, (("scale", 2.0), ABOUT_Z)), (-4, -2, -4), (0, -1, -1)),
        (Item("EllipticParaboloid", {"A": 1.0, "E": 1.0, "z_range": (1.0, INF)}, (ABOUT_Z, ("scale", (1.0, 2.0, 1.0)))), (1, -1.5, 1.5), (0, 3, -1)),
        (Item("OneSheetHyperboloid", {"A": 1.0, "E": 1.0, "H": 4.0}, (("rotate", (0.0, 0.0, 1.0), -75.0),)), (-2, 0, 1), (-2, 0, 1)),
        (Item("CylinderPatch", {"start": (0.0, 0.0, 0.0), "end": (0.0, 0.0, 1.0), "radius": 1.25, "start_angle": 0.0, "end_angle": 300.0, "reference": (0.0, -3.0, -3.0)}, (("rotate", (0.0, 0.0, 1.0), -75.0),)), (2, -2, 1), (-1, 1, 0)),
        # Of the ray's direction 3.4e-21 lies along an axis that bends: the ray hits a body without an end at 3e20
        (
            Item(
                "Quadric", {"coefficients": dict(xx=0.0, yy=0.0, zz=0.0, xy=-1.0, yz=0.0, xz=0.0, x=0.0, y=-2.0, z=0.0, constant=-2.0)},
                (("transform", ((1.0, 0.0, 0.0, -1.0), (0.0, 1.0, 1.0, 0.0), (0.0, 0.0, 1.0, -1.0), (0.0, 0.0, 0.0, 1.0))), ("rotate", (1.0, 1.0, 0.0), 180.0)),
            ),
            (-3, 0, 3.0000000000000027), (1, -3.3881317890172014e-21, -1),
        ),
    ],
    ids=["apex", "cap", "bound", "asymptote", "patch", "a wall that rounding takes beyond all sizes"],
)  # fmt: skip
def test_rational_cases(item, origin, direction):
    check([item], origin, direction)


def half_space(normal, offset) -> Item:
    return Item("HalfSpace", {"normal": normal, "offset": offset})


def test_an_interval_of_a_few_floats_about_a_crossing():
    """Two planes meet within the interval. `first_hit` and `occluded` agree."""
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


@pytest.mark.parametrize("copies", [1, 80])
def test_a_ball_is_left_behind_just_beyond_the_origin(copies):
    """At t = 6.9e-19 the roots of the fast formulas lie behind.

    So lists of rays must be in doubt, alone and in packets.
    """
    ball = Item("Sphere", {"radius": 3.0, "center": (-2.0, 1.0, 0.0)})
    judge = Judge(co, [ball])
    origin, direction = (-1.734723475976807e-18, -1, -1), (1, -1.0000009536743164, -1)
    one = judge.rays(np.tile(np.array(origin, float), (copies, 1)), np.tile(np.array(direction, float), (copies, 1)))
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


def test_streams_and_single_rays_doubt_alike_below_every_number():
    scene = co.Scene([co.Disc((1, 0, -0.5), (-1, 1, -2), 3)])
    origins, directions = np.tile((1.0, 0.0, -0.5), (33 * 64, 1)), np.tile((0.0, -1.0, -1.0), (33 * 64, 1))
    origins[1::2] += (0.0, 50.0, 0.0)  # in no order, so that they make a stream
    for low, high in ((-1e-323, -5e-324), (-5e-324, 0.0), (-5e-324, 5e-324), (0.0, 5e-324)):
        alone = scene.first_hit(origins[0], directions[0], low, high)
        stream = scene.first_hit(origins, directions, low, high)
        assert (stream.t[::2] == alone.t).all()
        assert (stream.doubtful[::2] == alone.doubtful).all()
