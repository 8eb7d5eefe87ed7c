"""One scene of a kind with all that is asked of it, and how much of it makes a suite."""

from __future__ import annotations

from typing import Any

import numpy as np

import conicoid as co

from .aims import directions, lattice_points, lattice_rays, nudged, picture
from .columns import Array
from .intervals import Interval, ends
from .judge import Asked, Judge
from .kinds import SCENES, Random, generator
from .routes import Routes
from .score import Score

BOUNCES = 2


def scene_score(kind: str, number: int, count: int) -> Score:
    """Lists, first hits, spans, membership, intervals, routes and bounces of `count` rays or some more."""
    r = generator(kind, number)
    judge = Judge(co, SCENES[kind](r))
    origins, d = lattice_rays(r, judge.items, count)
    side = max(8, int(np.sqrt(count / 4)))
    more = picture(r, judge.items, side)
    asked = judge.asked(*(np.concatenate(pair) for pair in zip((origins, d), more, strict=True)))
    _ask(r, asked, len(origins) + np.arange(side * side).reshape(side, side))
    judge.membership(lattice_points(r, judge.items, count // 2))
    off = judge.asked(*nudged(r, origins[: count // 6], d[: count // 6]))
    _ask(r, off, None)
    hits = judge.scene.first_hit(asked.origins[: count // 2], asked.directions[: count // 2])
    for _ in range(BOUNCES):
        hits = bounced(r, judge, hits)
    return judge.score


def _ask(r: Random, asked: Asked, grid: Array | None) -> None:
    good = asked.lists()
    asked.first(good)
    asked.spans(good)
    low, high = ends(r, asked)
    Interval(asked, good, low, high).judge()
    routes = Routes(asked, (low, high) if r.random() < 0.5 else None)
    routes.shuffled(r)
    routes.singles(r, 4)
    if grid is not None:
        routes.picture(grid)


def bounced(r: Random, judge: Judge, hits: Any) -> Any:
    """Rays from hits in directions of the lattice, along and across the surfaces."""
    hits = hits[np.isfinite(hits.t)]
    if not len(hits):
        return hits
    d = directions(r, len(hits))
    d = np.where(r.random((len(hits), 1)) < 0.2, co.reflect(hits.rays.directions, hits.normal), d)
    d = np.where(np.abs(d) < 1e-90, 0.0, d)
    d = np.where(d.any(axis=1, keepdims=True), d, 1.0)
    start = np.array(
        [judge.faces[b].get(f, -1) for b, f in zip(hits.body.tolist(), hits.face.tolist(), strict=True)], int
    )
    rays = hits.spawn(d)
    asked = judge.asked(rays.origins, rays.directions, rays, start)
    _ask(r, asked, None)
    return judge.scene.first_hit(rays)


def score(kind: str, numbers: range, count: int) -> Score:
    total = Score()
    for number in numbers:
        total.add(scene_score(kind, number, count))
    return total
