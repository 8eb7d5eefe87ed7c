"""Random trees: points along rays against the Boolean formula, spans against interval algebra, crossings in order."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..samples import sampled
from .intervals import expected, same, table, without_hairs
from .leaves import MANY_DIGITS
from .rays import mixed_rays, random_rays
from .trees import Node, tree, world_leaves

BAND = 1e-12
MOST_LEAVES = 150
FEW_LEAVES = 50
POINTS = 16


def assert_spans_follow_from_those_of_the_leaves(node: Node, rays: Any) -> tuple[Any, Any]:
    """To the bit, on every ray, also where faces, edges and corners coincide."""
    scene = co.Scene([node.shape, *world_leaves(node)])
    spans = scene.spans(*rays, t_min=-math.inf)
    found = table(spans, 0)
    agree = same(without_hairs(found), without_hairs(expected(node, spans, 1)))
    wrong = np.flatnonzero(~agree)
    assert agree.all(), (
        f"{len(wrong)} rays, the first from {rays[0][wrong[0]].tolist()} along {rays[1][wrong[0]].tolist()}"
    )
    return found


def points_along(r: np.random.Generator, rays: Any, ends: Any) -> Any:
    """Parameters (rays, POINTS): half near the origin's side of space, half close to the ends of spans."""
    o, d = rays
    speed = np.linalg.norm(d, axis=1, keepdims=True)
    middle = -(o * d).sum(axis=1, keepdims=True) / speed**2
    anywhere = middle + r.uniform(-4, 4, (len(o), POINTS // 2)) / speed
    chosen = np.take_along_axis(ends, r.integers(0, ends.shape[1], (len(o), POINTS // 2)), axis=1)
    close = (
        np.where(np.isfinite(chosen), chosen, middle)
        + r.choice([-1, 1], chosen.shape) * 10 ** r.uniform(-12, 0, chosen.shape) / speed
    )
    return np.concatenate([anywhere, close], axis=1)


def assert_points_follow_the_formula(r: np.random.Generator, node: Node, rays: Any, found: tuple[Any, Any]) -> int:
    """No exception away from a band of 1e-12 (relative) around crossings, in t or in space. Returns how many were compared."""
    o, d = rays
    ends = np.concatenate(found, axis=1)
    t = points_along(r, rays, ends)
    scale = np.abs(t) + (np.abs(o).max(axis=1) / np.abs(d).max(axis=1))[:, None]
    clear = (np.abs(t[..., None] - ends[:, None]) > BAND * scale[..., None]).all(axis=2)
    inside = ((found[0][:, None] < t[..., None]) & (t[..., None] < found[1][:, None])).any(axis=2)
    truth = node.inside([o[:, k, None] + t * d[:, k, None] for k in range(3)])
    # Where rounding may have decided, ask again in 60 digits
    doubtful = np.nonzero((truth != inside) & clear)
    exact = exactly(o[doubtful[0]], d[doubtful[0]], t[doubtful])
    wrong = node.inside(exact) != inside[doubtful]
    if wrong.any():
        # A ray that grazes a surface, or runs within it, is in that band over more than 1e-12 of its own length
        sizes = np.linalg.norm(o, axis=1)[:, None] + np.abs(t) * np.linalg.norm(d, axis=1)[:, None]
        wrong[wrong] = node.distance([p[wrong] for p in exact]) > BAND * sizes[doubtful][wrong]
    if wrong.any():
        ray, k = (index[wrong][0] for index in doubtful)
        pytest.fail(
            f"{wrong.sum()} points, the first at t = {t[ray, k]!r} on the ray from {o[ray].tolist()} along {d[ray].tolist()}"
        )
    return int(clear.sum())


def exactly(origins: Any, directions: Any, t: Any) -> list[Any]:
    """Three arrays of mpf: the coordinates of origins + t directions."""
    many = np.frompyfunc(MANY_DIGITS.mpf, 1, 1)
    return [many(origins[:, k]) + many(t) * many(directions[:, k]) for k in range(3)]


def assert_crossings_are_in_order(node: Node, rays: Any, found: tuple[Any, Any]) -> None:
    """Enter and leave in turn, at the ends of spans; an even number where the solid is bounded."""
    crossings = co.Scene([node.shape]).crossings(*rays, t_min=-math.inf)
    counts, starts = np.diff(crossings.offsets), crossings.offsets[:-1]
    ray = np.repeat(np.arange(len(counts)), counts)
    first = np.isneginf(found[0][:, 0])
    place = np.arange(len(ray)) - starts[ray]
    assert np.array_equal(crossings.entering, (place + first[ray]) % 2 == 0)
    inner = np.diff(crossings.t)[np.diff(ray) == 0]
    assert (inner >= 0).all()  # told apart exactly, they may round to one float
    if np.isfinite(node.shape.bounds).all():
        assert (counts % 2 == 0).all()
    ends = np.sort(np.concatenate(found, axis=1), axis=1)
    assert np.array_equal(np.isfinite(ends).sum(axis=1), counts)


def check(seed: int, count: int, *, grid: bool, most: int = MOST_LEAVES) -> int:
    """Compare one tree on some rays; returns how many points were compared, 0 for a tree of more than `most` leaves."""
    r = np.random.default_rng(seed)
    node = tree(r, int(r.integers(1, 9)), grid=grid)
    if sum(1 for _ in node.leaves()) > most:
        return 0
    rays = (mixed_rays if grid else random_rays)(r, count)
    found = assert_spans_follow_from_those_of_the_leaves(node, rays)
    assert_crossings_are_in_order(node, rays, found)
    return assert_points_follow_the_formula(r, node, rays, found)


@pytest.mark.parametrize("seed", sampled(range(16), 4))
def test_random_trees(seed: int):
    check(seed, 300, grid=False, most=FEW_LEAVES)


@pytest.mark.parametrize("seed", sampled(range(1000, 1032), 5))
def test_trees_on_a_grid(seed: int):
    check(seed, 400, grid=True, most=FEW_LEAVES)


@pytest.mark.deep
@pytest.mark.parametrize("grid", [False, True], ids=["random", "grid"])
@pytest.mark.parametrize("block", range(12))
def test_ten_million_points(block: int, grid: bool):
    """24 blocks of some 40 trees: over 10⁷ points, to the letter."""
    seeds = np.arange(40) + 10_000 + 100 * block + 5000 * grid
    assert sum(check(int(seed), 900, grid=grid) for seed in seeds) > 420_000


@pytest.mark.parametrize("seed", sampled(range(6), 3))
def test_contains_is_the_formula(seed: int):
    r = np.random.default_rng(seed)
    node = tree(r, 4)
    points = r.uniform(-2.5, 2.5, (2000, 3))
    contains = co.Scene([node.shape]).contains(points)
    doubtful = node.inside(list(points.T)) != contains
    exact = exactly(points[doubtful], points[doubtful], np.zeros(doubtful.sum()))
    assert np.array_equal(node.inside(exact), contains[doubtful])


def test_first_hits_are_the_first_crossings():
    for seed in range(4):
        r = np.random.default_rng(seed)
        node, rays = tree(r, 4, grid=seed % 2 == 0), mixed_rays(r, 300)
        scene = co.Scene([node.shape])
        hits, crossings = scene.first_hit(*rays), scene.crossings(*rays)
        some = np.diff(crossings.offsets) > 0
        first = crossings.offsets[:-1][some]
        assert np.array_equal(np.isfinite(hits.t), some)
        assert np.array_equal(hits.t[some], crossings.t[first])
        assert np.array_equal(hits.face[some], crossings.face[first])
        assert np.array_equal(hits.entering[some], crossings.entering[first])
        assert np.array_equal(scene.occluded(*rays), some)
