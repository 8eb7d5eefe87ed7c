"""What users of other packages write of scenes, their parts and their answers: each is told what there is here."""

from __future__ import annotations

import dataclasses
import pickle
import re

import numpy as np
import pytest

import conicoid as co
from conicoid._util.foreign_names import CLASS_METHOD_HINTS, SCENE_HINTS
from conicoid._util.hints import has_misplaced_arguments

STEEL = co.matte("red", name="steel", properties={"density": 7.8})
SCENE = co.Scene(
    [co.Body(co.Sphere(), STEEL, "ball"), co.Body(co.Box((2, 2, 2), (3, 3, 3)), "blue"), co.Body(co.Sphere(1, (9, 0, 0)), STEEL)],
    lights=co.PointLight((0, 0, 9)),
)  # fmt: skip
RAYS = co.Rays([(0, 0, 5), (50, 0, 5), (9, 0, 5)], (0, 0, -1))
HITS, SPANS = SCENE.first_hit(RAYS), SCENE.spans(RAYS)


def refused(call, kind=Exception):
    with pytest.raises(kind) as error:
        call()
    return str(error.value)


@pytest.mark.parametrize(("name", "told"), [
    ("first_hits", "first_hit("), ("ray_intersect", "first_hit("), ("visible", "occluded("), ("material_at", "scene.body_at(points)"),
    ("aabb", "it is called bounds"), ("write", "save(path)"), ("show", "scene.view()"), ("to_mesh", "triangles"),
    ("path_lengths", "lengths(rays)"), ("add_light", "replace(lights=[...])"), ("delete", "without(which)"), ("boddy", "did you mean body?"),
])  # fmt: skip
def test_scenes_tell_what_they_are_asked(name, told):
    assert told in refused(lambda: getattr(SCENE, name), AttributeError)


def test_no_hint_is_for_what_scenes_have():
    for name, hint in SCENE_HINTS.items():
        assert not hasattr(SCENE, name), name
        assert hint in refused(lambda name=name: getattr(SCENE, name), AttributeError), name
    for kind, names in CLASS_METHOD_HINTS.items():
        for name, hint in names.items():
            assert refused(lambda kind=kind, name=name: getattr(getattr(co, kind), name), AttributeError).endswith(hint)


@pytest.mark.parametrize(("ask", "told"), [
    (lambda: co.Fresnel, "co.refract has directions"), (lambda: co.Point3D, "vectors are three numbers"),
    (lambda: co.Subtract, r"did you mean Difference\?"), (lambda: co.Surface, "lenses are solids"), (lambda: co.World, "Scene"),
    (lambda: co.Detector, "shapes that they hit"), (lambda: co.rotate_x, "shape.rotate"), (lambda: co.project, "co.ct.project"),
    (lambda: co.ct.fan, r"did you mean fanflat\?"), (lambda: co.ct.iradon, "not reconstructed"), (lambda: co.ct.cones, r"mean cone\?"),
    (lambda: co.parallel.Client, "Dask's"), (lambda: co.parallel.Pool, r"mean Processes\?"),
    (lambda: co.ct.parallel([0], 3).rays, "co.Rays.from_scan"), (lambda: co.check(SCENE).ok, "`if not findings`"),
    (lambda: HITS.reflect, r"co\.reflect\(hits\.rays\.directions"), (lambda: HITS.bounce, r"hits\.spawn\(co\.reflect\("),
    (lambda: HITS.angle, "cosine"), (lambda: SPANS.by_material, r"lengths\(by='material'\)"),
    (lambda: SCENE["ball"].density, "a material has that"), (lambda: SCENE["ball"].replace, "dataclasses.replace"),
    (lambda: SCENE["ball"].number, r"scene\.bodies\.index"), (lambda: co.Sphere().replace, "dataclasses.replace"),
    (lambda: (co.Sphere() | co.Box()).center, "volume, area, centroid"), (lambda: STEEL.properties.density, r"properties\['density'\]"),
])  # fmt: skip
def test_names_of_other_packages(ask, told):
    assert re.search(told, refused(ask, AttributeError))


