"""The table of other programs' names, and suggestions in messages."""

from __future__ import annotations

import inspect
import re

import pytest

import conicoid as co
from conicoid._util import environment
from conicoid._util.text import ALIASES, NameTuple, check_choice, closest_name, known_alias, suggest_name

from .public_names import PUBLIC


def _public_words():
    """Names of everything public: functions and classes, their methods and fields, and arguments."""
    words = set(PUBLIC)
    for value in PUBLIC.values():
        for member in [value, *(getattr(value, name) for name in dir(value) if not name.startswith("_"))]:
            if callable(member):
                try:
                    words |= set(inspect.signature(member).parameters)
                except (TypeError, ValueError):  # of NumPy's types
                    continue
        if isinstance(value, type):
            words |= {name for name in dir(value) if not name.startswith("_")}
            words |= {name for base in value.__mro__ for name in getattr(base, "__annotations__", ())}
    return words


def test_aliases_are_of_public_names():
    words = _public_words()
    for alias, names in ALIASES.items():
        assert alias == alias.casefold()
        assert set(names.split()) <= words, alias


@pytest.mark.parametrize(
    ("name", "known", "meant"),
    [
        ("intersect", dir(co.Scene), "first_hit"),
        ("Path_Lengths", dir(co.Scene), "lengths"),
        ("bbox", dir(co.Sphere), "bounds"),
        ("distance", ["t_max", "radius"], "t_max"),
        ("radios", ["center", "radius"], "radius"),
        ("FOV", ["field_of_view"], "field_of_view"),
        ("quite other", ["center", "radius"], ""),
        ("x" * 10_000, ["center"], ""),
        ("center", [], ""),
    ],
)
def test_closest_name(name, known, meant):
    assert closest_name(name, known) == meant


def test_known_alias():
    assert known_alias("IOR", ["refractive_index"]) == "refractive_index"
    assert known_alias("ior", ["radius"]) == known_alias("radios", ["radius"]) == ""


def test_suggest_name():
    assert suggest_name("radios", ["center", "radius"]) == " (did you mean 'radius'?)"
    assert suggest_name("qqq", ["center", "radius"]) == " (known: center, radius)"
    assert suggest_name("qqq", [f"name {k}" for k in range(17)]) == ""


def test_check_choice():
    assert check_choice("f", "by", "body", ("body", "material")) == "body"
    with pytest.raises(
        ValueError, match=r"^f: by must be one of body, material, got 'bodie' \(did you mean 'body'\?\)$"
    ):
        check_choice("f", "by", "bodie", ("body", "material"))
    with pytest.raises(ValueError, match=r"^f: by must be one of body, material, got 3$"):
        check_choice("f", "by", 3, ("body", "material"))


SCENE = co.Scene([co.Body(co.Sphere(), co.matte("red", name="steel"), "ball"), co.Box((2, 2, 2), (3, 3, 3))])


@pytest.mark.parametrize(
    ("thing", "name", "meant"),
    [
        (SCENE, "intersect", "first_hit"),
        (SCENE, "first_hits", "first_hit"),
        (SCENE, "boddy", "body"),
        (SCENE, "aabb", "bounds"),
        (co.Sphere(), "bbox", "bounds"),
        (co.Sphere(), "radios", "radius"),
        (SCENE["ball"], "materiel", "material"),
        (SCENE.first_hit((0, 0, 5), (0, 0, -1)), "points", "point"),
        (SCENE.first_hit((0, 0, 5), (0, 0, -1)).rays, "origin", "origins"),
        (SCENE, "nonsense", ""),
        (co.Sphere(), "nonsense", ""),
        (SCENE["ball"], "_name", ""),
    ],
)
def test_unknown_attribute(thing, name, meant):
    hint = f": did you mean {meant}?" if meant else ""
    with pytest.raises(
        AttributeError, match=rf"^'{type(thing).__name__}' object has no attribute '{name}'{re.escape(hint)}$"
    ):
        getattr(thing, name)


def test_attribute_error_of_a_property(monkeypatch):
    def fails(scene):
        return scene.bodies[0].shape.nonsense

    monkeypatch.setattr(co.Scene, "_ready", fails)
    scene = co.Scene([co.Sphere()])
    for query in (lambda: scene._prepared, lambda: scene.first_hit((0, 0, 5), (0, 0, -1))):
        with pytest.raises(AttributeError, match=r"^'Sphere' object has no attribute 'nonsense'$"):
            query()


