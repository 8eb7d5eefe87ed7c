"""What is read of many shapes at once is what is read of each; surfaces that are near by chance are not named."""

from __future__ import annotations

import random
from collections import Counter
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.transform import Rotate, Scale, Translate
from conicoid.prepare import lowering
from conicoid.prepare.coincidence import FIRST_DIRECTION, find_clusters
from conicoid.prepare.motion_batch import MotionBatch, MotionChains
from conicoid.prepare.pytree import flatten, flatten_all

from .tapes.test_recorded import KINDS


def some(rng: random.Random) -> list[Any]:
    """Shapes of all kinds, several forms of some, and some of them more than once."""
    shapes = [KINDS[rng.choice(list(KINDS))](rng) for _ in range(rng.randint(1, 60))]
    shapes += [co.Polygon([(0, 0, 0), (4, 0, 0), (4, 3, 0), (0, 2, 0), (-1, 1, 0)][:k]) for k in (3, 4, 5, 4)]
    shapes += [co.Polyhedron([(0, 0, 1.0), (1.0, 0, 0)], [1.0, 2.0]), co.Union((co.Sphere(1), co.Sphere(2)))]
    shapes += rng.choices(shapes, k=rng.choice((0, 5, 300)))
    rng.shuffle(shapes)
    return shapes


@pytest.mark.parametrize("seed", range(20))
def test_many_are_read_as_each(seed):
    shapes = some(random.Random(seed))
    found: dict[int, Any] = {}
    for alike in flatten_all(shapes):
        for which, numbers in zip(alike.which.tolist(), alike.numbers.tolist(), strict=True):
            assert which not in found
            found[which] = alike.form, numbers
    for which, shape in enumerate(shapes):
        told = flatten(shape)
        assert found.get(which) == (None if told is None else (told.form, told.numbers))


def test_every_motion_has_one_number():
    rng = random.Random(1)
    few = [
        (Rotate((0.0, 0.0, 1.0), float(k)), Translate((1.0, rng.choice((0.0, -0.0)), 2.0))) for k in range(5)
    ] + [(Scale((2.0, 2.0, 2.0)),), (Translate((1.0, 2.0, 3.0)), Translate((1.0, 2.0, 3.0)))]  # fmt: skip
    motions, chains = MotionBatch(), [(*rng.choice(few),) for _ in range(200)]
    rows = motions.rows(MotionChains(chains), np.arange(200)).tolist()
    again = [motions.row(steps) for steps in chains]
    assert rows == again
    assert len(set(zip(rows, chains, strict=True))) == len(set(rows)) == len(set(chains))


def test_frames_of_bodies_that_are_turned_or_only_moved():
    block = co.Box() - co.Sphere(0.5)
    moved = {
        "still": lambda s, k: s,
        "moved": lambda s, k: s.translate((k, -0.0, 1.5)),
        "moved twice": lambda s, k: s.translate((k, 0.1, 0)).translate((0.2, 0, k)),
        "turned": lambda s, k: s.rotate("z", 30 + k).translate((0, k, 0)),
    }
    bodies = [co.Body(move(block, float(k))) for k in range(12) for move in moved.values()]
    lowered = lowering.lower(bodies)
    for number, body in enumerate(bodies):
        expected = body.shape.motion.inverse_matrix[:3]
        assert lowered.frames[lowered.body_frame[number]].tolist() == expected.tolist()


class Rows:
    """Features that are given."""

    def __init__(self, rows):
        self.rows = rows

    def places(self, along, which):
        return self.rows[which] @ along


def test_surfaces_that_agree_along_one_direction_by_chance_are_parted():
    """Rows with one place along `ALONG`: equal ones stay together, in whatever order, and others do not."""
    rng = np.random.default_rng(3)
    rows = rng.uniform(-1, 1, (40, 10))
    rows[:, -1] += (0.5 - rows @ FIRST_DIRECTION) / FIRST_DIRECTION[-1]
    assert np.ptp(rows @ FIRST_DIRECTION) < 1e-14
    which = rng.integers(0, 40, 200)
    noise = 1e-14 * rng.uniform(-1, 1, (200, 10))
    found = [group.tolist() for group in find_clusters(np.arange(200), Rows(rows[which] + noise))]
    sizes = Counter(which.tolist())
    assert sorted(len(group) for group in found) == sorted(size for size in sizes.values() if size > 1)
    assert all(len({int(which[member]) for member in group}) == 1 for group in found)


def test_planes_through_corners_are_exact():
    """The height of a triangle's anchor over its plane, record and rest, is n·(anchor - a) in fractions.

    n is the record's own normal, of which rests tell what rounding took, so both sides are exact but for 2^-106.
    """
    rng = random.Random(5)
    shapes = [KINDS["Triangle"](rng) for _ in range(300)]
    lowered = lowering.lower([co.Body(shape) for shape in shapes])
    for record, rest, shape in zip(lowered.tables.planes, lowered.rest.planes, shapes, strict=True):
        exact = [Fraction(x) + Fraction(y) for x, y in zip(record.tolist(), rest.tolist(), strict=True)]
        aside = [Fraction(p) - Fraction(q) for p, q in zip(record[4:].tolist(), shape.a, strict=True)]
        height = sum(n * d for n, d in zip(exact[:3], aside, strict=True))
        assert abs(height - exact[3]) <= Fraction(2) ** -100 * sum(abs(d) for d in aside)
