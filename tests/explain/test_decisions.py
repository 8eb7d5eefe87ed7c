"""Explanations: their numbers are the kernels' own; which formulas decided; the surfaces that they name."""

import math
from typing import Any

import mpmath
import numpy as np
import pytest

import conicoid as co
from benchmarks.comparison.scenes import write_core

from ..booleans.random_solids import EXAMPLES, random_body
from ..samples import deep

# --- Which formulas decided: certain rays, doubtful ones with the places of all crossings, and rays for exact
# arithmetic


def test_a_certain_ray_has_the_bound_of_its_hit():
    found = co.Scene([co.Sphere(1)]).explain((-3, 0.6, 0), (1, 0, 0))
    assert (found.decision.first, found.decision.all, found.decision.places) == ("floats", "floats", ())
    assert found.decision.t_error == found.hit.t_error
    # 0.36 is not 0.6² exactly: t* = 3 − √(1 − 0.6²) with the float 0.6
    with mpmath.workdps(50):
        exact = 3 - mpmath.sqrt(1 - mpmath.mpf(0.6) ** 2)
        assert abs(mpmath.mpf(float(found.hit.t)) - exact) <= found.decision.t_error


@pytest.mark.parametrize("power", [36, 44, 50])
def test_a_grazing_ray_is_located_to_thirty_digits(power):
    """At the height 1 − 2^−k a unit ball has crossings at 5 ∓ √(1 − h²), which the float formulas leave in doubt."""
    height = 1 - 2.0**-power
    found = co.Scene([co.Sphere(1)]).explain((-5, height, 0), (1, 0, 0))
    assert found.decision.first == found.decision.all == "certified"
    assert [place.surface for place in found.decision.places] == [0, 0]
    with mpmath.workdps(60):
        half = mpmath.sqrt(1 - mpmath.mpf(height) ** 2)
        for place, exact in zip(found.decision.places, (5 - half, 5 + half), strict=True):
            assert abs(mpmath.mpf(place.high) + mpmath.mpf(place.low) - exact) <= place.error <= 1e-20
            assert place.t == float(exact)
    ranks = [place.rank for place in found.decision.places]
    assert ranks == sorted(set(ranks))
    assert [c.t for c in found.crossings] == [place.t for place in found.decision.places]
    assert "the float formulas leave it in doubt; decided by numbers in two floats" in found.text


def test_two_roots_that_are_one():
    """Unit balls about 0 and (1, 0, 0) have equal crossings 5 ∓ √3/2 along z at x = 1/2.

    Only exact arithmetic finds them equal.
    """
    scene = co.Scene([co.Sphere(1), co.Sphere(1, (1, 0, 0))])
    found = scene.explain((0.5, 0, 5), (0, 0, -1))
    assert found.decision.first == "exact"
    first, second, third, last = found.decision.places
    assert {first.surface, second.surface} == {third.surface, last.surface} == {0, 1}
    assert first.rank == second.rank < third.rank == last.rank
    assert first.t == second.t == pytest.approx(5 - 3**0.5 / 2, rel=1e-15)
    assert "decided by exact arithmetic, since error bounds left it open" in found.text
    assert found.hit.body == 0


def test_crossings_after_the_first_hit_may_be_in_doubt():
    """The ray hits a plate first and grazes a ball beyond it."""
    scene = co.Scene([co.Box((-3, -1, -1), (-2, 2, 1)), co.Sphere(1)])
    found = scene.explain((-5, 1 - 2.0**-44, 0), (1, 0, 0))
    assert (found.decision.first, found.decision.all) == ("floats", "certified")
    assert "crossings behind it are in doubt" in found.text
    assert [c.body for c in found.crossings] == [0, 0, 1, 1]


def test_a_ray_through_an_edge_is_decided_by_ranks():
    """The ray goes through an edge of a turned cube.

    It leaves two faces at places that differ by less than their errors.
    """
    scene = co.Scene([co.Box((-1, -1, -1), (1, 1, 1)).rotate((1, 2, 3), 40)])
    found = scene.explain((8.00624797748944, 14.562531536778334, 16.736100761092338), (-2, -4, -4))
    step = found.bodies[0]
    assert step.doubtful
    assert found.decision.all == "certified"
    assert [c.t for c in step.crossings] == scene.crossings(found.hit.rays).t.tolist()
    # The two faces that meet in the edge are next to each other in the order of all crossings
    last = step.crossings[-1]
    near = [place for place in found.decision.places if abs(place.t - last.t) < 1e-12]
    assert len(near) == 2
    assert abs(near[0].rank - near[1].rank) <= 1


