"""Closed solids are crossed an even number of times, and occlusion says what the first hit says, on every hard ray."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

from ..reference.items import Item
from ..reference.random_shapes import Random, generator
from ..reference.whole_items import SCENES, SOLIDS
from ..reference.whole_rays import nudged, whole_rays
from ..samples import drawn

KINDS = [
    kind
    for kind in (*SOLIDS, "Boolean", "Shared", "Tree")
    if kind not in ("DoubleCone", "HalfSpace", "ParabolicCylinder")
]


def closed(kind: str, r: Random) -> Item:
    """Return a bounded solid of a kind that is not empty."""
    while True:
        (item,) = SCENES[kind](r)
        low, high = item.shape(co).bounds
        if np.isfinite([low, high]).all() and (low < high).all():
            return item


def check(kind: str, number: int, count: int) -> int:
    """Return how many crossings there are on hard rays, half of them a little off."""
    r = generator(f"parity {kind}", number)
    item = closed(kind, r)
    rays = whole_rays(r, [item], count // 2)
    origins, directions = (np.concatenate(pair) for pair in zip(rays, nudged(r, *rays), strict=True))
    scene = co.Scene([item.shape(co)])
    crossings = scene.crossings(origins, directions, t_min=-math.inf)
    counts = np.diff(crossings.offsets)
    odd = np.flatnonzero(counts % 2)
    assert not len(odd), (item, origins[odd[0]], directions[odd[0]])
    assert (crossings.entering == (np.arange(len(crossings.t)) % 2 == 0)).all(), item
    spans = scene.spans(origins, directions, t_min=-math.inf)
    assert np.array_equal(2 * spans.offsets, crossings.offsets), item
    assert np.array_equal(np.stack([spans.t_enter, spans.t_exit], axis=1).ravel(), crossings.t), item
    ahead, hits = scene.crossings(origins, directions), scene.first_hit(origins, directions)
    some = np.diff(ahead.offsets) > 0
    assert np.array_equal(scene.occluded(origins, directions), hits.hit), item
    assert np.array_equal(hits.hit, some), item
    assert np.array_equal(hits.t[some], ahead.t[ahead.offsets[:-1][some]]), item
    assert np.isfinite(hits.normal[some]).all(), item
    return len(crossings.t)


@pytest.mark.parametrize("kind", KINDS)
def test_even_on_hard_rays(kind):
    assert sum(check(kind, number, 200) for number in range(3))


@pytest.mark.deep
@pytest.mark.parametrize("kind", KINDS)
def test_even_on_many_hard_rays(kind):
    for number in drawn(range(3, 32), 4, kind):
        check(kind, number, 20_000)
