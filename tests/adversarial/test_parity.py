"""Closed solids are crossed an even number of times, and occlusion says what the first hit says, on every hard ray."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

from .targets import Target, hard_rays, targets

TARGETS = {target.name: target for target in targets()}


def check(target: Target, origins: np.ndarray, directions: np.ndarray) -> None:
    scene = co.Scene([target.shape])
    crossings = scene.crossings(origins, directions)
    counts = np.diff(crossings.offsets)
    odd = np.flatnonzero(counts % 2)
    assert len(odd) == 0, reproduction(target, origins, directions, crossings, odd)
    whole = np.diff(scene.crossings(origins, directions, t_min=-math.inf).offsets)
    odd = np.flatnonzero(whole % 2)
    assert len(odd) == 0, reproduction(target, origins, directions, crossings, odd)
    # every crossing is of the other kind than the one before
    first = np.zeros(len(crossings.t), bool)
    first[crossings.offsets[:-1][counts > 0]] = True
    assert crossings.entering[first].all()
    assert (crossings.entering[1:] != crossings.entering[:-1])[~first[1:]].all()
    hits = scene.first_hit(origins, directions)
    assert np.array_equal(scene.occluded(origins, directions), np.isfinite(hits.t))
    assert np.array_equal(np.isfinite(hits.t), counts > 0)
    assert np.array_equal(hits.t[counts > 0], crossings.t[first])
    assert np.isfinite(hits.normal[counts > 0]).all()


def reproduction(target, origins, directions, crossings, odd):
    i = odd[0]
    of = slice(crossings.offsets[i], crossings.offsets[i + 1])
    return (
        f"{target.name}: {len(odd)} of {len(origins)} rays have an odd number of crossings; the first has origin {origins[i].tolist()}, "
        f"direction {directions[i].tolist()}, t {crossings.t[of].tolist()}, face {crossings.face[of].tolist()}"
    )


@pytest.mark.parametrize("name", TARGETS)
def test_even_on_hard_rays(name):
    check(TARGETS[name], *hard_rays(TARGETS[name], 16_000 // len(TARGETS) + 1))


@pytest.mark.deep
@pytest.mark.parametrize("name", TARGETS)
def test_even_on_ten_million_hard_rays(name):
    share = 10_000_000 // len(TARGETS) + 1
    for seed, start in enumerate(range(0, share, 50_000)):
        check(TARGETS[name], *hard_rays(TARGETS[name], min(50_000, share - start), seed + 1))


@pytest.mark.parametrize("name", TARGETS)
def test_spans_and_crossings_agree_on_hard_rays(name):
    origins, directions = hard_rays(TARGETS[name], 600, 99)
    scene = co.Scene([TARGETS[name].shape])
    spans, crossings = scene.spans(origins, directions), scene.crossings(origins, directions)
    assert np.array_equal(2 * np.diff(spans.offsets), np.diff(crossings.offsets))
    ends = np.stack([spans.t_enter, spans.t_exit], axis=1).ravel()
    assert np.array_equal(ends, crossings.t)
    assert not spans.enter_clipped.any()
    assert not spans.exit_clipped.any()


def test_abutting_boxes_look_like_one():
    """A union of boxes with common walls is crossed as the box that they make."""
    union, whole = TARGETS["abutting boxes"], co.Scene([co.Box((-1, -1, -1), (1, 2, 1))])
    origins, directions = hard_rays(union, 20_000, 7)
    parts, one = co.Scene([union.shape]).spans(origins, directions), whole.spans(origins, directions)
    assert np.array_equal(parts.offsets, one.offsets)
    assert np.array_equal(parts.t_enter, one.t_enter)
    assert np.array_equal(parts.t_exit, one.t_exit)
