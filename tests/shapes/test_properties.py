"""Names and properties of materials: values, comparisons, refusals by name, files, pickles and answers."""

import copy
import dataclasses
import json
import math
import pickle
from fractions import Fraction

import jsonschema
import numpy as np
import pytest
from hypothesis import given, strategies as st

import conicoid as co
from conicoid.materials.material import Properties
from conicoid.materials.presets import CONSTRUCTORS

from ..formats.test_broken_files import VALIDATOR

ENERGIES = [0.03, 0.06, 0.1]
LEAD = co.metal(
    "slategray",
    name="lead",
    properties={
        "id": 82, "density": 11.35, "mu": np.array(ENERGIES) * 3, "table": [[0.03, 30.3], [0.06, 5.02]], "toxic": True,
        "isotopes": ["Pb206", "Pb207", "Pb208"], "fractions": {"Pb206": 0.241, "Pb207": 0.221, "Pb208": 0.524, "by": "atoms"},
        "melts": Fraction(60061, 100), "half life": math.inf, "note": "no: a [text] with \u00e9, \"quotes\" and 1e-9",
    },
)  # fmt: skip


def test_values_are_given_back():
    found = LEAD.properties
    assert LEAD.name == "lead"
    assert (found["id"], found["density"], found["toxic"], found["melts"]) == (82, 11.35, True, 600.61)
    assert [type(found[name]) for name in ("id", "density", "toxic")] == [int, float, bool]
    assert found["mu"].tolist() == [3 * energy for energy in ENERGIES]
    assert found["table"].shape == (2, 2)
    assert found["isotopes"] == ("Pb206", "Pb207", "Pb208")
    assert found["fractions"]["Pb208"] == 0.524
    assert "colour" not in found
    assert list(found)[:2] == ["id", "density"]


@pytest.mark.parametrize("name", CONSTRUCTORS)
def test_every_constructor_takes_them(name):
    plain, named = CONSTRUCTORS[name](), CONSTRUCTORS[name](name="it", properties={"density": 2})
    assert (plain.name, dict(plain.properties)) == (None, {})
    assert (named.name, dict(named.properties)) == ("it", {"density": 2})
    assert dataclasses.replace(named, name=None, properties={}) == plain


def test_they_never_change():
    values = {"mu": np.arange(3.0)}
    material = co.Material(properties=values)
    values["mu"][0], values["more"] = 9, 1
    assert material.properties["mu"].tolist() == [0, 1, 2]
    assert "more" not in material.properties
    with pytest.raises(ValueError, match="read-only"):
        material.properties["mu"][0] = 1
    with pytest.raises(TypeError):
        material.properties["mu"] = 1


def test_materials_are_compared_by_them():
    def lead(**changes):
        return dataclasses.replace(LEAD, properties={**LEAD.properties, **changes})

    assert lead() == LEAD
    assert hash(lead()) == hash(LEAD)
    assert lead(mu=[-0.0, 1]) == lead(mu=[0, 1])
    assert hash(lead(mu=[-0.0, 1])) == hash(lead(mu=[0, 1]))
    for change in ({"density": 11.34}, {"mu": ENERGIES}, {"more": 1}, {"fractions": {}}, {"isotopes": ["Pb206"]}):
        assert lead(**change) != LEAD
    assert dataclasses.replace(LEAD, name="Pb") != LEAD
    assert LEAD.properties == dict(LEAD.properties)
    assert len({LEAD, lead(), lead(density=1)}) == 2


@pytest.mark.parametrize(
    ("properties", "message"),
    [
        (7, "Material: properties must be a mapping from names to values, got int"),
        ({3: 1}, "Material: properties must have non-empty texts as names, got 3"),
        ({"": 1}, "Material: properties must have non-empty texts as names, got ''"),
        ({"mu": None}, r"Material: properties\['mu'\] must be a number, a text, .*, got None"),
        ({"mu": math.nan}, r"properties\['mu'\] must be a number .*not NaN"),
        ({"mu": [1, math.nan]}, r"properties\['mu'\] must not hold NaN"),
        ({"mu": 1j}, r"properties\['mu'\] must be a number, a text, .*, got complex"),
        ({"mu": [1, [2, 3]]}, r"properties\['mu'\] must be an array of numbers"),
        ({"mu": [1, "a"]}, r"properties\['mu'\] must be an array of numbers, or a list of texts"),
        ({"mu": np.zeros((2, 2, 2))}, r"properties\['mu'\] must have at most 2 dimensions, got shape \(2, 2, 2\)"),
        ({"mu": ""}, r"properties\['mu'\] must not be an empty text"),
        ({"mu": b"a"}, r"properties\['mu'\] must be .*, got bytes"),
        ({"mu": {1, 2}}, r"properties\['mu'\] must be .*, got set"),
        ({"id": 10**18}, r"properties\['id'\] must be an integer of at most 18 digits"),
        ({"x": {"y": {"z": 1}}}, r"properties\['x'\]\['y'\] must be a number or a text, got dict"),
        ({"x": {"y": [1]}}, r"properties\['x'\]\['y'\] must be a number or a text, got list"),
    ],
)  # fmt: skip
def test_others_are_refused_by_name(properties, message):
    with pytest.raises((TypeError, ValueError), match=message):
        co.Material(properties=properties)


