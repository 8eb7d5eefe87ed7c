"""Scenes with the answers of every query about their rays, in the amounts of a suite."""

from collections.abc import Callable, Sequence

import numpy as np

import conicoid as co

from . import aimed_rays
from .aimed_rays import Aim
from .intervals import Interval, ends
from .items import Item
from .judge import Comparison, Judge, Score
from .random_items import SCENES, axis, extreme, ordinary
from .random_shapes import LEAST, MOST, Random, generator, pick
from .routes import Routes
from .trace import Array
from .whole_rays import directions, nudged, picture, whole_points, whole_rays

BOUNCES = 2
BATCH = 500
LEAST_LIMIT = 1e-200
ODD_ANGLES = (1.0, 7.5, 22.5, 33.3, 89.999, 120.5, -0.001, 1e-9, 179.0, 37.0)
"""Angles whose sines are not sums of square roots."""


def compare(r: Random, rays: Comparison, grid: Array | None = None):
    """Compare lists, first hits, spans, intervals and routes; return the first hits."""
    good = rays.lists()
    hits = rays.first()
    rays.spans(good)
    low, high = ends(r, rays.found.offsets, rays.found.t)
    if not rays.judge.far:  # directions have any length: limits beside 0 would be subnormal at their scale
        low, high = (np.where(np.abs(x) < LEAST_LIMIT, 0.0, x) for x in (low, high))
    if rays.spawned:
        low, high = np.maximum(low, 0.0), np.maximum(high, 0.0)
    Interval(rays, good, low, high).judge()
    routes = Routes(rays, (low, high) if r.random() < 0.5 else None)
    routes.shuffled(r)
    routes.singles(r, 4)
    if grid is not None:
        routes.picture(grid)
    return hits


def whole_score(kind: str, number: int, count: int, turned: bool = False) -> Score:
    """Score `count` rays of whole numbers and more: pictures, nearly whole rays, bounces; one turn may move all."""
    r = generator(f"{kind}, turned" if turned else kind, number)
    items = SCENES[kind](r)
    turn = (("rotate", axis(r), float(pick(r, ODD_ANGLES))),) if turned else ()
    judge = Judge(co, [item.moved(*turn) for item in items])
    origins, d = whole_rays(r, items, count)
    side = max(8, int(np.sqrt(count / 4)))
    more = picture(r, items, side)
    rays = judge.rays(*(np.concatenate(pair) for pair in zip((origins, d), more, strict=True)))
    hits = compare(r, rays, len(origins) + np.arange(side * side).reshape(side, side))
    judge.membership(
        np.concatenate([whole_points(r, judge.items, count), rays.origins, rays.origins + rays.directions])
    )
    compare(r, judge.rays(*nudged(r, origins[: count // 6], d[: count // 6])))
    hits = hits[: count // 2]
    for _ in range(BOUNCES):
        hits = bounced(r, judge, hits, lattice(r, hits))
    return judge.score


def random_score(kind: str, sort: Callable[[str, Random], Item], number: int, count: int) -> Score:
    """Score `count` rays that are hard on a random shape, and a bounce of some of them."""
    r = generator(f"{kind} {sort.__name__}", number)
    item = sort(kind, r)
    judge = Judge(co, [item], far=0)  # these may be as thin as they like beside their size
    aim = Aim(judge.table, item.world_center, item.world_size, r)
    for begin in range(0, count, BATCH):
        origins, d = aimed_rays.rays(aim, min(BATCH, count - begin))
        order = r.permutation(len(d))
        rays = judge.rays(origins[order], d[order])
        side = int(np.sqrt(len(d)))
        hits = compare(r, rays, np.arange(side * side).reshape(side, side))
        points = np.concatenate([rays.origins, rays.origins + rays.directions, hits.point[np.isfinite(hits.t)]])
        points = np.where(np.abs(points) < LEAST, 0.0, points)
        judge.membership(points[(np.abs(points) <= MOST).all(axis=1)])
        hits = hits[: len(d) // 4]
        bounced(r, judge, hits, onward(r, hits))
    return judge.score


def lattice(r: Random, hits) -> Array:
    """Return directions along and across the surfaces of whole numbers."""
    d = directions(r, len(hits.t))
    d = np.where(r.random((len(d), 1)) < 0.2, co.reflect(hits.rays.directions, hits.normal), d)
    return np.where(np.abs(d) < 1e-90, 0.0, d)


def onward(r: Random, hits) -> Array:
    """Return directions at random, mirrored, straight on, and nearly along the surface."""
    count = len(hits.t)
    wild = aimed_rays.directions(r, count)
    along = wild - (wild * hits.normal).sum(axis=1, keepdims=True) * hits.normal
    grazing = along + hits.normal * r.choice([-1, 1], (count, 1)) * 2.0 ** -r.integers(1, 40, (count, 1))
    kinds = np.stack([wild, grazing, co.reflect(hits.rays.directions, hits.normal), hits.rays.directions])
    d = kinds[r.integers(len(kinds), size=count), np.arange(count)]
    return d / np.abs(d).max(axis=1, keepdims=True)


def bounced(r: Random, judge: Judge, hits, d: Array):
    """Compare rays from hits on; return the next hits."""
    some = np.isfinite(hits.t)
    hits, d = hits[some], d[some]
    if not len(hits):
        return hits
    rays = hits.spawn(np.where(d.any(axis=1, keepdims=True), d, 1.0))
    start = [judge.table.faces[b].get(f, -1) for b, f in zip(hits.body.tolist(), hits.face.tolist(), strict=True)]
    return compare(r, judge.rays(rays.origins, rays.directions, rays, np.array(start, int)))


def total(scores: Sequence[Score]) -> Score:
    result = Score()
    for score in scores:
        result.add(score)
    return result


__all__ = ["bounced", "compare", "extreme", "ordinary", "random_score", "total", "whole_score"]