def test_cancelling_terms_are_computed_again():
    """The ray is nearly a ruling of a cone: a = 1 − slope² is 2^-20 of its terms, so two floats compute it, halved."""
    slope = 1 + 2.0**-20
    step = co.Scene([co.EllipticCone(1, 1, 1)]).explain((0.5, 0, 0), (1, 0, slope), t_min=-10).surfaces[0]
    assert step.careful
    assert step.board.numbers["a"] == 1 - slope * slope
    assert 2 * step.a == pytest.approx(1 - slope * slope, rel=1e-15)


def test_a_far_away_direction_is_scaled():
    """t is that of the user's ray, also where the kernels scale it: 2.2 / 10⁴⁰."""
    found = co.Scene([co.Sphere(1)]).explain((-3, 0.6, 0), (1e40, 0, 0))
    assert float(found.hit.t) == pytest.approx(2.2e-40, rel=1e-15)
    assert found.surfaces[0].board.numbers["t0"] == pytest.approx(2.2e-40, rel=1e-15)


# --- The numbers of an explanation are the kernels' own: they lead to the answers of queries, to the bit


def follows(found: Any) -> None:
    """Check that every crossing is a recorded root, and an event at which the value of a Boolean changes.

    Where the ray is doubtful the float formulas may differ from the answers, and the explanation has to say so.
    """
    scene, ray = found.scene, found.hit.rays
    limits = {"t_min": found.t_min, "t_max": found.t_max}
    hit, crossings, spans = scene.first_hit(ray, **limits), scene.crossings(ray, **limits), scene.spans(ray, **limits)
    columns = crossings.t, crossings.body, crossings.face, crossings.surface, crossings.entering
    rows = [tuple(row) for row in zip(*(column.tolist() for column in columns), strict=True)]
    assert [(c.t, c.body, c.face, c.surface, c.entering) for c in found.crossings] == rows
    if found.decision.all != "floats":
        assert found.decision.places or not rows
        return
    assert not any(step.doubtful for step in found.bodies if step.crossings)
    first = (float(hit.t), int(hit.body), int(hit.face), int(hit.surface), bool(hit.entering)) if hit.hit else None
    assert first == (rows[0] if rows else None)
    roots = {(t, number) for number, step in found.surfaces.items() for t in step.roots}
    assert {(t, surface) for t, _, _, surface, _ in rows} <= roots
    for step in found.bodies:
        if step.kind == "Boolean" and step.sweep is not None:
            values = [step.sweep.begins, *(row.value for row in step.sweep.rows)]
            changes = {
                row.t for row, one, other in zip(step.sweep.rows, values, values[1:], strict=False) if one != other
            }
            inside = [t for t in changes if found.t_min < t < found.t_max and t != 0]
            assert sorted(inside) == [c.t for c in step.crossings if c.t != 0]
    ends = sorted((s.t_enter, step.body, s.t_exit) for step in found.bodies for s in derived_spans(step, found))
    rows = zip(*(column.tolist() for column in (spans.t_enter, spans.body, spans.t_exit)), strict=True)
    assert ends == sorted(rows)


def derived_spans(step: Any, found: Any) -> list[Any]:
    """Return the spans of a solid: they must fit its crossings, with the ends of the interval."""
    inner = [s.t_enter for s in step.spans if not s.enter_clipped] + [
        s.t_exit for s in step.spans if not s.exit_clipped
    ]
    if step.kind in ("ball", "solid", "Boolean"):
        assert sorted(inner) == [c.t for c in step.crossings]
    assert all(s.t_enter == found.t_min for s in step.spans if s.enter_clipped)
    return list(step.spans)


def through(rng: np.random.Generator, scene: Any) -> co.Rays:
    """Return a ray that probably hits, now and then of round numbers, or from a surface."""
    low, high = (np.array(end) for end in scene.extent)
    direction = rng.normal(size=3)
    origin = (low + high) / 2 + 0.3 * (high - low) * rng.normal(size=3) - 4 * rng.random() * direction
    if rng.random() < 0.25:
        origin, direction = np.round(origin), np.round(2 * direction) + (0, 0, 0.5)
    ray = co.Rays(origin, direction * 10.0 ** rng.integers(-3, 4))
    if rng.random() < 0.25:
        hit = scene.first_hit(ray)
        if hit.hit:
            return hit.spawn(rng.normal(size=3))
    return ray


