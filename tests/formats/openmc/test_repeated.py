"""Bodies in many elements of a lattice are computed once, and equal those that are written out."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from benchmarks.comparison.scenes import core_xml
from conicoid.geometry.instances import InstanceList
from conicoid.prepare.lowering import lower

from ...samples import marked
from .evaluator import Evaluator, same_place
from .models import BALL, MODELS, geometry_file

SLANTED = {"hexagons", "core at an angle", "cubes at an angle", "hexagons at an angle"}
"""Models with slanted walls, for which another record may stand for equal planes."""


@pytest.fixture(params=marked((name, name != "hexagons at an angle") for name in MODELS), scope="module")
def path(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return geometry_file(MODELS[request.param], tmp_path_factory.mktemp("model"))


@pytest.fixture(scope="module")
def scene(path: Path) -> co.Scene:
    """Return a scene for tests that do not change it."""
    return co.load_openmc(path)


def model_name(path: Path) -> str:
    """Return the name of the model."""
    return next(name for name, text in MODELS.items() if text == path.read_text())


def written_out(scene: co.Scene) -> tuple[co.Body, ...]:
    """Return the bodies, each a shape of its own."""
    return tuple(co.Body(body.shape, body.material, body.name) for body in scene.bodies)


def test_pins_that_a_vessel_does_not_cut_are_alike(tmp_path: Path) -> None:
    """Pins of assemblies that the vessel cuts, and fuel whose water it cuts, are of the kinds of all others."""
    bodies = co.load_openmc(geometry_file(core_xml(5, vessel=8.0, pins=4), tmp_path)).bodies
    assert isinstance(bodies, InstanceList)
    fuel = [number for number, body in enumerate(bodies) if body.name.startswith("cell 1 ")]
    within = [number for number in fuel if np.hypot(*np.mean(bodies.shape(number).bounds, axis=0)[:2]) < 8 - 1.3]
    assert len(within) > 80
    assert len({int(bodies.kinds[number]) for number in within}) == 1


def test_copies_are_lowered_without_a_shape_for_each_place(tmp_path: Path, noted_calls) -> None:
    """A pin of 81 assemblies has 153 places along each axis. A few of its shapes show the effect of a shift."""
    bodies = co.load_openmc(geometry_file(core_xml(9), tmp_path), void=False).bodies
    assert isinstance(bodies, InstanceList)
    shapes = noted_calls(type(bodies), "shape_at")
    lower(bodies)
    assert len(bodies.shifts.values[0]) >= 153
    assert len(shapes) <= 12 * len(bodies.members)


def test_boxes_are_made_again_as_they_were(scene: co.Scene) -> None:
    expected = lower(scene.bodies).boxes.tobytes()
    scene.prepare()
    assert "boxes" not in vars(scene._prepared.lowered.bounds)
    assert scene._prepared.lowered.boxes.tobytes() == expected


def test_answers_are_those_of_bodies_written_out(path: Path, scene: co.Scene) -> None:
    """Answers are equal to the bit, but where walls slant: there another record may stand for equal planes."""
    other = co.Scene(written_out(scene))
    random = np.random.default_rng(3)
    low, high = (np.nan_to_num(end, posinf=40, neginf=-40) for end in scene.bounds)
    a, b = random.uniform(low, high, (2, 400, 3))
    rays = co.Rays(a, b - a)
    mine, its = scene.first_hit(rays), other.first_hit(rays)
    assert (mine.body == its.body).all()
    assert (mine.face == its.face).all()
    assert np.allclose(mine.t, its.t, rtol=1e-12 if model_name(path) in SLANTED else 0, atol=0)
    assert np.allclose(mine.uv, its.uv, atol=1e-9, equal_nan=True)
    spans, expected = scene.spans(rays), other.spans(rays)
    assert (spans.offsets == expected.offsets).all()
    assert (spans.body == expected.body).all()
    assert np.allclose(spans.t_enter, expected.t_enter, rtol=1e-12, atol=1e-12)
    assert (scene.body_at(a) == other.body_at(a)).all()


def test_every_point_is_in_the_cell_of_openmc_s_rules(path: Path, scene: co.Scene) -> None:
    evaluator = Evaluator(path)
    random = np.random.default_rng(5)
    low, high = (np.nan_to_num(end, posinf=3, neginf=-3) for end in scene.bounds)
    points = random.uniform(low, high, (3000, 3))
    for place, body in zip(evaluator.find(points), scene.body_at(points).tolist(), strict=True):
        assert same_place(place, scene.bodies[body].name if body >= 0 else None)


@pytest.mark.deep
def test_many_points_of_a_core_of_100000_pins_are_in_the_cells_of_openmc_s_rules(tmp_path: Path) -> None:
    path = geometry_file(core_xml(19), tmp_path)
    scene, evaluator = co.load_openmc(path), Evaluator(path)
    points = np.random.default_rng(5).uniform((-250, -250, -183), (250, 250, 183), (100_000, 3))
    found = scene.body_at(points)
    assert len(np.unique(found)) > 50_000
    for place, body in zip(evaluator.find(points), found.tolist(), strict=True):
        assert same_place(place, scene.bodies[body].name if body >= 0 else None)


def test_bodies_are_a_sequence(scene: co.Scene) -> None:
    bodies = scene.bodies
    every = list(bodies)
    assert len(bodies) == len(every) == scene.body_count
    assert every[-1] == scene[len(bodies) - 1]
    with pytest.raises(IndexError, match="takes a number from 0 to .*, got -1$"):
        bodies[-1]
    assert bodies[3:6] == tuple(every[3:6])
    names = [body.name for body in every]
    assert len(set(names)) == len(names)
    for number in (0, len(every) // 2, len(every) - 1):
        assert scene[names[number]] == every[number]
        assert isinstance(bodies, InstanceList)
        assert bodies.number(names[number] or "") == number
    with pytest.raises(KeyError, match="no body named .*cell 1 @ nowhere"):
        scene["cell 1 @ nowhere"]
    with pytest.raises(IndexError):
        bodies[len(bodies)]
    assert scene.materials == tuple(dict.fromkeys(body.material for body in every))
    hits = scene.first_hit(np.array([(0.11, 0.12, 99.0)]), (0.0, 0.01, -1.0))
    assert hits.name.tolist() == [names[hits.body[0]]]
    assert hits.material.tolist() == [every[hits.body[0]].material]


def test_scenes_are_pickled_and_changed(scene: co.Scene) -> None:
    again = pickle.loads(pickle.dumps(scene))
    assert again == scene
    assert isinstance(again.bodies, InstanceList)
    assert again.bodies[1].name == scene.bodies[1].name
    moved = scene.replace(0, co.Sphere(0.1, (0, 0, 50)))
    assert moved.bodies[0].shape == co.Sphere(0.1, (0, 0, 50))
    assert moved.bodies[0].name == scene.bodies[0].name
    assert moved.bodies[1:] == tuple(scene.bodies)[1:]
    assert scene.bodies[1].translate((1, 0, 0)).shape == scene.bodies[1].shape.translate((1, 0, 0))


@pytest.mark.parametrize("region", ["-1 (2 3 | -2 -3 7)", "-2 (1 3 | -1 -3 7)"])
def test_cells_that_name_a_surface_twice_are_lowered_once(region: str, tmp_path: Path) -> None:
    """A hundred cells are moved copies. All quadrics have one form, and faces are not written out for each."""
    text = "".join((
        BALL, '<surface id="2" type="z-cylinder" coeffs="0 0 0.2"/>',
        '<surface id="3" type="z-plane" coeffs="0.05"/>', '<surface id="7" type="z-plane" coeffs="0.2"/>',
        '<surface id="9" type="sphere" coeffs="0 0 0 30" boundary="vacuum"/>',
        f'<cell id="1" universe="1" material="1" region="{region}"/>',
        '<lattice id="4" dimension="5 5 4" pitch="1 1.1 1.2" lower_left="-2.5 -2.75 -2.4" universes="' + "1 " * 100 + '"/>',
        '<cell id="20" fill="4" region="-9"/>',
    ))  # fmt: skip
    path = geometry_file(f"<geometry>{text}</geometry>", tmp_path)
    scene = co.load_openmc(path)
    tables = scene._prepared.lowered.tables
    assert len(scene.bodies) == 100
    assert len(tables.quadric_forms) == 1
    assert len(tables.face_maps) < 100
