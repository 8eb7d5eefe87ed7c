"""The numbers of an explanation are the kernels' own: what follows from its steps is what queries answer, to the bit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..booleans.random_solids import EXAMPLES, random_body


def follows(found: Any) -> None:
    """Crossings and spans from the recorded steps of each body, and the nearest of them, against the three queries.

    `floats` and `spans` of a step come from recorded roots, slabs and events; where the ray is doubtful the float
    formulas may differ from the answers, and the explanation has to say so.
    """
    scene, ray = found.scene, found.hit.rays
    limits = {"t_min": found.t_min, "t_max": found.t_max}
    hit, crossings, spans = scene.first_hit(ray, **limits), scene.crossings(ray, **limits), scene.spans(ray, **limits)
    columns = crossings.t, crossings.body, crossings.face, crossings.surface, crossings.entering
    rows = [tuple(row) for row in zip(*(column.tolist() for column in columns), strict=True)]
    assert [(c.t, c.body, c.face, c.surface, c.entering) for c in found.crossings] == rows
    if found.decision.all != "floats":
        assert found.decision.places or not rows
        return
    derived = sorted((c for step in found.bodies for c in step.floats), key=lambda c: (c.t, c.body))
    assert [(c.t, c.body, c.face, c.surface, c.entering) for c in derived] == rows
    nearest = derived[0] if derived else None
    expected = None if nearest is None else (nearest.t, nearest.body, nearest.face, nearest.surface, nearest.entering)
    told = (float(hit.t), int(hit.body), int(hit.face), int(hit.surface), bool(hit.entering)) if hit.hit else None
    assert told == expected
    ends = sorted((s.t_enter, step.body, s.t_exit) for step in found.bodies for s in derived_spans(step, found))
    rows = zip(*(column.tolist() for column in (spans.t_enter, spans.body, spans.t_exit)), strict=True)
    assert ends == sorted(rows)


def derived_spans(step: Any, found: Any) -> list[Any]:
    """Spans of a solid: they must fit its crossings, with the ends of the interval."""
    inner = [s.t_enter for s in step.spans if not s.enter_clipped] + [
        s.t_exit for s in step.spans if not s.exit_clipped
    ]
    if step.kind in ("ball", "solid", "Boolean"):
        assert sorted(inner) == [c.t for c in step.floats]
    assert all(s.t_enter == found.t_min for s in step.spans if s.enter_clipped)
    return list(step.spans)


def through(rng: np.random.Generator, scene: Any) -> co.Rays:
    """A ray that has a chance to hit; now and then of round numbers, or from a surface."""
    low, high = (np.array(end) for end in scene.extent)
    direction = rng.normal(size=3)
    origin = (low + high) / 2 + 0.3 * (high - low) * rng.normal(size=3) - 4 * rng.random() * direction
    if rng.random() < 0.25:
        origin, direction = np.round(origin), np.round(2 * direction) + (0, 0, 0.5)
    ray = co.Rays(origin, direction * 10.0 ** rng.integers(-3, 4))
    if rng.random() < 0.25:
        hit = scene.first_hit(ray)
        if hit.hit:
            return hit.spawn(rng.normal(size=3))
    return ray


def limits(rng: np.random.Generator) -> dict[str, float]:
    return {
        "t_min": float(rng.choice([0.0, 0.0, -math.inf, 0.4])),
        "t_max": float(rng.choice([math.inf, math.inf, 3.0])),
    }


def compare(rng: np.random.Generator, scene: Any, rays: int) -> int:
    """How many of some rays the float formulas decided."""
    certain = 0
    for _ in range(rays):
        found = scene.explain(through(rng, scene), **limits(rng))
        follows(found)
        certain += found.decision.all == "floats"
    return certain


def every_shape(rays: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert sum(compare(rng, co.Scene([shape]), rays) for shape in EXAMPLES) > 0.8 * rays * len(EXAMPLES)


def random_scenes(scenes: int, rays: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert sum(compare(rng, co.Scene([random_body(rng) for _ in range(3)]), rays) for _ in range(scenes)) > 0.1 * scenes


@pytest.mark.filterwarnings("ignore")
def test_every_shape():
    every_shape(1, 1)


@pytest.mark.filterwarnings("ignore")
def test_random_booleans():
    random_scenes(12, 6, 2)


@pytest.mark.deep
@pytest.mark.filterwarnings("ignore")
def test_thousands_of_rays():
    every_shape(30, 3)
    random_scenes(60, 20, 4)


def test_extreme_lengths_of_directions():
    """Directions that the kernels scale by a power of two: t is that of the ray as given."""
    scene = co.Scene([co.Sphere(1.5) - co.Box((-1, -1, -1), (1, 1, 0.5))])
    for length in (1e-40, 1e40, 1e-90):
        follows(scene.explain((0.2, 0.3, -5), np.array([0.01, 0.02, 1.0]) * length))


def test_bulk_bodies_and_the_tree():
    rng = np.random.default_rng(6)
    scene = co.Scene([co.Spheres(rng.uniform(-3, 3, (200, 3)), 0.4), co.Cylinders([(0, 0, -4)], [(0, 0, 4)], 0.5)])
    for _ in range(10):
        found = scene.explain(rng.normal(size=3) * 4, rng.normal(size=3))
        follows(found)
        assert len(found.bodies) + found.misses == 201


def test_numbers_are_those_of_the_formulas():
    """x² + y² + z² = 1 from (−3, 0.6, 0) along x: the foot is at t = 3, c = 0.36 − 1, b² − a c = 0.64, all but exact."""
    step = co.Scene([co.Sphere(1)]).explain((-3, 0.6, 0), (1, 0, 0)).surfaces[0]
    assert (step.a, step.b, step.foot) == (1, 0, 3)
    assert step.c == pytest.approx(-0.64, rel=1e-15)
    assert step.discriminant == pytest.approx(0.64, rel=1e-15)
    assert step.roots == (2.2, 3.8)