def limits(rng: np.random.Generator) -> dict[str, float]:
    return {
        "t_min": float(rng.choice([0.0, 0.0, -math.inf, 0.4])),
        "t_max": float(rng.choice([math.inf, math.inf, 3.0])),
    }


def compare(rng: np.random.Generator, scene: Any, rays: int) -> int:
    """Return how many of some rays the float formulas decided."""
    certain = 0
    for _ in range(rays):
        found = scene.explain(through(rng, scene), **limits(rng))
        follows(found)
        certain += found.decision.all == "floats"
    return certain


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("rays", "seed"), [(1, 1), deep((30, 3))])
def test_every_shape(rays: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert sum(compare(rng, co.Scene([shape]), rays) for shape in EXAMPLES) > 0.8 * rays * len(EXAMPLES)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("scenes", "rays", "seed"), [(12, 6, 2), deep((60, 20, 4))])
def test_random_booleans(scenes: int, rays: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert sum(compare(rng, co.Scene([random_body(rng) for _ in range(3)]), rays) for _ in range(scenes)) > 0.1 * scenes


@pytest.mark.parametrize("length", [1e-40, 1e40, 1e-90])
def test_extreme_lengths_of_directions(length):
    """The kernels scale these directions by a power of two. t is that of the user's ray."""
    scene = co.Scene([co.Sphere(1.5) - co.Box((-1, -1, -1), (1, 1, 0.5))])
    follows(scene.explain((0.2, 0.3, -5), np.array([0.01, 0.02, 1.0]) * length))


def test_bulk_bodies_and_the_tree():
    rng = np.random.default_rng(6)
    scene = co.Scene([co.Spheres(rng.uniform(-3, 3, (200, 3)), 0.4), co.Cylinders([(0, 0, -4)], [(0, 0, 4)], 0.5)])
    for _ in range(10):
        found = scene.explain(rng.normal(size=3) * 4, rng.normal(size=3))
        follows(found)
        assert len(found.bodies) + found.misses == 201


def test_numbers_are_those_of_the_formulas():
    """From (−3, 0.6, 0) along x, x² + y² + z² = 1 has its foot at t = 3, c = 0.36 − 1, b² − a c = 0.64, all but exact."""
    step = co.Scene([co.Sphere(1)]).explain((-3, 0.6, 0), (1, 0, 0)).surfaces[0]
    assert (step.a, step.b, step.foot) == (1, 0, 3)
    assert step.c == pytest.approx(-0.64, rel=1e-15)
    assert step.discriminant == pytest.approx(0.64, rel=1e-15)
    assert step.roots == (2.2, 3.8)


# --- Surfaces of a scene: equations in the world, kinds, owners


def value(coefficients, point):
    """Return the polynomial at a point, by its named coefficients."""
    x, y, z = point
    terms = dict(xx=x * x, yy=y * y, zz=z * z, xy=x * y, yz=y * z, xz=x * z, x=x, y=y, z=z, constant=1.0)
    return sum(c * terms[name] for name, c in coefficients.items()), sum(
        abs(c * terms[name]) for name, c in coefficients.items()
    )


SAMPLE = [
    pytest.param(one, id=type(one).__name__, marks=[pytest.mark.deep] if k % 18 else [])
    for k, one in enumerate(EXAMPLES)
]


@pytest.mark.parametrize("shape", SAMPLE)
def test_hit_points_satisfy_the_equation_of_their_surface(shape):
    """The tolerance is the error bound of the point times the gradient, at most the size of the terms."""
    rng, scene = np.random.default_rng(1), co.Scene([shape.rotate((1, 2, 3), 25).translate((1, -2, 0.5))])
    low, high = scene.extent
    directions = rng.normal(size=(40, 3))
    hits = scene.first_hit((low + np.array(high)) / 2 - 3 * directions, directions)
    known = {}
    for point, surface in zip(hits.point[hits.hit], hits.surface[hits.hit].tolist(), strict=True):
        known.setdefault(surface, scene.surface(surface))
        residue, size = value(known[surface].coefficients, point)
        assert abs(residue) <= 1e-12 * size
        assert any(owner.body == 0 for owner in known[surface].owners)


def test_the_face_of_a_hit_is_an_owner():
    block = co.Box((-1, -1, -1), (1, 1, 1)) - co.Sphere(0.5, (1, 0, 0))
    scene = co.Scene([co.Body(block, name="block"), co.Body(co.Sphere(0.5, (1, 0, 0)), name="ball")])
    hit = scene.first_hit((0.8, 0, 0), (-1, 0, 0), t_max=5)
    surface = scene.surface(hit.surface)
    # The dent and the ball in it are one surface: face 6 of the block, outside; face 0 of the ball, inside
    assert [(o.body, o.name, o.face, o.side) for o in surface.owners] == [(0, "block", 6, -1), (1, "ball", 0, 1)]
    assert surface.equation == "(x − 1)² + y² + z² = 0.25"
    assert str(surface).splitlines()[-1] == "shared by face 6 of body 0 'block', face 0 of body 1 'ball'"


def test_abutting_boxes_share_a_plane():
    scene = co.Scene([co.Box((0, 0, 0), (1, 1, 1)), co.Box((1, 0, 0), (2, 1, 1))])
    shared = [scene.surface(k) for k in range(len(scene._prepared.lowered.tables.surface_kind))]
    wall = next(one for one in shared if one.equation == "x − 1 = 0")
    assert [(o.body, o.face, o.side) for o in wall.owners] == [(0, 1, 1), (1, 0, -1)]
    assert wall.kind == "plane"
    assert len({one.equation for one in shared}) == len(shared) == 7


def test_sheets_and_bulk_balls_own_surfaces():
    scene = co.Scene([co.Disc((0, 0, 1), (0, 0, -1), 2), co.Spheres([(0, 0, 5), (3, 0, 5)], 1.0),
                      co.Triangle((0, 0, 9), (1, 0, 9), (0, 1, 9))])  # fmt: skip
    found = [scene.surface(scene.first_hit((x, y, 20), (0, 0, -1), t_min=t).surface) for x, y, t in
             ((0.1, 0.1, 0), (3, 0, 0), (1.5, 0, 0))]  # fmt: skip
    assert [(s.kind, [(o.body, o.face, o.side) for o in s.owners]) for s in found] == [
        ("plane", [(3, 0, 1)]), ("sphere", [(2, 0, 1)]), ("plane", [(0, 0, -1)]),
    ]  # fmt: skip
    assert found[1].equation == "(x − 3)² + y² + (z − 5)² = 1"


@pytest.mark.parametrize(("matrix", "kind"), [
    (dict(xx=1, yy=-1), "crossing planes"), (dict(xx=1, constant=-4), "parallel planes"),
    (dict(x=1, y=2, constant=-3), "plane"), (dict(xy=1, z=-1), "hyperbolic paraboloid"),
])  # fmt: skip
def test_degenerate_quadrics(matrix, kind):
    assert co.Scene([co.Quadric(coefficients=matrix)]).surface(0).kind == kind
    assert co.Scene([co.Quadric(coefficients=matrix).rotate((1, 1, 0), 33)]).surface(0).kind == kind


def test_numbers_that_are_none():
    scene = co.Scene([co.Sphere()])
    for call, error, message in (
        (lambda: scene.surface(-1), IndexError, "-1 stands for a miss"),
        (lambda: scene.surface(1), IndexError, "below 1, got 1"),
        (lambda: scene.surface(np.array([0, 0])), TypeError, "number must be one integer"),
    ):
        with pytest.raises(error, match=message):
            call()
    assert scene.surface(np.int32(0)).number == 0


def test_every_body_of_a_lattice_owns_the_plane_that_it_ends_at(tmp_path):
    """The lower faces of all bodies lie in the plane z = -182.88 cm that bounds the core from below."""
    write_core(tmp_path / "geometry.xml", 2, pins=5)
    scene = co.load(tmp_path / "geometry.xml")
    hit = scene.first_hit((0.1, 0.2, -500), (0, 0, 1))
    found = scene.surface(hit.surface)
    assert found.equation == "z + 182.88 = 0"
    assert [owner.body for owner in found.owners] == list(range(scene.body_count))
    assert {owner.side for owner in found.owners} == {-1}
    assert [owner.name for owner in found.owners] == [body.name for body in scene.bodies]
    pellet = scene.surface(scene.first_hit((3.19 + 1.26, 3.19, 0), (1, 0, 0)).surface)
    assert sorted(owner.side for owner in pellet.owners) == [-1, 1]  # the fuel and the gap around it
