"""Every query on small whole numbers: bodies of all kinds under all motions, rays through their corners, edges, axes and walls."""

import numpy as np
import pytest

import conicoid as co

from ..reference.random_items import SCENES
from ..reference.suite import total, whole_score
from ..samples import deep, drawn


@pytest.mark.parametrize("kind", SCENES)
def test_scenes(kind):
    score = whole_score(kind, 0, 60)
    assert score.rows
    score.check()


@pytest.mark.deep
@pytest.mark.parametrize("kind", SCENES)
def test_more_scenes(kind):
    score = total([whole_score(kind, number, 500) for number in drawn(range(100, 144), 3, kind)])
    score.check()


TURNED = (
    "Boolean",
    "Fan",
    "Siblings",
    "Abutting",
    "Shared",
    "ClippedSheet",
    "Cylinder",
    "Cone",
    "Polyhedron",
    "Triangle",
)


@pytest.mark.parametrize("numbers", [range(1), deep(drawn(range(100, 160), 3))], ids=["sample", "deep"])
@pytest.mark.parametrize("kind", TURNED)
def test_scenes_turned_by_any_angle(kind, numbers):
    score = total([whole_score(kind, number, 40 if len(numbers) < 2 else 400, turned=True) for number in numbers])
    assert score.rays
    score.check()


def test_the_first_body_of_the_list_is_hit_first() -> None:
    """One box stands there twice, in both orders. The walls are one surface, and the first body answers."""
    box = co.Box((0, 0, 0), (1, 1, 1))
    for scene in (co.Scene([box, box]), co.Scene([co.Box((0, 0, 0), (1, 2, 1)), box])):
        hits = scene.first_hit(np.array([[-1.0, 0.5, 0.25]]), (1, 0, 0))
        assert hits.body[0] == 0
        assert hits.t_error[0] == 0
