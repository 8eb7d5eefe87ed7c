"""Hard rays have the same answers to the bit, errors and all, on every route and any number of threads."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co

from ..oracle.samples import KINDS
from .aim import Aim
from .cases import extreme, generator, ordinary
from .families import rays
from .nice import lattice_rays, nice_case

FIELDS = ("t", "t_error", "point", "point_error", "body", "face", "surface", "entering", "normal")
WIDTH = 40


def scene_and_rays(kind: str, sort):
    random = generator(f"routes {kind} {sort.__name__}", 0)
    case = sort(kind, random)
    o, d = lattice_rays(random, WIDTH * WIDTH) if sort is nice_case else rays(Aim(case, random), WIDTH * WIDTH)
    order = np.resize(np.random.default_rng(3).permutation(len(o)), WIDTH * WIDTH)
    return co.Scene([case.shape(co)]), o[order], d[order]


def same(one, other, order=slice(None)):
    for field in FIELDS:
        a, b = (getattr(hits, field) for hits in (one, other))
        last = a.shape[len(one.rays.shape) :]
        assert np.array_equal(a.reshape(-1, *last)[order], b.reshape(-1, *last), equal_nan=True), field


@pytest.mark.parametrize("sort", [ordinary, extreme, nice_case], ids=lambda sort: sort.__name__)
@pytest.mark.parametrize("kind", sorted(KINDS))
def test_routes_agree_on_hard_rays(kind, sort):
    scene, o, d = scene_and_rays(kind, sort)
    flat = scene.first_hit(o, d)
    square = (WIDTH, WIDTH, 3)
    same(flat, scene.first_hit(o.reshape(square), d.reshape(square)))
    order = np.random.default_rng(4).permutation(len(o))
    same(flat, scene.first_hit(o[order], d[order]), order)
    for i in order[:40]:
        same(flat, scene.first_hit(o[i], d[i]), [i])
    assert np.array_equal(scene.occluded(o, d), np.isfinite(flat.t))
    crossings = scene.crossings(o, d)
    some = np.diff(crossings.offsets) > 0
    first = crossings.offsets[:-1][some]
    for field in ("t", "t_error", "body", "face", "surface", "entering"):
        assert np.array_equal(getattr(crossings, field)[first], getattr(flat, field)[some]), field
    assert np.array_equal(some, np.isfinite(flat.t))


@pytest.mark.parametrize("kind", ["Cone", "NestedBooleans", "Polygon", "Quadric", "Sphere"])
def test_threads_agree_on_hard_rays(kind):
    scene, o, d = scene_and_rays(kind, ordinary)
    o, d = np.tile(o, (8, 1)), np.tile(d, (8, 1))
    expected = None
    try:
        for threads in (1, 2, 4):
            co.set_threads(threads)
            hits = scene.first_hit(o, d)
            if expected is None:
                expected = hits
            same(expected, hits)
    finally:
        co.set_threads(None)
