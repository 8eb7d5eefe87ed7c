"""Rays that start on a surface: the binary ray against everything, with the one root removed that it starts on."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co

from ..oracle.samples import KINDS
from .aim import Aim, directions
from .cases import extreme, generator, ordinary
from .exact import ExactRay, as_pair, distance
from .families import aimed
from .places import learn, off_surface
from .traced import crossings


def onward(random, hits):
    """At random, mirrored, straight on, and nearly along the surface."""
    count = len(hits.t)
    wild = directions(random, count)
    normal = np.where(np.isfinite(hits.normal), hits.normal, 0.0)
    along = wild - (wild * normal).sum(axis=1, keepdims=True) * normal
    grazing = along + normal * random.choice([-1, 1], (count, 1)) * 2.0 ** -random.integers(1, 40, (count, 1))
    mirrored = np.where(
        np.isfinite(hits.t)[:, None], co.reflect(hits.rays.directions, np.where(normal == 0, wild, normal)), wild
    )
    kinds = np.stack([wild, grazing, mirrored, hits.rays.directions])
    d = kinds[random.integers(len(kinds), size=count), np.arange(count)]
    return d / np.linalg.norm(d, axis=1, keepdims=True)


@pytest.mark.parametrize("cases", [2, pytest.param(40, marks=pytest.mark.deep)])
@pytest.mark.parametrize("sort", [ordinary, extreme], ids=lambda sort: sort.__name__)
@pytest.mark.parametrize("kind", sorted(KINDS))
def test_spawned_rays(kind, sort, cases):
    compared = 0
    for number in range(cases):
        random = generator(f"spawned {kind} {sort.__name__}", number)
        case = sort(kind, random)
        aim = Aim(case, random)
        scene = co.Scene([case.shape(co)])
        hits = scene.first_hit(*aimed(aim, 150))
        hits = hits[np.isfinite(hits.t)]
        if not len(hits):
            continue
        again = scene.first_hit(hits.spawn(onward(random, hits)))
        forms: dict[int, int] = {}
        learn(forms, hits, off_surface(aim.oracle, hits.point)[1])
        for i in range(len(hits)):
            o, d = again.rays.origins[i], again.rays.directions[i]
            found = crossings(aim.oracle.shape, ExactRay(o, d), forms[int(hits.surface[i])])
            ahead = [c for c in found if c.root.sign > 0]
            place = f"{case!r}\n  start {o.tolist()} on form {forms[int(hits.surface[i])]}, direction {d.tolist()}\n  expected {[(as_pair(c.root)[0], c.entering) for c in ahead]}, found {again.t[i]}"
            assert np.isfinite(again.t[i]) == bool(ahead), place
            if ahead:
                assert distance(ahead[0].root, float(again.t[i]))[0] <= again.t_error[i], place
                assert (ahead[0].entering, ahead[0].body) == (again.entering[i], again.body[i]), place
            compared += 1
    assert compared > 30


@pytest.mark.parametrize("far", [1.0, 1e2, 1e4])
@pytest.mark.parametrize("route", ["alone", "flat", "square", "shuffled"])
def test_along_the_outermost_plane_of_many(route, far):
    """The rounded start lies above or below the boxes' common lid, whose plane holds the ray: it runs through them all."""
    random = np.random.default_rng(5)
    ends = [(k + 0.25, k + 0.75) for k in range(20)]
    scene = co.Scene([co.Box((a, -1, -1), (b, 0.2, 1)) for a, b in ends])
    count = 4096
    target = np.stack([random.uniform(0.3, 0.7, count), np.full(count, 0.2), random.uniform(-0.5, 0.5, count)], axis=1)
    to = np.stack([random.uniform(-1, 1, count), -random.uniform(0.3, 1, count), random.uniform(-1, 1, count)], axis=1)
    hits = scene.first_hit(target - far * to, to)
    assert np.isin(hits.face, hits.face[0]).all()
    assert (hits.body == 0).all()
    height = hits.point[:, 1] - 0.2
    assert (height > 0).any()
    assert (height < 0).any()
    along = np.stack([random.uniform(0.5, 2, count), np.zeros(count), random.uniform(-0.01, 0.01, count)], axis=1)
    if route == "alone":
        chosen = np.concatenate([np.argsort(height)[:30], np.argsort(height)[-30:]])
        answers = [(scene.first_hit(ray), scene.crossings(ray)) for ray in (hits.spawn(along)[i] for i in chosen)]
    else:
        order = random.permutation(count) if route == "shuffled" else np.arange(count)
        rays = hits.spawn(along)[order.reshape(64, 64) if route == "square" else order]
        answers, chosen = [(scene.first_hit(rays), scene.crossings(rays))], order
    wall = np.array([x for interval in ends for x in interval][1:])
    expected = (wall - hits.point[chosen, :1]) / along[chosen, :1]
    first = np.concatenate([np.ravel(hit.t) for hit, _ in answers])
    every = np.concatenate([np.ravel(crossing.t) for _, crossing in answers])
    assert np.allclose(first, expected[:, 0], rtol=1e-12)
    assert np.allclose(every.reshape(-1, len(wall)), expected, rtol=1e-12)
