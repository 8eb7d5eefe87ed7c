"""Messages: their length, their suggestions, and the names of other programs."""

import difflib
import inspect
import re

import numpy as np
import pytest

import conicoid as co
from conicoid._util import environment
from conicoid._util.text import ALIASES, NameTuple, closest_name

from . import messages
from .command_line import failure, run
from .public_names import PUBLIC

# --- Messages: nouns and numbers agree, and no message is longer than a screen


# --- Messages about things with thousands of parts name the first few and count the rest

MANY = 3000
LONG = "a long name " * 400


def _scene_of_many() -> co.Scene:
    return co.Scene([co.Body(co.Sphere(), name=f"{i} {LONG}") for i in range(MANY)])


@pytest.mark.parametrize("provoke", [
    lambda: _scene_of_many()["nobody"],
    lambda: _scene_of_many()[LONG],
    lambda: _scene_of_many()[10**4000],
    lambda: _scene_of_many().replace(LONG, co.Sphere()),
    lambda: co.Scene([co.Body(co.Sphere(), name=LONG)] * 2),
    lambda: co.Scene([LONG] * 9),
    lambda: co.Union([co.Sphere()] * MANY + [LONG]),
    lambda: co.Polygon(np.random.default_rng(0).random((MANY, 3))),
    lambda: co.Quadric(coefficients={f"{i}": 1.0 for i in range(MANY)}),
    lambda: co.Spheres(np.zeros((MANY, 2)), 1),
    lambda: co.Sphere(center=[0.1] * MANY),
    lambda: co.set_threads(10**400),
    lambda: co.set_threads(10**5000),
    lambda: co.set_threads(True),
    lambda: co.Image(np.zeros((3, 3)), colormap=LONG),
    lambda: co.Image(np.zeros((3, 3))).save(LONG),
    lambda: co.turntable(co.Sphere(), LONG),
    lambda: co.load(LONG),
    lambda: co.Hits.load(LONG),
    lambda: co.Scene([co.Sphere()]).spans((0, 0, 5), (0, 0, -1)).line_integral([1.0] * MANY),
    lambda: co.Scene([co.Sphere()]).first_hit(np.zeros((MANY, 2)), np.zeros((7, 3))),
    lambda: getattr(co, LONG),
])  # fmt: skip
def test_bad_input(provoke):
    """`conftest.py` measures the messages themselves."""
    with pytest.raises((ValueError, TypeError, LookupError, OSError, AttributeError)):
        provoke()


@pytest.mark.parametrize("content", [
    "bodies: [" + "{shape: {Spere: {}}}, " * MANY + "]",
    f"bodies: [{{shape: {{'{LONG}': {{}}}}}}]",
    f"bodies: [{{shape: '{LONG}'}}]\nshapes: {{{', '.join(f'shape {i}: {{Sphere: {{}}}}' for i in range(MANY))}}}",
    f"bodies: [{{shape: {{Sphere: {{radius: '{LONG}'}}}}}}]",
    f"bodies: [{{shape: {{Sphere: {{}}}}, material: '{LONG}'}}]",
    f"bodies: []\n'{LONG}': 3",
    "bodies: [" + f"{{shape: {{Sphere: {{radius: '{LONG}'}}}}, name: '{LONG}'}}, " * 50 + "]",
    "bodies: [" + "\x1b" * 5000 + "]",
    "[" * 3000,
])  # fmt: skip
def test_bad_scene_files(content, tmp_path):
    (tmp_path / "scene.yaml").write_text(content)
    message = failure("info", tmp_path / "scene.yaml")
    assert "scene.yaml" in message
    with pytest.raises(co.SceneFileError):
        co.load(tmp_path / "scene.yaml")


def test_bad_arguments_of_commands(tmp_path):
    (tmp_path / "scene.yaml").write_text("bodies: []")
    for arguments in (
        ("info", LONG), ("render", tmp_path / "scene.yaml", "-o", LONG), ("info", tmp_path / "scene.yaml", LONG),
        ("render", tmp_path / "scene.yaml", "-o", tmp_path / "x.png", "--integrator", LONG), (LONG,),
        ("render", tmp_path / "scene.yaml", "-o", tmp_path / "x.png", "--position", LONG),
        ("turntable", tmp_path / "scene.yaml", "-o", LONG), ("render", tmp_path / "scene.yaml", f"--{LONG}"),
        ("render", tmp_path / "scene.yaml", "-o", tmp_path / "x.png", "--width", LONG),
    ):  # fmt: skip
        result = run(*arguments)
        assert result.exit_code == 2, arguments
        assert messages.rows_of(result.stderr) <= messages.ROWS, (arguments[0], result.stderr[:3000])


