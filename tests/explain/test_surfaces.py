"""Surfaces of a scene: equations in the world, kinds, owners."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co
from benchmarks.comparison.scenes import write_core

from ..booleans.random_solids import EXAMPLES


def value(coefficients, point):
    """The polynomial at a point, by its named coefficients."""
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
    """With the error bound of the point times the gradient, which is at most as large as the terms' sizes say."""
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
    # The dent and the ball that made it are one surface: face 6 of the block, outside; face 0 of the ball, inside
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
    with pytest.raises(IndexError, match="-1 stands for a miss"):
        scene.surface(-1)
    with pytest.raises(IndexError, match="below 1, got 1"):
        scene.surface(1)
    with pytest.raises(TypeError, match="number must be one integer"):
        scene.surface(np.array([0, 0]))
    assert scene.surface(np.int32(0)).number == 0


def test_every_body_of_a_lattice_owns_the_plane_that_it_ends_at(tmp_path):
    """All stand on the plane z = -182.88 cm that bounds the core from below, with their lower faces."""
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
