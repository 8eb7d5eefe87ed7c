"""Calls and words that a new user tries: what does not fit is told in words of the field, with what was meant."""

from __future__ import annotations

import inspect
import re

import numpy as np
import pytest

import conicoid as co
from conicoid._util.foreign_names import MEASURE_FIELDS, SCENE_METHODS
from conicoid.scene.scene import QUERIES

from .public_names import PUBLIC

BALL = co.Sphere()
SCENE = co.Scene([co.Body(BALL, co.matte("red", name="steel"), "ball"), co.Box((2, 2, 2), (3, 3, 3))])
RAYS = co.Rays([(0, 0, 5), (0.1, 0, 5)], (0, 0, -1))


@pytest.mark.parametrize(("call", "told"), [
    (lambda: BALL.translate(1, 2, 3), r"translate\(\) takes 1 argument, got 3; .* brackets: translate\(\(1, 2, 3\)\)$"),
    (lambda: BALL.scale(1, 2, 3), r"scale\(\) takes 1 argument without a name, got 3; .*: scale\(\(1, 2, 3\)\)$"),
    (lambda: BALL.rotate(30), r"rotate\(\) missing degrees; call it as rotate\(axis, degrees, \*, about\)$"),
    (lambda: BALL.rotate("z", angle=30), r"has no argument 'angle' \(did you mean degrees\?\)"),
    (lambda: SCENE.render(size=(2, 2)), r"has no argument 'size' \(did you mean width and height\?\); call it as render\("),
    (lambda: SCENE.render(2, 2, widht=3), r"\(did you mean width\?\)"),
    (lambda: co.Camera((0, 0, 5), (0, 0, 0), fov=30), r"^Camera\(\) has no argument 'fov' \(did you mean field_of_view\?\)"),
    (lambda: co.glass(n=1.5), r"^glass\(\) has no argument 'n' \(did you mean refractive_index\?\)"),
    (lambda: co.matte(colour="red"), r"^matte\(\) .*\(did you mean color\?\)"),
    (lambda: co.Sphere(r=2), r"^Sphere\(\) .*\(did you mean radius\?\); call it as Sphere\(radius, center\)$"),
    (lambda: co.Cylinder(), r"^Cylinder\(\) missing start and end and radius; call it as Cylinder\(start, end, radius, "),
    (lambda: co.PointLight(pos=(1, 1, 1)), r"missing position; has no argument 'pos' \(did you mean position\?\)"),
    (lambda: co.Box(1, 2, 3, 4), r"^Box\(\) takes 2 arguments.*, got 4; call it as Box\(low, high\)$"),
    (lambda: co.Body(BALL, shape=BALL), r"^Body\(\) is given shape twice"),
    (lambda: co.measure(BALL, n=5), r"^measure\(\) has no argument 'n'; call it as measure\(shape, rays, seed, progress, \*, executor\)$"),
    (lambda: co.Rays([(0, 0, 1)]), r"^Rays\(\) missing directions; call it as Rays\(origins, directions\)$"),
])  # fmt: skip
def test_calls_that_do_not_fit_are_told_how(call, told):
    with pytest.raises(TypeError, match=told) as error:
        call()
    assert "positional" not in str(error.value)
    assert "unexpected" not in str(error.value)


def test_errors_from_within_stay_what_they_are():
    def fails(done, count):
        raise TypeError("mine")

    with pytest.raises(TypeError, match="^mine$"):
        SCENE.render(2, 2, progress=fails)
    with pytest.raises(TypeError, match="is a sheet"):
        _ = co.Disc((0, 0, 0), (0, 0, 1), 1) | BALL
    assert list(inspect.signature(co.Sphere).parameters) == ["radius", "center", "motion"]
    assert next(iter(inspect.signature(co.glass).parameters)) == "refractive_index"


