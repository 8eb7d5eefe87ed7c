"""One digest for each kind of answer, which must be the same on every processor, system and way of compiling.

    python benchmarks/digest.py

asks the installed Conicoid about solids of every kind and prints the digests as JSON; tests compare them with those in
tests/native/digests.json. Rays and scenes are made of whole numbers, so that no other library has a say in them.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from hashlib import blake2b
from typing import Any

import numpy as np

try:
    from .same_answers import solids
except ImportError:  # as a program it asks the installed package, and not the one beside this folder
    from same_answers import solids  # type: ignore[no-redef]

KINDS = {
    "ids": ("body", "face", "surface", "entering", "doubtful"),
    "t": ("t",),
    "t_error": ("t_error",),
    "point": ("point", "local_point"),
    "point_error": ("point_error",),
    "normal": ("normal",),
    "uv": ("uv",),
}
SPANS = "offsets", "t_enter", "t_exit", "body", "enter_clipped", "exit_clipped"
CROSSINGS = "offsets", "t", "body", "face", "surface", "entering"


class Numbers:
    """Whole numbers that look random (Marsaglia's xorshift of 64 bits)."""

    def __init__(self, seed: int) -> None:
        self.state = seed

    def next(self) -> int:
        for shift in (13, -7, 17):
            moved = self.state << shift if shift > 0 else self.state >> -shift
            self.state = (self.state ^ moved) & (2**64 - 1)
        return self.state >> 11

    def whole(self, shape: tuple[int, ...], low: int, high: int) -> Any:
        """An array of whole numbers from low to high, as floats."""
        found = [low + self.next() % (high - low + 1) for _ in range(int(np.prod(shape)))]
        return np.array(found, dtype=float).reshape(shape)

    def parts(self, shape: tuple[int, ...], size: int) -> Any:
        """An array of multiples of 2^-20 up to ± size."""
        return self.whole(shape, -size << 20, size << 20) / 2.0**20


def scenes() -> Iterator[Any]:
    """Each kind of body in a scene of its own, moved; all of them; a flush lattice; many balls."""
    import conicoid as co

    numbers, every = Numbers(7), []
    for shape in solids().values():
        placed = [
            shape.scale(0.3).rotate(numbers.whole((3,), 1, 9), numbers.next() % 360).translate(numbers.parts((3,), 1))
            for _ in range(3)
        ]
        every += placed[:2]
        yield co.Scene([shape, *(body.translate((3, 0, 0)) for body in placed)])
    yield co.Scene([*every, co.Plane((0, 0, 1), -2)])
    cells = [co.Box((i, j, k), (i + 1, j + 1, k + 1)) for i in range(-1, 2) for j in range(-1, 2) for k in range(-1, 2)]
    yield co.Scene([*cells, *(cell - co.Sphere(0.5, (0.5, 0.5, 0.5)) for cell in cells[:4])])
    yield co.Scene([co.Spheres(numbers.parts((500, 3), 1), 0.0625 + abs(numbers.parts((500,), 1)) / 16), *every[:8]])
    paints = co.glass(1.5, absorption=(0.25, 0.5, 0.125)), co.phong((1, 0.5, 0.25), specular=0.5), co.mirror()
    bodies = [co.Body(body, paints[k % 3]) for k, body in enumerate(every[::2])]
    yield co.Scene(bodies, lights=[co.PointLight((3, 4, 5)), co.DirectionalLight((1, 1, -2), 0.5), co.AmbientLight()])


def rays(numbers: Numbers) -> Iterator[tuple[Any, Any, dict[str, float]]]:
    """(origins, directions, limits): from a point, parallel, in no order, between points of a lattice, far and tiny."""
    x, y = np.meshgrid(np.arange(-8.0, 8.0) / 7, np.arange(-8.0, 8.0) / 7)
    yield np.array([4.0, 3.0, 2.5]), np.stack([x - 0.75, y - 0.625, -0.5 - 0.375 * x], axis=-1), {}
    yield np.stack([x, y, np.full_like(x, 5.0)], axis=-1), (0.0, 0.0, -1.0), {"t_min": -3.0, "t_max": 8.0}
    yield numbers.parts((200, 3), 3), numbers.parts((200, 3), 1), {}
    steps = numbers.whole((200, 3), -2, 2)
    steps[~steps.any(axis=1)] = 1.0
    yield numbers.whole((200, 3), -2, 2), steps, {"t_min": -1.0}
    yield 1e6 * numbers.parts((16, 3), 1), 1e-90 * numbers.parts((16, 3), 1), {}


def answers() -> Iterator[tuple[str, Any]]:
    """(kind, an array of answers of that kind)."""
    from conicoid.render.integrators import INTEGRATORS

    for n, scene in enumerate(scenes()):
        numbers = Numbers(n + 1)
        for origins, directions, limits in rays(numbers):
            hits = scene.first_hit(origins, directions, **limits)
            spawned = scene.first_hit(hits.spawn(np.where(hits.hit[..., None], hits.normal, 1.0) + 0.25))
            for kind, fields in KINDS.items():
                for field in fields:
                    yield kind, getattr(hits, field)
                    yield f"spawned {kind}", getattr(spawned, field)
            yield "occluded", scene.occluded(origins, directions, **limits)
            spans = scene.spans(origins, directions, **limits)
            yield from (("spans", getattr(spans, field)) for field in SPANS)
            yield from (("spans t_error", error) for error in (spans.t_enter_error, spans.t_exit_error))
            crossings = scene.crossings(origins, directions, **limits)
            yield from (("crossings", getattr(crossings, field)) for field in CROSSINGS)
            yield "crossings t_error", crossings.t_error
            yield "body_at", scene.body_at(hits.rays.origins / 2)
        for integrator in INTEGRATORS if n % 4 == 0 or scene.lights else ("normals",):
            yield f"picture {integrator}", np.asarray(scene.render(24, 20, 2, integrator))


def bits(values: Any) -> bytes:
    """Of every number all bits; of every NaN the same."""
    array = np.ascontiguousarray(values)
    if array.dtype.kind == "f":
        return np.where(np.isnan(array), array.dtype.type(np.nan), array).tobytes()
    return array.astype("<i8").tobytes()


def digests() -> dict[str, str]:
    """A digest of each kind of answer."""
    found: dict[str, Any] = {}
    for kind, values in answers():
        found.setdefault(kind, blake2b(digest_size=8)).update(bits(values))
    return {kind: each.hexdigest() for kind, each in sorted(found.items())}


if __name__ == "__main__":
    json.dump(digests(), sys.stdout, indent=2)
    print()
