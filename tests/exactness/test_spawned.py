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