@pytest.mark.parametrize("thing", [BALL, BALL - co.Box(), co.Body(BALL), co.Disc((0, 0, 0), (0, 0, 1), 1)])
def test_what_a_scene_is_asked_is_not_asked_of_a_shape(thing):
    kind = type(thing).__name__
    for name in SCENE_METHODS:
        with pytest.raises(
            AttributeError, match=rf"^'{kind}' object has no attribute '{name}': a scene has, co\.Scene\("
        ):
            getattr(thing, name)
    for name in MEASURE_FIELDS:
        with pytest.raises(
            AttributeError, match=rf"has no attribute '{name}': co\.measure\({kind.lower()}\)\.{name} is"
        ):
            getattr(thing, name)
        assert hasattr(co.measure(co.Sphere()), name)
    with pytest.raises(AttributeError, match=f"^'{kind}' object has no attribute 'radios'$"):
        _ = thing.radios


def test_the_list_of_what_scenes_are_asked_is_whole():
    assert set(QUERIES) <= set(SCENE_METHODS) <= {name for name in dir(co.Scene) if not name.startswith("_")}


@pytest.mark.parametrize(("call", "told"), [
    (lambda: co.Polyhedron([(0, 0, 1)], [1, 2]), "Polyhedron: offsets must be a list of 1 number, got 2:"),
    (lambda: co.Polyhedron([(0, 0, 1)], 2), "Polyhedron: offsets must be a list of 1 number, got the number 2$"),
    (lambda: BALL.rotate("w", 30), "rotate: axis must be 3 numbers, or 'x', 'y', 'z', '-x', '-y', '-z', got 'w'$"),
    (lambda: BALL.scale("2"), "scale: factors must be one number or 3 numbers, got '2'$"),
    (lambda: co.refract(np.ones((4, 3)), np.ones((4, 3)), np.ones(3)), r"refract: eta must be a number or broadcast to the "
     r"rays' shape \(4,\), got shape \(3,\)$"),
    (lambda: co.refract(np.ones((4, 3)), np.ones((5, 3)), 1.5), r"refract: directions and normals must .* \(4, 3\) and \(5, 3\)$"),
    (lambda: SCENE.spans(RAYS, t_min="a"), "^spans: t_min must be a number"),
    (lambda: SCENE.crossings(RAYS, t_max=np.nan), "^crossings: t_max must not be NaN"),
    (lambda: SCENE.lengths(RAYS, t_max=[1, 2, 3]), "^lengths: t_max must be a number or broadcast"),
    (lambda: SCENE.line_integral([1, 1], RAYS, t_max=[1, 2, 3]), "^line_integral: t_max must be a number or broadcast"),
    (lambda: SCENE.render(2, 2, integrator="whited"), r"got 'whited' \(did you mean 'whitted'\?\)$"),
    (lambda: SCENE.lengths(RAYS, by="materials"), r"got 'materials' \(did you mean 'material'\?\)$"),
    (lambda: co.Image(np.eye(2), colormap="grayy"), r"got 'grayy' \(did you mean 'grey'\?\)$"),
    (lambda: co.Body(BALL, "#3366c"), r"got '#3366c' \(5 digits after #: there must be 6, or 3 as in '#rgb'\)$"),
    (lambda: co.matte("#gg0000"), r"got '#gg0000' \('g' is no hexadecimal digit\)$"),
    (lambda: co.matte("bleu"), r"got 'bleu' \(did you mean 'blue'\?\)$"),
])  # fmt: skip
def test_wording(call, told):
    with pytest.raises(ValueError, match=told):
        call()


@pytest.mark.parametrize("query", sorted({"first_hit", "occluded", "spans", "crossings", "lengths", "line_integral"}))
def test_questions_begin_with_their_names(query):
    values = ([1, 1],) if query == "line_integral" else ()
    ask = getattr(SCENE, query)
    for arguments in (((0, 0, 1),), (RAYS, (0, 0, 1)), (SCENE,)):
        with pytest.raises(TypeError, match=f"^{query}: "):
            ask(*values, *arguments)