@pytest.mark.parametrize(("call", "error", "message"), [
    *((lambda name=name: co.matte(name=name), ValueError, "Material: name must be a non-empty text or None") for name in ("", 3, b"lead")),
    (lambda: co.matte(properties={"density": 1}).properties["densty"], KeyError, "no property 'densty'; properties: 'density'"),
    (lambda: co.Painted(co.Box(), "red", (-1,)), ValueError, r"Painted: faces\[0\] must be an integer >= 0, got -1"),
    (lambda: co.Painted(co.Box(), "red", (0.5,)), ValueError, r"Painted: faces\[0\] must be an integer"),
    (lambda: co.Painted(co.Box(), "red", "red"), TypeError, "Painted: faces must be numbers of faces"),
    (lambda: co.Scene([co.Box().painted("red", (6,))]).first_hit((0, 0, 5), (0, 0, -1)), ValueError,
     "Painted: faces must be below 6, of its operand, got 6"),
])  # fmt: skip
def test_names_and_faces_to_paint_are_checked(call, error, message):
    with pytest.raises(error, match=message):
        call()


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_scene_files_keep_them(tmp_path, suffix):
    finite = dataclasses.replace(LEAD, properties={n: v for n, v in LEAD.properties.items() if n != "half life"})
    light = dataclasses.replace(finite, properties={**finite.properties, "density": 11.0})
    lead = LEAD if suffix == ".yaml" else finite
    scene = co.Scene(
        [
            co.Body(co.Sphere(), lead),
            co.Body(co.Box(), light),
            co.Sphere(0.5) - co.Box().painted(lead),
            co.Body(co.Sphere(2), "red"),
        ]
    )
    path = tmp_path / f"scene{suffix}"
    co.save(scene, path)
    again = co.load(path)
    assert again == scene
    assert again.bodies[0].material.properties["mu"].tolist() == LEAD.properties["mu"].tolist()
    assert again.bodies[1].material.properties["density"] == 11
    if suffix == ".json":
        written = json.loads(path.read_text(encoding="utf-8"))
        VALIDATOR.validate(written)
        assert list(written["materials"]) == ["lead", "lead (2)", "material A"]
        written["materials"]["lead"]["Material"]["properties"]["mu"] = None
        with pytest.raises(jsonschema.ValidationError):
            VALIDATOR.validate(written)


def test_files_are_refused_with_the_place(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text("materials:\n  lead: {matte: {properties: {mu: [1, [2]], id: 7}}}\nbodies: []\n")
    with pytest.raises(
        co.SceneFileError, match=r"scene.yaml:2:30: material \"lead\": matte: properties\['mu'\] must be an array"
    ):
        co.load(path)


keys = st.text(st.characters(exclude_categories=("Cs",)), min_size=1, max_size=6)
single = st.one_of(
    st.integers(-(10**17), 10**17), st.floats(allow_nan=False, allow_subnormal=False), st.booleans(), keys
)
lists = st.one_of(
    st.lists(st.floats(allow_nan=False)), st.lists(keys), st.lists(st.lists(st.floats(-9, 9), min_size=2, max_size=2))
)


@given(st.dictionaries(keys, st.one_of(single, lists, st.dictionaries(keys, single, max_size=3)), max_size=4))
def test_any_properties_survive_files_and_pickles(tmp_path_factory, properties):
    scene = co.Scene(co.Body(co.Sphere(), co.Material(properties=properties, name="x")))
    path = tmp_path_factory.getbasetemp() / "properties.yaml"
    co.save(scene, path)
    for again in (co.load(path), pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
        assert again == scene
        assert hash(again.bodies[0].material) == hash(scene.bodies[0].material)


def test_answers_give_the_material_back():
    scene = co.Scene(
        [co.Body(co.Spheres([(0, 0, 0), (4, 0, 0)], 1), LEAD), co.Body(co.Sphere(1, (0, 9, 0)), co.matte())]
    )
    hits = scene.first_hit([(0, 0, 5), (4, 0, 5), (9, 9, 9)], (0, 0, -1))
    for found in (hits, pickle.loads(pickle.dumps(hits))):
        assert [m and m.properties["density"] for m in found.material] == [11.35, 11.35, None]
    assert scene.body(1).material.name == "lead"


def test_long_arrays_are_abbreviated():
    long = Properties({"mu": np.arange(10_000.0)})
    assert repr(long) == "{'mu': <array of 10000 numbers>}"
    assert repr(Properties({"mu": [1, 2]})) == "{'mu': [1.0, 2.0]}"
    assert "9999.0" in long.exact_text


@pytest.mark.parametrize("count", [1, 5])
def test_single_faces_are_painted(count):
    """Each painted side of a box looks like a box of that color, alone and in Booleans."""
    colours = ["red", "lime", "blue", "yellow", "cyan", "magenta"]
    box, light = co.Box((-1, -1, -1), (1, 1, 1)), [co.AmbientLight(1.0)]
    directions = np.concatenate([np.eye(3), -np.eye(3)])
    faces = co.Scene([box]).first_hit(-3 * directions, directions).face.tolist()
    painted = box
    for face, colour in zip(faces, colours, strict=True):
        painted = painted.painted(colour, (face,))
    assert painted.painted("white") != painted == pickle.loads(pickle.dumps(painted))
    far = co.Sphere(1, (9, 9, 9))
    for shape in (painted, painted - far, far | painted, painted & co.Sphere(9)):
        scene = co.Scene([co.Body(shape.translate((40 * k, 0, 0)), "white") for k in range(count)], light)
        for direction, colour in zip(directions, colours, strict=True):
            up, at = (0, 0, 1) if direction[2] == 0 else (0, 1, 0), np.array([40 * (count - 1), 0, 0])
            painted_pixels, plain = (
                one.replace(camera=co.OrthographicCamera(at - 3 * direction, at, up=up, height=0.1)).render(1, 1).pixels
                for one in (scene, co.Scene([co.Body(box.translate(at), colour)], light))
            )
            assert painted_pixels.tolist() == plain.tolist(), (shape, direction)
