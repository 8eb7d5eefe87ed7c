"""Each kind of body has the same answer to the bit on every route: swept in lanes, in a stream, by single rays."""

import functools

import numpy as np
import pytest

import conicoid as co

from ..reference.random_shapes import generator
from ..reference.whole_items import tree
from .test_routes import FIELDS, assert_same, reordered

COUNT = 16
RED = co.Material((1, 0, 0))


def balls(rng, count, size, reach):
    return [co.Sphere(size, reach * rng.normal(size=3)) for _ in range(count)]


def bodies(kind, rng, s):
    """One body of a kind, about the origin, of size s."""
    box = co.Box((-s, -s, -s), (s, s, s))
    if kind.startswith("union of"):
        return co.Union(tuple(balls(rng, int(kind.split()[-1]), 0.5 * s, 0.5 * s)))
    return {
        "box with flush bores": lambda: (
            box
            - co.Cylinder((0, 0, -s), (0, 0, s), 0.5 * s)
            - co.Cylinder((-s, 0, 0), (s, 0, 0), 0.5 * s)
            - co.Cylinder((0, -s, 0), (0, s, 0), 0.5 * s)
        ),
        "nested": lambda: ((box & co.Sphere(1.2 * s)) - (co.Sphere(0.7 * s) - box.scale(0.5))) | co.Sphere(0.2 * s),
        "a & a - b | b": lambda: ((box & box) - co.Sphere(1.1 * s)) | (co.Sphere(1.1 * s) & box.translate((s, 0, 0))),
        "complement": lambda: ~(~box | co.Sphere(1.2 * s)) | ~(~co.Sphere(0.3 * s)),
        "shared faces": lambda: box | box.translate((2 * s, 0, 0)) | box.translate((0, 2 * s, 0)) - co.Sphere(s),
        "painted cut": lambda: box.painted(RED) - co.Sphere(1.2 * s).painted(RED),
        "wedge": lambda: co.Cylinder((0, 0, -s), (0, 0, s), s, 20, 250, (1, 0, 0)) - co.Sphere(0.5 * s),
        "two spans": lambda: co.OneSheetHyperboloid(9 / s**2, 9 / s**2, 4 / s**2, z_range=(-s, s)) & co.Sphere(s),
        "double cone": lambda: co.DoubleCone(1.0, z_range=(-s, s)) | co.Sphere(0.3 * s),
        "unbounded leaves": lambda: co.HalfSpace((0, 0, 1), 0.2 * s) & co.Sphere(s) - co.HalfSpace((1, 0, 0), -0.5 * s),
        "clipped sheet": lambda: co.Disc((0, 0, 0), (0, 0, 1), s) - co.Cylinder((0, 0, -s), (0, 0, s), 0.4 * s),
        "polygon in a ball": lambda: co.Polygon([(-s, -s, 0), (s, -s, 0), (0, s, 0)]) & co.Sphere(0.8 * s),
    }[kind]()


KINDS = (
    *(f"union of {n}" for n in (2, 3, 8, 15, 16, 17, 40)),
    "box with flush bores", "nested", "a & a - b | b", "complement", "shared faces", "painted cut", "wedge",
    "two spans", "double cone", "unbounded leaves", "clipped sheet", "polygon in a ball",
)  # fmt: skip


@functools.cache
def scene_of(kind, depth=4):
    """A scene of bodies of a kind, prepared once for all tests of a process; trees have so many levels at most."""
    rng = np.random.default_rng(len(kind))
    if kind == "trees":
        trees = [tree(generator("routes", seed), 1 + seed % depth).shape(co) for seed in range(COUNT)]
        return co.Scene([shape.scale(0.12).translate(rng.uniform(-1, 1, 3)) for shape in trees])
    placed = [
        bodies(kind, rng, 0.2).rotate(rng.normal(size=3), 360 * rng.random()).translate(rng.uniform(-1, 1, 3))
        for _ in range(COUNT - 4)
    ]
    # Some stay along the axes, so that rays run within faces and through edges
    upright = [bodies(kind, rng, 0.25).translate((0.5 * k - 1, 0.5, 1)) for k in range(4)]
    return co.Scene([*placed, *upright])


def rays_of(width):
    """A camera's, and rays along the axes in rows that meet faces, edges and corners."""
    camera = co.Camera((0.1, -0.2, -4), (0, 0, 0), up=(0, 1, 0), field_of_view=42).rays(width, width)
    x, y = np.meshgrid(np.linspace(-1.5, 1.5, width), np.linspace(-1.5, 1.5, width))
    grid = np.round(np.stack([x, y, np.full_like(x, -4.0)], axis=-1) * 16) / 16
    return camera, co.Rays(grid, np.broadcast_to([0.0, 0.0, 1.0], grid.shape))


@pytest.mark.parametrize("kind", [*KINDS, "trees"])
@pytest.mark.parametrize("width", [48, pytest.param(512, marks=pytest.mark.deep)])
def test_every_route_agrees_to_the_bit(kind, width):
    scene, singles = scene_of(kind, 4 if width < 100 else 6), 50
    for rays in rays_of(width):
        order = np.random.default_rng(1).permutation(width * width)
        hits = scene.first_hit(rays)
        assert (hits.body >= 0).any()
        shuffled = reordered(rays, order)
        again = scene.first_hit(shuffled)
        assert_same(hits, again, order)
        some = hits.body.ravel()[order] >= 0
        assert np.array_equal(hits.normal.reshape(-1, 3)[order][some], again.normal[some])
        assert np.array_equal(scene.occluded(rays), hits.t < np.inf)
        assert np.array_equal(scene.occluded(shuffled), again.t < np.inf)
        for k in range(0, width * width, width * width // singles):
            one = scene.first_hit(shuffled[k])
            for field in FIELDS:
                assert getattr(one, field) == getattr(again, field)[k], field


@pytest.mark.parametrize("length", [1.0, 1e-100])
def test_rays_that_begin_just_before_a_wall_of_their_origin_cross_it_at_plus_zero(length):
    """t is 0, never -0.0, on every route; t_min = -1e-250 is before it, however short the direction is."""
    box = co.Box((-1, -1, -1), (1, 1, 1))
    for shape in (
        box, box - co.Sphere(0.5), co.HalfSpace((0, 0, 1), 1), co.Cylinder((0, 0, -1), (0, 0, 1), 1),
        co.Cone((0, 0, -1), (0, 0, 1), 2, 1), co.RegularPrism(4, 3, (-1, 1)), co.Disc((0, 0, 1), (0, 0, 1), 2),
        co.Union(tuple(box.scale((s, s, 1)) for s in np.linspace(0.5, 1, 20))),
    ):  # fmt: skip
        scene = co.Scene([shape])
        for way in ((0, 0, -1), (1, -1, 1)):
            packet = co.Rays(np.tile((0.125, 0.25, 1.0), (3, 1)), length * np.tile(way, (3, 1)))
            away = co.Rays((0.125, 0.25, 7.0), length * np.random.default_rng(2).choice((-1.0, 1.0), (2048, 3)))
            # Together, alone, alone by the short call, and beside rays without order
            for rays in (packet, packet[0], packet[0], co.Rays.concatenate([packet[:1], away])):
                hits, rows = scene.first_hit(rays, t_min=-1e-250), scene.crossings(rays, t_min=-1e-250)
                spans = scene.spans(rays, t_min=-1e-250)
                assert hits.t.ravel()[0] == 0 == rows.t[0], (shape, way)
                for t in (hits.t, rows.t, spans.t_enter, spans.t_exit):
                    assert not np.signbit(t[t == 0]).any(), (shape, way)
