"""Boolean bodies met in lanes, another in each, as single rays meet them: to the bit, and hardly ever in doubt."""

import numba
import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.body.hit import no_hit, try_entry
from conicoid.kernels.body.scratch import new_scratch
from conicoid.kernels.packet.csg_gather import (
    FORMS,
    body_hit,
    empty_queue,
    form_of,
    meet_bodies,
    new_bodies,
    put_body,
    queue_body,
)
from conicoid.kernels.ray import Ray

pytestmark = pytest.mark.deep  # it compiles both ways; that they agree is also seen by test_routes_of_bodies.py
MISS = -2.0


@numba.njit(error_model="numpy")
def keep(hits, n, hit):
    hits[n, 0], hits[n, 1], hits[n, 2], hits[n, 3], hits[n, 4] = hit[0], hit[1], hit[2], hit[3], hit[4]
    hits[n, 5], hits[n, 6], hits[n, 7] = hit[5], hit[6], hit[7]


@numba.njit(error_model="numpy")
def one_by_one(geometry, rays, more, entries, hits):
    """The hit of each ray with its body, by the code of single rays."""
    scratch = new_scratch(geometry)
    for n in range(len(hits)):
        r, m = rays[8 * n :], more[8 * n :]
        ray = Ray(r[0], r[1], r[2], m[0], m[1], m[2], r[6], m[5], np.int64(m[4]))
        keep(hits, n, try_entry(geometry, scratch, entries[n], ray, no_hit()))


@numba.njit(error_model="numpy")
def in_lanes(geometry, rays, more, entries, programs, most, hits):
    """The same in lanes, up to `most` of a form at a time, where so many forms are kept; -2: a ray is off the list."""
    bodies, counts = new_bodies(geometry, most), np.zeros(FORMS, np.int64)
    hits[:] = MISS
    for n in range(len(hits) + FORMS):
        form = n - len(hits)
        if n < len(hits):
            form = form_of(geometry, bodies, programs[n])
            if form < 0:
                hits[n, 0] = np.nan
                continue
            put_body(bodies, form, n, entries[n])
            counts[form] += 1
            if counts[form] < most:
                continue
        count = empty_queue(bodies, form)
        for k in range(meet_bodies(geometry, bodies, form, rays, more, count) if count > 0 else 0):
            keep(hits, queue_body(bodies, form, k)[0], body_hit(geometry, bodies, form, k))
        counts[form] = 0


def shapes(kind, rng, count):
    """Bodies of one form, or of many, turned and moved."""
    made = []
    for k in range(count):
        ball, box = co.Sphere(1), co.Box((-0.75, -0.75, -0.75), (0.75, 0.75, 0.75))
        bore = co.Cylinder((-1, 0, 0), (1, 0, 0), 0.4)
        shape = {
            "bored": lambda ball=ball, box=box, bore=bore: (ball & box) - bore - bore.rotate((0, 0, 1), 90),
            "union": lambda ball=ball, box=box: (box - ball.scale(0.9)) | ball.scale(0.3),
            "cone": lambda ball=ball: co.DoubleCone(1.0, z_range=(-0.7, 0.7)) - ball.scale(0.4),
            "many": lambda k=k, ball=ball, box=box, bore=bore: (
                (ball & box) - bore if k % 3 else (box - ball) | ball.scale(0.5 + 0.01 * k)
            ),
        }[kind]()
        turned = shape.rotate(rng.normal(size=3), float(rng.uniform(0, 360))) if k % 2 else shape
        made.append(turned.scale(float(rng.uniform(0.2, 0.5))).translate(rng.uniform(-1, 1, 3)))
    return made


@pytest.mark.parametrize("kind", ["bored", "union", "cone", "many"])
@pytest.mark.parametrize("most", [3, 64])
def test_bodies_are_met_in_lanes_as_by_single_rays(kind, most):
    """Rays from anywhere, and from the surfaces of the bodies; short ones too."""
    rng = np.random.default_rng(most)
    scene = co.Scene(shapes(kind, rng, 12))
    geometry, tables = scene._prepared.geometry, scene._prepared.lowered.tables
    origins = rng.uniform(-2, 2, (3000, 3))
    first = scene.first_hit(origins, rng.uniform(-1, 1, (3000, 3)) - origins)
    on = np.flatnonzero(first.hit)[:600]
    origins = np.concatenate([first.point[on], rng.uniform(-2, 2, (900, 3))])
    count, starts = len(origins), np.concatenate([first.surface[on], np.full(900, -1)])
    entries = np.concatenate([first.body[on], rng.integers(0, 12, 900)]).astype(np.int64)
    target = np.array([np.mean(body.shape.bounds, axis=0) for body in scene.bodies])[entries]
    directions = target + rng.normal(scale=0.3, size=(count, 3)) - origins
    rays, more = np.zeros((count, 8)), np.zeros((count, 8))
    rays[:, :3], rays[:, 6], more[:, :3] = origins, 0.0, directions
    more[:, 3], more[:, 4] = 1.0 / np.sum(directions * directions, axis=1), starts
    more[:, 5], more[:, 6] = np.where(np.arange(count) % 5, np.inf, 0.8), np.inf
    rays[:, 7] = more[:, 5]
    programs, (single, lanes) = tables.entry_index[entries].astype(np.int64), np.empty((2, count, 8))
    one_by_one(geometry, rays.ravel(), more.ravel(), entries, single)
    in_lanes(geometry, rays.ravel(), more.ravel(), entries, programs, most, lanes)
    assert not np.isnan(lanes[:, 0]).any()
    off, unsure = lanes[:, 0] == MISS, lanes[:, 7] == 1.0
    assert np.isinf(single[off, 0]).all()
    assert not single[off, 7].any()
    assert np.mean(unsure) < 0.02
    certain, hit = ~off & ~unsure, np.isfinite(single[:, 0])
    assert np.sum(certain & hit) > 200
    np.testing.assert_array_equal(lanes[certain, 0], single[certain, 0])
    np.testing.assert_array_equal(lanes[certain & hit, 1:], single[certain & hit, 1:])
