"""Are the answers of two source trees the same to the bit? For changes that are to change none.

    python benchmarks/same_answers.py OTHER [RAYS]

OTHER is another checkout (`git worktree add ../before HEAD~1`). Both answer the same questions about scenes of every
kind of body: RAYS each (2,000 if not given) as a picture, in a row, in no order, alone, spawned, from before their
origins; spans, crossings, points and small pictures. What differs is listed, field by field.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np

FIELDS = ("t", "body", "face", "surface", "entering", "doubtful", "t_error", "point", "point_error", "normal", "uv")


def solids() -> dict[str, Any]:
    """Some of each kind, about the origin."""
    import conicoid as co

    box, ball = co.Box((-1, -1, -1), (1, 1, 1)), co.Sphere(1.2)
    made: dict[str, Any] = {
        "sphere": ball,
        "box": box,
        "box cut three times": box - co.Sphere(1.2) - co.Cylinder((0, 0, -2), (0, 0, 2), 0.4),
        "cylinder": co.Cylinder((0, 0, -1), (0, 0, 1), 0.8),
        "oblique cylinder": co.Cylinder((0, 0.3, -1), (0.5, 0, 1), 0.8),
        "wedge": co.Cylinder((0, 0, -1), (0, 0, 1), 1, 20, 250, (1, 0, 0)),
        "cone": co.Cone((0, 0, -1), (0, 0, 1), 1.0, 0.3),
        "double cone": co.DoubleCone(1.0, z_range=(-1, 1)),
        "ellipsoid": co.Ellipsoid((1, 1, 0.5)),
        "paraboloid": co.EllipticParaboloid(A=2, E=0.5) & ball,
        "saddle": co.HyperbolicParaboloid(A=2, E=0.5) & ball,
        "one sheet": co.OneSheetHyperboloid(9, 9, 4, z_range=(-1, 1)),
        "two sheets": co.TwoSheetHyperboloid(9, 9, 4) & co.Sphere(2),
        "union of 40": co.Union(
            tuple(co.Sphere(0.4, (k * 7 % 40 / 20 - 1, k * 11 % 40 / 20 - 1, k / 20 - 1)) for k in range(40))
        ),
        "complement": ~(~box | ball) | ~(~co.Sphere(0.3)),
        "flush": box | box.translate((2, 0, 0)) | (box.translate((0, 2, 0)) - ball),
        "disc cut": co.Disc((0, 0, 0), (0, 0, 1), 1) - co.Cylinder((0, 0, -1), (0, 0, 1), 0.4),
        "polygon": co.Polygon([(-1, -1, 0), (1, -1, 0), (0, 1, 0)]),
        "triangle": co.Triangle((-1, -1, 0), (1, -1, 0.5), (0, 1, 0)),
        "patch": co.CylinderPatch((0, 0, -1), (0, 0, 1), 1),
    }
    return made


def scenes() -> Iterator[tuple[str, Any]]:
    """Scenes of one kind each, some of it moved; of all kinds; of a flush lattice."""
    import conicoid as co

    rng = np.random.default_rng(7)
    every = []
    for name, shape in solids().items():
        placed = [
            shape.scale(0.3).rotate(rng.normal(size=3), float(rng.uniform(0, 360))).translate(rng.uniform(-1, 1, 3))
            for _ in range(12)
        ]
        every += placed[:4]
        yield name, co.Scene([shape, *(body.translate((3, 0, 0)) for body in placed)])
    yield "all kinds", co.Scene([*every, co.Plane((0, 0, 1), -2)])
    cells = [co.Box((i, j, k), (i + 1, j + 1, k + 1)) for i in range(-2, 2) for j in range(-2, 2) for k in range(-2, 2)]
    yield "lattice", co.Scene([*cells, *(cell - co.Sphere(0.5, (0.5, 0.5, 0.5)) for cell in cells[:4])])
    yield "balls", co.Scene([co.Spheres(rng.uniform(-1, 1, (3000, 3)), 0.02 + 0.03 * rng.random(3000)), *every[:8]])
    glass = [
        co.Body(body, co.glass(1.5)) if k % 2 else co.Body(body, co.phong((1, 0, 0)))
        for k, body in enumerate(every[::3])
    ]
    yield "glass", co.Scene(glass, lights=[co.PointLight((3, 4, 5)), co.AmbientLight()])


def rays(count: int, seed: int) -> Iterator[tuple[str, Any, Any, dict[str, float]]]:
    """(name, origins, directions, limits)."""
    rng, side = np.random.default_rng(seed), max(16, int(count**0.5))
    x, y = np.meshgrid(np.linspace(-1.2, 1.2, side), np.linspace(-1.2, 1.2, side))
    eye, toward = np.array([4.0, 3.0, 2.5]), np.stack([x - 0.8, y - 0.6, -0.5 - 0.4 * x], axis=-1)
    yield "camera", eye, toward, {}
    origins = np.stack([x, y, np.full_like(x, 5.0)], axis=-1)
    yield "parallel", origins, (0.0, 0.0, -1.0), {}
    yield "parallel from before", origins, (0.0, 0.0, -1.0), {"t_min": -3.0, "t_max": 8.0}
    grid = rng.integers(-2, 3, (count, 3)).astype(float)
    steps = rng.integers(-2, 3, (count, 3)).astype(float)
    steps[~steps.any(axis=1)] = 1.0
    yield "small integers", grid, steps, {"t_min": -1.0}
    yield "no order", rng.normal(size=(count, 3)) * 3, rng.normal(size=(count, 3)), {}
    yield "short", rng.normal(size=(count, 3)), rng.normal(size=(count, 3)), {"t_min": 0.1, "t_max": 0.9}
    yield "far and tiny", 1e6 * rng.normal(size=(64, 3)), 1e-90 * rng.normal(size=(64, 3)), {}


def digest(values: Any) -> str:
    """Of every bit; of every NaN the same."""
    array = np.ascontiguousarray(values)
    if array.dtype.kind == "f":
        array = np.where(np.isnan(array), np.nan, array)
    return blake2b(array.tobytes(), digest_size=8).hexdigest()


def answers(count: int) -> Iterator[tuple[str, str]]:
    """(question, digest of the answer)."""
    for n, (scene_name, scene) in enumerate(scenes()):
        for ray_name, origins, directions, limits in rays(count, n):
            at = f"{scene_name} / {ray_name}"
            hits = scene.first_hit(origins, directions, **limits)
            for field in FIELDS:
                yield f"{at} / first {field}", digest(getattr(hits, field))
            yield f"{at} / occluded", digest(scene.occluded(origins, directions, **limits))
            o, d = (np.broadcast_to(part, (*hits.rays.shape, 3)).reshape(-1, 3) for part in (origins, directions))
            alone = [scene.first_hit(o[k], d[k], **limits) for k in range(0, len(o), max(1, len(o) // 40))]
            yield f"{at} / alone", digest([[hit.t, hit.body, hit.face, hit.doubtful] for hit in alone])
            spawned = scene.first_hit(hits.spawn(np.where(hits.hit[..., None], hits.normal, 1.0) + 0.3))
            for field in ("t", "body", "doubtful"):
                yield f"{at} / spawned {field}", digest(getattr(spawned, field))
            order = np.random.default_rng(1).permutation(len(o))
            for way, which in (("", slice(None)), (" in no order", order)):
                spans = scene.spans(o[which], d[which], **limits)
                for field in ("offsets", "t_enter", "t_exit", "body", "t_enter_error"):
                    yield f"{at} / spans{way} {field}", digest(getattr(spans, field))
                crossings = scene.crossings(o[which], d[which], **limits)
                for field in ("offsets", "t", "body", "face", "surface", "entering", "t_error"):
                    yield f"{at} / crossings{way} {field}", digest(getattr(crossings, field))
                yield f"{at} / first t{way}", digest(scene.first_hit(o[which], d[which], **limits).t)
            yield f"{at} / body_at", digest(scene.body_at(o / 2))
        for integrator in ("normals", "whitted"):
            yield f"{scene_name} / {integrator}", digest(np.asarray(scene.render(48, 40, 2, integrator)))


def asked_of(tree: Path, count: int) -> dict[str, str]:
    """Return the answers of a tree."""
    environment = os.environ | {"PYTHONPATH": str(tree)}
    command = [sys.executable, str(Path(__file__).resolve()), "--worker", str(count)]
    run = subprocess.run(command, cwd=tree, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    found: dict[str, str] = json.loads(run.stdout.splitlines()[-1])
    return found


def main() -> int:
    """Return 0 if nothing differs."""
    if sys.argv[1:2] == ["--worker"]:
        print(json.dumps(dict(answers(int(sys.argv[2])))))
        return 0
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 2000
    here, other = asked_of(Path(__file__).resolve().parents[1], count), asked_of(Path(sys.argv[1]).resolve(), count)
    different = [name for name in here if here[name] != other.get(name)]
    for name in different:
        print(f"differs: {name}")
    print(f"{len(here)} answers, {len(different)} differ")
    return 1 if different or len(here) != len(other) else 0


if __name__ == "__main__":
    sys.exit(main())
