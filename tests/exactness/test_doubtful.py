"""Which hits hang on a tie, and that doubt reaches every end of a body; rows of them keep the user's interval."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels import tables as table
from conicoid.kernels.tables import Geometry
from conicoid.queries.exact import doubtful_rays
from conicoid.queries.exact.ranks import count_form_floats

from ..reference.routes import in_doubt, ties

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
    """x = 1 beside the unit ball; a unit in the last place nearer, which exact methods decide, and well within."""
    scene = co.Scene([co.Sphere()])
    x = [1.0, math.nextafter(1, 0), 0.5]
    hits = scene.first_hit([(value, 0.0, 5.0) for value in x], (0, 0, -1))
    assert hits.doubtful.tolist() == [True, False, False]
    assert in_doubt(scene, hits.rays).tolist() == [True, True, False]
    assert np.isfinite(hits.t).tolist() == [False, True, True]


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("wall", [-1.0, -0.5, 0.5, 1.0])
def test_ends_of_both_spans_of_a_body_near_the_origin(wall: float, direction: float) -> None:
    """A bow tie, x² + y² <= z² and |z| <= 1: along x = 0.5, y = 0 it holds z in [-1, -0.5] and [0.5, 1].

    From each of the four walls, or one unit in the last place beside it: in packets, in lists and alone.
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
    """Of certain rays and of doubtful ones, whatever the length of the direction."""
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
    """t_min = 1e300 along a direction of length 1e90: finite, however it is scaled."""
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
    """The ray alone, and in one packet with rays that look another way."""
    (origin, direction), tied = TIES[name]
    scene = co.Scene([co.Box((-0.5,) * 3, (0.5,) * 3) - co.Sphere(0.5)])
    assert scene.first_hit(origin, direction).doubtful == tied
    around = co.Rays([(x / 4 - 0.5, 0, 5) for x in range(63)], (0, 0, -1))
    rays = co.Rays.concatenate([co.Rays([origin], [direction]), around])
    assert scene.first_hit(rays).doubtful[0] == tied
    assert ties(scene, rays)[1][0] == tied


@pytest.mark.parametrize("seed", range(40))
def test_a_corner_of_three_walls_is_a_tie_if_rays_beside_it_hit_others(seed: int) -> None:
    """Rays beside it cross the walls x = y = z = 0 in each of the six orders, and have no ties themselves."""
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
        assert scenes[0].first_hit(on_edges, direction).doubtful.all()  # starts on the polygon and on its edge
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
    assert hits.doubtful.tolist() == [True, False, True]  # along a ruling a rule decides


def test_limits_of_canonical_quadrics_lie_within_their_memory() -> None:
    """Kernels load two limits by the number of a form; places and lengths of a lattice of pins cut by eight planes."""
    geometry = Geometry(np.zeros(2 * table.LENGTHS + 5, np.int64), np.zeros(0, np.int32), np.zeros(53_536))
    geometry.places[[table.QUADRIC_FORMS, table.QUADRIC_LIMITS, table.LENGTHS + table.QUADRICS]] = 5_000, 49_304, 60
    size = len(geometry.floats) + count_form_floats(geometry)
    forms = (size - 5_000) // table.FORM_SIZE  # the last form ends where the memory ends
    assert 49_304 + 2 * forms <= size


AT_A_THIRD = {  # what a ray from (1, -1, -2) to (1, 2, 4) crosses and touches at t = 1/3, and (t, entering) of its hit
    "an edge": ([co.Box((0, 0, 0), (2, 1, 1))], (1 / 3, True)),
    "past two edges": ([co.Box((0, 0, -9), (2, 1, 0)), co.Box((0, -9, 0), (2, 0, 1))], (math.inf, False)),
    "two balls that touch": ([co.Sphere(), co.Sphere(1, (2, 0, 0))], (math.inf, False)),
    "a ball at a wall": ([co.Sphere(), co.HalfSpace((0, -1, 0), 0)], (1 / 3, True)),
    "a ball in a tube": ([co.Sphere(), co.Cylinder((0, 0, -1), (0, 0, 1), 1)], (math.inf, False)),
}


@pytest.mark.parametrize("name", AT_A_THIRD)
def test_ties_at_a_quotient_that_no_float_is_need_no_integers(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """1/3 has an error in pairs of floats, its numerator and denominator have none: integers would take 50 times as long."""
    solids, (t, entering) = AT_A_THIRD[name]
    asked: list[int] = []
    monkeypatch.setattr(doubtful_rays, "put_exact_ranks", lambda *arguments: asked.append(1))
    hit = co.Scene(solids).first_hit((1, -1, -2), (0, 3, 6))
    assert not asked
    assert (hit.t, hit.entering, hit.doubtful) == (t, entering, True)


@pytest.mark.parametrize("radius", [1e-60, 1e-75, 1e-80, 1e-90, 1e-100])
def test_rays_at_the_smallest_angles_to_thin_rods(radius: float) -> None:
    """y = (t - 3) r along the ray, so that it is within from 2 to 4; discriminants are r⁴, below the least float."""
    scene = co.Scene([co.Cylinder((-10, 0, 0), (10, 0, 0), radius)])
    spans = scene.spans((-5, -3 * radius, 0), (1, radius, 0))
    assert spans.t_enter == pytest.approx([2], rel=1e-14)
    assert spans.t_exit == pytest.approx([4], rel=1e-14)
    assert scene.first_hit([(-5, -3 * radius, 0)] * 70, (1, radius, 0)).t == pytest.approx(np.full(70, 2), rel=1e-14)
    assert not scene.first_hit((-5, -3 * radius, 2 * radius), (1, radius, 0)).hit


@pytest.mark.parametrize("radius", [1e-20, 1e-33, 1e-40, 1e-100])
def test_balls_that_are_tiny_beside_their_distance(radius: float) -> None:
    """A ray through the very centre: its crossings are 2 r apart, less than two floats together resolve."""
    center, rays = (0.59, 0.586, 1.02), ([(-3.1, 0.586, 1.02)] * 70, (1, 0, 0))
    for ball in (co.Sphere(radius, center), co.Ellipsoid((radius, radius, radius), center)):
        scene = co.Scene([ball])
        hits, crossings = scene.first_hit(*rays), scene.crossings(*rays)
        assert hits.t == pytest.approx(np.full(70, 3.69), rel=1e-15)
        assert scene.occluded(*rays).all()
        assert crossings.entering.tolist() == [True, False] * 70


def test_curved_solids_thinner_than_the_rounding_of_their_distance() -> None:
    """Through the middle of a lens of 1e-20, wide as 1: both its crossings are at one float, t = 5."""
    thin, ball = co.Ellipsoid((1e-20, 1, 1), (1, 0, 0)), co.Sphere(0.1, (9, 0, 0))
    for solid in (thin, thin.rotate("x", 30), thin | ball, co.Body(thin | ball).shape - co.Sphere(0.1, (5, 5, 5))):
        scene = co.Scene([solid])
        hits = scene.first_hit([(-4, 0, 0)] * 70, (1, 0, 0))
        assert hits.t.tolist() == [5] * 70
        assert not hits.doubtful.any()
        assert scene.first_hit((-4, 0, 0), (1, 0, 0)).t == 5
        assert scene.crossings([(-4, 0, 0)], (1, 0, 0)).t.tolist()[:2] == [5, 5]
        assert scene.occluded((-4, 0, 0), (1, 0, 0))
