"""A thousand bounces: never out, never back at the start, always on the surface, at any scale and place.

Light enters a body by refraction and is reflected inside it. Every point lies on the surface within its `point_error`
(by exact arithmetic: |f| / |grad f|, taken in pairs of floats); every fiftieth bounce all rays are traced exactly, the
root that they start on taken out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..oracle.cases import Case
from .exact import ExactRay, distance
from .oracle import Oracle
from .places import learn, off_surface
from .shapes import exact_shape
from .traced import crossings

N, BOUNCES, EVERY = 40, 1000, 50
Vector = tuple[float, float, float]


def ball(s: float, at: Vector) -> Case:
    return Case("Sphere", {"radius": s, "center": at}, at, 2 * s)


def lens(s: float, at: Vector) -> Case:
    """Two balls of radius s, their centres 1.2 s apart."""
    parts = [ball(s, (at[0], at[1], at[2] + z * s)) for z in (-0.6, 0.6)]
    return Case("Intersection", {}, at, 2 * s, operands=tuple(parts))


def carved(s: float, at: Vector) -> Case:
    """A turned box with a ball bitten out and a rod put in."""

    def near(*x: float) -> Vector:
        return (at[0] + s * x[0], at[1] + s * x[1], at[2] + s * x[2])

    box = Case("Box", {"low": near(-0.5, -0.6, -0.4), "high": near(0.5, 0.6, 0.4)}, at, 2 * s)
    bite = ball(0.35 * s, near(0.5, 0.6, 0.4))
    rod = Case("Cylinder", {"start": near(-0.8, 0, 0), "end": near(0.8, 0.1, 0.05), "radius": 0.2 * s}, at, 2 * s)
    rest = Case("Difference", {}, at, 2 * s, operands=(box, bite))
    return Case("Union", {}, at, 2 * s, operands=(rest, rod))


BODIES: dict[str, Callable[[float, Vector], Case]] = {"ball": ball, "lens": lens, "carved": carved}
SCALES = [1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9]


def configurations() -> list[Any]:
    found = []
    for name in BODIES:
        for scale in SCALES:
            for away in (0.0, 1e6):
                fast = (scale, away) in ((1e-9, 0.0), (1e9, 1e6), (1.0, 1e6))
                marks = [] if fast else [pytest.mark.deep]
                found.append(pytest.param(name, scale, away, marks=marks, id=f"{name}-{scale:g}-{away:g}"))
    return found


@pytest.mark.parametrize(("name", "scale", "away"), configurations())
def test_a_thousand_bounces(name: str, scale: float, away: float) -> None:
    at = tuple(float(x) for x in scale * away * np.array([0.48, -0.6, 0.64]))
    case = BODIES[name](scale, at)
    oracle = Oracle(exact_shape(case), at, 2 * scale)
    scene = co.Scene([case.shape(co)])
    random = np.random.default_rng(7)
    d = random.normal(size=(N, 3))
    target = np.asarray(at) + 0.15 * scale * random.uniform(-1, 1, (N, 3))
    hits = scene.first_hit(target - 5 * scale * d / np.linalg.norm(d, axis=1, keepdims=True), d)
    assert hits.entering.all()
    inward, total = co.refract(hits.rays.directions, hits.normal, 1 / 1.5)
    assert not total.any()
    forms: dict[int, int] = {}
    for step in range(BOUNCES):
        rays, previous = hits.spawn(inward), hits
        hits = scene.first_hit(rays)
        assert np.isfinite(hits.t).all(), f"{np.isinf(hits.t).sum()} rays escape at bounce {step}"
        assert (hits.t > 0).all(), f"back at the start at bounce {step}"
        assert not hits.entering.any(), f"met from outside at bounce {step}"
        off, nearest = off_surface(oracle, hits.point)
        beside = float((off / hits.point_error).max())
        assert beside <= 1, f"{beside} bounds beside the surface at bounce {step}"
        if step < EVERY:
            learn(forms, hits, nearest)
        elif step % EVERY == 0:
            trace_exactly(oracle, forms, previous, hits)
        inward = co.reflect(rays.directions, hits.normal)


def trace_exactly(oracle: Oracle, forms: dict[int, int], previous: Any, hits: Any) -> None:
    for i in range(N):
        ray = ExactRay(hits.rays.origins[i], hits.rays.directions[i])
        start = forms[int(previous.surface[i])]
        ahead = [c for c in crossings(oracle.shape, ray, start) if c.root.sign > 0]
        assert ahead
        assert ahead[0].entering == hits.entering[i]
        assert distance(ahead[0].root, float(hits.t[i]))[0] <= hits.t_error[i]
        assert ahead[0].root.index == forms.get(int(hits.surface[i]), ahead[0].root.index)