@pytest.mark.parametrize(("thing", "name", "told"), [
    (co.Sphere(), "radius", r"^Sphere: radius cannot be set, .*: dataclasses\.replace\(sphere, radius=\.\.\.\) is another$"),
    (co.Sphere() - co.Box(), "operands", "^Difference: operands cannot be set"),
    (co.Sphere(), "raduis", r"^Sphere: there is no field 'raduis' \(did you mean radius\?\), and fields never change"),
    (SCENE["ball"], "material", r"scene\.replace\(which, material=\.\.\.\) a scene with it$"),
    (SCENE["ball"], "shape", r"scene\.replace\(which, shape\)"), (STEEL, "color", r"dataclasses\.replace\(material, color"),
    (SCENE.lights[0], "intensity", r"scene\.replace\(lights=\.\.\.\)"), (co.Sky(), "zenith", r"scene\.replace\(background=\.\.\.\)"),
    (co.Camera((0, 0, 1), (0, 0, 0)), "position", r"scene\.replace\(camera=\.\.\.\)"), (co.Checker(), "a", r"dataclasses\.replace\(checker"),
    (co.measure(co.Sphere()), "volume", "^Measures: volume cannot be set: what was found does not change$"),
    (co.ct.parallel([0], 3), "rows", r"dataclasses\.replace\(scangeometry, rows=\.\.\.\)"),
])  # fmt: skip
def test_fields_that_are_set(thing, name, told):
    for change in (lambda: setattr(thing, name, 1), lambda: delattr(thing, name)):
        message = refused(change, dataclasses.FrozenInstanceError)
        assert re.search(told, message.replace("be deleted", "be set"))


def test_loaded_parts_tell_it_too(tmp_path):
    scene = SCENE.replace(background=co.Sky(), camera=co.OrthographicCamera((0, 0, 1), (0, 0, 0)))
    scene.save(tmp_path / "scene.yaml")
    loaded = co.load(tmp_path / "scene.yaml")
    parts = (loaded[0].shape, loaded[0], loaded.lights[0], loaded.camera, loaded.background, loaded.materials[0])
    for part in (*parts, *pickle.loads(pickle.dumps(parts))):
        field = dataclasses.fields(part)[-1].name
        assert "cannot be set, and fields never change" in refused(
            lambda part=part, field=field: setattr(part, field, 1)
        )


@pytest.mark.parametrize(("change", "told"), [
    (lambda: SCENE.__setitem__("ball", 1), "scene.replace(which, shape or Body)"), (lambda: SCENE.__delitem__(0), "scene.without(which)"),
    (lambda: SCENE.bodies.__setitem__(0, 1), "scene.replace(which, shape or Body)"), (lambda: SCENE.lights.append(1), "scene.replace(lights=[...])"),
    (lambda: SCENE.lights.__setitem__(0, 1), "scene.replace(lights=[...])"), (lambda: SCENE.materials.append(1), "material=...)"),
    (lambda: HITS.__setitem__(0, 1), "hits.t.copy()"), (lambda: RAYS.__setitem__(0, 1), "rays.origins.copy()"),
    (lambda: co.measure(SCENE).__setitem__(0, 1), "what was found"), (lambda: STEEL.properties.__setitem__("mu", 1), "**material.properties, 'mu': ..."),
    (lambda: SCENE + co.Sphere(), "scene.added(items)"), (lambda: co.Sphere() ^ co.Box(), "(a | b) - (a & b)"),
])  # fmt: skip
def test_items_that_are_set(change, told):
    assert told in refused(change, (TypeError, AttributeError))


def test_lights_are_joined_with_a_list():
    lit = SCENE.replace(lights=SCENE.lights + [co.PointLight((1, 1, 1))])
    assert len(lit.lights) == 2
    assert SCENE.lights == (co.PointLight((0, 0, 9)),)


