"""Closed solids with their features: corners, points of edges and rims, apexes, and the directions of edges and axes."""

from __future__ import annotations

import itertools
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np

import conicoid as co

SIGNS = [np.array(s, dtype=float) for s in itertools.product((-1, 1), repeat=3)]
AXES = np.eye(3)


@dataclass(frozen=True)
class Target:
    """`features`: points of edges, rims and corners; `lines`: directions along edges, rulings and axes."""

    name: str
    shape: Any
    features: np.ndarray
    lines: np.ndarray


def circle(center: Any, u: Any, v: Any, turns: Any) -> list[np.ndarray]:
    """center + cos u + sin v at angles given in turns; exact for 3-4-5 points too."""
    center, u, v = (np.asarray(x, dtype=float) for x in (center, u, v))
    points = [center + np.cos(2 * np.pi * t) * u + np.sin(2 * np.pi * t) * v for t in turns]
    exact = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    return points + [center + c * u + s * v for c, s in exact]


def grid(low: Any, high: Any) -> list[np.ndarray]:
    """Corners, middles of edges and of faces of a box."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    levels = [(a, (a + b) / 2, b) for a, b in zip(low, high, strict=True)]
    return [
        np.array(p)
        for p in itertools.product(*levels)
        if any(c in (a, b) for c, a, b in zip(p, low, high, strict=True))
    ]


TURNS = [0.05, 0.13, 0.3, 0.41, 0.55, 0.77, 0.9]


def targets() -> list[Target]:
    found = []

    def add(name: str, shape: Any, features: Any, lines: Any = ()) -> None:
        found.append(Target(name, shape, np.array(list(features), dtype=float), np.array([*AXES, *lines], dtype=float)))

    cube, corners = co.Box((-1, -1, -1), (1, 1, 1)), grid((-1, -1, -1), (1, 1, 1))
    add("box", cube, corners)
    turned = cube.rotate((1, 1, 0), 37)
    c, s, k = np.cos(np.radians(37)), np.sin(np.radians(37)), np.array([1, 1, 0]) / np.sqrt(2)
    turn = np.array([c * e + s * np.cross(k, e) + (1 - c) * (k @ e) * k for e in AXES]).T
    add("turned box", turned, [turn @ p for p in corners], turn.T)
    add("sheared box", cube.transform([[1, 0.5, 0, 0], [0, 1, 0, 0], [0.25, 0, 1, 0], [0, 0, 0, 1]]),
        [(p[0] + 0.5 * p[1], p[1], p[2] + 0.25 * p[0]) for p in corners], [(1, 0, 0.25), (0.5, 1, 0)])  # fmt: skip
    octahedron = co.Polyhedron([tuple(n) for n in SIGNS], [1] * 8)
    points = [*AXES, *-AXES, *((a + b) / 2 for a, b in itertools.combinations([*AXES, *-AXES], 2) if (a + b).any())]
    add(
        "octahedron",
        octahedron,
        points,
        [a + b for a, b in itertools.combinations([*AXES, *-AXES], 2) if (a + b).any()],
    )
    add("tetrahedron", co.Polyhedron([(-1, 0, 0), (0, -1, 0), (0, 0, -1), (1, 1, 1)], [0, 0, 0, 1]),
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 0, 0), (0.5, 0.5, 0), (0.25, 0.25, 0.5), (0.25, 0.25, 0)],
        [(1, -1, 0), (0, 1, -1), (1, 0, -1)])  # fmt: skip
    rims = [*circle((0, 0, -1), AXES[0], AXES[1], TURNS), *circle((0, 0, 1), AXES[0], AXES[1], TURNS)]
    rims += [np.array([x, y, z]) for z in (-1, 0, 1) for x, y in ((0.6, 0.8), (-0.8, 0.6), (0, 0), (1, 0))]
    add("cylinder", co.Cylinder((0, 0, -1), (0, 0, 1), 1), rims)
    add("tilted cylinder", co.Cylinder((0, 0, 0), (2, 2, 1), 1.5),
        [*circle((0, 0, 0), np.array([1, -1, 0]) * 1.5 / np.sqrt(2), np.array([1, 1, -4]) * 1.5 / np.sqrt(18), TURNS),
         *circle((2, 2, 1), np.array([1, -1, 0]) * 1.5 / np.sqrt(2), np.array([1, 1, -4]) * 1.5 / np.sqrt(18), TURNS)],
        [(2, 2, 1), (1, -1, 0), (1, 1, -4)])  # fmt: skip
    walls = [(x, y, z) for z in (-1, 0, 1) for x, y in ((0, 0), (1, 0), (0.5, 0), (0, 1), (0, -1), (0, 0.5), (-1, 0))]
    add("quarter wedge", co.Cylinder((0, 0, -1), (0, 0, 1), 1, 0, 90, (1, 0, 0)), walls)
    add("half wedge", co.Cylinder((0, 0, -1), (0, 0, 1), 1, 0, 180, (1, 0, 0)), walls)
    add("wedge of 270", co.Cylinder((0, 0, -1), (0, 0, 1), 1, 0, 270, (1, 0, 0)), walls)
    add("wedge of 300", co.Cylinder((0, 0, -1), (0, 0, 1), 1, 15, 315, (1, 0, 0)), [*walls, *rims])
    add("cone", co.Cone((0, 0, 0), (0, 0, 2), 1, 0), [(0, 0, 2), (0, 0, 0), *circle((0, 0, 0), AXES[0], AXES[1], TURNS), (0.5, 0, 1), (0, 0.3, 0)],
        [(1, 0, -2), (0, 1, -2), (0.6, 0.8, -2)])  # fmt: skip
    add("frustum", co.Cone((0, 0, 0), (0, 0, 1), 2, 1), [*circle((0, 0, 0), 2 * AXES[0], 2 * AXES[1], TURNS), *circle((0, 0, 1), AXES[0], AXES[1], TURNS)],
        [(1, 0, -1), (0, 1, -1), (0.6, 0.8, -1)])  # fmt: skip
    bow = [
        (0, 0, 0),
        *circle((0, 0, 1), AXES[0], AXES[1], TURNS),
        *circle((0, 0, -1), AXES[0], AXES[1], TURNS),
        (0.5, 0, 0.5),
        (0, 0.5, -0.5),
    ]
    add("bow tie", co.DoubleCone(1, (-1, 1)), bow, [(1, 0, 1), (0, 1, 1), (0.6, 0.8, 1), (1, 0, -1)])
    add("bow tie with a cut at the apex", co.DoubleCone(1, (0, 1)), bow, [(1, 0, 1), (0.6, 0.8, 1)])
    add(
        "barrel",
        co.Ellipsoid((1, 1, 2), z_range=(-1, 1)),
        [*circle((0, 0, 1), AXES[0] * np.sqrt(0.75), AXES[1] * np.sqrt(0.75), TURNS), (1, 0, 0), (0, 0, 1)],
    )
    add("cooling tower", co.OneSheetHyperboloid(1, 1, 1, z_range=(-1, 1)), [*circle((0, 0, 1), AXES[0] * np.sqrt(2), AXES[1] * np.sqrt(2), TURNS), (1, 0, 0), (1, 1, 1), (1, -1, -1)],
        [(0, 1, 1), (0, 1, -1), (1, 0, 1)])  # fmt: skip
    add(
        "saddle block",
        co.HyperbolicParaboloid(1, 1, co.Box()),
        [*corners, (0, 0, 0), (1, 1, 0), (1, 0, 1), (0, 1, -1)],
        [(1, 1, 0), (1, -1, 0)],
    )
    add("sphere", co.Sphere(5), [(3, 4, 0), (0, 3, -4), (5, 0, 0), (0, 0, 5)], [(4, -3, 0), (0, 4, 3)])
    add(
        "abutting boxes",
        co.Box((-1, -1, -1), (0, 1, 1)) | co.Box((0, -1, -1), (1, 1, 1)) | co.Box((-1, 1, -1), (1, 2, 1)),
        grid((-1, -1, -1), (1, 2, 1)) + corners,
    )
    add(
        "box with a flush hole",
        cube - co.Box((-0.5, -0.5, -1), (0.5, 0.5, 1)),
        corners + grid((-0.5, -0.5, -1), (0.5, 0.5, 1)),
    )
    add("flange", co.Cylinder((0, 0, 0), (0, 0, 1), 2) | co.Cylinder((0, 0, 1), (0, 0, 3), 1) - co.Cylinder((0, 0, 0), (0, 0, 3), 0.5),
        [p for z in (0, 1, 3) for r in (0.5, 1, 2) for p in circle((0, 0, z), r * AXES[0], r * AXES[1], TURNS[:3])])  # fmt: skip
    add(
        "half ball",
        co.Sphere(5) & co.HalfSpace((0, 0, 1), 3),
        [(4, 0, 3), (0, 4, 3), (-4, 0, 3), (0, 0, 3), *circle((0, 0, 3), 4 * AXES[0], 4 * AXES[1], TURNS)],
    )
    add("shell", co.Sphere(2) - co.Sphere(1), [(1, 0, 0), (0, 1, 0), (2, 0, 0), (0, 0, -1)])
    return found


def hard_rays(target: Target, count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Through features: towards other features, along edges, in the planes of faces, and at random; from outside."""
    random = np.random.default_rng([zlib.crc32(target.name.encode()), seed])
    features, lines = target.features, target.lines
    p = features[random.integers(len(features), size=count)]
    q = features[random.integers(len(features), size=count)]
    u, v = (lines[random.integers(len(lines), size=count)] for _ in range(2))
    kind = random.integers(0, 5, count)[:, None]
    d = np.where(
        kind == 0,
        q - p,
        np.where(
            kind == 1,
            u,
            np.where(kind == 2, u + v * random.integers(-3, 4, (count, 1)), random.normal(size=(count, 3))),
        ),
    )
    d = np.where((d != 0).any(axis=1)[:, None], d, u) * 2.0 ** random.integers(-3, 4, (count, 1))
    jitter = np.where(kind == 4, random.normal(size=(count, 3)) * 2.0 ** -random.integers(30, 56, (count, 1)), 0)
    extent = np.abs(features).max() * 8
    steps = 2.0 ** np.ceil(np.log2(extent / np.abs(d).max(axis=1, keepdims=True))) * random.integers(1, 9, (count, 1))
    return p + jitter - d * steps, d
