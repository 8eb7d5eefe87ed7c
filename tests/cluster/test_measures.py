"""Measures on workers."""

from __future__ import annotations

import numpy as np

import conicoid as co

from . import subject


def test_measures_of_workers_are_the_same():
    scene, lens = subject.scene(), co.Sphere(1) & co.Sphere(1, (0.5, 0.5, 0)) & co.Sphere(1, (0, 0.4, 0.3))
    with co.cluster.Processes(1) as pool:
        far, one = co.measure(scene, rays=600, executor=pool), co.measure(lens, rays=600, executor=pool)
    near = co.measure(scene, rays=600)
    assert np.array_equal(far.volume, near.volume)
    assert np.array_equal(far.volume_error, near.volume_error)
    assert [body.area for body in far] == [body.area for body in near]
    local = co.measure(lens, rays=600)
    assert (one.volume, one.area, one.volume_error) == (local.volume, local.area, local.volume_error)
    assert one.volume_error > 0  # it was sampled
