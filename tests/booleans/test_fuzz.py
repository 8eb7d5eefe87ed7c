"""Random Booleans of all shapes through every query: no exception, no warning, no hang, and what must hold of any answer."""

from __future__ import annotations

import itertools
import pickle
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..samples import drawn
from .random_solids import random_body

BODIES = 25
"""To a scene: preparing one is what takes time."""
FEW_BODIES = 6
RAYS = 48
LONGEST = 10.0
"""Seconds of a processor for one query of a scene: a hang, not a timing."""


def random_scene(seed: int, number: int, bodies: int) -> tuple[co.Scene, np.random.Generator]:
    rng = np.random.default_rng([seed, number])
    return co.Scene([random_body(rng) for _ in range(bodies)]), rng


def random_rays(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Half of them at random, which meet nothing exactly; half between small whole numbers."""
    origins = np.concatenate([rng.normal(size=(RAYS // 2, 3)) * 5, rng.integers(-4, 5, (RAYS // 2, 3)) * 1.0])
    directions = np.concatenate([rng.normal(size=(RAYS // 2, 3)), rng.integers(-2, 3, (RAYS // 2, 3)) * 1.0])
    directions[~directions.any(axis=1)] = (1.0, 0.0, 0.0)
    return origins, directions


def faults(scene: co.Scene, rng: np.random.Generator, folder: Path, measured: bool) -> Iterator[str]:
    """What is wrong with a scene's answers."""
    clock = Clock()
    origins, directions = random_rays(rng)
    low, high = scene.bounds
    yield from clock("bounds")
    hits = scene.first_hit(origins, directions)
    yield from clock("first_hit")
    occluded = scene.occluded(origins, directions)
    yield from clock("occluded")
    crossings = scene.crossings(origins, directions)
    yield from clock("crossings")
    spans = scene.spans(origins, directions, t_min=-np.inf)
    yield from clock("spans")
    hit = np.isfinite(hits.t)
    if (occluded != hit).any():
        yield f"occluded differs from first_hit: rays {np.flatnonzero(occluded != hit)}"
    yield from first_crossings(hits, crossings)
    yield from sizes_of_errors(hits, crossings, origins, directions)
    if np.isnan([low, high]).any():
        yield f"bounds {low} {high}"
    room = hits.point_error[hit][:, None] + 1e-15 * np.abs(hits.point[hit])
    if not ((hits.point[hit] >= low - room) & (hits.point[hit] <= high + room)).all():
        yield "hits beyond the bounds"
    for k in np.flatnonzero(hit):
        box = scene.bodies[hits.body[k]].shape.bounds
        if (hits.point[k] < box[0] - room.max()).any() or (hits.point[k] > box[1] + room.max()).any():
            yield f"ray {k}: hit at {hits.point[k]} beyond bounds {box} of body {hits.body[k]}"
    yield from clock("bounds of bodies")
    yield from stretches(scene, spans, origins[: RAYS // 2], directions[: RAYS // 2])
    if spans.lengths().shape != (RAYS, len(scene.bodies)):
        yield "lengths"
    lengths = spans.line_integral(np.ones(len(scene.bodies)))
    if not np.allclose(lengths, spans.lengths().sum(axis=1), rtol=1e-12, equal_nan=True):
        yield "line_integral differs from lengths"
    yield from clock("contains and lengths")
    numbers = (hits.normal[hit], hits.local_point[hit], hits.uv[hit], hits.point[hit])
    if not all(np.isfinite(values).all() for values in numbers):
        yield "normal, uv or point is not finite"
    bounced = hits[hit].spawn(hits.normal[hit])
    if (scene.occluded(bounced) != np.isfinite(scene.first_hit(bounced).t)).any():
        yield "occluded differs from first_hit for spawned rays"
    yield from clock("spawn")
    yield from copies(scene, folder)
    yield from clock("files")
    if measured:
        yield from measures(scene)
        co.check(scene, rays=300)


class Clock:
    """Seconds of a processor since it was last asked; the first query of a process compiles."""

    def __init__(self) -> None:
        self.last = time.process_time()

    def __call__(self, what: str) -> Iterator[str]:
        now = time.process_time()
        if now - self.last > LONGEST:
            yield f"{what} took {now - self.last:.1f} s"
        self.last = now


def first_crossings(hits: Any, crossings: Any) -> Iterator[str]:
    for k in range(len(hits.t)):
        begin, end = crossings.offsets[k : k + 2]
        first = (crossings.t[begin], crossings.body[begin]) if end > begin else (np.inf, -1)
        if first != (hits.t[k], hits.body[k]):
            yield f"ray {k}: first hit {hits.t[k]} of {hits.body[k]}, first crossing {first}"
        if (np.diff(crossings.t[begin:end]) < 0).any():
            yield f"ray {k}: crossings out of order"


def sizes_of_errors(hits: Any, crossings: Any, origins: np.ndarray, directions: np.ndarray) -> Iterator[str]:
    """Against t and the ray's own scale, which is what its rounding is measured in."""
    speed = np.linalg.norm(directions, axis=1)
    scale = np.linalg.norm(origins, axis=1) / speed + 1e-3
    ray = np.repeat(np.arange(len(origins)), np.diff(crossings.offsets))
    told = ((range(len(origins)), hits.t, hits.t_error), (ray, crossings.t, crossings.t_error))
    for rays, t, errors in told:
        for k, at, error in zip(rays, t, errors, strict=True):
            if np.isfinite(at) and not error <= 2.0**-20 * (abs(at) + scale[k]):
                yield f"ray {k}: t {at} with an error of {error}"


def stretches(scene: co.Scene, spans: Any, origins: np.ndarray, directions: np.ndarray) -> Iterator[str]:
    """Middles of spans are inside, middles of gaps between them outside."""
    points, inside, body = [], [], []
    for k in range(len(origins)):
        rows = slice(*spans.offsets[k : k + 2])
        enter, leave, bodies = spans.t_enter[rows], spans.t_exit[rows], spans.body[rows]
        ends = np.unique(np.clip(np.concatenate([enter, leave, [-50, 50]]), -50, 50))
        for a, b in itertools.pairwise(ends):
            if b - a > 1e-5:
                middle = a + (b - a) * 0.41
                within = (enter < middle) & (leave > middle)
                points.append(origins[k] + middle * directions[k])
                inside.append(within.any())
                body.append(bodies[within].min() if within.any() else -1)
    found = scene.body_at(np.array(points))
    if (found != body).any():
        wrong = np.flatnonzero(found != body)
        yield f"{len(wrong)} points: spans say {np.array(body)[wrong][:3]}, body_at {found[wrong][:3]} at {np.array(points)[wrong][0]}"
    if (scene.contains(np.array(points)) != inside).any():
        yield "contains differs from spans"


def copies(scene: co.Scene, folder: Path) -> Iterator[str]:
    path = folder / "scene.yaml"
    co.save(scene, path)
    if co.load(path) != scene:
        yield "it loads as another scene"
    for body in scene.bodies:
        if pickle.loads(pickle.dumps(body)) != body:
            yield f"pickled as another body: {body}"


def measures(scene: co.Scene) -> Iterator[str]:
    for body in scene.bodies:
        if np.isfinite(body.shape.bounds).all():
            found = co.measure(body, rays=60)
            values = (found.volume, found.area, found.volume_error, found.area_error, *found.centroid_error)
            if found.volume < 0 or (found.volume > 0 and not np.isfinite([*values, *found.centroid]).all()):
                yield f"measure of {body}: {found}"


def fuzzed(seed: int, numbers: Sequence[int], folder: Path, bodies: int = BODIES) -> list[str]:
    lines = []
    for number in numbers:
        scene, rng = random_scene(seed, number, bodies)
        try:
            lines += [f"{seed}, {number}: {line}" for line in faults(scene, rng, folder, number == numbers[0])]
        except Exception as error:
            lines.append(f"{seed}, {number}: {type(error).__name__}: {error}")
    return lines


@pytest.fixture(scope="module", autouse=True)
def _compiled() -> None:
    scene = co.Scene([co.Sphere() - co.Box((0, 0, 0), (2, 2, 2)), co.Disc((0, 0, 3), (0, 0, 1), 1)])
    list(faults_of_kernels(scene))


def faults_of_kernels(scene: co.Scene) -> Iterator[Any]:
    """Compiling is no hang."""
    co.warmup()
    yield scene.crossings((0, 0, 9), (0, 0, -1)).t_error


def test_a_few_random_booleans_through_every_query(tmp_path: Path) -> None:
    assert not fuzzed(0, range(1), tmp_path, FEW_BODIES)


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(1, 11))
def test_random_booleans_through_every_query(seed: int, tmp_path: Path) -> None:
    assert not fuzzed(seed, drawn(range(40), 4, str(seed)), tmp_path)
