"""A thousand bounces: never out, never back at the start, always on the surface, at any scale and place.

Light enters a body by refraction and is reflected inside it. At every tenth bounce, points lie on the surfaces of their
faces within `point_error`: |f| / |grad f|, f by exact arithmetic. At every fiftieth, all rays are traced exactly, the
root that they start on taken out.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..reference.items import Item, combined
from ..reference.judge import holds
from ..reference.quadratics import Table
from ..reference.solids import bodies
from ..reference.trace import Trace, distances

N, BOUNCES, SOME, EVERY = 40, 1000, 10, 50
Vector = tuple[float, float, float]


def ball(s: float, at: Vector) -> Item:
    return Item("Sphere", {"radius": s, "center": at})


def lens(s: float, at: Vector) -> Item:
    """Two balls of radius s, their centres 1.2 s apart."""
    return combined("Intersection", *(ball(s, (at[0], at[1], at[2] + z * s)) for z in (-0.6, 0.6)))


def carved(s: float, at: Vector) -> Item:
    """A box with a ball bitten out and a rod put in."""

    def near(*x: float) -> Vector:
        return (at[0] + s * x[0], at[1] + s * x[1], at[2] + s * x[2])

    box = Item("Box", {"low": near(-0.5, -0.6, -0.4), "high": near(0.5, 0.6, 0.4)})
    rod = Item("Cylinder", {"start": near(-0.8, 0, 0), "end": near(0.8, 0.1, 0.05), "radius": 0.2 * s})
    return combined("Union", combined("Difference", box, ball(0.35 * s, near(0.5, 0.6, 0.4))), rod)


BODIES: dict[str, Callable[[float, Vector], Item]] = {"ball": ball, "lens": lens, "carved": carved}
SCALES = [1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9]


SAMPLE = ("ball", 1e-9, 0.0), ("lens", 1e9, 1e6), ("carved", 1.0, 1e6)
CONFIGURATIONS = [
    pytest.param(*one, marks=[] if one in SAMPLE else [pytest.mark.deep])
    for one in itertools.product(BODIES, SCALES, (0.0, 1e6))
]


@pytest.mark.parametrize(("name", "scale", "away"), CONFIGURATIONS)
def test_a_thousand_bounces(name: str, scale: float, away: float) -> None:
    at = tuple(float(x) for x in scale * away * np.array([0.48, -0.6, 0.64]))
    item = BODIES[name](scale, at)
    table = Table(bodies([item]))
    scene = co.Scene([item.shape(co)])
    random = np.random.default_rng(7)
    d = random.normal(size=(N, 3))
    target = np.asarray(at) + 0.15 * scale * random.uniform(-1, 1, (N, 3))
    hits = scene.first_hit(target - 5 * scale * d / np.linalg.norm(d, axis=1, keepdims=True), d)
    assert hits.entering.all()
    inward, total = co.refract(hits.rays.directions, hits.normal, 1 / 1.5)
    assert not total.any()
    for step in range(BOUNCES):
        rays, start = hits.spawn(inward), surfaces(table, hits)
        hits = scene.first_hit(rays)
        assert np.isfinite(hits.t).all(), f"{np.isinf(hits.t).sum()} rays escape at bounce {step}"
        assert (hits.t > 0).all(), f"back at the start at bounce {step}"
        assert not hits.entering.any(), f"entered at bounce {step}"
        if step % SOME == 0:
            beside = (distances(table, hits.point, surfaces(table, hits)) / hits.point_error).max()
            assert beside <= 1, f"{beside} bounds beside the surface at bounce {step}"
        if step % EVERY == 0:
            trace_exactly(table, start, hits)
        inward = co.reflect(rays.directions, hits.normal)


def surfaces(table: Table, hits: Any) -> np.ndarray:
    return np.array([table.faces[0][face] for face in hits.face.tolist()])


def trace_exactly(table: Table, start: np.ndarray, hits: Any) -> None:
    found = Trace(table, hits.rays.origins, hits.rays.directions, start).crossings.ahead()
    assert (np.diff(found.offsets) > 0).all()
    first = found.offsets[:-1]
    assert (found.entering[first] == hits.entering).all()
    assert (found.face[first] == hits.face).all()
    for root, t, error in zip(found.roots[first], hits.t.tolist(), hits.t_error.tolist(), strict=True):
        assert holds(root, t, error)