@pytest.mark.parametrize(("index", "told"), [
    (1.0, "Scene: index must be a name, a body's number or a slice of numbers, got 1.0$"),
    (True, "Scene: index must be a name, .* got True$"), (None, "Scene: index must be a name, .* got None$"),
])  # fmt: skip
def test_scenes_say_what_an_index_is(index, told):
    with pytest.raises(TypeError, match=told):
        SCENE[index]
    with pytest.raises(TypeError, match="replace: which must be the name of an entry or the number of its body, got"):
        SCENE.replace(index, co.Box())
    with pytest.raises(
        TypeError, match="body: number must be one integer, got 'ball'; scene.name. is the entry of a name"
    ):
        SCENE.body("ball")
    with pytest.raises(IndexError, match="replace: which number must be at least 0 and below 2, got 7$"):
        SCENE.replace(7, co.Box())


_NOT_FOR_USERS = re.compile(r".*_under|unbounded_support|placed")


def _public():
    """Name and callable of all that a user calls: functions, classes, and their methods."""
    for name, value in PUBLIC.items():
        if not callable(value):
            continue
        if not issubclass(value, co.Hits | co.Spans | co.Crossings | Exception) if isinstance(value, type) else True:
            yield name, value
        for method in dir(value) if isinstance(value, type) else ():
            found = inspect.getattr_static(value, method)
            found = getattr(found, "__func__", found)
            if inspect.isfunction(found) and not method.startswith("_") and not _NOT_FOR_USERS.fullmatch(method):
                yield f"{name}.{method}", found


@pytest.mark.parametrize(("name", "function"), {f: (n, f) for n, f in _public() if "conicoid" in f.__module__}.values())
def test_docstrings_name_every_argument(name, function):
    said = inspect.getdoc(function) or ""
    arguments = [one for one in inspect.signature(function).parameters if one not in ("self", "cls", "motion")]
    assert [one for one in arguments if not re.search(rf"\b{re.escape(one)}\b", said)] == [], name


@pytest.mark.parametrize(("call", "told"), [
    (lambda: co.Sphere((0, 0, 0), 10), r"radius must be a number, got \(0, 0, 0\); call it as Sphere\(radius, center\)$"),
    (lambda: co.Plane((0, 0, 0), (0, 0, 1)), r"call it as Plane\(normal, offset, one_sided\); through a point p its offset is normal·p$"),
    (lambda: co.Plane((0, 0, 1), (0, 0, 1)), r"^Plane: offset must be a number, .*; call it as Plane\("),
    (lambda: co.Disc((0, 0, 0), 1, (0, 0, 1)), r"call it as Disc\(center, normal, radius\)$"),
    (lambda: co.Cylinder((0, 0, 0), 1, (0, 0, 1)), r"end is start \+ height \* axis$"),
    (lambda: co.Cylinder((0, 0, 0), (0, 0, 1), 1, 2), r"of two radii it is a Cone\(start, end, start_radius, end_radius\)$"),
    (lambda: co.Box(0, 1), r"call it as Box\(low, high\)$"), (lambda: co.Camera((0, 0, 5), (0, 0, 0), 40), "field_of_view=40$"),
    (lambda: BALL.rotate(30, "z"), r"call it as rotate\(axis, degrees, \*, about\)$"),
    (lambda: co.Body("lead", BALL), r"call it as Body\(shape, material, name, "),
    (lambda: co.Body(co.Spheres([(0, 0, 0)], 1), ["red", "blue"]), r"Body\(shape, materials=\[\.\.\.\]\)"),
])  # fmt: skip
def test_arguments_in_the_places_of_others(call, told):
    with pytest.raises((TypeError, ValueError), match=told):
        call()


def test_places_are_not_told_where_they_are_right():
    for call in (
        lambda: co.Sphere(-1),
        lambda: co.Plane((0, 0, 0), 1),
        lambda: BALL.translate(1),
        lambda: co.Sphere("1"),
    ):
        with pytest.raises(ValueError, match="must") as error:
            call()
        assert "call it as" not in str(error.value)


