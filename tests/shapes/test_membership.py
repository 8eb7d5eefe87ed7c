"""The cells of every solid hold the points that the interface's inequality holds, moved or not."""

from __future__ import annotations

import numpy as np
import pytest

from .catalogue import SAMPLES, Sample
from .evaluate import contains, faces
from .motions import MOTIONS, carried

samples = pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: sample.name)


def points_of(sample: Sample, count: int) -> np.ndarray:
    rng = np.random.default_rng(7)
    return rng.uniform(-sample.reach, sample.reach, (count, 3))


@samples
def test_cells_hold_what_the_inequality_holds(sample: Sample) -> None:
    points = points_of(sample, 2000)
    expected = sample.inside(*points.T)
    assert 0 < expected.sum() < len(points)
    for name, motion in MOTIONS.items():
        found = contains(sample.shape.tree(), carried(motion, points), sample.shape.under(motion))
        np.testing.assert_array_equal(found, expected, name)


@samples
def test_cells_have_one_quadric_first_and_rising_numbers(sample: Sample) -> None:
    tree = sample.shape.tree()
    numbers = list(faces(tree))
    assert numbers == sorted(numbers)
    for cell in [tree] if hasattr(tree, "faces") else [part for part in tree.parts if hasattr(part, "faces")]:
        quadrics = [i for i, face in enumerate(cell.faces) if hasattr(face.surface, "squares")]
        assert quadrics in ([], [0])
