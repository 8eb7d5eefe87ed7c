"""Scenes in which bodies are moved, and exchanged for others: of all kinds, apart or with walls in common."""

from __future__ import annotations

import numpy as np

import conicoid as co
from conicoid.prepare.edits import in_place as exchange

CUBE = co.Box((-1, -1, -1), (1, 1, 1))


def bored(radius, at):
    """Five leaves, three pairs of whose walls are a pair of planes."""
    solid = CUBE & co.Sphere(1.3)
    for axis in np.eye(3):
        solid = solid - co.Cylinder((-2 * axis).tolist(), (2 * axis).tolist(), radius)
    return solid.scale(0.3).translate(at)


def anywhere(rng):
    """A body of one of many kinds, whose walls are no other body's."""
    at, turn = tuple(rng.uniform(-4, 4, 3).tolist()), (tuple(rng.normal(size=3).tolist()), float(rng.uniform(0, 180)))
    red = co.matte("red")
    many = CUBE
    for corner in rng.uniform(-1, 1, (14, 3)).tolist():
        many = many - co.Sphere(0.2, corner)
    kinds = [
        lambda: bored(0.3, at),
        lambda: co.Sphere(float(rng.uniform(0.2, 1)), at),
        lambda: co.Ellipsoid((1, 2, 0.5)).rotate(*turn).translate(at),
        lambda: CUBE.rotate(*turn).translate(at),
        lambda: co.Cylinder(at, (0, 0, 0), 0.3),
        lambda: (CUBE - co.Sphere(0.9, (1, 1, 1)).painted(red)).rotate(*turn).translate(at),
        lambda: many.rotate(*turn).translate(at),
        lambda: (co.Disc((0, 0, 0), (0, 0, 1), 2) - co.Sphere(1)).rotate(*turn).translate(at),
        lambda: co.Polygon([(0, 0, 0), (1, 0, 0), (0, 1, 0)]).rotate(*turn).translate(at),
        lambda: CUBE.scale(0.2).translate((float(rng.integers(-2, 3)), 0, 0)),  # walls that are others', too
    ]
    return kinds[-1 if rng.random() < 0.03 else rng.integers(0, len(kinds) - 1)]()


def bodies(count, seed=1, more=()):
    rng = np.random.default_rng(seed)
    return co.Scene([*(co.Body(anywhere(rng), name=str(k)) for k in range(count)), *more])


def moved(scene, rng):
    """One or two bodies moved, or exchanged for others of their kind or of any."""
    for _ in range(rng.integers(1, 3)):
        name = str(rng.integers(0, 20))
        motion = tuple(rng.uniform(-0.3, 0.3, 3).tolist())
        what = rng.integers(0, 20)
        if what == 0:
            scene = scene.replace(name, anywhere(rng))
        elif what < 5:
            scene = scene.moved(name, lambda shape: shape.rotate((1, 2, 3), 10))
        else:
            scene = scene.moved(name, motion)
    return scene


def standing(rng):
    """A body that stands on the floor z = 0, or is as high as others, or is the same ball as others."""
    x, y = rng.uniform(-4, 4, 2).tolist()
    kinds = [
        lambda: co.Box((x, y, 0), (x + 0.5, y + 0.3, 1)),
        lambda: co.Box((x, y, 0), (x + 0.5, y + 0.3, 1)) - co.Sphere(0.3, (x, y, 1)),
        lambda: co.Cylinder((x, y, 0), (x, y, 2), 0.2),
        lambda: ~co.HalfSpace((0, 0, 1), 0) & co.Sphere(1, (x, y, 0)),
        lambda: co.Sphere(0.2, (1, 1, 1)),
        lambda: co.Ellipsoid((0.2, 0.2, 0.2)).rotate("x", 20).translate((1, 1, 1)),
        lambda: co.Box((0, 0, 0), (1, 1, 1)).rotate((1, 2, 3), 30) & ~co.Sphere(0.2, (1, 1, 1)),
        lambda: co.Disc((x, y, 2), (0, 0, 1), 0.5),
    ]
    return kinds[rng.integers(0, len(kinds))]()


def slid(scene, rng):
    """Bodies slid along the floor, or raised, or swapped with others that stand there."""
    for _ in range(rng.integers(1, 3)):
        name, what = str(rng.integers(0, 20)), rng.integers(0, 12)
        along = (*rng.uniform(-0.3, 0.3, 2).tolist(), 0.0)
        if what == 0:
            scene = scene.replace(name, standing(rng))
        elif what == 1:
            scene = scene.moved(name, (0, 0, 1))
        else:
            scene = scene.moved(name, along)
    return scene


def content(scene):
    """All numbers of a scene."""
    lowered, rest = scene._prepared.lowered, scene._prepared.lowered.rest
    parts = (*lowered.tables, lowered.boxes, lowered.frames, lowered.body_frame, lowered.body_item, rest.planes,
             rest.spheres, rest.quadrics, rest.vertices)  # fmt: skip
    return [part.tobytes() for part in parts]


def note_memory_taken(monkeypatch) -> list[bool]:
    """Whether each exchange from now on finds memory that was another scene's, or that of the one it is made from."""
    found, begin = [], exchange.InPlaceEdit.__init__

    def noted(self, *arguments):
        begin(self, *arguments)
        found.append(self._buffer is not None)

    monkeypatch.setattr(exchange.InPlaceEdit, "__init__", noted)
    return found
