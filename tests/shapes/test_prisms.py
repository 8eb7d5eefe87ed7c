"""Prisms and corner cubes by what they do with light, and walls of solids as open sheets."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.cell import Cell, Face
from conicoid.geometry.shape import REGISTERED, PrimitiveSolid
from conicoid.geometry.surface import PlaneSurface


def bent(scene, rays, steps):
    """Rays refracted (a pair of indices) or reflected (None), one after the other."""
    for step in steps:
        hits = scene.first_hit(rays)
        assert hits.hit.all()
        if step is None:
            rays = hits.spawn(co.reflect(rays.directions, hits.normal))
        else:
            ways, total = co.refract(rays.directions, hits.normal, step[0] / step[1])
            assert not total.any()
            rays = hits.spawn(ways)
    return rays


@pytest.mark.parametrize(("apex", "index"), [(60, 1.5168), (30, 1.7), (90, 1.3)])
def test_the_least_deviation_of_a_prism(apex, index):
    """n = sin((a + d) / 2) / sin(a / 2): the ray within is parallel to the base."""
    half = math.radians(apex / 2)
    d = 2 * math.asin(index * math.sin(half)) - 2 * half
    way = np.array([0, math.sin(d / 2), math.cos(d / 2)])
    scene = co.Scene([co.Prism(apex, 10, 8)])
    out = bent(scene, co.Rays([np.array([1, 0.5, 0]) - 30 * way], [way]), [(1, index), (index, 1)])
    assert out.directions[0] / np.linalg.norm(out.directions[0]) == pytest.approx([0, -way[1], way[2]], abs=1e-14)


def test_the_angle_at_the_apex_and_the_sizes():
    prism = co.Prism(50, 10, 8)
    half = math.radians(25)
    low, high = prism.bounds
    assert high == pytest.approx([4, 5 * math.cos(half), 10 * math.sin(half)], rel=1e-15)
    assert low == pytest.approx(-high, rel=1e-15)
    found = co.Scene([prism]).first_hit([(0, 0, -20), (0, 0, 20), (0, -20, 0), (-20, 0, 0), (20, 0, 0)], [(0, 0, 1), (0, 0, -1), (0, 1, 0), (1, 0, 0), (-1, 0, 0)])  # fmt: skip
    assert found.face.tolist() == [0, 1, 2, 3, 4]
    assert math.degrees(math.acos(-found.normal[0] @ found.normal[1])) == pytest.approx(50, rel=1e-14)


@pytest.mark.parametrize("tilt", [0, 3, -5])
def test_a_penta_prism_turns_by_a_right_angle_however_it_stands(tilt):
    index, t = 1.5168, math.radians(tilt)
    way = np.array([0, math.sin(t), math.cos(t)])
    rng = np.random.default_rng(1)
    on_face = np.column_stack([rng.uniform(-2, 2, 100), rng.uniform(1, 4, 100), np.zeros(100)])
    rays = co.Rays(on_face - 9 * way, np.tile(way, (100, 1)))
    out = bent(co.Scene([co.PentaPrism(5, 6)]), rays, [(1, index), None, None, (index, 1)])
    ways = out.directions / np.linalg.norm(out.directions, axis=1)[:, None]
    assert np.abs(ways @ way).max() < 1e-14
    assert ways == pytest.approx(np.tile([0, -way[2], way[1]], (100, 1)), abs=1e-14)


def test_a_full_beam_passes_the_penta_prism():
    rng = np.random.default_rng(2)
    rays = co.Rays(np.column_stack([rng.uniform(-3, 3, 500), rng.uniform(0, 5, 500), np.full(500, -4.0)]), (0, 0, 1))
    scene = co.Scene([co.PentaPrism(5, 6.5)])
    faces = []
    for step in ([(1, 1.5)], [None], [None]):
        faces.append(scene.first_hit(rays).face)
        rays = bent(scene, rays, step)
    assert [set(face.tolist()) for face in (*faces, scene.first_hit(rays).face)] == [{0}, {2}, {3}, {1}]


def test_a_corner_cube_sends_light_back():
    rng = np.random.default_rng(3)
    ways = rng.uniform(-0.2, 0.2, (400, 3)) + (0, 0, 1)
    rays = co.Rays(rng.uniform(-0.5, 0.5, (400, 3)) * (1, 1, 0) - 5 * ways, ways)
    out = bent(co.Scene([co.CornerCube(3)]), rays, [(1, 1.5), None, None, None, (1.5, 1)])
    back = out.directions / np.linalg.norm(out.directions, axis=1)[:, None]
    assert back == pytest.approx(-ways / np.linalg.norm(ways, axis=1)[:, None], abs=2e-15)
    assert np.array(co.CornerCube(3).bounds) == pytest.approx(
        np.array([[-math.sqrt(18), -math.sqrt(13.5), 0], [math.sqrt(4.5), math.sqrt(13.5), 3]])
    )


def test_a_stop_is_a_ring():
    r = np.linspace(0.013, 3, 300)
    hits = co.Scene([co.Stop(2, 4)]).first_hit(np.column_stack([r, np.zeros(300), np.full(300, -1)]), (0, 0, 1))
    assert np.array_equal(hits.hit, (r > 1) & (r < 2))
    assert (hits.normal[hits.hit] == (0, 0, -1)).all()


SOLIDS = {
    "box": co.Box((-1, -2, 0), (1, 0.5, 1.5)),
    "wedge": co.Cylinder((0, 0, 0), (1, 1, 1), 1, 20, 310, (2, 0, 0)),
    "lens": co.Lens(-2, 1.5, 0.4, 2, front_aperture=1.5, back_aperture=1.8),
    "long lens": co.Lens(1, -1, 4, 1.5, -3, 0),
    "mirror": co.Mirror(-2, -1, 3, 0.5, 0.75),
    "bowls": co.TwoSheetHyperboloid(1, 1, 1, (-2, 3)),
    "moved cone": co.Cone((0, 0, 0), (0, 0, 2), 1, 0.5).rotate("x", 30).scale((1, 2, 0.5)),
    "polar angles": co.SphereSection(1.5, 0.5, (100, 160), 20, 310),
    "beyond a cone": co.SphereSection(1.5, 0.5, (35, 80)),
    "one cone": co.SphereSection(1.5, polar_range=(40, 140)),
    "rings": co.Revolution([(0.5, 0), (2, 0), (1, 1), (1.5, 2), (0.75, 2.5), (0.5, 1)], 30, 200),
    "sections": co.Polycone([(0, 0.5, 1), (1, 0.5, 2), (1, 0.75, 1.5), (2, 0.75, 0.75)], -30, 240),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_the_walls_of_a_solid_are_its_surface(name):
    """All of them together are crossed where the solid is, at the same t, on the same side."""
    solid = SOLIDS[name]
    whole = co.Scene([solid])
    low, high = whole.bounds
    rng = np.random.default_rng(4)
    start, to = (rng.uniform(low - 1, high + 1, (1500, 3)) for _ in range(2))
    found = whole.crossings(start, to - start, t_min=-math.inf)
    faces = sorted(set(found.face.tolist()))
    open_ = co.Scene([co.Wall(solid, face) for face in faces]).crossings(start, to - start, t_min=-math.inf)
    assert len(faces) > 1
    assert np.array_equal(found.offsets, open_.offsets)
    assert np.array_equal(found.t, open_.t)
    assert np.array_equal(found.face, np.array(faces)[open_.body])
    assert np.array_equal(found.entering, open_.entering)


def test_a_wall_cut_by_solids_is_a_thin_mirror():
    """An off-axis piece of a paraboloid z = (x² + y²) / 4 f sends light along -z to its focus, (0, 0, f)."""
    f = 50.0
    dish = co.Wall(co.EllipticParaboloid(1 / (4 * f), 1 / (4 * f)), 0) & co.Cylinder((40, 0, -1), (40, 0, 99), 12.5)
    rng = np.random.default_rng(6)
    rays = co.Rays(
        np.column_stack([rng.uniform(28, 52, 300), rng.uniform(-12, 12, 300), np.full(300, 90.0)]), (0, 0, -1)
    )
    hits = co.Scene([dish]).first_hit(rays)
    assert np.array_equal(hits.hit, np.hypot(rays.origins[:, 0] - 40, rays.origins[:, 1]) < 12.5)
    out = hits[hits.hit].spawn(co.reflect(rays.directions[hits.hit], hits.normal[hits.hit]))
    t = (f - out.origins[:, 2]) / out.directions[:, 2]
    assert np.abs((out.origins + t[:, None] * out.directions)[:, :2]).max() < 1e-12


def test_a_face_on_several_surfaces_is_no_wall():
    """A shape of a user's own may give its faces one number."""

    @dataclass(frozen=True)
    class Slab(PrimitiveSolid):
        def tree(self):
            return Cell(tuple(Face(PlaneSurface((0.0, 0.0, sense), 1.0), 0) for sense in (-1.0, 1.0)))

        def support(self, direction):
            return 99.0 * sum(map(abs, direction))

    REGISTERED.pop("Slab")
    with pytest.raises(ValueError, match=r"Wall: face 0 of Slab is on more than one surface"):
        co.Wall(Slab(), 0)


def test_what_has_no_such_wall_is_refused():
    with pytest.raises(ValueError, match=r"Wall: face must be one of Box's, 0, 1, 2, 3, 4, 5, got 6"):
        co.Wall(co.Box(), 6)
    with pytest.raises(TypeError, match=r"Wall: solid must be a primitive, got Union; Wall\(part, face\) & others"):
        co.Wall(co.Box() | co.Sphere(), 0)
    with pytest.raises(TypeError, match=r"Wall: solid must be a solid, got Disc"):
        co.Wall(co.Disc((0, 0, 0), (0, 0, 1), 1), 0)