def test_materials_by_name_and_not_by_body():
    assert SCENE.materials == (STEEL, co.matte("blue"))
    assert SCENE.materials["steel"] is SCENE.materials[0]
    assert SCENE.materials.index("steel") == 0
    assert SPANS.materials["steel"] == STEEL
    assert co.measure(SCENE).by_material["steel"].volume == pytest.approx(2 * 4 / 3 * np.pi)
    assert SCENE.materials[np.argmax([0, 1])] == co.matte("blue")
    assert "did you mean 'steel'?" in refused(lambda: SCENE.materials["steal"], KeyError)
    assert HITS.body.tolist() == [0, -1, 2]
    assert SCENE.materials[HITS.body[0]] == STEEL
    for place in (1, 2):
        assert "scene.body(number).material" in refused(
            lambda place=place: SCENE.materials[HITS.body[place]], IndexError
        )
    box = SCENE.body_at((2.5, 2.5, 2.5))
    assert SCENE.materials[box] == co.matte("blue")
    swapped = co.Scene([SCENE[0], SCENE[2], SCENE[1]])
    assert "counted differently" in refused(lambda: swapped.materials[box], IndexError)
    assert "hits.material" in refused(lambda: SCENE.materials[HITS.body], TypeError)
    again = pickle.loads(pickle.dumps((SCENE.materials, SCENE.lights)))
    assert again == (SCENE.materials, SCENE.lights)
    assert again[0]["steel"] == STEEL


@pytest.mark.parametrize("operation", [
    lambda h: h * 2, lambda h: 2 * h, lambda h: h + h, lambda h: h - 1, lambda h: -h, abs, lambda h: h / 2, lambda h: h**2,
    lambda h: h < 1, lambda h: h >= 1, sorted, min, sum,
])  # fmt: skip
@pytest.mark.parametrize("answer", [HITS, SPANS, RAYS], ids=["hits", "spans", "rays"])
def test_answers_are_no_numbers(operation, answer):
    if operation in (sorted, min, sum) and answer is RAYS:
        return  # which are then origins and directions
    assert "is no array of numbers: its fields are, such as" in refused(lambda: operation(answer), TypeError)
    assert "is no array of numbers" in refused(lambda: float(answer), TypeError)


def test_rays_and_hits_are_not_looped_over_at_once():
    for pairs in (lambda: list(zip(RAYS, HITS, strict=False)), lambda: list(zip(HITS, RAYS, strict=False)),
                  lambda: [one for _ in RAYS for one in SPANS], lambda: list(zip(RAYS, SCENE.crossings(RAYS), strict=False))):  # fmt: skip
        assert "has the ray of each as one.rays" in refused(pairs, TypeError)
    for hit in HITS:  # and unpacking is as it was, within a loop too
        origins, directions = hit.rays
        assert origins.shape == directions.shape == (3,)
    assert [part.shape for part in RAYS] == [(3, 3), (3, 3)]
    assert np.stack([*RAYS]).shape == (2, 3, 3)
    begun = iter(RAYS)
    next(begun)
    del begun
    assert len(list(HITS)) == 3


@pytest.mark.parametrize(("ask", "told"), [
    (lambda: HITS["ball"], "hits[hits.name == 'ball']"), (lambda: SPANS["ball"], "spans.t_enter[spans.name == 'ball']"),
    (lambda: SPANS[SPANS.body == 0], "a mask selects rays and must have 3 items, got one of 2 rows: spans.t_enter[mask]"),
])  # fmt: skip
def test_indices_of_answers(ask, told):
    assert told in refused(ask, IndexError)


def test_places_of_arguments():
    """Numbers where vectors are wanted, and the reverse; not what may be meant."""
    import inspect

    plane = inspect.signature(co.Plane).parameters
    assert has_misplaced_arguments(plane, [(0, 0, 0), (0, 0, 1)])
    assert has_misplaced_arguments(plane, [0, (0, 0, 1)])
    assert not has_misplaced_arguments(plane, [(0, 0, 0), 1])
    assert not has_misplaced_arguments(plane, [(0, 0), 1])
    assert not has_misplaced_arguments(plane, ["z", 1])
