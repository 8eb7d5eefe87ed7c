"""Every shape goes through a scene file and comes back equal, and so do the answers."""

from __future__ import annotations

import math

import numpy as np

import conicoid as co


def test_round_trip(subject, tmp_path):
    path = tmp_path / "scene.yaml"
    co.save(subject.scene, path)
    again = co.load(path)
    assert again == subject.scene
    here, there = (s.crossings(*subject.rays, t_min=-math.inf) for s in (subject.scene, again))
    for name in ("offsets", "t", "body", "face", "surface", "entering"):
        assert np.array_equal(getattr(here, name), getattr(there, name)), name
