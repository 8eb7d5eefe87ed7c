"""Motions for tests: a few plain ones and random affine ones, mirrors and shears among them."""

from collections.abc import Callable
from typing import Any

import numpy as np

from conicoid.geometry.transform import IDENTITY_MOTION, Motion

SHEAR = [[1, 0.7, 0, 0.5], [0, 1, -0.4, -1], [0.2, 0, 1, 2], [0, 0, 0, 1]]

MOTIONS = {
    "still": IDENTITY_MOTION,
    "shifted": IDENTITY_MOTION.translate((3, -1, 0.5)),
    "turned": IDENTITY_MOTION.rotate((1, 2, -1), 47).translate((1, 0, 0)),
    "quarter": IDENTITY_MOTION.rotate((0, 1, 0), 90),
    "mirrored": IDENTITY_MOTION.scale((1, -1, 1)).rotate((1, 0, 0), 20),
    "stretched": IDENTITY_MOTION.scale((3, 0.2, 1)).rotate((0, 0, 1), 33),
    "sheared": IDENTITY_MOTION.transform(SHEAR),
}


def random_motion(rng: np.random.Generator) -> Motion:
    """Return a random invertible matrix, half of them mirrors, with a shift."""
    matrix = np.eye(4)
    matrix[:3, :3] = rng.normal(size=(3, 3)) + np.diag(rng.choice([-1.0, 1.0], 3))
    matrix[:3, 3] = rng.normal(size=3) * 3
    return IDENTITY_MOTION.transform(matrix)


def climb(
    inside: Callable[[Any], Any],
    direction: Any,
    start: np.ndarray,
    rng: np.random.Generator,
    rounds: int,
    count: int = 60,
) -> np.ndarray:
    """Return the furthest point along a direction, by differential evolution: points move by differences of others."""
    people = start[np.argsort(-(start @ direction))][:count]
    for _ in range(rounds):
        others = people[rng.integers(len(people), size=(3, len(people)))]
        tries = others[0] + rng.uniform(0.3, 1.1, (len(people), 1)) * (others[1] - others[2])
        better = inside(tries) & (tries @ direction > people @ direction)
        people = np.where(better[:, None], tries, people)
    return people[np.argmax(people @ direction)]


def carried(motion: Motion, points: np.ndarray) -> np.ndarray:
    matrix = motion.matrix
    return points @ matrix[:3, :3].T + matrix[:3, 3]
