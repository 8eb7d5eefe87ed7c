"""Materials by index of many bodies in one entry: as if each body had its own."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import conicoid as co

RED, BLUE = co.matte("red", name="red"), co.matte("blue", name="blue")
PLACES = 3.0 * np.arange(6)[:, None] * (1, 0, 0)
INDEX = [1, 1, 0, 1, 2, 2]
ENTRIES = {
    "Spheres": co.Spheres(PLACES, 1),
    "Boxes": co.Boxes(PLACES - 1, PLACES + 1),
    "Discs": co.Discs(PLACES, (0, 0, 1), 1),
}


def scene(name: str) -> co.Scene:
    many = co.Body(ENTRIES[name], materials=[RED, "blue", None], material_index=INDEX, name="many")
    return co.Scene([co.Body(co.Sphere(1, (0, 9, 0)), BLUE), many, co.Sphere(1, (0, -9, 0))])


def apart(one: co.Scene) -> co.Scene:
    return co.Scene([co.Body(body.shape, body.material) for body in one])


@pytest.mark.parametrize("name", ENTRIES)
def test_each_body_has_its_own(name: str) -> None:
    one = scene(name)
    blue = co.matte("blue")
    assert [body.material for body in one] == [BLUE, blue, blue, RED, blue, None, None, None]
    assert one.materials == (BLUE, blue, RED, None)
    hits = one.first_hit(np.array([*(PLACES + (0, 0, 5)), (0, 9, 5)]), (0, 0, -1))
    assert hits.material.tolist() == [blue, blue, RED, blue, None, None, BLUE]
    assert hits.name.tolist() == ["many"] * 6 + [None]
    assert hits[2:4].detached().material.tolist() == [RED, blue]


@pytest.mark.parametrize("name", ENTRIES)
def test_pictures_are_those_of_the_bodies_apart(name: str) -> None:
    one = scene(name)
    camera = co.Camera((8, -20, 12), (7, 0, 0))
    pictures = [each.render(width=60, height=40, camera=camera).pixels for each in (one, apart(one))]
    assert np.array_equal(*pictures)
    assert len(np.unique(pictures[0].reshape(-1, 3), axis=0)) > 20
    if name == "Boxes":
        assert np.array_equal(*(each.section("z", 0.5).pixels for each in (one, apart(one))))


@pytest.mark.parametrize("count", [1, 30])
def test_values(count: int, tmp_path: Any) -> None:
    """Equality, pickles and scene files, inline and beside the scene."""
    shape = co.Spheres(np.tile(PLACES, (count, 1)), 1)
    body = co.Body(shape, materials=[RED, BLUE, None], material_index=np.tile(INDEX, count))
    other = co.Body(shape, materials=[RED, BLUE, None], material_index=np.tile(INDEX[::-1], count))
    assert body == pickle.loads(pickle.dumps(body)) != other
    assert hash(body) == hash(pickle.loads(pickle.dumps(body)))
    co.save(co.Scene([body, other]), tmp_path / "scene.yaml")
    assert co.load(tmp_path / "scene.yaml").bodies == (body, other)
    assert len(list(tmp_path.glob("scene-materials-*.npy"))) == (2 if count > 1 else 0)


def test_one_material_for_each_needs_no_index() -> None:
    body = co.Body(co.Spheres(PLACES[:2], 1), materials=["red", "blue"])
    assert [one.material for one in co.Scene([body])] == [co.matte("red"), co.matte("blue")]


@pytest.mark.parametrize(("make", "message"), [
    (lambda shape: co.Body(shape, materials=["red"], material_index=[0] * 5), r"material_index must have shape \(6,\)"),
    (lambda shape: co.Body(shape, materials=["red"], material_index=[0] * 5 + [1]), r"material_index\[5\] must be at least 0 and below 1, got 1"),
    (lambda shape: co.Body(shape, materials=["red"]), "materials must be as many as bodies .* got 1 materials for 6 bodies"),
    (lambda shape: co.Body(shape, "red", materials=["red"]), "material must be left out where materials are given"),
    (lambda shape: co.Body(shape, materials=["red", "blu"], material_index=INDEX), r"materials\[1\]: material must be .* got 'blu'"),
    (lambda shape: co.Body(shape, materials=["red"], material_index=[0.5] * 6), "material_index must be integers"),
    (lambda shape: co.Body(shape, material_index=[0] * 6), "material_index must be left out, or go with materials"),
])  # fmt: skip
def test_refusals(make: Any, message: str) -> None:
    with pytest.raises(ValueError, match=f"^Body: {message}"):
        make(ENTRIES["Boxes"])


def test_only_many_bodies_have_several() -> None:
    with pytest.raises(TypeError, match="materials are for many bodies in one entry"):
        co.Body(co.Sphere(), materials=["red"])
