"""Whole geometries: every point is in the cell that OpenMC's rules give, and chords have the lengths of the cells."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import conicoid as co
from conicoid._util.arrays import FloatArray
from conicoid.render.camera import fit_extent

from ...samples import marked
from .evaluator import Evaluator, same_place
from .models import NAMES, loaded, written

BOXES = {"assembly": ((-10.8, -10.8, -22.0), (10.8, 10.8, 402.0)), "kinds": ((-3.1, -3.1, -3.1), (3.1, 3.1, 3.1))}


def box(name: str, scene: co.Scene) -> tuple[FloatArray, FloatArray]:
    """Around the geometry with a margin."""
    low, high = BOXES.get(name, fit_extent(np.array([body.shape.bounds for body in scene.bodies]).reshape(-1, 6)))
    margin = 0.02 * (np.array(high) - low)
    return low - margin, high + margin


def grid(low: FloatArray, high: FloatArray, count: int) -> FloatArray:
    """Points (count³, 3) that lie on no surface, being off by odd fractions of a step."""
    step = (high - low) / count
    axes = [a + (np.arange(count) + f) * s for a, s, f in zip(low, step, (0.4871, 0.5113, 0.4937), strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


class Model(NamedTuple):
    """A geometry as it is read, and what OpenMC's rules say of it."""

    name: str
    scene: co.Scene
    evaluator: Evaluator


@pytest.fixture(scope="module", params=marked((name, name != "assembly") for name in NAMES))
def model(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Model:
    """Read and made ready once for all tests."""
    path = written(request.param, tmp_path_factory.mktemp("model"))
    return Model(request.param, loaded(path), Evaluator(path))


def compare(model: Model, count: int) -> None:
    name, scene, evaluator = model
    points = grid(*box(name, scene), count)
    bodies = scene.body_at(points)
    wrong = [
        f"{points[i].tolist()}: {place} but in {scene.bodies[body].name if body >= 0 else None!r}"
        for i, (place, body) in enumerate(zip(evaluator.find(points), bodies.tolist(), strict=True))
        if not same_place(place, scene.bodies[body].name if body >= 0 else None)
    ]
    assert not wrong, f"{len(wrong)} of {len(points)} points, such as {wrong[0]}"
    assert len(set(bodies.tolist())) > min(4, len(scene.bodies)) / 2


def test_every_point_is_in_the_cell_that_the_rules_give(model: Model) -> None:
    compare(model, 12)


@pytest.mark.deep
def test_every_point_of_a_fine_grid_is_in_the_cell_that_the_rules_give(model: Model) -> None:
    compare(model, 100)


def test_spans_have_the_lengths_of_the_cells(model: Model) -> None:
    """Along random segments no two spans overlap, and every stretch between two walls is in the cell of its span,
    or in none where there is no span: at its middle, and at random points of the segment."""
    name, scene, evaluator = model
    low, high = box(name, scene)
    random = np.random.default_rng(4)
    starts, ends = (random.uniform(low, high, (40, 3)) for _ in range(2))
    spans = scene.spans(starts, ends - starts, 0.0, 1.0)
    points, names = [], []
    for ray in range(len(starts)):
        rows = slice(spans.offsets[ray], spans.offsets[ray + 1])
        enter, leave, body = spans.t_enter[rows], spans.t_exit[rows], spans.body[rows]
        walls = np.unique(np.concatenate([[0.0, 1.0], enter, leave]))
        middles = (0.5 * (walls[:-1] + walls[1:]))[np.diff(walls) > 1e-9]
        for t in (*middles, *random.uniform(0, 1, 100)):
            inside = body[(enter <= t) & (leave >= t)]
            assert len(inside) <= 1
            points.append(starts[ray] + t * (ends[ray] - starts[ray]))
            names.append(scene.bodies[inside[0]].name if len(inside) else None)
    places = evaluator.find(np.array(points))
    assert all(same_place(place, body) for place, body in zip(places, names, strict=True))
    assert len(set(names)) > 3


def test_the_scene_is_an_ordinary_one(model: Model, tmp_path: Path) -> None:
    """It saves and loads as an equal scene."""
    co.save(model.scene, tmp_path / "scene.yaml")
    assert co.load(tmp_path / "scene.yaml") == model.scene