@pytest.mark.parametrize(("call", "told"), [
    (lambda: co.Box(xmin=0, xmax=1), r"'xmin' \(did you mean low and high\?\)"), (lambda: co.Cone(apex=(0, 0, 0), angle=3), r"'angle' \(did you mean start_radius"),
    (lambda: co.Cylinder(center=(0, 0, 0), radius=1), r"'center' \(did you mean start and end\?\)"),
    (lambda: co.Ellipsoid(semi_axes=(1, 2, 3)), r"mean radii\?"), (lambda: co.Ellipsoid.from_coefficients(a=1), r"missing A and E and H"),
    (lambda: co.Plane(point=(0, 0, 0), normal=(0, 0, 1)), r"mean offset \(normal·point\)\?"), (lambda: co.Plane(z=0), r"mean normal and offset\?"),
    (lambda: co.Spheres(positions=[]), r"mean centers\?"), (lambda: BALL.translate(x=1), r"mean offset \(a vector, \(x, y, z\)\)\?"),
    (lambda: co.Camera((0, 0, 1), (0, 0, 0), aspect=2), r"pictures have that, scene\.render"),
    (lambda: co.Body(BALL, density=2), "a material has that"), (lambda: co.Rays((0, 0, 0), (0, 0, 1), t_max=1), "intervals go with the question"),
    (lambda: SCENE.first_hit(RAYS, max_distance=1), r"mean t_max\?"), (lambda: SCENE.first_hit(o=(0, 0, 0), d=(0, 0, 1)), r"'d' \(did you mean directions\?\)"),
    (lambda: SCENE.first_hit(RAYS).spawn((0, 0, 1), epsilon=1), "no small distance is needed"), (lambda: SCENE.first_hit(RAYS).spawn((0, 0, 1), 1), "no small"),
    (lambda: SCENE.render(fov=3), r"mean camera \(its field_of_view\)\?"), (lambda: SCENE.moved((1, 0, 0)), r"call it as moved\(which, motion\)$"),
    (lambda: co.OrthographicCamera((0, 0, 1), (0, 0, 0), scale=3), r"mean height \(of the window\)\?"), (lambda: SCENE.replace(bodies=[]), r"scene\.added"),
    (lambda: co.ct.fanflat([0], 3, sod=1, sdd=2), r"mean source_origin\?.*mean origin_detector \(sdd - source_origin\)\?"),
    (lambda: co.ct.parallel([0], 3, 0.5), r"call it as parallel\(angles, columns, \*, spacing, offset\)$"), (lambda: co.ct.cone([0], 3, det_width=1), r"mean spacing\?"),
    (lambda: SCENE.lengths(RAYS, "material"), r"lengths\(rays, by='material'\)$"), (lambda: SCENE.first_hit(tuple(RAYS)), r"first_hit\(\*pair\)$"),
    (lambda: SCENE.first_hit(np.zeros((2, 6))), r"first_hit\(a\[\.\.\., :3\], a\[\.\.\., 3:\]\)$"), (lambda: co.Rays.from_camera(SCENE.camera, 4, 3), r"scene\.fitting_camera\(\)"),
    (lambda: co.Scene("scene.yaml"), r"co\.load\(path\)"), (lambda: co.check("scene.yaml"), r"co\.load\(path\)"), (lambda: co.measure("scene.yaml"), r"co\.load"),
    (lambda: co.check([BALL]), r"co\.Scene\(\[\.\.\.\]\) is one of several"),
    (lambda: co.ct.project(SCENE, [0, 1], "mu"), r"co\.ct\.parallel\(angles, columns\)"),
])  # fmt: skip
def test_what_other_packages_call_it(call, told):
    with pytest.raises(TypeError, match=told):
        call()


def test_a_name_is_no_place_among_the_entries():
    with pytest.raises(KeyError, match="before says what the items come before; a material is their own"):
        SCENE.added(BALL, "red")
