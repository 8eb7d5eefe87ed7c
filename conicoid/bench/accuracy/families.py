"""The families of rays: each is a way in which distances go wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from .bodies import Body, Floats, inside
from .subjects import Precision, Random, Subject, ball, block, cone, cylinder, oblique, quadric, unit

BODIES = 20
"""How many random bodies share the rays of a family."""

_MARGIN = 1.2
"""Rays are aimed at a ball about the body, by this factor wider, so that some miss."""

Made = tuple[Floats, Floats]
Maker = Callable[[Subject, Random, int, Precision], Made]


@dataclass(frozen=True)
class Trial:
    """A body and rays (n, 3), all of them floats of the measured precision."""

    body: Body
    origins: Floats
    directions: Floats


@dataclass(frozen=True)
class Family:
    """How rays are made, and how large the bodies are, as powers of two from and to."""

    name: str
    about: str
    make: Maker
    scales: tuple[int, int] = (0, 0)


def near(subject: Subject, random: Random, n: int, precision: Precision) -> Made:
    directions = precision.rounded(unit(random.normal(size=(n, 3))))
    distance = subject.size * random.uniform(3, 10, (n, 1))
    return precision.rounded(_aims(subject, random, n) - distance * directions), directions


def far(subject: Subject, random: Random, n: int, precision: Precision) -> Made:
    """Drawn again until they pass near the body: in float32 most rays from afar cannot be aimed well enough."""
    origins, directions = np.empty((n, 3)), np.empty((n, 3))
    distance = subject.size * 10 ** random.uniform(2, 8, (n, 1))
    left = np.arange(n)
    while len(left):
        d = precision.rounded(unit(random.normal(size=(len(left), 3))))
        o = precision.rounded(_aims(subject, random, len(left)) - distance[left] * d)
        passing = np.linalg.norm(np.cross(o - subject.center, d), axis=1)
        good = passing < _MARGIN * subject.size * np.linalg.norm(d, axis=1)
        origins[left[good]], directions[left[good]] = o[good], d[good]
        left = left[~good]
    return origins, directions


def grazing(subject: Subject, random: Random, n: int, precision: Precision) -> Made:
    """Beside a tangent by ±2^-k sizes, k from 1 to the bits of the precision; rounding moves them a little more."""
    points, normals = subject.rim(random, n)
    tangents = random.normal(size=(n, 3))
    tangents = unit(tangents - (tangents * normals).sum(axis=1, keepdims=True) * normals)
    beside = _powers(random, n, precision) * random.choice([-1, 1], (n, 1))
    starts = points + subject.size * (beside * normals - random.uniform(2, 10, (n, 1)) * tangents)
    return precision.rounded(starts), precision.rounded(tangents)


def parallel(subject: Subject, random: Random, n: int, precision: Precision) -> Made:
    """Along axis, rulings, asymptotes or faces; one half tilted by 2^-k, k from 1 to the bits of the precision."""
    directions = subject.parallels(random, n)
    tilts = unit(random.normal(size=(n, 3))) * _powers(random, n, precision) * random.integers(0, 2, (n, 1))
    directions = precision.rounded(directions + tilts)
    distance = subject.size * random.uniform(3, 10, (n, 1))
    return precision.rounded(_aims(subject, random, n) - distance * directions), directions


def within(subject: Subject, random: Random, n: int, precision: Precision) -> Made:
    """From points inside, every way."""
    origins = np.empty((0, 3))
    while len(origins) < n:
        points = precision.rounded(_aims(subject, random, n))
        origins = np.concatenate([origins, points[inside(subject.body, points)]])
    return origins[:n], precision.rounded(unit(random.normal(size=(n, 3))))


def _aims(subject: Subject, random: Random, n: int) -> Floats:
    """Points (n, 3), uniform in the ball about the body."""
    reach = _MARGIN * subject.size * random.random((n, 1)) ** (1 / 3)
    return subject.center + reach * unit(random.normal(size=(n, 3)))


def _powers(random: Random, n: int, precision: Precision) -> Floats:
    """2^-k (n, 1)."""
    return np.ldexp(1.0, -random.integers(1, precision.bits + 1, (n, 1)))


FAMILIES = (
    Family("near", "3 to 10 sizes away", near),
    Family("far", "10² to 10⁸ sizes away", far),
    Family("grazing", "beside a tangent or an edge by ±2^-k sizes", grazing),
    Family("tiny", "sizes of 10^-12 to 10^-6", near, (-40, -20)),
    Family("huge", "sizes of 10^6 to 10^12", near, (20, 40)),
    Family("parallel", "along axis, ruling, asymptote or face, half of them tilted by 2^-k", parallel),
    Family("inside", "from points of the body", within),
)

SHAPES: dict[str, Callable[[Random, Precision, float], Subject]] = {
    "sphere": ball, "box": block, "cylinder": cylinder, "cone": cone, "oblique": oblique, "quadric": quadric,
}  # fmt: skip


def trials(shape: str, family: Family, precision: Precision, rays: int) -> list[Trial]:
    """The rays of a family at bodies of a shape: the same for every system, every time."""
    random = np.random.default_rng(crc32(f"{shape} {family.name} {precision.name}".encode()))
    made = []
    for i in range(BODIES):
        subject = SHAPES[shape](random, precision, 2.0 ** random.integers(family.scales[0], family.scales[1] + 1))
        count = rays * (i + 1) // BODIES - rays * i // BODIES
        made.append(Trial(subject.body, *family.make(subject, random, count, precision)))
    return made