# --- The table of other programs' names, and suggestions in messages


def _public_words():
    """Return names of everything public: functions and classes, their methods and fields, and arguments."""
    words = set(PUBLIC)
    for value in PUBLIC.values():
        for member in [value, *(getattr(value, name) for name in dir(value) if not name.startswith("_"))]:
            if callable(member):
                try:
                    words |= set(inspect.signature(member).parameters)
                except (TypeError, ValueError):  # types of NumPy
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
    ("name", "known", "suggestion"),
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
def test_closest_name(name, known, suggestion):
    assert closest_name(name, known) == suggestion


SCENE = co.Scene([co.Body(co.Sphere(), co.matte("red", name="steel"), "ball"), co.Box((2, 2, 2), (3, 3, 3))])


@pytest.mark.parametrize(
    ("instance", "name", "suggestion"),
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
def test_unknown_attribute(instance, name, suggestion):
    hint = f": did you mean {suggestion}?" if suggestion else ""
    with pytest.raises(
        AttributeError, match=rf"^'{type(instance).__name__}' object has no attribute '{name}'{re.escape(hint)}$"
    ):
        getattr(instance, name)


def test_names_are_compared_once_for_a_class(monkeypatch):
    """Bounds test each operand of a Boolean by `hasattr`, which took 80 µs an operand."""
    compared = []
    monkeypatch.setattr(difflib, "get_close_matches", lambda name, names, **_: compared.append(name) or [])
    assert not any(hasattr(co.Sphere(radius), "surely_unknown") for radius in (1, 2, 3))
    assert len(compared) == 1


def test_attribute_error_of_a_property(monkeypatch):

    monkeypatch.setattr(co.Scene, "_ready", lambda scene: scene.bodies[0].shape.nonsense)
    scene = co.Scene([co.Sphere()])
    for query in (lambda: scene._prepared, lambda: scene.first_hit((0, 0, 5), (0, 0, -1))):
        with pytest.raises(AttributeError, match=r"^'Sphere' object has no attribute 'nonsense'$"):
            query()


@pytest.mark.parametrize(("package", "name", "message"), [
    (co, "Ball", " (did you mean Sphere?)"), (co, "Halfspace", " (did you mean HalfSpace?)"), (co, "nonsense", ""),
    (co.materials, "Woood", " (did you mean Wood?)"), (co, "Fresnel", ": it is co.optics.Fresnel"),
    (co, "gold", ": it is co.materials.gold"), (co, "Slice", ": it is co.section.Slice"), (co, "Molecule", ": it is co.scene.Molecule"),
    (co, "trace_paths", ": it is co.optics.trace_paths"), (co.materials, "matte", ": it is co.matte"),
])  # fmt: skip
def test_unknown_package_name(package, name, message):
    with pytest.raises(
        AttributeError, match=rf"^module '{package.__name__}' has no attribute '{name}'{re.escape(message)}$"
    ):
        getattr(package, name)


NAMED = co.Scene(
    [
        co.Body(co.Sphere(), co.matte("red", name=f"m{k}"), name)
        for k, name in enumerate(["barrel", "bung", "cell 5 'fuel' @ cell 9", "cell 5 'fuel' @ cell 10"])
    ]
)


@pytest.mark.parametrize(("name", "message"), [
    ("barel", r"named bodies: 'barrel', 'bung', .* \(did you mean 'barrel'\?\)$"),
    ("fuel", r"named bodies with it in their names: \"cell 5 'fuel' @ cell 9\", \"cell 5 'fuel' @ cell 10\"$"),
    ("Barrel", r"named bodies with it in their names: 'barrel'$"),
    ("quite other", r"named bodies: 'barrel', 'bung', [^(]*$"),
])  # fmt: skip
def test_scene_names_are_suggested(name, message):
    with pytest.raises(KeyError) as error:
        NAMED[name]
    assert re.search(message, error.value.args[0])


def test_material_names_are_suggested():
    with pytest.raises(ValueError, match=r"no material is called 'm'; materials with it in their names: 'm0', 'm1'"):
        NAMED.line_integral({"m": 1}, (0, 0, 9), (0, 0, -1), otherwise=0)
    with pytest.raises(KeyError, match="no material and no body is called .*mm2.*did you mean .*m2"):
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