@pytest.mark.parametrize(("package", "name", "told"), [
    (co, "Ball", " (did you mean Sphere?)"), (co, "Halfspace", " (did you mean HalfSpace?)"), (co, "nonsense", ""),
    (co.materials, "Woood", " (did you mean Wood?)"), (co, "Fresnel", ": it is co.optics.Fresnel"),
])  # fmt: skip
def test_unknown_package_name(package, name, told):
    with pytest.raises(
        AttributeError, match=rf"^module '{package.__name__}' has no attribute '{name}'{re.escape(told)}$"
    ):
        getattr(package, name)


NAMED = co.Scene(
    [
        co.Body(co.Sphere(), co.matte("red", name=f"m{k}"), name)
        for k, name in enumerate(["barrel", "bung", "cell 5 'fuel' @ cell 9", "cell 5 'fuel' @ cell 10"])
    ]
)


@pytest.mark.parametrize(("name", "told"), [
    ("barel", r"named bodies: 'barrel', 'bung', .* \(did you mean 'barrel'\?\)$"),
    ("fuel", r"named bodies with it in their names: \"cell 5 'fuel' @ cell 9\", \"cell 5 'fuel' @ cell 10\"$"),
    ("Barrel", r"named bodies with it in their names: 'barrel'$"),
    ("quite other", r"named bodies: 'barrel', 'bung', [^(]*$"),
])  # fmt: skip
def test_scene_names_are_suggested(name, told):
    with pytest.raises(KeyError) as error:
        NAMED[name]
    assert re.search(told, error.value.args[0])


def test_material_names_are_suggested():
    with pytest.raises(ValueError, match=r"no material is called 'm'; materials with it in their names: 'm0', 'm1'"):
        NAMED.line_integral({"m": 1}, (0, 0, 9), (0, 0, -1), otherwise=0)
    with pytest.raises(KeyError, match="no material is called 'mm2'; materials: .*did you mean 'm2'"):
        co.measure(NAMED)["mm2"]


def test_property_names_are_suggested():
    lead = co.matte("gray", name="lead", properties={"density": 11.35, "mu": 1})
    scene = co.Scene(co.Body(co.Sphere(), lead))
    with pytest.raises(ValueError, match=r"no property 'densty' for material 'lead'; .* \(did you mean 'density'\?\)$"):
        scene.line_integral("densty", (0, 0, 9), (0, 0, -1))
    with pytest.raises(ValueError, match=r"no material has a property 'densty'; .* \(did you mean 'density'\?\)$"):
        scene.line_integral("densty", (0, 0, 9), (0, 0, -1), otherwise=0)


def test_describe_names_fits_on_a_screen():
    scene = co.Scene([co.Body(co.Sphere(0.1, (k, 0, 0)), co.matte("red", name=f"{k}" * 40)) for k in range(300)])
    with pytest.raises(ValueError, match="no material is called 'x'") as error:
        scene.line_integral({"x": 1}, (0, 0, 9), (0, 0, -1))
    assert len(str(error.value)) < 1200


def test_name_tuple_finds_items_by_name():
    items = NameTuple([co.matte(name="a"), None, co.matte(name="b"), co.glass(name="b")], "scene.materials")
    assert items["a"] == items[0] == co.matte(name="a")
    assert items.index("a") == 0
    assert items.index(None) == 1
    assert items[1:] == tuple(items)[1:]
    with pytest.raises(KeyError, match=r"scene.materials: 2 have the name 'b', at \[2, 3\]: use an index"):
        items["b"]
    with pytest.raises(KeyError, match="scene.materials: none has the name 'steal'"):
        items["steal"]


def test_unknown_environment_variables_are_warned_of_once(monkeypatch):
    environment.warn_of_unknown.cache_clear()
    monkeypatch.setenv("CONICOID_TREADS", "2")
    with pytest.warns(UserWarning, match="^CONICOID_TREADS is not a Conicoid variable: did you mean CONICOID_THREADS"):
        environment.read_threads()
    environment.read_threads()  # warnings are errors here
    environment.read_jit_mode()
    environment.warn_of_unknown.cache_clear()
