"""Several bodies that touch, abut, coincide and hold one another: who is met first, in exact arithmetic."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co

from .cases import generator
from .judge import Judge, Score
from .nice import PLAIN, lattice_rays, moved, nice_case
from .oracle import Oracle
from .shapes import exact_shape

SHEETS_TOO = (*sorted(set(PLAIN) - {"Quadric", "Spheres"}), "Difference", "Intersection", "ClippedSheet")
CLOSED = ("Sphere", "Ellipsoid", "Box", "Box", "Cylinder", "Cone", "Polyhedron", "Disc", "Triangle", "Polygon")


def scene_score(number: int, count: int) -> Score:
    random = generator("ties", number)
    cases = [nice_case(str(random.choice(SHEETS_TOO)), random) for _ in range(random.integers(2, 6))]
    cases.append(moved(cases[0], (("translate", (1.0, 0.0, 0.0)),)))
    cases.append(cases[int(random.integers(len(cases)))])
    oracle = Oracle(exact_shape(*cases), (0, 0, 0), 8.0)
    return Judge(co, oracle, cases, *lattice_rays(random, count)).run()


def crowd_score(number: int, count: int) -> Score:
    """Forty solids and sheets on a lattice: boxes of the tree end where rays run, bodies touch and hold one another."""
    random = generator("crowd", number)
    cases = []
    for _ in range(40):
        case = nice_case(str(random.choice(CLOSED)), random)
        shift = tuple(float(x) for x in random.integers(-9, 10, 3))
        cases.append(moved(case, (("translate", shift),)))
    oracle = Oracle(exact_shape(*cases), (0, 0, 0), 32.0)
    origins, d = lattice_rays(random, count)
    return Judge(co, oracle, cases, origins * 2.0, d).run()


@pytest.mark.parametrize(
    "numbers", [range(2), pytest.param(range(100, 130), marks=pytest.mark.deep)], ids=["sample", "deep"]
)
def test_crowds_on_a_lattice(numbers: range) -> None:
    total = Score()
    for number in numbers:
        total.add(crowd_score(number, 100 if len(numbers) < 100 else 300))
    assert total.crossings > total.rays / 4
    total.check()


@pytest.mark.parametrize(
    "numbers", [range(12), pytest.param(range(100, 600), marks=pytest.mark.deep)], ids=["sample", "deep"]
)
def test_scenes_on_a_lattice(numbers: range) -> None:
    total = Score()
    for number in numbers:
        total.add(scene_score(number, 80 if len(numbers) < 100 else 400))
    assert total.crossings > total.rays / 4
    total.check()


def test_the_body_listed_first_is_met_first() -> None:
    """One box twice, in both orders: the walls are one surface, the body that answers is the first."""
    box = co.Box((0, 0, 0), (1, 1, 1))
    for scene in (co.Scene([box, box]), co.Scene([co.Box((0, 0, 0), (1, 2, 1)), box])):
        hits = scene.first_hit(np.array([[-1.0, 0.5, 0.25]]), (1, 0, 0))
        assert hits.body[0] == 0
        assert hits.t_error[0] == 0
